#include "engine/lab/model_selection/selection_cache.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "base/timing.h"
#include "engine/control/tuning.h"
#include "engine/lab/model_selection/contact_shapes.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <ios>
#include <limits>
#include <string>
#include <vector>

namespace springdrive::model_selection {

namespace {

using Json = nlohmann::ordered_json;

Json number_json(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

double number_of(const Json &json) {
    return json.is_null() ? std::numeric_limits<double>::infinity() : json.get<double>();
}

Json error_json(const ModelError &error) {
    return {{"force_N", number_json(error.force_N)},
            {"direction_rad", number_json(error.direction_rad)}};
}

ModelError error_of(const Json &json) {
    return {number_of(json.at("force_N")), number_of(json.at("direction_rad"))};
}

Json axis_json(const ModelAxis &axis, const scene::ModelTolerance &tolerance) {
    Json candidates = Json::array();
    for (const Candidate &candidate : axis.candidates) {
        candidates.push_back({{"name", candidate.name},
                              {"cost_ns", candidate.cost.min_ns},
                              {"median_cost_ns", candidate.cost.median_ns},
                              {"greatest_cost_ns", candidate.cost.max_ns},
                              {"error", error_json(candidate.error)},
                              {"verdict", verdict(candidate.error, tolerance)}});
    }
    Json cheaper = Json::array();
    for (const CheaperTrial &trial : axis.cheaper) {
        cheaper.push_back({{"name", axis.candidates[trial.candidate].name},
                           {"error", error_json(trial.error)},
                           {"verdict", verdict(trial.error, tolerance)}});
    }
    return {{"name", axis.name},
            {"candidates", candidates},
            {"chosen", axis.candidates[axis.chosen].name},
            {"cheaper_tried", cheaper}};
}

std::size_t index_of(const ModelAxis &axis, const std::string &name) {
    for (std::size_t i = 0; i < axis.candidates.size(); ++i) {
        if (axis.candidates[i].name == name) {
            return i;
        }
    }
    throw InputError("model choice: '" + name + "' is not one of its " + axis.name + " candidates");
}

ModelAxis axis_of(const Json &json) {
    ModelAxis axis;
    axis.name = json.at("name").get<std::string>();
    for (const Json &candidate : json.at("candidates")) {
        axis.candidates.push_back(
            {candidate.at("name").get<std::string>(),
             {candidate.at("cost_ns").get<double>(), candidate.at("median_cost_ns").get<double>(),
              candidate.at("greatest_cost_ns").get<double>()},
             error_of(candidate.at("error"))});
    }
    axis.chosen = index_of(axis, json.at("chosen").get<std::string>());
    for (const Json &trial : json.at("cheaper_tried")) {
        axis.cheaper.push_back(
            {index_of(axis, trial.at("name").get<std::string>()), error_of(trial.at("error"))});
    }
    return axis;
}

ModelSelection read(const Json &json) {
    ModelSelection choice;
    const Json &tolerance = json.at("tolerance");
    choice.tolerance = {tolerance.at("force_N").get<double>(),
                        tolerance.at("direction_rad").get<double>(),
                        tolerance.at("bandwidth_hz").get<double>()};
    for (const Json &axis : json.at("axes")) {
        choice.axes.push_back(axis_of(axis));
    }
    if (choice.axes.size() != kModelAspects) {
        throw InputError("model choice: it has " + std::to_string(choice.axes.size()) +
                         " axes instead of " + std::to_string(kModelAspects));
    }
    choice.error = error_of(json.at("error"));
    choice.cost_ns = json.at("cost_ns").get<double>();
    choice.fullest_cost_ns = json.at("fullest_cost_ns").get<double>();
    choice.warnings = json.at("remarks").get<std::vector<std::string>>();
    return choice;
}

void add_soup(Sha256 &digest, const contact::TriangleSoup &soup) {
    digest.add(std::uint64_t{soup.vertices_m.size()});
    for (const Vector3 &vertex_m : soup.vertices_m) {
        digest.add(vertex_m);
    }
    digest.add(std::uint64_t{soup.triangles.size()});
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        digest.add(soup.triangles[i].data(), sizeof soup.triangles[i]);
        digest.add(std::uint64_t{soup.material_of_triangle[i]});
    }
    for (const contact::SurfaceMaterial &material : soup.materials) {
        digest.add(material.eta);
        digest.add(material.static_friction);
        digest.add(material.dynamic_friction);
        digest.add(static_cast<std::uint64_t>(material.sides));
    }
}

/// A shape is identified by its nearest points to a few points around it: different shapes differ
/// there.
void add_shape(Sha256 &digest, const contact::AnalyticShape &shape) {
    const Eigen::AlignedBox3d box = shape.bounds();
    digest.add(std::uint64_t{shape.size().index()});
    digest.add(std::uint64_t{shape.material()});
    digest.add(Vector3(box.min()));
    digest.add(Vector3(box.max()));
    for (const auto corner :
         {Eigen::AlignedBox3d::BottomLeftFloor, Eigen::AlignedBox3d::BottomRightFloor,
          Eigen::AlignedBox3d::TopLeftCeil}) {
        const contact::NearestOnShape nearest = shape.nearest(box.corner(corner));
        digest.add(nearest.point_m);
        digest.add(nearest.normal);
    }
}

void add_scene(Sha256 &digest, const scene::Scene &scene) {
    add_soup(digest, scene.surface);
    add_soup(digest, scene.flat_surface);
    digest.add(std::uint64_t{scene.shapes.size()});
    for (const contact::AnalyticShape &shape : scene.shapes) {
        add_shape(digest, shape);
    }
    digest.add(std::uint64_t{scene.planar});
    digest.add(scene.tolerance.force_N);
    digest.add(scene.tolerance.direction_rad);
    digest.add(scene.tolerance.bandwidth_hz);
}

std::filesystem::path file_of(const std::filesystem::path &folder, const std::string &key) {
    return folder / ("model-" + key.substr(0, 16) + ".json");
}

bool write_all(const std::filesystem::path &file, const std::string &text) {
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    stream.close();
    return static_cast<bool>(stream);
}

class CachedChooser : public ModelChooser {
public:
    [[nodiscard]] std::optional<ModelSelection> stored(const ModelQuestion &question,
                                                       const ModelMemory &memory) const override {
        return read_model_selection(model_cache_folder(), key_of(question, memory));
    }

