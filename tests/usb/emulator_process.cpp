#include "tests/usb/emulator_process.h"

#include "device/core/device_file.h"
#include "device/usb/emulator/gadget.h"
#include "tests/support/devices.h"

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace springdrive::usb_test {

namespace {

constexpr std::string_view kAsked = "--emulate";

int emulate(const EmulatorWish &wish) {
    emulator::EmulatedBoard board(described(), board_options(wish));
    emulator::GadgetOptions options;
    options.serial = wish.serial;
    options.name = wish.serial;
    emulator::Gadget gadget(board, options);
    std::atomic<bool> must_end{false};
    const auto is_done = [] {
        [[maybe_unused]] const ssize_t size = write(STDOUT_FILENO, "done\n", 5);
    };
    gadget.plug_in();
    std::thread orders([&] {
        for (char order = 0; read(STDIN_FILENO, &order, 1) == 1;) {
            order == 'u' ? gadget.unplug() : gadget.plug_in();
            is_done();
        }
        must_end = true;
        gadget.wake();
    });
    is_done();
    gadget.run([&] { return must_end.load(); });
    orders.join();
    return 0;
}

} // namespace

device::DeviceDescription described() { return device::read_device_file("phantom_1_0.toml"); }

emulator::EmulatedBoardOptions board_options(const EmulatorWish &wish) {
    emulator::EmulatedBoardOptions options;
    options.identity = emulator::emulated_identity(wish.serial);
    options.settings.loop_rate_hz = static_cast<std::uint32_t>(std::lround(wish.loop_hz));
    options.start_tip_m = testing::kOffCentre_m;
    options.simulation.hand.stiffness_N_per_m = wish.hand_N_per_m;
    options.clock = wish.clock;
    options.delay_periods = wish.delay_periods;
    return options;
}

EmulatorProcess::EmulatorProcess(const EmulatorWish &wish) {
    std::array<int, 2> orders{};
    std::array<int, 2> answers{};
    if (pipe(orders.data()) != 0 || pipe(answers.data()) != 0) {
        throw std::runtime_error("no pipes");
    }
    const std::string clock = wish.clock == emulator::BoardClock::frame ? "frame" : "wall";
    const std::string delay = std::to_string(wish.delay_periods);
    const std::string loop = std::to_string(wish.loop_hz);
    const std::string hand = std::to_string(wish.hand_N_per_m);
    process_ = fork();
    if (process_ == 0) {
        dup2(orders[0], STDIN_FILENO);
        dup2(answers[1], STDOUT_FILENO);
        for (const int file : {orders[0], orders[1], answers[0], answers[1]}) {
            close(file);
        }
        execl("/proc/self/exe", "emulator", kAsked.data(), wish.serial.c_str(), clock.c_str(),
              delay.c_str(), loop.c_str(), hand.c_str(), nullptr);
        _exit(127);
    }
    close(orders[0]);
    close(answers[1]);
    orders_ = orders[1];
    answers_ = answers[0];
    if (answer() != "done") {
        throw std::runtime_error("the emulator did not start");
    }
}

EmulatorProcess::~EmulatorProcess() {
    if (process_ > 0) {
        close(orders_);
        waitpid(process_, nullptr, 0);
        close(answers_);
    }
}

void EmulatorProcess::kill() {
    ::kill(process_, SIGKILL);
    waitpid(std::exchange(process_, -1), nullptr, 0);
    close(orders_);
    close(answers_);
}

void EmulatorProcess::order(char letter) const {
    if (write(orders_, &letter, 1) != 1 || answer() != "done") {
        throw std::runtime_error("the emulator has ended");
    }
}

std::string EmulatorProcess::answer() const {
    std::string line;
    for (char letter = 0; read(answers_, &letter, 1) == 1 && letter != '\n';) {
        line += letter;
    }
    return line;
}

int emulate_if_asked(int argc, char **argv) {
    if (argc != 7 || argv[1] != kAsked) {
        return -1;
    }
    signal(SIGPIPE, SIG_IGN);
    try {
        return emulate({argv[2],
                        argv[3] == std::string_view("frame") ? emulator::BoardClock::frame
                                                             : emulator::BoardClock::wall,
                        std::stod(argv[4]), std::stod(argv[5]), std::stod(argv[6])});
    } catch (const std::exception &error) {
        std::fprintf(stderr, "emulator: %s\n", error.what());
        return 1;
    }
}

} // namespace springdrive::usb_test
