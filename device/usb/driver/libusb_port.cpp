// A board on USB, by libusb-1.0.
//
//   servo ──Latest──► ┌────────┐ ──2 transfers OUT──► board
//   servo ◄──ring──── │ thread │ ◄─4 transfers IN──── board
//                     └────────┘
//
// libusb locks and allocates with each transfer, so a thread calls it whose heap is its own
// (base/real_time_thread.h). The servo's thread passes packets to and from that thread without
// waiting, and wakes it, or is woken, by an eventfd: one system call each. Of commands that could
// not leave yet, only the newest is kept.
#include "device/usb/driver/board_port.h"

#include "base/hand_over.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/usb/driver/libusb_boards.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <fmt/format.h>
#include <future>
#include <memory>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace springdrive::usb {

namespace {

constexpr int kMaxWait_ms = 100;

struct TransferEnd {
    void operator()(libusb_transfer *transfer) const { libusb_free_transfer(transfer); }
};

class EventCounter {
public:
    EventCounter() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
        if (fd_ < 0) {
            throw InputError("USB cannot be used: too many files are open");
        }
    }
    ~EventCounter() { ::close(fd_); }
    EventCounter(const EventCounter &) = delete;
    EventCounter &operator=(const EventCounter &) = delete;

    void signal() const noexcept {
        const std::uint64_t one = 1;
        [[maybe_unused]] const ssize_t written = write(fd_, &one, sizeof one);
    }
    void clear() const noexcept {
        std::uint64_t count = 0;
        [[maybe_unused]] const ssize_t size = read(fd_, &count, sizeof count);
    }
    /// @return whether it was signalled
    [[nodiscard]] bool wait(int longest_ms) const noexcept {
        pollfd waits{fd_, POLLIN, 0};
        return poll(&waits, 1, longest_ms) > 0;
    }
    [[nodiscard]] int fd() const noexcept { return fd_; }

private:
    int fd_;
};

class LibusbPort final : public BoardPort {
public:
    LibusbPort() = default;
    ~LibusbPort() override { end(); }
    LibusbPort(const LibusbPort &) = delete;
    LibusbPort &operator=(const LibusbPort &) = delete;

