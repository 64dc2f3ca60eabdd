// Covers engine/servo/bumpless_transfer.cpp, and servo_loop.cpp where its inputs change while the
// hand presses, and where measurements are late, missing or faulty.
#include "engine/servo/servo_loop.h"

#include "device/core/haptic_device.h"
#include "engine/control/haptic_law.h"
#include "engine/control/tuning.h"
#include "engine/control/velocity_filter.h"
#include "engine/servo/bumpless_transfer.h"
#include "tests/engine/servo/servo_rig.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

using testing::following;
using testing::kPeriod_s;
using testing::kStart_m;
using testing::kStartUp_s;
using testing::plate;
using testing::Rig;

BumplessTransfer transfer_at(double period_s) { return {testing::phantom_1_0(), period_s}; }

/// e_W of the law with its offset.
Vector3 carried_on_V(BumplessTransfer &transfer, const Vector3 &law_V,
                     const std::optional<Vector3> &unchanged_V, bool scene_is_new = false,
                     bool is_felt = true) {
    transfer.carry(law_V, unchanged_V, scene_is_new, is_felt);
    return law_V + transfer.transfer_offset_V();
}

TEST(BumplessTransfer, NoChangeMovesTheVoltageByMoreThanItsBound) {
    // A law that varies by itself and is changed occasionally: the output follows the law to within
    // the bound. All values are within the supply.
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    for (const double period_s : {1.0 / 250, 1e-3, 1e-4}) {
        const double bound_V = kMaxChange_V_per_s * period_s;
        BumplessTransfer transfer = transfer_at(period_s);
        Vector3 set_V = testing::random_vector(random, 3.0);
        Vector3 own_V = Vector3::Zero(); // the law's own variation
        Vector3 out_V = carried_on_V(transfer, set_V, std::nullopt);
        EXPECT_EQ(out_V, set_V);
        int changes = 0;
        for (int tick = 0; tick < 20'000; ++tick) {
            const Vector3 moved_V = testing::random_vector(random, 0.5) - own_V;
            own_V += moved_V;
            std::optional<Vector3> unchanged_V;
            if (chance(random) < 0.05) {
                unchanged_V = set_V + own_V;
                set_V = testing::random_vector(random, 3.0);
                ++changes;
            }
            const Vector3 law_V = set_V + own_V;
            const Vector3 now_V = carried_on_V(transfer, law_V, unchanged_V);
            ASSERT_LE((now_V - out_V - moved_V).cwiseAbs().maxCoeff(), bound_V + 1e-12);
            out_V = now_V;
        }
        EXPECT_GT(changes, 500);
    }
}

TEST(BumplessTransfer, DecaysToExactlyZeroInTheExpectedTime) {
    BumplessTransfer transfer = transfer_at(1e-3);
    const Vector3 before_V(2.0, -1.0, 0.02);
    for (int tick = 1; tick <= 41; ++tick) {
        const Vector3 now_V = carried_on_V(transfer, Vector3::Zero(),
                                           tick == 1 ? std::optional(before_V) : std::nullopt);
        EXPECT_NEAR(now_V[0], std::max(0.0, 2.0 - 0.05 * tick), 1e-12);
        EXPECT_NEAR(now_V[1], -std::max(0.0, 1.0 - 0.05 * tick), 1e-12);
        EXPECT_EQ(now_V[2], 0.0);
    }
    EXPECT_EQ(transfer.transfer_offset_V(), Vector3::Zero()); // exactly
}

TEST(BumplessTransfer, LimitsTheOffsetToTheSupply) {
    const double supply_V = testing::phantom_1_0().motor[0].supply_V;
    BumplessTransfer transfer = transfer_at(1e-3);
    const Vector3 far_V = Vector3::Constant(10.0 * supply_V);
    const Vector3 now_V = carried_on_V(transfer, Vector3::Zero(), far_V);
    EXPECT_NEAR(now_V[0], supply_V - 0.05, 1e-12);
}

TEST(BumplessTransfer, StartsANewSceneWithTheLastVoltage) {
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.carry(Vector3(1.0, 0.0, 0.0), std::nullopt, false, true);
    const Vector3 now_V = carried_on_V(transfer, Vector3(0.0, 0.3, 0.01), std::nullopt, true);
    EXPECT_LT((now_V - Vector3(0.95, 0.05, 0.01)).norm(), 1e-12);
}

