#include "device/usb/emulator/gadget.h"

#include "base/input_error.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <linux/aio_abi.h>
#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>
#include <mutex>
#include <poll.h>
#include <span>
#include <sys/eventfd.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace springdrive::emulator {

namespace {

using Clock = std::chrono::steady_clock;
namespace fs = std::filesystem;

const fs::path kConfigFolder = "/sys/kernel/config/usb_gadget";
const fs::path kControllerFolder = "/sys/class/udc";

constexpr std::size_t kReads = 4;        ///< packets that the host can send in a row
constexpr std::size_t kMaxPayload = 512; ///< of a control request
constexpr std::size_t kMaxName = 32;
constexpr double kMaxPass_s = 5e-3;
constexpr double kMinPass_s = 20e-6;
/// After which a name whose owner was killed is free at the latest.
constexpr auto kOwnersEnd = std::chrono::seconds(2);
constexpr auto kPause = std::chrono::milliseconds(10);

std::string reason(int error) { return std::generic_category().message(error); }

InputError gadget_error(const std::string &name, const std::string &what) {
    return InputError("USB gadget " + name + ": " + what);
}

class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor &&other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor &operator=(Descriptor &&other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor() {
        if (number_ >= 0) {
            close(number_);
        }
    }
    [[nodiscard]] int number() const { return number_; }
    [[nodiscard]] bool is_open() const { return number_ >= 0; }

private:
    int number_ = -1;
};

/// Wakes a thread that polls.
class Bell {
public:
    Bell() : file_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
        if (!file_.is_open()) {
            throw std::system_error(errno, std::generic_category(), "eventfd");
        }
    }
    void ring() const noexcept {
        const std::uint64_t one = 1;
        [[maybe_unused]] const ssize_t size = write(file_.number(), &one, sizeof one);
    }
    /// Since the last call.
    [[nodiscard]] bool has_rung() const noexcept {
        std::uint64_t rings = 0;
        return read(file_.number(), &rings, sizeof rings) > 0;
    }
    void silence() const noexcept { [[maybe_unused]] const bool has_rung_before = has_rung(); }
    [[nodiscard]] int number() const { return file_.number(); }

private:
    Descriptor file_;
};

/// A setting of configfs. @return 0, or the error
int set(const fs::path &file, std::string_view value) {
    const Descriptor opened(open(file.c_str(), O_WRONLY | O_CLOEXEC));
    if (!opened.is_open()) {
        return errno;
    }
    // An empty value needs a character, too.
    const std::string line = std::string(value) + "\n";
    return write(opened.number(), line.data(), line.size()) < 0 ? errno : 0;
}

std::string first_line(const fs::path &file) {
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    return line;
}

std::string find_controller(const std::string &gadget, const std::string &requested) {
    std::vector<std::string> controllers;
    std::error_code ignored;
    for (const auto &entry : fs::directory_iterator(kControllerFolder, ignored)) {
        controllers.push_back(entry.path().filename().string());
    }
    std::ranges::sort(controllers);
    if (controllers.empty()) {
        throw gadget_error(gadget, "there is no USB device controller; load dummy_hcd, or connect "
                                   "one");
    }
    if (requested.empty()) {
        return controllers.front();
    }
    if (!std::ranges::binary_search(controllers, requested)) {
        throw gadget_error(gadget, "there is no USB device controller " + requested +
                                       "; there is " + controllers.front());
    }
    return requested;
}

/// FunctionFS' files of this instance, mounted nowhere, so that nothing remains when this process
/// ends. @return the folder, or nothing and `errno`
Descriptor mount_function(const std::string &name) {
    const Descriptor context(fsopen("functionfs", FSOPEN_CLOEXEC));
    if (!context.is_open() ||
        fsconfig(context.number(), FSCONFIG_SET_STRING, "source", name.c_str(), 0) != 0 ||
        fsconfig(context.number(), FSCONFIG_CMD_CREATE, nullptr, nullptr, 0) != 0) {
        return {};
    }
    return Descriptor(fsmount(context.number(), FSMOUNT_CLOEXEC, 0));
}

