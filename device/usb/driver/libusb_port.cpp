#include "device/usb/driver/libusb_port.h"

#include "base/input_error.h"
#include "base/latest_value.h"
#include "base/one_line.h"
#include "base/sample_ring.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace springdrive::usb {

namespace {

constexpr unsigned kControlTimeout_ms = 500;
constexpr int kLongestWait_ms = 100;

struct ContextEnd {
    void operator()(libusb_context *context) const { libusb_exit(context); }
};
using Context = std::unique_ptr<libusb_context, ContextEnd>;

struct HandleEnd {
    void operator()(libusb_device_handle *handle) const { libusb_close(handle); }
};
using Handle = std::unique_ptr<libusb_device_handle, HandleEnd>;

struct TransferEnd {
    void operator()(libusb_transfer *transfer) const { libusb_free_transfer(transfer); }
};

Context make_context() {
    libusb_context *context = nullptr;
    if (const int error = libusb_init(&context); error != 0) {
        throw InputError(
            fmt::format("USB cannot be used: {}; is /dev/bus/usb there?", libusb_strerror(error)));
    }
    return Context(context);
}

class DeviceList {
public:
    explicit DeviceList(libusb_context *context)
        : count_(libusb_get_device_list(context, &devices_)) {}
    ~DeviceList() {
        if (devices_ != nullptr) {
            libusb_free_device_list(devices_, 1);
        }
    }
    DeviceList(const DeviceList &) = delete;
    DeviceList &operator=(const DeviceList &) = delete;

    [[nodiscard]] std::span<libusb_device *> all() const {
        return {devices_, count_ > 0 ? static_cast<std::size_t>(count_) : 0U};
    }

private:
    libusb_device **devices_ = nullptr;
    ssize_t count_;
};

std::string place_of(libusb_device *device) {
    return fmt::format("bus {} device {}", libusb_get_bus_number(device),
                       libusb_get_device_address(device));
}

/// What to do about an error of libusb.
std::string advice_on(int error) {
    switch (error) {
    case LIBUSB_ERROR_ACCESS:
        return "no permission; plug the board in again, at the computer where you are logged in; "
               "if springdrive was not installed as a package, first copy "
               "setup/70-springdrive-usb.rules to /etc/udev/rules.d";
    case LIBUSB_ERROR_BUSY:
        return "another program uses it; end that program";
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
    case LIBUSB_ERROR_IO:
        return "it does not answer; plug it in again";
    default:
        return std::string(libusb_strerror(error)) + "; plug it in again";
    }
}

/// The interface of the protocol, of any of its versions, and its endpoints.
struct Endpoints {
    int interface_number = 0;
    std::uint8_t protocol = 0;
    std::uint8_t in = 0;
    std::uint8_t out = 0;
};

std::optional<Endpoints> endpoints_of(const libusb_interface_descriptor &description) {
    if (description.bInterfaceClass != kInterfaceClass ||
        description.bInterfaceSubClass != kInterfaceSubclass) {
        return std::nullopt;
    }
    Endpoints found{description.bInterfaceNumber, description.bInterfaceProtocol, 0, 0};
    for (const libusb_endpoint_descriptor &endpoint :
         std::span(description.endpoint, description.bNumEndpoints)) {
        if ((endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_INTERRUPT) {
            continue;
        }
        const bool is_in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_DIR_MASK) != 0;
        (is_in ? found.in : found.out) = endpoint.bEndpointAddress;
    }
    return found.in != 0 && found.out != 0 ? std::optional(found) : std::nullopt;
}

std::optional<Endpoints> endpoints_of(libusb_device *device) {
    libusb_config_descriptor *raw = nullptr;
    if (libusb_get_active_config_descriptor(device, &raw) != 0) {
        return std::nullopt;
    }
    const std::unique_ptr<libusb_config_descriptor, decltype(&libusb_free_config_descriptor)>
        configuration(raw, &libusb_free_config_descriptor);
    for (const libusb_interface &one :
         std::span(configuration->interface, configuration->bNumInterfaces)) {
        if (one.num_altsetting > 0) {
            if (const auto found = endpoints_of(one.altsetting[0])) {
                return found;
            }
        }
    }
    return std::nullopt;
}

/// A board that was opened; or why it was not.
struct OpenedBoard {
    std::string place;
    std::string serial;
    Handle handle;
    std::string problem;
};

std::string serial_of(libusb_device_handle *handle, std::uint8_t index) {
    std::array<unsigned char, 64> text{};
    const int size = libusb_get_string_descriptor_ascii(handle, index, text.data(),
                                                        static_cast<int>(text.size()));
    return size > 0 ? one_line({reinterpret_cast<const char *>(text.data()), // of any origin
                                static_cast<std::size_t>(size)})
                    : std::string();
}

std::vector<OpenedBoard> open_all(libusb_context *context) {
    std::vector<OpenedBoard> boards;
    const DeviceList devices(context);
    for (libusb_device *device : devices.all()) {
        libusb_device_descriptor description{};
        if (libusb_get_device_descriptor(device, &description) != 0 ||
            description.idVendor != kVendorId || description.idProduct != kProductId) {
            continue;
        }
        libusb_device_handle *raw = nullptr;
        const int error = libusb_open(device, &raw);
        OpenedBoard &board = boards.emplace_back();
        board.place = place_of(device);
        board.handle.reset(raw);
        if (error != 0) {
            board.problem = advice_on(error);
        } else {
            board.serial = serial_of(raw, description.iSerialNumber);
        }
    }
    return boards;
}

std::string list_of(const std::vector<OpenedBoard> &boards) {
    std::string list;
    for (const OpenedBoard &board : boards) {
        list += (list.empty() ? "" : ", ") + (board.serial.empty() ? board.place : board.serial);
    }
    return list;
}

/// The board with this serial number, or the only one.
OpenedBoard choose(std::vector<OpenedBoard> boards, const std::string &serial) {
    if (boards.empty()) {
        throw InputError("no USB board is connected; plug one in and switch its power on, or use "
                         "--device sim");
    }
    const auto found = serial.empty() && boards.size() == 1
                           ? boards.begin()
                           : std::ranges::find(boards, serial, &OpenedBoard::serial);
    if (serial.empty() && boards.size() > 1) {
        throw InputError("several USB boards are connected: " + list_of(boards) +
                         "; name one by --device usb:SERIAL");
    }
    if (found == boards.end()) {
        throw InputError(fmt::format("no USB board with the serial number '{}' is connected, but "
                                     "{}",
                                     serial, list_of(boards)));
    }
    if (!found->problem.empty()) {
        throw InputError("the USB board at " + found->place + ": " + found->problem);
    }
    return std::move(*found);
}

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
    std::thread thread_;
};

