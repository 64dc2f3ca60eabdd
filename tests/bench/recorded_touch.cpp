#include "tests/bench/recorded_touch.h"

#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scene_surface.h"
#include "tests/bench/touch_path.h"
#include "tests/support/devices.h"

#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace springdrive::bench {

namespace {

constexpr double kHeightWhenFree_m = 0.02;

rig::Scenario in_scene(const rig::ScenarioSetting &setting, const std::string &name,
                       double depth_m) {
    const scene::Scene scene = rig::touch_scene(
        (testing::assets() / "scenes" / (name + ".gltf")).string(), setting.device.workspace);
    scene::ScriptedTouch how;
    how.depth_m = depth_m;
    return rig::scripted_touch_scenario(
        setting,
        {std::make_shared<contact::HapticSurface>(scene::haptic_surface_of(scene)), scene.lower_m,
         scene.upper_m},
        how);
}

/// From above onto the top, then along a figure that comes by everywhere in reach.
rig::Scenario on_sphere(const rig::ScenarioSetting &setting, contact::HapticSurface surface) {
    const Vector3 corner_m = Vector3::Constant(rig::kTestSphereRadius_m);
    const scene::ScriptedTouch how;
    rig::Scenario scenario = rig::scripted_touch_scenario(
        setting,
        {std::make_shared<contact::HapticSurface>(std::move(surface)), -corner_m, corner_m}, how);
    std::vector<simulated::HandPath::Point> points{{0.0, scenario.start_m},
                                                   {how.wait_s, scenario.start_m}};
    double time_s = how.wait_s + how.approach_s;
    for (const Vector3 &tip_m :
         pressed_tips_m(Relief::smooth, lissajous_directions(RecordedTouch::kTicks))) {
        points.push_back({time_s, tip_m});
        time_s += kServoPeriod_s;
    }
    scenario.simulation.path = simulated::HandPath(std::move(points));
    return scenario;
}

rig::Scenario scenario_named(const rig::ScenarioSetting &setting, const std::string &name) {
    if (name == "free") {
        return in_scene(setting, "plate", -kHeightWhenFree_m);
    }
    if (std::optional<contact::TriangleSoup> soup = rig::test_surface_named(name)) {
        return on_sphere(setting, contact::HapticSurface(std::move(*soup)));
    }
    if (name == "sphere shape") {
        contact::TriangleSoup material_only;
        material_only.materials = {{"sphere", 0.0}};
        return on_sphere(setting,
                         contact::HapticSurface(
                             std::move(material_only),
                             {contact::AnalyticShape(contact::Sphere{rig::kTestSphereRadius_m},
                                                     Eigen::Isometry3d::Identity(), 0)}));
    }
    return in_scene(setting, name, scene::ScriptedTouch{}.depth_m);
}

void check(const RecordedTouch &touch, const std::string &name) {
    std::size_t touching = 0;
    for (std::size_t i = RecordedTouch::kBefore; i < RecordedTouch::kTicks; ++i) {
        const servo::ServoSample &sample = touch.samples[i];
        touching += sample.contact.touching ? 1 : 0;
        if (sample.safety.state != servo::SafetyState::running) {
            throw std::runtime_error(
                name + ": the servo does not run: " + servo::description(sample.safety));
        }
    }
    const std::size_t measured = RecordedTouch::kTicks - RecordedTouch::kBefore;
    if (name == "free" ? touching > 0 : 10 * touching < 9 * measured) {
        throw std::runtime_error(name + ": " + std::to_string(touching) + " of " +
                                 std::to_string(measured) + " ticks in contact");
    }
}

std::unique_ptr<RecordedTouch> play(const std::string &name) {
    auto touch = std::make_unique<RecordedTouch>(
        RecordedTouch{scenario_named({testing::phantom_1_0(), {}}, name), {}, {}});
    const std::unique_ptr<rig::ServoRig> rig = touch->rig();
    for (std::size_t i = 0; i < RecordedTouch::kTicks; ++i) {
        touch->samples.push_back(rig->tick());
        touch->states.push_back(rig->measured());
    }
    check(*touch, name);
    return touch;
}

} // namespace

std::unique_ptr<rig::ServoRig> RecordedTouch::rig() const {
    return std::make_unique<rig::ServoRig>(scenario);
}

std::unique_ptr<rig::ServoRig> RecordedTouch::rig_in_touch() const {
    std::unique_ptr<rig::ServoRig> begun = rig();
    for (std::size_t i = 0; i < kBefore; ++i) {
        begun->tick();
    }
    return begun;
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