TEST(BumplessTransfer, HasNoOffsetWhileMotorsAreOff) {
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.carry(Vector3::Zero(), Vector3::Ones(), false, true);
    EXPECT_NE(transfer.transfer_offset_V(), Vector3::Zero());
    transfer.carry(Vector3::Ones(), Vector3::Zero(), false, false);
    EXPECT_EQ(transfer.transfer_offset_V(), Vector3::Zero());
}

TEST(BumplessTransfer, MovesParametersSmoothlyToTheirTargets) {
    constexpr double kGlide_s = 0.05;
    LawSettings requested;
    for (const control::Parameter &parameter : control::kParameters) {
        double &value = requested.tuning.*parameter.value;
        value += 0.5 * (parameter.maximum - value);
    }
    requested.tuning.dR_Ohm = control::Tuning{}.dR_Ohm; // its rate is limited: see below
    requested.tuning.map = control::MotionMap::inverse;
    requested.global_alpha_rad2_per_m2 = 1234.0;
    BumplessTransfer transfer = transfer_at(kPeriod_s);
    const control::Tuning start = transfer.active().tuning;
    for (int tick = 1; tick <= 1500; ++tick) {
        transfer.approach(requested, true);
        const control::Tuning &now = transfer.active().tuning;
        EXPECT_EQ(now.map, requested.tuning.map); // immediately: the step of e_W is compensated
        EXPECT_EQ(transfer.active().global_alpha_rad2_per_m2, 1234.0);
        const double left = std::exp(-tick * kPeriod_s / kGlide_s);
        for (const control::Parameter &parameter : control::kParameters) {
            const double end = requested.tuning.*parameter.value;
            const double range = parameter.maximum - parameter.minimum;
            EXPECT_NEAR(now.*parameter.value, end + left * (start.*parameter.value - end),
                        1e-6 * range) // the final step
                << parameter.name;
        }
    }
    EXPECT_EQ(transfer.active(), requested);
    EXPECT_FALSE(transfer.has_changed());
}

TEST(BumplessTransfer, LimitsTheRateOfTheCancelledVoltage) {
    const device::DeviceDescription device = testing::phantom_1_0();
    for (const double period_s : {1e-3, 1e-4}) {
        LawSettings requested;
        requested.tuning.dR_Ohm = 3.0;
        BumplessTransfer transfer(device, period_s);
        double before_Ohm = transfer.active().tuning.dR_Ohm;
        double fastest_V_per_s = 0.0;
        for (int tick = 0; tick < 300; ++tick) {
            transfer.approach(requested, true);
            const double now_Ohm = transfer.active().tuning.dR_Ohm;
            fastest_V_per_s =
                std::max(fastest_V_per_s,
                         (now_Ohm - before_Ohm) * device.motor[0].peak_current_A / period_s);
            before_Ohm = now_Ohm;
        }
        EXPECT_NEAR(fastest_V_per_s, kMaxChange_V_per_s, 1e-6);
    }
}

TEST(BumplessTransfer, ChangesImmediatelyWhileMotorsAreOff) {
    LawSettings requested;
    requested.tuning.K_P_V_per_rad = 25.0;
    requested.tuning.dR_Ohm = 3.0;
    BumplessTransfer transfer = transfer_at(1e-3);
    transfer.approach(requested, false);
    EXPECT_EQ(transfer.active(), requested);
    EXPECT_TRUE(transfer.has_changed());
    EXPECT_EQ(transfer.before(), LawSettings{});
    transfer.approach(requested, false);
    EXPECT_FALSE(transfer.has_changed());
}

constexpr double kBound_V = kMaxChange_V_per_s * kPeriod_s;

/// A firm hand presses on the plate where the maps differ, and slides along it slowly.
simulated::SimulationOptions firm_contact() {
    simulated::SimulationOptions options = following({{0.0, kStart_m},
                                                      {0.3, Vector3(0.0, 0.003, -0.04)},
                                                      {0.6, Vector3(0.0, -0.009, -0.04)},
                                                      {1.6, Vector3(0.01, -0.009, -0.03)}});
    options.hand = {0.1, 20.0, 800.0, 10.0, 0.4};
    return options;
}

