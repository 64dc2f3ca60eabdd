#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "base/assertions.h"
#include "base/degrees.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <vector>

namespace springdrive::app {

namespace {

/// What can be touched of one node.
struct NodeFacets {
    std::size_t triangles = 0; ///< as the file gives them
    std::size_t one_sided = 0; ///< prepared
    std::size_t two_sided = 0;
};

struct InspectReport {
    std::string name;
    std::uintmax_t file_bytes = 0; ///< 0: generated, not read
    const scene::Scene *scene = nullptr;
    const contact::HapticSurface *surface = nullptr;
    double load_s = 0.0;
    double preparation_s = 0.0;
    const model_selection::ModelSelection *model =
        nullptr; ///< that the scene would get; null: not requested
};

using Json = nlohmann::ordered_json;

/// One number of mesh preparation, and its meaning for contact.
struct Finding {
    const char *key;
    const char *label;
    std::size_t contact::MeshReport::*count;
    const char *meaning;
};

constexpr std::array<Finding, 10> kFindings{{
    {"triangles_given", "triangles given", &contact::MeshReport::triangles_given, "in the file"},
    {"triangles_kept", "triangles kept", &contact::MeshReport::triangles_kept, "can be touched"},
    {"degenerate_triangles", "degenerate", &contact::MeshReport::degenerate_triangles,
     "too thin to have a normal, or not finite: left out"},
    {"duplicate_triangles", "duplicate", &contact::MeshReport::duplicate_triangles,
     "repeated: touched once"},
    {"welded_vertices", "welded vertices", &contact::MeshReport::welded_vertices,
     "at the position of another: merged, so that edges are shared"},
    {"open_edges", "open edges", &contact::MeshReport::open_edges,
     "of one triangle only: the boundary of a sheet or hole, around which the tip can move"},
    {"non_manifold_edges", "non-manifold edges", &contact::MeshReport::non_manifold_edges,
     "of more than two triangles: touched unchanged"},
    {"components", "surfaces", &contact::MeshReport::components, "connected over edges"},
    {"closed_components", "closed surfaces", &contact::MeshReport::closed_components,
     "bound a volume: stop the tip from outside, and let it leave"},
    {"inward_components", "inward surfaces", &contact::MeshReport::inward_components,
     "closed and facing inwards: stop the tip from inside, like a room"},
}};

const char *name_of(contact::TouchSides sides) {
    switch (sides) {
    case contact::TouchSides::one:
        return "one";
    case contact::TouchSides::two:
        return "two";
    case contact::TouchSides::automatic:
        break;
    }
    return "automatic";
}

Json vector_json(const Vector3 &v) { return {v.x(), v.y(), v.z()}; }

/// The warnings of loading and preparation.
std::vector<std::string> warnings_of(const InspectReport &report) {
    std::vector<std::string> warnings = report.scene->warnings;
    const std::vector<std::string> of_mesh =
        contact::warnings_about(report.surface->report(), report.surface->materials());
    warnings.insert(warnings.end(), of_mesh.begin(), of_mesh.end());
    return warnings;
}

double bytes_per_triangle(const contact::HapticSurface &surface) {
    const std::size_t kept = surface.report().triangles_kept;
    return kept == 0 ? 0.0 : static_cast<double>(surface.bytes()) / static_cast<double>(kept);
}

/// In the order of the scene's materials.
std::vector<NodeFacets> facets_of_nodes(const scene::Scene &scene,
                                        const contact::HapticSurface &surface) {
    std::vector<NodeFacets> nodes(surface.materials().size());
    for (const std::uint16_t material : scene.surface.material_of_triangle) {
        ++nodes[material].triangles;
    }
    for (std::uint32_t i = 0; i < surface.report().triangles_kept; ++i) {
        const contact::Facet &facet = surface.facet(i);
        NodeFacets &node = nodes[scene.surface.material_of_triangle[facet.triangle()]];
        ++(facet.sides() == contact::FacetSides::one ? node.one_sided : node.two_sided);
    }
    return nodes;
}

Json nodes_json(const InspectReport &report) {
    const std::vector<NodeFacets> facets = facets_of_nodes(*report.scene, *report.surface);
    Json nodes = Json::array();
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const contact::SurfaceMaterial &material = report.surface->materials()[i];
        nodes.push_back({{"name", material.name},
                         {"triangles", facets[i].triangles},
                         {"eta", material.eta},
                         {"static_friction", material.static_friction},
                         {"dynamic_friction", material.dynamic_friction},
                         {"sides", name_of(material.sides)},
                         {"one_sided_triangles", facets[i].one_sided},
                         {"two_sided_triangles", facets[i].two_sided}});
    }
    return nodes;
}

/// Without what it does not say.
Json lesson_json(const scene::Lesson &lesson) {
    Json json = Json::object();
    if (!lesson.title.empty()) {
        json["title"] = lesson.title;
    }
    if (!lesson.feel.empty()) {
        json["feel"] = lesson.feel;
    }
    if (lesson.spot) {
        json["point_m"] = vector_json(lesson.spot->point_m);
        json["normal"] = vector_json(lesson.spot->normal);
    }
    return json;
}

void write_head(std::ostream &out, const InspectReport &report) {
    const scene::Scene &scene = *report.scene;
    out << report.name;
    if (report.file_bytes > 0) {
        print(out, ": {:.1f} kB", 1e-3 * static_cast<double>(report.file_bytes));
    }
    print(out, ", loaded in {:.3f} s\n", report.load_s);
    if (!scene.lesson.title.empty()) {
        out << "title     " << scene.lesson.title << '\n';
    }
    if (!scene.lesson.feel.empty()) {
        out << "feel      " << scene.lesson.feel << '\n';
    }
    if (scene.in_metres) {
        out << "units     metres of the device's frame, unchanged\n";
    } else {
        print(out, "units     fitted to the workspace: one is {:.6g} m\n", scene.metres_per_unit);
    }
    const Vector3 size_mm = 1e3 * (scene.upper_m - scene.lower_m);
    const Vector3 lower_mm = 1e3 * scene.lower_m;
    const Vector3 upper_mm = 1e3 * scene.upper_m;
    print(out, "box       {:.2f} × {:.2f} × {:.2f} mm, ", size_mm.x(), size_mm.y(), size_mm.z());
    print(out, "from ({:.2f}, {:.2f}, {:.2f}) ", lower_mm.x(), lower_mm.y(), lower_mm.z());
    print(out, "to ({:.2f}, {:.2f}, {:.2f}) mm\n", upper_mm.x(), upper_mm.y(), upper_mm.z());
}

void write_nodes(std::ostream &out, const InspectReport &report) {
    Table table = Table::with_columns("triangles,one-sided,two-sided,η:.3g,friction\nstatic:.3g,"
                                      "dynamic:.3g,sides,node");
    const std::vector<NodeFacets> facets = facets_of_nodes(*report.scene, *report.surface);
    for (std::size_t i = 0; i < facets.size(); ++i) {
        const contact::SurfaceMaterial &material = report.surface->materials()[i];
        table.rows.push_back({facets[i].triangles, facets[i].one_sided, facets[i].two_sided,
                              material.eta, material.static_friction, material.dynamic_friction,
                              name_of(material.sides), material.name});
    }
    out << '\n';
    write_text(out, table);
}

/// Whether a candidate is selected, or its verdict in combination with the selected others.
std::string further(const model_selection::ModelAxis &axis, std::size_t candidate,
                    const scene::ModelTolerance &tolerance) {
    if (candidate == axis.chosen) {
        return "  <- selected";
    }
    for (const model_selection::CheaperTrial &trial : axis.cheaper) {
        if (trial.candidate == candidate) {
            return "; with the others selected: " +
                   model_selection::verdict(trial.error, tolerance);
        }
    }
    return "";
}

/// A model choice as text: the measurements of each candidate, the selection and its reason.
void write_model_table(std::ostream &out, const model_selection::ModelSelection &choice) {
    const scene::ModelTolerance &tolerance = choice.tolerance;
    print(out, "\nmodel: force to {:.3g} N, direction to {:.3g}°, below {:.3g} Hz\n",
          tolerance.force_N, tolerance.direction_rad * kDegreesPerRadian, tolerance.bandwidth_hz);
    Table table =
        Table::with_columns("axis,candidate,cost [ns]:.0f,force [N]:.3f,direction [°]:.2f,verdict");
    for (const model_selection::ModelAxis &axis : choice.axes) {
        for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
            const model_selection::Candidate &candidate = axis.candidates[i];
            table.rows.push_back({i == 0 ? axis.name : "", candidate.name, candidate.cost.min_ns,
                                  candidate.error.force_N,
                                  candidate.error.direction_rad * kDegreesPerRadian,
                                  model_selection::verdict(candidate.error, tolerance) +
                                      further(axis, i, tolerance)});
        }
    }
    write_text(out, table);
    print(out, "selected: error {:.3f} N and {:.2f}° relative to the full model, ",
          choice.error.force_N, choice.error.direction_rad * kDegreesPerRadian);
    print(out, "at {:.2f} µs per tick instead of {:.2f} µs\n", 1e-3 * choice.cost_ns,
          1e-3 * choice.fullest_cost_ns);
    for (const std::string &warning : choice.warnings) {
        out << "remark: " << warning << '\n';
    }
}

