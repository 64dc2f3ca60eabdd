#include "engine/lab/charts/integrator_chart.h"

#include "engine/lab/charts/integrator_trial.h"

#include <array>
#include <string>
#include <utility>

namespace springdrive::charts {

namespace {

constexpr std::array<double, 5> kTolerances{1e-2, 1e-4, 1e-6, 1e-8, 1e-10};

struct NamedCvode {
    CvodeMethod method = CvodeMethod::adams;
    const char *name = nullptr;
};
constexpr std::array<NamedCvode, 2> kCvodes{
    {{CvodeMethod::adams, "CVODE (Adams)"}, {CvodeMethod::bdf, "CVODE (BDF)"}}};

SpeedAccuracyChart chart_of(const rig::Scenario &press, std::string name, std::string title,
                            const ChartSetting &setting, const ChartProgress &progress) {
    const IntegratorTrial trial(press);
    SpeedAccuracyChart chart;
    chart.name = std::move(name);
    chart.title = std::move(title);
    chart.cost_label = "processor time per simulated millisecond";
    chart.error_label = "error of the force over the transient, r.m.s. against CVODE at 1e-12 (N)";
    const double lines = kIntegrators.size() + kCvodes.size();
    double done = 0.0;
    for (const NamedIntegrator &named : kIntegrators) {
        for (int sub_steps = 1; sub_steps <= kMaxSubSteps; sub_steps *= 2) {
            chart.points.push_back(trial.point(named.integrator, sub_steps, setting.repeats));
            chart.points.back().method = named.name;
        }
        progress(++done / lines);
    }
    for (const NamedCvode &named : kCvodes) {
        for (const double tolerance : kTolerances) {
            chart.points.push_back(trial.cvode_point(named.method, tolerance, setting.repeats));
            chart.points.back().method = named.name;
        }
        progress(++done / lines);
    }
    return chart;
}

} // namespace

SpeedAccuracyChart integrator_chart(const ChartSetting &setting, const ChartProgress &progress) {
    return chart_of(press_of(setting, rig::pen_press()), "integrators",
                    "Integrators of the plant in hard contact", setting, progress);
}

SpeedAccuracyChart stiff_integrator_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return chart_of(press_of(setting, rig::vice_press()), "integrators_vice",
                    "Integrators of the plant in hard contact, the tip in a vice", setting,
                    progress);
}

} // namespace springdrive::charts
