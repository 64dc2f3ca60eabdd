// The plant with real Coulomb friction, by CVODE from one change of sticking and sliding to the
// next: the reference of the chart of integrators under friction.
//
// Between two changes the plant is smooth: a joint slides one way, and friction takes τ_c from it,
// or it sticks, and friction takes what holds it. CVODE's root finder tells when a sliding joint
// comes to rest or a sticking one needs more than τ_c. What the joints at rest then do is the one
// choice that goes with itself: those that stick need no more than τ_c, those that begin to slide
// are accelerated the way that they slide.
#pragma once

#include "engine/lab/charts/cvode_method.h"
#include "engine/lab/rig/plant_equations.h"

#include <array>
#include <memory>

namespace springdrive::charts {

/// What a joint does: +1 and -1 where it slides forward or backward, 0 where it sticks.
using StickSlipModes = std::array<int, 3>;

/// q̈ under real friction, and what friction brings to hold the joints that stick.
struct StickSlipMotion {
    Vector3 acceleration_rad_per_s2{Vector3::Zero()};
    Vector3 holding_Nm{Vector3::Zero()};
};

[[nodiscard]] StickSlipMotion stick_slip_motion(const rig::PlantMechanics &mechanics,
                                                const Vector3 &coulomb_Nm,
                                                const StickSlipModes &modes);

/// What joints do that move at these rates. What is at rest, to the last bit, does what goes with
/// itself; a joint that is `released` slides.
[[nodiscard]] StickSlipModes stick_slip_modes(const rig::PlantMechanics &mechanics,
                                              const Vector3 &coulomb_Nm,
                                              const Vector3 &rate_rad_per_s,
                                              const std::array<bool, 3> &released);

class StickSlipSolver {
public:
    /// As CvodeSolver.
    StickSlipSolver(CvodeMethod method, double relative_tolerance);
    ~StickSlipSolver();
    StickSlipSolver(const StickSlipSolver &) = delete;
    StickSlipSolver &operator=(const StickSlipSolver &) = delete;

    /// y at `end_s`, from `y` at `start_s`. Joints that stick at the end have a rate of exactly 0.
    /// @throw std::runtime_error where CVODE gives up, or changes do not come to an end
    [[nodiscard]] rig::PlantState advance(const rig::PlantEquations &equations, double start_s,
                                          double end_s, const rig::PlantState &y);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace springdrive::charts