/// The device as configfs describes it, unplugged; removed by the destructor.
class DeviceTree {
public:
    explicit DeviceTree(const GadgetOptions &options)
        : name_(options.name), function_("ffs." + options.name),
          folder_(kConfigFolder / options.name) {
        check(options);
        remove_leftover();
        try {
            create(options);
        } catch (...) {
            remove();
            throw;
        }
    }
    DeviceTree(const DeviceTree &) = delete;
    DeviceTree &operator=(const DeviceTree &) = delete;
    ~DeviceTree() { remove(); }

    /// @param controller  empty: of none
    /// @return 0, or the error
    [[nodiscard]] int bind(std::string_view controller) const {
        return set(folder_ / "UDC", controller);
    }

private:
    void check(const GadgetOptions &options) const {
        const auto is_allowed = [](char letter) {
            return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
                   (letter >= '0' && letter <= '9') || letter == '-' || letter == '_';
        };
        if (name_.empty() || name_.size() > kMaxName || !std::ranges::all_of(name_, is_allowed)) {
            throw InputError("a USB gadget's name has 1 to 32 letters, digits, - and _");
        }
        if (geteuid() != 0) {
            throw gadget_error(name_, "only root can create one; start it with sudo");
        }
        std::error_code ignored;
        if (!fs::exists(kConfigFolder, ignored)) {
            throw gadget_error(name_, "there is no " + kConfigFolder.string() +
                                          "; mount configfs and load libcomposite");
        }
        for (const std::string &text : {options.serial, options.product}) {
            if (text.empty() || text.size() > 126 ||
                !std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; })) {
                throw gadget_error(name_, "serial and product have 1 to 126 ASCII letters");
            }
        }
    }

    void remove_leftover() const {
        std::error_code ignored;
        if (!fs::exists(folder_, ignored)) {
            return;
        }
        for (const auto &entry : fs::directory_iterator(folder_ / "functions", ignored)) {
            if (entry.path().filename() != function_) {
                throw gadget_error(name_, "another program's gadget has this name; use another");
            }
        }
        // A killed owner's descriptors may take a moment to be closed.
        const auto deadline = Clock::now() + kOwnersEnd;
        while (!mount_function(name_).is_open() && errno == EBUSY) {
            if (Clock::now() > deadline) {
                throw gadget_error(name_, "it is running already; end it, or use another name");
            }
            std::this_thread::sleep_for(kPause);
        }
        remove();
    }

    void create(const GadgetOptions &options) const {
        make(folder_);
        const auto id = [](unsigned number) {
            constexpr std::string_view kDigits = "0123456789abcdef";
            std::string text = "0x";
            for (unsigned shift = 16; shift > 0;) {
                shift -= 4;
                text += kDigits[(number >> shift) & 0xfU];
            }
            return text;
        };
        put("idVendor", id(usb::kVendorId));
        put("idProduct", id(usb::kProductId));
        put("bcdUSB", "0x0200");
        put("bcdDevice", id(usb::kProtocolVersion << 8U));
        put("max_speed", options.is_high_speed ? "high-speed" : "full-speed");
        make(folder_ / "strings/0x409");
        put("strings/0x409/serialnumber", options.serial);
        put("strings/0x409/manufacturer", "springdrive");
        put("strings/0x409/product", options.product);
        make(folder_ / "configs/c.1");
        put("configs/c.1/bmAttributes", "0xc0"); // has its own supply
        make(folder_ / "functions" / function_);
        std::error_code error;
        fs::create_symlink(folder_ / "functions" / function_, folder_ / "configs/c.1" / function_,
                           error);
        if (error) {
            throw gadget_error(name_, "its function cannot be added: " + error.message());
        }
    }

    void make(const fs::path &folder) const {
        if (mkdir(folder.c_str(), 0755) == 0) {
            return;
        }
        if (folder == folder_ && errno == EEXIST) {
            throw gadget_error(name_, "it is being created already; use another name");
        }
        throw gadget_error(name_, folder.string() + " cannot be created: " + reason(errno) +
                                      "; load libcomposite and usb_f_fs");
    }

    void put(const fs::path &file, const std::string &value) const {
        if (const int error = set(folder_ / file, value); error != 0) {
            throw gadget_error(name_, (folder_ / file).string() + " cannot be set to " + value +
                                          ": " + reason(error));
        }
    }

    void remove() const noexcept {
        [[maybe_unused]] const int error = bind("");
        unlink((folder_ / "configs/c.1" / function_).c_str());
        for (const char *part : {"configs/c.1/strings/0x409", "configs/c.1", "strings/0x409"}) {
            rmdir((folder_ / part).c_str());
        }
        rmdir((folder_ / "functions" / function_).c_str());
        rmdir(folder_.c_str());
    }

    std::string name_;
    std::string function_;
    fs::path folder_;
};

