#include "engine/lab/rig/touch_check.h"

#include "engine/lab/rig/crossing_finder.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace springdrive::rig {

namespace {

constexpr double kStuckShare = 0.01;

/// A tip that moves along the surface by less than this stands still [m].
constexpr double kStandsStill_m = 1e-8;

double angle_rad(const Vector3 &a, const Vector3 &b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Steps whose path crosses a triangle.
std::vector<std::size_t> pop_throughs(const TouchRun &run,
                                      std::span<const PlainTriangle> triangles) {
    const CrossingFinder finder(triangles);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < run.steps.size(); ++i) {
        const std::span<const Vector3> way = run.way(i);
        for (std::size_t piece = 0; piece + 1 < way.size(); ++piece) {
            if (finder.crossed(way[piece], way[piece + 1])) {
                found.push_back(i);
                break;
            }
        }
    }
    return found;
}

/// Evenly spread elements of a list, first and last included.
std::vector<std::size_t> spread(const std::vector<std::size_t> &all, std::size_t count) {
    if (all.size() <= count) {
        return all;
    }
    std::vector<std::size_t> some;
    for (std::size_t i = 0; i < count; ++i) {
        some.push_back(all[count == 1 ? 0 : i * (all.size() - 1) / (count - 1)]);
    }
    return some;
}

/// Descends from where a step ended, and notes how far.
void check_step(const TouchRun &run, std::size_t index, const BruteForceProxy &brute_force,
                double reach_m, TouchFindings &findings) {
    const TouchStep &step = run.steps[index];
    const BruteForceProxy::End end = brute_force.walk(step.proxy_m, step.tip_m, reach_m);
    const double lag_m = (end.point_m - step.proxy_m).norm();
    ++findings.checked;
    findings.given_up += end.is_lowest ? 0 : 1;
    (step.settled ? findings.lag_m : findings.unsettled_lag_m).consider(lag_m, index);
    if (lag_m > kLag_m) {
        findings.lagging.push_back(index);
        if (index > 0 && looks_stuck(run.steps[index - 1], step)) {
            findings.stuck.push_back(index);
        }
    }
    const Vector3 force = end.point_m - step.tip_m;
    if (step.is_touching() && force.norm() > kMinGap_m) {
        findings.direction_error_rad.consider(angle_rad(step.normal, force), index);
    }
}

} // namespace

bool looks_stuck(const TouchStep &before, const TouchStep &step) {
    if (!before.is_touching() || !step.is_touching() || step.has_friction) {
        return false;
    }
    const Vector3 tip_way = step.tip_m - before.tip_m;
    const double along_m = (tip_way - step.normal.dot(tip_way) * step.normal).norm();
    return along_m > kStandsStill_m &&
           (step.proxy_m - before.proxy_m).norm() < kStuckShare * along_m;
}

TouchFindings check_touch(const TouchRun &run, const TouchedSurface &surface,
                          const TouchCheckOptions &options) {
    TouchFindings findings;
    findings.pop_throughs = pop_throughs(run, surface.triangles);
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
    std::vector<std::size_t> to_check = spread(in_contact, options.checks);
    const std::vector<std::size_t> beside = spread(suspicious, options.max_suspicious);
    findings.suspicious = suspicious.size();
    findings.suspicious_unchecked = suspicious.size() - beside.size();
    to_check.insert(to_check.end(), beside.begin(), beside.end());
    const std::vector<std::size_t> lost = spread(off_rest, options.max_suspicious);
    to_check.insert(to_check.end(), lost.begin(), lost.end());
    std::ranges::sort(to_check);
    to_check.erase(std::unique(to_check.begin(), to_check.end()), to_check.end());

    const BruteForceProxy brute_force(surface.triangles, surface.shapes, options.slack_m);
    for (const std::size_t index : to_check) {
        check_step(run, index, brute_force, options.reach_m, findings);
    }
    return findings;
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
