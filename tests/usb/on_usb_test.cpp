// The driver by libusb against an emulated board by FunctionFS, with a kernel between them. Needs
// root and a device controller: run by tests/usb/virtual_machine.
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/core/device_file.h"
#include "device/core/phantom/kinematics.h"
#include "device/usb/driver/board_port.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/driver/usb_device.h"
#include "device/usb/emulator/emulated_board.h"
#include "device/usb/emulator/gadget.h"
#include "tests/support/devices.h"
#include "tests/support/emulated_port.h"
#include "tests/support/real_time_watch.h"
#include "tests/usb/both_ends.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace springdrive::usb_test {
namespace {

using device::Arrival;
using device::DeviceHealth;
using device::Measurement;
using emulator::BoardClock;
using usb::Pacing;
using usb::UsbDevice;
using namespace std::chrono_literals;

/// The device of both ends: phantom_1_0.toml, in the current folder.
device::DeviceDescription described() { return device::read_device_file("phantom_1_0.toml"); }

/// What the emulator's command line holds.
struct EmulatorWish {
    std::string serial = "EMU-1";
    emulator::BoardClock clock = emulator::BoardClock::frame;
    double delay_periods = 0.3;
    double loop_hz = 40'000.0;
    double hand_N_per_m = 300.0;
};

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

constexpr std::string_view kAsked = "--emulate";

int emulate(const EmulatorWish &wish) {
    emulator::EmulatedBoard board(described(), board_options(wish));
    emulator::GadgetOptions options;
    options.serial = wish.serial;
    options.name = wish.serial;
    emulator::Gadget gadget(board, options);
    run_by_orders(gadget);
    return 0;
}

/// An emulated board as a USB device of this machine, in a process of its own.
class EmulatorProcess : public GadgetProcess {
public:
    explicit EmulatorProcess(const EmulatorWish &wish = {})
        : GadgetProcess({"emulator", std::string(kAsked), wish.serial,
                         wish.clock == BoardClock::frame ? "frame" : "wall",
                         std::to_string(wish.delay_periods), std::to_string(wish.loop_hz),
                         std::to_string(wish.hand_N_per_m)}) {}
};

/// The whole of the process, if these are its arguments; for `main`.
/// @return its exit status, or −1 if they are not
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

/// From the environment, so that one program serves quick and long runs.
int count_of(const char *name, int otherwise) {
    const char *const text = std::getenv(name);
    return text != nullptr ? std::atoi(text) : otherwise;
}

/// What is plugged in takes some time to be there.
void wait_until(const std::function<bool()> &is_so, double limit_s = 10.0) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
    while (!is_so() && std::chrono::steady_clock::now() < end) {
        std::this_thread::sleep_for(20ms);
    }
    ASSERT_TRUE(is_so());
}

bool is_present(const std::string &serial) {
    return std::ranges::any_of(usb::boards_present(), [&](const usb::FoundBoard &board) {
        return board.serial == serial && board.problem.empty();
    });
}

std::unique_ptr<UsbDevice> opened(const EmulatorWish &wish, double period_s, Pacing pacing) {
    wait_until([&] { return is_present(wish.serial); });
    return std::make_unique<UsbDevice>(usb::make_libusb_port(), described(), wish.serial, period_s,
                                       pacing);
}

Vector3 start_rad() {
    const device::PhantomGeometry &geometry = described().geometry;
    return device::motor_from_joint(
        geometry, device::joint_angles_rad(geometry, testing::kOffCentre_m).value());
}

/// Pulls from the place of the start to 0.2 rad beyond it: (10) without a filter.
class Hold {
public:
    explicit Hold(const device::DeviceDescription &device)
        : rad_per_count_(device.rad_per_count()) {}

    device::DeviceCommand operator()(const Measurement &measured) const {
        device::DeviceCommand command;
        command.number = measured.number;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const double theta_rad = rad_per_count_ * measured.counts[static_cast<std::size_t>(j)];
            command.e_W_V[j] = std::clamp(-4.0 * (theta_rad - start_rad_[j] - 0.2), -3.0, 3.0);
        }
        command.cancelled_resistance_Ohm = Vector3::Constant(1.2);
        return command;
    }

