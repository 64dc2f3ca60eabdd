// Covers engine/study/protocol/{protocol_check,check_stimuli,study_setting}.cpp: both
// sides of each line.
#include "engine/study/protocol/protocol_check.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;
using testing::with;

/// The findings of a severity whose text contains a part.
long count(const ProtocolFindings &findings, Severity severity, const std::string &part) {
    return std::ranges::count_if(findings, [&](const ProtocolFinding &one) {
        return one.severity == severity && text_of(one).find(part) != std::string::npos;
    });
}

std::string all_texts(const ProtocolFindings &findings) {
    std::string all;
    for (const ProtocolFinding &one : findings) {
        all += text_of(one) + '\n';
    }
    return all;
}

StudySetting setting_of(const Protocol &protocol) {
    return study_setting(protocol, testing::folders());
}

ProtocolFindings limits_of(const Protocol &protocol, const StudySetting &setting) {
    return check_limits(protocol, setting, all_presented(protocol));
}

void expect_errors(const ProtocolFindings &findings, const std::string &part, long many) {
    EXPECT_EQ(count(findings, Severity::error, part), many) << part << '\n' << all_texts(findings);
}

/// No such error on one side of a line, so many on the other.
void expect_line(const ProtocolFindings &within, const ProtocolFindings &beyond,
                 const std::string &part, long many) {
    expect_errors(within, part, 0);
    EXPECT_EQ(count(beyond, Severity::error, part), many) << all_texts(beyond);
}

TEST(ProtocolCheck, HasNothingAgainstAPlainOne) {
    const CheckedProtocol checked = check_protocol(protocol_of(kPlainProtocol), testing::folders());
    EXPECT_EQ(count(checked.findings, Severity::error, ""), 0) << all_texts(checked.findings);
    EXPECT_EQ(count(checked.findings, Severity::warning, ""), 0) << all_texts(checked.findings);
    EXPECT_EQ(count(checked.findings, Severity::note, "precision"), 1);
    EXPECT_EQ(checked.trials.size(), 6U);
}

TEST(ProtocolCheck, FindsTheFirstUnstableGainOfAnyHand) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.conditions.pop_back();
    protocol.blocks.pop_back();
    const StudySetting setting = setting_of(protocol);
    // The limit of K_P by the loops themselves, at the largest share 1 − η that is presented: of
    // the standard, 0.6.
    const auto is_stable = [&](double K_P) {
        loops::StabilityCase which;
        which.device = setting.device;
        which.tuning = protocol.conditions[0].tuning;
        which.tuning.eta = 0.4;
        which.tuning.K_P_V_per_rad = K_P;
        which.q_rad = *device::joint_angles_rad(setting.device.geometry, {0.0, -0.005, -0.015});
        which.hands = loops::hand_family(41);
        if (!loops::is_stable(which)) {
            return false;
        }
        which.freedom = loops::Freedom::three_motors;
        which.hands = loops::hand_family(9);
        return loops::is_stable(which);
    };
    double stable = 6.0;
    double unstable = 200.0;
    ASSERT_TRUE(is_stable(stable));
    ASSERT_FALSE(is_stable(unstable));
    while (unstable - stable > 1e-4 * stable) {
        (is_stable(0.5 * (stable + unstable)) ? stable : unstable) = 0.5 * (stable + unstable);
    }
    protocol.conditions[0].tuning.K_P_V_per_rad = stable;
    const ProtocolFindings below = check_stability(protocol, setting, all_presented(protocol));
    expect_errors(below, "", 0);
    EXPECT_EQ(count(below, Severity::warning, "within a factor 1.1"), 1) << all_texts(below);
    protocol.conditions[0].tuning.K_P_V_per_rad = unstable;
    const ProtocolFindings above = check_stability(protocol, setting, all_presented(protocol));
    expect_errors(above, "condition \"a\", the standard: is unstable in contact", 1);
    protocol.conditions[0].tuning.K_P_V_per_rad = stable / 1.2;
    EXPECT_TRUE(check_stability(protocol, setting, all_presented(protocol)).empty());
}

TEST(ProtocolCheck, FindsADelayThatTheTuningDoesNotBear) {
    const Protocol late =
        protocol_of(with(kPlainProtocol, "delay_periods = 0.0", "delay_periods = 8.0"));
    EXPECT_GE(count(check_stability(late, setting_of(late), all_presented(late)), Severity::error,
                    "delay 8"),
              1);
}