/// A tuning with several volts of e_W under the hand's force.
control::Tuning firm_tuning() {
    control::Tuning tuning;
    tuning.dR_Ohm = 1.0;
    tuning.K_P_V_per_rad = 10.0;
    return tuning;
}

/// e_W of `now` if nothing had changed since `before`: the previous law for the present state, from
/// the two samples alone.
Vector3 unchanged_V(const control::HapticLaw &law, const ServoSample &before,
                    const ServoSample &now) {
    control::VelocityFilter filter(before.theta_rad, before.theta_rate_rad_per_s);
    const double pole = control::velocity_filter_pole(before.tuning.lambda_rad_per_s, kPeriod_s);
    const control::Configuration state =
        law.configuration(now.theta_rad, filter.update(now.theta_rad, pole, kPeriod_s));
    return law(state, now.contact, before.tuning,
               {before.global_alpha_rad2_per_m2,
                alpha_in_contact(before.contact, before.alpha_rad2_per_m2)},
               now.motor, now.lag_s)
               .command.e_W_V +
           before.transfer_offset_V;
}

/// A rig cannot be moved: it is made where it stands.
struct FirmRig : Rig {
    FirmRig() : Rig(firm_contact(), testing::plate()), law(device().description()) {
        inputs.tuning = firm_tuning();
    }

    /// A tick, and by how much a change alone moved e_W in it [V].
    double tick_and_step_V() {
        const ServoSample before = last;
        tick();
        return (last.command.e_W_V - unchanged_V(law, before, last)).cwiseAbs().maxCoeff();
    }

    control::HapticLaw law;
};

struct Change {
    std::string name;
    std::function<void(ServoInputs &)> make;
    double min_V = 0.0; ///< minimum step of e_W without bumpless transfer
};

/// The largest step of e_W due to a change alone, and the largest offset.
struct Felt {
    double step_V = 0.0;
    double transfer_offset_V = 0.0;
    int ticks = 0; ///< examined: until the limiter acts
};

Felt feel(const Change &change, const std::function<void(ServoInputs &)> &first) {
    FirmRig rig;
    first(rig.inputs);
    rig.run(kStartUp_s + 0.8);
    rig.tick();
    EXPECT_TRUE(rig.last.contact.touching);
    EXPECT_EQ(rig.last.safety.state, SafetyState::running) << change.name;
    EXPECT_GT(rig.last.command.e_W_V.norm(), 1.0) << change.name;
    change.make(rig.inputs);
    Felt felt;
    for (int tick = 0; tick < 400; ++tick) {
        const double step_V = rig.tick_and_step_V();
        EXPECT_EQ(rig.last.safety.state, SafetyState::running)
            << change.name << ": " << description(rig.last.safety);
        if (rig.last.active_limits.holds_force() || rig.last.active_limits.voltage) {
            break; // the limiter's reduction is not part of the change
        }
        ++felt.ticks;
        felt.step_V = std::max(felt.step_V, step_V);
        felt.transfer_offset_V =
            std::max(felt.transfer_offset_V, rig.last.transfer_offset_V.cwiseAbs().maxCoeff());
    }
    return felt;
}

void nothing(ServoInputs & /*inputs*/) {}

TEST(ServoLoopChanges, WithoutAChangeTheLawIsReproducedFromTheSamples) {
    const Felt felt = feel({"nothing", nothing}, nothing);
    EXPECT_LT(felt.step_V, 1e-12);
    EXPECT_EQ(felt.transfer_offset_V, 0.0);
}

TEST(ServoLoopChanges, OfAnyParameterMoveEWWithinTheBound) {
    const auto by_hand = [](ServoInputs &inputs) { // so that α has an effect, too
        inputs.tuning.alpha_mode = control::AlphaMode::by_hand;
    };
    for (const control::Parameter &parameter : control::kParameters) {
        const double now = firm_tuning().*parameter.value;
        for (const double value : {parameter.minimum, 0.5 * (parameter.minimum + now),
                                   std::min(1.5 * now + 0.3, parameter.maximum)}) {
            const Change change{
                std::string(parameter.name) + " to " + std::to_string(value),
                [&](ServoInputs &inputs) { inputs.tuning.*parameter.value = value; }};
            const Felt felt = feel(change, by_hand);
            EXPECT_LE(felt.step_V, kBound_V + 1e-9) << change.name;
            EXPECT_GT(felt.ticks, 10) << change.name;
        }
    }
}

