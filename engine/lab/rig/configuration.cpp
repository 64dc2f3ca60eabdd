#include "engine/lab/rig/configuration.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"

#include <fmt/core.h>

#include <array>
#include <optional>

namespace springdrive::rig {

namespace {

struct LimitedAngle {
    const char *name;
    double rad;
    double min_rad;
    double max_rad;
};

} // namespace

void check_configuration(const device::DeviceDescription &device, const Vector3 &q_rad) {
    const device::JointLimits &limits = device.joint_limits;
    const std::array<LimitedAngle, 4> angles{
        {{"q1", q_rad[0], limits.min_rad[0], limits.max_rad[0]},
         {"q2", q_rad[1], limits.min_rad[1], limits.max_rad[1]},
         {"q3", q_rad[2], limits.min_rad[2], limits.max_rad[2]},
         {"q3 - q2", q_rad[2] - q_rad[1], limits.min_q3_minus_q2_rad, limits.max_q3_minus_q2_rad}}};
    for (const LimitedAngle &angle : angles) {
        if (!(angle.rad >= angle.min_rad && angle.rad <= angle.max_rad)) { // a NaN too
            throw InputError(fmt::format(
                "{} is {:g}°; {} allows {:g}° to {:g}° (joint_limits of its device file)",
                angle.name, kDegreesPerRadian * angle.rad, device.name,
                kDegreesPerRadian * angle.min_rad, kDegreesPerRadian * angle.max_rad));
        }
    }
    constexpr double kSameAngle_rad = 1e-6;
    const std::optional<Vector3> found =
        device::joint_angles_rad(device.geometry, device::tip_position_m(device.geometry, q_rad));
    if (!found || !(*found - q_rad).isZero(kSameAngle_rad)) {
        throw InputError("at these joint angles the tip is behind the base axis, where inverse "
                         "kinematics take other angles; choose q2 and q3 with the tip in front");
    }
}

} // namespace springdrive::rig