/// The shared tuning in free space is in force when the hand touches: with a smaller dR the same
/// K_P is stiffer.
TEST(ProtocolCheck, FindsAGlideThatBeginsUnstable) {
    Protocol protocol = protocol_of(kPlainProtocol);
    for (Condition &condition : protocol.conditions) {
        condition.tuning.dR_Ohm = 2.0;
        condition.tuning.K_P_V_per_rad = 50.0;
        condition.tuning.lambda_rad_per_s = 3000.0;
        condition.tuning.K_D_Vs_per_rad = 0.05;
    }
    const StudySetting setting = setting_of(protocol);
    protocol.free_space.reset();
    expect_errors(check_stability(protocol, setting, all_presented(protocol)), "", 0);
    protocol.free_space = {0.2, 1000.0};
    expect_errors(check_stability(protocol, setting, all_presented(protocol)), "before it glides",
                  2);
}

/// D² = l₁² + l₂² + 2 l₁ l₂ sin(q₃ − q₂) is the tip's distance from the shoulder, so the soft edge,
/// 5° before the fold of 55°, is a sphere about it, and the ends of a stroke meet it first.
TEST(ProtocolCheck, FindsStrokesBeyondTheSoftEdgeOfTheWorkspace) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::stroke;
    const device::DeviceDescription device = testing::phantom_1_0();
    const double l_m = device.geometry.upper_arm_m;
    ASSERT_EQ(l_m, device.geometry.forearm_m);
    const auto farthest_m = [l_m](double fold_deg) {
        const double D_m = l_m * std::sqrt(2.0 * (1.0 + std::sin(fold_deg * kRadiansPerDegree)));
        return std::sqrt(D_m * D_m - kStroke_m * kStroke_m) - l_m;
    };
    const auto findings_at = [&](double z_m) {
        for (Condition &condition : protocol.conditions) {
            condition.scene = kNoScene;
            condition.spot = scene::TouchSpot{Vector3(0.0, l_m, z_m), Vector3::UnitY()};
        }
        return check_spots(protocol, setting_of(protocol));
    };
    EXPECT_TRUE(findings_at(farthest_m(50.0) - 1e-4).empty());
    expect_errors(findings_at(farthest_m(50.0) + 1e-4), "soft edge", 2);
    expect_errors(findings_at(farthest_m(55.0) + 1e-4), "out of the device", 2);
}

TEST(ProtocolCheck, FindsSpotsThatAreNotOnTheSurface) {
    const auto findings_of_spot = [](const std::string &point, const std::string &normal) {
        const Protocol protocol = protocol_of(
            with(with(kPlainProtocol, "[0.0, -0.005, -0.015]", point), "[0.0, 1.0, 0.0]", normal));
        return check_spots(protocol, setting_of(protocol));
    };
    const std::string up = "[0.0, 1.0, 0.0]";
    // The plate's upper side is at y = −5 mm.
    EXPECT_TRUE(findings_of_spot("[0.0, -0.0045, -0.015]", up).empty());
    expect_errors(findings_of_spot("[0.0, -0.0035, -0.015]", up), "not on the surface", 2);
    EXPECT_TRUE(findings_of_spot("[0.0, -0.0059, -0.015]", up).empty());
    expect_errors(findings_of_spot("[0.0, -0.0061, -0.015]", up), "off it", 2);
    EXPECT_EQ(count(findings_of_spot("[0.08, -0.005, -0.015]", up), Severity::error, "not on"), 2)
        << "beside the plate";
    const auto leaning = [](double degrees) {
        const double rad = degrees * kRadiansPerDegree;
        return "[" + std::to_string(std::sin(rad)) + ", " + std::to_string(std::cos(rad)) +
               ", 0.0]";
    };
    EXPECT_TRUE(findings_of_spot("[0.0, -0.005, -0.015]", leaning(4.9)).empty());
    expect_errors(findings_of_spot("[0.0, -0.005, -0.015]", leaning(5.1)), "off the surface's", 2);
}

TEST(ProtocolCheck, FindsScenesThatAreNotThere) {
    const Protocol protocol = protocol_of(with(kPlainProtocol, "\"plate\"", "\"plat\""));
    expect_errors(check_protocol(protocol, testing::folders()).findings, "plat.gltf", 2);
}

