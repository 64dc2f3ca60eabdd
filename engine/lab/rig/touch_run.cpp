#include "engine/lab/rig/touch_run.h"

#include "base/assertions.h"
#include "engine/contact/proxy/proxy.h"

#include <algorithm>
#include <chrono>
#include <cmath>

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

} // namespace springdrive::rig
