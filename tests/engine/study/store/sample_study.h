// A small study for tests, whose trials follow from a seed and their number alone.
#pragma once

#include "base/split_mix.h"
#include "engine/study/store/study_store.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::testing {

/// Numbers of SplitMix64, one after the other.
class Draws {
public:
    explicit Draws(std::uint64_t key) : key_(key) {}

    std::uint64_t bits() { return split_mix::value(key_, count_++); }
    /// 0 to `limit` - 1
    template <typename Integer> Integer below(Integer limit) {
        return static_cast<Integer>(bits() % static_cast<std::uint64_t>(limit));
    }
    bool coin() { return below(2) == 1; }

private:
    std::uint64_t key_;
    std::uint64_t count_ = 0;
};

inline constexpr study::UtcTime kStart{
    std::chrono::milliseconds(1'717'155'296'789)}; // 2024-05-31T11:34:56.789Z

[[nodiscard]] study::NewStudy sample_new_study();

/// A study with the participants P01, P02, ... and a session of each, all of the device kinds in
/// turn; without trials.
/// @return the file
std::filesystem::path sample_study(const std::filesystem::path &folder, int participants = 1);

[[nodiscard]] study::Session sample_session(int participant);

/// The trial of this number, from 1, of a participant: every field is set, with numbers that are
/// hard to store (-0, subnormal, infinite, of 17 digits), and of very different sizes. Every tenth
/// repeats the one before.
[[nodiscard]] study::Trial sample_trial(std::uint64_t seed, int participant, int number);

/// The trials of numbers 1 to `count`, as they are read: `repeated_by` is set, too.
[[nodiscard]] std::vector<study::Trial> sample_trials(std::uint64_t seed, int participant,
                                                      int count);

/// Whether they hold the same, numbers bit for bit.
[[nodiscard]] bool are_identical(const std::vector<study::Trial> &a,
                                 const std::vector<study::Trial> &b);

/// What is said when the file is read; empty if it can be.
[[nodiscard]] std::string said_on_reading(const std::filesystem::path &file);
/// The same when it is opened for writing.
[[nodiscard]] std::string said_on_opening(const std::filesystem::path &file);

} // namespace springdrive::testing
