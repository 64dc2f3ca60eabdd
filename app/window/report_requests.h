// Requests for a report of what the window shows: each line "report" on standard input is answered
// by one line of JSON on standard output, after two frames have been drawn, the second of which
// shows the consequences of all input events up to the request.
#pragma once

#include <cstddef>
#include <string>

namespace springdrive::app {

class ReportRequests {
public:
    /// Waits for a request, at most a tenth of a second, unless there is one already.
    /// @return whether frames are asked for
    [[nodiscard]] bool wait();

    /// Whether nobody can ask any more.
    [[nodiscard]] bool has_ended() const { return has_ended_ && asked_ == 0; }

    /// Reads what is there, without waiting. Anything but a request is complained of on standard
    /// error. Call once per frame. @param has_input  events still wait for a frame
    void poll(bool has_input);

    /// Whether the frame that begins now will be reported.
    [[nodiscard]] bool is_due() const { return asked_ > 0 && frames_ >= kFrames; }

    /// Call after the frame; prints an answer for each request if it was due.
    void answer(const std::string &line);

private:
    void take_in(int wait_ms);

    static constexpr int kFrames = 2;

    std::string read_; ///< incomplete line
    std::size_t asked_ = 0;
    int frames_ = 0; ///< begun since the last request
    bool has_ended_ = false;
};

} // namespace springdrive::app
