#include "engine/scene/fit.h"

#include "base/input_error.h"

#include <gtest/gtest.h>

#include <random>

namespace springdrive::scene {
namespace {

constexpr double kFitRounding = 1e-12; // relative, a few operations in double precision

BoundingBox box_between(const Vector3 &lower, const Vector3 &upper) {
    BoundingBox box;
    box.include(lower);
    box.include(upper);
    return box;
}

TEST(Fit, FillsSixtyPercentAlongTheTightestAxisAndLessAlongTheOthers) {
    const device::Workspace workspace{Vector3(0.01, 0.02, 0.03), Vector3(0.3, 0.2, 0.1)};
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> coordinate(-100.0, 100.0);
    for (int trial = 0; trial < 200; ++trial) {
        BoundingBox box;
        for (int corner = 0; corner < 2; ++corner) {
            box.include(Vector3(coordinate(random), coordinate(random), coordinate(random)));
        }
        const Fit fit = fit_into(workspace, box);
        const Vector3 lower = fit(box.lower);
        const Vector3 upper = fit(box.upper);
        EXPECT_LT((0.5 * (lower + upper) - workspace.centre_m).norm(), kFitRounding);
        const Vector3 share = (upper - lower).cwiseQuotient(workspace.size_m);
        EXPECT_NEAR(share.maxCoeff(), 0.6, kFitRounding);
        EXPECT_TRUE(lies_within(workspace, box_between(lower, upper)));
    }
}

TEST(Fit, AFlatSceneIsScaledByWhatItSpans) {
    const device::Workspace workspace{Vector3::Zero(), Vector3(0.3, 0.2, 0.1)};
    const Fit fit = fit_into(workspace, box_between(Vector3(0, 5, 0), Vector3(3, 5, 0.5)));
    EXPECT_NEAR(fit.scale, 0.06, kFitRounding); // 0.6 × 0.3 / 3
    EXPECT_NEAR(fit(Vector3(0, 5, 0)).y(), 0.0, kFitRounding);
}

TEST(Fit, RefusesAPointAndTheBoundless) {
    const device::Workspace workspace{Vector3::Zero(), Vector3(0.3, 0.2, 0.1)};
    EXPECT_THROW((void)fit_into(workspace, box_between(Vector3(1, 2, 3), Vector3(1, 2, 3))),
                 InputError);
    EXPECT_THROW(
        (void)fit_into(workspace, box_between(Vector3(-1.5e308, 0, 0), Vector3(1.5e308, 0, 0))),
        InputError);
    EXPECT_THROW((void)fit_into(workspace, box_between(Vector3::Zero(), Vector3(1e-320, 0, 0))),
                 InputError);
}

TEST(Fit, WithinMeansOnEverySide) {
    const device::Workspace workspace{Vector3(1, 1, 1), Vector3(2, 2, 2)};
    EXPECT_TRUE(lies_within(workspace, box_between(Vector3(0, 0, 0), Vector3(2, 2, 2))));
    for (int axis = 0; axis < 3; ++axis) {
        Vector3 beyond = Vector3::Zero();
        beyond[axis] = 0.001;
        EXPECT_FALSE(
            lies_within(workspace, box_between(Vector3::Zero(), Vector3(2, 2, 2) + beyond)));
        EXPECT_FALSE(lies_within(workspace, box_between(-beyond, Vector3(2, 2, 2))));
    }
}

} // namespace
} // namespace springdrive::scene
