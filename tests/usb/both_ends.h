// Both ends of a USB on one machine: a gadget in a process of its own, and a plain libusb host. Of
// the link alone: an echo instead of a board, and how long a packet takes there and back. Times on
// an emulated machine are the emulation's; those of a board are given in relation to these,
// measured in the same run.
#pragma once

#include "device/usb/emulator/gadget.h"
#include "device/usb/emulator/peripheral.h"
#include "device/usb/protocol.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <libusb.h>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <sys/types.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace springdrive::usb_test {

/// Sends every packet back; of control requests, it keeps one payload for each wValue below
/// kBlocks, and refuses all others.
class Echo : public emulator::Peripheral {
public:
    static constexpr std::uint8_t kRequest = 0x22;
    static constexpr std::uint16_t kBlocks = 4;
    static constexpr std::size_t kMaxPayload = 64;

    void put(std::span<const std::uint8_t> packet) override {
        if (packets_.size() < kMaxQueue) {
            packets_.emplace_back(packet.begin(), packet.end());
        }
    }
    std::size_t take(usb::Frame &packet) override {
        if (packets_.empty()) {
            return 0;
        }
        const std::vector<std::uint8_t> next = std::move(packets_.front());
        packets_.pop_front();
        std::ranges::copy(next, packet.begin());
        return next.size();
    }
    bool control_out(std::uint8_t request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override {
        if (!takes_out(request, value, payload.size())) {
            return false;
        }
        payload_[value].assign(payload.begin(), payload.end());
        return true;
    }
    std::size_t control_in(std::uint8_t request, std::uint16_t value,
                           std::span<std::uint8_t> payload) override {
        if (!takes_out(request, value, 0)) {
            return 0;
        }
        std::ranges::copy(payload_[value], payload.begin());
        return payload_[value].size();
    }
    void attach(bool is_high_speed) override {
        is_high_speed_ = is_high_speed;
        ++attachments_;
        packets_.clear();
    }
    void detach() override { ++detachments_; }
    double pass(double /*elapsed_s*/) override { return 5e-3; }

    /// For GadgetOptions.
    [[nodiscard]] static bool takes_out(std::uint8_t request, std::uint16_t value,
                                        std::size_t size) {
        return request == kRequest && value < kBlocks && size <= kMaxPayload;
    }
    [[nodiscard]] bool is_high_speed() const { return is_high_speed_; }
    [[nodiscard]] int attachments() const { return attachments_; }
    [[nodiscard]] int detachments() const { return detachments_; }

private:
    static constexpr std::size_t kMaxQueue = 64;
    std::deque<std::vector<std::uint8_t>> packets_;
    std::array<std::vector<std::uint8_t>, kBlocks> payload_;
    bool is_high_speed_ = false;
    int attachments_ = 0;
    int detachments_ = 0;
};

/// Of packets that were all echoed, in order and unchanged.
struct EchoRun {
    std::size_t round_trips = 0;
    double rate_hz = 0.0;
    double median_us = 0.0;
    double p99_us = 0.0;
    double greatest_us = 0.0;
};

struct EchoFigures {
    EchoRun synchronous;  ///< libusb_interrupt_transfer
    EchoRun asynchronous; ///< libusb_submit_transfer, one packet at a time
    EchoRun four_in_flight;
};

/// What the host has found wrong.
class HostError : public std::runtime_error {
public:
    HostError(const std::string &what, int error)
        : std::runtime_error(what + ": " + libusb_error_name(error)) {}
    explicit HostError(const std::string &what) : std::runtime_error(what) {}
};

/// Plugs the gadget in, then obeys one letter of standard input after the other, u to unplug and p
/// to plug in, and answers each with a line, until the end of input.
inline void run_by_orders(emulator::Gadget &gadget) {
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
}

/// This program in a process of its own, which has a gadget and runs it by orders.
class GadgetProcess {
public:
    /// Plugged in when it returns. @throw HostError if it cannot be started
    /// @param arguments  by which it knows what to do, with the name that precedes them
    explicit GadgetProcess(std::vector<std::string> arguments) {
        std::array<int, 2> orders{};
        std::array<int, 2> answers{};
        if (pipe(orders.data()) != 0 || pipe(answers.data()) != 0) {
            throw HostError("no pipes");
        }
        std::vector<char *> words;
        for (std::string &argument : arguments) {
            words.push_back(argument.data());
        }
        words.push_back(nullptr);
        process_ = fork();
        if (process_ == 0) {
            dup2(orders[0], STDIN_FILENO);
            dup2(answers[1], STDOUT_FILENO);
            for (const int file : {orders[0], orders[1], answers[0], answers[1]}) {
                close(file);
            }
            execv("/proc/self/exe", words.data());
            _exit(127);
        }
        close(orders[0]);
        close(answers[1]);
        orders_ = orders[1];
        answers_ = answers[0];
        if (answer() != "done") {
            throw HostError("the gadget did not start");
        }
    }
    /// Unplugged, and ended.
    ~GadgetProcess() {
        if (process_ > 0) {
            close(orders_);
            waitpid(process_, nullptr, 0);
            close(answers_);
        }
    }
    GadgetProcess(const GadgetProcess &) = delete;
    GadgetProcess &operator=(const GadgetProcess &) = delete;