/// Bytes for FunctionFS; numbers are little-endian.
class Bytes {
public:
    void bytes(std::initializer_list<std::uint8_t> added) {
        data_.insert(data_.end(), added.begin(), added.end());
    }
    void number(std::uint32_t value, unsigned size = 4) {
        for (unsigned i = 0; i < size; ++i) {
            data_.push_back(static_cast<std::uint8_t>(value >> (8U * i)));
        }
    }
    void text(std::string_view added) {
        data_.insert(data_.end(), added.begin(), added.end());
        data_.push_back(0);
    }
    /// The size of all, at byte 4, where both of FunctionFS' tables have it.
    void seal() {
        for (unsigned i = 0; i < 4; ++i) {
            data_[4 + i] = static_cast<std::uint8_t>(data_.size() >> (8U * i));
        }
    }
    [[nodiscard]] std::span<const std::uint8_t> all() const { return data_; }

private:
    std::vector<std::uint8_t> data_;
};

Bytes descriptors() {
    constexpr std::uint8_t kInterval = 1;      // a frame at full speed, a microframe at high speed
    constexpr std::uint8_t kFirstString = 1;   // of strings()
    constexpr std::uint32_t kCountInSpeed = 3; // interface and endpoints
    constexpr std::array<std::uint8_t, 2> kAddresses{USB_DIR_OUT | 1, USB_DIR_IN | 2};
    Bytes table;
    table.number(FUNCTIONFS_DESCRIPTORS_MAGIC_V2);
    table.number(0);
    table.number(FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC);
    table.number(kCountInSpeed);
    table.number(kCountInSpeed);
    for (int speed = 0; speed < 2; ++speed) {
        table.bytes({USB_DT_INTERFACE_SIZE, USB_DT_INTERFACE, 0, 0, 2, usb::kInterfaceClass,
                     usb::kInterfaceSubclass, usb::kInterfaceProtocol, kFirstString});
        for (const std::uint8_t address : kAddresses) {
            table.bytes({USB_DT_ENDPOINT_SIZE, USB_DT_ENDPOINT, address, USB_ENDPOINT_XFER_INT});
            table.number(usb::kFrameSize, 2);
            table.bytes({kInterval});
        }
    }
    table.seal();
    return table;
}

Bytes strings() {
    Bytes table;
    table.number(FUNCTIONFS_STRINGS_MAGIC);
    table.number(0);
    table.number(1); // strings
    table.number(1); // languages
    table.number(0x409, 2);
    table.text("springdrive");
    table.seal();
    return table;
}

