// Covers engine/study/stimuli/stimulus.cpp.
#include "engine/study/stimuli/stimulus.h"

#include "base/degrees.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::study {
namespace {

/// cos φ along the normal, sin φ along axis × normal, and e along the axis: written out.
TEST(ForceAngles, AreThoseOfAForceWrittenOut) {
    const TurnFrame frame{Vector3(0.0, 0.6, 0.8), Vector3::UnitX()};
    const Vector3 towards(0.0, -0.8, 0.6); // x × (0, 0.6, 0.8)
    for (const double turn_deg : {-80.0, -20.0, 0.0, 3.0, 60.0, 89.0}) {
        const double phi = turn_deg * kRadiansPerDegree;
        const Vector3 square = std::cos(phi) * frame.normal + std::sin(phi) * towards;
        const ForceAngles in_plane = force_angles(frame, 2.5 * square);
        EXPECT_NEAR(in_plane.turn_deg, turn_deg, 1e-12);
        EXPECT_NEAR(in_plane.across_deg, 0.0, 1e-12);
        const ForceAngles across =
            force_angles(frame, square + std::tan(5.0 * kRadiansPerDegree) * frame.turn_axis);
        EXPECT_NEAR(across.turn_deg, turn_deg, 1e-12);
        EXPECT_NEAR(across.across_deg, 5.0, 1e-12);
    }
}

TEST(Pulse, HasTheImpulseOfHalfItsHeightAndEndsAtRest) {
    const Pulse pulse{1.5, 20.0};
    EXPECT_DOUBLE_EQ(pulse.force_N(0.5 * pulse.length_s()), 1.5);
    constexpr int kSteps = 1000; // the midpoint rule is exact for whole periods of a sine
    double impulse_Ns = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double since_s = (i + 0.5) / kSteps * pulse.length_s();
        impulse_Ns += pulse.force_N(since_s) * pulse.length_s() / kSteps;
        constexpr double kStep_s = 1e-6; // error of the difference: F''' h²/6 = 5e-7 N/s
        EXPECT_NEAR(pulse.rate_N_per_s(since_s),
                    (pulse.force_N(since_s + kStep_s) - pulse.force_N(since_s - kStep_s)) /
                        (2.0 * kStep_s),
                    1e-5);
    }
    EXPECT_NEAR(impulse_Ns, 0.5 * 1.5 / 20.0, 1e-14);
    for (const double outside_s : {-1e-9, 0.05 + 1e-9, 1.0}) {
        EXPECT_EQ(pulse.force_N(outside_s), 0.0);
        EXPECT_EQ(pulse.rate_N_per_s(outside_s), 0.0);
    }
}

TEST(Pulse, BeginsInTheMiddleOrSoThatItEndsInTime) {
    Stimulus stimulus;
    stimulus.presentation_s = 0.6;
    stimulus.pulse = {1.0, 30.0};
    EXPECT_DOUBLE_EQ(stimulus.pulse_from_s(), 0.3);
    stimulus.pulse.frequency_hz = 2.5; // 0.4 s
    EXPECT_DOUBLE_EQ(stimulus.pulse_from_s(), 0.6 - 0.4 - kAfterPulse_s);
}

TEST(Stimulus, GlidesBackWhereDROrLambdaDifferAndFromASteeredForce) {
    Stimulus stimulus;
    stimulus.contact.K_P_V_per_rad = 3.0;
    EXPECT_EQ(glide_back_s(stimulus), 0.0);
    stimulus.is_steered = true;
    EXPECT_EQ(glide_back_s(stimulus), 0.25);
    stimulus.contact.lambda_rad_per_s = 999.0;
    EXPECT_EQ(glide_back_s(stimulus), 0.5);
    stimulus.contact.lambda_rad_per_s = stimulus.free_space.lambda_rad_per_s;
    stimulus.contact.dR_Ohm = 0.6;
    EXPECT_EQ(glide_back_s(stimulus), 0.5);
    stimulus.min_glide_back_s = 0.7;
    EXPECT_EQ(glide_back_s(stimulus), 0.7);
    stimulus.form = StimulusForm::stroke;
    EXPECT_EQ(glide_back_s(stimulus), 0.0);
}

} // namespace
} // namespace springdrive::study
