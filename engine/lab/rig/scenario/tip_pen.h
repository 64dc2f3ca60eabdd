// Generates the path of a tip that moves at constant speed.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace springdrive::rig {

/// Adds a tip after each `step_m` of a path of straight pieces, up to a given number.
class TipPen {
public:
    /// @pre step_m > 0
    TipPen(double step_m, std::size_t tips) : step_m_(step_m), wanted_(tips) {
        SPRINGDRIVE_ASSERT(step_m > 0.0);
        tips_m_.reserve(tips);
    }

    /// Adds a tip at this point, at any distance.
    void leap_to(const Vector3 &point_m) {
        at_m_ = point_m;
        left_m_ = step_m_;
        if (!is_full()) {
            tips_m_.push_back(point_m);
        }
    }

    /// Straight on. Corners are passed, not stopped at.
    void draw_to(const Vector3 &point_m) {
        const Vector3 way = point_m - at_m_;
        const double length_m = way.norm();
        for (; left_m_ <= length_m && !is_full(); left_m_ += step_m_) {
            tips_m_.emplace_back(at_m_ + left_m_ / length_m * way);
        }
        left_m_ -= length_m;
        at_m_ = point_m;
    }

    [[nodiscard]] bool is_full() const { return tips_m_.size() >= wanted_; }
    [[nodiscard]] const Vector3 &at_m() const { return at_m_; }

    /// The tips; where the path was too short, the last is repeated.
    /// @pre there is at least one
    [[nodiscard]] std::vector<Vector3> take() {
        SPRINGDRIVE_ASSERT(!tips_m_.empty());
        tips_m_.resize(wanted_, Vector3(tips_m_.back()));
        return std::move(tips_m_);
    }

private:
    double step_m_;
    std::size_t wanted_;
    std::vector<Vector3> tips_m_;
    Vector3 at_m_{Vector3::Zero()};
    double left_m_ = 0.0; ///< to the next tip
};

} // namespace springdrive::rig