/// The device's endpoints as files.
class Function {
public:
    explicit Function(const std::string &name) : folder_(mount_function(name)) {
        if (!folder_.is_open()) {
            throw gadget_error(name, errno == EBUSY ? "it is running already; use another name"
                                                    : "FunctionFS cannot be mounted: " +
                                                          reason(errno) + "; load usb_f_fs");
        }
        control_ = open_endpoint(name, "ep0", 0);
        for (const Bytes &table : {descriptors(), strings()}) {
            if (write(control_.number(), table.all().data(), table.all().size()) < 0) {
                throw gadget_error(name, "FunctionFS refuses its descriptors: " + reason(errno));
            }
        }
        // Without waiting, what is submitted while the host has not configured the device fails.
        out_ = open_endpoint(name, "ep1", O_NONBLOCK);
        in_ = open_endpoint(name, "ep2", O_NONBLOCK);
    }

    [[nodiscard]] int control() const { return control_.number(); }
    [[nodiscard]] int out() const { return out_.number(); }
    [[nodiscard]] int in() const { return in_.number(); }

private:
    [[nodiscard]] Descriptor open_endpoint(const std::string &name, const char *file,
                                           int options) const {
        Descriptor opened(openat(folder_.number(), file, O_RDWR | O_CLOEXEC | options));
        if (!opened.is_open()) {
            throw gadget_error(name, std::string("FunctionFS' ") + file +
                                         " cannot be opened: " + reason(errno));
        }
        return opened;
    }

    Descriptor folder_;
    Descriptor control_;
    Descriptor out_;
    Descriptor in_;
};

/// Packets on their way to or from an endpoint: the kernel's asynchronous I/O, so that no thread
/// waits inside a read or write, which only a signal could end.
class Transfers {
public:
    explicit Transfers(std::size_t count) : blocks_(count), event_(count) {
        if (syscall(SYS_io_setup, count, &context_) != 0) {
            throw InputError("asynchronous I/O for a USB gadget cannot be had: " + reason(errno) +
                             "; raise fs.aio-max-nr (sysctl)");
        }
    }
    Transfers(const Transfers &) = delete;
    Transfers &operator=(const Transfers &) = delete;
    /// Cancels those under way.
    ~Transfers() { syscall(SYS_io_destroy, context_); }

    /// @return whether it is under way; if not, nothing follows
    [[nodiscard]] bool submit(std::size_t which, int endpoint, bool reads,
                              std::span<std::uint8_t> packet) {
        iocb &block = blocks_[which];
        block = {};
        block.aio_data = which;
        block.aio_lio_opcode = reads ? IOCB_CMD_PREAD : IOCB_CMD_PWRITE;
        block.aio_fildes = static_cast<std::uint32_t>(endpoint);
        block.aio_buf = reinterpret_cast<std::uintptr_t>(packet.data());
        block.aio_nbytes = packet.size();
        block.aio_flags = IOCB_FLAG_RESFD;
        block.aio_resfd = static_cast<std::uint32_t>(ended_.number());
        iocb *submitted = &block;
        return syscall(SYS_io_submit, context_, 1L, &submitted) == 1;
    }

    /// Those that have ended, in that order.
    [[nodiscard]] std::span<const io_event> ended() {
        timespec no_wait{};
        const long count = syscall(SYS_io_getevents, context_, 0L, static_cast<long>(event_.size()),
                                   event_.data(), &no_wait);
        return std::span(event_).first(static_cast<std::size_t>(std::max(count, 0L)));
    }
    /// Rings when one has ended.
    [[nodiscard]] const Bell &bell() const { return ended_; }

private:
    Bell ended_;
    std::vector<iocb> blocks_;
    std::vector<io_event> event_;
    aio_context_t context_ = 0;
};

/// Timers of this thread as exact as they can be, for as long as this lives.
class ExactTimers {
public:
    ExactTimers() { prctl(PR_SET_TIMERSLACK, 1UL); }
    ExactTimers(const ExactTimers &) = delete;
    ExactTimers &operator=(const ExactTimers &) = delete;
    ~ExactTimers() { prctl(PR_SET_TIMERSLACK, static_cast<unsigned long>(before_ns_)); }

private:
    int before_ns_ = prctl(PR_GET_TIMERSLACK);
};

