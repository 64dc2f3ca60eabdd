#include "app/demo/demo.h"

#include "app/demo/screen.h"
#include "app/host/output.h"
#include "app/host/process.h"
#include "app/host/software_renderer.h"
#include "app/stage/frame_loop.h"
#include "base/print.h"
#include "engine/session/session.h"

#include <cstdlib>
#include <iostream>

namespace springdrive::app {

namespace {

void print_frames(const servo::DurationHistogram &frames) {
    print(std::cout, "window: {} frames, median {:.1f} ms, 99 % {:.1f} ms, longest {:.1f} ms\n",
          frames.count(), 1e3 * frames.quantile_s(0.5), 1e3 * frames.quantile_s(0.99),
          1e3 * frames.longest_s());
}

void print_load(const FrameLoad &load) {
    print(std::cout, "view: {} draw calls, {} triangles and lines, {} samples drawn in a frame\n",
          load.draw_calls, load.primitives, load.samples);
}

/// Whether it is to be started again.
bool finish_kiosk(Screen &screen) {
    exhibit::Kiosk *const kiosk = screen.kiosk();
    if (kiosk == nullptr) {
        return false;
    }
    const bool starts_again = kiosk->ending() == exhibit::KioskEnding::start_again;
    if (starts_again) {
        std::cerr << "springdrive: the kiosk was stopped by a failed assertion, which only a new "
                     "start clears; start it again\n";
    }
    kiosk->finish(starts_again                                     ? "only a new start helps"
                  : kiosk->ending() == exhibit::KioskEnding::asked ? "by Ctrl+Alt+Q"
                  : asked_to_end()                                 ? "by a signal"
                                                                   : "its time is over");
    return starts_again;
}

} // namespace

int run_demo(const DemoOptions &options) {
    if (options.kiosk) {
        draw_without_threads(); // days count more than frames
    }
    session::Session session = open_session(options.session);
    Screen screen(options, session);
    note_ending_signals();
    end_well_without_display([&] {
        session.stop();
        if (screen.kiosk() != nullptr) {
            screen.kiosk()->finish("the display is lost");
        }
    });
    session.start();
    print_new_warnings(session);
    const servo::DurationHistogram frames = run_frames(screen, session,
                                                       {.frames = options.frames,
                                                        .seconds = options.seconds,
                                                        .reports = options.reports,
                                                        .only_reported = options.is_stepped(),
                                                        .is_paced = !options.session.lockstep});
    end_well_without_display({});
    session.stop();
    const bool starts_again = finish_kiosk(screen);
    const std::string unkept = screen.finish();
    if (!unkept.empty()) {
        std::cerr << "springdrive: the session was not kept completely: " << unkept << '\n';
    }
    if (!options.screenshot.empty()) {
        write_output(
            options.screenshot.string(),
            [&](std::ostream &out) { screen.window().write_screenshot(out); }, options.existing);
    }
    if (options.unattended()) {
        session::write_session_report(std::cout, session);
        print_frames(frames);
        print_load(screen.frame_load());
        if (!options.screenshot.empty()) {
            std::cout << "screenshot: " << options.screenshot.string() << '\n';
        }
    }
    // An attended run shows the stop in its window.
    const bool stopped = options.unattended() && session::was_stopped(session, std::cerr);
    const bool is_well = session::record_is_whole(session, std::cerr) && !stopped && unkept.empty();
    return starts_again ? exhibit::kStartAgain : is_well ? 0 : 1;
}

} // namespace springdrive::app
