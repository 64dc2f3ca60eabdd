// A passivity observer on the rendered port: what the hand gets out of a contact beyond what it has
// put in [Hannaford and Ryu 2002].
//
// Over a tick the tip moves by Δx against the rendered force F, and the motion stretches the spring
// behind the set-point by ΔS. What was then made from nothing is
//
//   ΔG = F̄·Δx + ΔS,      F̄ the mean of F at both ends
//
// A passive contact has ΔG ≤ 0. What the spring holds is known from a model only, whose errors must
// accuse nobody: what counts as held rises by no more than the hand puts in, and falls by no more
// than it gets. So a spring that comes to hold more by itself accuses whoever made it, once it
// gives that to the hand. Credit is soon forgotten, so that a long slide against friction excuses
// nothing: G decays with kMemory_s, and is never below minus the limit.
#pragma once

#include "base/vector.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

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

    explicit EnergyObserver(double period_s) { set_period(period_s); }

    void set_period(double period_s) noexcept { decay_ = std::exp(-period_s / kMemory_s); }

    /// Starts anew.
    void reset() noexcept {
        knows_before_ = false;
        generated_J_ = 0.0;
    }

    /// @param stored_J   what the spring holds
    /// @param changed_J  of that, what a change of tuning made of it at this tick, not a motion
    /// RT-safe.
    void update(const Vector3 &tip_m, const Vector3 &force_N, double stored_J, double changed_J,
                double limit_J) noexcept {
        if (knows_before_) {
            const double work_J = 0.5 * (force_N + force_N_).dot(tip_m - tip_m_);
            const double stretched_J = std::clamp(stored_J - changed_J - stored_J_,
                                                  -std::max(0.0, work_J), std::max(0.0, -work_J));
            const double before_J = std::max(0.0, held_J_ + changed_J);
            held_J_ = std::clamp(before_J + stretched_J, 0.0, std::max(0.0, stored_J));
            generated_J_ =
                std::max(decay_ * generated_J_ + work_J + (held_J_ - before_J), -limit_J);
        } else {
            held_J_ = stored_J;
        }
        knows_before_ = true;
        tip_m_ = tip_m;
        force_N_ = force_N;
        stored_J_ = stored_J;
    }

    /// What the spring held at the last update.
    [[nodiscard]] double stored_J() const { return stored_J_; }
    [[nodiscard]] double generated_J() const { return generated_J_; }

private:
    double decay_ = 0.0;
    bool knows_before_ = false;
    double generated_J_ = 0.0;
    Vector3 tip_m_{Vector3::Zero()};
    Vector3 force_N_{Vector3::Zero()};
    double stored_J_ = 0.0; ///< by the model
    double held_J_ = 0.0;   ///< of that, what the hand put in
};

} // namespace springdrive::servo
