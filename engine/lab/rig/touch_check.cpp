#include "engine/lab/rig/touch_check.h"

#include "base/assertions.h"
#include "base/bisection.h"
#include "base/parallel.h"
#include "engine/contact/proxy/proxy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace springdrive::rig {

namespace {

using Clock = std::chrono::steady_clock;

TouchStep step_of(const contact::HapticSurface &surface, const Vector3 &tip_m,
                  const contact::Contact &contact) {
    TouchStep step;
    step.tip_m = tip_m;
    step.proxy_m = contact.x0_m;
    step.normal = contact.normal;
    step.constraints = contact.active_constraints;
    step.settled = contact.settled;
    step.has_friction =
        contact.touching && surface.materials()[contact.material].static_friction > 0.0;
    return step;
}

/// P(at most `failures` of `trials`), each failing with probability `rate`.
double probability_of_at_most(std::size_t failures, std::size_t trials, double rate) {
    const auto n = static_cast<double>(trials);
    double log_term = n * std::log1p(-rate); // of no failure
    const double log_odds = std::log(rate) - std::log1p(-rate);
    double sum = std::exp(log_term);
    for (std::size_t i = 0; i < failures; ++i) {
        const auto k = static_cast<double>(i);
        log_term += std::log((n - k) / (k + 1.0)) + log_odds;
        sum += std::exp(log_term);
    }
    return sum;
}

constexpr double kStuckShare = 0.01;

/// Fewer steps are no hold: as long as this a hand feels no wrong force.
constexpr std::size_t kHoldSteps = 3;

/// A tip that moves along the surface by less than this stands still [m].
constexpr double kStandsStill_m = 1e-8;

double angle_rad(const Vector3 &a, const Vector3 &b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Steps whose path crosses a triangle.
std::vector<std::size_t> pop_throughs(const TouchRun &run, const NearbyTriangles &nearby) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < run.steps.size(); ++i) {
        const std::span<const Vector3> way = run.way(i);
        for (std::size_t piece = 0; piece + 1 < way.size(); ++piece) {
            if (nearby.crossed(way[piece], way[piece + 1])) {
                found.push_back(i);
                break;
            }
        }
    }
    return found;
}

/// Evenly spread elements of a list, first and last included.
template <typename Element>
std::vector<Element> spread(const std::vector<Element> &all, std::size_t count) {
    if (all.size() <= count) {
        return all;
    }
    std::vector<Element> some;
    for (std::size_t i = 0; i < count; ++i) {
        some.push_back(all[count == 1 ? 0 : i * (all.size() - 1) / (count - 1)]);
    }
    return some;
}

/// What brute force says of one step.
struct CheckedStep {
    double lag_m = 0.0;
    bool is_lowest = false;
    std::optional<double> direction_error_rad;
};

/// Descends from where a step ended, and notes how far.
CheckedStep check_step(const TouchStep &step, const BruteForceProxy &brute_force, double reach_m) {
    const BruteForceProxy::End end = brute_force.walk(step.proxy_m, step.tip_m, reach_m);
    CheckedStep checked{(end.point_m - step.proxy_m).norm(), end.is_lowest, std::nullopt};
    const Vector3 force = end.point_m - step.tip_m;
    if (step.is_touching() && force.norm() > kMinGap_m) {
        checked.direction_error_rad = angle_rad(step.normal, force);
    }
    return checked;
}

/// Calls `work(i)` for each i below `count`, in parts, between which progress is told: the first
/// half of it, or the second.
template <typename Work>
void in_parts(std::size_t count, double progress, const TouchCheckOptions &options,
              const Work &work) {
    constexpr std::size_t kParts = 50;
    for (std::size_t part = 0; part < kParts; ++part) {
        options.progress(progress + 0.5 * static_cast<double>(part) / kParts);
        const std::size_t first = count * part / kParts;
        const std::size_t last = count * (part + 1) / kParts;
        for_each_in_parallel(last - first, all_processors(),
                             [&](std::size_t i) { work(first + i); });
    }
}

