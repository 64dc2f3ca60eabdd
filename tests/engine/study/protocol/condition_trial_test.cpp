// Covers engine/study/protocol/condition_trial.cpp: what a simulated hand meets.
#include "engine/study/protocol/condition_trial.h"

#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <algorithm>
#include <vector>

namespace springdrive::study {
namespace {

using testing::kPlainProtocol;
using testing::protocol_of;
using testing::with;

StimulusTrial trial_of(const Protocol &protocol, std::size_t index = 0) {
    return try_stimulus(protocol, study_setting(protocol, testing::folders()),
                        all_presented(protocol)[index]);
}

TEST(ConditionTrial, AHandPressesAsHardAsTheConditionSays) {
    const Protocol protocol = protocol_of(kPlainProtocol);
    const StimulusTrial trial = trial_of(protocol);
    EXPECT_EQ(trial.trip, "");
    EXPECT_TRUE(trial.has_touched);
    EXPECT_FALSE(trial.delivered.is_limited);
    // Of 1 N the weight of the bare linkage and the joints' friction, 0.04 N at the tip of each,
    // are not the motors'; the arrival of a grip damped with 6/(2 √(300 · 0.2)) = 0.4 of critical
    // overshoots by up to e^(−0.4 π/√(1 − 0.4²)) = 0.25 of it.
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 q_rad = *device::joint_angles_rad(device.geometry, {0.0, -0.005, -0.015});
    const Vector3 weight_Nm = device::gravity_torque_Nm(
        device::linkage_moments(device.geometry, device.inertia, 0.0), q_rad);
    const double weight_N =
        (device::joint_jacobian(device.geometry, q_rad).transpose().inverse() * weight_Nm).norm();
    EXPECT_GT(trial.delivered.peak_force_N, 1.0 - weight_N - 2.0 * 0.04);
    EXPECT_LT(trial.delivered.peak_force_N, 1.25 + weight_N + 2.0 * 0.04);
    EXPECT_LT(weight_N, 0.3) << "the bounds say something";
    EXPECT_LT(trial.delivered.aside_m, 1e-3);
}

TEST(ConditionTrial, IsTheSameEachTime) {
    const Protocol protocol = protocol_of(kPlainProtocol);
    const StimulusTrial first = trial_of(protocol);
    const StimulusTrial again = trial_of(protocol);
    EXPECT_EQ(first.delivered.peak_force_N, again.delivered.peak_force_N);
    EXPECT_EQ(first.delivered.aside_m, again.delivered.aside_m);
    EXPECT_EQ(first.delivered.generated_J, again.delivered.generated_J);
}

TEST(ConditionTrial, AnUnstableTuningShakes) {
    Protocol protocol = protocol_of(kPlainProtocol);
    EXPECT_LT(trial_of(protocol).shaking_m_per_s, kMaxShaking_m_per_s);
    protocol.conditions[0].tuning.K_P_V_per_rad = 300.0;
    const StimulusTrial trial = trial_of(protocol);
    EXPECT_GT(trial.shaking_m_per_s, kMaxShaking_m_per_s);
    const ProtocolFindings findings = findings_of(protocol, {trial});
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].severity, Severity::error);
}

TEST(ConditionTrial, SaysOfAMonitorThatTripsWhy) {
    const Protocol protocol = protocol_of(kPlainProtocol);
    StudySetting setting = study_setting(protocol, testing::folders());
    setting.device.limits.tip_speed_m_per_s = 0.01; // the hand comes down with 20 mm in 0.5 s
    const StimulusTrial trial = try_stimulus(protocol, setting, all_presented(protocol)[0]);
    EXPECT_NE(trial.trip.find("tip speed"), std::string::npos) << trial.trip;
    const ProtocolFindings findings = findings_of(protocol, {trial});
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].severity, Severity::error);
    EXPECT_NE(findings[0].what.find(trial.trip), std::string::npos);
}

