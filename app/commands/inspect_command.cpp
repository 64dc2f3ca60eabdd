#include "app/commands/inspect_command.h"

#include "app/commands/common_options.h"
#include "app/commands/inspect_report.h"
#include "app/load_lines.h"
#include "device/device_file.h"
#include "engine/scenario/touch_scene.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

namespace springdrive {

namespace {

struct Typed {
    std::string scene;
    std::filesystem::path device_file;
    std::string json; ///< empty: text for people
};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run(const Typed &typed) {
    const DeviceDescription device = read_device_file(typed.device_file);
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = load_scene_with_lines(typed.scene, device.workspace);
    InspectReport report;
    report.load_s = seconds_since(start);
    const auto loaded = std::chrono::steady_clock::now();
    const HapticSurface surface = haptic_surface_of(scene);
    report.preparation_s = seconds_since(loaded);
    report.name = typed.scene;
    report.scene = &scene;
    report.surface = &surface;
    std::error_code not_a_file;
    const std::uintmax_t bytes = std::filesystem::file_size(typed.scene, not_a_file);
    report.file_bytes = not_a_file ? 0 : bytes;
    write_output(typed.json.empty() ? "-" : typed.json, [&](std::ostream &out) {
        if (typed.json.empty()) {
            write_inspect_table(out, report);
        } else {
            write_inspect_json(out, report);
        }
    });
}

} // namespace

void add_inspect_command(CLI::App &app) {
    CLI::App &inspect =
        *app.add_subcommand("inspect", "what a scene holds, and what of it can be touched");
    const auto typed = std::make_shared<Typed>();
    inspect
        .add_option("scene", typed->scene,
                    "a glTF file, or sphere:N, bumpy:N or organic:N, of N triangles")
        ->type_name("FILE")
        ->required();
    add_device_file_option(inspect, typed->device_file);
    inspect.add_option("--json", typed->json, "write JSON to a file, or to standard output with -")
        ->type_name("FILE|-");
    inspect.callback([typed] { run(*typed); });
}

} // namespace springdrive
