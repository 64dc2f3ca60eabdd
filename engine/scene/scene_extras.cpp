#include "engine/scene/scene_extras.h"

#include "base/degrees.h"
#include "engine/scene/gltf_extras.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
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

void read(const std::string &json, const std::string &owner, SceneExtras &said) {
    constexpr std::array<std::string_view, 1> kUnits = {"m"};
    const Extras extras(json, owner);
    said.in_metres |=
        extras.word("units", kUnits, "'m' (metres), or left out to fit the scene").has_value();
    said.planar = extras.flag("planar").value_or(said.planar);
    if (const auto tolerance =
            extras.object("tolerance", "an object of force_N, direction_deg and bandwidth_hz")) {
        read_tolerance(*tolerance, said.tolerance);
    }
}

} // namespace

SceneExtras read_scene_extras(const tinygltf::Model &model) {
    SceneExtras said;
    read(model.asset.extras_json_string, "asset", said);
    const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
    if (scene < model.scenes.size()) {
        read(model.scenes[scene].extras_json_string, "scene", said);
    }
    return said;
}

} // namespace springdrive::scene::gltf