TEST(ServoLoopChanges, OfMapAlphaSourceAndGlobalAlphaMoveEWWithinTheBound) {
    const auto start = [](ServoInputs &inputs) {
        inputs.global_alpha_rad2_per_m2 = 3000.0;
        inputs.tuning.alpha_rad2_per_m2 = 2000.0;
    };
    const auto global = [&](ServoInputs &inputs) {
        start(inputs);
        inputs.tuning.alpha_mode = control::AlphaMode::global;
    };
    const auto stiff = [](ServoInputs &inputs) { // α by hand, beyond (29)
        inputs.tuning.alpha_rad2_per_m2 = 8000.0;
        inputs.tuning.alpha_mode = control::AlphaMode::by_hand;
    };
    const auto inverse = [&](ServoInputs &inputs) {
        start(inputs);
        inputs.tuning.map = control::MotionMap::inverse;
    };
    const auto to_map = [](control::MotionMap map) {
        return [map](ServoInputs &inputs) { inputs.tuning.map = map; };
    };
    const auto to_alpha = [](control::AlphaMode mode) {
        return [mode](ServoInputs &inputs) { inputs.tuning.alpha_mode = mode; };
    };
    const auto to_global = [](double alpha) {
        return [alpha](ServoInputs &inputs) { inputs.global_alpha_rad2_per_m2 = alpha; };
    };
    const std::vector<std::pair<Change, std::function<void(ServoInputs &)>>> changes{
        {{"to the inverse map", to_map(control::MotionMap::inverse), 0.1}, start},
        {{"to the transpose map", to_map(control::MotionMap::transpose), 0.1}, inverse},
        {{"to α by hand", to_alpha(control::AlphaMode::by_hand), 0.3}, start},
        {{"to the global α", to_alpha(control::AlphaMode::global), 0.3}, start},
        {{"to α at touch", to_alpha(control::AlphaMode::at_touch), 0.3}, stiff},
        {{"to α on the fly", to_alpha(control::AlphaMode::on_the_fly), 0.3}, global},
        {{"to a lower global α", to_global(500.0), 0.3}, global},
        {{"to no global α", to_global(0.0), 0.3}, global}};
    for (const auto &[change, first] : changes) {
        const Felt felt = feel(change, first);
        EXPECT_LE(felt.step_V, kBound_V + 1e-9) << change.name;
        EXPECT_GT(felt.transfer_offset_V, change.min_V) << change.name; // not vacuous
        EXPECT_GT(felt.ticks, 100) << change.name;
    }
}

TEST(ServoLoopChanges, OfAllParametersRepeatedDuringATransferMoveEWWithinTheBound) {
    FirmRig rig;
    rig.inputs.global_alpha_rad2_per_m2 = 2500.0;
    rig.run(kStartUp_s + 0.8);
    rig.tick();
    double max_V = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
        if (tick % 7 == 0) {
            control::Tuning &tuning = rig.inputs.tuning;
            tuning.map =
                tick % 2 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
            tuning.alpha_mode = static_cast<control::AlphaMode>(tick % 3);
            tuning.K_P_V_per_rad = tick % 4 == 0 ? 6.0 : 12.0;
            tuning.lambda_rad_per_s = tick % 5 == 0 ? 500.0 : 1500.0;
            rig.inputs.global_alpha_rad2_per_m2 = 2000.0 + tick;
        }
        ASSERT_LE(rig.tick_and_step_V(), kBound_V + 1e-9) << tick;
        const ServoSample &now = rig.last;
        ASSERT_FALSE(now.active_limits.holds_force() || now.active_limits.voltage) << tick;
        max_V = std::max(max_V, now.transfer_offset_V.cwiseAbs().maxCoeff());
    }
    EXPECT_GT(max_V, 0.3);
}