/// How far the force of a step is from where a hop leads on; 0 if none does.
double hold_error_rad(const TouchStep &step, const BruteForceProxy &brute_force, double reach_m) {
    if ((step.proxy_m - step.tip_m).norm() <= kMinGap_m) {
        return 0.0; // too near to tell a direction
    }
    const std::optional<Vector3> end_m = brute_force.hop(step.proxy_m, step.tip_m, reach_m);
    if (!end_m) {
        return 0.0;
    }
    const Vector3 force = *end_m - step.tip_m;
    return force.norm() > kMinGap_m ? angle_rad(step.normal, force) : std::numbers::pi;
}

/// Of the steps of one stand. Any hold has one of every three steps, so only these are checked
/// first, and what is beside them where a hop leads on.
std::vector<Hold> holds_in(const TouchRun &run, const Stall &stand,
                           const BruteForceProxy &brute_force, double reach_m) {
    std::vector<Hold> found;
    const auto error_rad = [&](std::size_t step) {
        return hold_error_rad(run.steps[step], brute_force, reach_m);
    };
    std::size_t first = stand.first;
    for (std::size_t i = first + kHoldSteps - 1; i < stand.end(); i += kHoldSteps) {
        Hold hold{{1, i}, run.steps[i].proxy_m, error_rad(i)};
        if (hold.max_error_rad <= kHoldError_rad) {
            continue;
        }
        const auto extend = [&](std::size_t to) {
            const double other_rad = error_rad(to);
            const bool holds = other_rad > kHoldError_rad;
            hold.steps.steps += holds ? 1 : 0;
            hold.max_error_rad = std::max(hold.max_error_rad, other_rad);
            return holds;
        };
        while (hold.steps.first > first && extend(hold.steps.first - 1)) {
            --hold.steps.first;
            hold.place_m = run.steps[hold.steps.first].proxy_m;
        }
        while (hold.steps.end() < stand.end() && extend(hold.steps.end())) {
        }
        if (hold.steps.steps >= kHoldSteps) {
            found.push_back(hold);
        }
        i = hold.steps.end(); // which holds no more
        first = i + 1;
    }
    return found;
}

void note(const TouchRun &run, std::size_t index, const CheckedStep &checked,
          TouchFindings &findings) {
    const TouchStep &step = run.steps[index];
    ++findings.checked;
    findings.given_up += checked.is_lowest ? 0 : 1;
    findings.lag_of_step_m[index] = checked.lag_m;
    (step.settled ? findings.lag_m : findings.unsettled_lag_m).consider(checked.lag_m, index);
    if (checked.lag_m > kLag_m) {
        findings.lagging.push_back(index);
        if (index > 0 && looks_stuck(run.steps[index - 1], step)) {
            findings.stuck.push_back(index);
        }
    }
    if (checked.direction_error_rad) {
        findings.direction_error_rad.consider(*checked.direction_error_rad, index);
    }
}

/// Of steps in ascending order.
Stall longest_of(const std::vector<std::size_t> &steps) {
    Stall longest;
    Stall now;
    for (const std::size_t step : steps) {
        if (now.end() != step || now.steps == 0) {
            now = {0, step};
        }
        ++now.steps;
        if (now.steps > longest.steps) {
            longest = now;
        }
    }
    return longest;
}

} // namespace

void TouchRun::add(const TouchStep &step, std::span<const Vector3> way_m) {
    if (first_corner.empty()) {
        first_corner.push_back(0);
    }
    steps.push_back(step);
    corners_m.insert(corners_m.end(), way_m.begin(), way_m.end());
    first_corner.push_back(corners_m.size());
}

