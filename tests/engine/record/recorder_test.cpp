// Covers engine/record/recorder.cpp; for a killed process see record_kill_test.cpp.
#include "engine/record/recorder.h"

#include "engine/control/tuning.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/record/record_file.h"
#include "engine/record/replay.h"
#include "tests/engine/record/samples.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <random>
#include <thread>
#include <vector>

namespace springdrive::record {
namespace {

using testing::expected_bytes;
using testing::fresh_folder;
using Mode = Recorder::Mode;

servo::ServoSample sample_at(std::uint64_t tick) {
    servo::ServoSample sample;
    sample.tick = tick;
    return sample;
}

/// The ticks and notes of a file, in order: "0 1 2 {note} 3".
std::string log_of(const std::filesystem::path &file) {
    RecordReader reader(file);
    std::string log;
    reader.for_each(
        [&](const servo::ServoSample &sample) { log += std::to_string(sample.tick) + " "; },
        [&](std::string_view note) { log += "{" + std::string(note) + "} "; });
    EXPECT_EQ(reader.ending().why, "");
    return log;
}

void push(SampleRing<servo::ServoSample> &ring, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t tick = from; tick < to; ++tick) {
        ring.push(sample_at(tick));
    }
}

TEST(Recorder, RecordsWhatIsPumpedBetweenStartAndStop) {
    const auto file = fresh_folder("recorder_pumped") / "a.rec";
    SampleRing<servo::ServoSample> ring(16);
    Recorder recorder(ring);
    push(ring, 0, 3); // from before
    EXPECT_FALSE(recorder.is_recording());
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_TRUE(recorder.is_recording());
    push(ring, 3, 10);
    recorder.pump();
    push(ring, 10, 15);
    recorder.note("scene");
    recorder.pump();
    push(ring, 15, 17);
    recorder.stop("end");
    EXPECT_FALSE(recorder.is_recording());
    EXPECT_EQ(log_of(file), "3 4 5 6 7 8 9 10 11 12 13 14 {scene} 15 16 {end} ");
    const RecorderStatus status = recorder.status();
    EXPECT_EQ(status.rows, 14U);
    EXPECT_EQ(status.bytes, std::filesystem::file_size(file));
    EXPECT_EQ(status.lost, 0U);
    EXPECT_EQ(status.error, "");
}

TEST(Recorder, CountsSamplesLostByTheRingOnce) {
    const auto file = fresh_folder("recorder_lost") / "a.rec";
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    push(ring, 0, 20); // loses 12, which are not the recording's
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_EQ(recorder.status().lost, 0U);
    push(ring, 20, 31); // 3 lost
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 3U);
    push(ring, 31, 35);
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 3U);
    push(ring, 37, 39); // 2 never came
    recorder.pump();
    EXPECT_EQ(recorder.status().lost, 5U);
    recorder.stop();
    RecordReader reader(file);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.ending().missing_ticks, 5U);
}

TEST(Recorder, RestartsWithFreshStatus) {
    const auto folder = fresh_folder("recorder_anew");
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    recorder.start(folder / "a.rec", record_header(testing::kServo_hz), Mode::pumped);
    push(ring, 0, 12);
    EXPECT_NE(error_text_of([&] { // stops the first, too
                  recorder.start(folder / "a.rec", record_header(testing::kServo_hz), Mode::pumped);
              })
                  .find("exists already"),
              std::string::npos);
    EXPECT_FALSE(recorder.is_recording());
    recorder.start(folder / "b.rec", record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_EQ(recorder.status().rows, 0U);
    EXPECT_EQ(recorder.status().lost, 0U);
    push(ring, 50, 52);
    recorder.stop();
    recorder.stop("twice");
    recorder.note("too late");
    recorder.pump();
    EXPECT_EQ(log_of(folder / "a.rec"), "0 1 2 3 4 5 6 7 ");
    EXPECT_EQ(log_of(folder / "b.rec"), "50 51 ");
}

TEST(Recorder, RejectsATooLongNote) {
    const auto file = fresh_folder("recorder_note") / "a.rec";
    SampleRing<servo::ServoSample> ring(8);
    Recorder recorder(ring);
    recorder.start(file, record_header(testing::kServo_hz), Mode::pumped);
    EXPECT_NE(error_text_of([&] { recorder.note(std::string(RecordWriter::kMaxNote + 1, ' ')); }),
              "");
    recorder.stop();
    EXPECT_EQ(log_of(file), "");
}

/// Waits for a condition set by another thread, at most a minute.
template <typename Condition> bool comes_true(Condition &&condition) {
    for (int i = 0; i < 60'000 && !condition(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return condition();
}

TEST(Recorder, WritesOnItsOwnThreadEvenWhenTheServoPauses) {
    const auto file = fresh_folder("recorder_thread") / "a.rec";
    SampleRing<servo::ServoSample> ring(1024);
    Recorder recorder(ring);
    recorder.start(file, record_header(10'000.0), Mode::own_thread);
    push(ring, 0, 7); // far less than a chunk of 200
    EXPECT_TRUE(comes_true([&] { return recorder.status().rows == 7; }));
    EXPECT_EQ(recorder.status().bytes, std::filesystem::file_size(file));
    recorder.note("paused");
    EXPECT_TRUE(comes_true(
        [&] { return recorder.status().bytes > expected_bytes(7, record_header(10'000.0)); }));
    push(ring, 7, 9);
    recorder.stop("end");
    EXPECT_EQ(log_of(file), "0 1 2 3 4 5 6 {paused} 7 8 {end} ");
}

// For the thread sanitizer: calls everything that may run concurrently.
TEST(Recorder, MayBeQueriedByAnyThread) {
    const auto file = fresh_folder("recorder_threads") / "a.rec";
    SampleRing<servo::ServoSample> ring(1U << 12U);
    Recorder recorder(ring);
    recorder.start(file, record_header(10'000.0), Mode::own_thread);
    std::atomic<bool> pushed{false};
    std::thread servo([&] {
        for (std::uint64_t tick = 0; tick < 5000; ++tick) {
            while (!ring.push(sample_at(tick))) {
                std::this_thread::yield();
            }
        }
        pushed = true;
    });
    std::uint64_t rows = 0;
    std::size_t notes = 0;
    while (!pushed) {
        const RecorderStatus status = recorder.status();
        EXPECT_GE(status.rows, rows);
        rows = status.rows;
        EXPECT_TRUE(recorder.is_recording());
        recorder.note("n");
        ++notes;
        std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    servo.join();
    recorder.stop();
    EXPECT_EQ(recorder.status().rows, 5000U);
    RecordReader reader(file);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.ending().rows, 5000U);
    EXPECT_EQ(reader.ending().notes, notes);
    EXPECT_EQ(reader.ending().missing_ticks, 0U);
}

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
            inputs.tuning.alpha_mode =
                static_cast<control::AlphaMode>(random() % control::kAlphaModeNames.size());
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

TEST(Replay, AnotherTuningGivesOtherVoltages) {
    control::Tuning stiffer;
    stiffer.K_P_V_per_rad = 15.0;
    Replay replay(testing::phantom_1_0(), stiffer);
    for (const servo::ServoSample &sample : one_run()) {
        static_cast<void>(replay.take(sample));
    }
    EXPECT_FALSE(replay.is_identical());
    EXPECT_EQ(replay.quantities()[0].differing, 0U); // θ is as it was
}

} // namespace
} // namespace springdrive::record