TEST(ProtocolCheck, FindsScenesWithoutASpotAndTakesThatOfALesson) {
    const std::string without = with(with(kPlainProtocol, "point_m = [0.0, -0.005, -0.015]\n", ""),
                                     "normal = [0.0, 1.0, 0.0]\n", "");
    const Protocol plate = protocol_of(without);
    expect_errors(check_spots(plate, setting_of(plate)), "marks no spot", 2);
    const Protocol lesson = protocol_of(with(without, "\"plate\"", "\"wrong_direction\""));
    EXPECT_TRUE(check_spots(lesson, setting_of(lesson)).empty());
}

TEST(ProtocolCheck, TurnsOnlyThePulseOfAPulse) {
    Protocol protocol = protocol_of(kPlainProtocol);
    Condition &condition = protocol.conditions[0];
    condition.press_N = 0.5;
    condition.pulse_N = 1.0;
    condition.turn_deg = 90.0;
    condition.turn_axis_deg = 90.0; // to the right
    const StudySetting setting = setting_of(protocol);
    Presented one = all_presented(protocol)[0];
    const std::optional<PredictedPress> pulse = predicted_press(setting, one, StimulusForm::pulse);
    EXPECT_TRUE(pulse->force_N.isApprox(Vector3(1.0, 0.5, 0.0), 1e-9))
        << pulse->force_N.transpose();
    EXPECT_TRUE(pulse->held_N.isApprox(Vector3(0.0, 0.5, 0.0), 1e-9));
    // A press is turned as a whole: 0.5 N against the hand are 1 N at 60 degrees.
    one.parameters.turn_deg = 60.0;
    const std::optional<PredictedPress> press = predicted_press(setting, one, StimulusForm::press);
    EXPECT_TRUE(press->force_N.isApprox(Vector3(std::sqrt(0.75), 0.5, 0.0), 1e-9));
}

TEST(ProtocolCheck, FindsForcesThatTheServoHoldsBack) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::pulse;
    const StudySetting setting = setting_of(protocol);
    const auto findings_with = [&](double pulse_N) {
        for (Condition &condition : protocol.conditions) {
            condition.press_N = 5.0;
            condition.pulse_N = pulse_N;
            condition.pulse_hz = 100.0;
        }
        return limits_of(protocol, setting);
    };
    // 95 % of 8.5 N is 8.075 N.
    expect_line(findings_with(3.07), findings_with(3.08), "N at the tip", 2);
}

/// A vertical force F asks of the links F ∂y/∂q, with y = l₂ − l₂ cos q₃ + l₁ sin q₂.
TEST(ProtocolCheck, FindsCurrentsAndVoltagesBeyondTheMotors) {
    Protocol protocol = protocol_of(kPlainProtocol);
    StudySetting setting = setting_of(protocol);
    const device::PhantomGeometry &geometry = setting.device.geometry;
    const Vector3 q_rad = *device::joint_angles_rad(geometry, {0.0, -0.005, -0.015});
    const device::MotorParameters motor = setting.device.motor[0];
    const double F_N = 1.0;
    const double current_A = std::max(std::abs(F_N * geometry.upper_arm_m * std::cos(q_rad[1])) /
                                          geometry.transmission_ratio[1],
                                      std::abs(F_N * geometry.forearm_m * std::sin(q_rad[2])) /
                                          geometry.transmission_ratio[2]) /
                             motor.torque_constant_Nm_per_A;
    const auto findings_with = [&](double peak_A, double supply_V) {
        for (device::MotorParameters &one : setting.device.motor) {
            one.peak_current_A = peak_A;
            one.supply_V = supply_V;
        }
        return limits_of(protocol, setting);
    };
    expect_line(findings_with(1.001 * current_A / 0.95, 12.0),
                findings_with(0.999 * current_A / 0.95, 12.0), "A in motor", 1);
    // R at 60 °C and at the commutator's worst angle: 2 % above.
    const double volts_V = current_A * 2.18 * (1.0 + 0.0039 * 35.0) * 1.02;
    expect_line(findings_with(5.5, 1.001 * volts_V), findings_with(5.5, 0.999 * volts_V),
                "V at motor", 1);
}

