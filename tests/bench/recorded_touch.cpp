#include "tests/bench/recorded_touch.h"

#include "engine/scenario/scripted_touch.h"
#include "engine/scenario/test_surfaces.h"
#include "engine/scenario/touch_scene.h"
#include "tests/bench/touch_path.h"
#include "tests/support/devices.h"

#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace springdrive::bench {

namespace {

constexpr double kHeightWhenFree_m = 0.02;

/// Of a touch: what is touched, and how the hand goes.
struct Place {
    HapticSurface surface;
    HandPath path;
};

Place in_scene(const DeviceDescription &device, const std::string &name, double depth_m) {
    const Scene scene =
        touch_scene((testing::assets() / "scenes" / (name + ".gltf")).string(), device.workspace);
    HapticSurface surface = haptic_surface_of(scene);
    ScriptedTouch how;
    how.depth_m = depth_m;
    HandPath path = scripted_touch(device, surface, scene.lower_m, scene.upper_m,
                                   start_above(device, scene.lower_m, scene.upper_m), how);
    return {std::move(surface), std::move(path)};
}

/// From above onto the top, then along a figure that comes by everywhere in reach.
Place on_sphere(const DeviceDescription &device, HapticSurface surface) {
    const Vector3 corner_m = Vector3::Constant(kTestSphereRadius_m);
    const Vector3 start_m = start_above(device, -corner_m, corner_m);
    const ScriptedTouch how;
    std::vector<HandPath::Point> points{{0.0, start_m}, {how.wait_s, start_m}};
    double time_s = how.wait_s + how.approach_s;
    for (const Vector3 &tip_m :
         pressed_tips_m(Relief::smooth, lissajous_directions(RecordedTouch::kTicks))) {
        points.push_back({time_s, tip_m});
        time_s += kServoPeriod_s;
    }
    return {std::move(surface), HandPath(std::move(points))};
}

Place place_named(const DeviceDescription &device, const std::string &name) {
    if (name == "free") {
        return in_scene(device, "plate", -kHeightWhenFree_m);
    }
    if (std::optional<TriangleSoup> soup = test_surface_named(name)) {
        return on_sphere(device, HapticSurface(std::move(*soup)));
    }
    if (name == "sphere shape") {
        TriangleSoup material_only;
        material_only.materials = {{"sphere", 0.0}};
        return on_sphere(device, HapticSurface(std::move(material_only),
                                               {AnalyticShape(Sphere{kTestSphereRadius_m},
                                                              Eigen::Isometry3d::Identity(), 0)}));
    }
    return in_scene(device, name, ScriptedTouch{}.depth_m);
}

void check(const RecordedTouch &touch, const std::string &name) {
    std::size_t touching = 0;
    for (std::size_t i = RecordedTouch::kBefore; i < RecordedTouch::kTicks; ++i) {
        const ServoSample &sample = touch.samples[i];
        touching += sample.contact.touching ? 1 : 0;
        if (sample.safety.state != SafetyState::running) {
            throw std::runtime_error(name +
                                     ": the servo does not run: " + description(sample.safety));
        }
    }
    const std::size_t measured = RecordedTouch::kTicks - RecordedTouch::kBefore;
    if (name == "free" ? touching > 0 : 10 * touching < 9 * measured) {
        throw std::runtime_error(name + ": " + std::to_string(touching) + " of " +
                                 std::to_string(measured) + " ticks in contact");
    }
}

std::unique_ptr<RecordedTouch> play(const std::string &name) {
    const DeviceDescription device = testing::phantom_1_0();
    Place place = place_named(device, name);
    auto touch = std::make_unique<RecordedTouch>(
        RecordedTouch{device, std::move(place.surface), std::move(place.path), {}, {}});
    ServoRig rig = touch->rig();
    for (std::size_t i = 0; i < RecordedTouch::kTicks; ++i) {
        touch->states.push_back(rig.loop.read());
        touch->samples.push_back(rig.loop.update(touch->states.back(), rig.sealed_inputs));
        rig.loop.write();
    }
    check(*touch, name);
    return touch;
}

SimulationOptions following(const HandPath &path) {
    SimulationOptions options;
    options.path = path;
    return options;
}

} // namespace

ServoRig::ServoRig(const DeviceDescription &description, const HandPath &path,
                   const HapticSurface &surface)
    : device(description, following(path), path.points().front().position_m),
      loop(device, kServoPeriod_s) {
    ServoInputs inputs;
    inputs.surface = &surface;
    sealed_inputs = sealed(inputs);
}

const RecordedTouch &recorded_touch(const std::string &name) {
    static std::map<std::string, std::unique_ptr<RecordedTouch>> played;
    std::unique_ptr<RecordedTouch> &touch = played[name];
    if (!touch) {
        touch = play(name);
    }
    return *touch;
}

} // namespace springdrive::bench
