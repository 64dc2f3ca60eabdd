#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/inspect_report.h"
#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "device/core/device_file.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/scene/scene_surface.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

namespace springdrive::app {

namespace {

struct TypedInspect {
    std::string scene;
    std::filesystem::path device_file;
    std::string json; ///< empty: text for people
    bool no_model = false;
    bool fresh = false; ///< measure even if a choice is cached
    Existing existing = Existing::keep;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// With the default tuning at 1 kHz, as `springdrive demo` begins.
model_selection::ModelSelection model_of_scene(const TypedInspect &typed, const scene::Scene &scene,
                                               const device::DeviceDescription &device) {
    std::ifstream stream(typed.device_file, std::ios::binary);
    const std::string device_text{std::istreambuf_iterator<char>(stream), {}};
    const model_selection::ModelQuestion question{&scene, device, {}, 1e-3, 0.0};
    const model_selection::ModelMemory memory{device_text, SPRINGDRIVE_VERSION};
    ProgressLine line;
    const model_selection::ModelProgress show = [&line](const std::string &what, double share) {
        line.show("springdrive: measuring models: " + what + ',', share);
    };
    const std::shared_ptr<const model_selection::ModelChooser> chooser =
        model_selection::cached_chooser();
    return typed.fresh ? chooser->measured(question, memory, show)
                       : chooser->known(question, memory, show);
}

void run(const TypedInspect &typed) {
    check_outputs({{typed.device_file}, typed.scene, {typed.json}}, typed.existing);
    const device::DeviceDescription device = device::read_device_file(typed.device_file);
    const auto start = std::chrono::steady_clock::now();
    const scene::Scene scene = load_scene_with_lines(typed.scene, device.workspace);
    InspectReport report;
    report.load_s = seconds_since(start);
    const auto loaded = std::chrono::steady_clock::now();
    const contact::HapticSurface surface = scene::haptic_surface_of(scene);
    report.preparation_s = seconds_since(loaded);
    report.name = typed.scene;
    report.scene = &scene;
    report.surface = &surface;
    std::error_code not_a_file;
    const std::uintmax_t bytes = std::filesystem::file_size(typed.scene, not_a_file);
    report.file_bytes = not_a_file ? 0 : bytes;
    std::optional<model_selection::ModelSelection> model;
    if (!typed.no_model) {
        model = model_of_scene(typed, scene, device);
        report.model = &*model;
    }
    write_report([&](std::ostream &out) { write_inspect_table(out, report); },
                 {{typed.json, [&](std::ostream &out) { write_inspect_json(out, report); }}},
                 typed.existing);
}

} // namespace

void add_inspect_command(Command &app) {
    Command inspect =
        app.add_subcommand("inspect", "the content of a scene, what can be touched, and "
                                      "the model that it would get");
    const auto typed = std::make_shared<TypedInspect>();
    inspect
        .add_option("scene", typed->scene,
                    "a glTF file, or sphere:N, bumpy:N, organic:N, scan:N or cad:N, of N triangles")
        .type_name("FILE")
        .required();
    add_device_file_option(inspect, typed->device_file);
    add_output_option(inspect, "--json", typed->json, "JSON");
    add_force_option(inspect, typed->existing);
    inspect.add_flag("--no-model", typed->no_model,
                     "do not measure which model the scene would get, which takes seconds");
    inspect.add_flag("--fresh", typed->fresh,
                     "measure the model again, even if a result is cached");
    inspect.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
