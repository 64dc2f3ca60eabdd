// Covers engine/session/record_playback.cpp: with a record's own tuning everything is as recorded,
// to the last bit or to the resolution of the encoders; with another, as the law, the filter and a
// simulation with that tuning have it.
#include "engine/session/record_playback.h"

#include "engine/control/velocity_filter.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/engine/record/samples.h"
#include "tests/engine/session/record_fixture.h"

#include "tests/engine/session/session_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace springdrive::session {
namespace {

using Samples = std::vector<servo::ServoSample>;
using testing::Press;

Samples answers(const Samples &recorded, const control::Tuning &tuning, double delay_periods = 0.0,
                const device::DeviceDescription &device = testing::phantom_1_0()) {
    WhatIf what_if(device, delay_periods, tuning);
    Samples all;
    for (const servo::ServoSample &sample : recorded) {
        all.push_back(what_if.of(sample));
    }
    return all;
}

/// What the encoders make of the currents: a velocity is off by up to a count a period, and the
/// next one by as much the other way, so that the angles are never off by more than a count. That
/// is k_T times a count of flux, and L times the current.
double current_of_a_count_A(const device::DeviceDescription &device) {
    const device::MotorParameters &motor = device.motor[0];
    return motor.torque_constant_Nm_per_A * device.rad_per_count() / motor.inductance_H;
}

double greatest_difference_A(const Samples &a, const Samples &b) {
    double greatest_A = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        greatest_A = std::max(greatest_A, (a[i].current_A - b[i].current_A).cwiseAbs().maxCoeff());
    }
    return greatest_A;
}

double greatest_current_A(const Samples &samples) {
    double greatest_A = 0.0;
    for (const servo::ServoSample &sample : samples) {
        greatest_A = std::max(greatest_A, sample.current_A.cwiseAbs().maxCoeff());
    }
    return greatest_A;
}

/// Windings of the file's resistance.
simulated::SimulationOptions ideal_windings() {
    simulated::SimulationOptions options = Press::pressing();
    options.effects.winding_heat = false;
    options.effects.commutation_ripple = false;
    return options;
}

/// With the currents and what follows from them taken from another sample.
servo::ServoSample with_currents_of(servo::ServoSample sample, const servo::ServoSample &other) {
    sample.current_A = other.current_A;
    sample.tip_force_N = other.tip_force_N;
    sample.rendered_error_rad = other.rendered_error_rad;
    return sample;
}

TEST(WhatIf, TheRecordsOwnTuningChangesNoBitButTheCurrents) {
    for (const control::MotionMap map :
         {control::MotionMap::inverse, control::MotionMap::transpose}) {
        Press press;
        press.inputs.tuning.map = map;
        press.inputs.tuning.eta = 0.1;
        press.seconds = 4.0;
        press.before_tick = [](rig::ServoRig &rig, int tick) {
            rig.inputs.limits.tip_force_N = tick < 2100 ? 1.0 : 8.0; // less than the hand presses
            rig.inputs.requested_stop = tick >= 2000 ? 1 : 0;
            rig.inputs.reset_count = rig.inputs.released_stop = tick > 2010 ? 1 : 0;
            if (tick == 1400 || tick == 1420) { // ticks that hold the last command
                rig.device().commit({.kind = device::FaultKind::drop, .end_s = 2.0});
            }
        };
        const Samples recorded = press.samples();
        const Samples found = answers(recorded, press.inputs.tuning);
        std::uint64_t passing = 0;
        std::uint64_t active_limits = 0;
        std::uint64_t held = 0;
        std::uint64_t pushing = 0;
        for (std::size_t i = 0; i < recorded.size(); ++i) {
            ASSERT_EQ(testing::row_of(with_currents_of(found[i], recorded[i])),
                      testing::row_of(recorded[i]))
                << i;
            passing += servo::lets_pass(recorded[i].safety.state) ? 1U : 0U;
            active_limits += recorded[i].active_limits.holds_force() ? 1U : 0U;
            held += recorded[i].since_last_s == 0.0 ? 1U : 0U;
            pushing += std::isnan(recorded[i].transpose_error_rad) ? 0U : 1U;
        }
        EXPECT_GT(passing, 1000U); // not vacuous
        EXPECT_GT(active_limits, 50U);
        EXPECT_EQ(held, 4U);
        EXPECT_GT(pushing, 500U);
    }
}

