// Covers engine/servo/servo_loop.cpp and all that it calls, and engine/study/stimuli: a tick
// allocates nothing, locks nothing and makes no system call. For the thread that ticks, see
// servo_real_time_test.cpp.
#include "device/simulated/plant_model.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/servo/servo.h"
#include "engine/session/scene_loader.h"
#include "engine/study/protocol/protocol_file.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus_run.h"
#include "engine/study/stimuli/warm_up.h"
#include "tests/support/devices.h"
#include "tests/support/real_time_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <memory>
#include <string>

#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace springdrive::servo {
namespace {

std::unique_ptr<session::LoadedScene> scene_named(const std::string &name,
                                                  const device::DeviceDescription &description) {
    scene::LoadProgress progress;
    return session::load_scene(testing::assets() / "scenes" / (name + ".gltf"),
                               description.workspace, progress);
}

/// A scene of the project, touched by the scripted hand.
class TouchedScene {
public:
    TouchedScene(const std::string &scene_name, control::MotionMap map,
                 control::AlphaMode alpha_mode)
        : scene_(scene_named(scene_name, description_)), closed_loop(scenario()) {
        closed_loop.inputs.tuning.map = map;
        closed_loop.inputs.tuning.alpha_mode = alpha_mode;
        closed_loop.inputs.global_alpha_rad2_per_m2 = 3000.0;
    }

    /// Ticks in contact among `ticks`; trips and resets on the way.
    int run(int ticks) {
        int touching = 0;
        for (int i = 0; i < ticks; ++i) {
            closed_loop.inputs.requested_stop = i >= ticks - 200 ? 1U : 0U;
            closed_loop.inputs.released_stop = i > ticks - 100 ? 1U : 0U;
            closed_loop.inputs.reset_count = closed_loop.inputs.released_stop;
            touching += closed_loop.tick().contact.touching ? 1 : 0;
        }
        return touching;
    }

    [[nodiscard]] rig::Scenario scenario() const {
        return rig::scripted_touch_scenario(
            {description_, {}},
            rig::placed(scene_->surface, scene_->scene.lower_m, scene_->scene.upper_m));
    }

private:
    device::DeviceDescription description_ = testing::phantom_1_0();
    std::unique_ptr<session::LoadedScene> scene_;

public:
    rig::ServoRig closed_loop;
};

constexpr int kTicks = 3000; // of which 1200 before the hand starts to move

template <typename Check> void for_every_scene(Check &&check) {
    for (const char *scene : {"plate", "sphere", "stepped_block", "organic", "compliance"}) {
        for (const control::MotionMap map :
             {control::MotionMap::inverse, control::MotionMap::transpose}) {
            for (const control::AlphaMode mode :
                 {control::AlphaMode::on_the_fly, control::AlphaMode::global,
                  control::AlphaMode::by_hand}) {
                TouchedScene touched(scene, map, mode);
                check(touched, scene);
            }
        }
    }
}

/// Expects that `work` neither allocates nor locks.
template <typename Work> void expect_quiet(Work &&work) {
    testing::watched().allocations = 0;
    testing::watched().locks = 0;
    {
        const testing::CountingWatch watch;
        work();
    }
    EXPECT_EQ(testing::watched().allocations, 0);
    EXPECT_EQ(testing::watched().locks, 0);
}

TEST(RealTime, ATickAllocatesAndLocksNothing) {
    for_every_scene([](TouchedScene &touched, const char *scene) {
        SCOPED_TRACE(scene);
        int touching = 0;
        expect_quiet([&] { touching = touched.run(kTicks); });
        EXPECT_GT(touching, 500);
    });
}

/// A turned press in a friction cup, from rest in free space until the hand has left.
TEST(RealTime, APresentedStimulusAllocatesAndLocksNothing) {
    const std::filesystem::path protocols = testing::assets() / "protocols";
    const study::Protocol protocol = study::read_protocol_file(protocols / "direction.toml");
    const study::StudySetting setting =
        study::study_setting(protocol, {protocols, testing::assets()});
    study::Presented presented = study::all_presented(protocol).front();
    presented.parameters.turn_deg = 30.0;
    const study::Stimulus stimulus = study::stimulus_of(protocol, setting, presented);
    const study::HandCourse course = study::hand_course(setting, presented, stimulus, {});
    simulated::SimulationOptions options;
    options.path.emplace(course.points);
    simulated::SimulatedPhantom phantom(setting.device, options, course.points.front().position_m);
    servo::Servo servo(phantom, 1.0 / options.servo_period_s);
    study::LiveStimulus live(setting.device, stimulus, options.servo_period_s);
    servo::ServoInputs inputs;
    inputs.tuning = presented.free_space;
    inputs.surface = setting.conditions[presented.condition].surface.get();
    inputs.course = &live;
    servo.publish(inputs);
    const auto ticks = std::lround(course.points.back().time_s / options.servo_period_s);
    expect_quiet([&] { servo.advance(static_cast<int>(ticks)); });
    EXPECT_EQ(live.phase(), study::StimulusPhase::done) << description(live.failure());
    EXPECT_NEAR(live.delivered().measures.turn_deg.value(), 30.0, 1.0); // the protocol's band
}

TEST(RealTime, AWarmUpAllocatesAndLocksNothing) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const simulated::SimulationOptions options;
    rig::ServoRig rig(device, options, {0.0, 0.03, 0.0});
    rig.run(1.5);
    study::WarmUp warm_up(device, {25.0, 25.2, 60.0}, options.servo_period_s);
    expect_quiet([&] {
        for (long tick = 0; tick < 120'000 && !warm_up.is_over(); ++tick) {
            warm_up.update(rig.tick(), rig.inputs);
        }
    });
    EXPECT_EQ(warm_up.phase(), study::WarmUpPhase::done) << description(warm_up.failure());
}

