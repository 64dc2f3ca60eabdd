#include "app/panels/tuning_editor.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"
#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::app {
namespace {

using control::Tuning;

Tuning random_tuning(std::mt19937_64 &random) {
    const auto between = [&random](double from, double to) {
        return from * std::pow(to / from, std::uniform_real_distribution<>(0.0, 1.0)(random));
    };
    Tuning tuning;
    tuning.dR_Ohm = between(0.05, 2.0);
    tuning.K_P_V_per_rad = between(0.5, 200.0);
    tuning.K_D_Vs_per_rad = between(1e-3, 0.5);
    tuning.lambda_rad_per_s = between(200.0, 5000.0);
    tuning.map = random() % 2 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
    return tuning;
}

/// By the eigenvalues of every hand's loops, with K_P and K_D times `gain`.
bool is_stable(const session::Session &session, Tuning tuning, double gain) {
    tuning.K_P_V_per_rad *= gain;
    tuning.K_D_Vs_per_rad *= gain;
    return loops::is_stable(stability_case_of(session, tuning));
}

struct Rig {
    session::Session session{testing::scripted()};
    TuningEditor editor{session};
};

TEST(TuningEditor, TheLockLetsEveryStableTuningPassAndNoOther) {
    Rig rig;
    std::mt19937_64 random(11);
    const Tuning start = rig.session.tuning().now();
    int held = 0;
    int passed = 0;
    for (int i = 0; i < 300; ++i) {
        const Tuning wanted = random_tuning(random);
        rig.editor.replace(start, "start");
        rig.editor.drag(wanted, 1);
        rig.session.tuning().let_go();
        EXPECT_EQ(rig.session.servo().inputs().tuning, rig.session.tuning().now());
        EXPECT_TRUE(is_stable(rig.session, rig.session.tuning().now(), 1.0));
        if (is_stable(rig.session, wanted, 1.021)) {
            EXPECT_EQ(rig.session.tuning().now(), wanted);
            EXPECT_TRUE(rig.editor.error().empty());
            ++passed;
        } else if (!is_stable(rig.session, wanted, 1.02)) {
            EXPECT_NE(rig.session.tuning().now(), wanted);
            EXPECT_FALSE(rig.editor.error().empty());
            ++held;
        }
    }
    EXPECT_GT(held, 50);
    EXPECT_GT(passed, 50);
}

TEST(TuningEditor, ADragEndsAtTheLimit) {
    Rig rig;
    Tuning wanted = rig.session.tuning().now();
    wanted.K_P_V_per_rad = 400.0;
    rig.editor.drag(wanted, 1);
    const Tuning reached = rig.session.tuning().now();
    EXPECT_GT(reached.K_P_V_per_rad, 6.0);
    EXPECT_TRUE(is_stable(rig.session, reached, 1.0));
    // 2 % more gain is unstable, to within the last halving of the way to 400 V/rad: 0.024 V/rad.
    EXPECT_FALSE(is_stable(rig.session, reached, 1.02 * (1.0 + 0.03 / reached.K_P_V_per_rad)));
}

TEST(TuningEditor, UnlockedEveryTuningPassesAndTheIndicatorFollows) {
    Rig rig;
    rig.editor.is_unlocked = true;
    Tuning wanted = rig.session.tuning().now();
    wanted.K_P_V_per_rad = 400.0;
    rig.editor.drag(wanted, 1);
    EXPECT_EQ(rig.session.tuning().now(), wanted);
    EXPECT_FALSE(rig.editor.indicator().is_stable());
    // Locked again, every way is open from there.
    rig.editor.is_unlocked = false;
    wanted.K_P_V_per_rad = 300.0;
    rig.editor.drag(wanted, 1);
    EXPECT_EQ(rig.session.tuning().now(), wanted);
}

TEST(TuningEditor, TheIndicatorIsThatOfTheChosenHand) {
    Rig rig;
    rig.editor.is_unlocked = true;
    std::mt19937_64 random(12);
    int differing = 0;
    for (int i = 0; i < 200; ++i) {
        rig.editor.replace(random_tuning(random), "random");
        bool any_is_unstable = false;
        for (const auto &[hand, firmness] : {std::pair{IndicatorHand::light, 0.0},
                                             {IndicatorHand::relaxed, 0.5},
                                             {IndicatorHand::firm, 1.0}}) {
            rig.editor.hand = hand;
            rig.editor.update();
            loops::StabilityCase which = stability_case_of(rig.session, rig.session.tuning().now());
            which.hands = {loops::hand_of_firmness(firmness)};
            EXPECT_EQ(rig.editor.indicator().is_stable(), loops::is_stable(which));
            any_is_unstable |= !rig.editor.indicator().is_stable();
        }
        rig.editor.hand = IndicatorHand::every;
        rig.editor.update();
        if (any_is_unstable) {
            EXPECT_FALSE(rig.editor.indicator().is_stable());
        }
        rig.editor.hand = IndicatorHand::firm;
        rig.editor.update();
        differing += rig.editor.indicator().is_stable() && any_is_unstable ? 1 : 0;
    }
    EXPECT_GT(differing, 0); // some rest in a firm hand only
}

TEST(TuningEditor, WhatIsRefusedChangesNothing) {
    Rig rig;
    const Tuning start = rig.session.tuning().now();
    Tuning unstable = start;
    unstable.K_P_V_per_rad = 400.0;
    rig.editor.replace(unstable, "a file");
    EXPECT_EQ(rig.session.tuning().now(), start);
    EXPECT_NE(rig.editor.error().find("a file"), std::string::npos);
    EXPECT_FALSE(rig.session.tuning().can_undo());
    // Unlocked it becomes a step; locked again, undo works, redo is refused.
    rig.editor.is_unlocked = true;
    rig.editor.replace(unstable, "a file");
    rig.editor.is_unlocked = false;
    rig.editor.undo();
    EXPECT_EQ(rig.session.servo().inputs().tuning, start);
    rig.editor.redo();
    EXPECT_EQ(rig.session.servo().inputs().tuning, start);
    EXPECT_FALSE(rig.editor.error().empty());
}

TEST(TuningEditor, ATuningFromElsewhereIsAStep) {
    Rig rig;
    Tuning other = rig.session.tuning().now();
    other.eta = 0.5;
    rig.session.tuning().replace(other, rig.session.plot_time_s(), "by a scene's model");
    EXPECT_EQ(rig.session.servo().inputs().tuning, other);
    ASSERT_TRUE(rig.session.tuning().can_undo());
    rig.editor.undo();
    EXPECT_EQ(rig.session.servo().inputs().tuning.eta, 0.0);
}

} // namespace
} // namespace springdrive::app