    [[nodiscard]] ModelSelection measured(const ModelQuestion &question, const ModelMemory &memory,
                                          const ModelProgress &progress) const override {
        ModelSelection choice = choose_scene_model(question, progress);
        write_model_selection(model_cache_folder(), key_of(question, memory), choice);
        return choice;
    }

    [[nodiscard]] contact::HapticSurface surface_of(const scene::Scene &scene,
                                                    const ContactShape &shape) const override {
        return haptic_surface_of(scene, shape);
    }

private:
    [[nodiscard]] static std::string key_of(const ModelQuestion &question,
                                            const ModelMemory &memory) {
        return model_selection_key(question, memory.device_text, memory.program_version);
    }
};

} // namespace

Json json_of(const ModelSelection &choice) {
    Json axes = Json::array();
    for (const ModelAxis &axis : choice.axes) {
        axes.push_back(axis_json(axis, choice.tolerance));
    }
    return {{"tolerance",
             {{"force_N", choice.tolerance.force_N},
              {"direction_rad", choice.tolerance.direction_rad},
              {"bandwidth_hz", choice.tolerance.bandwidth_hz}}},
            {"axes", axes},
            {"error", error_json(choice.error)},
            {"cost_ns", choice.cost_ns},
            {"fullest_cost_ns", choice.fullest_cost_ns},
            {"remarks", choice.warnings}};
}

ModelSelection model_selection_of(const Json &json) {
    try {
        ModelSelection choice = read(json);
        static_cast<void>(model_of(choice)); // rejects unknown names
        return choice;
    } catch (const Json::exception &error) {
        throw InputError(std::string("model choice: cannot be read: ") + error.what());
    }
}

std::string model_selection_key(const ModelQuestion &question, const std::string &device_text,
                                const std::string &program_version) {
    Sha256 digest;
    add_scene(digest, *question.scene);
    digest.add(device_text);
    for (const control::Parameter &parameter : control::kParameters) {
        digest.add(question.tuning.*parameter.value);
    }
    digest.add(question.period_s);
    digest.add(question.delay_periods);
    digest.add(program_version);
    digest.add(static_cast<std::uint64_t>(kModelMeasureVersion));
    digest.add(machine_name());
    return digest.hex();
}

std::filesystem::path model_cache_folder() {
    if (const char *cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
        return std::filesystem::path(cache) / "springdrive";
    }
    if (const char *home = std::getenv("HOME"); home != nullptr && *home == '/') {
        return std::filesystem::path(home) / ".cache" / "springdrive";
    }
    return {};
}

std::optional<ModelSelection> read_model_selection(const std::filesystem::path &folder,
                                                   const std::string &key) {
    if (folder.empty()) {
        return std::nullopt;
    }
    try {
        std::ifstream stream(file_of(folder, key), std::ios::binary);
        const auto json = nlohmann::ordered_json::parse(stream);
        if (json.at("key").get<std::string>() != key) {
            return std::nullopt;
        }
        return model_selection_of(json.at("choice"));
    } catch (const InputError &) {
        return std::nullopt;
    } catch (const std::ios_base::failure &) {
        return std::nullopt; // for example a folder in its place
    } catch (const nlohmann::ordered_json::exception &) {
        return std::nullopt; // missing or damaged: measured and written again
    }
}

bool write_model_selection(const std::filesystem::path &folder, const std::string &key,
                           const ModelSelection &choice) noexcept {
    if (folder.empty()) {
        return false;
    }
    try {
        std::filesystem::create_directories(folder);
        const std::filesystem::path file = file_of(folder, key);
        const nlohmann::ordered_json json{{"key", key}, {"choice", json_of(choice)}};
        if (std::filesystem::is_symlink(file)) {
            std::filesystem::remove(file); // what it leads to is not ours to replace
        }
        NewFile written(file);
        if (write_all(written.temporary(), json.dump(2) + "\n")) {
            written.publish(Existing::replace);
            return true;
        }
    } catch (const std::exception &) {
        return false; // the cache is optional
    }
    return false;
}

std::shared_ptr<const ModelChooser> cached_chooser() { return std::make_shared<CachedChooser>(); }

} // namespace springdrive::model_selection