TEST(WhatIf, CurrentsAgreeToTheResolutionOfTheEncoders) {
    const std::pair<int, double> cases[]{{1, 0.0},  {1, 1.75}, {64, 0.0},
                                         {64, 0.3}, {64, 1.0}, {64, 1.75}};
    for (const auto &[finer, delay_periods] : cases) {
        SCOPED_TRACE(::testing::Message() << finer << ' ' << delay_periods);
        Press press;
        press.device.encoder_counts_per_turn *= finer;
        press.simulation = ideal_windings();
        press.simulation.delay_periods = delay_periods;
        press.inputs.tuning.K_P_V_per_rad = 3.0;
        const Samples recorded = press.samples();
        const Samples found = answers(recorded, press.inputs.tuning, delay_periods, press.device);
        // Within a period the rotors do not turn evenly, which the second part allows for.
        const double allowed_A =
            current_of_a_count_A(press.device) + 0.01 * greatest_current_A(recorded);
        const double difference_A = greatest_difference_A(found, recorded);
        EXPECT_LT(difference_A, allowed_A);
        EXPECT_GT(difference_A, 0.0);           // they are predicted
        if (finer > 1 && delay_periods > 0.0) { // and the delay matters
            const Samples early = answers(recorded, press.inputs.tuning, 0.0, press.device);
            EXPECT_GT(greatest_difference_A(early, recorded), 2.0 * allowed_A);
        }
    }
}

TEST(WhatIf, CurrentsGoOnAcrossLateTicksAndMissingMeasurements) {
    for (const double delay_periods : {0.0, 1.3}) {
        Press press;
        press.simulation = ideal_windings();
        press.simulation.delay_periods = delay_periods;
        press.inputs.tuning.K_P_V_per_rad = 3.0;
        press.before_tick = [](rig::ServoRig &rig, int tick) {
            if (tick % 100 == 50) {
                rig.device().pass_by(2);
            } else if (tick % 100 == 80) {
                rig.device().commit({.kind = device::FaultKind::drop, .end_s = 2.0});
            }
        };
        const Samples recorded = press.samples();
        const Samples found = answers(recorded, press.inputs.tuning, delay_periods);
        EXPECT_LT(greatest_difference_A(found, recorded), current_of_a_count_A(press.device));
        std::uint64_t missed = 0;
        std::uint64_t predicted = 0;
        for (std::size_t i = 0; i < recorded.size(); ++i) {
            missed += recorded[i].missed_periods;
            predicted += found[i].current_A == recorded[i].current_A ? 0U : 1U;
        }
        EXPECT_GT(missed, 100U);
        EXPECT_GT(predicted, recorded.size() / 2);
    }
}

TEST(WhatIf, ForceFollowsFromTheCurrentsWithTheirOffsets) {
    Press press;
    press.simulation.device_seed = 5;                  // deviations of motors and sensors
    press.device = testing::phantom_without_brushes(); // a prediction knows nothing of V_b
    press.inputs.observes_resistance = true;
    const Samples recorded = press.samples();
    const Samples found = answers(recorded, press.inputs.tuning);
    double squares = 0.0;
    double predicted_squares = 0.0;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
        if (recorded[i].contact.touching) {
            squares += recorded[i].tip_force_N.squaredNorm();
            predicted_squares += (found[i].tip_force_N - recorded[i].tip_force_N).squaredNorm();
        }
    }
    // Of R = 2.2 Ω, the observer knows some per cent less than all, of dR = 0.5 Ω four times as
    // many; the encoders' share is as above.
    EXPECT_LT(std::sqrt(predicted_squares / squares), 0.08);
}