TEST(RealTime, ATickThatSwitchesThePlantAllocatesAndLocksNothing) {
    TouchedScene touched("plate", control::MotionMap::transpose, control::AlphaMode::on_the_fly);
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        simulated::SimulationOptions options = touched.scenario().simulation;
        options.dynamics = model.dynamics;
        options.effects = model.effects;
        touched.closed_loop.phantom().simulate_as(options);
        expect_quiet([&] { touched.run(300); });
    }
}

TEST(RealTime, AProxyOnShapesAndWithFrictionAllocatesAndLocksNothing) {
    using Size = contact::AnalyticShape::Size;
    for (const Size &size :
         {Size(contact::Plate{0.03, 0.03}), Size(contact::Sphere{0.02}),
          Size(contact::Box{Vector3::Constant(0.02)}), Size(contact::Cylinder{0.02, 0.01}),
          Size(contact::Capsule{0.02, 0.01})}) {
        contact::TriangleSoup soup;
        soup.materials = {{"rough", 0.0, 0.4, 0.3}};
        const contact::HapticSurface surface(
            soup, {contact::AnalyticShape(size, Eigen::Isometry3d::Identity(), 0)});
        contact::Proxy proxy(0.5e-3);
        proxy.reset({0.0, 0.05, 0.0});
        int touching = 0;
        expect_quiet([&] {
            for (int i = 0; i < kTicks; ++i) {
                const double t = 0.01 * i;
                const Vector3 tip(0.015 * std::sin(t), 0.01 + 0.04 * std::cos(3.0 * t),
                                  0.015 * std::cos(0.7 * t));
                touching += proxy.update(surface, tip).touching ? 1 : 0;
            }
        });
        EXPECT_GT(touching, 100);
    }
}

/// Runs in a child that is killed by any system call but read, write and exit.
int exit_status_without_system_calls(TouchedScene &touched, bool call_one) {
    const pid_t child = fork();
    if (child == 0) {
        if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) {
            _exit(77);
        }
        touched.run(kTicks);
        if (call_one) {
            syscall(SYS_getpid);
        }
        syscall(SYS_exit, 0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(RealTime, ATickMakesNoSystemCall) {
    TouchedScene one_call("plate", control::MotionMap::transpose, control::AlphaMode::on_the_fly);
    const int killed = exit_status_without_system_calls(one_call, true);
    if (killed == 77) {
        GTEST_SKIP() << "this kernel has no seccomp";
    }
    ASSERT_EQ(killed, -SIGKILL); // the filter works
    for_every_scene([](TouchedScene &touched, const char *scene) {
        EXPECT_EQ(exit_status_without_system_calls(touched, false), 0) << scene;
    });
}

} // namespace
} // namespace springdrive::servo
