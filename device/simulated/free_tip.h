// A tip connected to the end of the linkage by a compliant structure: a mass behind a spring and a
// damper, moved by a hand.
//
// Over a step, with s the stretch at its start, ẋ̄ and ē the mean velocities of tip and linkage end,
// and k_e = c + hk/2 of the structure:
//
//   m (ẋ₁ − ẋ₀)/h = F_hand − b_hand ẋ̄ − F       F = k s + k_e (ẋ̄ − ē)
//
// so the spring acts with its mean stretch, and its work over the step is exact.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"

namespace springdrive::simulated {

/// A force that is affine in the mean velocity of the body it acts on: F − b v̄.
struct VelocityLoad {
    Vector3 force_N{Vector3::Zero()};
    double damping_Ns_per_m = 0.0;
};

struct FreeTip {
    device::StructuralCompliance structure;
    double mass_kg = 0.0;
    Vector3 position_m{Vector3::Zero()};
    Vector3 velocity_m_per_s{Vector3::Zero()};

    /// The part of the tip's load that acts on the linkage's end, with ẋ̄ eliminated. RT-safe.
    [[nodiscard]] VelocityLoad at_linkage(const VelocityLoad &hand, const Vector3 &linkage_end_m,
                                          double step_s) const {
        const Vector3 spring = structure.stiffness_N_per_m * (position_m - linkage_end_m);
        const double share = coupling(step_s) / impedance(hand, step_s);
        return {spring + share * (momentum_rate(step_s) + hand.force_N - spring),
                coupling(step_s) * (1.0 - share)};
    }

    /// Advances the tip over the step, given the motion of the linkage's end. RT-safe.
    void settle(const VelocityLoad &hand, const Vector3 &linkage_end_before_m,
                const Vector3 &mean_end_velocity_m_per_s, double step_s) {
        const Vector3 spring = structure.stiffness_N_per_m * (position_m - linkage_end_before_m);
        const Vector3 mean = (momentum_rate(step_s) + hand.force_N - spring +
                              coupling(step_s) * mean_end_velocity_m_per_s) /
                             impedance(hand, step_s);
        position_m += step_s * mean;
        velocity_m_per_s = 2.0 * mean - velocity_m_per_s;
    }

    [[nodiscard]] double energy_J(const Vector3 &linkage_end_m) const {
        return 0.5 * structure.stiffness_N_per_m * (position_m - linkage_end_m).squaredNorm() +
               0.5 * mass_kg * velocity_m_per_s.squaredNorm();
    }

private:
    [[nodiscard]] double coupling(double step_s) const {
        return structure.damping_Ns_per_m + 0.5 * step_s * structure.stiffness_N_per_m;
    }
    [[nodiscard]] double impedance(const VelocityLoad &hand, double step_s) const {
        return 2.0 * mass_kg / step_s + hand.damping_Ns_per_m + coupling(step_s);
    }
    [[nodiscard]] Vector3 momentum_rate(double step_s) const {
        return 2.0 * mass_kg / step_s * velocity_m_per_s;
    }
};

} // namespace springdrive::simulated