private:
    double rad_per_count_;
    Vector3 start_rad_ = start_rad();
};

/// By the frame clock, nothing hangs on the link: the same as in process, to the last bit.
TEST(OnUsb, IsTheSameAsInProcessToTheLastBit) {
    const EmulatorWish wish;
    constexpr std::size_t kTicks = 500;
    constexpr double kSettling_s = 2.0;
    const auto run = [](UsbDevice &device) {
        device.zero(start_rad());
        const Hold hold(device.description());
        std::vector<Measurement> all;
        for (std::size_t i = 0; i < kTicks; ++i) {
            all.push_back(device.read());
            device.write(hold(all.back()));
        }
        return all;
    };
    // Both rest in the hand before they are connected.
    emulator::EmulatedBoard board(described(), board_options(wish));
    auto *const port = new testing::EmulatedPort(board);
    port->pass(kSettling_s);
    UsbDevice in_process(std::unique_ptr<usb::BoardPort>(port), described(), "", 1e-3,
                         Pacing::reports);
    const std::vector<Measurement> expected = run(in_process);
    const EmulatorProcess emulator(wish);
    std::this_thread::sleep_for(std::chrono::duration<double>(kSettling_s));
    const auto device = opened(wish, 1e-3, Pacing::reports);
    const std::vector<Measurement> measured = run(*device);
    double largest_A = 0.0;
    for (std::size_t i = 0; i < kTicks; ++i) {
        const Measurement &here = measured[i];
        const Measurement &there = expected[i];
        ASSERT_EQ(here.arrival, Arrival::fresh) << i;
        ASSERT_EQ(here.number - measured[0].number, there.number - expected[0].number) << i;
        ASSERT_NEAR(here.time_s - measured[0].time_s, there.time_s - expected[0].time_s, 1e-9) << i;
        ASSERT_EQ(here.counts, there.counts) << i;
        ASSERT_EQ(here.current_A, there.current_A) << i;
        largest_A = std::max(largest_A, here.current_A.cwiseAbs().maxCoeff());
    }
    EXPECT_GT(largest_A, 0.01); // it did drive
    EXPECT_NEAR(device->delay_periods(), wish.delay_periods, 0.03);
}

