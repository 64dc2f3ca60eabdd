// Covers engine/lab/rig/touch_check.cpp: faults that are made here are found, what is right is not
// taken for one.
#include "engine/lab/rig/touch_check.h"

#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace springdrive::rig {
namespace {

constexpr double kDepth_m = 1e-3;

TEST(TouchRun, IsWhatTheProxyDid) {
    contact::TriangleSoup soup = testing::icosphere(3, 0.05);
    soup.materials.push_back(soup.materials[0]);
    soup.materials[1].static_friction = 0.5;
    soup.materials[1].dynamic_friction = 0.4;
    for (std::size_t i = 0; i < soup.triangles.size(); i += 2) {
        soup.material_of_triangle[i] = 1;
    }
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
    std::array<int, 3> seen{}; // free, touching without friction, with
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const contact::Contact contact = proxy.update(surface, tips[i]);
        const TouchStep &step = run.steps[i];
        EXPECT_EQ(step.tip_m, tips[i]);
        EXPECT_EQ(step.proxy_m, contact.x0_m);
        EXPECT_EQ(step.normal, contact.normal);
        EXPECT_EQ(step.constraints, contact.active_constraints);
        EXPECT_EQ(step.is_touching(), contact.touching);
        EXPECT_EQ(step.has_friction, contact.touching && contact.material == 1);
        EXPECT_TRUE(std::ranges::equal(run.way(i), proxy.path()));
        EXPECT_LE(step.min_ns, step.first_ns);
        EXPECT_GE(step.min_ns, 0.0);
        ++seen[!contact.touching ? 0 : step.has_friction ? 2 : 1];
    }
    EXPECT_GT(std::ranges::min(seen), 20); // not vacuous
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

TEST(FailureRate, NeedsThreeOverItsTrialsToBeExcluded) {
    EXPECT_EQ(trials_to_exclude(1e-4, 0.95), 29'956U);
    for (const double rate : {0.3, 0.01, 1e-3, 1e-6}) {
        const std::size_t trials = trials_to_exclude(rate, 0.95);
        EXPECT_LE(rate_not_excluded(0, trials, 0.95), rate);
        EXPECT_GT(rate_not_excluded(0, trials - 1, 0.95), rate);
    }
}

TEST(FailureRate, IsThatOfPublishedTables) {
    // Upper limits of two-sided 95 % intervals, for example Zar, Biostatistical Analysis, table of
    // confidence limits for proportions.
    EXPECT_NEAR(rate_not_excluded(0, 10, 0.975), 0.3085, 5e-5);
    EXPECT_NEAR(rate_not_excluded(1, 10, 0.975), 0.4450, 5e-5);
    EXPECT_NEAR(rate_not_excluded(5, 50, 0.975), 0.2181, 5e-5);
    EXPECT_NEAR(rate_not_excluded(0, 100, 0.975), 0.0362, 5e-5);
    EXPECT_EQ(rate_not_excluded(0, 0, 0.95), 1.0);
    EXPECT_EQ(rate_not_excluded(7, 7, 0.95), 1.0);
}

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

/// Steps whose ways are straight from where the one before ended.
TouchRun run_of(const std::vector<TouchStep> &steps) {
    TouchRun run;
    for (const TouchStep &step : steps) {
        const Vector3 from = run.steps.empty() ? step.proxy_m : run.steps.back().proxy_m;
        run.add(step, std::array{from, step.proxy_m});
    }
    return run;
}

TouchFindings findings_of(const std::vector<TouchStep> &steps, std::size_t checks = 1000) {
    return check_touch(run_of(steps), sheet(), options(checks));
}

using Steps = std::vector<std::size_t>;

TEST(TouchCheck, MeasuresALag) {
    for (const double lag_m : {0.0, 0.9e-6, 1.1e-6, 50e-6, 3e-3}) {
        const TouchFindings found = findings_of({on_sheet(0.0, 0.0), on_sheet(1e-3 - lag_m, 1e-3)});
        // What a walk downhill leaves, and the clearance.
        EXPECT_NEAR(found.lag_m.value, lag_m, 3e-9);
        EXPECT_NEAR(found.lag_of_step_m.at(1).value_or(-1.0), lag_m, 3e-9);
        EXPECT_EQ(found.lagging, lag_m > 1e-6 ? Steps{1} : Steps{});
        EXPECT_TRUE(found.stuck.empty()); // it moved
        EXPECT_TRUE(found.pop_throughs.empty());
        EXPECT_EQ(found.checked, 2U);
        EXPECT_EQ(found.given_up + found.suspicious, 0U);
    }
}

TEST(TouchCheck, MeasuresAWrongDirection) {
    TouchStep tilted = on_sheet(1e-4, 1e-4);
    tilted.normal = Vector3(std::sin(0.02), std::cos(0.02), 0.0);
    const TouchFindings found = findings_of({on_sheet(0.0, 0.0), tilted});
    EXPECT_NEAR(found.direction_error_rad.value, 0.02, 2e-6);
    EXPECT_EQ(found.direction_error_rad.step, 1U);
    // A tip too near tells nothing of a direction.
    for (const double gap_m : {0.9e-5, 1.1e-5}) {
        TouchStep shallow = tilted;
        shallow.tip_m = shallow.proxy_m - gap_m * Vector3::UnitY();
        EXPECT_EQ(findings_of({shallow}).direction_error_rad.step.has_value(), gap_m > 1e-5);
    }
}

TEST(TouchCheck, FindsAStuckProxyAndOnlyIt) {
    // The tip goes on by 1 mm, the proxy by a little less or more than 1 % of that.
    for (const double share : {0.0, 0.009, 0.011}) {
        const TouchFindings found =
            findings_of({on_sheet(0.0, 0.0), on_sheet(share * 1e-3, 1e-3)}, 1);
        const std::size_t expected = share < 0.01 ? 1U : 0U;
        EXPECT_EQ(found.suspicious, expected) << share;
        EXPECT_EQ(found.stuck.size(), expected) << share;
        EXPECT_EQ(found.checked, 1U + expected) << share; // the first step, and what looks stuck
    }
    // One that stands as still as the tip moves along, by less than a micrometre, does not lag.
    const std::vector<TouchStep> creeping{on_sheet(0.0, 0.0), on_sheet(0.0, 0.9e-6),
                                          on_sheet(0.0, 1.8e-6)};
    EXPECT_EQ(findings_of(creeping).suspicious, 2U);
    EXPECT_EQ(findings_of(creeping).stuck, Steps{2});
}

TEST(TouchCheck, WhatLooksStuckFollowsNoTipAlongTheSurface) {
    const TouchStep start = on_sheet(0.0, 0.0);
    const TouchStep gone_on = on_sheet(0.0, 1e-3);
    TouchStep deeper = start;
    deeper.tip_m.y() -= 1e-3;
    TouchStep free = start;
    free.constraints = 0;
    TouchStep held = gone_on;
    held.has_friction = true;
    EXPECT_TRUE(looks_stuck(start, gone_on));
    EXPECT_FALSE(looks_stuck(gone_on, gone_on)); // the tip stands still
    EXPECT_FALSE(looks_stuck(start, deeper));
    EXPECT_FALSE(looks_stuck(free, gone_on)); // it has only just come into contact
    EXPECT_FALSE(looks_stuck(start, held));
    const TouchFindings found = findings_of({start, held});
    EXPECT_EQ(found.with_friction, 1U);
    EXPECT_EQ(found.checked, 1U);
    EXPECT_TRUE(found.lagging.empty());
}

TEST(TouchCheck, ChecksWhatDidNotSettleAndWhatIsFreeButNotAtTheTip) {
    TouchStep late = on_sheet(1e-4, 2e-4);
    late.settled = false;
    TouchFindings found = findings_of({on_sheet(0.0, 0.0), late}, 1); // which takes the first
    EXPECT_EQ(found.unsettled, Steps{1});
    EXPECT_NEAR(found.unsettled_lag_m.value, 1e-4, 3e-9);
    EXPECT_LT(found.lag_m.value, 2e-9);
    EXPECT_EQ(found.lagging, Steps{1});

    TouchStep free;
    free.proxy_m = free.tip_m = {0.0, 1e-3, 0.0};
    EXPECT_EQ(findings_of({free}).checked, 0U);
    TouchStep behind = free;
    behind.tip_m.x() += 2e-6;
    found = findings_of({free, behind});
    EXPECT_EQ(found.lagging, Steps{1});
    EXPECT_NEAR(found.lag_m.value, 2e-6, 3e-9);
}

TEST(TouchCheck, AgreesWithTheProxyInACornerAndOnAMesh) {
    // Inside of a box seen from within, the tip goes about behind the corner: it may stand still.
    contact::TriangleSoup room = testing::turned_inside_out(testing::icosphere(0, 0.05));
    std::vector<Vector3> behind{Vector3::Zero()};
    for (int i = 0; i < 40; ++i) {
        behind.emplace_back(1.1 * room.vertices_m[0] +
                            1e-3 * Vector3(std::cos(0.3 * i), std::sin(0.3 * i), 0.0));
    }
    const TouchRun stood = run_touch(contact::HapticSurface(room), behind, 0.0, 1);
    const TouchFindings found =
        check_touch(stood, {plain_triangles(contact::prepare_mesh(room).facets), {}}, options(1));
    EXPECT_GT(found.suspicious, 30U);
    EXPECT_TRUE(found.stuck.empty());

    // Each proxy where it was a tick before: what lags is the way between two places of rest.
    const contact::TriangleSoup soup = testing::bumpy_sphere(4, 0.05);
    std::vector<Vector3> tips;
    for (int i = 0; i < 200; ++i) {
        const double angle = 2e-3 * i;
        tips.emplace_back(0.04 * Vector3(std::cos(angle), 0.3, std::sin(angle)));
    }
    tips.front() *= 2.0; // outside
    const TouchRun run = run_touch(contact::HapticSurface(soup), tips, 0.0, 1);
    TouchRun lagging;
    for (std::size_t i = 20; i < tips.size(); i += 4) {
        TouchStep step = run.steps[i];
        step.proxy_m = run.steps[i - 1].proxy_m;
        lagging.add(step, std::array{step.proxy_m});
    }
    const TouchFindings lags =
        check_touch(lagging, {plain_triangles(contact::prepare_mesh(soup).facets), {}}, options());
    for (std::size_t k = 0; k < lagging.steps.size(); ++k) {
        const double way_m = (run.steps[20 + 4 * k].proxy_m - lagging.steps[k].proxy_m).norm();
        // Of what it stops for, 0.2 µrad of up to 10 mm, and the clearance.
        EXPECT_NEAR(lags.lag_of_step_m[k].value_or(-1.0), way_m, 2e-8) << k;
    }
}

TEST(TouchCheck, SaysHowManySuspectsItLeftOut) {
    std::vector<TouchStep> steps;
    for (int i = 0; i < 21; ++i) {
        steps.push_back(on_sheet(0.0, 1e-4 * i));
    }
    TouchCheckOptions how = options(0);
    how.max_suspicious = 5;
    const TouchFindings found = check_touch(run_of(steps), sheet(), how);
    EXPECT_EQ(found.suspicious, 20U);
    EXPECT_EQ(found.checked, 5U);
    EXPECT_EQ(found.suspicious_unchecked, 15U);
    EXPECT_EQ(found.stuck.size(), 5U);
}

TEST(TouchCheck, SpreadsItsChecksOverTheStepsInContact) {
    std::vector<TouchStep> steps;
    for (int i = 0; i < 101; ++i) {
        steps.push_back(on_sheet(1e-4 * i, 1e-4 * i));
        if (i % 2 == 0) { // free
            steps.back().constraints = 0;
            steps.back().tip_m = steps.back().proxy_m;
        }
    }
    steps[99].proxy_m.x() -= 5e-6; // the last in contact lags
    const TouchFindings found = findings_of(steps, 7);
    EXPECT_EQ(found.checked, 7U);
    EXPECT_EQ(found.lagging, Steps{99});
    EXPECT_TRUE(found.lag_of_step_m[1] && found.lag_of_step_m[99] && !found.lag_of_step_m[3]);
}

TEST(TouchCheck, SaysWhatRateItCouldHaveMissed) {
    EXPECT_EQ(default_checks(), 29'956U);
    constexpr std::size_t kSteps = 8000;
    for (const std::size_t every : {0U, 1000U, 10U}) {
        std::vector<TouchStep> steps;
        for (std::size_t i = 0; i < kSteps; ++i) {
            const double x_m = 1e-6 * static_cast<double>(i);
            const bool lags = every > 0 && i % every == every / 2;
            steps.push_back(on_sheet(lags ? x_m - 5e-6 : x_m, x_m));
        }
        TouchCheckOptions how = options(800);
        how.max_suspicious = 0;
        std::vector<double> shares;
        how.progress = [&shares](double share) { shares.push_back(share); };
        const TouchFindings some = check_touch(run_of(steps), sheet(), how);
        EXPECT_EQ(some.in_contact, kSteps);
        EXPECT_EQ(some.sampled, 800U);
        EXPECT_TRUE(std::ranges::is_sorted(shares));
        EXPECT_EQ(shares.back(), 1.0);
        const double rate = every > 0 ? 1.0 / static_cast<double>(every) : 0.0;
        EXPECT_GE(some.rate_not_excluded(), rate);
        EXPECT_LT(some.rate_not_excluded(), 1.5 * rate + 6e-3);
        how.checks = kAllSteps;
        const TouchFindings all = check_touch(run_of(steps), sheet(), how);
        EXPECT_EQ(all.sampled, kSteps);
        EXPECT_EQ(all.checked, kSteps);
        EXPECT_EQ(all.sampled_lagging, every > 0 ? kSteps / every : 0U);
        if (every == 0) {
            EXPECT_NEAR(some.rate_not_excluded(), 3.0 / 800, 2e-5);
        }
    }
    EXPECT_EQ(check_touch({}, sheet(), options()).rate_not_excluded(), 1.0);
}

TEST(TouchCheck, TellsTheLongestStall) {
    // The proxy stands still in steps 3 to 5 and 8 to 14, and from 11 on so that it could move.
    std::vector<TouchStep> steps;
    double proxy_m = 0.0;
    for (int i = 0; i < 20; ++i) {
        const bool stands = (i >= 3 && i <= 5) || (i >= 8 && i <= 14);
        const bool creeps = i >= 8 && i <= 10; // by less than what counts as lag
        const double tip_m = stands ? proxy_m + (creeps ? 0.3e-6 * (i - 7) : 1e-4 * i) : 1e-4 * i;
        proxy_m = stands ? proxy_m : tip_m;
        steps.push_back(on_sheet(proxy_m, tip_m));
    }
    const TouchFindings found = findings_of(steps);
    EXPECT_EQ(found.stall.steps, 7U);
    EXPECT_EQ(found.stall.first, 8U);
    EXPECT_EQ(found.stuck_for.steps, 4U);
    EXPECT_EQ(found.stuck_for.first, 11U);
    EXPECT_EQ(findings_of({}).stall.steps, 0U);
}

TEST(TouchCheck, FindsHoldsOfThreeStepsAndMoreThanTenDegrees) {
    // On a sheet nothing holds the proxy, which stands still while the tip is beside it.
    for (const std::size_t count : {1U, 2U, 3U, 4U, 11U}) {
        for (const double error_deg : {9.0, 11.0, 60.0}) {
            for (std::size_t before = 1; before < 5; ++before) {
                TouchStep start = on_sheet(0.0, 0.0);
                start.constraints = 3;
                std::vector<TouchStep> steps(before, start);
                const double beside_m = kDepth_m * std::tan(error_deg * kRadiansPerDegree);
                for (std::size_t i = 0; i < count; ++i) {
                    TouchStep held = start;
                    held.tip_m.x() = beside_m;
                    held.normal = (held.proxy_m - held.tip_m).normalized();
                    steps.push_back(held);
                }
                steps.insert(steps.end(), 2, start);
                const TouchFindings found = findings_of(steps, 0);
                const bool is_hold = count >= 3 && error_deg > 10.0;
                ASSERT_EQ(found.holds.size(), is_hold ? 1U : 0U) << count << ' ' << error_deg;
                EXPECT_EQ(found.stands, 1U);
                if (is_hold) {
                    EXPECT_EQ(found.holds[0].steps.first, before);
                    EXPECT_EQ(found.holds[0].steps.steps, count);
                    EXPECT_EQ(found.holds[0].place_m, steps[0].proxy_m);
                    EXPECT_NEAR(found.holds[0].max_error_rad, error_deg * kRadiansPerDegree, 1e-4);
                }
                // Not with friction, and not on a face.
                for (TouchStep &step : steps) {
                    step.has_friction = true;
                }
                EXPECT_TRUE(findings_of(steps, 0).holds.empty());
                for (TouchStep &step : steps) {
                    step.has_friction = false;
                    step.constraints = 1;
                }
                EXPECT_TRUE(findings_of(steps, 0).holds.empty());
            }
        }
    }
}

TEST(TouchCheck, FindsPopThroughsInEveryPieceOfAWay) {
    TouchStep below = on_sheet(1e-4, 1e-4);
    below.proxy_m.y() = -contact::kClearance_m;
    below.constraints = 0;
    // Stays there, and comes back from behind.
    EXPECT_EQ(findings_of({on_sheet(0.0, 0.0), below, below, on_sheet(2e-4, 2e-4)}).pop_throughs,
              (Steps{1, 3}));
    // Down through the sheet and up again beside it, within one step.
    const TouchStep step = on_sheet(0.0, 0.0);
    TouchRun run;
    run.add(step, std::array{step.proxy_m, step.proxy_m});
    run.add(step, std::array{step.proxy_m, Vector3(0, -1e-3, 0), step.proxy_m});
    run.add(step, std::array{step.proxy_m});
    EXPECT_EQ(check_touch(run, sheet(), options()).pop_throughs, Steps{1});
    // A tip may leave a closed surface, but not enter.
    TouchStep outside;
    outside.proxy_m = outside.tip_m = {0.06, 0.01, 0.0};
    TouchStep inside;
    inside.proxy_m = inside.tip_m = {0.01, 0.0, 0.0};
    const TouchedSurface ball{
        plain_triangles(contact::prepare_mesh(testing::icosphere(2, 0.05)).facets), {}};
    EXPECT_EQ(check_touch(run_of({inside, outside, inside}), ball, options()).pop_throughs,
              Steps{2});
}

TEST(TouchCheck, HoldsNormalsAgainstTheSphere) {
    TouchStep step;
    step.tip_m = {0.049, 0.0, 0.0};
    step.proxy_m = {0.05, 0.0, 0.0};
    step.normal = {std::cos(0.01), std::sin(0.01), 0.0};
    TouchStep touching = step;
    touching.constraints = 1;
    EXPECT_FALSE(sphere_direction_error_rad(run_of({step})).step.has_value()); // free
    EXPECT_NEAR(sphere_direction_error_rad(run_of({step, touching})).value, 0.01, 1e-15);
    EXPECT_EQ(sphere_direction_error_rad(run_of({step, touching})).step, 1U);
}

} // namespace
} // namespace springdrive::rig
