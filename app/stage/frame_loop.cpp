#include "app/stage/frame_loop.h"

#include "base/real_time_thread.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <dlfcn.h>
#include <functional>
#include <iostream>
#include <mutex>
#include <ostream>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

namespace springdrive::app {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// How far frames may lag behind the clock; a longer lag is not caught up.
constexpr std::chrono::milliseconds kMaxLag(50);

/// Whether as many frames or seconds have passed as the options allow.
bool has_reached_limit(const FrameOptions &options, int frame, double elapsed_s) {
    constexpr double kRoundOff_s = 1e-9; // of a time that is a number of frames
    return (options.frames > 0 && frame >= options.frames) ||
           (options.seconds > 0.0 && elapsed_s >= options.seconds - kRoundOff_s);
}

/// What is done when the X server goes away: by default Xlib ends the program at once, while the
/// servo runs.
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

LoadProgressPrinter::LoadProgressPrinter(std::string file, const scene::LoadProgress &progress,
                                         std::ostream &out, std::chrono::milliseconds period)
    : thread_([file = std::move(file), &progress, &out, period](const std::stop_token &stop) {
          std::mutex mutex;
          std::unique_lock lock(mutex);
          std::condition_variable_any never_notified; // a stop request ends the wait
          while (true) {
              never_notified.wait_for(lock, stop, period, [] { return false; });
              if (stop.stop_requested()) {
                  return;
              }
              out << "springdrive: " << file << ": " << progress.text() << std::endl;
          }
      }) {}

session::Session open_session(const session::SessionOptions &options) {
    if (!reserve_heaps()) {
        std::cerr << "springdrive: the heap cannot be set up; a board's packets may wait while a "
                     "scene is loaded, and memory may grow in use\n";
    }
    scene::LoadProgress progress;
    const LoadProgressPrinter printer(options.scene.filename().string(), progress, std::cerr);
    return session::Session(options, &progress); // in place: a session cannot be moved
}

void print_new_warnings(session::Session &session) {
    for (const std::string &warning : session.warnings().take_new()) {
        std::cerr << "springdrive: " << warning << '\n';
    }
}

servo::DurationHistogram run_frames(Activity &activity, session::Session &session,
                                    const FrameOptions &options) {
    ReportRequests requests(options.reports);
    const Clock::time_point start = Clock::now();
    Clock::time_point next = start;
    for (int frame = 0; !activity.is_over(); ++frame) {
        if (options.only_reported && !requests.wait()) {
            break;
        }
        const double elapsed_s =
            options.is_paced ? Seconds(Clock::now() - start).count() : frame * kFrame_s;
        if (has_reached_limit(options, frame, elapsed_s)) {
            break;
        }
        session.advance(kFrame_s);
        print_new_warnings(session);
        requests.begin_frame(activity.reported());
        activity.draw();
        requests.end_frame(activity.reported(), session.latest());
        activity.update();
        if (options.is_paced) {
            next += std::chrono::duration_cast<Clock::duration>(Seconds(kFrame_s));
            next = std::max(next, Clock::now() - kMaxLag);
            std::this_thread::sleep_until(next);
        }
    }
    return requests.durations();
}

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

} // namespace springdrive::app