    void unplug() const { order('u'); }
    void plug_in() const { order('p'); }
    void kill() {
        ::kill(process_, SIGKILL);
        waitpid(std::exchange(process_, -1), nullptr, 0);
        close(orders_);
        close(answers_);
    }
    /// @return what it says at its end
    std::string end() {
        close(orders_);
        std::string farewell = answer();
        int status = 0;
        waitpid(std::exchange(process_, -1), &status, 0);
        close(answers_);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
            throw HostError("the gadget ended with status " + std::to_string(status));
        }
        return farewell;
    }

private:
    void order(char letter) const {
        if (write(orders_, &letter, 1) != 1 || answer() != "done") {
            throw HostError("the gadget has ended");
        }
    }
    [[nodiscard]] std::string answer() const {
        std::string line;
        for (char letter = 0; read(answers_, &letter, 1) == 1 && letter != '\n';) {
            line += letter;
        }
        return line;
    }

    pid_t process_ = -1;
    int orders_ = -1;
    int answers_ = -1;
};

/// A device with springdrive's interface, opened by its serial number.
class HostDevice {
public:
    /// @throw HostError if it is not there
    HostDevice(libusb_context *context, const std::string &serial) {
        libusb_device **devices = nullptr;
        const ssize_t count = libusb_get_device_list(context, &devices);
        for (ssize_t i = 0; i < count && !handle_; ++i) {
            open_if_wanted(devices[i], serial);
        }
        if (devices != nullptr) {
            libusb_free_device_list(devices, 1);
        }
        if (!handle_) {
            throw HostError("no device with serial number " + serial, LIBUSB_ERROR_NOT_FOUND);
        }
        if (const int error = libusb_claim_interface(handle_.get(), 0); error != 0) {
            throw HostError("claiming the interface", error);
        }
    }

    [[nodiscard]] libusb_device_handle *handle() const { return handle_.get(); }
    [[nodiscard]] std::uint8_t out() const { return out_; }
    [[nodiscard]] std::uint8_t in() const { return in_; }
    [[nodiscard]] bool is_high_speed() const {
        return libusb_get_device_speed(libusb_get_device(handle_.get())) == LIBUSB_SPEED_HIGH;
    }

private:
    struct Close {
        void operator()(libusb_device_handle *handle) const { libusb_close(handle); }
    };

    void open_if_wanted(libusb_device *device, const std::string &serial) {
        libusb_device_descriptor ids{};
        libusb_get_device_descriptor(device, &ids);
        libusb_device_handle *opened = nullptr;
        if (ids.idVendor != usb::kVendorId || ids.idProduct != usb::kProductId ||
            libusb_open(device, &opened) != 0) {
            return;
        }
        std::unique_ptr<libusb_device_handle, Close> handle(opened);
        std::array<unsigned char, 128> text{};
        const int size = libusb_get_string_descriptor_ascii(opened, ids.iSerialNumber, text.data(),
                                                            static_cast<int>(text.size()));
        if (size > 0 && serial == std::string(text.begin(), text.begin() + size) &&
            has_interface(device)) {
            handle_ = std::move(handle);
        }
    }

    /// The controller gives the endpoints their addresses.
    bool has_interface(libusb_device *device) {
        libusb_config_descriptor *configuration = nullptr;
        if (libusb_get_active_config_descriptor(device, &configuration) != 0) {
            return false;
        }
        const libusb_interface_descriptor &interface = configuration->interface[0].altsetting[0];
        const bool is_ours = interface.bInterfaceClass == usb::kInterfaceClass &&
                             interface.bInterfaceSubClass == usb::kInterfaceSubclass &&
                             interface.bInterfaceProtocol == usb::kInterfaceProtocol &&
                             interface.bNumEndpoints == 2;
        for (const libusb_endpoint_descriptor &endpoint :
             std::span(interface.endpoint, is_ours ? 2U : 0U)) {
            const bool is_in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0;
            (is_in ? in_ : out_) = endpoint.bEndpointAddress;
        }
        libusb_free_config_descriptor(configuration);
        return is_ours && in_ != 0 && out_ != 0;
    }