TEST(WhatIf, AnotherTuningIsWhatReplayFinds) {
    const Samples &recorded = testing::plain_press();
    control::Tuning other;
    other.K_P_V_per_rad = 9.0;
    other.dR_Ohm = 0.8;
    other.lambda_rad_per_s = 400.0;
    other.map = control::MotionMap::inverse;
    const Samples found = answers(recorded, other);
    record::Replay replay(testing::phantom_1_0(), other);
    for (std::size_t i = 0; i < recorded.size(); ++i) {
        const std::optional<record::ReplayedTick> tick = replay.take(recorded[i]);
        ASSERT_TRUE(tick.has_value());
        ASSERT_EQ(found[i].command.e_W_V, tick->command.e_W_V);
        ASSERT_EQ(found[i].command.cancelled_resistance_Ohm,
                  tick->command.cancelled_resistance_Ohm);
        ASSERT_EQ(found[i].theta_Sd_rad, tick->found.used.theta_Sd_rad);
        ASSERT_EQ(found[i].tuning, other);
    }
    EXPECT_FALSE(replay.is_identical());
}

TEST(WhatIf, AnotherLambdaFiltersTheWholeMotion) {
    const Samples &recorded = testing::plain_press();
    control::Tuning other;
    other.lambda_rad_per_s = 200.0;
    const Samples found = answers(recorded, other);
    control::VelocityFilter filter;
    filter.reset(recorded.front().theta_rad);
    const double pole = control::velocity_filter_pole(other.lambda_rad_per_s, 1e-3);
    double greatest = 0.0;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
        const Vector3 rate = filter.update(recorded[i].theta_rad, pole, 1e-3);
        ASSERT_TRUE(found[i].theta_rate_rad_per_s.isApprox(rate, 1e-9) || rate.norm() < 1e-9) << i;
        greatest = std::max(greatest, (rate - recorded[i].theta_rate_rad_per_s).norm());
    }
    EXPECT_GT(greatest, 0.5); // not vacuous
}

/// The mean force of a held press.
Vector3 held_force_N(const Samples &samples) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 1650; i < 1790; ++i) {
        sum += samples[i].tip_force_N / 140.0;
    }
    return sum;
}

TEST(WhatIf, TheForceOfAHeldPressIsThatOfASimulationWithThatTuning) {
    Press press;
    press.simulation = ideal_windings();
    press.simulation.hand.stiffness_N_per_m = 20'000.0; // the tip is where the hand is
    press.simulation.hand.damping_Ns_per_m = 80.0;
    press.simulation.hand.max_force_N = 50.0;
    press.inputs.tuning.K_P_V_per_rad = 1.5;
    Press softer = press;
    softer.inputs.tuning.dR_Ohm = 0.8;
    const Samples recorded = press.samples();
    const Vector3 simulated_N = held_force_N(softer.samples());
    const Vector3 predicted_N = held_force_N(answers(recorded, softer.inputs.tuning));
    EXPECT_GT(simulated_N.norm(), 1.0);
    EXPECT_LT((predicted_N - simulated_N).norm(), 0.03 * simulated_N.norm());
    EXPECT_GT((held_force_N(recorded) - simulated_N).norm(), 0.3 * simulated_N.norm());
}

TEST(WhatIf, AfterAGapCurrentsStartAsRecorded) {
    Press press;
    press.inputs.tuning.K_P_V_per_rad = 3.0;
    Samples recorded = press.samples();
    recorded.erase(recorded.begin() + 1500, recorded.begin() + 1510);
    control::Tuning other = press.inputs.tuning;
    other.K_P_V_per_rad = 2.0;
    const Samples found = answers(recorded, other);
    EXPECT_NE(found[1499].current_A, recorded[1499].current_A);
    EXPECT_EQ(testing::row_of(found[1500]), testing::row_of(recorded[1500]));
    EXPECT_NE(found[1501].command.e_W_V, recorded[1501].command.e_W_V);
    EXPECT_NE(found[1501].current_A, recorded[1501].current_A);
    const Samples later = answers(recorded, other, 2.5);
    EXPECT_EQ(later[1502].current_A, recorded[1502].current_A); // their commands are missing
    EXPECT_NE(later[1504].current_A, recorded[1504].current_A);
}

