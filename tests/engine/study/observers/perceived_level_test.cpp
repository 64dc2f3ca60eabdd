// Covers engine/study/observers/perceived_level.cpp.
#include "engine/study/observers/perceived_level.h"

#include "tests/engine/study/protocol/plain_protocol.h"

#include <gtest/gtest.h>

namespace springdrive::study {
namespace {

FeltPresentation felt_with(double intended_N_per_m, double delivered_N_per_m) {
    FeltPresentation felt;
    felt.intended.stiffness_N_per_m = intended_N_per_m;
    felt.delivered.stiffness_N_per_m = delivered_N_per_m;
    return felt;
}

Protocol of_variable(const std::string &parameter) {
    Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    protocol.variable.parameter = parameter;
    protocol.variable.level = LevelMeaning::value;
    return protocol;
}

TEST(PerceivedLevel, IsTheEtaThatGivesTheDeliveredStiffness) {
    const Protocol protocol = of_variable("eta");
    constexpr double kRigid = 2000.0;
    FeltPresentation felt = felt_with((1.0 - 0.4) * kRigid, (1.0 - 0.43) * kRigid);
    felt.condition.tuning.eta = 0.4;
    EXPECT_NEAR(delivered_value(protocol, felt), 0.43, 1e-12);
    felt.delivered.stiffness_N_per_m.reset();
    EXPECT_EQ(delivered_value(protocol, felt), 0.4) << "as intended where nothing was measured";
}

TEST(PerceivedLevel, OfGainsIsTheOneThatGivesTheDeliveredStiffness) {
    FeltPresentation felt = felt_with(1000.0, 1050.0); // K is k_T K_P/dR
    felt.condition.tuning.K_P_V_per_rad = 6.0;
    felt.condition.tuning.dR_Ohm = 0.42;
    EXPECT_NEAR(delivered_value(of_variable("K_P_V_per_rad"), felt), 6.3, 1e-12);
    EXPECT_NEAR(delivered_value(of_variable("dR_Ohm"), felt), 0.4, 1e-12);
    EXPECT_EQ(delivered_value(of_variable("lambda_rad_per_s"), felt),
              felt.condition.tuning.lambda_rad_per_s);
}

TEST(PerceivedLevel, IsWhatWasMeasuredOfAngleAndPulse) {
    FeltPresentation felt;
    felt.condition.turn_deg = 20.0;
    felt.condition.pulse_N = 1.0;
    felt.delivered.turn_deg = 19.4;
    felt.delivered.pulse_N = 0.93;
    EXPECT_EQ(delivered_value(of_variable("turn_deg"), felt), 19.4);
    EXPECT_EQ(delivered_value(of_variable("pulse_N"), felt), 0.93);
}

TEST(PerceivedLevel, IsTheDifferenceFromTheStandardAsDelivered) {
    Protocol protocol = of_variable("turn_deg");
    FeltPresentation comparison;
    comparison.delivered.turn_deg = 21.0;
    FeltPresentation standard;
    standard.delivered.turn_deg = 5.5;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), 21.0);
    protocol.variable.level = LevelMeaning::added;
    protocol.variable.standard = 5.0;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), 15.5);
    EXPECT_EQ(delivered_level(protocol, comparison, std::nullopt), 16.0);
    protocol.variable.level = LevelMeaning::taken_off;
    EXPECT_EQ(delivered_level(protocol, comparison, standard), -15.5);
}

} // namespace
} // namespace springdrive::study
