// Semihosting: text to the debugger or emulator, and the end of the program.
#pragma once

#include <cstdint>

namespace springdrive::semihosting {

inline std::uint32_t call(std::uint32_t operation, std::uintptr_t argument) {
    register std::uint32_t r0 asm("r0") = operation;
    register std::uintptr_t r1 asm("r1") = argument;
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

inline void write(const char *text) {
    constexpr std::uint32_t kWrite0 = 0x04;
    call(kWrite0, reinterpret_cast<std::uintptr_t>(text));
}

inline void write(std::uint32_t number) {
    char digits[11] = {};
    char *digit = digits + 10;
    do {
        *--digit = static_cast<char>('0' + number % 10U);
        number /= 10U;
    } while (number != 0);
    write(digit);
}

[[noreturn]] inline void exit(int status) {
    constexpr std::uint32_t kExitExtended = 0x20;
    constexpr std::uint32_t kApplicationExit = 0x20026;
    const std::uint32_t block[2] = {kApplicationExit, static_cast<std::uint32_t>(status)};
    for (;;) {
        call(kExitExtended, reinterpret_cast<std::uintptr_t>(block));
    }
}

} // namespace springdrive::semihosting
