#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/study/protocol/checks.h"

#include <fmt/core.h>

#include <array>
#include <optional>
#include <string>

namespace springdrive::study {

namespace {

/// As many hands between as `tune` tries: one motor at a time, and all three.
constexpr int kGripsOneMotor = 41;
constexpr int kGripsThreeMotors = 9;

/// The shares of the way from the tuning in free space to that in contact.
constexpr std::array kWay{0.25, 0.5, 0.75, 1.0};

/// A loop that is unstable.
struct Unstable {
    double eigenvalue = 0.0;
    std::string hand;
    std::string where; ///< "in contact"
};

/// In free space a mass without friction coasts: its eigenvalue is 1.
bool is_unstable(const loops::WorstMember &worst, double eta) {
    const double round_off = eta < 1.0 ? -loops::kEigenvalueRoundOff : loops::kEigenvalueRoundOff;
    return worst.eigenvalue >= 1.0 + round_off;
}

std::optional<Unstable> first_unstable(loops::StabilityCase which, const std::string &where) {
    for (const loops::Freedom freedom : {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
        which.freedom = freedom;
        which.hands = loops::hand_family(freedom == loops::Freedom::one_motor ? kGripsOneMotor
                                                                              : kGripsThreeMotors);
        const loops::WorstMember worst = loops::worst_member(which);
        if (is_unstable(worst, which.tuning.eta)) {
            return Unstable{worst.eigenvalue, loops::hand_text(worst.member.hand.name), where};
        }
    }
    return std::nullopt;
}

loops::StabilityCase case_of(const StudySetting &setting, const Presented &one) {
    loops::StabilityCase which;
    which.device = setting.device;
    which.tuning = one.parameters.tuning;
    if (which.tuning.alpha_mode == control::AlphaMode::global) {
        which.tuning.alpha_mode = control::AlphaMode::by_hand; // the loops would search for it anew
        which.tuning.alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    }
    which.period_s = 1.0 / one.parameters.servo_hz;
    which.delay_periods = one.parameters.delay_periods;
    const Vector3 &point_m = setting.conditions[one.condition].spot.point_m;
    which.q_rad = device::joint_angles_rad(setting.device.geometry, point_m)
                      .value_or(device::default_pose_rad());
    return which;
}

/// All loops of one stimulus, with K_P and K_D larger by a factor.
std::optional<Unstable> unstable_loop(const StudySetting &setting, const Presented &one,
                                      double gain) {
    const PlacedCondition &place = setting.conditions[one.condition];
    loops::StabilityCase which = case_of(setting, one);
    which.tuning.K_P_V_per_rad *= gain;
    which.tuning.K_D_Vs_per_rad *= gain;
    const control::Tuning contact = which.tuning;
    const double surface_eta = one.parameters.hold == Hold::cup ? 0.0 : place.surface_eta;
    const double eta = 1.0 - (1.0 - surface_eta) * (1.0 - contact.eta);
    const bool glides = one.free_space.dR_Ohm != contact.dR_Ohm ||
                        one.free_space.lambda_rad_per_s != contact.lambda_rad_per_s;
    which.tuning.dR_Ohm = one.free_space.dR_Ohm;
    which.tuning.lambda_rad_per_s = one.free_space.lambda_rad_per_s;
    which.tuning.eta = 1.0;
    if (gain == 1.0) { // no gain acts in free space
        if (std::optional<Unstable> bad = first_unstable(which, "in free space"); bad) {
            return bad;
        }
    }
    which.tuning.eta = eta;
    if (place.surface == nullptr) {
        return std::nullopt;
    }
    if (glides) {
        if (std::optional<Unstable> bad =
                first_unstable(which, "in contact, before it glides to its own tuning");
            bad) {
            return bad;
        }
    }
    for (const double share : kWay) {
        if (share < 1.0 && !glides) {
            continue;
        }
        const auto between = [share](double from, double to) { return from + share * (to - from); };
        which.tuning.dR_Ohm = between(one.free_space.dR_Ohm, contact.dR_Ohm);
        which.tuning.lambda_rad_per_s =
            between(one.free_space.lambda_rad_per_s, contact.lambda_rad_per_s);
        if (std::optional<Unstable> bad = first_unstable(
                which, share < 1.0 ? "on the glide to its own tuning" : "in contact");
            bad) {
            return bad;
        }
    }
    return std::nullopt;
}

ProtocolFinding finding_of(const Protocol &protocol, const Presented &one, const Unstable &bad,
                           double gain) {
    const control::Tuning &tuning = one.parameters.tuning;
    const std::string of = fmt::format(
        "K_P {:g} V/rad, K_D {:g} V·s/rad, λ {:g} rad/s, dR {:g} Ω, {:g} Hz, delay {:g}",
        tuning.K_P_V_per_rad, tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s, tuning.dR_Ohm,
        one.parameters.servo_hz, one.parameters.delay_periods);
    if (gain > 1.0) {
        return {Severity::warning, name_of(protocol, one),
                fmt::format("is within a factor {:g} on its gains of being unstable {} with {} "
                            "({})",
                            gain, bad.where, bad.hand, of),
                "lower K_P_V_per_rad or K_D_Vs_per_rad; `springdrive tune` keeps a margin of 1.3"};
    }
    return {Severity::error, name_of(protocol, one),
            fmt::format("is unstable {} with {}: the largest eigenvalue is {:.4f} ({})", bad.where,
                        bad.hand, bad.eigenvalue, of),
            "lower K_P_V_per_rad or K_D_Vs_per_rad, or raise servo_hz; `springdrive tune` finds "
            "the stiffest that is stable"};
}

} // namespace

ProtocolFindings check_stability(const Protocol &protocol, const StudySetting &setting,
                                 const std::vector<Presented> &presented) {
    std::vector<std::optional<ProtocolFinding>> found(presented.size());
    for_each_in_parallel(presented.size(), all_processors(), [&](std::size_t i) {
        for (const double gain : {1.0, kGainMargin}) {
            if (const std::optional<Unstable> bad = unstable_loop(setting, presented[i], gain)) {
                found[i] = finding_of(protocol, presented[i], *bad, gain);
                return;
            }
        }
    });
    std::vector<StimulusFinding> findings;
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (found[i]) {
            findings.push_back({presented[i].condition, std::move(*found[i])});
        }
    }
    return once_per_condition(findings);
}

} // namespace springdrive::study