/// A thread that signals do not reach: they are for the program's own threads.
template <typename Work> std::thread thread_without_signals(Work work) {
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    try {
        std::thread thread(work);
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
        return thread;
    } catch (...) {
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
        throw;
    }
}

} // namespace

class Gadget::Implementation {
public:
    Implementation(Peripheral &peripheral, const GadgetOptions &options)
        : peripheral_(peripheral), name_(options.name), takes_out_(options.takes_out),
          tree_(options), controller_(find_controller(options.name, options.controller)),
          function_(options.name), transfers_(kReads + 1),
          requests_(thread_without_signals([this] { serve_requests(); })) {}
    Implementation(const Implementation &) = delete;
    Implementation &operator=(const Implementation &) = delete;
    ~Implementation() {
        // A request whose data the thread is waiting for ends by the unplugging.
        [[maybe_unused]] const int error = tree_.bind("");
        end_.ring();
        requests_.join();
        try {
            detach(false);
        } catch (...) { // NOLINT(bugprone-empty-catch)
            // What a peripheral has to say at its end, nobody can be told.
        }
    }

    void plug_in() {
        const int error = tree_.bind(controller_);
        if (error == EBUSY && is_plugged_in_) {
            return;
        }
        if (error == EBUSY) {
            throw gadget_error(name_, "another gadget has the controller " + controller_ +
                                          "; end that one, or name another controller");
        }
        if (error != 0) {
            throw gadget_error(name_, "the controller " + controller_ +
                                          " cannot be used: " + reason(error));
        }
        is_plugged_in_ = true;
    }

    void unplug() {
        const int error = tree_.bind("");
        if (error != 0 && error != ENODEV) {
            throw gadget_error(name_, "it cannot be unplugged: " + reason(error));
        }
        is_plugged_in_ = false;
        detach(false);
    }

    void run(const std::function<bool()> &until) {
        const ExactTimers exact;
        const Running running(*this);
        std::array<pollfd, 2> bells{
            {{.fd = transfers_.bell().number(), .events = POLLIN, .revents = 0},
             {.fd = wake_.number(), .events = POLLIN, .revents = 0}}};
        while (!until()) {
            const double wait_s = work();
            const timespec timeout{.tv_sec = 0, .tv_nsec = static_cast<long>(1e9 * wait_s)};
            ppoll(bells.data(), bells.size(), &timeout, nullptr);
            if (bells[1].revents != 0) {
                wake_.silence();
            }
        }
    }

    void wake() noexcept { wake_.ring(); }
    [[nodiscard]] const std::string &controller() const { return controller_; }
    [[nodiscard]] std::uint64_t refused_too_late() const { return refused_too_late_; }

private:
    /// Time passes for the peripheral while this lives.
    class Running {
    public:
        explicit Running(Implementation &gadget) : gadget_(gadget) {
            const std::lock_guard lock(gadget_.use_);
            gadget_.last_pass_ = Clock::now();
            gadget_.is_running_ = true;
        }
        Running(const Running &) = delete;
        Running &operator=(const Running &) = delete;
        ~Running() {
            const std::lock_guard lock(gadget_.use_);
            gadget_.is_running_ = false;
        }

    private:
        Implementation &gadget_;
    };

    /// All there is to do now. @return how long until there may be more [s]
    double work() {
        const std::lock_guard lock(use_);
        if (failure_) {
            std::rethrow_exception(std::exchange(failure_, nullptr));
        }
        // Packets arrive at a peripheral whose time is now, and may change what it does next.
        double wait_s = pass();
        bool has_put = false;
        if (transfers_.bell().has_rung()) {
            for (const io_event &ended : transfers_.ended()) {
                has_put = end(ended) || has_put;
            }
        }
        if (has_put) {
            wait_s = pass();
        }
        if (is_configured_) {
            for (std::size_t i = 0; i < kReads && !failed_read_; ++i) {
                if (!is_under_way_[i]) {
                    read(i);
                }
            }
            failed_read_ = false;
        }
        write_next();
        return std::clamp(wait_s, kMinPass_s, kMaxPass_s);
    }