    bool send(const Frame &frame) noexcept override;
    bool receive(Packet &packet, double deadline_s) noexcept override;
    [[nodiscard]] bool is_connected() const noexcept override {
        return is_connected_.load(std::memory_order_acquire);
    }
    [[nodiscard]] double now_s() const noexcept override {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
            .count();
    }
    std::size_t control_in(Kind request, std::uint16_t value,
                           std::span<std::uint8_t> answer) override;
    bool control_out(Kind request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override;
    void close() noexcept override { end(); }
    void open(const std::string &serial) override;
    [[nodiscard]] std::string_view speed() const override { return speed_; }
    [[nodiscard]] std::string_view warning() const override { return warning_; }

private:
    static constexpr std::size_t kTransfersIn = 4;
    static constexpr std::size_t kTransfersOut = 2;
    static constexpr std::size_t kPackets = 64; ///< that the servo has not read yet

    struct Outgoing {
        Frame frame{};
        std::uint32_t number = 0; ///< 0: none yet
    };

    /// A transfer of libusb, with its buffer.
    struct Transfer {
        std::unique_ptr<libusb_transfer, TransferEnd> transfer{libusb_alloc_transfer(0)};
        std::array<unsigned char, kFrameSize> data{};
        LibusbPort *port = nullptr;
        bool is_under_way = false;
    };

    /// A control request under way.
    struct Control {
        std::unique_ptr<libusb_transfer, TransferEnd> transfer;
        std::vector<unsigned char> data; ///< after the setup packet
        LibusbPort *port = nullptr;
        std::atomic<bool> is_done{false};
    };

    void end() noexcept;
    void find_files();
    void prepare(Transfer &transfer, std::uint8_t endpoint, libusb_transfer_cb_fn callback);
    void run() noexcept;
    void submit(Transfer &transfer) noexcept;
    void submit_newest() noexcept;
    void lose() noexcept;
    void cancel_all() noexcept;
    [[nodiscard]] bool is_any_under_way() const noexcept;
    void received(Transfer &transfer) noexcept;
    void sent(Transfer &transfer) noexcept;
    void handle_events() noexcept;
    int control(std::uint8_t direction, Kind request, std::uint16_t value,
                std::span<std::uint8_t> data);
    int control_or_throw(std::uint8_t direction, Kind request, std::uint16_t value,
                         std::span<std::uint8_t> data);

    static void LIBUSB_CALL on_received(libusb_transfer *transfer) {
        auto &ours = *static_cast<Transfer *>(transfer->user_data);
        ours.port->received(ours);
    }
    /// `control` frees the transfer as soon as it is done.
    static void LIBUSB_CALL on_controlled(libusb_transfer *transfer) {
        auto &control = *static_cast<Control *>(transfer->user_data);
        const EventCounter &controlled = control.port->controlled_;
        control.is_done.store(true, std::memory_order_release);
        controlled.signal();
    }
    static void LIBUSB_CALL on_sent(libusb_transfer *transfer) {
        auto &ours = *static_cast<Transfer *>(transfer->user_data);
        ours.port->sent(ours);
    }

    Context context_;
    Handle handle_;
    Endpoints endpoints_;
    std::string speed_ = "not connected";
    std::string warning_;
    std::vector<pollfd> files_; ///< that this port's thread waits for
    std::array<Transfer, kTransfersIn> in_;
    std::array<Transfer, kTransfersOut> out_;

    // Between the servo's thread and this port's.
    LatestValue<Outgoing> outgoing_;
    std::uint32_t outgoing_number_ = 0; ///< of the servo's thread
    std::uint32_t submitted_ = 0;       ///< of this port's thread
    SampleRing<Packet> packets_{kPackets};
    EventCounter wake_;       ///< wakes this port's thread
    EventCounter arrived_;    ///< wakes the servo's
    EventCounter controlled_; ///< wakes the thread of a control request
    std::atomic<bool> is_connected_{false};
    std::atomic<bool> ends_{false};
    std::atomic<bool> is_running_{false}; ///< the thread, which handles libusb's events
    std::future<void> thread_;            ///< until it ends
};

void LibusbPort::open(const std::string &serial) {
    end();
    context_ = make_context(); // without udev, an old one does not see what was plugged in since
    OpenedBoard board = open_board_named(context_.get(), serial);
    const std::string name = "the USB board " + (board.serial.empty() ? board.place : board.serial);
    libusb_device *const device = libusb_get_device(board.handle.get());
    if (const int error =
            libusb_claim_interface(board.handle.get(), board.endpoints.interface_number);
        error != 0) {
        throw InputError(name + ": " + advice_on(error));
    }
    handle_ = std::move(board.handle);
    endpoints_ = board.endpoints;
    speed_ = name_of_speed(libusb_get_device_speed(device));
    for (Transfer &transfer : in_) {
        prepare(transfer, endpoints_.in, &LibusbPort::on_received);
    }
    for (Transfer &transfer : out_) {
        prepare(transfer, endpoints_.out, &LibusbPort::on_sent);
    }
    find_files();
    for (Packet old; packets_.pop(old);) { // of the connection before
    }
    submitted_ = outgoing_number_;
    ends_ = false;
    is_running_ = true;
    is_connected_ = true;
    const auto refused = std::make_shared<std::promise<int>>();
    thread_ = run_on_own_heap([this, refused] {
        refused->set_value(request_priority(kPortThreadPriority));
        run();
    });
    warning_ = refused->get_future().get() == 0
                   ? std::string()
                   : fmt::format("the thread that serves USB has no real-time priority ({} was "
                                 "refused), so reports may be late; see springdrive doctor",
                                 kPortThreadPriority);
}

/// What `run` waits for: its own wake-up, and the files of libusb, which stay the same while the
/// board is open.
void LibusbPort::find_files() {
    files_.assign(1, {wake_.fd(), POLLIN, 0});
    const std::unique_ptr<const libusb_pollfd *, decltype(&libusb_free_pollfds)> own(
        libusb_get_pollfds(context_.get()), &libusb_free_pollfds);
    if (!own) {
        throw InputError("USB cannot be used: libusb has no files to wait for on this system");
    }
    for (const libusb_pollfd *const *next = own.get(); *next != nullptr; ++next) {
        files_.push_back({(*next)->fd, (*next)->events, 0});
    }
}

void LibusbPort::prepare(Transfer &transfer, std::uint8_t endpoint,
                         libusb_transfer_cb_fn callback) {
    if (!transfer.transfer) {
        throw InputError("USB cannot be used: out of memory");
    }
    transfer.port = this;
    libusb_fill_interrupt_transfer(transfer.transfer.get(), handle_.get(), endpoint,
                                   transfer.data.data(), static_cast<int>(transfer.data.size()),
                                   callback, &transfer, 0);
}

/// The thread has cancelled all transfers when it ends.
void LibusbPort::end() noexcept {
    if (thread_.valid()) {
        ends_ = true;
        wake_.signal();
        thread_.get();
    }
    is_connected_ = false;
    if (handle_) {
        libusb_release_interface(handle_.get(), endpoints_.interface_number);
        handle_.reset();
        speed_ = "not connected";
    }
}

bool LibusbPort::send(const Frame &frame) noexcept {
    if (!is_connected()) {
        return false;
    }
    outgoing_.publish({frame, ++outgoing_number_});
    wake_.signal();
    return true;
}

bool LibusbPort::receive(Packet &packet, double deadline_s) noexcept {
    while (!packets_.pop(packet)) {
        const double left_s = deadline_s - now_s();
        if (!is_connected() || left_s <= 0.0) {
            return false;
        }
        pollfd waits{arrived_.fd(), POLLIN, 0};
        const auto whole_s = static_cast<time_t>(left_s);
        const timespec timeout{whole_s,
                               static_cast<long>(1e9 * (left_s - static_cast<double>(whole_s)))};
        ppoll(&waits, 1, &timeout, nullptr);
        arrived_.clear();
    }
    return true;
}

/// The port's thread handles the events of this transfer, too: whoever else did would hold a lock
/// that a thread of higher priority then waits for.
int LibusbPort::control(std::uint8_t direction, Kind request, std::uint16_t value,
                        std::span<std::uint8_t> data) {
    if (!is_connected()) {
        return LIBUSB_ERROR_NO_DEVICE;
    }
    Control control{std::unique_ptr<libusb_transfer, TransferEnd>(libusb_alloc_transfer(0)),
                    std::vector<unsigned char>(LIBUSB_CONTROL_SETUP_SIZE + data.size()), this};
    if (!control.transfer) {
        return LIBUSB_ERROR_NO_MEM;
    }
    const auto begin = control.data.begin() + LIBUSB_CONTROL_SETUP_SIZE;
    std::ranges::copy(data, begin);
    libusb_fill_control_setup(control.data.data(), direction, static_cast<std::uint8_t>(request),
                              value, static_cast<std::uint16_t>(endpoints_.interface_number),
                              static_cast<std::uint16_t>(data.size()));
    libusb_fill_control_transfer(control.transfer.get(), handle_.get(), control.data.data(),
                                 &LibusbPort::on_controlled, &control, kControlTimeout_ms);
    if (const int error = libusb_submit_transfer(control.transfer.get()); error != 0) {
        return error;
    }
    while (!control.is_done.load(std::memory_order_acquire)) {
        static_cast<void>(controlled_.wait(kMaxWait_ms));
        controlled_.clear();
        if (!is_running_) { // it ended before this transfer was submitted
            handle_events();
        }
    }
    std::copy_n(begin, control.transfer->actual_length, data.begin());
    switch (control.transfer->status) {
    case LIBUSB_TRANSFER_COMPLETED:
        return control.transfer->actual_length;
    case LIBUSB_TRANSFER_STALL:
        return LIBUSB_ERROR_PIPE;
    default:
        return LIBUSB_ERROR_IO;
    }
}

int LibusbPort::control_or_throw(std::uint8_t direction, Kind request, std::uint16_t value,
                                 std::span<std::uint8_t> data) {
    const int result = control(direction, request, value, data);
    if (result < 0 && result != LIBUSB_ERROR_PIPE) {
        throw InputError("the USB board: " + advice_on(result));
    }
    return result;
}

std::size_t LibusbPort::control_in(Kind request, std::uint16_t value,
                                   std::span<std::uint8_t> answer) {
    const int size = control_or_throw(kRequestIn, request, value, answer);
    return size > 0 ? static_cast<std::size_t>(size) : 0U;
}

bool LibusbPort::control_out(Kind request, std::uint16_t value,
                             std::span<const std::uint8_t> payload) {
    std::vector<std::uint8_t> data(payload.begin(), payload.end());
    return control_or_throw(kRequestOut, request, value, data) >= 0;
}

void LibusbPort::submit(Transfer &transfer) noexcept {
    transfer.is_under_way = libusb_submit_transfer(transfer.transfer.get()) == 0;
    if (!transfer.is_under_way) {
        lose();
    }
}

void LibusbPort::submit_newest() noexcept {
    const auto free = std::ranges::find(out_, false, &Transfer::is_under_way);
    const Outgoing &newest = outgoing_.latest();
    if (free == out_.end() || newest.number == submitted_) {
        return;
    }
    submitted_ = newest.number;
    free->data = newest.frame;
    submit(*free);
}

/// Every error of a transfer may be an unplug.
void LibusbPort::lose() noexcept {
    is_connected_ = false;
    arrived_.signal(); // nothing will come
}

void LibusbPort::received(Transfer &transfer) noexcept {
    transfer.is_under_way = false;
    const libusb_transfer &done = *transfer.transfer;
    if (done.status == LIBUSB_TRANSFER_OVERFLOW || done.status == LIBUSB_TRANSFER_COMPLETED) {
        Packet packet{transfer.data, static_cast<std::size_t>(done.actual_length), now_s()};
        if (done.status == LIBUSB_TRANSFER_OVERFLOW) {
            packet.size = kFrameSize + 1; // not a report
        }
        packets_.push(packet);
        arrived_.signal();
        if (!ends_ && is_connected()) {
            submit(transfer);
        }
    } else if (done.status != LIBUSB_TRANSFER_CANCELLED) {
        lose();
    }
}

void LibusbPort::sent(Transfer &transfer) noexcept {
    transfer.is_under_way = false;
    const libusb_transfer_status status = transfer.transfer->status;
    if (status != LIBUSB_TRANSFER_COMPLETED && status != LIBUSB_TRANSFER_CANCELLED) {
        lose();
    }
}

void LibusbPort::cancel_all() noexcept {
    const auto cancel = [](Transfer &transfer) {
        if (transfer.is_under_way) {
            libusb_cancel_transfer(transfer.transfer.get());
        }
    };
    std::ranges::for_each(in_, cancel);
    std::ranges::for_each(out_, cancel);
}

bool LibusbPort::is_any_under_way() const noexcept {
    return std::ranges::any_of(in_, &Transfer::is_under_way) ||
           std::ranges::any_of(out_, &Transfer::is_under_way);
}

void LibusbPort::handle_events() noexcept {
    timeval none{};
    libusb_handle_events_timeout_completed(context_.get(), &none, nullptr);
}

/// Until the end, or the connection is lost; then all transfers are taken back.
void LibusbPort::run() noexcept {
    std::ranges::for_each(in_, [this](Transfer &transfer) { submit(transfer); });
    while (!ends_ && is_connected()) {
        poll(files_.data(), files_.size(), kMaxWait_ms);
        wake_.clear();
        handle_events();
        submit_newest();
    }
    is_connected_ = false;
    arrived_.signal();
    cancel_all();
    while (is_any_under_way()) {
        poll(files_.data() + 1, files_.size() - 1, kMaxWait_ms);
        handle_events();
    }
    is_running_ = false;
}

} // namespace

std::unique_ptr<BoardPort> make_libusb_port() { return std::make_unique<LibusbPort>(); }

} // namespace springdrive::usb
