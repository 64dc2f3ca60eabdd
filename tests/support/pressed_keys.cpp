#include "tests/support/pressed_keys.h"

#include <map>
#include <stdexcept>

// Last: these define macros such as None and Bool.
#include <X11/Xlib.h>
#include <X11/extensions/XTest.h>

namespace springdrive::testing {

struct PressedKeys::Connection {
    Display *display;

    /// Those that are seen, by title.
    [[nodiscard]] std::map<std::string, Window> windows() const {
        Window of_root = None;
        Window of_parent = None;
        Window *children = nullptr;
        unsigned count = 0;
        std::map<std::string, Window> found;
        XQueryTree(display, DefaultRootWindow(display), &of_root, &of_parent, &children, &count);
        for (unsigned i = 0; i < count; ++i) {
            char *name = nullptr;
            XWindowAttributes attributes;
            if (XFetchName(display, children[i], &name) != 0 &&
                XGetWindowAttributes(display, children[i], &attributes) != 0 &&
                attributes.map_state == IsViewable) {
                found[name] = children[i];
            }
            if (name != nullptr) {
                XFree(name);
            }
        }
        if (children != nullptr) {
            XFree(children);
        }
        return found;
    }

    /// None if there is no window of that title.
    [[nodiscard]] Window window(const std::string &title) const {
        const std::map<std::string, Window> all = windows();
        const auto found = all.find(title);
        return found == all.end() ? None : found->second;
    }
};

PressedKeys::PressedKeys(const std::string &display)
    : connection_(std::make_unique<Connection>(Connection{XOpenDisplay(display.c_str())})) {
    if (connection_->display == nullptr) {
        throw std::runtime_error("no display " + display);
    }
}

PressedKeys::~PressedKeys() { XCloseDisplay(connection_->display); }

void PressedKeys::tap(const std::string &key) {
    const KeyCode code = XKeysymToKeycode(connection_->display, XStringToKeysym(key.c_str()));
    if (code == 0) {
        throw std::runtime_error("the keyboard has no key " + key);
    }
    XTestFakeKeyEvent(connection_->display, code, True, CurrentTime);
    XTestFakeKeyEvent(connection_->display, code, False, CurrentTime);
    XSync(connection_->display, False);
}

void PressedKeys::click(int x, int y, int which) {
    move_to(x, y);
    button(which, true);
    button(which, false);
}

void PressedKeys::move_to(int x, int y) {
    XTestFakeMotionEvent(connection_->display, -1, x, y, CurrentTime);
    XSync(connection_->display, False);
}

void PressedKeys::button(int button, bool is_down) {
    XTestFakeButtonEvent(connection_->display, static_cast<unsigned>(button),
                         is_down ? True : False, CurrentTime);
    XSync(connection_->display, False);
}

bool PressedKeys::move_window(const std::string &title, int x, int y) {
    const Window window = connection_->window(title);
    if (window != None) {
        XMoveWindow(connection_->display, window, x, y);
        XSync(connection_->display, False);
    }
    return window != None;
}

void PressedKeys::resize_window(const std::string &title, int width, int height) {
    if (const Window window = connection_->window(title); window != None) {
        XResizeWindow(connection_->display, window, static_cast<unsigned>(width),
                      static_cast<unsigned>(height));
        XSync(connection_->display, False);
    }
}

void PressedKeys::focus(const std::string &title) {
    if (const Window window = connection_->window(title); window != None) {
        XSetInputFocus(connection_->display, window, RevertToParent, CurrentTime);
        XSync(connection_->display, False);
    }
}

std::set<std::string> PressedKeys::window_titles() const {
    std::set<std::string> titles;
    for (const auto &[title, window] : connection_->windows()) {
        titles.insert(title);
    }
    return titles;
}

} // namespace springdrive::testing
