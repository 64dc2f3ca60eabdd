// One press (contact_press.h) of the plant (plant_equations.h) by many integrators, against CVODE
// at a tight tolerance. "Ours" is the simulated device itself.
#pragma once

#include "engine/lab/charts/chart.h"
#include "engine/lab/charts/contact_press.h"
#include "engine/lab/charts/cvode_solver.h"
#include "engine/lab/rig/plant_equations.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace springdrive::charts {

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

    /// The error of the force [N], infinite where the integrator diverged.
    [[nodiscard]] double error_N(Integrator integrator, int sub_steps) const;

    /// Points of a chart, without the name of their method.
    [[nodiscard]] ChartPoint point(Integrator integrator, int sub_steps, int repeats,
                                   double width = 0.0) const;
    [[nodiscard]] ChartPoint cvode_point(CvodeMethod method, double relative_tolerance, int repeats,
                                         double width = 0.0) const;
    [[nodiscard]] ChartPoint reference_point(double relative_tolerance, int repeats) const;

private:
    [[nodiscard]] ChartPoint solved_point(const NewPlant &new_plant, double relative_tolerance,
                                          int repeats) const;

    rig::Scenario press_;
    rig::PlantEquations equations_;
    std::vector<simulated::HandTarget> targets_; ///< at the start of each period
    rig::PlantState start_;
    PressRecord reference_;
};

} // namespace springdrive::charts