std::string_view name_of_speed(int speed) {
    switch (speed) {
    case LIBUSB_SPEED_LOW:
        return "low speed (1.5 Mbit/s)";
    case LIBUSB_SPEED_FULL:
        return "full speed (12 Mbit/s)";
    case LIBUSB_SPEED_HIGH:
        return "high speed (480 Mbit/s)";
    case LIBUSB_SPEED_SUPER:
    case LIBUSB_SPEED_SUPER_PLUS:
        return "super speed (5 Gbit/s or more)";
    default:
        return "an unknown speed";
    }
}

void LibusbPort::open(const std::string &serial) {
    end();
    context_ = make_context(); // without udev, an old one does not see what was plugged in since
    OpenedBoard board = choose(open_all(context_.get()), serial);
    const std::string name = "the USB board " + (board.serial.empty() ? board.place : board.serial);
    libusb_device *const device = libusb_get_device(board.handle.get());
    const std::optional<Endpoints> endpoints = endpoints_of(device);
    if (!endpoints) {
        throw InputError(name + ": has no interface for springdrive; is its firmware installed?");
    }
    if (const int error = libusb_claim_interface(board.handle.get(), endpoints->interface_number);
        error != 0) {
        throw InputError(name + ": " + advice_on(error));
    }
    handle_ = std::move(board.handle);
    endpoints_ = *endpoints;
    speed_ = name_of_speed(libusb_get_device_speed(device));
    for (Transfer &transfer : in_) {
        prepare(transfer, endpoints_.in, &LibusbPort::on_received);
    }
    for (Transfer &transfer : out_) {
        prepare(transfer, endpoints_.out, &LibusbPort::on_sent);
    }
    for (Packet old; packets_.pop(old);) { // of the connection before
    }
    submitted_ = outgoing_number_;
    ends_ = false;
    is_running_ = true;
    is_connected_ = true;
    thread_ = std::thread([this] { run(); });
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
    if (thread_.joinable()) {
        ends_ = true;
        wake_.signal();
        thread_.join();
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
        static_cast<void>(controlled_.wait(kLongestWait_ms));
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
    sched_param parameters{};
    parameters.sched_priority = kPortThreadPriority;
    static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters));
    std::ranges::for_each(in_, [this](Transfer &transfer) { submit(transfer); });
    constexpr std::size_t kMostFiles = 16;
    std::array<pollfd, kMostFiles> files{};
    files[0] = {wake_.fd(), POLLIN, 0};
    std::size_t count = 1;
    const std::unique_ptr<const libusb_pollfd *, decltype(&libusb_free_pollfds)> own(
        libusb_get_pollfds(context_.get()), &libusb_free_pollfds);
    for (const libusb_pollfd *const *next = own.get();
         next != nullptr && *next != nullptr && count < kMostFiles; ++next) {
        files[count++] = {(*next)->fd, (*next)->events, 0};
    }
    while (!ends_ && is_connected()) {
        poll(files.data(), count, kLongestWait_ms);
        wake_.clear();
        handle_events();
        submit_newest();
    }
    is_connected_ = false;
    arrived_.signal();
    cancel_all();
    while (is_any_under_way()) {
        poll(files.data() + 1, count - 1, kLongestWait_ms);
        handle_events();
    }
    is_running_ = false;
}

} // namespace

