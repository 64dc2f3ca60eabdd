// Covers what engine/study/stimuli does on the servo's thread, and the servo's schedules: what the
// servo presents by itself is what a rig presents that is told before each tick; windings are
// warmed, and the tip stays where it is.
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/servo/servo.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/warm_up.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
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
        trajectory = hand_trajectory(setting, presented, stimulus, {});
        options.servo_period_s = 1.0 / presented.parameters.servo_hz;
        options.delay_periods = presented.parameters.delay_periods;
        options.ambient_C = protocol.windings.from_C;
        options.path.emplace(trajectory.points);
        inputs.tuning = presented.free_space;
        inputs.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
        inputs.observes_resistance = true;
        inputs.surface = setting.conditions[presented.condition].surface.get();
    }

    Protocol protocol;
    StudySetting setting;
    Presented presented;
    Stimulus stimulus;
    HandTrajectory trajectory;
    simulated::SimulationOptions options;
    servo::ServoInputs inputs;
};

/// The heat of a warm-up's current of ±`current_A` in a winding of `resistance_Ohm` [W]: P of
/// warm_up.h.
double warming_heat_W(const device::MotorParameters &motor, double resistance_Ohm, double current_A,
                      double period_s) {
    const double tau_s = motor.inductance_H / resistance_Ohm;
    return resistance_Ohm * current_A * current_A *
           (1.0 - 2.0 * tau_s / period_s * std::tanh(0.5 * period_s / tau_s));
}

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
                                        it.trajectory.points.front().position_m);
    servo::Servo servo(phantom, it.presented.parameters.servo_hz);
    LiveStimulus live(it.setting.device, rig.stimulus, it.options.servo_period_s);
    it.inputs.schedule = &live;
    servo.publish(it.inputs);
    EXPECT_FALSE(live.has_begun());
    const auto ticks = std::lround(it.trajectory.points.back().time_s / it.options.servo_period_s);
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
                                        it.trajectory.points.front().position_m);
    servo::Servo servo(phantom, it.presented.parameters.servo_hz);
    LiveStimulus live(it.setting.device, it.stimulus, it.options.servo_period_s);
    it.inputs.schedule = &live;
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
class Greedy final : public servo::InputSchedule {
public:
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override {
        last_tick = last.tick;
        ++updates;
        next.excitation_V = Vector3::Constant(1e6);
    }
    std::uint64_t last_tick = 0;
    int updates = 0;
};

