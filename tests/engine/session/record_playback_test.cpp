// Covers engine/session/record_playback.cpp and record.cpp: every row of a record, whatever
// the file is; the playhead; answers that arrive, and what ends in the middle.
#include "engine/session/record_playback.h"

#include "engine/session/telemetry_history.h"
#include "tests/engine/record/samples.h"
#include "tests/engine/session/record_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::session {
namespace {

using Samples = std::vector<servo::ServoSample>;

constexpr double kForever = std::numeric_limits<double>::infinity();
constexpr std::size_t kAmple = RecordPlayback::kMaxBytes;

/// Made-up ticks at 1 kHz, from tick 100 on.
Samples made_up(std::size_t count) {
    Samples samples;
    for (std::size_t i = 0; i < count; ++i) {
        servo::ServoSample sample;
        sample.tick = 100 + i;
        sample.time_s = static_cast<double>(sample.tick) / testing::kRecorded_hz;
        sample.measurement_number = 7 + i;
        sample.since_last_s = 1e-3;
        sample.theta_rad[1] = 0.001 * static_cast<double>(i);
        samples.push_back(sample);
    }
    return samples;
}

using testing::plain_press;

Record record_from(const std::filesystem::path &file, double from_s = -kForever,
                   std::size_t max_bytes = kAmple) {
    BackgroundTalk talk;
    return load_record(file, from_s, max_bytes, talk);
}

std::string error_about(const std::filesystem::path &file, double from_s = -kForever) {
    return error_text_of([&] { static_cast<void>(record_from(file, from_s)); });
}

/// Frames until `is_so`; false after ten seconds.
template <typename Condition> bool wait_until(RecordPlayback &playback, Condition &&is_so) {
    for (int frame = 0; frame < 10'000 && !is_so(); ++frame) {
        playback.advance(0.0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return is_so();
}

bool wait_until_loaded(RecordPlayback &playback) {
    return wait_until(playback, [&] { return !playback.is_loading(); });
}

bool has_whole_answer(const RecordPlayback &playback) {
    return playback.answer() != nullptr && playback.asked() == playback.answered_tuning() &&
           playback.answer()->end() == playback.store().end();
}

/// A folder with records for all tests here.
class Playback : public ::testing::Test {
protected:
    [[nodiscard]] std::filesystem::path record_of(const Samples &samples,
                                                  const std::string &name = "touch.rec",
                                                  std::size_t note_after = 0) const {
        testing::write_samples(folder / name, samples, testing::header_of(), note_after);
        return folder / name;
    }

    std::filesystem::path folder = testing::fresh_folder("record_playback");
    RecordPlayback playback;
};

TEST_F(Playback, HasAllBitsOfEveryRow) {
    const Record record = record_from(record_of(plain_press()));
    ASSERT_EQ(record.store.end() - record.store.begin(), plain_press().size());
    TelemetryHistory history(record.device.geometry, testing::kRecorded_hz);
    for (std::size_t i = 0; i < plain_press().size(); ++i) {
        ASSERT_EQ(testing::row_of(sample_at(record.store, i)), testing::row_of(plain_press()[i]))
            << i;
        history.add(plain_press()[i]);
    }
    for (std::size_t channel = 0; channel < channels().size(); ++channel) {
        for (std::uint64_t row = 0; row < record.store.end(); row += 7) {
            const double value = record.store.value(channel, row);
            const double expected = history.store().value(channel, row);
            ASSERT_TRUE(value == expected || (std::isnan(value) && std::isnan(expected)))
                << channels()[channel].name << ' ' << row;
        }
    }
    EXPECT_FALSE(record.is_partial());
    EXPECT_EQ(record.device.name, testing::phantom_1_0().name);
    EXPECT_EQ(record.ending, "3000 rows, 1 note");
}

TEST_F(Playback, DerivedChannelsFollowTheRate) {
    Samples samples;
    for (std::size_t i = 0; i < 400; ++i) {
        const double t_s = i < 200 ? 1e-3 * static_cast<double>(i)
                                   : 0.199 + 0.25e-3 * static_cast<double>(i - 199);
        samples.push_back(plain_press()[1500 + i]);
        samples.back().time_s = 1000.0 + t_s;
    }
    const Record record = record_from(record_of(samples));
    TelemetryHistory history(record.device.geometry, testing::kRecorded_hz);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        history.set_rate(i < 200 ? 1000.0 : 4000.0);
        history.add(samples[i]);
    }
    const std::size_t channel = channel_named("transpose_measured_rad").value();
    const double last = record.store.value(channel, record.store.end() - 1);
    EXPECT_FALSE(std::isnan(last));
    EXPECT_EQ(last, history.store().value(channel, history.store().end() - 1));
}

TEST_F(Playback, WhatIsNoRecordIsRefusedAndTheOpenOneRemains) {
    playback.open(record_of(made_up(50)));
    ASSERT_TRUE(wait_until_loaded(playback));
    ASSERT_TRUE(playback.is_open());
    testing::write_file(folder / "text.rec", "This is no record.");
    testing::write_file(folder / "empty.rec", "");
    testing::write_samples(folder / "no_rows.rec", {});
    record::RecordHeader other = testing::header_of();
    other.device_toml = "name = 3";
    testing::write_samples(folder / "other_device.rec", made_up(5), other);
    other.device_toml = "";
    testing::write_samples(folder / "no_device.rec", made_up(5), other);
    std::filesystem::create_directory(folder / "folder.rec");
    for (const std::string name : {"text.rec", "empty.rec", "no_rows.rec", "other_device.rec",
                                   "no_device.rec", "folder.rec", "missing.rec"}) {
        playback.open(folder / name);
        ASSERT_TRUE(wait_until_loaded(playback));
        EXPECT_NE(playback.error().find(name), std::string::npos) << playback.error();
        EXPECT_EQ(playback.error().find('\n'), std::string::npos) << playback.error();
        ASSERT_TRUE(playback.is_open());
        EXPECT_EQ(playback.record().file, folder / "touch.rec");
        EXPECT_EQ(playback.sample().tick, 100U);
    }
    playback.open(folder / "touch.rec");
    EXPECT_TRUE(playback.error().empty());
}

TEST_F(Playback, ARecordWithoutAColumnIsRefused) {
    const std::string file = testing::contents_of(record_of(made_up(5)));
    std::string changed = file;
    const std::size_t at = changed.find("\"time_s\"");
    changed.replace(at, 8, "\"time_x\"");
    const std::size_t length = testing::number_at(changed, 8, 4);
    testing::write_file(folder / "old.rec", testing::header_bytes(changed.substr(12, length)) +
                                                changed.substr(16 + length));
    EXPECT_NE(error_about(folder / "old.rec").find("no column time_s"), std::string::npos);
}

TEST_F(Playback, ATruncatedRecordIsShownUpToItsEnd) {
    const std::string whole = testing::contents_of(record_of(made_up(200)));
    for (const std::size_t cut : {1U, 1000U, 20'000U}) {
        testing::write_file(folder / "cut.rec", whole.substr(0, whole.size() - cut));
        const Record record = record_from(folder / "cut.rec");
        EXPECT_LT(record.store.end(), 200U);
        EXPECT_EQ(record.store.end() % 20, 0U); // whole chunks
        EXPECT_NE(record.ending.find("cannot be used"), std::string::npos) << record.ending;
        EXPECT_FALSE(record.is_partial());
    }
}

TEST_F(Playback, OneRowIsARecord) {
    playback.open(record_of(made_up(1)));
    ASSERT_TRUE(wait_until_loaded(playback));
    playback.step(5);
    playback.step(-5);
    playback.seek(77.0);
    EXPECT_EQ(playback.sample().tick, 100U);
    playback.play(true);
    playback.advance(1.0);
    EXPECT_FALSE(playback.is_playing());
    playback.ask({});
    ASSERT_TRUE(wait_until(playback, [&] { return has_whole_answer(playback); }));
    EXPECT_EQ(playback.answered_sample()->tick, 100U);
}

TEST_F(Playback, MissingTicksAreAbsent) {
    Samples samples = made_up(300);
    samples.erase(samples.begin() + 100, samples.begin() + 200);
    playback.open(record_of(samples));
    ASSERT_TRUE(wait_until_loaded(playback));
    EXPECT_EQ(playback.store().end(), 200U);
    playback.seek(0.25); // within the gap: the row before it
    EXPECT_EQ(playback.sample().tick, 199U);
    playback.step(1);
    EXPECT_EQ(playback.sample().tick, 300U);
    playback.step(-1);
    EXPECT_EQ(playback.sample().tick, 199U);
    EXPECT_NE(playback.record().ending.find("100 samples lost"), std::string::npos);
}

TEST_F(Playback, RowsWhoseTimeDoesNotIncreaseAreLeftOut) {
    Samples samples = made_up(100);
    samples[20].time_s = std::nan("");
    samples[40].time_s = samples[39].time_s;
    samples[60].time_s = -3.0;
    samples[70].time_s = kForever;
    samples[80].tick = std::numeric_limits<std::uint64_t>::max();
    samples[81].measurement_number = std::uint64_t{1} << 60U;
    const Record record = record_from(record_of(samples));
    EXPECT_EQ(record.store.end(), 94U);
    EXPECT_NE(record.ending.find("left out: 6 rows"), std::string::npos) << record.ending;
    for (std::uint64_t row = 1; row < record.store.end(); ++row) {
        EXPECT_LT(record.store.time_s(row - 1), record.store.time_s(row));
    }
    for (servo::ServoSample &sample : samples) {
        sample.time_s = std::nan("");
    }
    EXPECT_NE(error_about(record_of(samples)).find("no usable rows"), std::string::npos);
}

TEST_F(Playback, ARandomRecordDoesNoHarm) {
    Samples samples = testing::random_samples(300, testing::kRecorded_hz, 1);
    for (servo::ServoSample &sample : samples) {
        sample.measurement_number %= 1000;
    }
    playback.open(record_of(samples));
    playback.ask({});
    ASSERT_TRUE(
        wait_until(playback, [&] { return playback.is_open() && has_whole_answer(playback); }));
    EXPECT_EQ(playback.store().end(), samples.size());
    for (std::uint64_t row = 0; row < samples.size(); ++row) {
        EXPECT_EQ(testing::row_of(sample_at(playback.store(), row)), testing::row_of(samples[row]));
    }
}

TEST_F(Playback, ARecordThatDoesNotFitIsLoadedInPart) {
    const std::filesystem::path file = record_of(plain_press(), "long.rec", 2500);
    constexpr std::size_t kLittle = std::size_t{2} << 20; // bytes
    const Record begin = record_from(file, -kForever, kLittle);
    EXPECT_TRUE(begin.is_partial());
    EXPECT_LT(begin.store.bytes(), 2 * kLittle);
    EXPECT_EQ(begin.times().first_s, 0.0);
    EXPECT_LT(begin.times().last_s, 2.5);
    EXPECT_EQ(begin.all.last_s, plain_press().back().time_s); // the total length is known
    EXPECT_EQ(begin.ending, "3000 rows, 1 note");
    const Record later = record_from(file, 0.5, kLittle);
    EXPECT_EQ(later.times().first_s, 0.5);
    EXPECT_EQ(sample_at(later.store, later.store.begin()).tick, 500U);
    EXPECT_TRUE(record_from(file, 2.9).is_partial());
    EXPECT_NE(error_about(file, 100.0).find("has no rows from 100 s on; it ends at 2.999 s"),
              std::string::npos);
    EXPECT_NE(error_about(file, std::nan("")), "");
}

TEST_F(Playback, ThePlayheadStaysWithinTheRows) {
    playback.open(record_of(made_up(1000)));
    ASSERT_TRUE(wait_until_loaded(playback));
    EXPECT_EQ(playback.position_s(), 0.1);
    playback.seek(-kForever);
    EXPECT_EQ(playback.sample().tick, 100U);
    playback.seek(kForever);
    EXPECT_EQ(playback.sample().tick, 1099U);
    playback.seek(std::nan(""));
    EXPECT_EQ(playback.sample().tick, 1099U);
    playback.seek(0.5004); // the last row until then
    EXPECT_EQ(playback.sample().tick, 500U);
    playback.step(3);
    EXPECT_EQ(playback.position_s(), 0.503);
    playback.step(-4);
    EXPECT_EQ(playback.sample().tick, 499U);
    playback.step(std::numeric_limits<int>::min());
    EXPECT_EQ(playback.sample().tick, 100U);
    playback.step(std::numeric_limits<int>::max());
    EXPECT_EQ(playback.sample().tick, 1099U);
}

TEST_F(Playback, PlaysBothWaysAndStopsAtTheEnds) {
    playback.play(true);
    EXPECT_FALSE(playback.is_playing()); // nothing is open
    playback.open(record_of(made_up(1001)));
    ASSERT_TRUE(wait_until_loaded(playback));
    playback.play(true);
    playback.advance(0.25);
    EXPECT_NEAR(playback.position_s(), 0.35, 1e-12);
    playback.set_speed(0.1);
    playback.advance(0.5);
    EXPECT_NEAR(playback.position_s(), 0.40, 1e-12);
    playback.set_speed(-2.0);
    playback.advance(0.05);
    EXPECT_NEAR(playback.position_s(), 0.30, 1e-12);
    playback.set_speed(std::nan(""));
    EXPECT_EQ(playback.speed(), -2.0);
    playback.advance(std::nan(""));
    playback.advance(10.0);
    EXPECT_FALSE(playback.is_playing());
    EXPECT_EQ(playback.position_s(), 0.1);
    playback.play(true); // backwards from the end
    EXPECT_EQ(playback.position_s(), 1.1);
    playback.set_speed(1e9);
    EXPECT_EQ(playback.speed(), RecordPlayback::kMaxSpeed);
    playback.advance(1.0);
    EXPECT_FALSE(playback.is_playing());
    EXPECT_EQ(playback.position_s(), 1.1);
    playback.set_speed(0.0);
    playback.play(true);
    playback.advance(1.0);
    EXPECT_TRUE(playback.is_playing());
    playback.step(1);
    EXPECT_FALSE(playback.is_playing());
    playback.close();
    playback.advance(0.1);
    EXPECT_FALSE(playback.is_open());
}

TEST_F(Playback, TheNewestOpenCounts) {
    for (int i = 0; i < 10; ++i) {
        playback.open(
            record_of(made_up(100 + static_cast<std::size_t>(i)), std::to_string(i) + ".rec"));
    }
    ASSERT_TRUE(wait_until_loaded(playback));
    EXPECT_EQ(playback.record().file, folder / "9.rec");
    EXPECT_EQ(playback.store().end(), 109U);
    playback.open(folder / "3.rec");
    playback.close();
    playback.advance(0.0);
    EXPECT_FALSE(playback.is_loading());
    EXPECT_FALSE(playback.is_open());
}

TEST_F(Playback, AnswersAreThoseOfTheTuningAskedFor) {
    playback.ask({}); // before there is a record
    playback.open(record_of(plain_press()));
    ASSERT_TRUE(
        wait_until(playback, [&] { return playback.is_open() && has_whole_answer(playback); }));
    control::Tuning other;
    other.K_P_V_per_rad = 2.0;
    playback.ask(other);
    control::Tuning invalid;
    invalid.dR_Ohm = std::nan("");
    playback.ask(invalid); // without effect
    ASSERT_TRUE(wait_until(playback, [&] { return has_whole_answer(playback); }));
    EXPECT_EQ(playback.answered_tuning(), other);
    WhatIf expected(testing::phantom_1_0(), 0.0, other);
    for (std::uint64_t row = 0; row < plain_press().size(); ++row) {
        ASSERT_EQ(playback.answer()->time_s(row), playback.store().time_s(row));
        ASSERT_EQ(testing::row_of(sample_at(*playback.answer(), row)),
                  testing::row_of(expected.of(plain_press()[row])));
    }
    playback.seek(1.7);
    EXPECT_EQ(playback.answered_sample()->tick, playback.sample().tick);
    playback.ask(other); // nothing new
    EXPECT_FALSE(playback.is_answering());
    playback.open(record_of(made_up(30), "other.rec"));
    ASSERT_TRUE(wait_until_loaded(playback));
    EXPECT_TRUE(playback.answer() == nullptr || has_whole_answer(playback)); // not of the old one
    ASSERT_TRUE(wait_until(playback, [&] { return has_whole_answer(playback); }));
    EXPECT_EQ(playback.answer()->end(), 30U);
    playback.stop_asking();
    EXPECT_EQ(playback.answer(), nullptr);
    EXPECT_FALSE(playback.answered_sample().has_value());
}

/// Long enough that what is around the playhead is answered first.
Samples long_press() {
    Samples samples;
    for (std::uint64_t tick = 0; tick < 25'000; ++tick) {
        samples.push_back(plain_press()[1200 + tick % 1000]);
        samples.back().tick = tick;
        samples.back().time_s = static_cast<double>(tick) / testing::kRecorded_hz;
    }
    return samples;
}

TEST_F(Playback, AnswersArriveWhileASliderMoves) {
    playback.open(record_of(long_press()));
    ASSERT_TRUE(wait_until_loaded(playback));
    playback.seek(12.0);
    control::Tuning tuning;
    control::Tuning last;
    int arrived = 0;
    for (int frame = 0; frame < 3000 && arrived < 5; ++frame) {
        tuning.K_P_V_per_rad = 1.0 + 0.001 * frame;
        playback.ask(tuning);
        playback.advance(1.0 / 60.0);
        if (playback.answer() != nullptr && playback.answered_tuning() != last) {
            last = playback.answered_tuning();
            ++arrived;
            EXPECT_TRUE(playback.answered_sample().has_value());
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(16));
    }
    EXPECT_EQ(arrived, 5);
    ASSERT_TRUE(wait_until(playback, [&] {
        return playback.answer() != nullptr && playback.answered_tuning() == tuning;
    }));
    const auto rows = playback.answer()->end();
    if (rows < playback.store().end()) { // the part around the playhead
        EXPECT_EQ(playback.answer()->time_s(0), 2.0);
        EXPECT_EQ(playback.answered_sample()->tick, 12'000U);
        playback.seek(1.0);
        EXPECT_FALSE(playback.answered_sample().has_value());
    }
    ASSERT_TRUE(wait_until(playback, [&] { return has_whole_answer(playback); }));
    EXPECT_TRUE(playback.answered_sample().has_value());
    EXPECT_TRUE(playback.error().empty());
}

TEST_F(Playback, AFileThatVanishesOrShrinksWhileItIsReadIsReadOrRefused) {
    for (const bool shrinks : {false, true}) {
        const std::filesystem::path file =
            record_of(long_press(), shrinks ? "shrinks.rec" : "vanishes.rec");
        playback.close();
        playback.open(file);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        if (shrinks) {
            std::filesystem::resize_file(file, 200'000);
        } else {
            std::filesystem::remove(file);
        }
        ASSERT_TRUE(wait_until_loaded(playback));
        EXPECT_TRUE(playback.is_open() || !playback.error().empty());
    }
}

TEST_F(Playback, EndsSoonAtAnyMoment) {
    const std::filesystem::path file = record_of(long_press());
    std::mt19937_64 random(2);
    const auto begin = std::chrono::steady_clock::now();
    for (int round = 0; round < 20; ++round) {
        auto one = std::make_unique<RecordPlayback>();
        one->open(file);
        for (std::uint64_t frames = random() % 40; frames > 0; --frames) {
            control::Tuning tuning;
            tuning.K_P_V_per_rad = 1.0 + static_cast<double>(random() % 3);
            one->advance(0.01);
            one->ask(tuning);
            if (random() % 30 == 0) {
                one->close();
                one->open(file, 10.0);
            } else if (random() % 30 == 0) {
                one->stop_asking();
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(random() % 20));
        }
    }
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    EXPECT_LT(passed.count(), 40.0); // some 4 s of it asleep
}

} // namespace
} // namespace springdrive::session
