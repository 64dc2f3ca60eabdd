#include "engine/lab/charts/friction_integrator_chart.h"

#include "engine/lab/charts/integrator_trial.h"

#include <array>
#include <string>

namespace springdrive::charts {

namespace {

constexpr std::array<double, 6> kFrictionTolerances{1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8};

/// Settings of CVODE with smoothed friction.
struct Smoothing {
    double tolerance = 0.0;
    double width_rad_per_s = 0.0;
};

/// The best of a grid of tolerances and widths in decades, for the PHANTOM 1.0: narrower friction
/// costs more there, and wider friction has a larger error.
constexpr std::array<Smoothing, 6> kSmoothings{
    {{1e-2, 1e-3}, {1e-3, 1e-4}, {1e-4, 1e-5}, {1e-5, 1e-6}, {1e-6, 1e-6}, {1e-7, 1e-7}}};

} // namespace

SpeedAccuracyChart friction_integrator_chart(const ChartSetting &setting,
                                             const ChartProgress &progress) {
    const IntegratorTrial trial(press_of(setting, rig::sticking_press()));
    SpeedAccuracyChart chart;
    chart.name = "integrators_friction";
    chart.title = "Integrators of the plant in hard contact with stick-slip friction";
    chart.cost_label = "processor time per simulated millisecond";
    chart.error_label = "error of the force over the transient, r.m.s. against CVODE at 1e-12 (N)";
    const double lines = kIntegrators.size() + 2.0;
    double done = 0.0;
    for (const NamedIntegrator &named : kIntegrators) {
        const bool is_smoothed = named.integrator == Integrator::implicit_midpoint;
        for (int sub_steps = 1; sub_steps <= kMaxFrictionSubSteps; sub_steps *= 2) {
            const double step_s = trial.press().simulation.servo_period_s / sub_steps;
            const double width = is_smoothed ? trial.friction_width_rad_per_s(step_s) : 0.0;
            chart.points.push_back(
                trial.point(named.integrator, sub_steps, setting.repeats, width));
            chart.points.back().method = std::string(named.name) + (is_smoothed ? ", smooth" : "");
        }
        progress(++done / lines);
    }
    for (const Smoothing &smoothing : kSmoothings) {
        chart.points.push_back(trial.cvode_point(CvodeMethod::bdf, smoothing.tolerance,
                                                 setting.repeats, smoothing.width_rad_per_s));
        chart.points.back().method = "CVODE (BDF), smooth";
    }
    progress(++done / lines);
    for (const double tolerance : kFrictionTolerances) {
        chart.points.push_back(trial.reference_point(tolerance, setting.repeats));
        chart.points.back().method = "CVODE, slip to stick";
    }
    progress(++done / lines);
    return chart;
}

} // namespace springdrive::charts