/// ½ F²/K with K = (1 − η) α K_DC, and α = N²/(l² (1 + |sin(q₃ − q₂)|)) (docs/design.md).
TEST(ProtocolCheck, FindsEnergyThatAGlideMayGiveBack) {
    const Protocol protocol = protocol_of(kPlainProtocol);
    StudySetting setting = setting_of(protocol);
    const device::PhantomGeometry &geometry = setting.device.geometry;
    const Vector3 q_rad = *device::joint_angles_rad(geometry, {0.0, -0.005, -0.015});
    const double alpha = std::pow(geometry.transmission_ratio[1] / geometry.upper_arm_m, 2) /
                         (1.0 + std::abs(std::sin(q_rad[2] - q_rad[1])));
    const double K_DC = 23.4e-3 * 6.0 / 0.5;
    const double softest_eta = 0.7;
    const double held_J = 0.5 * 1.0 / ((1.0 - softest_eta) * alpha * K_DC);
    const auto findings_with = [&](double limit_J) {
        setting.device.limits.generated_energy_J = limit_J;
        return limits_of(protocol, setting);
    };
    // Of the condition that presses harder.
    expect_line(findings_with(1.001 * held_J), findings_with(0.999 * held_J), "mJ", 1);
}

/// The impulse of a pulse, F/(2 f), gives a light hand and the device ½ p²/m.
TEST(ProtocolCheck, FindsPulsesThatGiveTooMuchEnergy) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::pulse;
    StudySetting setting = setting_of(protocol);
    for (Condition &condition : protocol.conditions) {
        condition.press_N = 0.5;
        condition.pulse_N = 1.0;
        condition.pulse_hz = 30.0;
    }
    const Vector3 q_rad = *device::joint_angles_rad(setting.device.geometry, {0.0, -0.005, -0.015});
    const double mass_kg =
        loops::hand_of_firmness(0.0).mass_kg + tip_mass_kg(setting.device, q_rad, Vector3::UnitY());
    const double pulse_J = 0.5 * std::pow(1.0 / 60.0, 2) / mass_kg;
    const auto findings_with = [&](double limit_J) {
        setting.device.limits.generated_energy_J = limit_J;
        return limits_of(protocol, setting);
    };
    expect_line(findings_with(1.001 * pulse_J), findings_with(0.999 * pulse_J), "light hand", 2);
}

TEST(ProtocolCheck, TheMassOfTheTipIsTheInertiaSeenAlongADirection) {
    const device::DeviceDescription device = testing::phantom_1_0();
    // Sideways only the base turns: its inertia over the squared reach.
    const double sideways_kg = tip_mass_kg(device, Vector3::Zero(), Vector3::UnitX());
    loops::StabilityCase which;
    which.device = device;
    which.q_rad.setZero();
    which.freedom = loops::Freedom::three_motors;
    const double at_motor = loops::driven_load(which, {0, loops::no_hand()}).inertia_kg_m2(0, 0);
    const double N = device.geometry.transmission_ratio[0];
    const double reach_m = device.geometry.upper_arm_m;
    EXPECT_NEAR(sideways_kg, at_motor * N * N / (reach_m * reach_m), 1e-9);
    // The data sheet's apparent mass is below 75 g.
    EXPECT_LT(tip_mass_kg(device, Vector3::Zero(), Vector3::UnitY()), 0.15);
}

TEST(ProtocolCheck, FindsHandsThatSlideFromATurnedForce) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable = {"turn_deg", LevelMeaning::value, 0.0, "", false};
    const auto findings_with = [&](double turn_deg, Hold hold) {
        protocol.method = ConstantStimuli{{turn_deg}, 1, 10};
        protocol.practice.max_trials = 0;
        protocol.catch_trials.one_in = 0;
        for (Condition &condition : protocol.conditions) {
            condition.press_N = 1.0;
            condition.hold = hold;
        }
        return check_limits(protocol, setting_of(protocol), all_presented(protocol));
    };
    // 1 N tan φ against 300 N/m: 3 mm at 42.0°.
    const double edge_deg = std::atan(0.9) * kDegreesPerRadian;
    expect_line(findings_with(edge_deg - 0.1, Hold::surface),
                findings_with(edge_deg + 0.1, Hold::surface), "slides", 2);
    expect_errors(findings_with(edge_deg + 0.1, Hold::cup), "slides", 0);
}

TEST(ProtocolCheck, FindsConditionsThatDifferInFreeSpace) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.free_space.reset();
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto errors = [&] {
        return count(check_free_space(protocol, device), Severity::error, "in free space");
    };
    EXPECT_EQ(errors(), 0);
    protocol.conditions[1].tuning.K_P_V_per_rad = 3.0;
    EXPECT_EQ(errors(), 0) << "gains are not felt in free space";
    protocol.conditions[1].tuning.dR_Ohm = 0.51;
    EXPECT_EQ(errors(), 1);
    protocol.free_space = FreeSpaceTuning{};
    EXPECT_EQ(errors(), 0);
    protocol.free_space.reset();
    protocol.free_space_is_stimulus = true;
    EXPECT_EQ(errors(), 0);

    protocol.free_space_is_stimulus = false;
    protocol.conditions[1].tuning.dR_Ohm = 0.5;
    const double lag_s = control::loop_lag_s(1000.0, 1e-3, 0.0);
    protocol.conditions[1].tuning.lambda_rad_per_s =
        *control::lambda_of_lag_rad_per_s(1.009 * lag_s, 1e-3, 0.0);
    EXPECT_EQ(errors(), 0);
    protocol.conditions[1].tuning.lambda_rad_per_s =
        *control::lambda_of_lag_rad_per_s(1.011 * lag_s, 1e-3, 0.0);
    EXPECT_EQ(errors(), 1);
}