/// The inverse map pushes along a sloping surface; on the scene that shows that, by a third and
/// more of the force. The transpose map does not.
TEST(ConditionTrial, AHandSlidesWhereTheForceIsNotSquareToTheSurface) {
    const std::string spot_of_scene =
        with(with(with(kPlainProtocol, "point_m = [0.0, -0.005, -0.015]\n", ""),
                  "normal = [0.0, 1.0, 0.0]\n", ""),
             "\"plate\"", "\"wrong_direction\"");
    Protocol protocol = protocol_of(spot_of_scene);
    protocol.conditions[0].press_N = 3.0;
    const StimulusTrial square = trial_of(protocol);
    EXPECT_LT(square.delivered.aside_m, kMaxSlide_m);
    protocol.conditions[0].tuning.map = control::MotionMap::inverse;
    const StimulusTrial askew = trial_of(protocol);
    EXPECT_GT(askew.delivered.aside_m, kMaxSlide_m);
    EXPECT_EQ(findings_of(protocol, {askew})[0].severity, Severity::error);
    protocol.conditions[0].hold = Hold::cup;
    EXPECT_LT(trial_of(protocol).delivered.aside_m, kMaxSlide_m);
}

TEST(ConditionTrial, APulseAddsItsForceToThePress) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::pulse;
    Condition &condition = protocol.conditions[0];
    condition.hold = Hold::cup;
    condition.press_N = 0.5;
    condition.pulse_N = 2.0;  // of which the cup's spring takes K/(K + k), three quarters
    condition.pulse_hz = 5.0; // so slow that hand and windings follow
    const StimulusTrial with_pulse = trial_of(protocol);
    condition.pulse_N = 0.05;
    const StimulusTrial without = trial_of(protocol);
    EXPECT_EQ(with_pulse.trip, "");
    EXPECT_GT(with_pulse.delivered.peak_force_N, without.delivered.peak_force_N + 0.2);
}

/// In a cup the hand yields to a turned force, but does not slide; on a surface it slides.
TEST(ConditionTrial, ATurnedForcePushesAHandAsideThatIsNotInACup) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.conditions[0].turn_deg = 50.0;
    protocol.conditions[0].press_N = 1.5;
    const StimulusTrial slides = trial_of(protocol);
    EXPECT_EQ(slides.trip, "");
    EXPECT_GT(slides.delivered.aside_m, kMaxSlide_m);
    EXPECT_EQ(findings_of(protocol, {slides})[0].severity, Severity::error);
    protocol.conditions[0].hold = Hold::cup;
    EXPECT_TRUE(findings_of(protocol, {trial_of(protocol)}).empty());
}

TEST(ConditionTrial, SaysOfAHandThatGivesWayToo) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.conditions[0].hold = Hold::cup;
    protocol.conditions[0].turn_deg = 80.0; // tan 80° = 5.7, and so many newtons along the surface
    const StimulusTrial trial = trial_of(protocol);
    EXPECT_EQ(trial.failure, StimulusFailure::too_much_work);
    const ProtocolFindings findings = findings_of(protocol, {trial});
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].severity, Severity::error);
    EXPECT_NE(findings[0].what.find("gave way"), std::string::npos) << findings[0].what;
}

TEST(ConditionTrial, ABlowIsHarderTheFasterItIs) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::blow;
    double before_N = 0.0;
    for (const double speed_m_per_s : {0.05, 0.1, 0.2}) {
        protocol.conditions[0].speed_m_per_s = speed_m_per_s;
        const StimulusTrial trial = trial_of(protocol);
        EXPECT_EQ(trial.trip, "");
        EXPECT_GT(trial.delivered.peak_force_N, before_N);
        before_N = trial.delivered.peak_force_N;
    }
}

TEST(ConditionTrial, AStrokeTouchesNothing) {
    Protocol protocol = protocol_of(kPlainProtocol);
    protocol.stimulus = StimulusForm::stroke;
    protocol.conditions[0].scene = kNoScene;
    protocol.conditions[0].spot = scene::TouchSpot{Vector3(0.0, 0.01, 0.0), Vector3::UnitY()};
    const StimulusTrial trial = trial_of(protocol);
    EXPECT_EQ(trial.trip, "");
    EXPECT_FALSE(trial.has_touched);
    EXPECT_TRUE(findings_of(protocol, {trial}).empty());
}

} // namespace
} // namespace springdrive::study
