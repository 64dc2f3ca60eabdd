// Opens a session, printing the progress of its scene; runs the frames of an activity in one
// window, in two, or in none; and ends well if their display is lost.
//
//   session.advance ──► Activity::draw ──► report, if one is requested ──► Activity::update
#pragma once

#include "app/window/report_requests.h"
#include "engine/scene/load_messages.h"
#include "engine/session/session.h"

#include <chrono>
#include <functional>
#include <iosfwd>
#include <string>
#include <thread>

namespace springdrive::app {

/// Prints "springdrive: big.glb: gathering triangles, 40 %" once per period while it exists, first
/// after one period: faster loading prints nothing.
class LoadProgressPrinter {
public:
    /// @param progress  must outlive it, as must `out`
    LoadProgressPrinter(std::string file, const scene::LoadProgress &progress, std::ostream &out,
                        std::chrono::milliseconds period = std::chrono::seconds(1));

private:
    std::jthread thread_; ///< its destructor requests a stop, and joins it
};

/// Opens a session, with a LoadProgressPrinter on standard error while its scene is loaded.
/// @throw InputError as Session's constructor does
[[nodiscard]] session::Session open_session(const session::SessionOptions &options);

/// Prints each warning once, to standard error.
void print_new_warnings(session::Session &session);

/// The exit status of a program that lost its display.
inline constexpr int kLostDisplay = 4;

/// From now on, `last_wishes` is called when the display is lost; then the program ends with one
/// line on standard error and kLostDisplay. Does nothing with another windowing system.
/// @pre a window is open
void end_well_without_display(std::function<void()> last_wishes);

/// The time by which a frame advances a session.
inline constexpr double kFrame_s = 1.0 / 60.0;

/// What runs frame by frame: a demonstration, a study, an exhibit.
class Activity {
public:
    Activity() = default;
    virtual ~Activity() = default;
    Activity(const Activity &) = delete;
    Activity &operator=(const Activity &) = delete;

    [[nodiscard]] virtual bool is_over() const = 0;
    /// Draws the next frame in its windows, and collects their input.
    virtual void draw() {}
    /// Acts on the input of that frame.
    virtual void update() {}
    [[nodiscard]] virtual ReportedWindow reported() const { return {}; }
};

struct FrameOptions {
    int frames = 0;             ///< ends after so many; 0: no limit
    double seconds = 0.0;       ///< the same, after this time
    bool reports = false;       ///< answers requests on standard input, see ReportRequests
    bool only_reported = false; ///< there are no frames but those that requests ask for
    /// Sixty frames a second by the clock. Otherwise the time is the number of frames times
    /// kFrame_s, and the activity's windows may wait for their display.
    bool is_paced = false;
};

/// Runs frames until the activity or the options' time is over, or, with `only_reported`, until no
/// request can come any more.
/// @return the time to compute, draw and show a frame; a display with vertical synchronisation adds
///         its wait
servo::DurationHistogram run_frames(Activity &activity, session::Session &session,
                                    const FrameOptions &options);

} // namespace springdrive::app