TEST(WhatIf, ACommandHeldAfterAGapIsTheRecordedOne) {
    Press press;
    press.before_tick = [](rig::ServoRig &rig, int tick) {
        if (tick == 1500) {
            rig.device().commit({.kind = device::FaultKind::drop, .end_s = 2.0});
        }
    };
    Samples recorded = press.samples();
    const auto held = std::ranges::find(recorded, 0.0, &servo::ServoSample::since_last_s);
    ASSERT_NE(held, recorded.end());
    ASSERT_FALSE(held->command.e_W_V.isZero(0.0));
    recorded.erase(held - 5, held - 1);
    record::Replay replay(testing::phantom_1_0());
    for (const servo::ServoSample &sample : recorded) {
        static_cast<void>(replay.take(sample));
    }
    EXPECT_EQ(replay.skipped(), 1U);
    EXPECT_TRUE(replay.is_identical());
}

TEST(WhatIf, ATickWithValuesThatNoServoHasStaysAndIsMissing) {
    const Samples &recorded = testing::plain_press();
    control::Tuning other;
    other.K_P_V_per_rad = 2.0;
    using Spoil = void (*)(servo::ServoSample &);
    const double nan = std::nan("");
    for (const Spoil spoil : std::initializer_list<Spoil>{
             [](servo::ServoSample &s) { s.winding[1].R_hat_limit_Ohm = -1.0; },
             [](servo::ServoSample &s) { s.limits.voltage_V = -1.0; },
             [](servo::ServoSample &s) { s.since_last_s = std::nan(""); },
             [](servo::ServoSample &s) { s.contact.x0_m.setConstant(std::nan("")); },
             [](servo::ServoSample &s) { s.motor[2].here.resistance_Ohm = std::nan(""); }}) {
        Samples spoilt = recorded;
        spoil(spoilt[1600]);
        const Samples found = answers(spoilt, other);
        EXPECT_EQ(testing::row_of(found[1600]), testing::row_of(spoilt[1600]));
        EXPECT_EQ(testing::row_of(found[1601]), testing::row_of(spoilt[1601]));
        EXPECT_NE(found[1602].command.e_W_V, spoilt[1602].command.e_W_V);
        EXPECT_TRUE(found[1700].current_A.allFinite());
    }
    Samples spoilt = recorded;
    spoilt[1600].current_A.setConstant(nan);
    EXPECT_TRUE(answers(spoilt, other)[1601].current_A.allFinite());
}

TEST(WhatIf, RandomRowsDoNoHarm) {
    Samples random = testing::random_samples(400, testing::kRecorded_hz, 3);
    static_cast<void>(answers(random, {}, 0.5));
    std::mt19937_64 bits(4);
    Samples recorded = testing::plain_press();
    for (std::size_t i = 0; i < recorded.size(); i += 3) { // single columns
        const servo::ServoSample other = testing::random_sample(bits, recorded[i].tick);
        std::size_t column = 0;
        const std::size_t replaced = bits() % 60;
        std::vector<double> values;
        record::for_each_column(other, [&](auto, auto, const auto &value) {
            values.push_back(static_cast<double>(value));
        });
        record::for_each_column(recorded[i], [&](auto, auto, auto &value) {
            if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, double>) {
                value = column == replaced ? values[column] : value;
            }
            ++column;
        });
    }
    static_cast<void>(answers(recorded, {}, 1.5));
}