TEST(OnUsb, LosesNothingAsFastAsItGoes) {
    EmulatorWish wish;
    wish.loop_hz = 4000.0; // few loops: the link is measured, not the emulated motors
    const int ticks = count_of("SPRINGDRIVE_USB_FRAMES", 20'000);
    double rate_hz = 0.0;
    {
        const EmulatorProcess emulator(wish);
        const auto device = opened(wish, 1e-3, Pacing::reports);
        const std::uint64_t first = device->read().number;
        std::uint64_t number = first;
        device->write(device::DeviceCommand::braking());
        const auto begin = std::chrono::steady_clock::now();
        for (int i = 1; i <= ticks; ++i) {
            const Measurement measured = device->read();
            ASSERT_EQ(measured.arrival, Arrival::fresh) << i;
            ASSERT_EQ(measured.number, ++number) << i;
            device::DeviceCommand command = device::DeviceCommand::braking();
            command.number = measured.number;
            device->write(command);
        }
        rate_hz =
            ticks / std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        const device::LinkStatus link = *device->link();
        EXPECT_EQ(link.lost + link.late + link.absent + link.repeated + link.stale + link.corrupt +
                      link.unsent + link.rejected,
                  0U);
        EXPECT_NEAR(static_cast<double>(link.reports), ticks, 100.0); // and those of connecting
    }
    Echo echo;
    emulator::GadgetOptions options;
    options.serial = "ECHO-1";
    options.name = options.serial;
    options.takes_out = Echo::takes_out;
    emulator::Gadget gadget(echo, options);
    std::atomic<bool> must_end{false};
    gadget.plug_in();
    std::thread thread([&] { gadget.run([&] { return must_end.load(); }); });
    wait_until([] { return is_present("ECHO-1"); });
    libusb_context *context = nullptr;
    ASSERT_EQ(libusb_init(&context), 0);
    const EchoFigures figures = measure_echo(context, "ECHO-1", 5000);
    libusb_exit(context);
    must_end = true;
    gadget.wake();
    thread.join();
    std::printf("%d ticks at %.0f Hz, %.2f times the rate of a bare echo, synchronous (%.0f Hz)\n",
                ticks, rate_hz, rate_hz / figures.synchronous.rate_hz, figures.synchronous.rate_hz);
}

TEST(OnUsb, KeepsTheServosRateByTheClock) {
    for (const double servo_hz : {250.0, 1000.0}) {
        EmulatorWish wish;
        wish.clock = BoardClock::wall;
        wish.loop_hz = 4000.0;
        const EmulatorProcess emulator(wish);
        const auto device = opened(wish, 1.0 / servo_hz, Pacing::clock);
        const int ticks = count_of("SPRINGDRIVE_USB_CLOCKED_TICKS", 2000);
        std::uint64_t news = 0;
        std::uint64_t last = 0;
        auto next = std::chrono::steady_clock::now();
        for (int i = 0; i < ticks; ++i) {
            next += std::chrono::nanoseconds(std::llround(1e9 / servo_hz));
            std::this_thread::sleep_until(next);
            const Measurement measured = device->read();
            ASSERT_GE(measured.number, last) << i;
            last = measured.number;
            news += device::is_new(measured.arrival) ? 1U : 0U;
            device::DeviceCommand command = device::DeviceCommand::braking();
            command.number = measured.number;
            device->write(command);
        }
        const device::LinkStatus link = *device->link();
        std::printf("%.0f Hz: %d ticks, news in %.2f %%; lost %llu, late %llu, absent %llu; d %.2f "
                    "periods, round trip %.0f us, at most %.0f us\n",
                    servo_hz, ticks, 100.0 * static_cast<double>(news) / ticks,
                    static_cast<unsigned long long>(link.lost),
                    static_cast<unsigned long long>(link.late),
                    static_cast<unsigned long long>(link.absent), device->delay_periods(),
                    1e6 * link.round_trip_s, 1e6 * link.longest_round_trip_s);
        EXPECT_EQ(link.lost + link.corrupt + link.stale + link.repeated + link.rejected, 0U);
        EXPECT_GE(static_cast<double>(news), 0.9 * ticks);
    }
}

/// One unplug while it drives, and touch again.
void unplug_and_back(const EmulatorProcess &emulator, UsbDevice &device, double after_s) {
    const Hold hold(device.description());
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    while (seconds() < after_s) {
        const Measurement measured = device.read();
        ASSERT_EQ(measured.health, DeviceHealth::ok);
        device.write(hold(measured));
    }
    std::thread puller([&] { emulator.unplug(); });
    const double pulled_s = seconds();
    Measurement last = device.read();
    while (last.health == DeviceHealth::ok && seconds() < pulled_s + 2.0) {
        device.write(hold(last));
        last = device.read();
    }
    puller.join();
    ASSERT_EQ(last.health, DeviceHealth::lost);
    device.write(hold(last)); // goes nowhere, and harms nothing
    emulator.plug_in();
    const double plugged_s = seconds();
    std::string error;
    do {
        std::this_thread::sleep_for(20ms);
        error = error_text_of([&] { device.reconnect(); });
    } while (!error.empty() && seconds() < plugged_s + 10.0);
    ASSERT_EQ(error, "");
    Measurement measured = device.read();
    ASSERT_EQ(measured.health, DeviceHealth::ok);
    ASSERT_TRUE(device.is_zeroed()); // the board had power all the time
    // It braked by itself, and does so until a reset.
    ASSERT_TRUE(measured.faults.has(device::BoardFaults::kNoCommand));
    device::DeviceCommand reset = device::DeviceCommand::braking();
    reset.resets_faults = true;
    for (int i = 0; i < 20 && measured.faults.any(); ++i) {
        device.write(reset);
        measured = device.read();
    }
    ASSERT_FALSE(measured.faults.any());
}

TEST(OnUsb, ComesBackAfterAnUnplugAtAnyTime) {
    EmulatorWish wish;
    wish.loop_hz = 8000.0;
    const EmulatorProcess emulator(wish);
    const auto device = opened(wish, 1e-3, Pacing::reports);
    device->zero(start_rad());
    std::mt19937_64 random(19);
    std::uniform_real_distribution<double> after_s(0.0, 0.1);
    const int times = count_of("SPRINGDRIVE_USB_UNPLUGS", 5);
    for (int i = 0; i < times && !HasFatalFailure(); ++i) {
        SCOPED_TRACE(i);
        unplug_and_back(emulator, *device, after_s(random));
    }
}

TEST(OnUsb, SurvivesAnEmulatorThatIsKilled) {
    EmulatorWish wish;
    std::unique_ptr<UsbDevice> device;
    {
        EmulatorProcess emulator(wish);
        device = opened(wish, 1e-3, Pacing::reports);
        device->zero(start_rad());
        for (int i = 0; i < 50; ++i) {
            static_cast<void>(device->read());
            device->write(device::DeviceCommand::braking());
        }
        emulator.kill();
        wait_until([&] { return device->read().health == DeviceHealth::lost; });
    }
    const EmulatorProcess another(wish);
    wait_until([&] { return error_text_of([&] { device->reconnect(); }).empty(); });
    EXPECT_EQ(device->read().health, DeviceHealth::ok);
    EXPECT_FALSE(device->is_zeroed()); // it is another board, with the same number
}

TEST(OnUsb, SaysInOneLineWhyABoardCannotBeUsed) {
    const auto error = [](const std::string &serial) {
        return error_text_of([&] {
            const UsbDevice device(usb::make_libusb_port(), described(), serial, 1e-3,
                                   Pacing::reports);
        });
    };
    wait_until([] { return usb::boards_present().empty(); });
    EXPECT_NE(error("").find("no USB board is connected"), std::string::npos);
    EmulatorWish wish;
    const EmulatorProcess emulator(wish);
    wait_until([&] { return is_present(wish.serial); });
    EXPECT_NE(error("other").find("EMU-1"), std::string::npos);
    const auto device = opened(wish, 1e-3, Pacing::reports);
    EXPECT_NE(error("").find("another program uses it"), std::string::npos) << error("");
    EXPECT_EQ(device->read().health, DeviceHealth::ok); // which goes on
}

#ifdef SPRINGDRIVE_WATCHES_HEAP
/// The thread of the driver's port, with a kernel's USB: libusb allocates on it with each transfer,
/// where no other thread does.
TEST(HeapOnUsb, ThePortsThreadAllocatesWhereNoOtherDoes) {
    const EmulatorWish wish;
    const EmulatorProcess emulator(wish);
    testing::watch_heaps();
    ASSERT_TRUE(reserve_heaps());
    std::thread([] { static_cast<void>(std::make_unique<std::string>(100, ' ')); }).join();
    std::unique_ptr<usb::UsbDevice> device;
    for (int attempt = 0; !device && attempt < 500; ++attempt) { // it takes a moment to be there
        try {
            device = std::make_unique<usb::UsbDevice>(usb::make_libusb_port(), described(),
                                                      wish.serial, 1e-3, usb::Pacing::reports);
        } catch (const InputError &) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }
    ASSERT_TRUE(device);
    for (int tick = 0; tick < 500; ++tick) {
        static_cast<void>(device->read());
        device->write(device::DeviceCommand::braking());
        static_cast<void>(std::make_unique<std::string>(100, ' '));
    }
    EXPECT_EQ(testing::watched().allocating_threads, 1);
    EXPECT_EQ(testing::watched().shared_allocations, 0);
}
#endif

} // namespace
} // namespace springdrive::usb_test

int main(int argc, char **argv) {
    if (const int status = springdrive::usb_test::emulate_if_asked(argc, argv); status >= 0) {
        return status;
    }
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
