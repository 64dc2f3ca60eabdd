// Covers engine/record/replay.cpp: the servo's own samples are reproduced bit for bit, and any
// different bit is detected.
#include "engine/record/replay.h"

#include "engine/control/tuning.h"
#include "engine/lab/rig/servo_rig.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

namespace springdrive::record {
namespace {

const Vector3 kStart_m(0.0, 0.02, 0.0);

/// A touch during which everything changes: tuning, maps, limits, a trip and a reset.
std::vector<servo::ServoSample> eventful_run(unsigned seed, double period_s) {
    std::mt19937_64 random(seed);
    simulated::SimulationOptions options;
    options.servo_period_s = period_s;
    options.path.emplace(std::vector<simulated::HandPath::Point>{{1.2, kStart_m},
                                                                 {1.5, Vector3(0.0, -0.004, 0.0)},
                                                                 {2.5, Vector3(0.02, -0.006, 0.01)},
                                                                 {2.8, kStart_m}});
    const contact::HapticSurface plate(
        testing::box_soup(Vector3(-0.1, -0.02, -0.06), Vector3(0.1, 0.0, 0.06)));
    rig::ServoRig rig(testing::phantom_1_0(), options, kStart_m, &plate);
    servo::ServoInputs &inputs = rig.inputs;
    inputs.scene_id = 1;
    inputs.global_alpha_rad2_per_m2 = 3000.0;
    std::vector<servo::ServoSample> samples;
    const int ticks = static_cast<int>(std::lround(4.2 / period_s));
    for (int tick = 0; tick < ticks; ++tick) {
        if (tick % 97 == 0) {
            std::uniform_real_distribution<double> share(0.0, 1.0);
            for (const control::Parameter &parameter : control::kParameters) {
                inputs.tuning.*parameter.value =
                    parameter.default_value() * (0.7 + 0.6 * share(random));
            }
            inputs.tuning.eta = 0.5 * share(random);
            inputs.tuning.map =
                share(random) < 0.5 ? control::MotionMap::inverse : control::MotionMap::transpose;
            inputs.tuning.alpha_mode = static_cast<control::AlphaMode>(random() % 3);
            inputs.limits.tip_force_N = 1.0 + 8.0 * share(random);
        }
        if (tick % 97 == 48 && tick > ticks / 3) { // from touch to measurement, or back
            inputs.fixed_x0_m =
                inputs.fixed_x0_m ? std::nullopt : std::optional(samples.back().tip_m);
        }
        inputs.excitation_V.setConstant(inputs.fixed_x0_m ? 0.3 * std::sin(0.1 * tick) : 0.0);
        inputs.requested_stop = tick >= ticks * 3 / 4 ? 1 : 0;
        inputs.reset_count = inputs.released_stop = tick > ticks * 3 / 4 + 10 ? 1 : 0;
        samples.push_back(rig.tick());
    }
    return samples;
}

/// For all tests that change some of it.
const std::vector<servo::ServoSample> &one_run() {
    static const std::vector<servo::ServoSample> samples = eventful_run(5, 1e-3);
    return samples;
}

Replay replay_of(const std::vector<servo::ServoSample> &samples) {
    Replay replay(testing::phantom_1_0());
    for (const servo::ServoSample &sample : samples) {
        static_cast<void>(replay.take(sample));
    }
    return replay;
}

TEST(Replay, ReproducesTheServosBits) {
    for (const unsigned seed : {1U, 2U}) {
        const double period_s = seed % 2 == 0 ? 1e-3 : 0.25e-3;
        const std::vector<servo::ServoSample> samples = eventful_run(seed, period_s);
        const Replay replay = replay_of(samples);
        EXPECT_EQ(replay.replayed(), samples.size());
        EXPECT_EQ(replay.skipped(), 0U);
        EXPECT_TRUE(replay.is_identical());
        bool drove = false; // not vacuous
        bool carried = false;
        for (const servo::ServoSample &sample : samples) {
            drove = drove || !sample.command.e_W_V.isZero(1e-2);
            carried = carried || !sample.transfer_offset_V.isZero(0.0);
        }
        EXPECT_TRUE(drove);
        EXPECT_TRUE(carried);
    }
}

TEST(Replay, StartsAnywhereAndAcrossGaps) {
    std::vector<servo::ServoSample> samples = one_run();
    samples.erase(samples.begin() + 2000, samples.begin() + 2003); // lost
    samples.erase(samples.begin(), samples.begin() + 1300);        // recorded from there on
    const Replay replay = replay_of(samples);
    EXPECT_EQ(replay.skipped(), 2U);
    EXPECT_EQ(replay.replayed(), samples.size() - 2);
    EXPECT_TRUE(replay.is_identical());
}

TEST(Replay, DetectsASingleBit) {
    constexpr std::size_t kTick = 1700;
    std::vector<servo::ServoSample> changed = one_run();
    changed[kTick].command.e_W_V[1] = std::nextafter(changed[kTick].command.e_W_V[1], 100.0);
    const Replay replay = replay_of(changed);
    EXPECT_FALSE(replay.is_identical());
    for (const ReplayedQuantity &quantity : replay.quantities()) {
        const bool is_voltage = std::string(quantity.name) == "e_W_V";
        EXPECT_EQ(quantity.differing, is_voltage ? 1U : 0U) << quantity.name;
        EXPECT_EQ(quantity.first_tick, is_voltage ? kTick : 0U);
    }
}

TEST(Replay, AnotherCountIsAnotherMotion) {
    std::vector<servo::ServoSample> samples = one_run();
    ++samples[1800].counts[0];
    EXPECT_FALSE(replay_of(samples).is_identical());
}

} // namespace
} // namespace springdrive::record