    /// @return whether it was a packet for the peripheral
    bool end(const io_event &ended) {
        is_under_way_[ended.data] = false;
        if (ended.data == kWrite) {
            return false;
        }
        if (ended.res < 0) {
            // Repeated in the next call: the host may have unconfigured the device, and in that
            // case it fails again at no cost, until detached.
            failed_read_ = true;
            return false;
        }
        peripheral_.put(std::span(packet_[ended.data]).first(static_cast<std::size_t>(ended.res)));
        write_next();
        read(ended.data);
        return true;
    }

    double pass() {
        const Clock::time_point now = Clock::now();
        const std::chrono::duration<double> elapsed = now - std::exchange(last_pass_, now);
        return peripheral_.pass(elapsed.count());
    }

    /// The size is exactly a packet's: otherwise a full one would not end the read.
    void read(std::size_t which) {
        is_under_way_[which] = transfers_.submit(which, function_.out(), true, packet_[which]);
    }

    /// One at a time, so that the next one is as new as can be.
    void write_next() {
        if (!is_configured_ || is_under_way_[kWrite]) {
            return;
        }
        const std::size_t size = peripheral_.take(packet_[kWrite]);
        if (size > 0) {
            is_under_way_[kWrite] = transfers_.submit(
                kWrite, function_.in(), false,
                std::span(packet_[kWrite]).first(std::min(size, usb::kFrameSize)));
        }
    }

    // The thread of the host's requests.

    template <typename Question> auto ask(Question question) {
        const std::lock_guard lock(use_);
        pass_if_running();
        return question();
    }

    void pass_if_running() {
        if (is_running_) {
            pass();
        }
    }

    void serve_requests() noexcept {
        try {
            std::array<pollfd, 2> sources{
                {{.fd = function_.control(), .events = POLLIN, .revents = 0},
                 {.fd = end_.number(), .events = POLLIN, .revents = 0}}};
            for (;;) {
                poll(sources.data(), sources.size(), -1);
                if (sources[1].revents != 0) {
                    return;
                }
                if (sources[0].revents != 0) {
                    serve_event();
                }
            }
        } catch (...) {
            const std::lock_guard lock(use_);
            failure_ = std::current_exception();
        }
        wake_.ring();
    }

    /// One at a time: what the others say may be out of date once a request has been served.
    void serve_event() {
        usb_functionfs_event event{};
        if (::read(function_.control(), &event, sizeof event) !=
            static_cast<ssize_t>(sizeof event)) {
            if (errno != EIDRM && errno != EINTR && errno != EAGAIN) {
                throw std::system_error(errno, std::generic_category(), "FunctionFS' events");
            }
            return; // a request that the host has withdrawn
        }
        switch (event.type) {
        case FUNCTIONFS_ENABLE:
            attach(true);
            break;
        case FUNCTIONFS_RESUME:
            attach(false);
            break;
        case FUNCTIONFS_SUSPEND:
            detach(true);
            break;
        case FUNCTIONFS_DISABLE:
        case FUNCTIONFS_UNBIND:
            detach(false);
            break;
        case FUNCTIONFS_SETUP:
            serve(event.u.setup);
            break;
        default:
            break; // FUNCTIONFS_BIND
        }
        wake_.ring();
    }

    /// Linux drops events that a later one overtakes: the device may be attached, and have been
    /// disconnected in between.
    void attach(bool is_configured) {
        const bool is_high_speed =
            first_line(kControllerFolder / controller_ / "current_speed") == "high-speed";
        detach(true);
        const std::lock_guard lock(use_);
        is_configured_ = is_configured_ || is_configured;
        if (is_configured_) {
            peripheral_.attach(is_high_speed);
            is_attached_ = true;
        }
    }

