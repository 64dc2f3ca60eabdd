// The charts of integrators and of plant models.
#include "engine/lab/charts/charts.h"
#include "engine/lab/charts/press_trial.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace springdrive::charts {

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