    std::unique_ptr<libusb_device_handle, Close> handle_;
    std::uint8_t out_ = 0;
    std::uint8_t in_ = 0;
};

namespace detail {

using EchoClock = std::chrono::steady_clock;
inline constexpr unsigned kTimeLimit_ms = 2000;

/// Each one differs from all others, in every run.
inline usb::Frame echo_packet(std::uint32_t number) {
    usb::Frame packet{};
    for (std::size_t i = 0; i < packet.size(); ++i) {
        packet[i] =
            i < 4 ? static_cast<std::uint8_t>(number >> (8 * i))
                  : static_cast<std::uint8_t>(31U * number + 7U * static_cast<std::uint32_t>(i));
    }
    return packet;
}

inline void check_echo(std::uint32_t number, const usb::Frame &packet, int size) {
    if (size != static_cast<int>(packet.size()) || packet != echo_packet(number)) {
        std::uint32_t came = 0;
        std::memcpy(&came, packet.data(), sizeof came);
        throw HostError("echo " + std::to_string(number) + " is wrong: " + std::to_string(size) +
                        " bytes, number " + std::to_string(came));
    }
}

inline EchoRun summarise(std::vector<double> times_us, double duration_s) {
    std::ranges::sort(times_us);
    const auto quantile = [&](double share) {
        const auto last = static_cast<double>(times_us.size() - 1);
        return times_us[static_cast<std::size_t>(std::lround(share * last))];
    };
    return {.round_trips = times_us.size(),
            .rate_hz = static_cast<double>(times_us.size()) / duration_s,
            .median_us = quantile(0.5),
            .p99_us = quantile(0.99),
            .greatest_us = times_us.back()};
}

inline double microseconds_since(EchoClock::time_point begin) {
    return std::chrono::duration<double, std::micro>(EchoClock::now() - begin).count();
}

inline EchoRun echo_synchronously(const HostDevice &device, std::size_t round_trips) {
    std::vector<double> times_us;
    times_us.reserve(round_trips);
    const EchoClock::time_point begin = EchoClock::now();
    for (std::uint32_t i = 0; i < round_trips; ++i) {
        usb::Frame packet = echo_packet(i);
        const EchoClock::time_point sent = EchoClock::now();
        for (const std::uint8_t endpoint : {device.out(), device.in()}) {
            int size = 0;
            const int error =
                libusb_interrupt_transfer(device.handle(), endpoint, packet.data(),
                                          static_cast<int>(packet.size()), &size, kTimeLimit_ms);
            if (error != 0) {
                throw HostError(
                    "echo " + std::to_string(i) + ", endpoint " + std::to_string(endpoint), error);
            }
            check_echo(i, packet, size);
        }
        times_us.push_back(microseconds_since(sent));
    }
    return summarise(std::move(times_us), 1e-6 * microseconds_since(begin));
}

/// So many packets are always under way: an answer sends the next one.
class AsynchronousEcho {
public:
    AsynchronousEcho(libusb_context *context, const HostDevice &device, std::size_t in_flight)
        : context_(context), lane_(2 * in_flight) {
        for (std::size_t i = 0; i < lane_.size(); ++i) {
            const bool is_in = i < in_flight;
            Lane &lane = lane_[i];
            lane.owner = this;
            lane.transfer.reset(libusb_alloc_transfer(0));
            libusb_fill_interrupt_transfer(lane.transfer.get(), device.handle(),
                                           is_in ? device.in() : device.out(), lane.packet.data(),
                                           static_cast<int>(lane.packet.size()),
                                           is_in ? arrived : departed, &lane, kTimeLimit_ms);
        }
    }
    AsynchronousEcho(const AsynchronousEcho &) = delete;
    AsynchronousEcho &operator=(const AsynchronousEcho &) = delete;
    ~AsynchronousEcho() { end(); }