TEST(InputSchedule, IsAskedOncePerTickAndPassesTheMonitor) {
    Presentable it("stiffness");
    simulated::SimulatedPhantom phantom(it.setting.device, it.options,
                                        it.trajectory.points.front().position_m);
    servo::Servo servo(phantom, 1000.0);
    Greedy greedy;
    it.inputs.schedule = &greedy;
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

constexpr double kWarmUpPeriod_s = 1e-3;

/// So light that it leaves the tip alone, but keeps it from falling in minutes.
constexpr device::HandParameters kNearlyOff{0.0, 0.5, 20.0};

struct Warming {
    explicit Warming(const device::HandParameters &hand) : rig(device, options_with(hand), kAt_m) {
        rig.inputs.observes_resistance = true;
        rig.run(1.5);
    }

    static simulated::SimulationOptions options_with(const device::HandParameters &hand) {
        simulated::SimulationOptions options;
        options.servo_period_s = kWarmUpPeriod_s;
        options.hand = hand;
        return options;
    }

    static constexpr double kMax_s = 400.0;
    inline static const Vector3 kAt_m{0.0, 0.03, 0.0};

    device::DeviceDescription device = testing::phantom_1_0();
    rig::ServoRig rig;
};

/// Winding and housing with a constant heat P from the air's temperature, by the two modes of the
/// network: x(t) = x∞ − Σ c_k v_k e^(−λ_k t).
double winding_rise_K(const device::ThermalParameters &thermal, double heat_W, double time_s) {
    const double a = 1.0 / thermal.winding_time_s;
    const double C_h = thermal.motor_time_s / thermal.housing_ambient_K_per_W;
    const double b = 1.0 / (thermal.winding_housing_K_per_W * C_h);
    const double c = b + 1.0 / thermal.motor_time_s;
    // d/dt (w, h) = (−a, a; b, −c)(w, h): rates λ with λ² − (a + c) λ + a (c − b) = 0
    const double root = std::sqrt(0.25 * (a - c) * (a - c) + a * b);
    const double fast = 0.5 * (a + c) + root;
    const double slow = 0.5 * (a + c) - root;
    const double w_end =
        heat_W * (thermal.winding_housing_K_per_W + thermal.housing_ambient_K_per_W);
    const double h_end = heat_W * thermal.housing_ambient_K_per_W;
    // mode (1, (a − λ)/a)
    const double h_fast = (a - fast) / a;
    const double h_slow = (a - slow) / a;
    const double of_fast = (h_end - h_slow * w_end) / (h_fast - h_slow);
    const double of_slow = w_end - of_fast;
    return w_end - of_fast * std::exp(-fast * time_s) - of_slow * std::exp(-slow * time_s);
}

class WarmUpOfHands : public ::testing::TestWithParam<bool> {};

TEST_P(WarmUpOfHands, ComesIntoTheBandAndLeavesTheTipInItsPlace) {
    Warming warming(GetParam() ? device::HandParameters{} : kNearlyOff);
    rig::ServoRig &rig = warming.rig;
    const WindingBand band;
    WarmUp warm_up(warming.device, band, kWarmUpPeriod_s);
    const double dR_before_Ohm = rig.inputs.tuning.dR_Ohm;
    const double begun_s = rig.last.time_s;
    double force_N = 0.0;
    double generated_J = 0.0;
    double heated_s = 0.0;
    double rise_K = 0.0;
    double predicted_K = 0.0;
    Vector3 min_m = Vector3::Constant(1.0);
    Vector3 max_m = -min_m;
    while (!warm_up.is_over() && rig.last.time_s - begun_s < Warming::kMax_s) {
        const servo::ServoSample &sample = rig.tick();
        warm_up.update(sample, rig.inputs);
        generated_J = std::max(generated_J, sample.generated_energy_J);
        force_N = std::max(force_N, sample.tip_force_N.norm());
        EXPECT_FALSE(sample.active_limits.holds_force() || sample.active_limits.voltage);
        const bool is_full =
            warm_up.phase() == WarmUpPhase::heating && warm_up.amplitude_A().minCoeff() > 0.0;
        heated_s += is_full ? kWarmUpPeriod_s : 0.0;
        if (is_full && std::abs(heated_s - 30.0) < 0.5 * kWarmUpPeriod_s) {
            // With R of the middle between cold and hot, which is within 2 % of either.
            const device::MotorParameters &motor = warming.device.motor[0];
            rise_K = rig.truth().winding_C[0] - band.air_C;
            const double R_Ohm = device::winding_resistance_Ohm(motor, band.air_C + 0.7 * rise_K,
                                                                rig.truth().theta_rad[0]);
            const double current_A =
                warming_current_A(warming.device, sample.limits, sample.theta_rad)[0];
            predicted_K = winding_rise_K(
                motor.thermal, warming_heat_W(motor, R_Ohm, current_A, kWarmUpPeriod_s), 30.0);
        }
        if (heated_s > 30.0 && heated_s < 31.0) { // a hand comes to rest in a second
            min_m = min_m.cwiseMin(rig.truth().tip_m);
            max_m = max_m.cwiseMax(rig.truth().tip_m);
        }
    }
    ASSERT_FALSE(rig.has_tripped()) << servo::description(rig.last.safety);
    EXPECT_EQ(warm_up.phase(), WarmUpPhase::done);
    EXPECT_TRUE(warm_up.failure() == WarmUpFailure::none);
    EXPECT_FALSE(WarmUp::is_needed(band, estimated_windings_C(rig.last)));
    for (Eigen::Index j = 0; j < 3; ++j) {
        EXPECT_GE(rig.truth().winding_C[j], band.from_C);
        EXPECT_LE(rig.truth().winding_C[j], band.to_C);
        EXPECT_GE(rig.truth().winding_C[j], rig.last.winding[static_cast<std::size_t>(j)].min_C);
        EXPECT_LE(rig.truth().winding_C[j], rig.last.winding[static_cast<std::size_t>(j)].max_C);
    }
    // The voltage is for the R that is observed: without the commutator's 2 %, which are of the
    // angle, and up to 1 % colder, so its heat is within 6 %; R of the middle within 2 %.
    EXPECT_GT(rise_K, 5.0);
    EXPECT_NEAR(rise_K, predicted_K, 0.08 * predicted_K);
    EXPECT_LT(force_N, 0.8 * warming.device.limits.tip_force_N);
    EXPECT_LT(generated_J, 0.5 * warming.device.limits.generated_energy_J);
    EXPECT_TRUE(rig.inputs.excitation_V.isZero(0.0));
    EXPECT_EQ(rig.inputs.tuning.dR_Ohm, dR_before_Ohm);

    // F T²/8m to either side of the lightest direction there is.
    const Vector3 q_rad = device::joint_angles_rad(warming.device.geometry, Warming::kAt_m).value();
    double lightest_kg = 1.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        lightest_kg = std::min(lightest_kg, tip_mass_kg(warming.device, q_rad, Vector3::Unit(j)));
    }
    const double either_m = force_N * kWarmUpPeriod_s * kWarmUpPeriod_s / (8.0 * lightest_kg);
    EXPECT_LT((max_m - min_m).maxCoeff(), 2.0 * either_m);
    std::printf("warm after %.0f s, at most %.1f N, the tip goes %.1f um (at most %.1f), the "
                "observer saw %.1f mJ; true %.1f %.1f %.1f degC\n",
                rig.last.time_s - begun_s, force_N, 1e6 * (max_m - min_m).maxCoeff(),
                2e6 * either_m, 1e3 * generated_J, rig.truth().winding_C[0],
                rig.truth().winding_C[1], rig.truth().winding_C[2]);
}

