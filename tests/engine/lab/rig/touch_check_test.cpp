// Covers engine/lab/rig/touch_check.cpp: faults that are made here are found, what is right is not
// taken for one.
#include "engine/lab/rig/touch_check.h"

#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace springdrive::rig {
namespace {

constexpr double kDepth_m = 1e-3;

TouchCheckOptions options(std::size_t checks = 1000) {
    TouchCheckOptions how;
    how.checks = checks;
    how.reach_m = contact::kClearance_m;
    return how;
}

/// The plane y = 0, touched from both sides.
TouchedSurface sheet() {
    return {plain_triangles(contact::prepare_mesh(testing::sheet(10, 0.05)).facets), {}};
}

/// A proxy on the sheet at (proxy_x, 0), and a tip below (tip_x, 0).
TouchStep on_sheet(double proxy_x_m, double tip_x_m) {
    TouchStep step;
    step.tip_m = {tip_x_m, -kDepth_m, 0.0};
    step.proxy_m = {proxy_x_m, contact::kClearance_m, 0.0};
    step.normal = Vector3::UnitY();
    step.constraints = 1;
    return step;
}

/// Adds a step whose way is straight from where the last one ended.
void go_on(TouchRun &run, const TouchStep &step) {
    const Vector3 from = run.steps.empty() ? step.proxy_m : run.steps.back().proxy_m;
    run.add(step, std::array{from, step.proxy_m});
}

TEST(TouchCheck, FindsNothingWrongWithWhatIsRight) {
    TouchRun run;
    for (int i = 0; i < 50; ++i) {
        go_on(run, on_sheet(1e-4 * i, 1e-4 * i));
    }
    const TouchFindings found = check_touch(run, sheet(), options());
    EXPECT_TRUE(found.pop_throughs.empty());
    EXPECT_TRUE(found.stuck.empty());
    EXPECT_TRUE(found.lagging.empty());
    EXPECT_EQ(found.suspicious, 0U);
    EXPECT_EQ(found.checked, 50U);
    EXPECT_EQ(found.given_up, 0U);
    EXPECT_LT(found.lag_m.value, 2e-9); // what a walk downhill leaves, and the clearance
    EXPECT_LT(found.direction_error_rad.value, 2e-6);
}

TEST(TouchCheck, MeasuresALag) {
    for (const double lag_m : {0.9e-6, 1.1e-6, 50e-6, 3e-3}) {
        TouchRun run;
        go_on(run, on_sheet(0.0, 0.0));
        go_on(run, on_sheet(1e-3 - lag_m, 1e-3));
        const TouchFindings found = check_touch(run, sheet(), options());
        EXPECT_NEAR(found.lag_m.value, lag_m, 3e-9);
        EXPECT_EQ(found.lag_m.step, 1U);
        EXPECT_EQ(found.lagging.size(), lag_m > 1e-6 ? 1U : 0U);
        EXPECT_TRUE(found.stuck.empty()); // it moved
    }
}

TEST(TouchCheck, MeasuresAWrongDirection) {
    TouchRun run;
    go_on(run, on_sheet(0.0, 0.0));
    TouchStep tilted = on_sheet(1e-4, 1e-4);
    tilted.normal = Vector3(std::sin(0.02), std::cos(0.02), 0.0);
    go_on(run, tilted);
    const TouchFindings found = check_touch(run, sheet(), options());
    EXPECT_NEAR(found.direction_error_rad.value, 0.02, 2e-6);
    EXPECT_EQ(found.direction_error_rad.step, 1U);
    // A tip too near tells nothing of a direction.
    for (const double gap_m : {0.9e-5, 1.1e-5}) {
        TouchRun shallow;
        TouchStep step = tilted;
        step.tip_m = step.proxy_m - gap_m * Vector3::UnitY();
        go_on(shallow, step);
        EXPECT_EQ(check_touch(shallow, sheet(), options()).direction_error_rad.step.has_value(),
                  gap_m > 1e-5);
    }
}

TEST(TouchCheck, FindsAStuckProxyAndOnlyIt) {
    // The tip goes on by 1 mm, the proxy by a little less or more than 1 % of that.
    for (const double share : {0.0, 0.009, 0.011}) {
        TouchRun run;
        go_on(run, on_sheet(0.0, 0.0));
        go_on(run, on_sheet(share * 1e-3, 1e-3));
        const TouchFindings found = check_touch(run, sheet(), options(1));
        const std::size_t expected = share < 0.01 ? 1U : 0U;
        EXPECT_EQ(found.suspicious, expected) << share;
        EXPECT_EQ(found.stuck.size(), expected) << share;
        EXPECT_EQ(found.checked, 1U + expected) << share; // the first step, and what looks stuck
    }
}

TEST(TouchCheck, TakesAStallThatDoesNotLagForRight) {
    // Stands as still as the tip moves along: by less than a micrometre.
    TouchRun run;
    go_on(run, on_sheet(0.0, 0.0));
    go_on(run, on_sheet(0.0, 0.9e-6));
    EXPECT_EQ(check_touch(run, sheet(), options()).suspicious, 1U);
    EXPECT_TRUE(check_touch(run, sheet(), options()).stuck.empty());
    go_on(run, on_sheet(0.0, 1.8e-6));
    EXPECT_EQ(check_touch(run, sheet(), options()).stuck, std::vector<std::size_t>{2});
    // A tip that stands still, or goes in and out, makes no proxy stuck.
    EXPECT_FALSE(looks_stuck(on_sheet(0.0, 1e-3), on_sheet(0.0, 1e-3)));
    TouchStep deeper = on_sheet(0.0, 0.0);
    deeper.tip_m.y() -= 1e-3;
    EXPECT_FALSE(looks_stuck(on_sheet(0.0, 0.0), deeper));
    // Nor is one stuck that has only just come into contact.
    TouchStep free = on_sheet(0.0, 0.0);
    free.constraints = 0;
    EXPECT_FALSE(looks_stuck(free, on_sheet(0.0, 1e-3)));
    EXPECT_TRUE(looks_stuck(on_sheet(0.0, 0.0), on_sheet(0.0, 1e-3)));
}

TEST(TouchCheck, TakesOneInACornerForRight) {
    // Inside of a box seen from within: the tip goes about behind the corner.
    contact::TriangleSoup soup = testing::turned_inside_out(testing::icosphere(0, 0.05));
    const contact::HapticSurface surface(soup);
    const Vector3 corner = soup.vertices_m[0];
    std::vector<Vector3> tips{Vector3::Zero()};
    for (int i = 0; i < 40; ++i) {
        const double angle = 0.3 * i;
        tips.emplace_back(1.1 * corner + 1e-3 * Vector3(std::cos(angle), std::sin(angle), 0.0));
    }
    const TouchRun run = run_touch(surface, tips, 0.0, 1);
    const TouchFindings found =
        check_touch(run, {plain_triangles(contact::prepare_mesh(soup).facets), {}}, options(1));
    EXPECT_GT(found.suspicious, 30U);
    EXPECT_TRUE(found.stuck.empty());
    EXPECT_EQ(found.checked, found.suspicious + 1);
}

TEST(TouchCheck, LeavesFrictionAlone) {
    TouchRun run;
    go_on(run, on_sheet(0.0, 0.0));
    TouchStep held = on_sheet(0.0, 1e-3);
    held.has_friction = true;
    go_on(run, held);
    const TouchFindings found = check_touch(run, sheet(), options());
    EXPECT_EQ(found.with_friction, 1U);
    EXPECT_EQ(found.checked, 1U);
    EXPECT_TRUE(found.lagging.empty());
}

TEST(TouchCheck, TellsWhatDidNotSettleApart) {
    TouchRun run;
    go_on(run, on_sheet(0.0, 0.0));
    TouchStep late = on_sheet(1e-4, 2e-4);
    late.settled = false;
    go_on(run, late);
    const TouchFindings found = check_touch(run, sheet(), options(1)); // which takes the first
    EXPECT_EQ(found.unsettled, std::vector<std::size_t>{1});
    EXPECT_NEAR(found.unsettled_lag_m.value, 1e-4, 3e-9);
    EXPECT_LT(found.lag_m.value, 2e-9);
    EXPECT_EQ(found.lagging, std::vector<std::size_t>{1});
}

TEST(TouchCheck, MissesTheProxyThatIsFreeButNotAtTheTip) {
    TouchStep free;
    free.proxy_m = free.tip_m = {0.0, 1e-3, 0.0};
    TouchRun run;
    go_on(run, free);
    EXPECT_EQ(check_touch(run, sheet(), options()).checked, 0U);
    free.tip_m.x() += 2e-6;
    go_on(run, free);
    const TouchFindings found = check_touch(run, sheet(), options());
    EXPECT_EQ(found.lagging, std::vector<std::size_t>{1});
    EXPECT_NEAR(found.lag_m.value, 2e-6, 3e-9);
}

TEST(TouchCheck, AgreesWithTheProxyOnWhereItShouldHaveGone) {
    // Each proxy where it was a tick before: what lags is the way between two places of rest.
    const contact::TriangleSoup soup = testing::bumpy_sphere(4, 0.05);
    const contact::HapticSurface surface(soup);
    std::vector<Vector3> tips;
    for (int i = 0; i < 400; ++i) {
        const double angle = 2e-3 * i;
        tips.emplace_back(0.04 * Vector3(std::cos(angle), 0.3, std::sin(angle)));
    }
    tips.front() *= 2.0; // outside
    const TouchRun run = run_touch(surface, tips, 0.0, 1);
    const TouchedSurface touched{plain_triangles(contact::prepare_mesh(soup).facets), {}};
    for (std::size_t i = 20; i < tips.size(); i += 4) {
        TouchStep step = run.steps[i];
        step.proxy_m = run.steps[i - 1].proxy_m;
        TouchRun one;
        go_on(one, step);
        const TouchFindings found = check_touch(one, touched, options());
        // Of what it stops for, 0.2 µrad of up to 10 mm, and the clearance.
        EXPECT_NEAR(found.lag_m.value, (run.steps[i].proxy_m - step.proxy_m).norm(), 2e-8) << i;
    }
}

TEST(TouchCheck, SaysHowManySuspectsItLeftOut) {
    TouchRun run;
    for (int i = 0; i < 21; ++i) {
        go_on(run, on_sheet(0.0, 1e-4 * i));
    }
    TouchCheckOptions how = options(0);
    how.max_suspicious = 5;
    const TouchFindings found = check_touch(run, sheet(), how);
    EXPECT_EQ(found.suspicious, 20U);
    EXPECT_EQ(found.checked, 5U);
    EXPECT_EQ(found.suspicious_unchecked, 15U);
    EXPECT_EQ(found.stuck.size(), 5U);
}

TEST(TouchCheck, SpreadsItsChecksOverTheStepsInContact) {
    TouchRun run;
    for (int i = 0; i < 101; ++i) {
        TouchStep step = on_sheet(1e-4 * i, 1e-4 * i);
        if (i % 2 == 0) { // free
            step.constraints = 0;
            step.tip_m = step.proxy_m;
        }
        if (i == 99) {
            step.proxy_m.x() -= 5e-6; // the last in contact lags
        }
        go_on(run, step);
    }
    const TouchFindings found = check_touch(run, sheet(), options(7));
    EXPECT_EQ(found.checked, 7U);
    EXPECT_EQ(found.lagging, std::vector<std::size_t>{99});
}

TEST(TouchCheck, SaysWhatRateItCouldHaveMissed) {
    EXPECT_EQ(default_checks(), 29'956U);
    // 40,000 steps in contact, of which 0, 40 or 4,000 lag.
    for (const std::size_t every : {0U, 1000U, 10U}) {
        TouchRun run;
        for (std::size_t i = 0; i < 40'000; ++i) {
            const double x_m = 1e-6 * static_cast<double>(i);
            const bool lags = every > 0 && i % every == every / 2;
            go_on(run, on_sheet(lags ? x_m - 5e-6 : x_m, x_m));
        }
        TouchCheckOptions how = options(4000);
        how.max_suspicious = 0;
        std::vector<double> shares;
        how.progress = [&shares](double share) { shares.push_back(share); };
        const TouchFindings some = check_touch(run, sheet(), how);
        EXPECT_EQ(some.in_contact, 40'000U);
        EXPECT_EQ(some.sampled, 4000U);
        EXPECT_TRUE(std::ranges::is_sorted(shares));
        EXPECT_EQ(shares.back(), 1.0);
        const double rate = every > 0 ? 1.0 / static_cast<double>(every) : 0.0;
        EXPECT_GE(some.rate_not_excluded(), rate);
        EXPECT_LT(some.rate_not_excluded(), 1.5 * rate + 1e-3);
        how.checks = kAllSteps;
        const TouchFindings all = check_touch(run, sheet(), how);
        EXPECT_EQ(all.sampled, 40'000U);
        EXPECT_EQ(all.checked, 40'000U);
        EXPECT_EQ(all.sampled_lagging, every > 0 ? 40'000U / every : 0U);
        if (every == 0) {
            EXPECT_NEAR(some.rate_not_excluded(), 3.0 / 4000, 2e-6);
            EXPECT_NEAR(all.rate_not_excluded(), 3.0 / 40'000, 2e-7);
        }
    }
    EXPECT_EQ(check_touch({}, sheet(), options()).rate_not_excluded(), 1.0);
}

TEST(TouchCheck, TellsTheLagOfEachStepThatItChecked) {
    TouchRun run;
    for (int i = 0; i < 10; ++i) {
        go_on(run, on_sheet(1e-4 * i - 1e-6 * i * i, 1e-4 * i));
    }
    const TouchFindings all = check_touch(run, sheet(), options());
    ASSERT_EQ(all.lag_of_step_m.size(), 10U);
    for (int i = 0; i < 10; ++i) {
        EXPECT_NEAR(all.lag_of_step_m[static_cast<std::size_t>(i)].value_or(-1.0), 1e-6 * i * i,
                    3e-9);
    }
    const TouchFindings some = check_touch(run, sheet(), options(2));
    EXPECT_TRUE(some.lag_of_step_m[0] && some.lag_of_step_m[9] && !some.lag_of_step_m[5]);
}

TEST(TouchCheck, TellsTheLongestStall) {
    // The proxy stands still in steps 3 to 5 and 8 to 14, and from 11 on so that it could move.
    TouchRun run;
    const TouchedSurface corner = sheet();
    double proxy_m = 0.0;
    for (int i = 0; i < 20; ++i) {
        const bool stands = (i >= 3 && i <= 5) || (i >= 8 && i <= 14);
        const bool creeps = i >= 8 && i <= 10; // by less than what counts as lag
        const double tip_m = stands ? proxy_m + (creeps ? 0.3e-6 * (i - 7) : 1e-4 * i) : 1e-4 * i;
        proxy_m = stands ? proxy_m : tip_m;
        go_on(run, on_sheet(proxy_m, tip_m));
    }
    const TouchFindings found = check_touch(run, corner, options());
    EXPECT_EQ(found.stall.steps, 7U);
    EXPECT_EQ(found.stall.first, 8U);
    EXPECT_EQ(found.stuck_for.steps, 4U);
    EXPECT_EQ(found.stuck_for.first, 11U);
    EXPECT_EQ(check_touch({}, sheet(), options()).stall.steps, 0U);
}

TEST(TouchCheck, FindsPopThroughs) {
    TouchRun run;
    go_on(run, on_sheet(0.0, 0.0));
    TouchStep below = on_sheet(1e-4, 1e-4);
    below.proxy_m.y() = -contact::kClearance_m;
    below.constraints = 0;
    go_on(run, below);
    go_on(run, below);                // stays there
    go_on(run, on_sheet(2e-4, 2e-4)); // and comes back, from behind
    EXPECT_EQ(check_touch(run, sheet(), options()).pop_throughs, (std::vector<std::size_t>{1, 3}));
}

TEST(TouchCheck, LooksAtEveryPieceOfAWay) {
    // Down through the sheet and up again beside it, within one step.
    TouchStep step = on_sheet(0.0, 0.0);
    TouchRun run;
    run.add(step, std::array{step.proxy_m, step.proxy_m});
    run.add(step, std::array{step.proxy_m, Vector3(0, -1e-3, 0), step.proxy_m});
    run.add(step, std::array{step.proxy_m});
    EXPECT_EQ(check_touch(run, sheet(), options()).pop_throughs, std::vector<std::size_t>{1});
}

TEST(TouchCheck, LetsATipLeaveAClosedSurfaceButNotEnter) {
    const TouchedSurface ball{
        plain_triangles(contact::prepare_mesh(testing::icosphere(2, 0.05)).facets), {}};
    TouchStep outside;
    outside.proxy_m = outside.tip_m = {0.06, 0.01, 0.0};
    TouchStep inside;
    inside.proxy_m = inside.tip_m = {0.01, 0.0, 0.0};
    TouchRun run;
    go_on(run, inside);
    go_on(run, outside);
    EXPECT_TRUE(check_touch(run, ball, options()).pop_throughs.empty());
    go_on(run, inside);
    EXPECT_EQ(check_touch(run, ball, options()).pop_throughs, std::vector<std::size_t>{2});
}

TEST(TouchCheck, HoldsNormalsAgainstTheSphere) {
    TouchRun run;
    TouchStep step;
    step.tip_m = {0.049, 0.0, 0.0};
    step.proxy_m = {0.05, 0.0, 0.0};
    step.normal = {std::cos(0.01), std::sin(0.01), 0.0};
    EXPECT_FALSE(sphere_direction_error_rad(run).step.has_value());
    go_on(run, step); // free: does not count
    EXPECT_FALSE(sphere_direction_error_rad(run).step.has_value());
    step.constraints = 1;
    go_on(run, step);
    EXPECT_NEAR(sphere_direction_error_rad(run).value, 0.01, 1e-15);
    EXPECT_EQ(sphere_direction_error_rad(run).step, 1U);
}

} // namespace
} // namespace springdrive::rig