TEST(WhatIf, APartOfARecordIsAsInTheWhole) {
    const Record record = testing::in_memory(testing::plain_press());
    control::Tuning other;
    other.lambda_rad_per_s = 150.0;
    other.dR_Ohm = 0.1;
    const record::ChannelStore whole = what_if(record, other, {0, record.store.end()});
    ASSERT_EQ(whole.end(), record.store.end());
    const record::ChannelStore part = what_if(record, other, {1700, 2300});
    ASSERT_EQ(part.end() - part.begin(), 600U);
    for (std::uint64_t row = 0; row < 600; ++row) {
        EXPECT_EQ(part.time_s(row), record.store.time_s(1700 + row));
        for (std::size_t channel = 0; channel < channels().size(); ++channel) {
            const double in_part = part.value(channel, row);
            const double in_whole = whole.value(channel, 1700 + row);
            ASSERT_TRUE((std::isnan(in_part) && std::isnan(in_whole)) ||
                        std::abs(in_part - in_whole) <= 1e-9 * (1.0 + std::abs(in_whole)))
                << channels()[channel].name << ' ' << row;
        }
    }
    EXPECT_TRUE(what_if(record, other, {500, 500}).is_empty());
}

TEST(WhatIf, EndsSoonWhenCancelled) {
    const Record record = testing::in_memory(testing::plain_press());
    const std::atomic<bool> is_cancelled = true;
    const StopScope by(&is_cancelled);
    EXPECT_THROW(static_cast<void>(what_if(record, {}, {0, record.store.end()})), Cancelled);
}

/// Root of the mean square of the difference in a tick's currents, in a range of ticks.
double difference_A(const record::ChannelStore &a, const record::ChannelStore &b,
                    std::uint64_t from_tick) {
    double sum = 0.0;
    std::uint64_t count = 0;
    for (std::uint64_t row = a.begin(); row < a.end(); ++row) {
        const servo::ServoSample of_a = sample_at(a, row);
        if (of_a.tick >= from_tick) {
            sum += (of_a.current_A - sample_at(b, row).current_A).squaredNorm();
            ++count;
        }
    }
    return std::sqrt(sum / static_cast<double>(count));
}

TEST(WhatIf, FollowsDelayAndSceneThatChangeWithinARecord) {
    const std::filesystem::path folder = testing::fresh_folder("what_if_changes");
    SessionOptions options = testing::scripted();
    options.record = folder / "touch.rec";
    Session session(options);
    session.start();
    ASSERT_TRUE(testing::run_into_contact(session));
    session.set_delay(2.6);
    const std::uint64_t from_tick = session.latest().tick + 10;
    testing::run(session, 2.0);
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    ASSERT_TRUE(testing::run_until_loaded(session));
    session.stop();

    BackgroundTalk talk;
    Record record = load_record(options.record, 0.0, std::numeric_limits<std::size_t>::max(), talk);
    const servo::ServoSample first = sample_at(record.store, record.store.begin());
    const servo::ServoSample last = sample_at(record.store, record.store.end() - 1);
    EXPECT_EQ(delay_periods_at(first.tick, delays_of(record)), 0.0);
    EXPECT_EQ(delay_periods_at(last.tick, delays_of(record)), 2.6);
    EXPECT_TRUE(record.header.scene_file.ends_with("plate.gltf"));
    EXPECT_FALSE(noted_scenes(record).contains(first.scene_id));
    EXPECT_TRUE(noted_scenes(record)[last.scene_id].file.ends_with("sphere.gltf"));

    const double followed_A =
        difference_A(record.store, what_if(record, first.tuning, record.rows), from_tick);
    record.notes.clear();
    const double ignored_A =
        difference_A(record.store, what_if(record, first.tuning, record.rows), from_tick);
    EXPECT_LT(followed_A, current_of_a_count_A(record.device));
    EXPECT_LT(followed_A, 0.8 * ignored_A);
}

} // namespace
} // namespace springdrive::session
