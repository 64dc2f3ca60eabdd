// Opens a session, with progress shown on a terminal; and the loop of frames of all that lasts: in
// one window, in two, or in none.
//
//   session.advance ──► Activity::draw ──► report, if one is requested ──► Activity::update
#pragma once

#include "app/window/report_requests.h"
#include "engine/scene/load_messages.h"
#include "engine/session/session.h"

#include <chrono>
#include <iosfwd>
#include <string>
#include <thread>

namespace springdrive::app {

/// Prints "springdrive: big.glb: gathering triangles, 40 %" once per period while it exists, first
/// after one period: faster loading prints nothing.
class LoadLines {
public:
    /// @param progress and `out` must outlive it
    LoadLines(std::string file, const scene::LoadProgress &progress, std::ostream &out,
              std::chrono::milliseconds period = std::chrono::seconds(1));

private:
    std::jthread thread_; ///< asked to end, and joined, on destruction
};

/// Prints progress lines to standard error while its scene loads, if that takes long.
/// @throw InputError as Session's constructor does
[[nodiscard]] session::Session open_session(const session::SessionOptions &options);

/// Prints each warning once, to standard error.
void print_new_warnings(session::Session &session);

inline constexpr double kFrame_s = 1.0 / 60.0; ///< by which a session is advanced

class Activity {
public:
    Activity() = default;
    virtual ~Activity() = default;
    Activity(const Activity &) = delete;
    Activity &operator=(const Activity &) = delete;

    [[nodiscard]] virtual bool is_over() const = 0;
    /// Shows the next frame in its windows, and takes what is done there.
    virtual void draw() {}
    /// Goes on by what was done in that frame.
    virtual void update() {}
    [[nodiscard]] virtual ReportedWindow reported() const { return {}; }
};

struct FrameOptions {
    int frames = 0;             ///< ends after so many; 0: no limit
    double seconds = 0.0;       ///< the same, after this time
    bool reports = false;       ///< answers requests on standard input, see ReportRequests
    bool only_reported = false; ///< there are no frames but those that requests ask for
    /// Sixty frames a second by the clock; else time is that of frames, and the activity's windows
    /// may wait for their display.
    bool is_paced = false;
};

/// Until the activity or the options' time is over, or nobody can ask for frames any more.
/// @return the time to compute, draw and show a frame; a display with vertical synchronisation adds
///         its wait
servo::DurationHistogram run_frames(Activity &activity, session::Session &session,
                                    const FrameOptions &options);

} // namespace springdrive::app