TEST(ServoLoopChanges, ToALawBeyondTheSupplyMoveEWWithinTheBound) {
    // Manual α far above the bound: without bumpless transfer e_W would step from 5 V to 17 V.
    FirmRig rig;
    rig.inputs.tuning.dR_Ohm = 2.0;
    rig.inputs.tuning.K_P_V_per_rad = 20.0;
    rig.inputs.tuning.alpha_rad2_per_m2 = 20'000.0;
    rig.run(kStartUp_s + 0.8);
    rig.tick();
    rig.inputs.tuning.alpha_mode = control::AlphaMode::by_hand;
    Vector3 law_V = Vector3::Zero();
    for (int tick = 0; tick < 10; ++tick) {
        EXPECT_LE(rig.tick_and_step_V(), kBound_V + 1e-9) << tick;
        law_V = law_V.cwiseMax((rig.last.command.e_W_V - rig.last.transfer_offset_V).cwiseAbs());
    }
    EXPECT_GT(law_V.maxCoeff(), 12.0); // not vacuous
}

TEST(ServoLoopChanges, OfSceneReleaseTheOldVoltageSlowly) {
    // In the new scene the proxy starts free at the tip: e_W decays gradually to zero.
    const contact::HapticSurface elsewhere(
        testing::box_soup(Vector3(-0.05, -0.05, -0.05), Vector3(0.05, 0.05, 0.05)));
    for (const contact::HapticSurface *next :
         {&elsewhere, static_cast<const contact::HapticSurface *>(nullptr)}) {
        FirmRig rig;
        rig.run(kStartUp_s + 0.8);
        rig.tick();
        const Vector3 before_V = rig.last.command.e_W_V;
        ASSERT_GT(before_V.cwiseAbs().maxCoeff(), 0.5);
        rig.inputs.surface = next;
        ++rig.inputs.scene_id;
        rig.tick();
        EXPECT_FALSE(rig.last.contact.touching);
        EXPECT_LE((rig.last.command.e_W_V - before_V).cwiseAbs().maxCoeff(), kBound_V + 1e-9);
        EXPECT_GT(rig.last.transfer_offset_V.cwiseAbs().maxCoeff(), 0.4);
        for (int tick = 0; tick < 400; ++tick) {
            const double step_V = rig.tick_and_step_V();
            const ServoSample &now = rig.last;
            ASSERT_EQ(now.safety.state, SafetyState::running) << description(now.safety);
            ASSERT_FALSE(now.contact.touching);
            ASSERT_EQ(now.scene_id, rig.inputs.scene_id);
            ASSERT_TRUE(now.active_limits.holds_force() || step_V <= kBound_V + 1e-9)
                << tick << ": " << step_V << " V";
        }
        EXPECT_EQ(rig.last.transfer_offset_V, Vector3::Zero());
    }
}

TEST(ServoLoopChanges, OfTheRateKeepTheResidualsRateOfChange) {
    FirmRig rig;
    rig.run(kStartUp_s + 0.8);
    const double peak_A = rig.device().description().motor[0].peak_current_A;
    double dR_Ohm = 2.0;
    for (const double servo_hz : {4000.0, 2000.0}) {
        rig.loop().set_period(1.0 / servo_hz);
        double before_Ohm = rig.tick().command.cancelled_resistance_Ohm[0];
        rig.inputs.tuning.dR_Ohm = dR_Ohm;
        double fastest_V_per_s = 0.0;
        for (int tick = 0; tick < 200; ++tick) {
            const ServoSample now = rig.tick();
            ASSERT_EQ(now.safety.state, SafetyState::running) << description(now.safety);
            const double moved_Ohm = now.command.cancelled_resistance_Ohm[0] - before_Ohm;
            fastest_V_per_s = std::max(fastest_V_per_s, std::abs(moved_Ohm) * peak_A * servo_hz);
            before_Ohm += moved_Ohm;
        }
        // A step of 1 Ω or more exceeds the limit at either rate.
        EXPECT_NEAR(fastest_V_per_s, kMaxChange_V_per_s, 1e-6) << servo_hz;
        dR_Ohm = 0.3;
    }
}

/// With its own clock, like hardware: it advances by a given number of periods.
class AsHardware final : public device::ForwardingDevice {
public:
    using device::ForwardingDevice::ForwardingDevice;

    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::own; }
    [[nodiscard]] device::Measurement read() noexcept override {
        device::Measurement measured = device::ForwardingDevice::read();
        for (int i = 0; i < missed; ++i) {
            measured = device::ForwardingDevice::read();
        }
        measured.time_s += 17.0; // the servo must not depend on its zero
        return measured;
    }

    int missed = 0;
};

