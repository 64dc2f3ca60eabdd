#include "app/plots/stiffness_curves.h"

#include "app/widgets/widgets.h"
#include "engine/lab/loops/rendered_stiffness.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace springdrive::app {

namespace {

constexpr double kFirst_Hz = 1.0;
constexpr int kPredicted = 160;
constexpr int kMeasured = 25;

// Greys: no channel is shown, whose colour they could have.
const Stroke kAnalytic{kFaintInk, 1.4F, Dash::dashed};
const Stroke kSampled{{0.74F, 0.77F, 0.81F, 1.0F}, 1.8F};
const ImVec4 kMeasuredInk = kInk;

/// The sweep goes up to a quarter of the servo rate, as that of the command `stiffness`.
double last_Hz(const loops::SpringDrive &drive) { return 0.25 / drive.period_s; }

double omega(double frequency_Hz) { return 2.0 * std::numbers::pi * frequency_Hz; }

bool is_same(const loops::SpringDrive &a, const loops::SpringDrive &b) {
    return a.tuning == b.tuning && a.period_s == b.period_s && a.delay_periods == b.delay_periods &&
           a.motor.resistance_Ohm == b.motor.resistance_Ohm &&
           a.motor.inductance_H == b.motor.inductance_H &&
           a.motor.torque_constant_Nm_per_A == b.motor.torque_constant_Nm_per_A;
}

void draw_curve_of(Canvas &canvas, const PlotArea &area, const Curve &curve, const Stroke &stroke) {
    std::vector<ImVec2> points;
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
        points.push_back(area.place(curve.x[i], curve.y[i]));
    }
    canvas.polyline(points, stroke);
}

} // namespace

void StiffnessCurves::update(const loops::SpringDrive &now) {
    if (auto points = sweep_.take()) {
        measured_ = std::move(*points);
        measured_with_ = swept_with_;
    }
    if (has_drive_ && is_same(drive_, now)) {
        return;
    }
    drive_ = now;
    has_drive_ = true;
    analytic_ = sampled_ = {};
    const double ratio = last_Hz(now) / kFirst_Hz;
    for (int i = 0; i < kPredicted; ++i) {
        const double frequency_Hz = kFirst_Hz * std::pow(ratio, i / (kPredicted - 1.0));
        analytic_.x.push_back(frequency_Hz);
        analytic_.y.push_back(std::abs(loops::analytic_stiffness(now, omega(frequency_Hz))));
        sampled_.x.push_back(frequency_Hz);
        sampled_.y.push_back(std::abs(loops::sampled_stiffness(now, omega(frequency_Hz))));
    }
}

void StiffnessCurves::start_sweep() {
    if (!has_drive_) {
        return;
    }
    swept_with_ = drive_.tuning;
    sweep_.start([drive = drive_](BackgroundTalk &talk) {
        std::vector<loops::StiffnessPoint> points;
        const double ratio = last_Hz(drive) / kFirst_Hz;
        for (int i = 0; i < kMeasured; ++i) {
            talk.report("sweep", static_cast<double>(i) / kMeasured);
            const double requested_Hz = kFirst_Hz * std::pow(ratio, i / (kMeasured - 1.0));
            const loops::SweepWindow window = loops::sweep_window(requested_Hz, drive.period_s);
            loops::StiffnessPoint point;
            point.frequency_hz = window.frequency_hz(drive.period_s);
            point.analytic_Nm_per_rad = loops::analytic_stiffness(drive, omega(point.frequency_hz));
            point.sampled_Nm_per_rad = loops::sampled_stiffness(drive, omega(point.frequency_hz));
            point.measured_Nm_per_rad = loops::measured_stiffness(drive, window);
            points.push_back(point);
        }
        return points;
    });
}

PlotArea StiffnessCurves::draw(Canvas &canvas, const Rectangle &where,
                               const PlotSettings &settings) const {
    double least = 1e300;
    double greatest = 1e-300;
    for (const Curve *curve : {&analytic_, &sampled_}) {
        for (const double value : curve->y) {
            least = std::min(least, value);
            greatest = std::max(greatest, value);
        }
    }
    const bool is_empty = !(least < greatest);
    const Axis x = settings.x.value_or(Axis{kFirst_Hz, last_Hz(drive_), true});
    const Axis y = settings.y.value_or(is_empty ? Axis{0.1, 10.0, true}
                                                : Axis{0.7 * least, 1.4 * greatest, true});
    const PlotArea area = draw_axes(canvas, where, x, y, "Hz", "|K_θ|, N·m/rad");
    canvas.clip(area.where);
    draw_curve_of(canvas, area, analytic_, kAnalytic);
    draw_curve_of(canvas, area, sampled_, kSampled);
    ImVec4 ink = kMeasuredInk;
    ink.w = is_of_now() ? 1.0F : 0.4F; // of a former tuning
    for (const loops::StiffnessPoint &point : measured_) {
        canvas.dot(area.place(point.frequency_hz, std::abs(point.measured_Nm_per_rad)), 3.0F, ink);
    }
    const float height = text_height();
    ImVec2 at{area.where.corner.x + 0.5F * height, area.where.corner.y + 0.2F * height};
    const auto legend = [&](const ImVec4 &colour, std::string_view text) {
        canvas.text(at, colour, text);
        at.y += height;
    };
    legend(kAnalytic.colour, "- - (12), continuous");
    legend(kSampled.colour, "— sampled");
    if (!measured_.empty()) {
        legend(ink, is_of_now() ? "• measured" : "• measured, with the tuning before");
    }
    canvas.unclip();
    return area;
}

std::string StiffnessCurves::values_at(double frequency_Hz) const {
    return fmt::format("{:.3g} Hz\n(12): {:.4g} N·m/rad\nsampled: {:.4g} N·m/rad", frequency_Hz,
                       std::abs(loops::analytic_stiffness(drive_, omega(frequency_Hz))),
                       std::abs(loops::sampled_stiffness(drive_, omega(frequency_Hz))));
}

} // namespace springdrive::app
