#include "tests/support/dropped_files.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <poll.h>
#include <stdexcept>
#include <string_view>
#include <utility>

// Last: these define macros such as None and Bool.
#include <X11/Xatom.h>
#include <X11/Xlib.h>

namespace springdrive::testing {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMax{20};
constexpr long kVersion = 5;

/// The side of the protocol that offers the files.
class FileSource {
public:
    FileSource(const VirtualDisplay &display, Window target, std::string uris,
               std::function<void()> settle)
        : display_(XOpenDisplay(display.name().c_str())), target_(target), uris_(std::move(uris)),
          settle_(std::move(settle)) {
        if (display_ == nullptr) {
            throw std::runtime_error("dropped files: no connection to " + display.name());
        }
        window_ = XCreateSimpleWindow(display_, DefaultRootWindow(display_), 0, 0, 1, 1, 0, 0, 0);
        selection_ = atom("XdndSelection");
        uri_list_ = atom("text/uri-list");
        targets_ = atom("TARGETS");
    }
    ~FileSource() { XCloseDisplay(display_); }
    FileSource(const FileSource &) = delete;
    FileSource &operator=(const FileSource &) = delete;

    void drop_at(int x, int y) {
        const long version = std::min(kVersion, version_of_target());
        XSetSelectionOwner(display_, selection_, window_, CurrentTime);
        tell("XdndEnter", {version << 24, static_cast<long>(uri_list_), 0, 0});
        tell("XdndPosition", {0, (static_cast<long>(x) << 16) | y, CurrentTime,
                              static_cast<long>(atom("XdndActionCopy"))});
        if ((answer("XdndStatus") & 1) == 0) {
            tell("XdndLeave", {});
            throw std::runtime_error("dropped files: the window does not take them");
        }
        tell("XdndDrop", {0, CurrentTime, 0, 0});
        // Not only the lowest bit, as GLFW answers with the length of the list.
        if (answer("XdndFinished") == 0) {
            throw std::runtime_error("dropped files: the program could not read the list");
        }
    }

private:
    [[nodiscard]] Atom atom(const char *name) const { return XInternAtom(display_, name, False); }

    /// @throw std::runtime_error  it does not know the protocol
    [[nodiscard]] long version_of_target() const {
        Atom type = 0;
        int format = 0;
        unsigned long count = 0;
        unsigned long rest = 0;
        unsigned char *value = nullptr;
        XGetWindowProperty(display_, target_, atom("XdndAware"), 0, 1, False, AnyPropertyType,
                           &type, &format, &count, &rest, &value);
        if (value == nullptr || count == 0 || format != 32) {
            throw std::runtime_error("dropped files: the window does not know XDND");
        }
        const long version = *reinterpret_cast<const long *>(value); // Xlib's form of 32 bits
        XFree(value);
        return version;
    }

    /// Sends a message with this window's id and `rest`.
    void tell(const char *what, const std::array<long, 4> &rest) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = target_;
        event.xclient.message_type = atom(what);
        event.xclient.format = 32;
        event.xclient.data.l[0] = static_cast<long>(window_);
        std::copy(rest.begin(), rest.end(), event.xclient.data.l + 1);
        XSendEvent(display_, target_, False, NoEventMask, &event);
        XFlush(display_);
    }

    /// Waits for this message of the target and serves requests for the list until then.
    /// @return its flags
    [[nodiscard]] long answer(const char *what) {
        const Atom expected = atom(what);
        const Clock::time_point deadline = Clock::now() + kMax;
        while (Clock::now() < deadline) {
            if (XPending(display_) == 0) {
                pollfd watched{ConnectionNumber(display_), POLLIN, 0};
                settle_ ? settle_() : static_cast<void>(poll(&watched, 1, 100));
                continue;
            }
            XEvent event;
            XNextEvent(display_, &event);
            if (event.type == SelectionRequest) {
                serve(event.xselectionrequest);
            } else if (event.type == ClientMessage && event.xclient.message_type == expected) {
                return event.xclient.data.l[1];
            }
        }
        throw std::runtime_error(std::string("dropped files: no ") + what + " from the program");
    }

    void serve(const XSelectionRequestEvent &request) {
        XEvent reply{};
        reply.xselection.type = SelectionNotify;
        reply.xselection.requestor = request.requestor;
        reply.xselection.selection = request.selection;
        reply.xselection.target = request.target;
        reply.xselection.property = request.property;
        reply.xselection.time = request.time;
        if (request.target == uri_list_) {
            XChangeProperty(display_, request.requestor, request.property, uri_list_, 8,
                            PropModeReplace, reinterpret_cast<const unsigned char *>(uris_.data()),
                            static_cast<int>(uris_.size()));
        } else if (request.target == targets_) {
            const std::array<Atom, 2> offered{targets_, uri_list_};
            XChangeProperty(display_, request.requestor, request.property, XA_ATOM, 32,
                            PropModeReplace,
                            reinterpret_cast<const unsigned char *>(offered.data()),
                            static_cast<int>(offered.size()));
        } else {
            reply.xselection.property = None;
        }
        XSendEvent(display_, request.requestor, False, NoEventMask, &reply);
        XFlush(display_);
    }

    Display *display_;
    Window target_;
    std::string uris_;
    std::function<void()> settle_;
    Window window_ = 0;
    Atom selection_ = 0;
    Atom uri_list_ = 0;
    Atom targets_ = 0;
};

} // namespace

std::string uri_list(const std::vector<std::filesystem::path> &paths) {
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                        "0123456789-._~/";
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string list;
    for (const std::filesystem::path &path : paths) {
        list += "file://";
        for (const char letter : std::filesystem::absolute(path).string()) {
            if (kPlain.find(letter) != std::string_view::npos) {
                list += letter;
            } else {
                const auto byte = static_cast<unsigned char>(letter);
                list += {'%', kDigits[byte / 16U], kDigits[byte % 16U]};
            }
        }
        list += "\r\n";
    }
    return list;
}

void drop_on_window(const VirtualDisplay &display, unsigned long window, int x, int y,
                    const std::vector<std::filesystem::path> &paths,
                    const std::function<void()> &settle) {
    FileSource(display, window, uri_list(paths), settle).drop_at(x, y);
}

} // namespace springdrive::testing