TEST(ProtocolCheck, FindsBlowsThatAreOverBeforeTheyGlide) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::blow;
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto warnings = [&] {
        return count(check_free_space(protocol, device), Severity::warning, "a blow is felt with");
    };
    EXPECT_EQ(warnings(), 0);
    protocol.conditions[1].tuning.dR_Ohm = 0.3;
    EXPECT_EQ(warnings(), 1);
    protocol.stimulus = StimulusForm::press;
    EXPECT_EQ(warnings(), 0);
}

TEST(ProtocolCheck, FindsServoRatesThatCannotHaveTheSharedLag) {
    Protocol protocol = protocol_of(kPlainProtocol);
    const device::DeviceDescription device = testing::phantom_1_0();
    const auto findings_with = [&](double servo_hz) {
        protocol.conditions[1].servo_hz = servo_hz;
        return check_free_space(protocol, device);
    };
    // The lag is 1.58198 ms: T above 632.12 Hz. With λ = 5000 rad/s, the largest, T at 632.35 Hz.
    EXPECT_TRUE(findings_with(632.4).empty());
    expect_errors(findings_with(632.2), "needs lambda", 1);
    expect_errors(findings_with(632.0), "no filter", 1);
}

TEST(ProtocolCheck, FindsSessionsThatAreTooLong) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.breaks.between_blocks_s = 0.0;
    const double trials_s = session_length(protocol).min_s;
    ASSERT_LT(trials_s, 3599.0);
    protocol.breaks.between_blocks_s = 3600.0 - trials_s - 0.5;
    expect_errors(check_session(protocol, session_length(protocol)), "session", 0);
    EXPECT_EQ(
        count(check_session(protocol, session_length(protocol)), Severity::warning, "session"), 1)
        << "at its longest it is longer";
    protocol.breaks.between_blocks_s = 3600.0 - trials_s + 0.5;
    expect_errors(check_session(protocol, session_length(protocol)), "60 min", 1);
}

/// Of the plain protocol: a choice, a scale and a free text.
TEST(ProtocolCheck, QuestionsCountInTheSession) {
    Protocol protocol = protocol_of(kPlainProtocol);
    ASSERT_EQ(protocol.questionnaire.size(), 3U);
    const SessionLength with = session_length(protocol);
    protocol.questionnaire.clear();
    const SessionLength without = session_length(protocol);
    EXPECT_DOUBLE_EQ(with.min_s - without.min_s, 15.0);
    EXPECT_DOUBLE_EQ(with.max_s - without.max_s, 100.0);
    EXPECT_EQ(with.min_questions_s, 15.0);
    EXPECT_EQ(with.max_questions_s, 100.0);
}

TEST(ProtocolCheck, FindsHandsWithoutARestAndOrdersOutOfBalance) {
    Protocol protocol = protocol_of(kPlainProtocol);
    const auto warnings = [&](const std::string &part) {
        return count(check_session(protocol, session_length(protocol)), Severity::warning, part);
    };
    EXPECT_EQ(warnings(""), 0);
    protocol.participants = 5;
    EXPECT_EQ(warnings("plan for 6"), 1);
    protocol.participants = 6;
    EXPECT_EQ(warnings("participants"), 0);
    protocol.counterbalancing = Counterbalancing::fixed;
    EXPECT_EQ(warnings("counterbalancing"), 1);
    protocol.expected->threshold = 0.31;
    EXPECT_EQ(warnings("lies outside"), 1);
    protocol.expected->threshold = 0.29;
    EXPECT_EQ(warnings("lies outside"), 0);
    protocol.breaks.every_trials = static_cast<int>(900.0 / long_trial_s(protocol));
    std::get<ConstantStimuli>(protocol.method).blocks = 1000;
    EXPECT_EQ(warnings("without a rest"), 0);
    ++protocol.breaks.every_trials;
    EXPECT_EQ(warnings("without a rest"), 1);
}