    EchoRun run(std::size_t round_trips) {
        requested_ = round_trips;
        sent_.reserve(round_trips);
        times_us_.reserve(round_trips);
        const std::size_t in_flight = lane_.size() / 2;
        const EchoClock::time_point begin = EchoClock::now();
        for (std::size_t i = 0; i < in_flight; ++i) {
            submit(lane_[i]);
            to_send_ += sent_.size() + to_send_ < requested_ ? 1 : 0;
        }
        send();
        while (times_us_.size() < requested_ && failure_.empty()) {
            handle_events();
        }
        const double duration_s = 1e-6 * microseconds_since(begin);
        end();
        if (!failure_.empty()) {
            throw HostError(failure_);
        }
        return summarise(std::move(times_us_), duration_s);
    }

private:
    struct Free {
        void operator()(libusb_transfer *transfer) const { libusb_free_transfer(transfer); }
    };
    struct Lane {
        AsynchronousEcho *owner = nullptr;
        std::unique_ptr<libusb_transfer, Free> transfer;
        usb::Frame packet{};
        bool is_under_way = false;
    };

    static void departed(libusb_transfer *transfer) {
        auto &lane = *static_cast<Lane *>(transfer->user_data);
        lane.is_under_way = false;
        lane.owner->check(*transfer, "sending");
        lane.owner->send();
    }

    static void arrived(libusb_transfer *transfer) {
        auto &lane = *static_cast<Lane *>(transfer->user_data);
        AsynchronousEcho &self = *lane.owner;
        lane.is_under_way = false;
        self.check(*transfer, "receiving");
        if (self.is_ending_ || !self.failure_.empty()) {
            return;
        }
        const auto number = static_cast<std::uint32_t>(self.times_us_.size());
        try {
            check_echo(number, lane.packet, transfer->actual_length);
        } catch (const HostError &error) {
            self.failure_ = error.what();
            return;
        }
        self.times_us_.push_back(microseconds_since(self.sent_[number]));
        self.submit(lane);
        self.to_send_ += self.sent_.size() + self.to_send_ < self.requested_ ? 1 : 0;
        self.send();
    }

    void check(const libusb_transfer &transfer, const char *what) {
        if (transfer.status != LIBUSB_TRANSFER_COMPLETED && failure_.empty() && !is_ending_) {
            failure_ = std::string("echo ") + std::to_string(times_us_.size()) + ", " + what +
                       ": transfer status " + std::to_string(transfer.status);
        }
    }

    /// As many as are due and have a transfer.
    void send() {
        for (std::size_t i = lane_.size() / 2; i < lane_.size() && to_send_ > 0; ++i) {
            if (Lane &lane = lane_[i]; !lane.is_under_way && failure_.empty()) {
                lane.packet = echo_packet(static_cast<std::uint32_t>(sent_.size()));
                sent_.push_back(EchoClock::now());
                --to_send_;
                submit(lane);
            }
        }
    }

    void submit(Lane &lane) {
        if (is_ending_) {
            return;
        }
        const int error = libusb_submit_transfer(lane.transfer.get());
        lane.is_under_way = error == 0;
        if (error != 0 && failure_.empty()) {
            failure_ = std::string("submitting a transfer: ") + libusb_error_name(error);
        }
    }

    void handle_events() {
        timeval limit{.tv_sec = 1, .tv_usec = 0};
        libusb_handle_events_timeout_completed(context_, &limit, nullptr);
    }

    void end() {
        is_ending_ = true;
        for (Lane &lane : lane_) {
            if (lane.is_under_way) {
                libusb_cancel_transfer(lane.transfer.get());
            }
        }
        while (std::ranges::any_of(lane_, [](const Lane &lane) { return lane.is_under_way; })) {
            handle_events();
        }
    }

    libusb_context *context_;
    std::vector<Lane> lane_; ///< as many IN as OUT
    std::size_t requested_ = 0;
    std::size_t to_send_ = 0;
    std::vector<EchoClock::time_point> sent_;
    std::vector<double> times_us_;
    bool is_ending_ = false;
    std::string failure_;
};

} // namespace detail

/// From an `Echo`, which is plugged in.
/// @throw HostError if it is not, or if an echo is lost, changed, or out of order
inline EchoFigures measure_echo(libusb_context *context, const std::string &serial,
                                std::size_t round_trips) {
    const HostDevice device(context, serial);
    EchoFigures figures;
    figures.synchronous = detail::echo_synchronously(device, round_trips);
    figures.asynchronous = detail::AsynchronousEcho(context, device, 1).run(round_trips);
    figures.four_in_flight = detail::AsynchronousEcho(context, device, 4).run(round_trips);
    return figures;
}

} // namespace springdrive::usb_test
