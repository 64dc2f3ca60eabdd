#include "engine/lab/charts/integrator_trial.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/charts/integrator_plants.h"
#include "engine/lab/charts/stick_slip_solver.h"

#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace springdrive::charts {

namespace {

constexpr double kReferenceTolerance = 1e-12;

std::vector<simulated::HandTarget> targets_of(const rig::Scenario &press) {
    const std::vector<simulated::HandPath::Point> points = press.simulation.path->points();
    std::vector<simulated::HandTarget> targets;
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const Vector3 way_m = points[k + 1].position_m - points[k].position_m;
        targets.push_back({points[k].position_m, way_m / press.simulation.servo_period_s});
    }
    return targets;
}

rig::PlantState state_at(const rig::Scenario &press) {
    const std::optional<Vector3> q_rad =
        device::joint_angles_rad(press.device.geometry, press.start_m);
    if (!q_rad) {
        throw InputError(
            "integrators' chart: the press starts at a point that the tip cannot reach; "
            "choose a device whose workspace box is within reach");
    }
    rig::PlantState start = rig::PlantState::Zero();
    start.head<3>() = *q_rad;
    return start;
}

std::string step_text(double step_s) { return fmt::format("{:.4g} µs", step_s * 1e6); }

std::string tolerance_text(double tolerance) {
    return "1e" + std::to_string(std::lround(std::log10(tolerance)));
}

} // namespace

IntegratorTrial::IntegratorTrial(const rig::Scenario &press)
    : press_(press), equations_(press.device, press.simulation), targets_(targets_of(press)),
      start_(state_at(press)) {
    reference_ = run_press(press_, reference_plant(CvodeMethod::adams, kReferenceTolerance));
}

double IntegratorTrial::friction_width_rad_per_s(double step_s) const {
    const Vector3 inertia_kg_m2 =
        equations_.mechanics(0.0, start_).inertia.matrix_kg_m2().diagonal();
    return step_s * equations_.coulomb_Nm().cwiseQuotient(inertia_kg_m2).maxCoeff();
}

NewPlant IntegratorTrial::reference_plant(CvodeMethod method, double relative_tolerance) const {
    if (!press_.simulation.effects.coulomb_friction) {
        return cvode_plant(method, relative_tolerance);
    }
    return [this, method, relative_tolerance] {
        return std::make_unique<SolvedPlant<StickSlipSolver>>(method, relative_tolerance, press_,
                                                              equations_, targets_, start_);
    };
}

NewPlant IntegratorTrial::plant(Integrator integrator, int sub_steps, double width) const {
    rig::PlantEquations equations = equations_;
    equations.set_friction_width(width);
    const auto made = [&]<typename Plant>(std::type_identity<Plant>) -> NewPlant {
        return [this, sub_steps, equations] {
            return std::make_unique<Plant>(sub_steps, press_, equations, targets_, start_);
        };
    };
    switch (integrator) {
    case Integrator::explicit_euler:
        return made(std::type_identity<ExplicitPlant<Integrator::explicit_euler>>());
    case Integrator::semi_implicit_euler:
        return made(std::type_identity<ExplicitPlant<Integrator::semi_implicit_euler>>());
    case Integrator::runge_kutta:
        return made(std::type_identity<ExplicitPlant<Integrator::runge_kutta>>());
    case Integrator::implicit_midpoint:
        return made(std::type_identity<MidpointPlant>());
    case Integrator::simulator:
        break;
    }
    return [this, sub_steps] {
        simulated::SimulationOptions options = press_.simulation;
        options.longest_step_s = press_.simulation.servo_period_s / sub_steps;
        options.quantised_encoders = false;
        return std::make_unique<SimulatorPlant>(press_, options, equations_);
    };
}

NewPlant IntegratorTrial::cvode_plant(CvodeMethod method, double relative_tolerance,
                                      double width) const {
    rig::PlantEquations equations = equations_;
    equations.set_friction_width(width);
    return [this, method, relative_tolerance, equations] {
        return std::make_unique<SolvedPlant<CvodeSolver>>(method, relative_tolerance, press_,
                                                          equations, targets_, start_);
    };
}

double IntegratorTrial::error_N(Integrator integrator, int sub_steps) const {
    return force_error_N(run_press(press_, plant(integrator, sub_steps)), reference_);
}

ChartPoint IntegratorTrial::point(Integrator integrator, int sub_steps, int repeats,
                                  double width) const {
    const NewPlant new_plant = plant(integrator, sub_steps, width);
    const PressRecord record = run_press(press_, new_plant);
    ChartPoint point;
    point.setting = step_text(press_.simulation.servo_period_s / sub_steps);
    point.error = force_error_N(record, reference_);
    point.stable = std::isfinite(point.error);
    point.cost = press_cost(press_, record, new_plant, sub_steps, repeats);
    return point;
}

ChartPoint IntegratorTrial::cvode_point(CvodeMethod method, double relative_tolerance, int repeats,
                                        double width) const {
    return solved_point(cvode_plant(method, relative_tolerance, width), relative_tolerance,
                        repeats);
}

ChartPoint IntegratorTrial::reference_point(double relative_tolerance, int repeats) const {
    return solved_point(reference_plant(CvodeMethod::adams, relative_tolerance), relative_tolerance,
                        repeats);
}

ChartPoint IntegratorTrial::solved_point(const NewPlant &new_plant, double relative_tolerance,
                                         int repeats) const {
    constexpr int kSubSteps = 16; // about the number that it chooses itself
    ChartPoint point;
    point.setting = tolerance_text(relative_tolerance);
    try {
        const PressRecord record = run_press(press_, new_plant);
        point.error = force_error_N(record, reference_);
        point.stable = std::isfinite(point.error);
        point.cost = press_cost(press_, record, new_plant, kSubSteps, repeats);
    } catch (const std::runtime_error &) { // it failed
        point.error = std::numeric_limits<double>::infinity();
        point.stable = false;
    }
    return point;
}

} // namespace springdrive::charts