void write_inspect_json(std::ostream &out, const InspectReport &report) {
    SPRINGDRIVE_ASSERT(report.scene != nullptr && report.surface != nullptr);
    const scene::Scene &scene = *report.scene;
    const contact::HapticSurface &surface = *report.surface;
    Json json;
    json["file"] = report.name;
    json["file_bytes"] = report.file_bytes;
    json["load_s"] = report.load_s;
    json["in_metres"] = scene.in_metres;
    json["metres_per_unit"] = scene.metres_per_unit;
    json["lower_m"] = vector_json(scene.lower_m);
    json["upper_m"] = vector_json(scene.upper_m);
    json["nodes"] = nodes_json(report);
    json["shapes"] = surface.shapes().size();
    for (const Finding &finding : kFindings) {
        json["mesh"][finding.key] = surface.report().*finding.count;
    }
    json["preparation_s"] = report.preparation_s;
    json["bytes"] = surface.bytes();
    json["bytes_per_triangle"] = bytes_per_triangle(surface);
    json["planar"] = scene.planar;
    if (!scene.lesson.is_empty()) {
        json["lesson"] = lesson_json(scene.lesson);
    }
    if (report.model != nullptr) {
        json["model"] = model_selection::json_of(*report.model);
    }
    json["remarks"] = warnings_of(report);
    out << json_text(json) << '\n';
}

