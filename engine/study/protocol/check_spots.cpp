#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/study/protocol/checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace springdrive::study {

namespace {

/// Room for the hand below the surface, beside what the press itself needs [m].
constexpr double kBelow_m = 0.005;

/// The smallest distance of a configuration to a stop of the joints; negative beyond it [rad].
double room_rad(const device::JointLimits &limits, const Vector3 &q_rad) {
    const double fold_rad = q_rad[2] - q_rad[1];
    return std::min({(q_rad - limits.min_rad).minCoeff(), (limits.max_rad - q_rad).minCoeff(),
                     fold_rad - limits.min_q3_minus_q2_rad, limits.max_q3_minus_q2_rad - fold_rad});
}

/// The way of a trial: above the spot and below, or to either side of it.
std::string wrong_way(const device::DeviceDescription &device, const scene::TouchSpot &spot,
                      StimulusForm form) {
    constexpr int kSteps = 20;
    const bool is_stroke = form == StimulusForm::stroke;
    const Vector3 from_m = spot.point_m + (is_stroke ? Vector3(kStroke_m * Vector3::UnitX())
                                                     : Vector3(kApproach_m * spot.normal));
    const Vector3 to_m = spot.point_m - (is_stroke ? Vector3(kStroke_m * Vector3::UnitX())
                                                   : Vector3(kBelow_m * spot.normal));
    for (int i = 0; i <= kSteps; ++i) {
        const Vector3 tip_m = from_m + (to_m - from_m) * i / kSteps;
        const std::optional<Vector3> q_rad = device::joint_angles_rad(device.geometry, tip_m);
        const std::string at =
            fmt::format("({:.3f}, {:.3f}, {:.3f}) m, {:.0f} mm from the spot,", tip_m.x(),
                        tip_m.y(), tip_m.z(), 1e3 * (tip_m - spot.point_m).norm());
        if (!q_rad || !device.joint_limits.allow(*q_rad)) {
            return at + " is out of the device's reach";
        }
        if (const double room = room_rad(device.joint_limits, *q_rad);
            room < device.edge.margin_rad) {
            return fmt::format("{} is {:.1f}° before a stop, where the soft edge of the workspace "
                               "pushes from {:.1f}° on",
                               at, room * kDegreesPerRadian,
                               device.edge.margin_rad * kDegreesPerRadian);
        }
    }
    return {};
}

} // namespace

ProtocolFindings check_spots(const Protocol &protocol, const StudySetting &setting) {
    ProtocolFindings findings;
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        const Condition &condition = protocol.conditions[i];
        const std::string where = fmt::format("condition \"{}\"", condition.name);
        if (!is_used(protocol, i)) {
            findings.push_back(
                {Severity::warning, where, "is in no block", "add it to a block, or leave it out"});
            continue;
        }
        const PlacedCondition &place = setting.conditions[i];
        if (!place.problem.empty()) {
            findings.push_back({Severity::error, where, place.problem, ""});
            continue;
        }
        if (std::string wrong = wrong_way(setting.device, place.spot, protocol.stimulus);
            !wrong.empty()) {
            findings.push_back(
                {Severity::error, where, std::move(wrong),
                 fmt::format("move the spot: a trial needs {:g} mm above it and {:g} mm below",
                             1e3 * kApproach_m, 1e3 * kBelow_m)});
        }
    }
    return findings;
}

} // namespace springdrive::study
