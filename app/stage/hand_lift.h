// Moves the simulated hand's target evenly out of the surface, when a message's button asks for it.
#pragma once

#include "engine/session/session.h"

namespace springdrive::app {

class HandLift {
public:
    void start() { left_m_ = kClear_m; }
    void stop() { left_m_ = 0.0; }
    [[nodiscard]] bool is_on() const { return left_m_ > 0.0; }

    /// Once a frame: along the normal while the tip touches, else upwards, until the tip is clear
    /// of the surface by some distance, or the hand cannot get further.
    /// @param is_inside  whether the tip lies in a solid
    void update(session::Session &session, bool is_inside, double frame_s);

private:
    static constexpr double kSpeed_m_per_s = 0.06;
    static constexpr double kClear_m = 0.01;

    double left_m_ = 0.0; ///< to go in free space; 0: it is off
};

} // namespace springdrive::app
