#include "app/commands/touch_report.h"

#include "base/degrees.h"
#include "base/print.h"
#include "base/quoting.h"
#include "base/table.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace springdrive::app {

namespace {

using Json = nlohmann::ordered_json;

/// The number of steps of a kind that are listed.
constexpr std::size_t kNamedSteps = 20;

std::size_t steps_in_contact(const rig::TouchRun &run) {
    return static_cast<std::size_t>(std::ranges::count_if(run.steps, &rig::TouchStep::is_touching));
}

Json times_json(const rig::TouchRun &run, bool touching, double rig::TouchStep::*time_ns) {
    const std::optional<rig::UpdateTimes> times = rig::update_times(run, touching, time_ns);
    if (!times) {
        return nullptr;
    }
    return {{"median", times->median_ns},
            {"p99", times->p99_ns},
            {"p99.9", times->p99_9_ns},
            {"max", times->max_ns}};
}

Json first_of(const std::vector<std::size_t> &steps) {
    const auto count = static_cast<std::ptrdiff_t>(std::min(steps.size(), kNamedSteps));
    return std::vector<std::size_t>(steps.begin(), steps.begin() + count);
}

Json optional_json(const std::optional<std::size_t> &value) {
    return value ? Json(*value) : Json(nullptr);
}

Json stall_json(const rig::Stall &stall, double servo_hz) {
    if (stall.steps == 0) {
        return nullptr;
    }
    return {{"steps", stall.steps},
            {"s", static_cast<double>(stall.steps) / servo_hz},
            {"first_step", stall.first}};
}

Json value_json(const rig::Maximum &maximum, double factor) {
    return maximum.step ? Json(maximum.value * factor) : Json(nullptr);
}

void add_times(Table &table, std::string what, Cell steps,
               const std::optional<rig::UpdateTimes> &times) {
    const rig::UpdateTimes known = times.value_or(rig::UpdateTimes{NAN, NAN, NAN, NAN});
    table.rows.push_back({std::move(what), std::move(steps), known.median_ns, known.p99_ns,
                          known.p99_9_ns, known.max_ns});
}

/// "29,956".
std::string grouped(double number) {
    std::string text = fmt::format("{:.0f}", number);
    for (std::size_t at = text.size(); at > 3; at -= 3) {
        text.insert(at - 3, 1, ',');
    }
    return text;
}

/// What the sample says of the rate of lagging steps.
void print_rate(std::ostream &out, const rig::TouchFindings &found) {
    print(out, "lag over 1 µm          {:>8}   of {} steps, ", found.sampled_lagging,
          grouped(static_cast<double>(found.sampled)));
    if (found.sampled == found.in_contact) {
        out << "all that were in contact";
    } else {
        print(out, "spread over {} in contact", grouped(static_cast<double>(found.in_contact)));
    }
    const double one_in = std::floor(1.0 / found.rate_not_excluded());
    print(out, ": {} 1 in {} {} ({:.0f} %)\n",
          found.sampled_lagging == 0 ? "a rate below" : "the rate is below", grouped(one_in),
          found.sampled_lagging == 0 ? "could have been missed" : "of such steps",
          100.0 * rig::kConfidence);
}

void print_stall(std::ostream &out, const char *what, const rig::Stall &stall, double servo_hz) {
    print(out, "{:<23}{:>8.3f}   {} steps", what, static_cast<double>(stall.steps) / servo_hz,
          stall.steps);
    if (stall.steps > 0) {
        print(out, " from step {}", stall.first);
    }
    out << '\n';
}

void print_steps(std::ostream &out, const char *what, const std::vector<std::size_t> &steps) {
    if (steps.empty()) {
        return;
    }
    print(out, "{}: steps", what);
    for (std::size_t i = 0; i < std::min(steps.size(), kNamedSteps); ++i) {
        print(out, " {}", steps[i]);
    }
    out << (steps.size() > kNamedSteps ? " ...\n" : "\n");
}

} // namespace

void write_touch_csv(std::ostream &out, const TouchReport &report) {
    out << "t,x,y,z,px,py,pz,nx,ny,nz,constraints,ns,lag,still\n";
    std::size_t still = 0;
    for (std::size_t i = 0; i < report.run.steps.size(); ++i) {
        const rig::TouchStep &step = report.run.steps[i];
        print(out, "{:.9g}", static_cast<double>(i) / report.servo_hz);
        for (const Vector3 &vector : {step.tip_m, step.proxy_m, step.normal}) {
            print(out, ",{:.17g},{:.17g},{:.17g}", vector.x(), vector.y(), vector.z());
        }
        const bool stands = i > 0 && rig::looks_stuck(report.run.steps[i - 1], step);
        still = stands ? still + 1 : 0;
        print(out, ",{},{:.0f},", step.constraints, step.first_ns);
        if (const std::optional<double> lag_m = report.findings.lag_of_step_m[i]) {
            print(out, "{:.17g}", *lag_m);
        }
        print(out, ",{:.9g}\n", static_cast<double>(still) / report.servo_hz);
    }
}

