// The charts of integrators and of plant models.
#include "base/input_error.h"
#include "base/timing.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/charts/press_trial.h"
#include "engine/lab/rig/plant_equations.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace springdrive::charts {

namespace {

constexpr double kFarAway_rad = 1000.0; ///< no motor turns so far
constexpr double kReferenceTolerance = 1e-12;

/// The plant's time for a millisecond of the press [ns].
Cost press_cost(const rig::Scenario &press, const PressRecord &record, const NewPlant &new_plant,
                int sub_steps, int repeats) {
    constexpr int kMinSubSteps = 5120; // below, the clock would be too coarse
    const int rounds = std::max(1, kMinSubSteps / (periods_of(press) * std::max(1, sub_steps)));
    std::vector<std::unique_ptr<PressedPlant>> plants; // one for each press
    const int presses = rounds * (repeats + 1);
    plants.reserve(static_cast<std::size_t>(presses));
    for (int i = 0; i < presses; ++i) {
        plants.push_back(new_plant());
    }
    auto next = plants.begin();
    const auto work = [&] {
        for (int round = 0; round < rounds; ++round, ++next) {
            for (const simulated::PlantCommand &command : record.commands) {
                (*next)->advance(command);
            }
        }
    };
    constexpr double kMillisecond_s = 1e-3;
    return cost_of(repeats,
                   rounds * periods_of(press) * press.simulation.servo_period_s / kMillisecond_s,
                   work);
}

/// y at the end of a period that starts at a time with y.
using Integrate = std::function<rig::PlantState(const rig::PlantEquations &f, double start_s,
                                                const rig::PlantState &y)>;

/// A plant by its equations.
class EquationPlant final : public PressedPlant {
public:
    EquationPlant(const rig::Scenario &press, const rig::PlantEquations &equations,
                  const std::vector<simulated::HandTarget> &targets, const rig::PlantState &start,
                  Integrate integrate)
        : press_(press), targets_(targets), equations_(equations), y_(start),
          integrate_(std::move(integrate)) {}

