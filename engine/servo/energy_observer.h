// A passivity observer at the rendered port: the energy that the hand receives from a contact
// beyond what it has put in [Hannaford and Ryu 2002].
//
// Over a tick the tip moves by Δx against the rendered force F, and the motion changes the energy
// of the spring behind the set-point by ΔS. The energy generated is then
//
//   ΔG = F̄·Δx + ΔS,      F̄ the mean of F at start and end
//
// A passive contact has ΔG ≤ 0. The spring's energy is known only from a model, whose errors must
// not cause a trip: the energy counted as stored rises by no more than the hand puts in, and falls
// by no more than the hand receives. Energy that appears in the spring by itself therefore counts
// as generated once the hand receives it. Dissipated energy is soon forgotten, so that a long slide
// against friction does not mask later generation: G decays with kMemory_s, and is never below
// minus the limit.
#pragma once

#include "base/vector.h"

#include <algorithm>
#include <cmath>

namespace springdrive::servo {

/// Energy of a spring [J] of whose force only a share is passed on: ½ F·d for the whole force. For
/// less, it is modelled as a spring that yields at the force passed on: linear up to it, constant
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

    /// Starts again without memory.
    void reset() noexcept {
        has_previous_ = false;
        generated_J_ = 0.0;
    }

    /// @param stored_J   energy of the spring
    /// @param changed_J  the part due to a change of tuning at this tick, not to motion
    /// RT-safe.
    void update(const Vector3 &tip_m, const Vector3 &force_N, double stored_J, double changed_J,
                double limit_J) noexcept {
        if (has_previous_) {
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
        has_previous_ = true;
        tip_m_ = tip_m;
        force_N_ = force_N;
        stored_J_ = stored_J;
    }

    /// The spring's energy at the last update.
    [[nodiscard]] double stored_J() const { return stored_J_; }
    [[nodiscard]] double generated_J() const { return generated_J_; }

private:
    double decay_ = 0.0;
    bool has_previous_ = false;
    double generated_J_ = 0.0;
    Vector3 tip_m_{Vector3::Zero()};
    Vector3 force_N_{Vector3::Zero()};
    double stored_J_ = 0.0; ///< of the spring, by the model
    double held_J_ = 0.0;   ///< the part of it that the hand put in
};

} // namespace springdrive::servo