TEST(ProtocolCheck, FindsPausesTooShortForAnotherServoRate) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.variable.standard_condition = "a";
    const auto errors = [&] {
        return count(check_session(protocol, session_length(protocol)), Severity::error, "anew");
    };
    EXPECT_EQ(errors(), 0);
    protocol.conditions[1].servo_hz = 2000.0;
    EXPECT_EQ(errors(), 1);
    protocol.timing.pause_s = 2.0;
    EXPECT_EQ(errors(), 0);
}

TEST(ProtocolCheck, FindsNamesThatPersonsTakeForOne) {
    Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_TRUE(check_names(protocol).empty());
    for (const char *const like_a : {"A", "a ", " a", "a\u00a0", "a\u200b"}) {
        protocol.conditions[1].name = like_a;
        expect_errors(check_names(protocol), "has a name like \"a\"", 1);
        expect_errors(check_protocol(protocol, testing::folders(), {.simulates = false}).findings,
                      "condition \"" + std::string(like_a) + "\"", 1);
    }
    protocol.conditions[0].name = "gr\u00f6\u00dfer";
    protocol.conditions[1].name = "Gro\u0308\u00dfer";
    expect_errors(check_names(protocol), "has a name like", 1);
    protocol.conditions[1].name = "kleiner";
    protocol.blocks[1].name = "One";
    protocol.questionnaire[2].name = "Hand";
    expect_errors(check_names(protocol), "block \"One\"", 1);
    expect_errors(check_names(protocol), "question \"Hand\"", 1);
    protocol.questionnaire[2].name = "Session_ID";
    expect_errors(check_names(protocol), "question \"Session_ID\"", 1);
}

TEST(ProtocolCheck, FindsGridsThatKeepTheWindowWaiting) {
    Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_TRUE(check_choices(protocol).empty()) << "no grid";
    QuestPlus method;
    method.family.scale = Scale::logarithmic;
    for (int i = 0; i < 50; ++i) {
        method.levels.push_back(0.01 * (i + 1));
    }
    method.threshold = {{Scale::logarithmic, 0.05, 0.5}, 100};
    method.slope = {{Scale::logarithmic, 0.7, 7.0}, 20};
    method.guess = {{Scale::linear, 0.5, 0.5}, 1};
    method.lapse = {{Scale::linear, 0.0, 0.06}, 5};
    protocol.method = method; // 500,000 cells, of one condition at a time
    ASSERT_EQ(validate(protocol), "");
    EXPECT_TRUE(check_choices(protocol).empty());
    protocol.blocks = {{"both", {0, 1}}};
    expect_errors(check_choices(protocol), "of 2 conditions", 1);
    method.lapse.points = 6;
    protocol.blocks = {{"one", {0}}};
    protocol.method = method;
    expect_errors(check_choices(protocol), "of 1 condition,", 1);
    // It is said before studies are simulated with it, which would take minutes.
    const ProtocolFindings all =
        check_protocol(protocol, testing::folders(), {.simulates = false}).findings;
    expect_errors(all, "points of its grid", 1);
    EXPECT_EQ(count(all, Severity::note, "precision"), 0) << all_texts(all);
}

TEST(ProtocolCheck, TellsThePrecisionToBeExpected) {
    // With as many levels as unknown parameters or fewer, no number of trials tells lapses from a
    // flat slope, and the priors are felt for ever.
    Protocol protocol = protocol_of(kPlainProtocol);
    auto &method = std::get<ConstantStimuli>(protocol.method);
    method.levels = {0.05, 0.1, 0.14, 0.2, 0.28, 0.4, 0.6};
    const auto width = [&](int blocks) {
        method.blocks = blocks;
        const ProtocolFindings findings = check_precision(protocol);
        EXPECT_EQ(findings.size(), 1U);
        const std::string &what = findings[0].what;
        const std::size_t at = what.find("a factor of ");
        EXPECT_NE(at, std::string::npos) << what;
        return at == std::string::npos ? 0.0 : std::stod(what.substr(at + 12));
    };
    const double few = width(50);
    const double many = width(200);
    EXPECT_GT(many, 1.0);
    // Four times as many trials: on the logarithmic scale half of the width, in the limit of many.
    // The median of sixty studies scatters by some 5 %, and the factor is printed to three digits.
    const double ratio = std::log(few) / std::log(many);
    EXPECT_GT(ratio, 1.7);
    EXPECT_LT(ratio, 2.5);
    protocol.expected.reset();
    EXPECT_EQ(count(check_precision(protocol), Severity::note, "without [expected]"), 1);
}

