#include "app/study/participant/input_times.h"

#include <chrono>
#include <limits>

namespace springdrive::app::study_screen {

double steady_clock_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// This thread may be held up between readings of the two clocks: those closest to each other
/// count.
double servo_ahead_s(const session::ServoRun &servo) {
    constexpr int kReadings = 5;
    double shortest_s = std::numeric_limits<double>::infinity();
    double ahead_s = 0.0;
    for (int i = 0; i < kReadings; ++i) {
        const double before_s = steady_clock_s();
        const double now_s = servo.now_s();
        const double after_s = steady_clock_s();
        if (after_s - before_s < shortest_s) {
            shortest_s = after_s - before_s;
            ahead_s = now_s - 0.5 * (before_s + after_s);
        }
    }
    return ahead_s;
}

void tell_by_servo(std::vector<ParticipantInput> &inputs, const session::ServoRun &servo) {
    const double ahead_s = servo_ahead_s(servo);
    for (ParticipantInput &input : inputs) {
        input.clock_s = servo.is_in_lockstep() ? servo.now_s() : input.clock_s + ahead_s;
    }
}

} // namespace springdrive::app::study_screen
