#include "engine/study/protocol/checks.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"

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

double lag_s(const Condition &condition, const control::Tuning &tuning) {
    return control::loop_lag_s(tuning.lambda_rad_per_s, 1.0 / condition.servo_hz,
                               condition.delay_periods);
}

/// With [free_space]: λ of each condition must exist, and be one that the servo takes.
void check_shared(ProtocolFindings &findings, const Protocol &protocol) {
    const control::Parameter &lambda = control::parameter_of(&control::Tuning::lambda_rad_per_s);
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        if (!is_used(protocol, i)) {
            continue;
        }
        const Condition &condition = protocol.conditions[i];
        const std::optional<control::Tuning> tuning = free_space_tuning(protocol, condition);
        const std::string where = fmt::format("condition \"{}\"", condition.name);
        const std::string remedy =
            "lower free_space.lambda_rad_per_s, so that the lag is longer, or choose servo_hz and "
            "delay_periods nearer to the first condition's";
        if (!tuning) {
            findings.push_back({Severity::error, where,
                                fmt::format("at {:g} Hz with a delay of {:g} periods no filter has "
                                            "the lag of the shared free-space tuning",
                                            condition.servo_hz, condition.delay_periods),
                                remedy});
        } else if (!control::lies_in_range(lambda, *tuning)) {
            findings.push_back({Severity::error, where,
                                fmt::format("the lag of the shared free-space tuning needs lambda "
                                            "{:.0f} rad/s at {:g} Hz; it must be from {:g} to {:g}",
                                            tuning->lambda_rad_per_s, condition.servo_hz,
                                            lambda.minimum, lambda.maximum),
                                remedy});
        }
    }
}

/// Without it: all must be alike.
void check_alike(ProtocolFindings &findings, const Protocol &protocol,
                 const device::DeviceDescription &device) {
    const std::vector<Presented> all = all_presented(protocol);
    for (const Presented &one : all) {
        const Condition &first = all.front().parameters;
        const double before_s = lag_s(first, first.tuning);
        const double now_s = lag_s(one.parameters, one.parameters.tuning);
        const bool same_dR = one.parameters.tuning.dR_Ohm == first.tuning.dR_Ohm;
        if (same_dR && std::abs(now_s - before_s) <= kSameLag * before_s) {
            continue;
        }
        const auto added_g = [&](const Condition &condition) {
            const control::Coupling c =
                control::coupling(device.motor[1], condition.tuning, 1.0 / condition.servo_hz,
                                  condition.delay_periods);
            const double lever_m = device.geometry.upper_arm_m;
            const double N = device.geometry.transmission_ratio[1];
            return 1e3 * c.added_inertia_kg_m2 * N * N / (lever_m * lever_m);
        };
        findings.push_back(
            {Severity::error, name_of(protocol, one),
             fmt::format("can be told from {} in free space: dR {:g} against {:g} Ω and lag {:.2f} "
                         "against {:.2f} ms, some {:.1f} g against {:.1f} g",
                         name_of(protocol, all.front()), one.parameters.tuning.dR_Ohm,
                         first.tuning.dR_Ohm, 1e3 * now_s, 1e3 * before_s, added_g(one.parameters),
                         added_g(first)),
             "add [free_space] with the dR and lambda that all share there, or declare "
             "free_space_is_stimulus = true"});
        return;
    }
}

/// A blow is over within some hundredths of a second.
void check_blows(ProtocolFindings &findings, const Protocol &protocol) {
    for (std::size_t i = 0; i < protocol.conditions.size(); ++i) {
        const Condition &condition = protocol.conditions[i];
        const std::optional<control::Tuning> free = free_space_tuning(protocol, condition);
        if (!is_used(protocol, i) || !free ||
            (free->dR_Ohm == condition.tuning.dR_Ohm &&
             free->lambda_rad_per_s == condition.tuning.lambda_rad_per_s)) {
            continue;
        }
        findings.push_back(
            {Severity::warning, fmt::format("condition \"{}\"", condition.name),
             fmt::format("has dR {:g} Ω and lambda {:g} rad/s, but a blow is felt with those of "
                         "free space, {:g} Ω and {:g} rad/s, before it could glide",
                         condition.tuning.dR_Ohm, condition.tuning.lambda_rad_per_s, free->dR_Ohm,
                         free->lambda_rad_per_s),
             "give it the tuning of [free_space], or declare free_space_is_stimulus = true"});
    }
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

ProtocolFindings check_free_space(const Protocol &protocol,
                                  const device::DeviceDescription &device) {
    ProtocolFindings findings;
    if (protocol.free_space_is_stimulus) {
        findings.push_back({Severity::note, "free space",
                            "is the stimulus: each condition is there with its own dR and lambda",
                            ""});
    } else if (protocol.free_space) {
        check_shared(findings, protocol);
    } else {
        check_alike(findings, protocol, device);
    }
    if (protocol.stimulus == StimulusForm::blow) {
        check_blows(findings, protocol);
    }
    return findings;
}

} // namespace springdrive::study
