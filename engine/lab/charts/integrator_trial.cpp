#include "engine/lab/charts/integrator_trial.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/charts/contact_press.h"
#include "engine/lab/charts/cvode_solver.h"
#include "engine/lab/charts/stick_slip_solver.h"
#include "engine/lab/rig/integrators.h"
#include "engine/lab/rig/plant_equations.h"

#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace springdrive::charts {

namespace {

/// The common part of the plants by equations: the equations, their inputs and state.
class EquationPlant : public PressedPlant {
public:
    EquationPlant(const rig::Scenario &press, const rig::PlantEquations &equations,
                  const std::vector<simulated::HandTarget> &targets, const rig::PlantState &start)
        : press_(press), targets_(targets), equations_(equations), y_(start) {}

    void advance(const simulated::PlantCommand &command) override {
        const double start_s = static_cast<double>(period_) * press_.simulation.servo_period_s;
        equations_.set_inputs({command.spring_drive, start_s, targets_[period_]});
        y_ = integrated(start_s, y_);
        ++period_;
    }
    [[nodiscard]] Vector3 theta_rad() const override {
        return device::motor_from_joint(press_.device.geometry, y_.head<3>());
    }
    [[nodiscard]] Vector3 force_N() const override { return equations_.tip_force_N(y_); }

protected:
    [[nodiscard]] virtual rig::PlantState integrated(double start_s, const rig::PlantState &y) = 0;
    [[nodiscard]] const rig::PlantEquations &equations() const { return equations_; }
    [[nodiscard]] double period_s() const { return press_.simulation.servo_period_s; }

private:
    const rig::Scenario &press_;
    const std::vector<simulated::HandTarget> &targets_;
    rig::PlantEquations equations_;
    rig::PlantState y_;
    std::size_t period_ = 0;
};

/// Equal steps of one of the explicit methods.
template <Integrator integrator> class ExplicitPlant final : public EquationPlant {
public:
    template <typename... Common>
    explicit ExplicitPlant(int sub_steps, const Common &...common)
        : EquationPlant(common...), sub_steps_(sub_steps) {}

private:
    rig::PlantState integrated(double start_s, const rig::PlantState &start) override {
        const double h = period_s() / sub_steps_;
        rig::PlantState y = start;
        for (int i = 0; i < sub_steps_; ++i) {
            y = step(start_s + i * h, y, h);
        }
        return y;
    }
    [[nodiscard]] rig::PlantState step(double time_s, const rig::PlantState &y, double h) const {
        const auto f = [this](double t, const rig::PlantState &at) {
            return equations().rates(t, at);
        };
        if constexpr (integrator == Integrator::explicit_euler) {
            return rig::explicit_euler_step(f, time_s, y, h);
        } else if constexpr (integrator == Integrator::runge_kutta) {
            return rig::runge_kutta_step(f, time_s, y, h);
        } else {
            return rig::semi_implicit_euler_step(
                [this](double t, const rig::PlantState &at) {
                    return equations().momentum_rates(t, at);
                },
                [this](double, const rig::PlantState &at) {
                    return equations().position_rates(at);
                },
                time_s, y, h);
        }
    }

    int sub_steps_;
};

/// The Newton matrix is computed at the start of the period.
class MidpointPlant final : public EquationPlant {
public:
    template <typename... Common>
    explicit MidpointPlant(int sub_steps, const Common &...common)
        : EquationPlant(common...), sub_steps_(sub_steps) {}

private:
    rig::PlantState integrated(double start_s, const rig::PlantState &start) override {
        const auto f = [this](double t, const rig::PlantState &y) {
            return equations().rates(t, y);
        };
        const double h = period_s() / sub_steps_;
        midpoint_.prepare(f, start_s, start, h);
        rig::PlantState y = start;
        for (int i = 0; i < sub_steps_; ++i) {
            const std::optional<rig::PlantState> next = midpoint_.step(f, start_s + i * h, y);
            if (!next) {
                return rig::PlantState::Constant(std::numeric_limits<double>::quiet_NaN());
            }
            y = *next;
        }
        return y;
    }

    int sub_steps_;
    rig::ImplicitMidpoint<rig::PlantState> midpoint_;
};

/// Integrated by CvodeSolver or StickSlipSolver.
template <typename Solver> class SolvedPlant final : public EquationPlant {
public:
    template <typename... Common>
    SolvedPlant(CvodeMethod method, double relative_tolerance, const Common &...common)
        : EquationPlant(common...), solver_(method, relative_tolerance) {}

private:
    rig::PlantState integrated(double start_s, const rig::PlantState &start) override {
        return solver_.advance(equations(), start_s, start_s + period_s(), start);
    }

    Solver solver_;
};

/// The law reads the exact angles, as with the other plants, not counts.
class SimulatorPlant final : public PressedPlant {
public:
    SimulatorPlant(const rig::Scenario &press, const simulated::SimulationOptions &options,
                   const rig::PlantEquations &equations)
        : equations_(equations), geometry_(press.device.geometry),
          device_(press.device, options, press.start_m) {}

    void advance(const simulated::PlantCommand &command) override { device_.advance(command); }
    [[nodiscard]] Vector3 theta_rad() const override { return device_.truth().theta_rad; }
    [[nodiscard]] Vector3 force_N() const override {
        const simulated::SimulatedPhantom::Truth &truth = device_.truth();
        rig::PlantState y;
        y << device::joint_from_motor(geometry_, truth.theta_rad),
            device::joint_from_motor(geometry_, truth.theta_rate_rad_per_s), truth.current_A;
        return equations_.tip_force_N(y);
    }

private:
    const rig::PlantEquations &equations_;
    device::PhantomGeometry geometry_;
    simulated::SimulatedPhantom device_;
};

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