TEST(ServoLoopChanges, MissedDeadlinesOfADeviceThatDoesNotWaitReachSampleAndMonitor) {
    simulated::SimulatedPhantom phantom(testing::phantom_1_0(), firm_contact(), kStart_m);
    AsHardware device(phantom);
    ServoLoop loop(device, kPeriod_s);
    const auto tick = [&](std::uint32_t missed, std::uint32_t in_a_row) {
        device.missed = static_cast<int>(missed);
        return loop.tick({}, {missed, in_a_row});
    };
    for (int i = 0; i < 1200; ++i) {
        static_cast<void>(tick(0, 0));
    }
    const ServoSample within = tick(2, 50);
    EXPECT_EQ(within.missed_deadlines, 2U);
    EXPECT_EQ(within.missed_in_a_row, 50U);
    EXPECT_EQ(within.missed_periods, 2U);
    EXPECT_NEAR(within.since_last_s, 3e-3, 1e-12);
    EXPECT_EQ(within.safety.state, SafetyState::running);
    EXPECT_EQ(tick(1, 51).safety.cause, TripCause::missed_deadlines);
}

TEST(ServoLoopChanges, ADeviceThatWaitsMissesNothing) {
    FirmRig rig;
    rig.run(kStartUp_s + 0.8);
    FirmRig on_time;
    on_time.run(kStartUp_s + 0.8);
    for (const std::uint32_t missed : {1U, 99U, 2000U}) {
        const ServoSample late = rig.tick({missed, missed});
        const ServoSample sample = on_time.tick();
        EXPECT_EQ(late.missed_deadlines, missed); // counted nevertheless
        EXPECT_EQ(late.missed_periods, 0U);
        EXPECT_EQ(late.safety.state, SafetyState::running);
        EXPECT_EQ(late.command.e_W_V, sample.command.e_W_V);
        EXPECT_EQ(late.theta_rate_rad_per_s, sample.theta_rate_rad_per_s);
    }
}

/// Presses on the plate when its device starts to fail.
struct FailingRig : Rig {
    FailingRig() : Rig(firm_contact(), testing::plate()) { run(2.0); }

    void fail(device::FaultKind kind, double size = 0.0) {
        device().commit({kind, Vector3(size, 0.0, 0.0)});
    }
};

TEST(ServoLoopChanges, TheLastCommandIsHeldWithoutNewMeasurementsWithinTheLimit) {
    using device::FaultKind;
    const std::array<std::pair<FaultKind, device::Arrival>, 3> silences{
        {{FaultKind::repeat, device::Arrival::repeated},
         {FaultKind::corrupt, device::Arrival::corrupt},
         {FaultKind::drop, device::Arrival::absent}}};
    for (const auto &[fault, arrival] : silences) {
        FailingRig rig;
        ASSERT_TRUE(rig.last.contact.touching);
        ASSERT_EQ(rig.last.safety.state, SafetyState::running);
        const ServoSample before = rig.last;
        rig.fail(fault);
        for (int tick = 0; tick < 5; ++tick) { // 5 ms are tolerated
            const ServoSample stale = rig.tick();
            EXPECT_EQ(stale.arrival, arrival);
            EXPECT_EQ(stale.since_last_s, 0.0);
            EXPECT_EQ(stale.safety.state, SafetyState::running);
            EXPECT_EQ(stale.command.e_W_V, before.command.e_W_V);
            EXPECT_EQ(stale.theta_rad, before.theta_rad);
            EXPECT_EQ(stale.theta_rate_rad_per_s, before.theta_rate_rad_per_s);
            EXPECT_EQ(stale.contact.x0_m, before.contact.x0_m);
        }
        FailingRig fixed; // the same, but with a new measurement in the sixth tick
        fixed.fail(fault);
        for (int tick = 0; tick < 5; ++tick) {
            fixed.tick();
        }
        fixed.device().clear_fault();
        const ServoSample fresh = fixed.tick();
        EXPECT_EQ(fresh.safety.state, SafetyState::running);
        EXPECT_EQ(fresh.missed_periods, 5U);
        EXPECT_DOUBLE_EQ(fresh.since_last_s, 6.0 * kPeriod_s);

        const ServoSample tripped = rig.tick();
        EXPECT_EQ(tripped.safety.cause, TripCause::stale_measurement);
        EXPECT_NEAR(tripped.safety.measured, 6.0 * kPeriod_s, 1e-9);
        EXPECT_EQ(tripped.command.mode, device::CommandMode::brake);
        EXPECT_TRUE(tripped.command.e_W_V.isZero(0.0));
    }
}