    void advance(const simulated::PlantCommand &command) override {
        const double start_s = static_cast<double>(period_) * press_.simulation.servo_period_s;
        equations_.set_inputs({command.spring_drive, start_s, targets_[period_]});
        y_ = integrate_(equations_, start_s, y_);
        ++period_;
    }
    [[nodiscard]] Vector3 theta_rad() const override {
        return device::motor_from_joint(press_.device.geometry, y_.head<3>());
    }
    [[nodiscard]] Vector3 force_N() const override { return equations_.tip_force_N(y_); }

private:
    const rig::Scenario &press_;
    const std::vector<simulated::HandTarget> &targets_;
    rig::PlantEquations equations_;
    rig::PlantState y_;
    Integrate integrate_;
    std::size_t period_ = 0;
};

/// Equal steps.
/// @param step  y after a step of h, from the equations, the time, y and h
template <typename Step> Integrate stepped(double period_s, int sub_steps, const Step &step) {
    return [=, h = period_s / sub_steps](const rig::PlantEquations &f, double start_s,
                                         const rig::PlantState &start) {
        rig::PlantState y = start;
        for (int i = 0; i < sub_steps; ++i) {
            y = step(f, start_s + i * h, y, h);
        }
        return y;
    };
}

auto rates_of(const rig::PlantEquations &f) {
    return [&f](double t, const rig::PlantState &y) { return f.rates(t, y); };
}

/// The Newton matrix is computed at the start of the period. Not a number where it fails.
Integrate midpoint_steps(double period_s, int sub_steps) {
    return [=, h = period_s / sub_steps](const rig::PlantEquations &f, double start_s,
                                         const rig::PlantState &start) {
        rig::ImplicitMidpoint<rig::PlantState> midpoint;
        midpoint.prepare(rates_of(f), start_s, start, h);
        std::optional<rig::PlantState> y = start;
        for (int i = 0; i < sub_steps && y; ++i) {
            y = midpoint.step(rates_of(f), start_s + i * h, *y);
        }
        return y.value_or(rig::PlantState::Constant(std::numeric_limits<double>::quiet_NaN()));
    };
}

Integrate steps_of(Integrator integrator, double period_s, int sub_steps) {
    using rig::PlantEquations;
    using rig::PlantState;
    switch (integrator) {
    case Integrator::explicit_euler:
        return stepped(period_s, sub_steps,
                       [](const PlantEquations &f, double t, const PlantState &y, double h) {
                           return rig::explicit_euler_step(rates_of(f), t, y, h);
                       });
    case Integrator::semi_implicit_euler:
        return stepped(
            period_s, sub_steps,
            [](const PlantEquations &f, double t, const PlantState &y, double h) {
                return rig::semi_implicit_euler_step(
                    [&f](double at_s, const PlantState &at) { return f.momentum_rates(at_s, at); },
                    [&f](double, const PlantState &at) { return f.position_rates(at); }, t, y, h);
            });
    case Integrator::runge_kutta:
        return stepped(period_s, sub_steps,
                       [](const PlantEquations &f, double t, const PlantState &y, double h) {
                           return rig::runge_kutta_step(rates_of(f), t, y, h);
                       });
    case Integrator::implicit_midpoint:
    case Integrator::simulator: // has no equations
        break;
    }
    return midpoint_steps(period_s, sub_steps);
}

/// By CvodeSolver or StickSlipSolver.
template <typename Solver>
Integrate solved(double period_s, CvodeMethod method, double relative_tolerance) {
    return [=, solver = std::make_shared<Solver>(method, relative_tolerance)](
               const rig::PlantEquations &f, double start_s, const rig::PlantState &start) {
        return solver->advance(f, start_s, start_s + period_s, start);
    };
}

/// The simulated device.
class DevicePlant final : public PressedPlant {
public:
    /// @param exact  with these, the law reads exact angles, as with plants by equations, and the
    ///               force is theirs; without, encoders in whole counts from the start on, and the
    ///               force on the hand
    DevicePlant(const device::DeviceDescription &description,
                const simulated::SimulationOptions &options, const Vector3 &start_m,
                const rig::PlantEquations *exact)
        : device_(description, options, start_m), exact_(exact),
          rad_per_count_(device_.description().rad_per_count()) {
        for (std::size_t j = 0; j < 3; ++j) {
            const double theta_rad = device_.truth().theta_rad[static_cast<Eigen::Index>(j)];
            counts_[j] = static_cast<std::int32_t>(std::lround(theta_rad / rad_per_count_));
        }
    }

    void advance(const simulated::PlantCommand &command) override {
        counts_ = device_.advance(command).counts;
    }
    [[nodiscard]] Vector3 theta_rad() const override {
        return exact_ != nullptr
                   ? device_.truth().theta_rad
                   : Vector3(rad_per_count_ * Vector3(counts_[0], counts_[1], counts_[2]));
    }
    [[nodiscard]] Vector3 force_N() const override {
        const simulated::SimulatedPhantom::Truth &truth = device_.truth();
        if (exact_ == nullptr) {
            return truth.hand_force_N;
        }
        const device::PhantomGeometry &geometry = device_.description().geometry;
        rig::PlantState y;
        y << device::joint_from_motor(geometry, truth.theta_rad),
            device::joint_from_motor(geometry, truth.theta_rate_rad_per_s), truth.current_A;
        return exact_->tip_force_N(y);
    }

private:
    simulated::SimulatedPhantom device_;
    const rig::PlantEquations *exact_;
    double rad_per_count_;
    std::array<std::int32_t, 3> counts_{};
};

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

} // namespace

rig::Scenario press_of(const ChartSetting &setting, const rig::PressOptions &press) {
    return rig::press_scenario({setting.device, setting.tuning}, press);
}

