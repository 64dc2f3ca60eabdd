#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "device/simulated/hand.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/lab/rig/scenario/touch_path.h"
#include "engine/lab/rig/touch_check.h"
#include "engine/scene/scene.h"
#include "engine/servo/servo.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

struct TouchReport {
    std::string surface; ///< file, or name of a test surface
    contact::MeshReport mesh;
    std::size_t shapes = 0;
    double preparation_s = 0.0;
    std::size_t bytes = 0;

    std::string path;                         ///< file, or name of a generated one
    std::optional<rig::TouchPathOptions> how; ///< of a generated one
    double servo_hz = 0.0;
    double radius_m = 0.0; ///< of the proxy

    double check_slack_m = 0.0; ///< of TouchCheckOptions

    rig::TouchRun run;
    rig::TouchFindings findings;
    std::optional<rig::Maximum> sphere_error_rad; ///< of a sphere, whose true normals are known
};

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

Json holds_json(const std::vector<rig::Hold> &holds) {
    Json all = Json::array();
    for (std::size_t i = 0; i < std::min(holds.size(), kNamedSteps); ++i) {
        const rig::Hold &hold = holds[i];
        all.push_back({{"first_step", hold.steps.first},
                       {"steps", hold.steps.steps},
                       {"x_m", hold.place_m.x()},
                       {"y_m", hold.place_m.y()},
                       {"z_m", hold.place_m.z()},
                       {"direction_error_deg", kDegreesPerRadian * hold.max_error_rad}});
    }
    return all;
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

void print_holds(std::ostream &out, const rig::TouchFindings &found) {
    print(out, "held, a hop leads on   {:>8}   of {} places where it stood", found.holds.size(),
          found.stands);
    if (found.stands_unchecked > 0) {
        print(out, ", {} of which were not checked", found.stands_unchecked);
    }
    out << '\n';
}

/// A header and a row for each step. SI units, but for the time of an update in nanoseconds.
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

/// One object; quantities without a value are null.
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
    json["places_stood_at"] = found.stands;
    json["places_stood_at_unchecked"] = found.stands_unchecked;
    json["holds"] = found.holds.size();
    json["held_at"] = holds_json(found.holds);
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
    print_holds(out, found);
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
    for (std::size_t i = 0; i < std::min(found.holds.size(), kNamedSteps); ++i) {
        const rig::Hold &hold = found.holds[i];
        print(out,
              "held for {} steps from step {} at {:.9g}, {:.9g}, {:.9g} m, direction off by "
              "{:.0f}°\n",
              hold.steps.steps, hold.steps.first, hold.place_m.x(), hold.place_m.y(),
              hold.place_m.z(), kDegreesPerRadian * hold.max_error_rad);
    }
}

constexpr int kMaxSteps = 1'000'000;
constexpr int kRepeats = 3;

struct TypedTouch {
    std::string scene;
    std::string gltf_scene;
    std::filesystem::path device_file;
    std::string path = "slide";
    rig::TouchPathOptions how;
    int seed = 1;
    std::optional<int> steps; ///< 20000, or those of a file
    double servo_hz = 1000.0;
    std::string checks; ///< a number, or "all"; empty: the default
    double slack_m = rig::kMinSlack_m;
    std::vector<Option> of_a_made_path; ///< which do not apply to a file's path
    std::string csv;
    std::string json;
    Existing existing = Existing::keep;
    bool is_strict = false;
};

std::size_t checks_of(const TypedTouch &typed) {
    if (typed.checks.empty()) {
        return rig::default_checks();
    }
    if (typed.checks == "all") {
        return rig::kAllSteps;
    }
    const auto number = number_in<int>(typed.checks);
    if (!number || *number < 0 || *number > kMaxSteps) {
        throw InputError("--check " + typed.checks + ": must be a number from 0 to " +
                         std::to_string(kMaxSteps) + ", or all");
    }
    return static_cast<std::size_t>(*number);
}

