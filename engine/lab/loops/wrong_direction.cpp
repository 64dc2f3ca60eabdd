#include "engine/lab/loops/wrong_direction.h"

#include "base/degrees.h"
#include "device/core/motor/motor.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/force_direction.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace springdrive::loops {

namespace {

/// J is singular for all practical purposes if its columns span less than this share of the box
/// that they would span if they were square to each other.
constexpr double kMinVolumeShare = 1e-4;

bool is_regular(const Matrix3 &J) {
    const double box = J.col(0).norm() * J.col(1).norm() * J.col(2).norm();
    return std::abs(J.determinant()) > kMinVolumeShare * box;
}

/// Whether the joints are that far from their limits.
bool is_within(const device::JointLimits &limits, const Vector3 &q_rad, double margin_rad) {
    device::JointLimits narrow = limits;
    narrow.min_rad.array() += margin_rad;
    narrow.max_rad.array() -= margin_rad;
    narrow.min_q3_minus_q2_rad += margin_rad;
    narrow.max_q3_minus_q2_rad -= margin_rad;
    return narrow.allow(q_rad);
}

/// Whether device and amplifiers have that much to spare.
bool is_harmless(const device::DeviceDescription &device, const Matrix3 &J,
                 const Vector3 &force_N) {
    constexpr double kShare = 0.5;
    if (!(force_N.norm() <= kShare * device.limits.tip_force_N)) {
        return false;
    }
    const Vector3 torque_Nm = J.transpose() * force_N;
    for (std::size_t j = 0; j < 3; ++j) {
        const device::MotorParameters &motor = device.motor[j];
        const double limit_A =
            std::min(motor.peak_current_A, motor.supply_V / motor.resistance_Ohm);
        const double current_A =
            std::abs(torque_Nm[static_cast<Eigen::Index>(j)]) / motor.torque_constant_Nm_per_A;
        if (!(current_A <= kShare * limit_A)) {
            return false;
        }
    }
    return true;
}

/// Directions all over the unit sphere: a cube's faces, divided and projected. Its corners bulge
/// less than a grid of angles does at its poles.
std::vector<Vector3> directions(int frequency) {
    std::vector<Vector3> all;
    const auto along = [frequency](int i) { return -1.0 + (2.0 * i + 1.0) / frequency; };
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            for (int i = 0; i < frequency; ++i) {
                for (int j = 0; j < frequency; ++j) {
                    Vector3 direction = Vector3::Zero();
                    direction[axis] = side;
                    direction[(axis + 1) % 3] = along(i);
                    direction[(axis + 2) % 3] = along(j);
                    all.push_back(direction.normalized());
                }
            }
        }
    }
    return all;
}

/// A place, and what it has for all normals.
class Place {
public:
    Place(const device::DeviceDescription &device, const PressSearch &search, const Vector3 &tip_m)
        : device_(device), search_(search), tip_m_(tip_m) {
        const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (q_rad && is_within(device.joint_limits, *q_rad, search.margin_rad)) {
            q_rad_ = *q_rad;
            J_ = device::motor_jacobian(device.geometry, q_rad_);
            can_be_ = is_regular(J_);
        }
        if (can_be_) {
            K_ = inverse_tip_stiffness(device, search.tuning, q_rad_);
        }
    }

    [[nodiscard]] bool can_be() const { return can_be_; }
    [[nodiscard]] Press press(const Vector3 &normal) const { return {tip_m_, q_rad_, normal}; }

    /// Of the inverse map; nothing if that press does not count.
    [[nodiscard]] std::optional<double> error_rad(const Vector3 &normal) const {
        const Vector3 force_N = search_.depth_m * K_ * normal;
        if ((search_.accepts && !search_.accepts(press(normal))) ||
            !is_harmless(device_, J_, force_N)) {
            return std::nullopt;
        }
        return control::direction_error_rad(force_N, normal);
    }

private:
    const device::DeviceDescription &device_;
    const PressSearch &search_;
    Vector3 tip_m_;
    Vector3 q_rad_{Vector3::Zero()};
    Matrix3 J_{Matrix3::Zero()};
    Matrix3 K_{Matrix3::Zero()};
    bool can_be_ = false;
};

