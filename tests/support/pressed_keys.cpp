#include "tests/support/pressed_keys.h"

#include <stdexcept>

// Last: these define macros such as None and Bool.
#include <X11/Xlib.h>
#include <X11/extensions/XTest.h>

namespace springdrive::testing {

struct PressedKeys::Connection {
    Display *display;
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

void PressedKeys::click(int x, int y, int button) {
    XTestFakeMotionEvent(connection_->display, -1, x, y, CurrentTime);
    XTestFakeButtonEvent(connection_->display, static_cast<unsigned>(button), True, CurrentTime);
    XTestFakeButtonEvent(connection_->display, static_cast<unsigned>(button), False, CurrentTime);
    XSync(connection_->display, False);
}

} // namespace springdrive::testing
