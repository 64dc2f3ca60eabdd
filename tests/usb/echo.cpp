// Both ends of a USB on one machine: a gadget that echoes, in a process of its own, and a plain
// libusb host. Measures the bare echo, then plugs, resets and kills. As root, with dummy_hcd, as in
// tests/usb/virtual_machine:
//
//   echo [--round-trips N] [--cycles N] [--kills N] [--full-speed]
#include "base/input_error.h"
#include "device/usb/emulator/gadget.h"
#include "tests/usb/both_ends.h"

#include <array>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fmt/core.h>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

namespace springdrive::usb_test {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr const char *kSerial = "ECHO-1";
constexpr const char *kName = "springdrive-echo";

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The gadget's process; at its end it says how often it was attached.
int run_gadget(bool is_high_speed) {
    Echo echo;
    emulator::GadgetOptions options;
    options.serial = kSerial;
    options.product = "springdrive echo";
    options.name = kName;
    options.is_high_speed = is_high_speed;
    options.takes_out = Echo::takes_out;
    std::optional<emulator::Gadget> gadget(std::in_place, echo, options);
    run_by_orders(*gadget);
    const std::uint64_t refused_too_late = gadget->refused_too_late();
    gadget.reset();
    fmt::print("attached {} times at {} speed, detached {} times; {} requests refused too late\n",
               echo.attachments(), echo.is_high_speed() ? "high" : "full", echo.detachments(),
               refused_too_late);
    return 0;
}

/// The arguments of the process that `run_gadget` is.
std::vector<std::string> gadget_arguments(bool is_high_speed) {
    return {"echo", "--gadget", is_high_speed ? "high" : "full"};
}

struct EndContext {
    void operator()(libusb_context *context) const { libusb_exit(context); }
};
using Context = std::unique_ptr<libusb_context, EndContext>;

Context new_context() {
    libusb_context *context = nullptr;
    if (const int error = libusb_init(&context); error != 0) {
        throw HostError("libusb_init", error);
    }
    return Context(context);
}

/// A host that has found the device. Without udevd, only a new context sees a new device.
struct Host {
    Context context;
    std::unique_ptr<HostDevice> device;

