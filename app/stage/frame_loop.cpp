#include "app/stage/frame_loop.h"

#include "app/stage/open_session.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace springdrive::app {

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

} // namespace

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
        if ((options.frames > 0 && frame >= options.frames) ||
            (options.seconds > 0.0 && elapsed_s >= options.seconds - 1e-9)) {
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
            next = std::max(next, Clock::now() - std::chrono::milliseconds(50));
            std::this_thread::sleep_until(next);
        }
    }
    return requests.durations();
}

} // namespace springdrive::app
