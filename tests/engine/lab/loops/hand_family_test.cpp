// Covers engine/lab/loops/hand_family.h.
#include "engine/lab/loops/hand_family.h"

#include <gtest/gtest.h>

namespace springdrive::loops {
namespace {

TEST(HandFamily, HasTheRelaxedGripInItsMiddle) {
    const device::HandParameters relaxed;
    const Hand middle = hand_of_firmness(0.5);
    EXPECT_DOUBLE_EQ(middle.mass_kg, relaxed.mass_kg);
    EXPECT_DOUBLE_EQ(middle.damping_Ns_per_m, relaxed.damping_Ns_per_m);
    EXPECT_DOUBLE_EQ(middle.stiffness_N_per_m, relaxed.stiffness_N_per_m);
}

TEST(HandFamily, EndsAreFartherByTheStatedFactors) {
    const Hand middle = hand_of_firmness(0.5);
    for (const double firmness : {0.0, 1.0}) {
        const Hand end = hand_of_firmness(firmness);
        const double sign = firmness > 0.5 ? 1.0 : -1.0;
        EXPECT_NEAR(end.mass_kg, middle.mass_kg * std::pow(5.0, sign), 1e-12);
        EXPECT_NEAR(end.damping_Ns_per_m, middle.damping_Ns_per_m * std::pow(5.0, sign), 1e-12);
        EXPECT_NEAR(end.stiffness_N_per_m, middle.stiffness_N_per_m * std::pow(10.0, sign), 1e-9);
    }
}

TEST(HandFamily, GrowsFirmerFromOneToTheNext) {
    for (const int grips : {2, 5, 41}) {
        const std::vector<Hand> hands = hand_family(grips);
        ASSERT_EQ(hands.size(), static_cast<std::size_t>(grips) + 1);
        for (std::size_t i = 1; i < hands.size(); ++i) {
            EXPECT_GT(hands[i].mass_kg, hands[i - 1].mass_kg);
            EXPECT_GT(hands[i].damping_Ns_per_m, hands[i - 1].damping_Ns_per_m);
            EXPECT_GT(hands[i].stiffness_N_per_m, hands[i - 1].stiffness_N_per_m);
        }
        EXPECT_EQ(hands[1].name, "light");
        EXPECT_EQ(hands.back().name, "firm");
        EXPECT_EQ(hands.back().mass_kg, hand_of_firmness(1.0).mass_kg);
    }
}

TEST(HandFamily, BeginsWithoutAHand) {
    const Hand without_hand = hand_family().front();
    EXPECT_EQ(without_hand.mass_kg, 0.0);
    EXPECT_EQ(without_hand.damping_Ns_per_m, 0.0);
    EXPECT_EQ(without_hand.stiffness_N_per_m, 0.0);
    EXPECT_EQ(without_hand.name, "no hand");
}

} // namespace
} // namespace springdrive::loops