rig::LawRig press_loop(const rig::Scenario &press, PressedPlant &plant) {
    rig::LawOptions options;
    options.device = press.device;
    options.tuning = press.tuning;
    options.period_s = press.simulation.servo_period_s;
    options.max_turn_rad = kFarAway_rad;
    return {plant, options, press.constraint, rig::FirstCommand::answers};
}

double PressRecord::max_force_N() const {
    double max_N = 0.0;
    for (const Vector3 &one : force_N) {
        max_N = std::max(max_N, one.norm());
    }
    return max_N;
}

PressRecord run_press(const rig::Scenario &press, const NewPlant &new_plant) {
    const std::unique_ptr<PressedPlant> plant = new_plant();
    rig::LawRig loop = press_loop(press, *plant);
    PressRecord record;
    for (int period = 0; period < periods_of(press); ++period) {
        record.commands.push_back(loop.command());
        loop.tick();
        record.force_N.push_back(plant->force_N());
    }
    return record;
}

double force_error_N(const PressRecord &record, const PressRecord &reference) {
    constexpr double kAway = 10.0;
    const double away_N = kAway * reference.max_force_N();
    double sum = 0.0;
    for (std::size_t k = 0; k < reference.force_N.size(); ++k) {
        const Vector3 &force_N = record.force_N[k];
        if (!force_N.allFinite() || force_N.norm() > away_N) {
            return std::numeric_limits<double>::infinity();
        }
        sum += (force_N - reference.force_N[k]).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(reference.force_N.size()));
}

ChartPoint press_point(const rig::Scenario &press, const NewPlant &new_plant,
                       const PressRecord &reference, int sub_steps, int repeats) {
    const PressRecord record = run_press(press, new_plant);
    ChartPoint point;
    point.error = force_error_N(record, reference);
    point.stable = std::isfinite(point.error);
    point.cost = press_cost(press, record, new_plant, sub_steps, repeats);
    return point;
}

NewPlant model_plant(const rig::Scenario &press, const simulated::PlantModel &model, bool planar,
                     int sub_steps) {
    simulated::SimulationOptions options;
    options.servo_period_s = press.simulation.servo_period_s;
    options.longest_step_s = press.simulation.servo_period_s / sub_steps;
    options.hand = press.simulation.hand;
    options.path = *press.simulation.path;
    options.dynamics = model.dynamics;
    options.effects = model.effects;
    options.planar = planar;
    return [description = press.device, options, start_m = press.start_m] {
        return std::make_unique<DevicePlant>(description, options, start_m, nullptr);
    };
}

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

NewPlant IntegratorTrial::plant(Integrator integrator, int sub_steps, double width) const {
    const double period_s = press_.simulation.servo_period_s;
    if (integrator == Integrator::simulator) {
        simulated::SimulationOptions options = press_.simulation;
        options.longest_step_s = period_s / sub_steps;
        options.quantised_encoders = false;
        return [this, options] {
            return std::make_unique<DevicePlant>(press_.device, options, press_.start_m,
                                                 &equations_);
        };
    }
    rig::PlantEquations equations = equations_;
    equations.set_friction_width(width);
    return [=, this] {
        return std::make_unique<EquationPlant>(press_, equations, targets_, start_,
                                               steps_of(integrator, period_s, sub_steps));
    };
}

NewPlant IntegratorTrial::cvode_plant(CvodeMethod method, double relative_tolerance,
                                      double width) const {
    rig::PlantEquations equations = equations_;
    equations.set_friction_width(width);
    return [=, this] {
        return std::make_unique<EquationPlant>(
            press_, equations, targets_, start_,
            solved<CvodeSolver>(press_.simulation.servo_period_s, method, relative_tolerance));
    };
}

