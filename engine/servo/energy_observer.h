// A passivity observer on the rendered port: what the hand gets out of a contact beyond what it has
// put in [Hannaford and Ryu 2002].
//
// Over a tick the tip moves by Δx against the rendered force F, and the spring behind the set-point
// comes to hold ΔS more. What was then made from nothing is
//
//   ΔG = F̄·Δx + ΔS,      F̄ the mean of F at both ends
//
// A passive contact has ΔG ≤ 0. Credit is soon forgotten, so that a long slide against friction
// excuses nothing: G decays with kMemory_s, and is never below minus the limit.
#pragma once

#include "base/vector.h"

#include <algorithm>
#include <cmath>

namespace springdrive {

/// What a spring holds [J] of whose force only a share is let through: ½ F·d for all of it. For
/// less, it is taken as one that gives way at the force let through: F up to there, constant
/// beyond.
[[nodiscard]] inline double spring_energy_J(const Vector3 &force_N, const Vector3 &stretch_m,
                                            double share) {
    return 0.5 * force_N.dot(stretch_m) * share * (2.0 - share);
}

class EnergyObserver {
public:
    static constexpr double kMemory_s = 0.5;

    explicit EnergyObserver(double period_s) : decay_(std::exp(-period_s / kMemory_s)) {}

    /// Starts anew.
    void reset() noexcept {
        knows_before_ = false;
        generated_J_ = 0.0;
    }

    /// The spring was changed, not stretched: what it holds now counts as held before. For the
    /// tick of the next `update`.
    void spring_changed() noexcept { spring_changed_ = true; }

    /// RT-safe.
    void update(const Vector3 &tip_m, const Vector3 &force_N, double stored_J,
                double limit_J) noexcept {
        if (knows_before_) {
            const double work_J = 0.5 * (force_N + force_N_).dot(tip_m - tip_m_);
            const double stretched_J = spring_changed_ ? 0.0 : stored_J - stored_J_;
            generated_J_ = std::max(decay_ * generated_J_ + work_J + stretched_J, -limit_J);
        }
        knows_before_ = true;
        spring_changed_ = false;
        tip_m_ = tip_m;
        force_N_ = force_N;
        stored_J_ = stored_J;
    }

    [[nodiscard]] double generated_J() const { return generated_J_; }

private:
    double decay_;
    bool knows_before_ = false;
    bool spring_changed_ = false;
    double generated_J_ = 0.0;
    Vector3 tip_m_{Vector3::Zero()};
    Vector3 force_N_{Vector3::Zero()};
    double stored_J_ = 0.0;
};

} // namespace springdrive
