#include "engine/lab/charts/motion_trial.h"

#include "base/degrees.h"
#include "base/eigenvalues.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/haptic_law.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/charts/charts.h"
#include "engine/lab/loops/stability_case.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::charts {

namespace {

control::Configuration at_rest(const device::DeviceDescription &device, const Vector3 &theta_rad) {
    const Vector3 q_rad = device::joint_from_motor(device.geometry, theta_rad);
    return {theta_rad, Vector3::Zero(), device::tip_position_m(device.geometry, q_rad),
            device::motor_jacobian(device.geometry, q_rad)};
}

/// To the nearest count.
Vector3 quantised(const Vector3 &theta_rad, int counts_per_turn) {
    if (counts_per_turn == 0) {
        return theta_rad;
    }
    const double counts_per_rad = counts_per_turn / (2.0 * std::numbers::pi);
    return (counts_per_rad * theta_rad).array().round() / counts_per_rad;
}

/// The point of the wall nearest to the tip as the encoders show it.
Vector3 proxy_m(const Vector3 &true_tip_m, const Vector3 &estimated_tip_m, const HeldTip &tip) {
    const double height_m = tip.depth_m + tip.normal.dot(true_tip_m - estimated_tip_m);
    return estimated_tip_m + height_m * tip.normal;
}

double alpha_of(const device::DeviceDescription &device, const MotionMethod &method,
                const Matrix3 &J) {
    return method.alpha_mode == control::AlphaMode::on_the_fly
               ? control::alpha_bound(J, control::relative_stiffness(device))
               : method.alpha_rad2_per_m2;
}

/// The share of a displacement that each mode of the map opposes.
Vector3 mode_shares(const device::DeviceDescription &device, const MotionMethod &method,
                    const Matrix3 &J) {
    if (method.map == control::MotionMap::inverse) {
        return Vector3::Ones();
    }
    // Symmetric, and similar to α W⁻¹ JᵀJ.
    const Vector3 W = control::relative_stiffness(device);
    const Matrix3 scaled = J * W.cwiseSqrt().cwiseInverse().asDiagonal();
    const Matrix3 modes = alpha_of(device, method, J) * scaled.transpose() * scaled;
    return symmetric_eigenvalues(modes);
}

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

/// What a tip held at each place and for each normal has, from the tip and the force on its holder.
template <typename Of>
std::vector<double> of_all_presses(const ChartSetting &setting, const MotionMethod &method,
                                   const std::vector<Vector3> &places_rad, double depth_m,
                                   int counts_per_turn, const Of &of) {
    std::vector<double> values;
    for (const Vector3 &q_rad : places_rad) {
        for (const Vector3 &normal : spread_normals(kNormals)) {
            const HeldTip tip{q_rad, normal, depth_m, counts_per_turn};
            values.push_back(
                of(tip, force_on_holder_N(setting.device, setting.tuning, method, tip)));
        }
    }
    return values;
}

/// The 99th percentile of the angle over all places and normals [rad].
double direction_error_99_rad(const ChartSetting &setting, const MotionMethod &method,
                              const std::vector<Vector3> &places_rad, int counts_per_turn) {
    std::vector<double> errors_rad =
        of_all_presses(setting, method, places_rad, 1e-3, counts_per_turn,
                       [](const HeldTip &tip, const Vector3 &force_N) {
                           return control::direction_error_rad(force_N, tip.normal);
                       });
    const auto at = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(errors_rad.size()));
    std::ranges::nth_element(errors_rad, errors_rad.begin() + at);
    return errors_rad[static_cast<std::size_t>(at)];
}

/// The mean compliance of the tip along the normal [m/N].
double mean_give_m_per_N(const ChartSetting &setting, const MotionMethod &method,
                         const std::vector<Vector3> &places_rad) {
    const std::vector<double> all = of_all_presses(setting, method, places_rad, 1e-4, 0,
                                                   [](const HeldTip &tip, const Vector3 &force_N) {
                                                       return tip.depth_m / tip.normal.dot(force_N);
                                                   });
    return std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
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

/// A chart of all methods: each adds its points, from its cost and the places.
template <typename AddPoints>
SpeedAccuracyChart motion_chart(const std::string &name, const std::string &title,
                                const std::string &error_label, const ChartSetting &setting,
                                const ChartProgress &progress, const AddPoints &add_points) {
    check_static_stiffness(setting.tuning);
    const std::vector<Vector3> places_rad = workspace_angles_rad(setting.device, kPointsPerAxis);
    SpeedAccuracyChart chart{name,
                             "From the tip to the motors: " + title + ", " + setting.device.name,
                             "processor time per tick, from θ to e_W",
                             error_label,
                             {}};
    double done = 0.0;
    for (const NamedMethod &named : methods(setting)) {
        const Cost cost = cost_of_tick(setting, named.method, places_rad);
        add_points(chart.points, named, cost, places_rad);
        progress(++done / 4.0);
    }
    return chart;
}

} // namespace