    void detach(bool keeps_configuration) {
        const std::lock_guard lock(use_);
        is_configured_ = is_configured_ && keeps_configuration;
        if (is_attached_) {
            pass_if_running();
            peripheral_.detach();
            is_attached_ = false;
        }
    }

    void serve(const usb_ctrlrequest &request) {
        const std::size_t size = request.wLength;
        if (request.bRequestType == usb::kRequestIn) {
            const std::size_t answer = ask(
                [&] { return peripheral_.control_in(request.bRequest, request.wValue, payload_); });
            if (answer > 0 && size > 0) {
                [[maybe_unused]] const ssize_t sent =
                    ::write(function_.control(), payload_.data(),
                            std::min({answer, size, payload_.size()}));
                return;
            }
        } else if (request.bRequestType == usb::kRequestOut && size <= payload_.size() && ask([&] {
                       return !takes_out_ || takes_out_(request.bRequest, request.wValue, size);
                   })) {
            if (size == 0) {
                if (ask([&] {
                        return peripheral_.control_out(request.bRequest, request.wValue, {});
                    })) {
                    [[maybe_unused]] const ssize_t read =
                        ::read(function_.control(), payload_.data(), 0);
                    return;
                }
            } else {
                read_payload(request);
                return;
            }
        }
        stall(request);
    }

    void read_payload(const usb_ctrlrequest &request) {
        const ssize_t read = ::read(function_.control(), payload_.data(), request.wLength);
        if (read < 0) {
            return; // the host has withdrawn it
        }
        const std::span<const std::uint8_t> payload(payload_.data(),
                                                    static_cast<std::size_t>(read));
        if (!ask([&] {
                return peripheral_.control_out(request.bRequest, request.wValue, payload);
            })) {
            ++refused_too_late_;
        }
    }

    /// FunctionFS stalls a request when it is answered in the wrong direction.
    void stall(const usb_ctrlrequest &request) {
        [[maybe_unused]] const ssize_t stalled =
            (request.bRequestType & USB_DIR_IN) != 0
                ? ::read(function_.control(), payload_.data(), 0)
                : ::write(function_.control(), payload_.data(), 0);
    }

    static constexpr std::size_t kWrite = kReads; ///< after the reads

    Peripheral &peripheral_;
    std::string name_;
    std::function<bool(std::uint8_t, std::uint16_t, std::size_t)> takes_out_;

    std::mutex use_; ///< of the peripheral, and of all down to `failure_`
    Clock::time_point last_pass_ = Clock::now();
    bool is_running_ = false;
    bool is_attached_ = false;
    bool is_configured_ = false;
    bool failed_read_ = false;
    std::exception_ptr failure_;

    std::array<bool, kReads + 1> is_under_way_{};
    std::array<usb::Frame, kReads + 1> packet_{};
    std::array<std::uint8_t, kMaxPayload> payload_{}; ///< of the requests' thread
    std::atomic<std::uint64_t> refused_too_late_{0};
    std::atomic<bool> is_plugged_in_{false};

    // Removed in the opposite order.
    Bell wake_;
    Bell end_;
    DeviceTree tree_;
    std::string controller_;
    Function function_;
    Transfers transfers_;
    std::thread requests_;
};

Gadget::Gadget(Peripheral &peripheral, const GadgetOptions &options)
    : implementation_(std::make_unique<Implementation>(peripheral, options)) {}

Gadget::~Gadget() = default;

void Gadget::plug_in() { implementation_->plug_in(); }

void Gadget::unplug() { implementation_->unplug(); }

void Gadget::run(const std::function<bool()> &until) { implementation_->run(until); }

void Gadget::wake() noexcept { implementation_->wake(); }

std::string_view Gadget::controller() const { return implementation_->controller(); }

std::uint64_t Gadget::refused_too_late() const { return implementation_->refused_too_late(); }

} // namespace springdrive::emulator
