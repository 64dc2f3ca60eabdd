// Covers engine/servo/change_over.h.
#include "engine/servo/change_over.h"

#include "tests/support/configurations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace springdrive::servo {
namespace {

TEST(ChangeOver, NoChangeMovesTheSumByMoreThanItsBound) {
    // A law that moves by itself, and is changed now and then: what goes out moves as the law does,
    // and by the bound beside.
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    for (const double period_s : {1.0 / 250, 1e-3, 1e-4}) {
        const double bound_V = kGreatestChange_V_per_s * period_s;
        ChangeOver change_over(period_s);
        Vector3 law_V = testing::random_vector(random, 5.0);
        Vector3 out_V = law_V;
        int changes = 0;
        for (int tick = 0; tick < 20'000; ++tick) {
            const Vector3 moved_V = testing::random_vector(random, 0.5);
            law_V += moved_V; // the state is another: that is the law's own
            if (chance(random) < 0.05) {
                const Vector3 changed_V = testing::random_vector(random, 12.0);
                change_over.change(law_V, changed_V);
                law_V = changed_V;
                ++changes;
            }
            change_over.fade();
            const Vector3 now_V = law_V + change_over.carried_V();
            ASSERT_LE((now_V - out_V - moved_V).cwiseAbs().maxCoeff(), bound_V + 1e-12);
            out_V = now_V;
        }
        EXPECT_GT(changes, 500);
    }
}

TEST(ChangeOver, LetsGoOfAllOfItInTheTimeItTakes) {
    const double period_s = 1e-3;
    ChangeOver change_over(period_s);
    change_over.change(Vector3(2.0, -1.0, 0.02), Vector3::Zero());
    EXPECT_EQ(change_over.carried_V(), Vector3(2.0, -1.0, 0.02));
    for (int tick = 1; tick <= 41; ++tick) {
        change_over.fade();
        EXPECT_NEAR(change_over.carried_V()[0], std::max(0.0, 2.0 - 0.05 * tick), 1e-12);
        EXPECT_NEAR(change_over.carried_V()[1], -std::max(0.0, 1.0 - 0.05 * tick), 1e-12);
        EXPECT_EQ(change_over.carried_V()[2], 0.0);
    }
    EXPECT_EQ(change_over.carried_V(), Vector3::Zero()); // to the last bit
}

TEST(ChangeOver, ThereAndBackLeavesNothing) {
    ChangeOver change_over(1e-3);
    const Vector3 a_V(1.5, 2.5, -3.0);
    const Vector3 b_V(-4.0, 0.25, 8.0);
    change_over.change(a_V, b_V);
    change_over.change(b_V, a_V);
    EXPECT_EQ(change_over.carried_V(), Vector3::Zero());
    change_over.change(a_V, b_V);
    change_over.reset();
    EXPECT_EQ(change_over.carried_V(), Vector3::Zero());
}

} // namespace
} // namespace springdrive::servo