std::vector<FoundBoard> boards_present() {
    const Context context = make_context();
    std::vector<FoundBoard> found;
    for (OpenedBoard &board : open_all(context.get())) {
        found.push_back({std::move(board.serial), std::move(board.problem)});
    }
    return found;
}

namespace {

BoardObstacle obstacle_of(int error) {
    switch (error) {
    case 0:
        return BoardObstacle::none;
    case LIBUSB_ERROR_ACCESS:
        return BoardObstacle::no_permission;
    case LIBUSB_ERROR_BUSY:
        return BoardObstacle::in_use;
    default:
        return BoardObstacle::no_answer;
    }
}

/// @return an error of libusb
int ask_for_identity(libusb_device_handle *handle, const Endpoints &endpoints,
                     SurveyedBoard &board) {
    if (const int error = libusb_claim_interface(handle, endpoints.interface_number); error != 0) {
        return error;
    }
    std::array<std::uint8_t, kIdentitySize> answer{};
    const int size = libusb_control_transfer(
        handle, kRequestIn, static_cast<std::uint8_t>(Kind::identity), 0,
        static_cast<std::uint16_t>(endpoints.interface_number), answer.data(),
        static_cast<std::uint16_t>(answer.size()), kControlTimeout_ms);
    libusb_release_interface(handle, endpoints.interface_number);
    if (size < 0 && size != LIBUSB_ERROR_PIPE) {
        return size;
    }
    take_identity(std::span(answer).first(size > 0 ? static_cast<std::size_t>(size) : 0U), board);
    return 0;
}

/// @return an error of libusb
int survey(libusb_device *device, const libusb_device_descriptor &description,
           SurveyedBoard &board) {
    std::array<std::uint8_t, 7> ports{}; // the deepest that USB allows
    const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
    board.bus = libusb_get_bus_number(device);
    board.address = libusb_get_device_address(device);
    board.sysfs_name = sysfs_name_of(
        board.bus, std::span(ports).first(depth > 0 ? static_cast<std::size_t>(depth) : 0U));
    board.speed = name_of_speed(libusb_get_device_speed(device));
    libusb_device_handle *raw = nullptr;
    if (const int error = libusb_open(device, &raw); error != 0) {
        return error;
    }
    const Handle handle(raw);
    board.serial = serial_of(raw, description.iSerialNumber);
    const std::optional<Endpoints> endpoints = endpoints_of(device);
    if (!endpoints) {
        board.obstacle = BoardObstacle::no_interface;
        board.problem = "has no interface for springdrive; is its firmware installed?";
        return 0;
    }
    return ask_for_identity(raw, *endpoints, board);
}

} // namespace

std::vector<SurveyedBoard> survey_boards() {
    const Context context = make_context();
    const DeviceList devices(context.get());
    std::vector<SurveyedBoard> boards;
    for (libusb_device *device : devices.all()) {
        libusb_device_descriptor description{};
        if (libusb_get_device_descriptor(device, &description) != 0 ||
            description.idVendor != kVendorId || description.idProduct != kProductId) {
            continue;
        }
        SurveyedBoard &board = boards.emplace_back();
        if (const int error = survey(device, description, board); error != 0) {
            board.obstacle = obstacle_of(error);
            board.problem = advice_on(error);
        }
    }
    return boards;
}

std::unique_ptr<BoardPort> make_libusb_port() { return std::make_unique<LibusbPort>(); }

} // namespace springdrive::usb
