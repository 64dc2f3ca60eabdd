// Covers engine/lab/rig/touch_run.cpp.
#include "engine/lab/rig/touch_run.h"

#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::rig {
namespace {

TEST(TouchRun, IsWhatTheProxyDid) {
    contact::TriangleSoup soup = testing::icosphere(3, 0.05);
    const contact::HapticSurface surface(soup);
    std::vector<Vector3> tips;
    for (int i = 0; i < 400; ++i) {
        const double angle = 0.02 * i;
        tips.emplace_back((0.052 - 1e-5 * i) * Vector3(std::cos(angle), std::sin(angle), 0.0));
    }
    const TouchRun run = run_touch(surface, tips, 0.0, 2);
    ASSERT_EQ(run.steps.size(), tips.size());
    contact::Proxy proxy;
    proxy.reset(tips[0]);
    int touching = 0;
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const contact::Contact contact = proxy.update(surface, tips[i]);
        const TouchStep &step = run.steps[i];
        EXPECT_EQ(step.tip_m, tips[i]);
        EXPECT_EQ(step.proxy_m, contact.x0_m);
        EXPECT_EQ(step.normal, contact.normal);
        EXPECT_EQ(step.constraints, contact.active_constraints);
        EXPECT_EQ(step.is_touching(), contact.touching);
        EXPECT_FALSE(step.has_friction);
        ASSERT_EQ(run.way(i).size(), proxy.path().size());
        EXPECT_TRUE(std::ranges::equal(run.way(i), proxy.path()));
        EXPECT_LE(step.min_ns, step.first_ns);
        EXPECT_GE(step.min_ns, 0.0);
        touching += contact.touching ? 1 : 0;
    }
    EXPECT_GT(touching, 100);
    EXPECT_LT(touching, 400);
}

TEST(TouchRun, KnowsWhatHasFriction) {
    contact::TriangleSoup soup = testing::sheet(4, 0.02);
    soup.materials[0].static_friction = 0.5;
    soup.materials[0].dynamic_friction = 0.4;
    const contact::HapticSurface surface(soup);
    const std::vector<Vector3> tips{Vector3(0, 1e-3, 0), Vector3(0, -1e-3, 0)};
    const TouchRun run = run_touch(surface, tips, 0.0, 1);
    EXPECT_FALSE(run.steps[0].has_friction); // free
    EXPECT_TRUE(run.steps[1].has_friction);
}

TEST(UpdateTimes, AreRanks) {
    TouchRun run;
    for (int i = 1; i <= 1000; ++i) {
        TouchStep step;
        step.constraints = 1;
        step.first_ns = 1001 - i;
        step.min_ns = 7.0;
        run.steps.push_back(step);
    }
    const UpdateTimes times = update_times(run, true, &TouchStep::first_ns).value();
    EXPECT_EQ(times.median_ns, 500.0);
    EXPECT_EQ(times.p99_ns, 990.0);
    EXPECT_EQ(times.p99_9_ns, 999.0);
    EXPECT_EQ(times.max_ns, 1000.0);
    EXPECT_EQ(update_times(run, true, &TouchStep::min_ns).value().max_ns, 7.0);
    EXPECT_FALSE(update_times(run, false, &TouchStep::first_ns).has_value());
    run.steps.resize(1);
    EXPECT_EQ(update_times(run, true, &TouchStep::first_ns).value().median_ns, 1000.0);
}

} // namespace
} // namespace springdrive::rig
