// CVODE (SUNDIALS) on the plant's equations: the reference of the charts of integrators, and one of
// the methods compared. Without friction, or with a smooth one, CVODE alone; with true Coulomb
// friction, CVODE restarted at each transition between sticking and sliding.
//
// Between two transitions the plant is smooth: a joint slides in one direction against the friction
// τ_c, or it sticks, and friction holds it. CVODE's root finder detects when a sliding joint comes
// to rest or a sticking one needs more than τ_c. The modes of the joints at rest are then the one
// consistent choice: those that stick need no more than τ_c, those that begin to slide are
// accelerated in the direction of their sliding.
#pragma once

#include "engine/lab/rig/plant_equations.h"

#include <array>
#include <cstdint>
#include <memory>

namespace springdrive::charts {

/// CVODE's two families of methods.
enum class CvodeMethod : std::uint8_t {
    adams, ///< up to order 12, for non-stiff problems
    bdf,   ///< up to order 5, for stiff problems
};

class CvodeSolver {
public:
    /// @param relative_tolerance  of every step; in absolute terms a hundredth of it
    /// @throw std::runtime_error where CVODE has no memory
    CvodeSolver(CvodeMethod method, double relative_tolerance);
    ~CvodeSolver();
    CvodeSolver(const CvodeSolver &) = delete;
    CvodeSolver &operator=(const CvodeSolver &) = delete;

    /// y at `end_s`, from `y` at `start_s`. Restarts, as inputs are discontinuous at the start of a
    /// period.
    /// @throw std::runtime_error where CVODE fails
    [[nodiscard]] rig::PlantState advance(const rig::PlantEquations &equations, double start_s,
                                          double end_s, const rig::PlantState &y);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// The mode of each joint: +1 and -1 where it slides forward or backward, 0 where it sticks.
using StickSlipModes = std::array<int, 3>;

/// q̈ under true friction, and the friction torque that holds the joints that stick.
struct StickSlipMotion {
    Vector3 acceleration_rad_per_s2{Vector3::Zero()};
    Vector3 holding_Nm{Vector3::Zero()};
};

[[nodiscard]] StickSlipMotion stick_slip_motion(const rig::PlantMechanics &mechanics,
                                                const Vector3 &coulomb_Nm,
                                                const StickSlipModes &modes);

/// The modes of joints at these rates. Joints exactly at rest get the consistent choice; a joint
/// that is `released` slides.
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
    /// @throw std::runtime_error where CVODE fails, or there are too many transitions
    [[nodiscard]] rig::PlantState advance(const rig::PlantEquations &equations, double start_s,
                                          double end_s, const rig::PlantState &y);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace springdrive::charts