NewPlant IntegratorTrial::reference_plant(CvodeMethod method, double relative_tolerance) const {
    if (!press_.simulation.effects.coulomb_friction) {
        return cvode_plant(method, relative_tolerance);
    }
    return [=, this] {
        return std::make_unique<EquationPlant>(
            press_, equations_, targets_, start_,
            solved<StickSlipSolver>(press_.simulation.servo_period_s, method, relative_tolerance));
    };
}

ChartPoint IntegratorTrial::point(Integrator integrator, int sub_steps, int repeats,
                                  double width) const {
    ChartPoint point =
        press_point(press_, plant(integrator, sub_steps, width), reference_, sub_steps, repeats);
    point.setting = fmt::format("{:.4g} µs", press_.simulation.servo_period_s / sub_steps * 1e6);
    return point;
}

ChartPoint IntegratorTrial::solved_point(const NewPlant &new_plant, double relative_tolerance,
                                         int repeats) const {
    constexpr int kSubSteps = 16; // about the number that it chooses itself
    ChartPoint point;
    try {
        point = press_point(press_, new_plant, reference_, kSubSteps, repeats);
    } catch (const std::runtime_error &) { // it failed
        point.error = std::numeric_limits<double>::infinity();
        point.stable = false;
    }
    point.setting = "1e" + std::to_string(std::lround(std::log10(relative_tolerance)));
    return point;
}

namespace {

constexpr int kMaxSubSteps = 1024; ///< in a servo period: down to about a microsecond at 1 kHz
constexpr std::array<double, 5> kTolerances{1e-2, 1e-4, 1e-6, 1e-8, 1e-10};

constexpr int kMaxFrictionSubSteps = 64; ///< down to about 16 µs at 1 kHz
constexpr std::array<double, 6> kFrictionTolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8};

constexpr std::array<int, 7> kModelSubSteps{1, 2, 5, 10, 20, 50, 100};
constexpr int kReferenceSubSteps = 1000;

struct NamedCvode {
    CvodeMethod method = CvodeMethod::adams;
    const char *name = nullptr;
};
constexpr std::array<NamedCvode, 2> kCvodes{
    {{CvodeMethod::adams, "CVODE (Adams)"}, {CvodeMethod::bdf, "CVODE (BDF)"}}};

/// Settings of CVODE with smoothed friction.
struct Smoothing {
    double tolerance = 0.0;
    double width_rad_per_s = 0.0;
};

/// The best of a grid of tolerances and widths in decades, for the PHANTOM 1.0: narrower friction
/// costs more there, and wider friction has a larger error.
constexpr std::array<Smoothing, 6> kSmoothings{
    {{1e-2, 1e-3}, {1e-3, 1e-4}, {1e-4, 1e-5}, {1e-5, 1e-6}, {1e-6, 1e-6}, {1e-7, 1e-7}}};

/// A chart of a press that grows line by line.
class PressChart {
public:
    /// @param lines  that it will have
    PressChart(SpeedAccuracyChart chart, std::size_t lines, const ChartProgress &progress)
        : chart_(std::move(chart)), lines_(static_cast<double>(lines)), progress_(progress) {
        chart_.cost_label = "processor time per simulated millisecond";
    }

    void add(ChartPoint point, std::string_view method) {
        point.method = method;
        chart_.points.push_back(std::move(point));
    }
    void end_line() { progress_(++done_ / lines_); }
    [[nodiscard]] SpeedAccuracyChart made() { return std::move(chart_); }

private:
    SpeedAccuracyChart chart_;
    double lines_;
    double done_ = 0.0;
    const ChartProgress &progress_;
};

constexpr const char *kIntegratorError =
    "error of the force over the transient, r.m.s. against CVODE at 1e-12 (N)";