void write_inspect_table(std::ostream &out, const InspectReport &report) {
    SPRINGDRIVE_ASSERT(report.scene != nullptr && report.surface != nullptr);
    const contact::HapticSurface &surface = *report.surface;
    write_head(out, report);
    write_nodes(out, report);
    out << '\n';
    for (const Finding &finding : kFindings) {
        print(out, "{:>12}  {:<20}{}\n", surface.report().*finding.count, finding.label,
              finding.meaning);
    }
    print(out, "{:>12}  {:<20}{}\n", surface.shapes().size(), "shapes",
          "touched exactly, without triangles");
    print(out, "\nprepared in {:.3f} s; takes {:.2f} MB, {:.0f} bytes per triangle\n",
          report.preparation_s, 1e-6 * static_cast<double>(surface.bytes()),
          bytes_per_triangle(surface));
    for (const std::string &warning : warnings_of(report)) {
        out << "remark: " << warning << '\n';
    }
    if (report.model != nullptr) {
        write_model_table(out, *report.model);
    }
}

struct TypedInspect {
    std::string scene;
    std::string gltf_scene;
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
    const scene::Scene scene =
        load_scene_with_progress(typed.scene, typed.gltf_scene, device.workspace);
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
    add_gltf_scene_option(inspect, typed->gltf_scene);
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
