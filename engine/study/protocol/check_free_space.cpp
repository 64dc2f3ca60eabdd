#include "engine/control/coupling.h"
#include "engine/study/protocol/checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace springdrive::study {

namespace {

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