struct Found {
    Press press;
    double error_rad = -std::numeric_limits<double>::infinity();
};

/// The coordinates along one axis of the box.
std::vector<double> along_axis(double lower, double upper, int points) {
    if (!(upper > lower) || points < 2) {
        return {0.5 * (lower + upper)};
    }
    std::vector<double> all;
    for (int i = 0; i < points; ++i) {
        all.push_back(lower + (upper - lower) * i / (points - 1));
    }
    return all;
}

/// The best normal of each place that has any, the best place first.
std::vector<Found> on_the_grid(const device::DeviceDescription &device, const PressSearch &search) {
    const std::vector<Vector3> normals = directions(search.normal_frequency);
    std::array<std::vector<double>, 3> axis;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto c = static_cast<Eigen::Index>(i);
        axis[i] = along_axis(search.lower_m[c], search.upper_m[c], search.points_per_axis);
    }
    std::vector<Found> best;
    for (const double x : axis[0]) {
        for (const double y : axis[1]) {
            for (const double z : axis[2]) {
                const Place place(device, search, {x, y, z});
                Found here;
                for (const Vector3 &normal : normals) {
                    const auto error_rad = place.can_be() ? place.error_rad(normal) : std::nullopt;
                    if (error_rad && *error_rad > here.error_rad) {
                        here = {place.press(normal), *error_rad};
                    }
                }
                if (std::isfinite(here.error_rad)) {
                    best.push_back(here);
                }
            }
        }
    }
    std::ranges::stable_sort(
        best, [](const Found &a, const Found &b) { return a.error_rad > b.error_rad; });
    return best;
}

/// Tries one step to either side along each axis of place and normal. True if one was better.
bool improve(const device::DeviceDescription &device, const PressSearch &search, double step_m,
             double step_rad, Found &found) {
    const Vector3 across = found.press.normal.unitOrthogonal();
    const std::array<Vector3, 2> turns{across, found.press.normal.cross(across)};
    Found best = found;
    const auto consider = [&](const Vector3 &tip_m, const Vector3 &normal) {
        const Vector3 inside_m = tip_m.cwiseMax(search.lower_m).cwiseMin(search.upper_m);
        const Place place(device, search, inside_m);
        const auto error_rad = place.can_be() ? place.error_rad(normal) : std::nullopt;
        if (error_rad && *error_rad > best.error_rad) {
            best = {place.press(normal), *error_rad};
        }
    };
    for (const double sign : {-1.0, 1.0}) {
        for (int c = 0; c < 3; ++c) {
            consider(found.press.tip_m + sign * step_m * Vector3::Unit(c), found.press.normal);
        }
        for (const Vector3 &turn : turns) {
            consider(found.press.tip_m,
                     (found.press.normal + sign * std::tan(step_rad) * turn).normalized());
        }
    }
    const bool is_better = best.error_rad > found.error_rad;
    found = best;
    return is_better;
}

/// Uphill until no step of a micrometre and a microradian is better.
Found uphill(const device::DeviceDescription &device, const PressSearch &search, Found found) {
    constexpr double kMin_m = 1e-6;
    constexpr double kMin_rad = 1e-6;
    double step_m = (search.upper_m - search.lower_m).maxCoeff() / search.points_per_axis;
    double step_rad = 1.0 / search.normal_frequency;
    while (step_m > kMin_m || step_rad > kMin_rad) {
        if (!improve(device, search, step_m, step_rad, found)) {
            step_m *= 0.5;
            step_rad *= 0.5;
        }
    }
    return found;
}

} // namespace