std::optional<control::MotorSetPoint> motor_set_point(const device::DeviceDescription &device,
                                                      const MotionMethod &method,
                                                      const control::Configuration &now,
                                                      const control::TipSetPoint &target) {
    if (method.map == control::MotionMap::inverse) {
        return control::inverse_map(device.geometry, now, target);
    }
    return control::transpose_map(now, target, alpha_of(device, method, now.J),
                                  control::relative_stiffness(device));
}

Vector3 force_on_holder_N(const device::DeviceDescription &device, const control::Tuning &tuning,
                          const MotionMethod &method, const HeldTip &tip) {
    const control::Configuration truth =
        at_rest(device, device::motor_from_joint(device.geometry, tip.q_rad));
    const control::Configuration estimated =
        at_rest(device, quantised(truth.theta_rad, tip.counts_per_turn));
    contact::Contact contact;
    contact.x0_m = proxy_m(truth.tip_m, estimated.tip_m, tip);
    const control::TipSetPoint target =
        control::contact_set_point(estimated.tip_m, Vector3::Zero(), contact, tuning.eta);
    const std::optional<control::MotorSetPoint> set_point =
        motor_set_point(device, method, estimated, target);
    if (!set_point) {
        return Vector3::Zero();
    }
    return control::static_tip_force(truth.J,
                                     control::static_stiffness_Nm_per_rad(device.motor, tuning),
                                     set_point->theta_Sd_rad - estimated.theta_rad);
}

std::vector<Vector3> workspace_angles_rad(const device::DeviceDescription &device,
                                          int points_per_axis) {
    std::vector<Vector3> all;
    const auto share = [&](int i) { return (i + 0.5) / points_per_axis - 0.5; };
    for (int i = 0; i < points_per_axis; ++i) {
        for (int j = 0; j < points_per_axis; ++j) {
            for (int k = 0; k < points_per_axis; ++k) {
                const Vector3 tip_m =
                    device.workspace.centre_m +
                    device.workspace.size_m.cwiseProduct(Vector3(share(i), share(j), share(k)));
                if (device::can_reach(device, tip_m)) {
                    all.push_back(*device::joint_angles_rad(device.geometry, tip_m));
                }
            }
        }
    }
    return all;
}

std::vector<Vector3> spread_normals(int count) {
    std::vector<Vector3> normals;
    for (int i = 0; i < count; ++i) {
        const double height = 1.0 - (2.0 * i + 1.0) / count;
        const double angle_rad = 2.0 * std::numbers::pi * std::numbers::phi * i;
        const double across = std::sqrt(1.0 - height * height);
        normals.emplace_back(across * std::cos(angle_rad), height, across * std::sin(angle_rad));
    }
    return normals;
}

bool is_stable_at(const device::DeviceDescription &device, const control::Tuning &tuning,
                  const MotionMethod &method, const Vector3 &q_rad) {
    const Vector3 shares =
        mode_shares(device, method, device::motor_jacobian(device.geometry, q_rad));
    loops::StabilityCase each = loops::motors_alone(device, tuning);
    for (const double share : shares) {
        each.tuning.eta = 1.0 - (1.0 - tuning.eta) * share;
        if (!loops::is_stable(each)) {
            return false;
        }
    }
    return true;
}

SpeedAccuracyChart motion_direction_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return motion_chart(
        "motion_direction", "direction of the force",
        "angle from normal to force, 99th percentile (degrees)", setting, progress,
        [&](std::vector<ChartPoint> &points, const NamedMethod &named, const Cost &cost,
            const std::vector<Vector3> &places_rad) {
            const bool stable = is_stable_everywhere(setting, named.method, places_rad);
            for (const int counts : kCountsPerTurn) {
                const double error_rad =
                    direction_error_99_rad(setting, named.method, places_rad, counts);
                points.push_back({named.name, std::to_string(counts) + " counts/turn", cost,
                                  error_rad * kDegreesPerRadian, stable});
            }
        });
}

SpeedAccuracyChart motion_stiffness_chart(const ChartSetting &setting,
                                          const ChartProgress &progress) {
    return motion_chart(
        "motion_stiffness", "usable stiffness", "mean compliance of a wall (m/N)", setting,
        progress,
        [&](std::vector<ChartPoint> &points, const NamedMethod &named, const Cost &cost,
            const std::vector<Vector3> &places_rad) {
            MotionMethod method = named.method;
            const bool by_hand = method.alpha_mode == control::AlphaMode::by_hand;
            for (const double alpha : by_hand ? std::vector<double>(kAlphas_rad2_per_m2.begin(),
                                                                    kAlphas_rad2_per_m2.end())
                                              : std::vector<double>{method.alpha_rad2_per_m2}) {
                method.alpha_rad2_per_m2 = alpha;
                points.push_back({named.name, setting_text(setting, method, places_rad), cost,
                                  mean_give_m_per_N(setting, method, places_rad),
                                  is_stable_everywhere(setting, method, places_rad)});
            }
        });
}

} // namespace springdrive::charts
