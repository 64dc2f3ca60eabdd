// Covers the scene "wrong_direction" and, with engine/lab/limits/locked_device.cpp, what is felt
// there: where, and on which surface, the force of the inverse map (18) deviates most from the
// normal. At rest a tip held at depth δ in a surface with unit normal n feels δ J⁻ᵀ K_q J⁻¹ n (21).
#include "engine/lab/loops/both_maps.h"

#include "assets/scenes/shapes.h"
#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/force_direction.h"
#include "engine/lab/limits/locked_device.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive::loops {
namespace {

const device::DeviceDescription &phantom() {
    static const device::DeviceDescription device = testing::phantom_1_0();
    return device;
}

const scenes::Spot &spot() {
    static const std::vector<scenes::SceneDescription> all = scenes::all_scenes();
    return std::ranges::find(all, "wrong_direction", &scenes::SceneDescription::name)
        ->lesson.spot.value();
}

/// Whether a press is easy to make and to see: from above on what slopes by 45° at most, 15 mm or
/// more below a tip that starts in the zero pose, which has it at the origin, with the forearm 30°
/// or more off the surface; by joints that are 15° before the limits of
/// assets/devices/phantom_1_0.toml.
bool is_easy(const Vector3 &q_rad, const Vector3 &tip_m, const Vector3 &normal) {
    const Vector3 q_deg = kDegreesPerRadian * q_rad;
    const double fold_deg = q_deg[2] - q_deg[1];
    if (std::abs(q_deg[0]) > 75.0 || q_deg[1] < -109.0 || q_deg[1] > 104.0 || q_deg[2] < -14.0 ||
        q_deg[2] > 199.0 || fold_deg > 40.0 || fold_deg < -50.0) {
        return false;
    }
    const device::LinkagePose pose = device::linkage_pose(phantom().geometry, q_rad);
    return normal.y() >= std::cos(45.0 * kRadiansPerDegree) && normal.dot(-tip_m) >= 0.015 &&
           (pose.elbow_m - pose.tip_m).normalized().dot(normal) >= 0.5;
}

/// The largest error of a grid of easy presses in the middle plane of the inner 80 % of the
/// workspace [rad].
double worst_of_a_grid_rad(int places, int angles) {
    const device::DeviceDescription &device = phantom();
    double worst_rad = 0.0;
    for (int i = 0; i <= places * places + 2 * places; ++i) {
        const Vector3 share(0.0, static_cast<double>(i % (places + 1)) / places - 0.5,
                            static_cast<double>(i / (places + 1)) / places - 0.5);
        const Vector3 tip_m =
            device.workspace.centre_m + 0.8 * share.cwiseProduct(device.workspace.size_m);
        const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (!q_rad) {
            continue;
        }
        const Matrix3 K = inverse_tip_stiffness(device, {}, *q_rad);
        for (int a = 0; a <= angles; ++a) { // from vertical to 45°
            for (int b = 0; b < 8 * angles; ++b) {
                const double polar_rad = M_PI * a / (4.0 * angles);
                const double round_rad = M_PI * b / (4.0 * angles);
                const Vector3 normal(std::sin(polar_rad) * std::cos(round_rad), std::cos(polar_rad),
                                     std::sin(polar_rad) * std::sin(round_rad));
                if (is_easy(*q_rad, tip_m, normal)) {
                    worst_rad =
                        std::max(worst_rad, control::direction_error_rad(K * normal, normal));
                }
            }
        }
    }
    return worst_rad;
}

TEST(WrongDirectionScene, IsWhereTheInverseMapErrsMostOfAllEasyPresses) {
    const Vector3 q_rad = device::joint_angles_rad(phantom().geometry, spot().point_m).value();
    const Vector3 beside_m = spot().point_m - phantom().workspace.centre_m;
    EXPECT_TRUE((beside_m.array().abs() <= 0.4 * phantom().workspace.size_m.array() + 1e-4).all());
    const double error_rad = control::direction_error_rad(
        inverse_tip_stiffness(phantom(), {}, q_rad) * spot().normal, spot().normal);
    EXPECT_GT(error_rad, 35.0 * kRadiansPerDegree);
    const double worst_rad = worst_of_a_grid_rad(40, 12);
    EXPECT_LE(worst_rad, error_rad + 0.2 * kRadiansPerDegree); // the spot's numbers are rounded
    // Normals 4° apart miss a maximum, around which the angle falls by at most Δ² (λ_max/λ_min) for
    // Δ in rad, by less than 1°; places 2 % of the box apart by less than half of that.
    EXPECT_GT(worst_rad, error_rad - 1.5 * kRadiansPerDegree);
}

/// The true force on a vice with a sensor, weight apart: of a device with motors and sensors of its
/// own, friction and encoders.
TEST(WrongDirectionScene, ThereTheTrueForceIsWrongWithOneMapAndRightWithTheOther) {
    const double normal_rad =
        std::atan2(spot().normal.y(), spot().normal.z()); // from outward to up
    limits::LockedDeviceOptions options;
    options.q_rad = *device::joint_angles_rad(phantom().geometry, spot().point_m);
    options.device_seed = 3;
    options.observes_resistance = true;
    const auto error_deg = [&](control::MotionMap map) {
        options.penetration_m = limits::harmless_penetration_m(phantom(), {}, options.q_rad, map);
        return kDegreesPerRadian *
               std::abs(limits::press_locked_device(phantom(), options, map, normal_rad).error_rad);
    };
    EXPECT_GT(error_deg(control::MotionMap::inverse), 35.0);
    EXPECT_LT(error_deg(control::MotionMap::transpose), 5.0);
}

} // namespace
} // namespace springdrive::loops