void check(const TypedTouch &typed) {
    check_range("--speed", typed.how.speed_m_per_s, 1e-6, 100.0);
    check_range("--depth", typed.how.depth_m, 1e-6, 1.0);
    check_range("--radius", typed.how.radius_m, 0.0, 0.1);
    check_range("--seed", typed.seed, 0, std::numeric_limits<int>::max());
    check_range("--steps", typed.steps.value_or(1), 1, kMaxSteps);
    static_cast<void>(checks_of(typed));
    check_range("--slack", typed.slack_m, rig::kMinSlack_m, 0.5 * contact::kClearance_m);
    if (typed.csv == "-" && typed.json == "-") {
        throw InputError("--csv - and --json - would mix on standard output; give one a file");
    }
}

/// The tip at each servo tick along the hand's path.
std::vector<Vector3> tips_of_file(const TypedTouch &typed, double period_s) {
    for (const Option &option : typed.of_a_made_path) {
        if (option.is_given()) {
            throw InputError(option.name() + ": belongs to a generated path; omit it with a "
                                             "path from a file");
        }
    }
    if (!std::filesystem::exists(typed.path)) {
        throw InputError("--path " + typed.path +
                         ": neither a file nor press, slide, lissajous, rain or random");
    }
    simulated::HandPath path =
        simulated::HandPath::read_csv(typed.path, simulated::HandPath::Header::optional);
    const double start_s = path.points().front().time_s;
    const double ticks = (path.points().back().time_s - start_s) / period_s + 1e-9;
    if (!typed.steps && ticks >= kMaxSteps) {
        throw InputError(typed.path + ": takes more than " + std::to_string(kMaxSteps) +
                         " steps of the servo; shorten it, or lower --servo-hz");
    }
    const double maximum = typed.steps.value_or(kMaxSteps);
    const auto count = static_cast<std::size_t>(std::min(ticks + 1.0, maximum));
    std::vector<Vector3> tips_m;
    for (std::size_t i = 0; i < count; ++i) {
        tips_m.push_back(path.at(start_s + static_cast<double>(i) * period_s).position_m);
    }
    return tips_m;
}