void write_touch_json(std::ostream &out, const TouchReport &report) {
    const rig::TouchFindings &found = report.findings;
    const rig::TouchRun &run = report.run;
    Json json;
    json["surface"] = report.surface;
    json["triangles_given"] = report.mesh.triangles_given;
    json["triangles_kept"] = report.mesh.triangles_kept;
    json["shapes"] = report.shapes;
    json["preparation_s"] = report.preparation_s;
    json["bytes"] = report.bytes;
    json["path"] = report.path;
    if (report.how) {
        json["speed_m_per_s"] = report.how->speed_m_per_s;
        json["depth_m"] = report.how->depth_m;
        json["seed"] = report.how->seed;
    }
    json["servo_hz"] = report.servo_hz;
    json["radius_m"] = report.radius_m;
    json["steps"] = run.steps.size();
    json["steps_in_contact"] = steps_in_contact(run);
    json["contact_ns"] = times_json(run, true, &rig::TouchStep::first_ns);
    json["contact_floor_ns"] = times_json(run, true, &rig::TouchStep::min_ns);
    json["free_ns"] = times_json(run, false, &rig::TouchStep::first_ns);
    json["free_floor_ns"] = times_json(run, false, &rig::TouchStep::min_ns);
    json["pop_throughs"] = found.pop_throughs.size();
    json["pop_through_steps"] = first_of(found.pop_throughs);
    json["stuck_steps"] = found.stuck.size();
    json["stuck_at_steps"] = first_of(found.stuck);
    json["unsettled_steps"] = found.unsettled.size();
    json["unsettled_at_steps"] = first_of(found.unsettled);
    json["largest_unsettled_lag_m"] = value_json(found.unsettled_lag_m, 1.0);
    json["check_slack_m"] = report.check_slack_m;
    json["steps_checked"] = found.checked;
    json["steps_sampled"] = found.sampled;
    json["steps_to_sample"] = found.in_contact;
    json["steps_sampled_lagging"] = found.sampled_lagging;
    json["confidence"] = rig::kConfidence;
    json["rate_not_excluded"] = found.rate_not_excluded();
    json["longest_standstill"] = stall_json(found.stall, report.servo_hz);
    json["longest_standstill_that_lags"] = stall_json(found.stuck_for, report.servo_hz);
    json["steps_suspicious"] = found.suspicious;
    json["steps_suspicious_unchecked"] = found.suspicious_unchecked;
    json["steps_with_friction"] = found.with_friction;
    json["checks_given_up"] = found.given_up;
    json["largest_lag_m"] = value_json(found.lag_m, 1.0);
    json["largest_lag_step"] = optional_json(found.lag_m.step);
    json["lagging_steps"] = found.lagging.size();
    json["lagging_at_steps"] = first_of(found.lagging);
    json["largest_direction_error_deg"] = value_json(found.direction_error_rad, kDegreesPerRadian);
    json["largest_direction_error_step"] = optional_json(found.direction_error_rad.step);
    if (report.sphere_error_rad) {
        json["largest_sphere_direction_error_deg"] =
            value_json(*report.sphere_error_rad, kDegreesPerRadian);
    }
    out << json_text(json) << '\n';
}

void write_touch_table(std::ostream &out, const TouchReport &report) {
    const rig::TouchFindings &found = report.findings;
    const rig::TouchRun &run = report.run;
    const std::size_t in_contact = steps_in_contact(run);
    print(out, "{}: {} of {} triangles, {} shapes; prepared in {:.3f} s, {:.1f} MB\n",
          report.surface, report.mesh.triangles_kept, report.mesh.triangles_given, report.shapes,
          report.preparation_s, 1e-6 * static_cast<double>(report.bytes));
    print(out, "path {}", report.path);
    if (report.how) {
        print(out, " at {:.4g} m/s, {:.4g} mm deep, seed {}", report.how->speed_m_per_s,
              1e3 * report.how->depth_m, report.how->seed);
    }
    print(out, "; servo {:.5g} Hz, proxy radius {:.4g} mm\n\n", report.servo_hz,
          1e3 * report.radius_m);
    Table times = Table::with_columns("update [ns]:,steps,median,p99,p99.9,max", ".0f");
    for (const bool touching : {true, false}) {
        const std::size_t steps = touching ? in_contact : run.steps.size() - in_contact;
        add_times(times, touching ? "in contact" : "free", steps,
                  rig::update_times(run, touching, &rig::TouchStep::first_ns));
        add_times(times, "  best of all repeats", "",
                  rig::update_times(run, touching, &rig::TouchStep::min_ns));
    }
    write_text(out, times);
    print(out, "\npop-throughs           {:>8}   of {} steps\n", found.pop_throughs.size(),
          run.steps.size());
    print(out, "stuck                  {:>8}   of {} suspected", found.stuck.size(),
          found.suspicious);
    if (found.suspicious_unchecked > 0) {
        print(out, ", {} of which were not checked", found.suspicious_unchecked);
    }
    out << '\n';
    print(out, "unsettled              {:>8}", found.unsettled.size());
    if (found.unsettled_lag_m.step) {
        print(out, "   which lag up to {:.3f} µm", 1e6 * found.unsettled_lag_m.value);
    }
    out << '\n';
    print(out, "largest lag, µm        {:>8.3f}   of {} steps checked", 1e6 * found.lag_m.value,
          found.checked);
    if (found.lag_m.step) {
        print(out, ", in step {}", *found.lag_m.step);
    }
    out << '\n';
    print_rate(out, found);
    print_stall(out, "longest standstill, s", found.stall, report.servo_hz);
    print_stall(out, "  while lagging, s", found.stuck_for, report.servo_hz);
    print(out, "direction error, °     {:>8.3f}\n",
          kDegreesPerRadian * found.direction_error_rad.value);
    if (report.sphere_error_rad) {
        print(out, "error from sphere, °   {:>8.3f}\n",
              kDegreesPerRadian * report.sphere_error_rad->value);
    }
    if (found.with_friction > 0) {
        print(out, "{} steps in contact with friction, which may cause lag: not checked for it\n",
              found.with_friction);
    }
    if (found.given_up > 0) {
        print(out, "{} checks did not complete\n", found.given_up);
    }
    print_steps(out, "pop-throughs", found.pop_throughs);
    print_steps(out, "stuck", found.stuck);
    print_steps(out, "unsettled", found.unsettled);
    print_steps(out, "lag over 1 µm", found.lagging);
}

} // namespace springdrive::app
