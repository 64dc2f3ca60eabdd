#include "engine/scene/scene_extras.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "engine/scene/gltf_extras.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

constexpr std::array<std::string_view, 3> kToleranceKeys = {"force_N", "direction_deg",
                                                            "bandwidth_hz"};

void read_tolerance(const Extras &extras, ModelTolerance &tolerance) {
    tolerance.force_N = extras.number("force_N", 1e-4, 10.0, "a number from 0.0001 to 10")
                            .value_or(tolerance.force_N);
    if (const auto direction_deg =
            extras.number("direction_deg", 0.01, 180.0, "a number from 0.01 to 180")) {
        tolerance.direction_rad = *direction_deg * kRadiansPerDegree;
    }
    tolerance.bandwidth_hz = extras.number("bandwidth_hz", 1.0, 5000.0, "a number from 1 to 5000")
                                 .value_or(tolerance.bandwidth_hz);
    extras.refuse_all_but(kToleranceKeys);
}

constexpr std::array<std::string_view, 4> kLessonKeys = {"title", "feel", "point", "normal"};

void read_spot(const Extras &extras, std::optional<TouchSpot> &spot) {
    constexpr double kFarthest = 1e6; // in the file's units, which may be micrometres
    const auto point = extras.vector("point", kFarthest);
    const auto normal = extras.vector("normal", kFarthest);
    if (point.has_value() != normal.has_value()) {
        extras.refuse(point ? "point" : "normal",
                      point ? "given with its normal" : "given with its point");
    }
    if (normal && normal->isZero(0.0)) {
        extras.refuse("normal", "a direction, not zero");
    }
    if (point) {
        spot = TouchSpot{*point, normal->stableNormalized()};
    }
}

void read_lesson(const Extras &extras, Lesson &lesson) {
    constexpr std::size_t kMaxTitle = 40;
    constexpr std::size_t kMaxSentence = 200;
    lesson.title = extras.text("title", kMaxTitle).value_or(lesson.title);
    lesson.feel = extras.text("feel", kMaxSentence).value_or(lesson.feel);
    read_spot(extras, lesson.spot);
    extras.refuse_all_but(kLessonKeys);
}

void read_scene(const std::string &text, const std::string &owner, SceneExtras &scene,
                WarningList &warnings) {
    constexpr std::array<std::string_view, 1> kUnits = {"m"};
    const Extras extras(text, owner, warnings);
    scene.in_metres |= extras.word("units", kUnits, "'m' (metres)").has_value();
    scene.planar = extras.flag("planar").value_or(scene.planar);
    if (const auto tolerance = extras.object(
            "tolerance", kToleranceKeys, "an object of force_N, direction_deg and bandwidth_hz")) {
        read_tolerance(*tolerance, scene.tolerance);
    }
    if (const auto lesson =
            extras.object("lesson", kLessonKeys, "an object of title, feel, point and normal")) {
        read_lesson(*lesson, scene.lesson);
    }
}

} // namespace

SceneExtras read_scene_extras(const tinygltf::Model &model, WarningList &warnings) {
    SceneExtras extras;
    read_scene(model.asset.extras_json_string, "asset", extras, warnings);
    const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
    if (scene < model.scenes.size()) {
        read_scene(model.scenes[scene].extras_json_string, "scene", extras, warnings);
    }
    return extras;
}

} // namespace springdrive::scene::gltf