TouchReport touch(TypedTouch typed) {
    check(typed);
    const bool is_made = rig::touch_path_named(typed.path).has_value();
    check_outputs(
        {{typed.device_file, is_made ? "" : typed.path}, typed.scene, {typed.csv, typed.json}},
        typed.existing);
    typed.how.period_s = servo::servo_period_s(typed.servo_hz);
    const device::DeviceDescription device = device::read_device_file(typed.device_file);
    const scene::Scene scene =
        load_scene_with_progress(typed.scene, typed.gltf_scene, device.workspace);

    TouchReport report;
    report.surface = typed.scene;
    report.path = typed.path;
    report.servo_hz = typed.servo_hz;
    report.radius_m = typed.how.radius_m;
    const auto start = std::chrono::steady_clock::now();
    const contact::HapticSurface surface = scene::haptic_surface_of(scene);
    report.preparation_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    report.mesh = surface.report();
    report.shapes = surface.shapes().size();
    report.bytes = surface.bytes();

    std::vector<Vector3> tips_m;
    if (const std::optional<rig::TouchPathKind> kind = rig::touch_path_named(typed.path)) {
        typed.how.kind = *kind;
        typed.how.seed = static_cast<std::uint64_t>(typed.seed);
        typed.how.steps = static_cast<std::size_t>(typed.steps.value_or(20'000));
        tips_m = rig::touch_path(surface, {scene.lower_m, scene.upper_m}, typed.how);
        report.how = typed.how;
    } else {
        tips_m = tips_of_file(typed, typed.how.period_s);
    }
    report.run = rig::run_touch(surface, tips_m, typed.how.radius_m, kRepeats);

    rig::TouchCheckOptions options;
    options.checks = checks_of(typed);
    if (options.checks == rig::kAllSteps) {
        options.max_suspicious = rig::kAllSteps;
    }
    ProgressLine line;
    options.progress = [&line](double share) { line.show("checking", share); };
    options.slack_m = report.check_slack_m = typed.slack_m;
    options.reach_m = std::max(typed.how.radius_m, contact::kClearance_m);
    report.findings = rig::check_touch(
        report.run,
        {rig::plain_triangles(contact::prepare_mesh(scene.surface).facets), surface.shapes()},
        options);
    if (rig::names_test_sphere(typed.scene)) {
        report.sphere_error_rad = rig::sphere_direction_error_rad(report.run);
    }
    return report;
}

void run(const TypedTouch &typed) {
    const TouchReport report = touch(typed);
    write_report([&](std::ostream &out) { write_touch_table(out, report); },
                 {{typed.csv, [&](std::ostream &out) { write_touch_csv(out, report); }},
                  {typed.json, [&](std::ostream &out) { write_touch_json(out, report); }}},
                 typed.existing);
    const rig::TouchFindings &found = report.findings;
    if (typed.is_strict &&
        !(found.pop_throughs.empty() && found.stuck.empty() && found.holds.empty())) {
        std::cerr << "springdrive: " << found.pop_throughs.size() << " pop-throughs, "
                  << found.stuck.size() << " stuck steps and " << found.holds.size() << " holds\n";
        end_with_status(EXIT_FAILURE);
    }
}

void add_path_options(Command &touch, TypedTouch &typed) {
    touch
        .add_option("--path", typed.path,
                    "press, slide, lissajous, rain or random, or a CSV file with columns t,x,y,z "
                    "[s, m] [slide]")
        .type_name("PATH");
    typed.of_a_made_path = {
        touch.add_option("--speed", typed.how.speed_m_per_s, "of the tip [0.1]").type_name("M/S"),
        touch.add_option("--depth", typed.how.depth_m, "of the tip below the surface [0.0015]")
            .type_name("M"),
        touch.add_option("--seed", typed.seed, "seed of random paths [1]").type_name("N")};
    touch
        .add_option("--steps", typed.steps,
                    "number of servo ticks, up to 1000000 [20000; with a file all of it]")
        .type_name("N");
    add_servo_hz_option(touch, typed.servo_hz);
    touch.add_option("--radius", typed.how.radius_m, "of the proxy [0]").type_name("M");
}

} // namespace

void add_touch_command(Command &app) {
    Command touch = app.add_subcommand(
        "touch", "the proxy over a scene along a path: time per tick, lag, pop-throughs");
    const auto typed = std::make_shared<TypedTouch>();
    touch
        .add_option("scene", typed->scene,
                    "a glTF file, or sphere:N, bumpy:N or organic:N, of N triangles: 1280, 5120, "
                    "... 1310720; or scan:N or cad:N, of about N triangles: 1000 to 2000000")
        .type_name("FILE")
        .required();
    add_gltf_scene_option(touch, typed->gltf_scene);
    add_device_file_option(touch, typed->device_file);
    add_path_options(touch, *typed);
    touch
        .add_option("--check", typed->checks,
                    "steps in contact to check by brute force, evenly spread, besides those that "
                    "look stuck or did not settle [29956: a rate of 1 in 10000 is found with 95 %]")
        .type_name("N|all");
    touch
        .add_option("--slack", typed->slack_m,
                    "height of a ridge that is ignored as a cause of lag, 2e-12 to 5e-9 [2e-12]")
        .type_name("M");
    add_output_option(touch, "--csv", typed->csv,
                      "every step (t [s], tip x, y, z and proxy px, py, pz [m], normal, "
                      "constraints, ns of the update, lag [m] if checked, s that the proxy has "
                      "stood still while the tip moved)");
    add_output_option(touch, "--json", typed->json, "the results");
    add_force_option(touch, typed->existing);
    touch.add_flag("--strict", typed->is_strict,
                   "exit with 1 if there was a pop-through, a stuck step or a hold");
    touch.footer("Times are of the first of three identical runs; the best of all three shows the "
                 "influence of\nother load.");
    touch.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
