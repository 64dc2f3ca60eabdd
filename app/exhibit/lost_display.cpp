#include "app/exhibit/lost_display.h"

#include <cstdlib>
#include <dlfcn.h>
#include <iostream>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

std::function<void()> &wishes() {
    static std::function<void()> the_last;
    return the_last;
}

extern "C" int on_lost_display(void * /*display*/) {
    if (const std::function<void()> last = std::exchange(wishes(), {})) {
        last();
    }
    std::cerr << "springdrive: the display is lost: its X server has ended; start springdrive "
                 "again once it is back\n";
    std::_Exit(kLostDisplay); // what belongs to the display cannot be released any more
}

} // namespace

void end_well_without_display(std::function<void()> last_wishes) {
    // GLFW has loaded it, where it draws on X11. Not to be linked: there may be none.
    void *const xlib = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
    if (xlib == nullptr) {
        return;
    }
    using Handler = int (*)(void *);
    using Setter = Handler (*)(Handler);
    if (const auto set = reinterpret_cast<Setter>(dlsym(xlib, "XSetIOErrorHandler"))) {
        wishes() = std::move(last_wishes);
        set(on_lost_display);
    }
    dlclose(xlib);
}

} // namespace springdrive::app::exhibit
