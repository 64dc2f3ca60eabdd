// Covers app/study/sound/masking_noise.cpp: what the system's sound output is given, by an output
// of ALSA that writes to a file; and what is said where there is none.
#include "app/study/sound/masking_noise.h"

#include "base/input_error.h"
#include "tests/support/child_process.h"
#include "tests/support/files.h"

#include <fmt/core.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace springdrive::app {
namespace {

/// What is said, also by the libraries below, in a process that is prepared for it.
std::string in_child(const std::function<void()> &prepare,
                     const std::function<std::string()> &step) {
    return testing::said_in_child(prepare, [&step] {
        ::testing::internal::CaptureStderr();
        std::string said;
        try {
            said = step();
        } catch (const InputError &error) {
            said = error.what();
        }
        return said + ::testing::internal::GetCapturedStderr();
    });
}

TEST(MaskingNoise, WithoutASoundOutputSaysSoInALine) {
    const std::string said = in_child([] {},
                                      [] {
                                          const MaskingNoise noise(-80.0);
                                          return std::string("plays");
                                      });
    if (said == "plays") {
        GTEST_SKIP() << "this machine has a sound output";
    }
    EXPECT_EQ(said,
              "masking noise: there is no sound output; plug in headphones and choose them as "
              "the system's sound output, or give --without-noise, which plays none");
}

constexpr const char *kSystems = "/usr/share/alsa/alsa.conf"; ///< of the package libasound2-data

TEST(MaskingNoise, PlaysSoftlyBegunAndEndedAtItsLevel) {
    if (!std::filesystem::exists(kSystems)) {
        GTEST_SKIP() << kSystems << " is not there";
    }
    constexpr double kLevel_dBFS = -40.0;
    const std::filesystem::path folder = testing::fresh_folder("sound");
    const std::filesystem::path raw = folder / "played.raw";
    const std::filesystem::path configuration = folder / "asound.conf";
    std::ofstream(configuration) << fmt::format(
        "<{}>\npcm.!default {{ type file slave.pcm \"null\" file \"{}\" format "
        "\"raw\" }}\n",
        kSystems, raw.string());
    const std::string said =
        in_child([&] { setenv("ALSA_CONFIG_PATH", configuration.c_str(), 1); },
                 [] {
                     MaskingNoise noise(kLevel_dBFS);
                     std::this_thread::sleep_for(std::chrono::milliseconds(200));
                     const MaskingNoise moved(std::move(noise));
                     return moved.device() + (moved.is_playing() ? " plays" : " is silent");
                 });
    ASSERT_EQ(said, "default plays");
    const std::string bytes = testing::contents_of(raw);
    std::vector<float> samples(bytes.size() / sizeof(float)); // left and right
    std::memcpy(samples.data(), bytes.data(), samples.size() * sizeof(float));
    // That output takes sound as fast as it is made: many seconds in these 0.2, and silence while
    // the fade is waited for.
    while (!samples.empty() && samples.back() == 0.0F) {
        samples.pop_back();
    }
    constexpr std::size_t kFade = 48'000; // half a second of two channels at 48 kHz
    ASSERT_GT(samples.size(), 4 * kFade);
    double sum = 0.0;
    double loudest = 0.0;
    const std::size_t end = samples.size() - kFade;
    for (std::size_t i = 0; i + 1 < samples.size(); i += 2) {
        ASSERT_EQ(samples[i], samples[i + 1]) << "the same in both ears";
        const auto sample = static_cast<double>(samples[i]);
        sum += i >= kFade && i < end ? 2.0 * sample * sample : 0.0;
        loudest = std::max(loudest, std::abs(sample));
    }
    const double level_dBFS = 10.0 * std::log10(sum / static_cast<double>(end - kFade));
    EXPECT_NEAR(level_dBFS, kLevel_dBFS, 1.0) << "some seconds; exactly in pink_noise_test.cpp";
    // Soft at both ends: a thousandth of the amplitude and less in the first and last millisecond.
    const double amplitude = std::pow(10.0, kLevel_dBFS / 20.0);
    for (std::size_t i = 0; i < 88; ++i) {
        EXPECT_LT(std::abs(samples[i]), 1e-3 * amplitude) << i;
        EXPECT_LT(std::abs(samples[samples.size() - 1 - i]), 1e-3 * amplitude) << i;
    }
    EXPECT_GT(loudest, 2.0 * amplitude) << "and not in between";
}

} // namespace
} // namespace springdrive::app