    Host() {
        constexpr double kTimeLimit_s = 10.0;
        const Clock::time_point begin = Clock::now();
        for (;;) {
            context = new_context();
            try {
                device = std::make_unique<HostDevice>(context.get(), kSerial);
                return;
            } catch (const HostError &) {
                if (seconds_since(begin) > kTimeLimit_s) {
                    throw;
                }
            }
            std::this_thread::sleep_for(20ms);
        }
    }
    [[nodiscard]] libusb_device_handle *handle() const { return device->handle(); }
    void echo(std::size_t round_trips) const {
        detail::echo_synchronously(*device, round_trips);
        detail::AsynchronousEcho(context.get(), *device, 4).run(round_trips);
    }
};

void check(bool is_true, const std::string &what) {
    if (!is_true) {
        throw HostError(what);
    }
}

void print_figures(const EchoFigures &figures) {
    fmt::print("{:>12} {:>10} {:>8} {:>8} {:>8}\n", "64 bytes", "rate, 1/s", "p50, us", "p99, us",
               "max, us");
    const auto row = [](const char *name, const EchoRun &run) {
        fmt::print("{:>12} {:10.0f} {:8.0f} {:8.0f} {:8.0f}\n", name, run.rate_hz, run.median_us,
                   run.p99_us, run.greatest_us);
    };
    row("synchronous", figures.synchronous);
    row("one", figures.asynchronous);
    row("four", figures.four_in_flight);
}

void check_control_requests(const Host &host) {
    constexpr std::uint8_t kUnknown = 0x7f;
    const auto transfer = [&](std::uint8_t type, std::uint8_t request, std::uint16_t value,
                              std::span<std::uint8_t> data) {
        return libusb_control_transfer(host.handle(), type, request, value, 0, data.data(),
                                       static_cast<std::uint16_t>(data.size()),
                                       detail::kTimeLimit_ms);
    };
    std::vector<double> times_us;
    for (std::size_t size = 1; size <= Echo::kMaxPayload; ++size) {
        std::vector<std::uint8_t> sent(size, static_cast<std::uint8_t>(size));
        std::vector<std::uint8_t> read(100);
        const auto block = static_cast<std::uint16_t>(size % Echo::kBlocks);
        const Clock::time_point begin = Clock::now();
        check(transfer(usb::kRequestOut, Echo::kRequest, block, sent) == static_cast<int>(size),
              "a control request to the device");
        const int size_read = transfer(usb::kRequestIn, Echo::kRequest, block, read);
        times_us.push_back(1e6 * seconds_since(begin));
        check(size_read == static_cast<int>(size), "a control request for data of " +
                                                       std::to_string(size) + ": " +
                                                       std::to_string(size_read));
        read.resize(size);
        check(read == sent, "data of control requests");

        // Stalled ones, each before ones that are not.
        const std::array<std::pair<const char *, int>, 5> stalled{{
            {"unknown, in", transfer(usb::kRequestIn, kUnknown, 0, read)},
            {"unknown, out", transfer(usb::kRequestOut, kUnknown, 0, read)},
            {"no such block", transfer(usb::kRequestIn, Echo::kRequest, Echo::kBlocks, read)},
            {"without data", transfer(usb::kRequestOut, kUnknown, 0, {})},
            {"to the device", transfer(0x40, Echo::kRequest, 0, {})},
        }};
        for (const auto &[name, result] : stalled) {
            check(result == LIBUSB_ERROR_PIPE,
                  std::string("should be stalled: ") + name + ", is " + std::to_string(result));
        }
    }
    check(transfer(usb::kRequestOut, Echo::kRequest, 0, {}) == 0, "a request without data");
    std::ranges::sort(times_us);
    fmt::print("control requests: out and in {:.0f} us, refused ones are stalled\n",
               times_us[times_us.size() / 2]);
}

/// A host that gives up half-way.
void check_cancelled_requests(const Host &host) {
    constexpr int kTimes = 50;
    constexpr std::uint16_t kSize = 64;
    std::array<unsigned char, LIBUSB_CONTROL_SETUP_SIZE + kSize> data{};
    int cancelled = 0;
    for (int i = 0; i < kTimes; ++i) {
        const std::uint8_t type = i % 2 == 0 ? usb::kRequestOut : usb::kRequestIn;
        libusb_transfer *transfer = libusb_alloc_transfer(0);
        int has_ended = 0;
        libusb_fill_control_setup(data.data(), type, Echo::kRequest, 0, 0, kSize);
        libusb_fill_control_transfer(
            transfer, host.handle(), data.data(),
            [](libusb_transfer *ended) { *static_cast<int *>(ended->user_data) = 1; }, &has_ended,
            detail::kTimeLimit_ms);
        check(libusb_submit_transfer(transfer) == 0, "a request to be cancelled");
        std::this_thread::sleep_for(i * 10us);
        libusb_cancel_transfer(transfer);
        while (has_ended == 0) {
            libusb_handle_events_completed(host.context.get(), &has_ended);
        }
        cancelled += transfer->status == LIBUSB_TRANSFER_CANCELLED ? 1 : 0;
        libusb_free_transfer(transfer);
    }
    host.echo(20);
    fmt::print("{} of {} control requests cancelled half-way\n", cancelled, kTimes);
}

/// The host configures the device again, and resets it.
void check_resets(const Host &host) {
    constexpr int kTimes = 10;
    for (int i = 0; i < kTimes; ++i) {
        libusb_release_interface(host.handle(), 0);
        check(libusb_set_configuration(host.handle(), 1) == 0, "configuring again");
        check(libusb_claim_interface(host.handle(), 0) == 0, "claiming again");
        host.echo(20);
    }
    const Clock::time_point begin = Clock::now();
    for (int i = 0; i < kTimes; ++i) {
        const int error = libusb_reset_device(host.handle());
        check(error == 0, std::string("resetting: ") + libusb_error_name(error));
        host.echo(20);
    }
    fmt::print("configured again and reset, {} times each; a reset with 40 echoes {:.0f} ms\n",
               kTimes, 1e3 * seconds_since(begin) / kTimes);
}

/// What a host's pending transfer ends with, and after how long.
class PendingRead {
public:
    explicit PendingRead(const Host &host) : context_(host.context.get()) {
        libusb_fill_interrupt_transfer(transfer_, host.handle(), host.device->in(), packet_.data(),
                                       static_cast<int>(packet_.size()), ended, this, 0);
        check(libusb_submit_transfer(transfer_) == 0, "a pending read");
    }
    PendingRead(const PendingRead &) = delete;
    PendingRead &operator=(const PendingRead &) = delete;
    ~PendingRead() { libusb_free_transfer(transfer_); }

