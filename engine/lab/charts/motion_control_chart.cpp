#include "engine/lab/charts/motion_control_chart.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/control/haptic_law.h"
#include "engine/control/tuning.h"
#include "engine/lab/charts/motion_trial.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::charts {

namespace {

constexpr int kPointsPerAxis = 7;
constexpr int kNormals = 60;
constexpr int kRounds = 100; ///< over the workspace, for one timing

constexpr std::array<int, 5> kCountsPerTurn{256, 1024, 4096, 16'384, 65'536};
constexpr std::array<double, 5> kAlphas_rad2_per_m2{1000.0, 2000.0, 4000.0, 8000.0, 16'000.0};

struct NamedMethod {
    std::string name;
    MotionMethod method;
};

std::array<NamedMethod, 4> methods(const ChartSetting &setting) {
    const double global = control::global_alpha_bound(setting.device);
    const auto transpose = [](std::string_view map, control::AlphaMode mode, double alpha) {
        return NamedMethod{fmt::format("{}, {}", map, control::label_of(mode)),
                           {control::MotionMap::transpose, mode, alpha}};
    };
    const std::string_view name = control::name_of(control::MotionMap::transpose);
    return {{{std::string(control::label_of(control::MotionMap::inverse)),
              {control::MotionMap::inverse, {}, 0.0}},
             transpose(control::label_of(control::MotionMap::transpose),
                       control::AlphaMode::on_the_fly, 0.0),
             transpose(name, control::AlphaMode::global, global),
             transpose(name, control::AlphaMode::by_hand, setting.tuning.alpha_rad2_per_m2)}};
}

void check_static_stiffness(const control::Tuning &tuning) {
    if (!(tuning.K_P_V_per_rad > 0.0 && tuning.eta < 1.0)) {
        throw InputError("the tuning has no static stiffness, so no force results from a "
                         "displacement; choose K_P above 0 and eta below 1");
    }
}

/// The whole law, tick by tick, each at another place.
Cost cost_of_tick(const ChartSetting &setting, const MotionMethod &method,
                  const std::vector<Vector3> &places_rad) {
    const control::HapticLaw law(setting.device);
    const Vector3 rate_rad_per_s(1.0, -2.0, 1.5);
    std::vector<Vector3> theta_rad;
    theta_rad.reserve(places_rad.size());
    for (const Vector3 &q_rad : places_rad) {
        theta_rad.push_back(device::motor_from_joint(setting.device.geometry, q_rad));
    }
    contact::Contact contact;
    contact.tangent_projector -= Vector3::UnitY() * Vector3::UnitY().transpose();
    const double ticks = kRounds * static_cast<double>(theta_rad.size());
    return cost_of(setting.repeats, ticks, [&] {
        for (int round = 0; round < kRounds; ++round) {
            for (const Vector3 &theta : theta_rad) {
                const control::Configuration now = law.configuration(theta, rate_rad_per_s);
                contact.x0_m = now.tip_m + 1e-3 * Vector3::UnitY();
                const control::TipSetPoint target =
                    control::contact_set_point(now.tip_m, now.tip_velocity_m_per_s(), contact, 0.0);
                const control::MotorSetPoint set_point =
                    motor_set_point(setting.device, method, now, target)
                        .value_or(control::no_force(now));
                keep(control::drift_compensation_V(law.k_T(), setting.tuning, now, set_point));
            }
        }
    });
}

/// The 99th percentile of the angle over all places and normals [rad].
double direction_error_99_rad(const ChartSetting &setting, const MotionMethod &method,
                              const std::vector<Vector3> &places_rad, int counts_per_turn) {
    std::vector<double> errors_rad;
    for (const Vector3 &q_rad : places_rad) {
        for (const Vector3 &normal : spread_normals(kNormals)) {
            const Vector3 force_N = force_on_holder_N(setting.device, setting.tuning, method,
                                                      {q_rad, normal, 1e-3, counts_per_turn});
            errors_rad.push_back(control::direction_error_rad(force_N, normal));
        }
    }
    const auto at = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(errors_rad.size()));
    std::ranges::nth_element(errors_rad, errors_rad.begin() + at);
    return errors_rad[static_cast<std::size_t>(at)];
}

/// The mean compliance of the tip along the normal [m/N].
double mean_give_m_per_N(const ChartSetting &setting, const MotionMethod &method,
                         const std::vector<Vector3> &places_rad) {
    double sum = 0.0;
    double count = 0.0;
    for (const Vector3 &q_rad : places_rad) {
        for (const Vector3 &normal : spread_normals(kNormals)) {
            const HeldTip tip{q_rad, normal, 1e-4, 0};
            const Vector3 force_N = force_on_holder_N(setting.device, setting.tuning, method, tip);
            sum += tip.depth_m / normal.dot(force_N);
            ++count;
        }
    }
    return sum / count;
}

bool is_stable_everywhere(const ChartSetting &setting, const MotionMethod &method,
                          const std::vector<Vector3> &places_rad) {
    return std::ranges::all_of(places_rad, [&](const Vector3 &q_rad) {
        return is_stable_at(setting.device, setting.tuning, method, q_rad);
    });
}

std::string alpha_text(double alpha_rad2_per_m2) {
    return "α " + std::to_string(std::lround(alpha_rad2_per_m2));
}

/// The value of α, or its range over the workspace.
std::string setting_text(const ChartSetting &setting, const MotionMethod &method,
                         const std::vector<Vector3> &places_rad) {
    if (method.map == control::MotionMap::inverse) {
        return "no α";
    }
    if (method.alpha_mode != control::AlphaMode::on_the_fly) {
        return alpha_text(method.alpha_rad2_per_m2);
    }
    std::vector<double> bounds;
    bounds.reserve(places_rad.size());
    for (const Vector3 &q_rad : places_rad) {
        bounds.push_back(
            control::alpha_bound(device::motor_jacobian(setting.device.geometry, q_rad),
                                 control::relative_stiffness(setting.device)));
    }
    const auto [minimum, maximum] = std::ranges::minmax(bounds);
    return alpha_text(minimum) + " to " + std::to_string(std::lround(maximum));
}

ChartPoint stiffness_point(const ChartSetting &setting, const NamedMethod &named, const Cost &cost,
                           const std::vector<Vector3> &places_rad) {
    return {named.name, setting_text(setting, named.method, places_rad), cost,
            mean_give_m_per_N(setting, named.method, places_rad),
            is_stable_everywhere(setting, named.method, places_rad)};
}

} // namespace

