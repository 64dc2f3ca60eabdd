#include "engine/lab/charts/plant_solvers.h"

#include "engine/lab/charts/cvode_session.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace springdrive::charts {

namespace {

int call_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *equations) {
    cvode::view<rig::PlantState>(y_rate) =
        static_cast<const rig::PlantEquations *>(equations)->rates(time_s,
                                                                   cvode::view<rig::PlantState>(y));
    return 0;
}

constexpr int kJoints = 3;
constexpr int kMaxChanges = 10'000; ///< per call
constexpr std::array<int, 3> kModes{0, 1, -1};

struct SlidingPlant {
    const rig::PlantEquations &equations;
    StickSlipModes modes{};
};

int call_sliding_rates(realtype time_s, N_Vector y, N_Vector y_rate, void *given) {
    const auto &plant = *static_cast<const SlidingPlant *>(given);
    const rig::PlantState now = cvode::view<rig::PlantState>(y);
    rig::PlantState rate = plant.equations.position_rates(now);
    rate.segment<3>(3) = stick_slip_motion(plant.equations.mechanics(time_s, now),
                                           plant.equations.coulomb_Nm(), plant.modes)
                             .acceleration_rad_per_s2;
    cvode::view<rig::PlantState>(y_rate) = rate;
    return 0;
}

/// A value for each joint that becomes negative where its mode changes.
int call_roots(realtype time_s, N_Vector y, realtype *values, void *given) {
    const auto &plant = *static_cast<const SlidingPlant *>(given);
    const rig::PlantState now = cvode::view<rig::PlantState>(y);
    const Vector3 &coulomb_Nm = plant.equations.coulomb_Nm();
    const Vector3 holding_Nm =
        stick_slip_motion(plant.equations.mechanics(time_s, now), coulomb_Nm, plant.modes)
            .holding_Nm;
    for (int j = 0; j < kJoints; ++j) {
        const int mode = plant.modes[static_cast<std::size_t>(j)];
        values[j] = mode == 0 ? coulomb_Nm[j] - std::abs(holding_Nm[j]) : mode * now[3 + j];
    }
    return 0;
}

/// By how much the modes of joints at rest are inconsistent [N·m].
double contradiction_Nm(const rig::PlantMechanics &mechanics, const Vector3 &coulomb_Nm,
                        const Vector3 &rate_rad_per_s, const StickSlipModes &modes) {
    const StickSlipMotion motion = stick_slip_motion(mechanics, coulomb_Nm, modes);
    const Vector3 inertia_kg_m2 = mechanics.inertia.matrix_kg_m2().diagonal();
    double worst_Nm = 0.0;
    for (int j = 0; j < kJoints; ++j) {
        const int mode = modes[static_cast<std::size_t>(j)];
        if (rate_rad_per_s[j] == 0.0) {
            worst_Nm = std::max(worst_Nm, mode == 0 ? std::abs(motion.holding_Nm[j]) - coulomb_Nm[j]
                                                    : -mode * inertia_kg_m2[j] *
                                                          motion.acceleration_rad_per_s2[j]);
        }
    }
    return worst_Nm;
}

} // namespace

struct CvodeSolver::Parts {
    cvode::Session<rig::PlantState> session;
};

CvodeSolver::CvodeSolver(CvodeMethod method, double relative_tolerance)
    : parts_(new Parts{{method, relative_tolerance, call_rates}}) {}

CvodeSolver::~CvodeSolver() = default;

rig::PlantState CvodeSolver::advance(const rig::PlantEquations &equations, double start_s,
                                     double end_s, const rig::PlantState &y) {
    rig::PlantEquations now = equations;
    parts_->session.restart(start_s, end_s, y, &now);
    double reached_s = 0.0;
    parts_->session.run(end_s, reached_s);
    return parts_->session.y();
}