INSTANTIATE_TEST_SUITE_P(, WarmUpOfHands, ::testing::Bool(), [](const auto &holds) {
    return std::string(holds.param ? "RelaxedGrip" : "NearlyOff");
});

/// The servo gives a schedule its inputs as they were published, a rig as the last tick left them.
TEST(LiveWarmUp, IsThatOfARigTickByTick) {
    const WindingBand band{25.0, 25.8, 60.0};
    Warming warming(kNearlyOff);
    WarmUp warm_up(warming.device, band, kWarmUpPeriod_s);
    simulated::SimulatedPhantom phantom(warming.device, Warming::options_with(kNearlyOff),
                                        Warming::kAt_m);
    servo::Servo servo(phantom, 1.0 / kWarmUpPeriod_s);
    servo::ServoInputs inputs = warming.rig.inputs;
    servo.publish(inputs);
    servo.advance(static_cast<int>(warming.rig.last.tick) + 1);
    LiveWarmUp live(warming.device, band, kWarmUpPeriod_s);
    inputs.schedule = &live;
    servo.publish(inputs);

    servo::ServoSample last;
    int heated_ticks = 0;
    for (int tick = 0; !warm_up.is_over() && tick < 60'000; ++tick) {
        warm_up.update(warming.rig.last, warming.rig.inputs);
        const servo::ServoSample &requested = warming.rig.tick();
        servo.advance(1);
        servo.drain([&](const servo::ServoSample &sample) { last = sample; });
        ASSERT_EQ(last.tick, requested.tick);
        ASSERT_EQ(last.command.e_W_V, requested.command.e_W_V) << "after " << tick << " ticks";
        ASSERT_EQ(live.phase(), warm_up.phase());
        heated_ticks += last.command.e_W_V.isZero(0.1) ? 0 : 1;
    }
    EXPECT_EQ(live.phase(), WarmUpPhase::done);
    EXPECT_GT(heated_ticks, 1000);
    EXPECT_FALSE(WarmUp::is_needed(band, estimated_windings_C(last)));
}

/// Of a servo that runs in free space, with windings of these temperatures.
servo::ServoSample sample_of(const device::DeviceDescription &device, const Vector3 &winding_C,
                             double dR_Ohm) {
    servo::ServoSample sample;
    sample.safety.state = servo::SafetyState::running;
    sample.limits = servo::limits_of(device);
    sample.theta_rad = device::motor_from_joint(device.geometry, device::default_pose_rad());
    sample.motor = control::motors_of_file(device.motor);
    sample.tuning.dR_Ohm = dR_Ohm;
    for (Eigen::Index j = 0; j < 3; ++j) {
        sample.winding[static_cast<std::size_t>(j)].min_C = winding_C[j] - 10.0;
        sample.winding[static_cast<std::size_t>(j)].max_C = winding_C[j] + 10.0;
    }
    return sample;
}

struct MadeUp {
    explicit MadeUp(double C1, double C2, double C3) : winding_C(C1, C2, C3) {}

    void run(double seconds) {
        for (long i = std::lround(seconds / kWarmUpPeriod_s); i > 0; --i) {
            sample = sample_of(device, winding_C, inputs.tuning.dR_Ohm);
            sample.contact.touching = is_touching;
            sample.safety.state =
                has_tripped ? servo::SafetyState::tripped : servo::SafetyState::running;
            warm_up.update(sample, inputs);
        }
    }

