// Detects when the tip has been at rest in free space, the condition for enabling the motors.
#pragma once

#include "base/vector.h"

namespace springdrive::servo {

class RestDetector {
public:
    /// At rest means within kNear_m of one place for kTime_s.
    static constexpr double kNear_m = 1e-3;
    static constexpr double kTime_s = 0.1;

    explicit RestDetector(double period_s) : period_s_(period_s) {}

    void set_period(double period_s) noexcept { period_s_ = period_s; }

    void reset() noexcept { rested_s_ = 0.0; }

    /// Advances by one tick. RT-safe.
    void update(const Vector3 &tip_m, bool touching) noexcept {
        const bool stays = (tip_m - place_m_).norm() <= kNear_m; // false if not finite
        if (touching || !stays) {
            place_m_ = tip_m;
            rested_s_ = 0.0;
            return;
        }
        rested_s_ += period_s_;
    }

    [[nodiscard]] bool is_at_rest() const { return rested_s_ >= kTime_s; }

private:
    double period_s_;
    double rested_s_ = 0.0;
    Vector3 place_m_{Vector3::Zero()};
};

} // namespace springdrive::servo
