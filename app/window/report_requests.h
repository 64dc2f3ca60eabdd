// Requests for a report of what the window shows: each line "report" on standard input is answered
// by one line of JSON on standard output, after two frames have been drawn, the second of which
// shows the consequences of all input events up to the request.
#pragma once

#include "app/window/window.h"
#include "engine/servo/servo_sample.h"
#include "engine/servo/servo_timing.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

namespace springdrive::app {

/// The window whose frames are reported.
struct ReportedWindow {
    GlWindow::Size size;
    float scale = 1.0F;             ///< of text and panels
    bool has_waiting_input = false; ///< for a later frame
};

class ReportRequests {
public:
    /// @param are_read  else there are none
    explicit ReportRequests(bool are_read) : are_read_(are_read) {}

    /// Waits until a request asks for frames, or the program is asked to end. False once nobody can
    /// ask any more.
    [[nodiscard]] bool wait();

    /// Before a frame takes its events, so that the answer follows all that came before it. Reads
    /// what is there, without waiting, and reports an error of anything but a request on standard
    /// error. `ui::report()` is wanted afterwards if the frame will be reported.
    void begin_frame(const ReportedWindow &window);

    /// After the frame; prints an answer for each request if it was due.
    void end_frame(const ReportedWindow &window, const servo::ServoSample &latest);

    /// Time to compute, draw and show a frame; a display with vertical synchronisation adds its
    /// wait.
    [[nodiscard]] const servo::DurationHistogram &durations() const { return durations_; }

private:
    void take_in(int wait_ms);

    static constexpr int kFrames = 2;

    bool are_read_;
    std::uint64_t frame_ = 0;
    std::chrono::steady_clock::time_point begun_; ///< the frame
    servo::DurationHistogram durations_;
    std::string read_; ///< incomplete line
    std::size_t asked_ = 0;
    int frames_ = 0; ///< begun since the last request
    bool has_ended_ = false;
};

} // namespace springdrive::app
