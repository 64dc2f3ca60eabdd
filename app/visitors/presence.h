// Whether a visitor is still there: somebody who acts, or moves the tip of a real device.
#pragma once

#include "base/vector.h"

#include <optional>

namespace springdrive::app::visitors {

inline constexpr double kAskedAfter_s = 30.0; ///< without a sign of anybody: "Still there?"
inline constexpr double kGoneAfter_s = 40.0;

class Presence {
public:
    explicit Presence(double now_s = 0.0) : seen_s_(now_s) {}

    /// Once a frame. @param tip_m  of a real device; nothing of one whose hand is simulated
    void update(double now_s, bool has_acted, const std::optional<Vector3> &tip_m) {
        const bool has_moved = tip_m && (!tip_m_ || (*tip_m - *tip_m_).norm() > kMove_m);
        if (has_moved) {
            tip_m_ = tip_m;
        }
        if (has_acted || has_moved) {
            seen_s_ = now_s;
        }
    }
    [[nodiscard]] double away_s(double now_s) const { return now_s - seen_s_; }

private:
    static constexpr double kMove_m = 0.003; ///< more than a device that lies still drifts

    double seen_s_;
    std::optional<Vector3> tip_m_; ///< where it was when it was moved last
};

} // namespace springdrive::app::visitors
