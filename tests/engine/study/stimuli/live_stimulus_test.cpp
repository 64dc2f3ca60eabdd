// Covers engine/study/stimuli/live_stimulus.cpp and the servo's courses: what the servo presents by
// itself is what a rig presents that is told before each tick.
#include "device/simulated/simulated_phantom.h"
#include "engine/servo/servo.h"
#include "engine/study/protocol/presented.h"
#include "engine/study/protocol/protocol_file.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/stimuli/live_stimulus.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

namespace springdrive::study {
namespace {

/// A stimulus of an included protocol, and a hand that is presented it.
struct Presentable {
    explicit Presentable(const std::string &name)
        : protocol(read_protocol_file(testing::assets() / "protocols" / (name + ".toml"))),
          setting(study_setting(protocol, {testing::assets() / "protocols", testing::assets()})),
          presented(all_presented(protocol).back()) {
        protocol.timing.presentation_s = 0.6;
        stimulus = stimulus_of(protocol, setting, presented);
        course = hand_course(setting, presented, stimulus, {});
        options.servo_period_s = 1.0 / presented.parameters.servo_hz;
        options.delay_periods = presented.parameters.delay_periods;
        options.ambient_C = protocol.windings.from_C;
        options.path.emplace(course.points);
        inputs.tuning = presented.free_space;
        inputs.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
        inputs.observes_resistance = true;
        inputs.surface = setting.conditions[presented.condition].surface.get();
    }

    Protocol protocol;
    StudySetting setting;
    Presented presented;
    Stimulus stimulus;
    HandCourse course;
    simulated::SimulationOptions options;
    servo::ServoInputs inputs;
};

void expect_same(const StimulusMeasures &one, const StimulusMeasures &other) {
    for (const StimulusMeasure &measure : kStimulusMeasures) {
        EXPECT_EQ(one.*measure.value, other.*measure.value) << measure.name;
    }
}

class LiveStimulusOf : public ::testing::TestWithParam<const char *> {};

TEST_P(LiveStimulusOf, IsWhatARigPresents) {
    Presentable it(GetParam());
    const StimulusTrial rig = try_stimulus(it.protocol, it.setting, it.presented);
    ASSERT_EQ(rig.failure, StimulusFailure::none);
    simulated::SimulatedPhantom phantom(it.setting.device, it.options,
                                        it.course.points.front().position_m);
    servo::Servo servo(phantom, it.presented.parameters.servo_hz);
    LiveStimulus live(it.setting.device, rig.stimulus, it.options.servo_period_s);
    it.inputs.course = &live;
    servo.publish(it.inputs);
    EXPECT_FALSE(live.has_begun());
    const auto ticks = std::lround(it.course.points.back().time_s / it.options.servo_period_s);
    servo.advance(static_cast<int>(ticks));
    ASSERT_TRUE(live.is_over());
    EXPECT_EQ(live.failure(), StimulusFailure::none);
    const DeliveredStimulus delivered = live.delivered();
    expect_same(delivered.measures, rig.delivered.measures);
    EXPECT_EQ(delivered.start_s, rig.delivered.start_s);
    EXPECT_EQ(delivered.end_s, rig.delivered.end_s);
    EXPECT_EQ(delivered.peak_force_N, rig.delivered.peak_force_N);
    EXPECT_NEAR(live.ended_s() - live.began_s(), rig.stimulus.presentation_s,
                2.0 * it.options.servo_period_s);
}

INSTANTIATE_TEST_SUITE_P(EachIncludedProtocol, LiveStimulusOf,
                         ::testing::Values("direction", "stiffness", "blow", "mass"),
                         [](const auto &instance) { return std::string(instance.param); });

TEST(LiveStimulus, IsPresentedOnTheServosOwnThread) {
    Presentable it("stiffness");
    simulated::SimulatedPhantom phantom(it.setting.device, it.options,
                                        it.course.points.front().position_m);
    servo::Servo servo(phantom, it.presented.parameters.servo_hz);
    LiveStimulus live(it.setting.device, it.stimulus, it.options.servo_period_s);
    it.inputs.course = &live;
    servo.publish(it.inputs);
    servo.start();
    const double before_s = servo.clock_s();
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!live.is_over() && std::chrono::steady_clock::now() < patience) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        servo.drain([](const servo::ServoSample &) {});
    }
    ASSERT_TRUE(live.is_over());
    EXPECT_EQ(live.failure(), StimulusFailure::none);
    // By the clock: it cannot have been shorter than its ticks, which begin on time or late, nor
    // have ended after now.
    EXPECT_GE(live.began_s(), before_s);
    EXPECT_GT(live.ended_s(), live.began_s());
    EXPECT_LE(live.ended_s(), servo.clock_s());
    EXPECT_NEAR(live.delivered().measures.stiffness_N_per_m.value(),
                intended_measures(it.protocol, it.setting, it.presented).stiffness_N_per_m.value(),
                0.02 * 3000.0);
    servo.stop();
}

/// Asks for what only the publisher may decide.
class Greedy final : public servo::InputCourse {
public:
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override {
        last_tick = last.tick;
        ++updates;
        next.excitation_V = Vector3::Constant(1e6);
    }
    std::uint64_t last_tick = 0;
    int updates = 0;
};

TEST(InputCourse, IsAskedOncePerTickAndPassesTheMonitor) {
    Presentable it("stiffness");
    simulated::SimulatedPhantom phantom(it.setting.device, it.options,
                                        it.course.points.front().position_m);
    servo::Servo servo(phantom, 1000.0);
    Greedy greedy;
    it.inputs.course = &greedy;
    servo.publish(it.inputs);
    servo.advance(3000);
    EXPECT_EQ(greedy.updates, 2999);    // not before the first tick
    EXPECT_EQ(greedy.last_tick, 2998U); // tick 0 is the first
    servo::ServoSample last;
    double largest_V = 0.0;
    servo.drain([&](const servo::ServoSample &sample) {
        last = sample;
        largest_V = std::max(largest_V, sample.command.e_W_V.cwiseAbs().maxCoeff());
    });
    EXPECT_GT(largest_V, 0.0);
    EXPECT_LE(largest_V, servo::limits_of(it.setting.device).voltage_V);
    EXPECT_EQ(last.safety.state, servo::SafetyState::tripped); // too fast, or too hot
}

} // namespace
} // namespace springdrive::study
