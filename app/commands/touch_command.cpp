#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "app/commands/touch_report.h"
#include "base/input_error.h"
#include "base/number_in.h"
#include "device/core/device_file.h"
#include "device/simulated/hand_path.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scene_surface.h"
#include "engine/servo/servo.h"

#include <algorithm>
#include <chrono>
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

constexpr int kMaxSteps = 1'000'000;
constexpr int kRepeats = 3;

struct TypedTouch {
    std::string scene;
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
    const scene::Scene scene = load_scene_with_lines(typed.scene, device.workspace);

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
    if (typed.is_strict && !(found.pop_throughs.empty() && found.stuck.empty())) {
        std::cerr << "springdrive: " << found.pop_throughs.size() << " pop-throughs and "
                  << found.stuck.size() << " stuck steps\n";
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
                   "exit with 1 if there was a pop-through or a stuck step");
    touch.footer("Times are of the first of three identical runs; the best of all three shows the "
                 "influence of\nother load.");
    touch.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