TouchRun run_touch(const contact::HapticSurface &surface, std::span<const Vector3> tips_m,
                   double radius_m, int repeats) {
    SPRINGDRIVE_ASSERT(!tips_m.empty() && repeats >= 1);
    TouchRun run;
    run.steps.reserve(tips_m.size());
    for (int repeat = 0; repeat < repeats; ++repeat) {
        contact::Proxy proxy(radius_m);
        proxy.reset(tips_m.front());
        for (std::size_t i = 0; i < tips_m.size(); ++i) {
            const Clock::time_point start = Clock::now();
            const contact::Contact contact = proxy.update(surface, tips_m[i]);
            const Clock::time_point end = Clock::now();
            const double time_ns = std::chrono::duration<double, std::nano>(end - start).count();
            if (repeat == 0) {
                TouchStep step = step_of(surface, tips_m[i], contact);
                step.first_ns = step.min_ns = time_ns;
                run.add(step, {proxy.path().begin(), proxy.path().end()});
            } else {
                run.steps[i].min_ns = std::min(run.steps[i].min_ns, time_ns);
            }
        }
    }
    return run;
}

std::optional<UpdateTimes> update_times(const TouchRun &run, bool touching,
                                        double TouchStep::*time_ns) {
    std::vector<double> times_ns;
    for (const TouchStep &step : run.steps) {
        if (step.is_touching() == touching) {
            times_ns.push_back(step.*time_ns);
        }
    }
    if (times_ns.empty()) {
        return std::nullopt;
    }
    std::ranges::sort(times_ns);
    // The least time that a share of all does not exceed.
    const auto quantile = [&](double share) {
        const double rank = std::ceil(share * static_cast<double>(times_ns.size()));
        return times_ns[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
    };
    return UpdateTimes{quantile(0.5), quantile(0.99), quantile(0.999), times_ns.back()};
}

std::size_t trials_to_exclude(double rate, double confidence) {
    SPRINGDRIVE_ASSERT(rate > 0.0 && rate < 1.0 && confidence > 0.0 && confidence < 1.0);
    return static_cast<std::size_t>(std::ceil(std::log1p(-confidence) / std::log1p(-rate)));
}

double rate_not_excluded(std::size_t failures, std::size_t trials, double confidence) {
    SPRINGDRIVE_ASSERT(failures <= trials && confidence > 0.0 && confidence < 1.0);
    if (failures == trials) {
        return 1.0; // also without any trial
    }
    constexpr int kHalvings = 100; // rates may be small
    const auto is_likely = [&](double rate) {
        return probability_of_at_most(failures, trials, rate) > 1.0 - confidence;
    };
    return bisect({0.0, 1.0}, kHalvings, is_likely).fails_at;
}

bool looks_stuck(const TouchStep &before, const TouchStep &step) {
    if (!before.is_touching() || !step.is_touching() || step.has_friction) {
        return false;
    }
    const Vector3 tip_way = step.tip_m - before.tip_m;
    const double along_m = (tip_way - step.normal.dot(tip_way) * step.normal).norm();
    return along_m > kStandsStill_m &&
           (step.proxy_m - before.proxy_m).norm() < kStuckShare * along_m;
}

std::vector<Stall> stands(const TouchRun &run) {
    std::vector<Stall> found;
    Stall now;
    const auto keep = [&] {
        if (now.steps >= kHoldSteps) {
            found.push_back(now);
        }
    };
    for (std::size_t i = 0; i < run.steps.size(); ++i) {
        const TouchStep &step = run.steps[i];
        const bool rests = step.constraints > 1 && step.settled && !step.has_friction;
        if (rests && now.steps > 0 && (step.proxy_m - run.steps[i - 1].proxy_m).norm() <= kHop_m) {
            ++now.steps;
            continue;
        }
        keep();
        now = {rests ? 1U : 0U, i};
    }
    keep();
    return found;
}

TouchFindings check_touch(const TouchRun &run, const TouchedSurface &surface,
                          const TouchCheckOptions &options) {
    const BruteForceProxy brute_force(surface.triangles, surface.shapes, options.slack_m);
    TouchFindings findings;
    findings.pop_throughs = pop_throughs(run, brute_force.nearby());
    std::vector<std::size_t> in_contact;
    std::vector<std::size_t> suspicious;
    std::vector<std::size_t> off_rest;
    for (std::size_t i = 0; i < run.steps.size(); ++i) {
        const TouchStep &step = run.steps[i];
        if (!step.settled) {
            findings.unsettled.push_back(i);
        }
        if (step.has_friction) {
            ++findings.with_friction;
            continue;
        }
        if (!step.settled || (!step.is_touching() && step.proxy_m != step.tip_m)) {
            off_rest.push_back(i);
        }
        if (step.is_touching()) {
            in_contact.push_back(i);
            if (i > 0 && looks_stuck(run.steps[i - 1], step)) {
                suspicious.push_back(i);
            }
        }
    }
    const std::vector<std::size_t> sample = spread(in_contact, options.checks);
    const std::vector<std::size_t> beside = spread(suspicious, options.max_suspicious);
    const std::vector<std::size_t> lost = spread(off_rest, options.max_suspicious);
    findings.in_contact = in_contact.size();
    findings.sampled = sample.size();
    findings.suspicious = suspicious.size();
    std::vector<std::size_t> to_check = sample;
    to_check.insert(to_check.end(), beside.begin(), beside.end());
    to_check.insert(to_check.end(), lost.begin(), lost.end());
    std::ranges::sort(to_check);
    to_check.erase(std::unique(to_check.begin(), to_check.end()), to_check.end());

    std::vector<CheckedStep> checked(to_check.size());
    in_parts(to_check.size(), 0.0, options, [&](std::size_t i) {
        checked[i] = check_step(run.steps[to_check[i]], brute_force, options.reach_m);
    });
    findings.lag_of_step_m.resize(run.steps.size());
    for (std::size_t i = 0; i < to_check.size(); ++i) {
        note(run, to_check[i], checked[i], findings);
    }
    const auto lags = [&](std::size_t step) { return findings.lag_of_step_m[step] > kLag_m; };
    findings.sampled_lagging = static_cast<std::size_t>(std::ranges::count_if(sample, lags));
    findings.suspicious_unchecked = static_cast<std::size_t>(std::ranges::count_if(
        suspicious, [&](std::size_t step) { return !findings.lag_of_step_m[step]; }));
    findings.stall = longest_of(suspicious);
    findings.stuck_for = longest_of(findings.stuck);
    const std::vector<Stall> all_stands = stands(run);
    const std::vector<Stall> to_try = spread(all_stands, options.max_suspicious);
    std::vector<std::vector<Hold>> holds(to_try.size());
    in_parts(to_try.size(), 0.5, options, [&](std::size_t i) {
        holds[i] = holds_in(run, to_try[i], brute_force, options.reach_m);
    });
    for (const std::vector<Hold> &some : holds) {
        findings.holds.insert(findings.holds.end(), some.begin(), some.end());
    }
    findings.stands = all_stands.size();
    findings.stands_unchecked = all_stands.size() - to_try.size();
    options.progress(1.0);
    return findings;
}

std::size_t default_checks() { return trials_to_exclude(kDetectedRate, kConfidence); }

double TouchFindings::rate_not_excluded() const {
    return rig::rate_not_excluded(sampled_lagging, sampled, kConfidence);
}

Maximum sphere_direction_error_rad(const TouchRun &run) {
    Maximum error_rad;
    for (std::size_t i = 0; i < run.steps.size(); ++i) {
        const TouchStep &step = run.steps[i];
        if (step.is_touching() && (step.proxy_m - step.tip_m).norm() > kMinGap_m &&
            step.tip_m.norm() > kMinGap_m) {
            error_rad.consider(angle_rad(step.normal, step.tip_m), i);
        }
    }
    return error_rad;
}

} // namespace springdrive::rig
