#include "app/demo.h"

#include "app/commands/output_files.h"
#include "app/ending_signal.h"
#include "app/frame_pace.h"
#include "app/open_session.h"
#include "app/screen.h"
#include "base/print.h"
#include "engine/session/session_report.h"

#include <iostream>

namespace springdrive::app {

namespace {

/// Until the window is closed, the frames are over, or termination is requested.
void play(const DemoOptions &options, session::Session &session, Screen &screen) {
    FramePace pace;
    const bool lockstep = options.session.lockstep;
    for (int frame = 0; !asked_to_end() && !screen.window().is_closing(); ++frame) {
        const double elapsed_s = lockstep ? frame * kFrame_s : pace.elapsed_s();
        if ((options.frames > 0 && frame >= options.frames) ||
            (options.seconds > 0.0 && elapsed_s >= options.seconds - 1e-9)) {
            return;
        }
        session.advance(kFrame_s);
        print_new_remarks(session);
        screen.draw_frame();
        if (!lockstep) {
            pace.wait();
        }
    }
}

void print_frames(const servo::DurationHistogram &frames) {
    print(std::cout, "window: {} frames, median {:.1f} ms, 99 % {:.1f} ms, longest {:.1f} ms\n",
          frames.count(), 1e3 * frames.quantile_s(0.5), 1e3 * frames.quantile_s(0.99),
          1e3 * frames.longest_s());
}

} // namespace

bool run_demo(const DemoOptions &options) {
    session::Session session = open_session(options.session);
    Screen screen(options, session);
    note_ending_signals();
    session.start();
    print_new_remarks(session);
    play(options, session, screen);
    session.stop();
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
        print_frames(screen.frame_durations());
        if (!options.screenshot.empty()) {
            std::cout << "screenshot: " << options.screenshot.string() << '\n';
        }
    }
    // An attended run shows the stop in its window.
    const bool stopped = options.unattended() && session::was_stopped(session, std::cerr);
    return session::record_is_whole(session, std::cerr) && !stopped && unkept.empty();
}

} // namespace springdrive::app