Matrix3 inverse_tip_stiffness(const device::DeviceDescription &device,
                              const control::Tuning &tuning, const Vector3 &q_rad) {
    const Vector3 K_q =
        (1.0 - tuning.eta) * control::static_stiffness_Nm_per_rad(device.motor, tuning);
    const Matrix3 J_inverse = device::motor_jacobian(device.geometry, q_rad).inverse();
    return J_inverse.transpose() * K_q.asDiagonal() * J_inverse;
}

double inverse_error_rad(const device::DeviceDescription &device, const control::Tuning &tuning,
                         const Press &press) {
    return control::direction_error_rad(
        inverse_tip_stiffness(device, tuning, press.q_rad) * press.normal, press.normal);
}

double transpose_error_rad(const device::DeviceDescription &device, const Press &press,
                           double share) {
    const Matrix3 J = device::motor_jacobian(device.geometry, press.q_rad);
    const Matrix3 J_inverse_transposed = J.transpose().inverse();
    double largest_rad = 0.0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        Vector3 D;
        for (unsigned j = 0; j < 3; ++j) {
            D[j] = (corner >> j & 1U) != 0 ? 1.0 + share : 1.0 - share;
        }
        const Vector3 force =
            J_inverse_transposed * D.cwiseProduct(Vector3(J.transpose() * press.normal));
        largest_rad = std::max(largest_rad, control::direction_error_rad(force, press.normal));
    }
    return largest_rad;
}

PressSearch everywhere(const device::DeviceDescription &device, const control::Tuning &tuning) {
    PressSearch search;
    search.tuning = tuning;
    search.lower_m = device.workspace.centre_m - 0.5 * device.workspace.size_m;
    search.upper_m = device.workspace.centre_m + 0.5 * device.workspace.size_m;
    search.margin_rad = device.edge.margin_rad;
    return search;
}

PressSearch with_ease(const device::DeviceDescription &device, const control::Tuning &tuning) {
    constexpr double kInner = 0.8;
    constexpr double kBeforeEdge_deg = 10.0;
    constexpr double kSteepest_deg = 45.0;
    constexpr double kBelowStart_m = 0.015;
    constexpr double kForearm_deg = 30.0;
    PressSearch search = everywhere(device, tuning);
    search.lower_m = device.workspace.centre_m - 0.5 * kInner * device.workspace.size_m;
    search.upper_m = device.workspace.centre_m + 0.5 * kInner * device.workspace.size_m;
    search.lower_m.x() = search.upper_m.x() = device.workspace.centre_m.x();
    search.points_per_axis = 33; // two dimensions only
    search.margin_rad += kBeforeEdge_deg * kRadiansPerDegree;
    const double min_up = std::cos(kSteepest_deg * kRadiansPerDegree);
    const double min_sine = std::sin(kForearm_deg * kRadiansPerDegree);
    search.accepts = [=, geometry = device.geometry](const Press &press) {
        if (press.normal.y() < min_up || press.normal.dot(-press.tip_m) < kBelowStart_m) {
            return false; // the zero pose has the tip at the origin
        }
        const device::LinkagePose pose = device::linkage_pose(geometry, press.q_rad);
        return (pose.elbow_m - pose.tip_m).normalized().dot(press.normal) >= min_sine;
    };
    return search;
}

std::optional<Press> most_wrong_press(const device::DeviceDescription &device,
                                      const PressSearch &search) {
    constexpr std::size_t kStarts = 8; // hills may be several, and constraints have corners
    const std::vector<Found> starts = on_the_grid(device, search);
    if (starts.empty()) {
        return std::nullopt;
    }
    Found best;
    for (std::size_t i = 0; i < std::min(kStarts, starts.size()); ++i) {
        const Found top = uphill(device, search, starts[i]);
        if (top.error_rad > best.error_rad) {
            best = top;
        }
    }
    return best.press;
}

} // namespace springdrive::loops
