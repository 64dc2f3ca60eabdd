#include "engine/lab/model_selection/selection_cache.h"

#include "base/input_error.h"
#include "base/machine_name.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "engine/control/tuning.h"
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/selection_json.h"

#include <cstdlib>
#include <fstream>
#include <ios>

namespace springdrive::model_selection {

namespace {

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
