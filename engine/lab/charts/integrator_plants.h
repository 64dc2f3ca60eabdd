// The plants of a press, advanced by integrators: those by the equations, and the simulated device.
#pragma once

#include "device/core/phantom/kinematics.h"
#include "engine/lab/charts/contact_press.h"
#include "engine/lab/charts/cvode_solver.h"
#include "engine/lab/charts/integrator_trial.h"
#include "engine/lab/rig/integrators.h"
#include "engine/lab/rig/plant_equations.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace springdrive::charts {

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

} // namespace springdrive::charts