/// What a count of one motor adds to the impulse of the law's current, by Euler's steps of (11).
Vector3 impulse_of_count_Ns(const device::DeviceDescription &device, const Vector3 &q_rad,
                            double dR_Ohm, Eigen::Index j) {
    const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
    constexpr double kStep_s = 1e-7;
    constexpr double kTurning_s = 1e-3; // the count is seen as a speed for one tick
    double i_A = 0.0;
    double charge_As = 0.0;
    for (int step = 0; step < 200'000; ++step) {
        const double rate = step * kStep_s < kTurning_s ? device.rad_per_count() / kTurning_s : 0.0;
        i_A +=
            kStep_s / motor.inductance_H * (-dR_Ohm * i_A - motor.torque_constant_Nm_per_A * rate);
        charge_As += kStep_s * i_A;
    }
    const Vector3 torque_Nms = motor.torque_constant_Nm_per_A * charge_As * Vector3::Unit(j);
    return device::motor_jacobian(device.geometry, q_rad).transpose().inverse() * torque_Nms;
}

TEST(ProtocolCheck, ABandNarrowerThanAnEncoderCountIsTold) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::pulse;
    protocol.timing.presentation_s = 1.0;
    for (Condition &condition : protocol.conditions) {
        condition.hold = Hold::cup;
        condition.pulse_N = 1.0;
        condition.pulse_hz = 100.0;
    }
    const StudySetting setting = setting_of(protocol);
    const std::vector<Presented> presented = all_presented(protocol);
    const Presented &one = presented.front();
    const Vector3 q_rad = predicted_press(setting, one, StimulusForm::pulse).value().q_rad;
    const Vector3 direction = stimulus_of(protocol, setting, one).direction;
    double expected_deg = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const Vector3 count_Ns =
            impulse_of_count_Ns(setting.device, q_rad, one.parameters.tuning.dR_Ohm, j);
        const Vector3 across_Ns = count_Ns - count_Ns.dot(direction) * direction;
        expected_deg = std::max(expected_deg, kDegreesPerRadian *
                                                  std::atan2(across_Ns.norm(), 0.5 * 1.0 / 100.0));
    }
    // Euler's error is the step's share of the winding's time constant, 2e-4.
    EXPECT_NEAR(count_angle_deg(protocol, setting, one), expected_deg, 1e-3 * expected_deg);

    double widest_deg = 0.0;
    for (const Presented &each : presented) {
        widest_deg = std::max(widest_deg, count_angle_deg(protocol, setting, each));
    }
    protocol.marking.direction_deg = 1.01 * widest_deg;
    EXPECT_EQ(count(check_marking(protocol, setting, presented), Severity::warning, "count"), 0);
    protocol.marking.direction_deg = 0.99 * widest_deg;
    EXPECT_GT(count(check_marking(protocol, setting, presented), Severity::warning, "count"), 0);
    // Twice as slow has twice the impulse.
    for (Condition &condition : protocol.conditions) {
        condition.pulse_hz = 50.0;
    }
    EXPECT_TRUE(check_marking(protocol, setting, all_presented(protocol)).empty());
}

/// A press is turned by J of the angles alone: no band that a protocol may have is so narrow.
TEST(ProtocolCheck, ACountHardlyTurnsAPress) {
    Protocol protocol = protocol_of(kPlainProtocol);
    for (Condition &condition : protocol.conditions) {
        condition.hold = Hold::cup;
    }
    const StudySetting setting = setting_of(protocol);
    for (const Presented &one : all_presented(protocol)) {
        const double count_deg = count_angle_deg(protocol, setting, one);
        EXPECT_GT(count_deg, 0.0);
        // Two joint angles of a count each: 2 · 360°/4096/11.2.
        EXPECT_LT(count_deg, 2.0 * 360.0 / 4096.0 / 11.2);
    }
}