    device::DeviceDescription device = testing::phantom_1_0();
    Vector3 winding_C;
    bool is_touching = false;
    bool has_tripped = false;
    servo::ServoSample sample;
    servo::ServoInputs inputs;
    WindingBand band;
    WarmUp warm_up{device, band, kWarmUpPeriod_s};
};

TEST(WarmUp, HeatsOnlyWhatIsTooCold) {
    MadeUp made_up(25.0, 40.0, 29.0);
    made_up.run(2.0);
    EXPECT_GT(std::abs(made_up.inputs.excitation_V[0]), 1.0);
    EXPECT_EQ(made_up.inputs.excitation_V[1], 0.0);
    EXPECT_GT(std::abs(made_up.inputs.excitation_V[2]), 1.0);
    const Vector3 before_V = made_up.inputs.excitation_V;
    made_up.run(kWarmUpPeriod_s);
    EXPECT_EQ(made_up.inputs.excitation_V, -before_V);
}

TEST(WarmUp, HasNothingToDoInTheBand) {
    MadeUp made_up(40.0, 40.0, 40.0);
    made_up.run(1.0);
    EXPECT_EQ(made_up.warm_up.phase(), WarmUpPhase::done);
    EXPECT_FALSE(WarmUp::is_needed({}, {30.0, 40.0, 50.0}));
    EXPECT_TRUE(WarmUp::is_needed({}, {40.0, 29.9, 40.0}));
    EXPECT_TRUE(WarmUp::is_needed({}, {40.0, 60.1, 40.0}));
}

TEST(WarmUp, RisesEvenlyAndFadesWhereTheTipTouches) {
    MadeUp made_up(25.0, 25.0, 25.0);
    made_up.run(0.25 * WarmUp::kRamp_s);
    const double quarter_A = made_up.warm_up.amplitude_A()[0];
    made_up.run(0.25 * WarmUp::kRamp_s);
    EXPECT_NEAR(made_up.warm_up.amplitude_A()[0], 2.0 * quarter_A, 0.02 * quarter_A);
    made_up.is_touching = true;
    made_up.run(WarmUp::kRamp_s);
    EXPECT_TRUE(made_up.inputs.excitation_V.isZero(0.0));
    EXPECT_EQ(made_up.warm_up.phase(), WarmUpPhase::heating) << "it goes on in free space";
}

TEST(WarmUp, FailsWithATripAtOnceAndAfterItsLongestTime) {
    MadeUp tripped(25.0, 25.0, 25.0);
    tripped.run(1.0);
    tripped.has_tripped = true;
    tripped.run(kWarmUpPeriod_s);
    EXPECT_EQ(tripped.warm_up.failure(), WarmUpFailure::tripped);
    EXPECT_TRUE(tripped.inputs.excitation_V.isZero(0.0));

    MadeUp never(25.0, 25.0, 25.0); // as if nothing heated
    never.run(WarmUp::kMax_s - 1.0);
    EXPECT_EQ(never.warm_up.phase(), WarmUpPhase::heating);
    never.run(2.0);
    EXPECT_EQ(never.warm_up.failure(), WarmUpFailure::too_long);
    EXPECT_FALSE(description(never.warm_up.failure()).empty());
}

/// Mean of the squared current of a square wave behind R and L, by a thousand Euler steps a tick.
TEST(WarmUp, ItsHeatIsThatOfTheWindingsEquation) {
    const device::MotorParameters motor = testing::phantom_1_0().motor[0];
    for (const double period_s : {1e-3, 2.5e-4}) {
        constexpr int kSteps = 4000;
        const double h = period_s / kSteps;
        double i_A = 0.0;
        double heat_W = 0.0;
        for (int tick = 0; tick < 200; ++tick) {
            heat_W = 0.0;
            const double e_V = (tick % 2 == 0 ? 1.5 : -1.5) * motor.resistance_Ohm;
            for (int step = 0; step < kSteps; ++step) {
                i_A += h / motor.inductance_H * (e_V - motor.resistance_Ohm * i_A);
                heat_W += motor.resistance_Ohm * i_A * i_A / kSteps;
            }
        }
        EXPECT_NEAR(warming_heat_W(motor, motor.resistance_Ohm, 1.5, period_s), heat_W,
                    0.005 * heat_W); // Euler's h R/L, 0.23 % of a step at most
    }
}

} // namespace
} // namespace springdrive::study
