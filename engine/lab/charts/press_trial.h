// The experiment of the charts of integrators and of plant models: a tip at rest on the surface of
// a hard plate, which a hand then presses into it within a few milliseconds, with the control law
// of the paper, (30), (23) and (10), in the loop.
//
// The constraint is bilateral, so that nothing switches. Between two samples a hand's target moves
// uniformly and e_W is held: the plant is smooth there, except for Coulomb friction where a press
// has it.
#pragma once

#include "device/simulated/simulation_options.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/charts/plant_solvers.h"
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/plant_equations.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

namespace springdrive::charts {

/// A scenario of `press_scenario` for a chart's device and tuning, at 1 kHz.
[[nodiscard]] rig::Scenario press_of(const ChartSetting &setting, const rig::PressOptions &press);

/// Servo periods from the start of a press to its end.
[[nodiscard]] inline int periods_of(const rig::Scenario &press) {
    return static_cast<int>(press.simulation.path->points().size()) - 1;
}

/// Commands and resulting forces, one for each period.
struct PressRecord {
    std::vector<simulated::PlantCommand> commands;
    std::vector<Vector3> force_N;

    [[nodiscard]] double max_force_N() const;
};

/// A plant advanced by one of the integrators. `advance` is what is timed.
class PressedPlant : public rig::Plant {
public:
    /// The force at the end of the last period, or its mean over the period, depending on the
    /// plant.
    [[nodiscard]] virtual Vector3 force_N() const = 0;
};

/// Makes a plant at rest at the start.
using NewPlant = std::function<std::unique_ptr<PressedPlant>()>;

/// The control law of a press. Its first command answers to the plant's initial angles.
[[nodiscard]] rig::LawRig press_loop(const rig::Scenario &press, PressedPlant &plant);

/// The whole press in closed loop.
[[nodiscard]] PressRecord run_press(const rig::Scenario &press, const NewPlant &new_plant);

/// The root mean square over all periods of the norm of the force's error [N]. Infinite where the
/// run diverged: forces not finite, or ten times the largest of the reference.
[[nodiscard]] double force_error_N(const PressRecord &record, const PressRecord &reference);

/// A point of a chart without the names of its method and setting: the error, and the plant's time
/// for a millisecond of the press, with the commands of that run. Neither the control law nor the
/// construction of a plant is timed.
/// @param sub_steps  approximate number per period: a short press is timed repeatedly
[[nodiscard]] ChartPoint press_point(const rig::Scenario &press, const NewPlant &new_plant,
                                     const PressRecord &reference, int sub_steps, int repeats);

/// A model of the plant in the press, with `sub_steps` equal steps in a servo period. Its law reads
/// the encoders in whole counts; its force is that on the hand, the mean of each period.
[[nodiscard]] NewPlant model_plant(const rig::Scenario &press, const simulated::PlantModel &model,
                                   bool planar, int sub_steps);

enum class Integrator : std::uint8_t {
    explicit_euler,
    semi_implicit_euler,
    runge_kutta,
    implicit_midpoint,
    simulator, ///< SimulatedPhantom::exchange
};

struct NamedIntegrator {
    Integrator integrator = Integrator::simulator;
    std::string_view name;
    double order = 0.0; ///< in theory
};

/// In the order of the chart.
inline constexpr std::array<NamedIntegrator, 5> kIntegrators{{
    {Integrator::explicit_euler, "explicit Euler", 1.0},
    {Integrator::semi_implicit_euler, "semi-implicit Euler", 1.0},
    {Integrator::runge_kutta, "Runge-Kutta 4", 4.0},
    {Integrator::implicit_midpoint, "implicit midpoint", 2.0},
    {Integrator::simulator, "ours (exact in energy)", 2.0},
}};

/// One press of the plant (plant_equations.h) by many integrators, against CVODE at a tight
/// tolerance. "Ours" is the simulated device itself.
class IntegratorTrial {
public:
    /// Runs the reference, in some tens of milliseconds.
    explicit IntegratorTrial(const rig::Scenario &press);

    [[nodiscard]] const rig::Scenario &press() const { return press_; }
    [[nodiscard]] const PressRecord &reference() const { return reference_; }

    /// With `sub_steps` equal steps in a servo period. Friction changes sign over a `width`
    /// [rad/s], or jumps where that is 0; the simulated device always has true friction.
    [[nodiscard]] NewPlant plant(Integrator integrator, int sub_steps, double width = 0.0) const;
    [[nodiscard]] NewPlant cvode_plant(CvodeMethod method, double relative_tolerance,
                                       double width = 0.0) const;

    /// The plant of the reference: CVODE, with friction restarted at each transition between
    /// sticking and sliding.
    [[nodiscard]] NewPlant reference_plant(CvodeMethod method, double relative_tolerance) const;

    /// The width of friction at which a joint at the start comes to rest at the rate 1/`step_s`:
    /// about the narrowest for which the implicit midpoint's iterations converge at that step.
    [[nodiscard]] double friction_width_rad_per_s(double step_s) const;

    /// The error of the force [N], infinite where the plant diverged.
    [[nodiscard]] double error_N(const NewPlant &new_plant) const {
        return force_error_N(run_press(press_, new_plant), reference_);
    }

    /// Points of a chart, without the name of their method.
    [[nodiscard]] ChartPoint point(Integrator integrator, int sub_steps, int repeats,
                                   double width = 0.0) const;
    /// Of `cvode_plant` or `reference_plant`.
    [[nodiscard]] ChartPoint solved_point(const NewPlant &new_plant, double relative_tolerance,
                                          int repeats) const;

private:
    rig::Scenario press_;
    rig::PlantEquations equations_;
    std::vector<simulated::HandTarget> targets_; ///< at the start of each period
    rig::PlantState start_;
    PressRecord reference_;
};

} // namespace springdrive::charts