    libusb_transfer_status wait() {
        const Clock::time_point begin = Clock::now();
        while (has_ended_ == 0) {
            check(seconds_since(begin) < 5.0, "a read outlasts its device");
            timeval limit{.tv_sec = 0, .tv_usec = 100'000};
            libusb_handle_events_timeout_completed(context_, &limit, &has_ended_);
        }
        return transfer_->status;
    }

private:
    static void ended(libusb_transfer *transfer) {
        static_cast<PendingRead *>(transfer->user_data)->has_ended_ = 1;
    }
    libusb_context *context_;
    libusb_transfer *transfer_ = libusb_alloc_transfer(0);
    usb::Frame packet_{};
    int has_ended_ = 0;
};

void check_plugging(const GadgetProcess &gadget, int cycles) {
    {
        const Host host;
        PendingRead read(host);
        const Clock::time_point begin = Clock::now();
        gadget.unplug();
        const int status = read.wait();
        fmt::print("unplugged: a pending read ends after {:.1f} ms with status {}\n",
                   1e3 * seconds_since(begin), status);
        check(status == LIBUSB_TRANSFER_NO_DEVICE || status == LIBUSB_TRANSFER_ERROR,
              "a read survives the unplugging");
    }
    Clock::time_point begin = Clock::now();
    gadget.plug_in();
    Host().echo(20);
    fmt::print("plugged in again: echoes after {:.0f} ms\n", 1e3 * seconds_since(begin));

    begin = Clock::now();
    for (int i = 0; i < cycles; ++i) {
        gadget.unplug();
        gadget.plug_in();
    }
    const double duration_s = seconds_since(begin);
    Host().echo(20);
    fmt::print("{} times unplugged and plugged in within {:.2f} s; echoes {:.0f} ms later\n",
               cycles, duration_s, 1e3 * (seconds_since(begin) - duration_s));

    // Now as quickly as the host can follow, with echoes each time.
    begin = Clock::now();
    for (int i = 0; i < cycles; ++i) {
        gadget.unplug();
        gadget.plug_in();
        Host().echo(5);
    }
    fmt::print("{} times with echoes each time, {:.0f} ms each\n", cycles,
               1e3 * seconds_since(begin) / cycles);
}

void check_kills(std::optional<GadgetProcess> &gadget, bool is_high_speed, int kills) {
    double longest_start_s = 0.0;
    for (int i = 0; i < kills; ++i) {
        {
            const Host host;
            host.echo(5);
            PendingRead read(host);
            gadget->kill();
            read.wait();
        }
        const Clock::time_point begin = Clock::now();
        gadget.emplace(gadget_arguments(is_high_speed));
        longest_start_s = std::max(longest_start_s, seconds_since(begin));
        Host().echo(20);
    }
    fmt::print("{} times killed and started under the same name, within {:.0f} ms\n", kills,
               1e3 * longest_start_s);
}

/// What is wrong with how the gadget is started is said in one line.
void check_errors() {
    const auto refuse = [](const std::function<void(emulator::GadgetOptions &)> &change) {
        emulator::GadgetOptions options;
        change(options);
        Echo echo;
        try {
            emulator::Gadget gadget(echo, options);
            gadget.plug_in();
        } catch (const InputError &error) {
            fmt::print("  {}\n", error.what());
            return;
        }
        throw HostError("a gadget should not have started");
    };
    fmt::print("refused:\n");
    refuse([](auto &options) { options.name = kName; });
    refuse([](auto &options) { options.name = "../x"; });
    refuse([](auto &options) { options.controller = "none.0"; });
    refuse([](auto &options) { options.name = "second"; });
    refuse([](auto &options) { options.serial = ""; });
}

std::size_t gadgets_in_configfs() {
    const std::filesystem::directory_iterator folder("/sys/kernel/config/usb_gadget");
    return static_cast<std::size_t>(std::distance(begin(folder), end(folder)));
}

struct Options {
    std::size_t round_trips = 2000;
    int cycles = 50;
    int kills = 5;
    bool is_high_speed = true;
};

int run_host(const Options &options) {
    const Clock::time_point begin = Clock::now();
    std::optional<GadgetProcess> gadget(gadget_arguments(options.is_high_speed));
    {
        const Host host;
        fmt::print("found after {:.0f} ms, at {} speed\n", 1e3 * seconds_since(begin),
                   host.device->is_high_speed() ? "high" : "full");
        check(host.device->is_high_speed() == options.is_high_speed, "the device's speed");
    }
    print_figures(measure_echo(new_context().get(), kSerial, options.round_trips));
    {
        const Host host;
        check_control_requests(host);
        check_cancelled_requests(host);
        check_control_requests(host);
        check_resets(host);
    }
    check_plugging(*gadget, options.cycles);
    check_errors();
    fmt::print("{}\n", gadget->end());
    check(gadgets_in_configfs() == 0, "gadgets are left in configfs");
    gadget.emplace(gadget_arguments(options.is_high_speed));
    check_kills(gadget, options.is_high_speed, options.kills);
    gadget->end();
    check(gadgets_in_configfs() == 0, "gadgets are left in configfs");
    fmt::print("all as it should be, in {:.1f} s\n", seconds_since(begin));
    return 0;
}

int run(std::span<char *const> arguments) {
    Options options;
    for (std::size_t i = 1; i < arguments.size(); ++i) {
        const std::string_view name = arguments[i];
        const auto value = [&] {
            check(i + 1 < arguments.size(), std::string(name) + " needs a value");
            return std::stoi(arguments[++i]);
        };
        if (name == "--gadget") {
            return run_gadget(i + 1 < arguments.size() &&
                              std::string_view(arguments[i + 1]) == "high");
        }
        if (name == "--round-trips") {
            options.round_trips = static_cast<std::size_t>(value());
        } else if (name == "--cycles") {
            options.cycles = value();
        } else if (name == "--kills") {
            options.kills = value();
        } else if (name == "--full-speed") {
            options.is_high_speed = false;
        } else {
            throw HostError("unknown option " + std::string(name));
        }
    }
    return run_host(options);
}

} // namespace

} // namespace springdrive::usb_test

int main(int count, char **arguments) {
    try {
        return springdrive::usb_test::run(std::span(arguments, static_cast<std::size_t>(count)));
    } catch (const std::exception &error) {
        fmt::print(stderr, "echo: {}\n", error.what());
        return 1;
    }
}
