#include "tests/support/person.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <poll.h>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

// Last: these define macros such as None and Bool.
#include <X11/XKBlib.h>
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>

namespace springdrive::testing {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMaxFrame{10};
constexpr std::chrono::duration<double> kMouseInterval{1.0 / 60.0};
/// Between two letters. GLFW takes two presses of a key within a millisecond for one.
constexpr std::chrono::milliseconds kTypingInterval{4};

/// A window may go away at any time, as its program ends; Xlib would end the test.
int ignore_error(Display * /*display*/, XErrorEvent * /*event*/) { return 0; }

std::runtime_error failure(const std::string &why) {
    return std::runtime_error("acting on the window: " + why);
}

/// A key, and whether its upper symbol is meant.
struct Key {
    unsigned code = 0;
    bool with_shift = false;
};

std::string modifier_key(const std::string &word) {
    constexpr std::array<std::pair<std::string_view, const char *>, 4> kModifiers{
        {{"ctrl", "Control_L"}, {"shift", "Shift_L"}, {"alt", "Alt_L"}, {"super", "Super_L"}}};
    for (const auto &[name, key] : kModifiers) {
        if (word == name) {
            return key;
        }
    }
    throw failure("there is no modifier " + word);
}

std::vector<std::string> words_of(const std::string &chord) {
    std::vector<std::string> words;
    std::size_t begin = 0;
    for (std::size_t end = chord.find('+'); end != std::string::npos;
         end = chord.find('+', begin)) {
        words.push_back(chord.substr(begin, end - begin));
        begin = end + 1;
    }
    words.push_back(chord.substr(begin));
    return words;
}

constexpr std::chrono::seconds kMaxAnswer{20};
constexpr long kXdndVersion = 5;

/// The side of the protocol XDND, version 5, that offers files dragged from a file manager. Its
/// methods throw std::runtime_error if the window does not take files, or does not answer within
/// 20 s.
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
        const long version = std::min(kXdndVersion, version_of_target());
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
        const Clock::time_point deadline = Clock::now() + kMaxAnswer;
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

/// As file managers write them: one file URI per line, with everything except letters, digits and
/// -._~/ percent-encoded.
/// @param paths  relative ones are meant from the folder of the test
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

} // namespace

/// What needs Xlib.
class Person::Connection {
public:
    explicit Connection(const std::string &display_name)
        : display_(XOpenDisplay(display_name.c_str())) {
        if (display_ == nullptr) {
            throw failure("no connection to " + display_name);
        }
        XSetErrorHandler(ignore_error);
        int ignored = 0;
        if (XTestQueryExtension(display_, &ignored, &ignored, &ignored, &ignored) == False) {
            XCloseDisplay(display_);
            throw failure(display_name + " has no XTEST extension");
        }
        // How long a key is held here depends on the speed of the machine.
        XAutoRepeatOff(display_);
        // The end of windows, and answers to pings.
        XSelectInput(display_, root(), SubstructureNotifyMask);
        XSync(display_, False);
    }
    ~Connection() { XCloseDisplay(display_); }
    Connection(const Connection &) = delete;
    Connection &operator=(const Connection &) = delete;

    [[nodiscard]] Window window() const { return window_; }