SpeedAccuracyChart smooth_chart(const rig::Scenario &press, std::string name, std::string title,
                                const ChartSetting &setting, const ChartProgress &progress) {
    const IntegratorTrial trial(press);
    PressChart chart({std::move(name), std::move(title), {}, kIntegratorError, {}},
                     kIntegrators.size() + kCvodes.size(), progress);
    for (const NamedIntegrator &named : kIntegrators) {
        for (int sub_steps = 1; sub_steps <= kMaxSubSteps; sub_steps *= 2) {
            chart.add(trial.point(named.integrator, sub_steps, setting.repeats), named.name);
        }
        chart.end_line();
    }
    for (const NamedCvode &named : kCvodes) {
        for (const double tolerance : kTolerances) {
            chart.add(trial.solved_point(trial.cvode_plant(named.method, tolerance), tolerance,
                                         setting.repeats),
                      named.name);
        }
        chart.end_line();
    }
    return chart.made();
}

} // namespace

SpeedAccuracyChart integrator_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return smooth_chart(press_of(setting, rig::pen_press()), "integrators",
                        "Integrators of the plant in hard contact", setting, progress);
}

SpeedAccuracyChart stiff_integrator_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return smooth_chart(press_of(setting, rig::vice_press()), "integrators_vice",
                        "Integrators of the plant in hard contact, the tip in a vice", setting,
                        progress);
}

SpeedAccuracyChart friction_integrator_chart(const ChartSetting &setting,
                                             const ChartProgress &progress) {
    const IntegratorTrial trial(press_of(setting, rig::sticking_press()));
    PressChart chart({"integrators_friction",
                      "Integrators of the plant in hard contact with stick-slip friction",
                      {},
                      kIntegratorError,
                      {}},
                     kIntegrators.size() + 2, progress);
    for (const NamedIntegrator &named : kIntegrators) {
        const bool is_smoothed = named.integrator == Integrator::implicit_midpoint;
        for (int sub_steps = 1; sub_steps <= kMaxFrictionSubSteps; sub_steps *= 2) {
            const double step_s = trial.press().simulation.servo_period_s / sub_steps;
            const double width = is_smoothed ? trial.friction_width_rad_per_s(step_s) : 0.0;
            chart.add(trial.point(named.integrator, sub_steps, setting.repeats, width),
                      std::string(named.name) + (is_smoothed ? ", smooth" : ""));
        }
        chart.end_line();
    }
    for (const auto &[tolerance, width] : kSmoothings) {
        chart.add(trial.solved_point(trial.cvode_plant(CvodeMethod::bdf, tolerance, width),
                                     tolerance, setting.repeats),
                  "CVODE (BDF), smooth");
    }
    chart.end_line();
    for (const double tolerance : kFrictionTolerances) {
        chart.add(trial.solved_point(trial.reference_plant(CvodeMethod::adams, tolerance),
                                     tolerance, setting.repeats),
                  "CVODE, slip to stick");
    }
    chart.end_line();
    return chart.made();
}

SpeedAccuracyChart plant_model_chart(const ChartSetting &setting, const ChartProgress &progress) {
    const rig::Scenario press = press_of(setting, rig::planar_press());
    const PressRecord reference = run_press(
        press, model_plant(press, simulated::kPlantModels.back(), false, kReferenceSubSteps));
    PressChart chart({"plant_models",
                      "Models of the plant in hard contact",
                      {},
                      "error of the force on the hand, r.m.s. against the full model at 1 µs (N)",
                      {}},
                     2 * simulated::kPlantModels.size(), progress);
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        for (const bool planar : {true, false}) {
            for (const int sub_steps : kModelSubSteps) {
                ChartPoint point = press_point(press, model_plant(press, model, planar, sub_steps),
                                               reference, sub_steps, setting.repeats);
                const double step_us = press.simulation.servo_period_s / sub_steps * 1e6;
                point.setting = std::to_string(std::lround(step_us)) + " µs";
                chart.add(std::move(point), std::string(model.name) + (planar ? ", planar" : ""));
            }
            chart.end_line();
        }
    }
    return chart.made();
}

} // namespace springdrive::charts
