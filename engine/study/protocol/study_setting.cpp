#include "engine/study/protocol/study_setting.h"

#include "base/contained_path.h"
#include "base/degrees.h"
#include "base/error_text.h"
#include "base/input_error.h"
#include "base/one_line.h"
#include "device/core/device_file.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/control/motion_control.h"
#include "engine/scene/gltf.h"
#include "engine/scene/scene_surface.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace springdrive::study {

namespace {

/// How far a given spot may be from the surface, and its normal from the surface's.
constexpr double kOffSurface_m = 1e-3;
constexpr double kOffNormal_rad = 5.0 * kRadiansPerDegree;

bool is_file(const std::string &name) { return name.find_first_of("./\\") != std::string::npos; }

std::filesystem::path included_or_own(const std::string &name, const ProtocolFolders &folders,
                                      const std::string &kind, const std::string &ending) {
    if (!is_file(name)) {
        return folders.assets / kind / (name + ending);
    }
    try {
        static_cast<void>(contained_file(name, folders.own, "protocol"));
    } catch (const InputError &error) {
        throw InputError(in_quotes(name) + " " + error.what());
    }
    return folders.own / name;
}

struct LoadedStudyScene {
    scene::Lesson lesson;
    std::shared_ptr<const contact::HapticSurface> surface; ///< null: it could not be loaded
    std::string problem;                                   ///< why
};

LoadedStudyScene load(const std::filesystem::path &file, const device::Workspace &workspace) {
    LoadedStudyScene loaded;
    loaded.problem = error_text_of([&] {
        const scene::Scene scene = scene::load_gltf(file, workspace);
        loaded.lesson = scene.lesson;
        loaded.surface =
            std::make_shared<const contact::HapticSurface>(scene::haptic_surface_of(scene));
    });
    return loaded;
}

/// The contact of a tip that comes straight down on a spot and stops half a millimetre below it.
contact::Contact touch_at(const contact::HapticSurface &surface, const scene::TouchSpot &spot) {
    constexpr double kTouchDepth_m = 0.5e-3;
    constexpr int kSteps = 100;
    contact::Proxy proxy;
    proxy.reset(spot.point_m + kApproach_m * spot.normal);
    contact::Contact contact;
    for (int i = 1; i <= kSteps; ++i) {
        const double height_m = kApproach_m - (kApproach_m + kTouchDepth_m) * i / kSteps;
        contact = proxy.update(surface, spot.point_m + height_m * spot.normal);
        if (contact.touching && height_m > kOffSurface_m) {
            return contact; // something is in the way
        }
    }
    return contact;
}

std::string wrong_spot(const scene::TouchSpot &spot, const contact::Contact &contact) {
    if (!contact.touching) {
        return fmt::format("its spot is not on the surface: {:g} mm below it nothing is touched; "
                           "move point_m onto the surface, or turn normal out of it",
                           0.5);
    }
    if (const double off_m = (contact.x0_m - spot.point_m).norm(); off_m > kOffSurface_m) {
        return fmt::format("on the way to its spot the tip touches something {:.1f} mm off it; "
                           "choose a spot that is free for {:g} mm along its normal",
                           1e3 * off_m, 1e3 * kApproach_m);
    }
    const double off_rad = std::acos(std::clamp(contact.normal.dot(spot.normal), -1.0, 1.0));
    if (off_rad > kOffNormal_rad) {
        return fmt::format("its normal is {:.0f}° off the surface's at the spot; give ({:.3f}, "
                           "{:.3f}, {:.3f})",
                           off_rad * kDegreesPerRadian, contact.normal.x(), contact.normal.y(),
                           contact.normal.z());
    }
    return {};
}

PlacedCondition placed(const Condition &condition, const LoadedStudyScene &scene) {
    PlacedCondition place;
    place.surface = scene.surface;
    if (!scene.problem.empty()) {
        place.problem = scene.problem;
        return place;
    }
    if (!condition.spot && !scene.lesson.spot) {
        place.problem = fmt::format("scene {} marks no spot; give point_m and normal, in device "
                                    "coordinates",
                                    condition.scene);
        return place;
    }
    place.spot = condition.spot ? *condition.spot : *scene.lesson.spot;
    const contact::Contact contact = touch_at(*scene.surface, place.spot);
    place.problem = wrong_spot(place.spot, contact);
    place.surface_eta = contact.touching ? contact.eta : 0.0;
    return place;
}

PlacedCondition in_free_space(const Condition &condition, const device::Workspace &workspace) {
    PlacedCondition place;
    place.spot = condition.spot.value_or(scene::TouchSpot{workspace.centre_m, Vector3::UnitY()});
    place.surface_eta = 1.0;
    return place;
}

} // namespace

std::filesystem::path device_file_of(const Protocol &protocol, const ProtocolFolders &folders) {
    return included_or_own(protocol.device_file, folders, "devices", ".toml");
}

std::filesystem::path scene_file_of(const Condition &condition, const ProtocolFolders &folders) {
    return included_or_own(condition.scene, folders, "scenes", ".gltf");
}

StudySetting study_setting(const Protocol &protocol, const ProtocolFolders &folders) {
    StudySetting setting;
    setting.device = device::read_device_file(device_file_of(protocol, folders));
    setting.global_alpha_rad2_per_m2 = control::global_alpha_bound(setting.device);
    std::map<std::filesystem::path, LoadedStudyScene> scenes;
    for (const Condition &condition : protocol.conditions) {
        if (condition.scene == kNoScene) {
            setting.conditions.push_back(in_free_space(condition, setting.device.workspace));
            if (protocol.stimulus != StimulusForm::stroke) {
                setting.conditions.back().problem = "it has no scene; name one, as only a stroke "
                                                    "is felt in free space";
            }
            continue;
        }
        std::filesystem::path file;
        if (std::string problem = error_text_of([&] { file = scene_file_of(condition, folders); });
            !problem.empty()) {
            setting.conditions.emplace_back().problem = std::move(problem);
            continue;
        }
        if (!scenes.contains(file)) {
            scenes.emplace(file, load(file, setting.device.workspace));
        }
        setting.conditions.push_back(placed(condition, scenes.at(file)));
    }
    return setting;
}

} // namespace springdrive::study