    void find_window(Clock::time_point deadline, bool is_seen) {
        window_ = None;
        for (;;) {
            const Window found = top_window();
            if (found != None && (!is_seen || shows_something(found)) && takes_focus(found)) {
                window_ = found;
                is_there_ = true;
                return;
            }
            if (Clock::now() > deadline) {
                throw failure(found == None ? "there is no window" : "the window stays empty");
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    }

    /// Whether the window was there to answer. GLFW answers as it polls its events, so the program
    /// has then seen what came before.
    bool ping() {
        if (window_ == None) {
            throw failure("wait_for_window has not been called");
        }
        ++pings_;
        tell_window("_NET_WM_PING", pings_);
        const Clock::time_point deadline = Clock::now() + kMaxFrame;
        while (Clock::now() < deadline) {
            if (!is_there_) {
                return false;
            }
            if (XPending(display_) == 0) {
                pollfd watched{ConnectionNumber(display_), POLLIN, 0};
                poll(&watched, 1, 100);
                continue;
            }
            XEvent event;
            XNextEvent(display_, &event);
            note_end(event);
            if (event.type == ClientMessage && event.xclient.data.l[1] == pings_) {
                return true;
            }
        }
        throw failure("the program draws no frames");
    }

    /// Once this returns, the program can read all events so far: the server writes them before it
    /// looks at the second request.
    void deliver() {
        XSync(display_, False);
        XSync(display_, False);
    }

    void move(int x, int y) {
        XTestFakeMotionEvent(display_, -1, x, y, CurrentTime);
        XFlush(display_);
    }

    void button(int button, bool down) {
        XTestFakeButtonEvent(display_, static_cast<unsigned>(button), down ? True : False,
                             CurrentTime);
        XFlush(display_);
    }

    void key(unsigned code, bool down) {
        XTestFakeKeyEvent(display_, code, down ? True : False, CurrentTime);
        XFlush(display_);
    }

    [[nodiscard]] Key key_named(const std::string &name) const {
        const KeySym symbol = XStringToKeysym(name.c_str());
        if (symbol == NoSymbol) {
            throw failure("there is no key " + name);
        }
        return key_of(symbol, name);
    }

    [[nodiscard]] Key key_for(char letter) const {
        if (letter < ' ' || letter > '~') {
            throw failure("only printable ASCII can be typed");
        }
        return key_of(static_cast<KeySym>(letter), {letter}); // the two are equal for ASCII
    }

    [[nodiscard]] unsigned shift() const { return key_named("Shift_L").code; }

    /// Sends a message of window managers.
    void tell_window(const char *what, long value) {
        XEvent event{};
        event.xclient.type = ClientMessage;
        event.xclient.window = window_;
        event.xclient.message_type = XInternAtom(display_, "WM_PROTOCOLS", False);
        event.xclient.format = 32;
        event.xclient.data.l[0] = static_cast<long>(XInternAtom(display_, what, False));
        event.xclient.data.l[1] = value;
        event.xclient.data.l[2] = static_cast<long>(window_);
        XSendEvent(display_, window_, False, NoEventMask, &event);
        XFlush(display_);
    }

private:
    [[nodiscard]] Window root() const { return DefaultRootWindow(display_); }

    [[nodiscard]] Key key_of(KeySym symbol, const std::string &name) const {
        const KeyCode code = XKeysymToKeycode(display_, symbol);
        for (const bool with_shift : {false, true}) {
            if (code != 0 && XkbKeycodeToKeysym(display_, code, 0, with_shift ? 1 : 0) == symbol) {
                return {code, with_shift};
            }
        }
        throw failure("the keyboard has no key for " + name);
    }

    void note_end(const XEvent &event) {
        is_there_ = is_there_ &&
                    !(event.type == DestroyNotify && event.xdestroywindow.window == window_) &&
                    !(event.type == UnmapNotify && event.xunmap.window == window_);
    }

    /// As GLFW does it where there is no window manager.
    [[nodiscard]] bool fills_screen(const XWindowAttributes &window) const {
        const int screen = DefaultScreen(display_);
        return window.width == DisplayWidth(display_, screen) &&
               window.height == DisplayHeight(display_, screen);
    }

    /// The topmost visible window; None if there is none.
    [[nodiscard]] Window top_window() const {
        Window of_root = None;
        Window of_parent = None;
        Window *children = nullptr;
        unsigned count = 0;
        Window found = None;
        XQueryTree(display_, root(), &of_root, &of_parent, &children, &count);
        for (unsigned i = 0; i < count; ++i) {
            XWindowAttributes attributes;
            if (XGetWindowAttributes(display_, children[i], &attributes) != 0 &&
                attributes.map_state == IsViewable && attributes.c_class == InputOutput &&
                (attributes.override_redirect == False || fills_screen(attributes))) {
                found = children[i];
            }
        }
        if (children != nullptr) {
            XFree(children);
        }
        return found;
    }

    /// Whether it is not of one colour.
    /// @throw std::runtime_error  it is not at the top left of the screen
    [[nodiscard]] bool shows_something(Window window) const {
        XWindowAttributes attributes;
        if (XGetWindowAttributes(display_, window, &attributes) == 0) {
            return false;
        }
        if (attributes.x != 0 || attributes.y != 0) {
            throw failure("the window is at " + std::to_string(attributes.x) + ", " +
                          std::to_string(attributes.y) + " instead of 0, 0");
        }
        const int width = std::min(attributes.width, XDisplayWidth(display_, 0));
        const int height = std::min(attributes.height, XDisplayHeight(display_, 0));
        XImage *image = XGetImage(display_, window, 0, 0, static_cast<unsigned>(width),
                                  static_cast<unsigned>(height), AllPlanes, ZPixmap);
        if (image == nullptr) {
            return false;
        }
        const auto size =
            static_cast<std::size_t>(image->bytes_per_line) * static_cast<std::size_t>(height);
        const std::string_view bytes(image->data, size);
        // Pixels have four bytes each.
        const bool is_plain = bytes.substr(4) == bytes.substr(0, size - 4);
        XDestroyImage(image);
        return !is_plain;
    }

    [[nodiscard]] bool takes_focus(Window window) const {
        Window focused = None;
        int ignored = 0;
        XSetInputFocus(display_, window, RevertToParent, CurrentTime);
        XGetInputFocus(display_, &focused, &ignored);
        return focused == window;
    }

    Display *display_;
    Window window_ = None;
    bool is_there_ = false;
    long pings_ = 0;
};

Person::Person(const VirtualDisplay &display)
    : display_(display), connection_(std::make_unique<Connection>(display.name())) {}

Person::~Person() = default;

void Person::wait_for_window(std::chrono::duration<double> limit, bool is_seen) {
    connection_->find_window(Clock::now() + std::chrono::duration_cast<Clock::duration>(limit),
                             is_seen);
    settle();
}

void Person::wait_for_frames(int frames) {
    // The program answers the first as it takes its events, and each further one a frame later.
    for (int i = 0; i <= frames && connection_->ping(); ++i) {
    }
}

void Person::settle(int frames) {
    if (settle_) {
        connection_->deliver();
        settle_();
    } else {
        wait_for_frames(frames);
    }
}

void Person::jump_to(float x, float y) {
    connection_->move(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
}

void Person::move_to(float x, float y) {
    jump_to(x, y);
    settle();
}

void Person::press(int button) {
    connection_->button(button, true);
    settle();
}

void Person::release(int button) {
    connection_->button(button, false);
    settle();
}

void Person::click(float x, float y, int button) {
    move_to(x, y);
    click_here(button, 1);
    settle();
}

void Person::double_click(float x, float y) {
    move_to(x, y);
    // Quickly; ImGui's GLFW backend shows a click for a frame even if it was shorter.
    click_here(1, 0);
    click_here(1, 0);
    settle();
}

void Person::click_here(int button, int frames) {
    connection_->button(button, true);
    settle(frames);
    connection_->button(button, false);
    settle(frames);
}

void Person::drag(Point from, Point to, double duration_s, int button) {
    move_to(from.x, from.y);
    press(button);
    const double interval_s = (settle_ ? 2 : 1) * kMouseInterval.count();
    const int steps = std::max(1, static_cast<int>(std::lround(duration_s / interval_s)));
    Clock::time_point next = Clock::now();
    for (int i = 1; i <= steps; ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(steps);
        next += std::chrono::duration_cast<Clock::duration>(kMouseInterval);
        if (!settle_) {
            std::this_thread::sleep_until(next);
        }
        jump_to(std::lerp(from.x, to.x, share), std::lerp(from.y, to.y, share));
        if (settle_) {
            settle();
        }
    }
    settle();
    release(button);
}

void Person::wheel(float x, float y, int notches) {
    move_to(x, y);
    for (int i = 0; i < std::abs(notches); ++i) {
        // X11 has no wheel: its notches are clicks of these buttons.
        const int button = notches > 0 ? 4 : 5;
        connection_->button(button, true);
        connection_->button(button, false);
        std::this_thread::sleep_for(kMouseInterval);
    }
    settle();
}

void Person::press_key(const std::string &name) {
    connection_->key(connection_->key_named(name).code, true);
    settle();
}

void Person::release_key(const std::string &name) {
    connection_->key(connection_->key_named(name).code, false);
    settle();
}

void Person::key(const std::string &chord) {
    const std::vector<std::string> words = words_of(chord);
    const Key last = connection_->key_named(words.back());
    std::vector<unsigned> codes;
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        codes.push_back(connection_->key_named(modifier_key(words[i])).code);
    }
    if (last.with_shift) {
        codes.push_back(connection_->shift());
    }
    codes.push_back(last.code);
    for (const unsigned code : codes) {
        connection_->key(code, true);
    }
    settle(1);
    std::reverse(codes.begin(), codes.end());
    for (const unsigned code : codes) {
        connection_->key(code, false);
    }
    settle();
}

void Person::type(const std::string &text) {
    bool holds_shift = false;
    // Held for a frame before its letters, as the program samples it once per frame.
    const auto hold_shift = [&](bool down) {
        if (down != holds_shift) {
            holds_shift = down;
            connection_->key(connection_->shift(), down);
            settle(1);
        }
    };
    for (const char letter : text) {
        const Key key = connection_->key_for(letter);
        hold_shift(key.with_shift);
        connection_->key(key.code, true);
        connection_->key(key.code, false);
        std::this_thread::sleep_for(kTypingInterval);
    }
    hold_shift(false);
    settle();
}

void Person::clear_field() {
    key("ctrl+a");
    key("BackSpace");
}

void Person::drop_files(float x, float y, const std::vector<std::filesystem::path> &paths) {
    move_to(x, y);
    FileSource(display_, connection_->window(), uri_list(paths), settle_)
        .drop_at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
    settle();
}

void Person::close_window() {
    connection_->tell_window("WM_DELETE_WINDOW", CurrentTime);
    settle();
}

} // namespace springdrive::testing
