#include "engine/servo/servo_sample.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>

namespace springdrive {

namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// Calls `visit(name, value)` for every column: the one list behind header and rows.
template <typename Visit> void for_each_column(const ServoSample &s, Visit &&visit) {
    const auto vector = [&visit](const char *name, const char *unit, const Vector3 &v) {
        constexpr std::array<const char *, 3> kAxes{"x", "y", "z"};
        for (Eigen::Index i = 0; i < 3; ++i) {
            visit(std::string(name) + "_" + kAxes[static_cast<std::size_t>(i)] + "_" + unit, v[i]);
        }
    };
    const auto motors = [&visit](const char *name, const char *unit, const Vector3 &v) {
        for (Eigen::Index i = 0; i < 3; ++i) {
            visit(std::string(name) + std::to_string(i + 1) + "_" + unit, v[i]);
        }
    };
    visit("tick", static_cast<double>(s.tick));
    visit("time_s", s.time_s);
    motors("counts", "count", Vector3(s.counts[0], s.counts[1], s.counts[2]));
    motors("theta", "rad", s.theta_rad);
    motors("theta_rate", "rad_per_s", s.theta_rate_rad_per_s);
    vector("tip", "m", s.tip_m);
    visit("touching", s.contact.touching ? 1.0 : 0.0);
    visit("constraints", static_cast<double>(s.contact.active_constraints));
    vector("proxy", "m", s.contact.x0_m);
    vector("normal", "1", s.contact.normal);
    visit("eta", s.eta);
    visit("alpha_rad2_per_m2", s.alpha_rad2_per_m2);
    visit("alpha_bound_rad2_per_m2", s.alpha_bound_rad2_per_m2);
    vector("x_Sd", "m", s.x_Sd_m);
    motors("theta_Sd", "rad", s.theta_Sd_rad);
    motors("e_W", "V", s.command.e_W_V);
    motors("R_hat", "Ohm", s.command.cancelled_resistance_Ohm);
    motors("current", "A", s.current_A);
    vector("force", "N", s.tip_force_N);
    visit("rendered_error_deg", s.rendered_error_rad * kDegreesPerRadian);
    visit("inverse_error_deg", s.inverse_error_rad * kDegreesPerRadian);
    visit("transpose_error_deg", s.transpose_error_rad * kDegreesPerRadian);
    visit("map_is_transpose", s.tuning.map == MotionMap::transpose ? 1.0 : 0.0);
    visit("inverse_possible", s.inverse_possible ? 1.0 : 0.0);
    visit("safety_state", static_cast<double>(s.safety.state));
    visit("trip_cause", static_cast<double>(s.safety.cause));
    const auto windings = [&](const char *name, const char *unit, const auto &number) {
        motors(name, unit, {number(s.winding[0]), number(s.winding[1]), number(s.winding[2])});
    };
    windings("winding_least", "C", [](const WindingStatus &w) { return w.least_C; });
    windings("winding_greatest", "C", [](const WindingStatus &w) { return w.greatest_C; });
    windings("R_hat_limit", "Ohm", [](const WindingStatus &w) { return w.R_hat_limit_Ohm; });
    windings("R_hat_limited", "1", [](const WindingStatus &w) { return w.is_limited ? 1.0 : 0.0; });
    visit("scene_id", static_cast<double>(s.scene_id));
    visit("period_s", s.period_s);
    visit("compute_s", s.compute_s);
    visit("exchange_s", s.exchange_s);
}

} // namespace

std::string telemetry_header() {
    std::string line;
    for_each_column(ServoSample{}, [&line](const std::string &name, double) {
        line += (line.empty() ? "" : ",") + name;
    });
    return line;
}

std::string telemetry_row(const ServoSample &sample) {
    std::string line;
    bool first = true;
    for_each_column(sample, [&](const std::string &, double value) {
        if (!first) {
            line += ',';
        }
        first = false;
        if (!std::isnan(value)) {
            std::array<char, 32> digits{};
            const auto end = std::to_chars(digits.begin(), digits.end(), value).ptr;
            line.append(digits.begin(), end);
        }
    });
    return line;
}

} // namespace springdrive