TEST(ServoLoopChanges, LateMeasurementsAreUsedAndCountedAsStale) {
    FailingRig rig;
    rig.fail(device::FaultKind::delay);
    for (int tick = 0; tick < 5; ++tick) {
        const ServoSample sample = rig.tick();
        EXPECT_EQ(sample.safety.state, SafetyState::running);
        EXPECT_DOUBLE_EQ(sample.since_last_s, kPeriod_s);
    }
    EXPECT_EQ(rig.tick().safety.cause, TripCause::stale_measurement);
}

TEST(ServoLoopChanges, BoardFaultsTripAndOnlyAmplifierFaultsOpenTheWindings) {
    for (int bit = 0; bit < 6; ++bit) {
        FailingRig rig;
        const auto bits = static_cast<std::uint16_t>(1U << static_cast<unsigned>(bit));
        rig.fail(device::FaultKind::board, bits);
        const ServoSample sample = rig.tick();
        EXPECT_EQ(sample.safety.cause, TripCause::board_fault);
        EXPECT_EQ(sample.board_faults, bits);
        EXPECT_EQ(sample.command.mode,
                  device::BoardFaults{bits}.has(device::BoardFaults::kAmplifier)
                      ? device::CommandMode::open
                      : device::CommandMode::brake);
        EXPECT_TRUE(sample.command.e_W_V.isZero(0.0));
        EXPECT_TRUE(sample.command.cancelled_resistance_Ohm.isZero(0.0));
        rig.fail(device::FaultKind::drop); // no new measurement: the fault persists
        EXPECT_EQ(rig.tick().command.mode, sample.command.mode);
        rig.device().clear_fault(); // it brakes again, until a reset
        EXPECT_EQ(rig.tick().command.mode, device::CommandMode::brake);
    }
}

/// How many ticks it tells the board to clear its faults, from a reset on.
int ticks_of_reset(FailingRig &rig, std::optional<int> cleared_after) {
    int ticks = 0;
    rig.inputs.reset_count += 1;
    for (int i = 0; i < 300; ++i) {
        if (i == cleared_after) {
            rig.device().clear_fault();
        }
        const ServoSample sample = rig.tick();
        ticks += sample.command.resets_faults ? 1 : 0;
        EXPECT_NE(sample.command.mode, device::CommandMode::drive);
        EXPECT_TRUE(!sample.command.resets_faults ||
                    sample.command.mode == device::CommandMode::brake);
    }
    return ticks;
}

TEST(ServoLoopChanges, OnlyAResetTellsTheBoardToClearItsFaults) {
    for (const std::uint16_t bits :
         {device::BoardFaults::kAmplifier, device::BoardFaults::kNoCommand}) {
        FailingRig rig;
        rig.fail(device::FaultKind::board, bits);
        for (int i = 0; i < 300; ++i) {
            EXPECT_FALSE(rig.tick().command.resets_faults);
        }
        EXPECT_EQ(ticks_of_reset(rig, std::nullopt), 99); // 0.1 s, and trips again
        EXPECT_EQ(rig.tick().safety.cause, TripCause::board_fault);
        EXPECT_EQ(ticks_of_reset(rig, 3), 3);
        EXPECT_EQ(rig.tick().safety.cause, TripCause::none);
    }
}

TEST(ServoLoopChanges, BeforeTheFirstMeasurementItBrakes) {
    Rig rig(firm_contact());
    rig.device().commit({.kind = device::FaultKind::drop});
    for (int i = 0; i < 3; ++i) {
        const ServoSample sample = rig.tick();
        EXPECT_EQ(sample.command.mode, device::CommandMode::brake);
        EXPECT_NE(sample.safety.state, SafetyState::running);
    }
    rig.device().clear_fault();
    const ServoSample first = rig.tick();
    EXPECT_TRUE(first.theta_rate_rad_per_s.isZero(0.0));
    EXPECT_EQ(first.safety.state, SafetyState::waiting);
}

} // namespace
} // namespace springdrive::servo