SpeedAccuracyChart motion_direction_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    check_static_stiffness(setting.tuning);
    const std::vector<Vector3> places_rad = workspace_angles_rad(setting.device, kPointsPerAxis);
    SpeedAccuracyChart chart;
    chart.name = "motion_direction";
    chart.title = "From the tip to the motors: direction of the force, " + setting.device.name;
    chart.cost_label = "processor time per tick, from θ to e_W";
    chart.error_label = "angle from normal to force, 99th percentile (degrees)";
    double done = 0.0;
    for (const NamedMethod &named : methods(setting)) {
        const Cost cost = cost_of_tick(setting, named.method, places_rad);
        const bool stable = is_stable_everywhere(setting, named.method, places_rad);
        for (const int counts : kCountsPerTurn) {
            const double error_rad =
                direction_error_99_rad(setting, named.method, places_rad, counts);
            chart.points.push_back({named.name, std::to_string(counts) + " counts/turn", cost,
                                    error_rad * kDegreesPerRadian, stable});
        }
        progress(++done / 4.0);
    }
    return chart;
}

SpeedAccuracyChart motion_stiffness_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    check_static_stiffness(setting.tuning);
    const std::vector<Vector3> places_rad = workspace_angles_rad(setting.device, kPointsPerAxis);
    SpeedAccuracyChart chart;
    chart.name = "motion_stiffness";
    chart.title = "From the tip to the motors: usable stiffness, " + setting.device.name;
    chart.cost_label = "processor time per tick, from θ to e_W";
    chart.error_label = "mean compliance of a wall (m/N)";
    double done = 0.0;
    for (NamedMethod named : methods(setting)) {
        const Cost cost = cost_of_tick(setting, named.method, places_rad);
        if (named.method.alpha_mode == control::AlphaMode::by_hand) {
            for (const double alpha : kAlphas_rad2_per_m2) {
                named.method.alpha_rad2_per_m2 = alpha;
                chart.points.push_back(stiffness_point(setting, named, cost, places_rad));
            }
        } else {
            chart.points.push_back(stiffness_point(setting, named, cost, places_rad));
        }
        progress(++done / 4.0);
    }
    return chart;
}

} // namespace springdrive::charts