StickSlipMotion stick_slip_motion(const rig::PlantMechanics &mechanics, const Vector3 &coulomb_Nm,
                                  const StickSlipModes &modes) {
    const Matrix3 M = mechanics.inertia.matrix_kg_m2();
    Matrix3 system = M;
    Vector3 right = mechanics.torque_Nm;
    for (int j = 0; j < kJoints; ++j) {
        const int mode = modes[static_cast<std::size_t>(j)];
        right[j] -= mode * coulomb_Nm[j];
        if (mode == 0) { // its equation is zero acceleration
            system.row(j) = Vector3::Unit(j).transpose();
            right[j] = 0.0;
        }
    }
    StickSlipMotion motion;
    motion.acceleration_rad_per_s2 = system.inverse() * right;
    const Vector3 missing_Nm = M * motion.acceleration_rad_per_s2 - mechanics.torque_Nm;
    for (int j = 0; j < kJoints; ++j) {
        if (modes[static_cast<std::size_t>(j)] == 0) {
            motion.acceleration_rad_per_s2[j] = 0.0;
            motion.holding_Nm[j] = missing_Nm[j];
        }
    }
    return motion;
}

StickSlipModes stick_slip_modes(const rig::PlantMechanics &mechanics, const Vector3 &coulomb_Nm,
                                const Vector3 &rate_rad_per_s,
                                const std::array<bool, 3> &released) {
    StickSlipModes best{};
    double min_Nm = std::numeric_limits<double>::infinity();
    const auto may_be = [&](std::size_t joint, int mode) {
        const double rate = rate_rad_per_s[static_cast<Eigen::Index>(joint)];
        return rate == 0.0 ? mode != 0 || !released[joint] : mode * rate > 0.0;
    };
    for (const int first : kModes) {
        for (const int second : kModes) {
            for (const int third : kModes) {
                if (!may_be(0, first) || !may_be(1, second) || !may_be(2, third)) {
                    continue;
                }
                const StickSlipModes modes{first, second, third};
                const double wrong_Nm =
                    contradiction_Nm(mechanics, coulomb_Nm, rate_rad_per_s, modes);
                if (wrong_Nm < min_Nm) {
                    min_Nm = wrong_Nm;
                    best = modes;
                }
            }
        }
    }
    return best;
}

struct StickSlipSolver::Parts {
    cvode::Session<rig::PlantState> session;
};

StickSlipSolver::StickSlipSolver(CvodeMethod method, double relative_tolerance)
    : parts_(new Parts{{method, relative_tolerance, call_sliding_rates}}) {
    std::array<int, kJoints> falling{-1, -1, -1};
    cvode::check(CVodeRootInit(parts_->session.get(), kJoints, call_roots), "CVodeRootInit");
    cvode::check(CVodeSetRootDirection(parts_->session.get(), falling.data()),
                 "CVodeSetRootDirection");
    cvode::check(CVodeSetNoInactiveRootWarn(parts_->session.get()), "CVodeSetNoInactiveRootWarn");
}

StickSlipSolver::~StickSlipSolver() = default;

rig::PlantState StickSlipSolver::advance(const rig::PlantEquations &equations, double start_s,
                                         double end_s, const rig::PlantState &y) {
    SlidingPlant plant{equations, {}};
    rig::PlantState now = y;
    double now_s = start_s;
    std::array<bool, 3> released{};
    for (int change = 0; change < kMaxChanges; ++change) {
        plant.modes = stick_slip_modes(equations.mechanics(now_s, now), equations.coulomb_Nm(),
                                       now.segment<3>(3), released);
        parts_->session.restart(now_s, end_s, now, &plant);
        const int status = parts_->session.run(end_s, now_s);
        now = parts_->session.y();
        if (status != CV_ROOT_RETURN) {
            return now;
        }
        std::array<int, kJoints> found{};
        cvode::check(CVodeGetRootInfo(parts_->session.get(), found.data()), "CVodeGetRootInfo");
        for (std::size_t j = 0; j < found.size(); ++j) {
            released[j] = found[j] != 0 && plant.modes[j] == 0;
            if (found[j] != 0 && plant.modes[j] != 0) {
                now[3 + static_cast<Eigen::Index>(j)] = 0.0; // exactly
            }
        }
    }
    throw std::runtime_error("sticking and sliding: too many transitions");
}

} // namespace springdrive::charts