/// From the air to the band by the network with constant heat, which is ½ R a² as the monitor sees
/// it: at the least C ΔT/P, at the most with what housings lose of it to the air.
TEST(ProtocolCheck, TheWarmUpCountsInTheSession) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.windings = {25.0, 30.0, 60.0};
    const StudySetting setting = setting_of(protocol);
    const double warm_up_s = predicted_warm_up_s(protocol, setting);
    const double most_A = warming_current_A(setting, warming_place_m(protocol, setting)).maxCoeff();
    const double C_J_per_K = 12.0 / 3.1 + 612.0 / 14.0;
    const double heat_W = 0.5 * 2.18 * 1.02 * most_A * most_A;
    const double min_s = 6.5 * C_J_per_K / (1.09 * heat_W); // R rises by up to 9 %
    EXPECT_GT(warm_up_s, min_s);
    EXPECT_LT(warm_up_s, 1.3 * 6.5 * C_J_per_K / (heat_W - 6.5 / 14.0));
    EXPECT_DOUBLE_EQ(session_length(protocol, warm_up_s).min_s,
                     session_length(protocol).min_s + warm_up_s);
    EXPECT_DOUBLE_EQ(session_length(protocol, warm_up_s).max_s,
                     session_length(protocol).max_s + warm_up_s);
    CheckOptions options;
    options.simulates = false;
    EXPECT_DOUBLE_EQ(check_protocol(protocol, testing::folders(), options).length.warm_up_s,
                     warm_up_s);
    protocol.windings = {15.0, 88.0, 90.0};
    expect_errors(check_protocol(protocol, testing::folders(), options).findings,
                  "cannot be warmed", 1);
}

/// A press without a pause, until winding and housing are in balance with the air:
/// T − T_air = i² R(T) (R_wh + R_ha), so T = T_air + P₀ Z/(1 − ρ P₀ Z) with P₀ Z the rise at 25 °C.
TEST(ProtocolCheck, PredictsTheWarmthOfALongPress) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.timing = {0.1, 0.2, 60.0, 0.0, 0.5, 0.0, 0.1};
    protocol.breaks = {0, 0.0, 0.0};
    std::get<ConstantStimuli>(protocol.method).blocks = 100;
    protocol.stopping.longest_session_min = 480.0;
    for (Condition &condition : protocol.conditions) {
        condition.press_N = 2.0;
    }
    StudySetting setting = setting_of(protocol);
    const std::vector<Presented> presented = all_presented(protocol);
    const SessionLength length = session_length(protocol);
    const SessionWarmth warmth = check_warmth(protocol, setting, presented, length);

    // The same force at every level, so the currents of any.
    const std::optional<PredictedPress> press =
        predicted_press(setting, presented[0], StimulusForm::press);
    const double i_A =
        currents_A(setting.device, press->q_rad, press->force_N).cwiseAbs().maxCoeff();
    // Of each 120.4 s the hand presses 120 s.
    const double rise_K = i_A * i_A * 2.18 * 1.02 * (3.1 + 14.0) * 120.0 / 120.4;
    const double expected_C = 25.0 + rise_K / (1.0 - 0.0039 * rise_K);
    // Commutation ripple of 2 % is at the angle that was taken; the gap of 0.4 s lets the winding
    // cool by 0.4/12 of its own rise at most.
    EXPECT_NEAR(warmth.hottest_C, expected_C, 0.01 * (expected_C - 25.0));

    for (device::MotorParameters &motor : setting.device.motor) {
        motor.thermal.max_winding_C = warmth.hottest_C + 0.1;
    }
    protocol.windings.to_C = warmth.hottest_C + 0.05;
    EXPECT_TRUE(check_warmth(protocol, setting, presented, length).findings.empty());
    protocol.windings.to_C = warmth.hottest_C - 0.05;
    EXPECT_EQ(count(check_warmth(protocol, setting, presented, length).findings, Severity::warning,
                    "windings.to_C"),
              1);
    for (device::MotorParameters &motor : setting.device.motor) {
        motor.thermal.max_winding_C = warmth.hottest_C - 0.1;
    }
    expect_errors(check_warmth(protocol, setting, presented, length).findings, "the limit", 1);
}

TEST(ProtocolCheck, TellsOfOneConditionOnceAndOfHowManyLevels) {
    const std::vector<StimulusFinding> all{
        {0, {Severity::error, "a at 1", "is bad", "mend it"}},
        {0, {Severity::error, "a at 2", "is bad", "mend it"}},
        {1, {Severity::error, "b at 1", "is bad", "mend it"}},
        {0, {Severity::warning, "a at 3", "is odd", "mend it"}},
    };
    const ProtocolFindings told = once_per_condition(all);
    ASSERT_EQ(told.size(), 3U);
    EXPECT_EQ(text_of(told[0]), "error: a at 1: is bad (so at 1 further levels); mend it");
    EXPECT_EQ(text_of(told[1]), "error: b at 1: is bad; mend it");
}

} // namespace
} // namespace springdrive::study
