// Start-up of an image for QEMU's mps2-an386, a Cortex-M4: vectors, memory, floating-point unit,
// and semihosting for text and the exit status. A real board replaces this file and image.ld.
#include "device/usb/board/arm/semihosting.h"

#include <cstdint>
#include <string.h>

int main();

// Of image.ld.
extern "C" std::uint32_t image_stack_top;
extern "C" std::uint32_t image_data_source;
extern "C" std::uint32_t image_data_start;
extern "C" std::uint32_t image_data_end;
extern "C" std::uint32_t image_bss_start;
extern "C" std::uint32_t image_bss_end;

namespace {

std::size_t bytes_between(const std::uint32_t &start, const std::uint32_t &end) {
    return reinterpret_cast<std::uintptr_t>(&end) - reinterpret_cast<std::uintptr_t>(&start);
}

[[noreturn]] void fail() {
    springdrive::semihosting::write("processor fault\n");
    springdrive::semihosting::exit(2);
}

[[noreturn]] void start_up() {
    auto &coprocessor_access = *reinterpret_cast<volatile std::uint32_t *>(0xe000ed88U);
    coprocessor_access = coprocessor_access | (0xfU << 20U); // floating-point unit
    asm volatile("dsb\n isb");
    memcpy(&image_data_start, &image_data_source, bytes_between(image_data_start, image_data_end));
    memset(&image_bss_start, 0, bytes_between(image_bss_start, image_bss_end));
    springdrive::semihosting::exit(main());
}

} // namespace

using Vector = void (*)();
struct Vectors {
    std::uint32_t *stack_top;
    Vector handler[15];
};
extern "C" [[gnu::section(".vectors"), gnu::used]] const Vectors image_vectors{
    &image_stack_top,
    {start_up, fail, fail, fail, fail, fail, fail, fail, fail, fail, fail, fail, fail, fail, fail}};
