#include "app/study/sound/masking_noise.h"

#include "base/input_error.h"
#include "base/split_mix.h"

#include <fmt/core.h>
#include <portaudio.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <numbers>
#include <thread>
#include <unistd.h>

namespace springdrive::app {

namespace {

using Clock = std::chrono::steady_clock;

/// PortAudio and ALSA print what they try while they look for outputs. What a user has to know is
/// in our one line, so the standard error is closed to them for as long as they look.
class SilencedErrors {
public:
    SilencedErrors() : kept_(dup(STDERR_FILENO)) {
        std::fflush(stderr);
        const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (kept_ >= 0 && nowhere >= 0) {
            dup2(nowhere, STDERR_FILENO);
        }
        if (nowhere >= 0) {
            close(nowhere);
        }
    }
    ~SilencedErrors() {
        std::fflush(stderr);
        if (kept_ >= 0) {
            dup2(kept_, STDERR_FILENO);
            close(kept_);
        }
    }
    SilencedErrors(const SilencedErrors &) = delete;
    SilencedErrors &operator=(const SilencedErrors &) = delete;

private:
    int kept_ = -1;
};

[[noreturn]] void refuse(const std::string &problem) {
    throw InputError("masking noise: " + problem +
                     "; plug in headphones and choose them as the system's sound output, or give "
                     "--without-noise, which plays none");
}

/// @throw InputError if there is none
const PaDeviceInfo &default_output() {
    const PaDeviceIndex index = Pa_GetDefaultOutputDevice();
    const PaDeviceInfo *const info = index == paNoDevice ? nullptr : Pa_GetDeviceInfo(index);
    if (info == nullptr || info->maxOutputChannels < 1) {
        refuse("there is no sound output");
    }
    return *info;
}

} // namespace

PinkNoise::PinkNoise(double sample_rate_Hz, double level_dBFS) {
    const double deviation =
        std::pow(10.0, level_dBFS / 20.0) / std::sqrt(static_cast<double>(kProcesses));
    double rate_Hz = kFastest_Hz;
    for (Process &process : processes_) {
        process.keep = std::exp(-2.0 * std::numbers::pi * rate_Hz / sample_rate_Hz);
        process.renew = deviation * std::sqrt(1.0 - process.keep * process.keep);
        rate_Hz /= kRatio;
    }
    // The slowest takes a second to reach its variance from nothing; so each begins as it will be.
    for (Process &process : processes_) {
        double sum = 0.0; // of twelve uniform draws: near enough to normal for one value
        for (int i = 0; i < 12; ++i) {
            sum += split_mix::unit_share(split_mix::value(0, draws_++)) - 0.5;
        }
        process.value = deviation * sum;
    }
}

double PinkNoise::next() noexcept {
    double sum = 0.0;
    for (Process &process : processes_) {
        const double uniform = split_mix::unit_share(split_mix::value(0, draws_++)) - 0.5;
        const double unit = uniform * (2.0 * std::numbers::sqrt3); // variance 1
        process.value = process.keep * process.value + process.renew * unit;
        sum += process.value;
    }
    return sum;
}

void PinkNoise::fill(std::span<float> samples) noexcept {
    for (float &sample : samples) {
        sample = static_cast<float>(std::clamp(next(), -1.0, 1.0));
    }
}

/// Its address is known to the sound system's thread.
struct MaskingNoise::Output {
    /// The library, begun and ended in pairs.
    class PortAudio {
    public:
        PortAudio() {
            const SilencedErrors silenced;
            if (const PaError error = Pa_Initialize(); error != paNoError) {
                refuse(fmt::format("the sound system cannot be used ({})", Pa_GetErrorText(error)));
            }
        }
        ~PortAudio() {
            const SilencedErrors silenced;
            Pa_Terminate();
        }
        PortAudio(const PortAudio &) = delete;
        PortAudio &operator=(const PortAudio &) = delete;
    };

    explicit Output(double level_dBFS)
        : name(default_output().name), sample_rate_Hz(default_output().defaultSampleRate),
          channels(std::min(default_output().maxOutputChannels, 2)),
          noise(sample_rate_Hz, level_dBFS, std::chrono::duration<double>(kFade).count()) {
        const SilencedErrors silenced;
        const PaDeviceIndex index = Pa_GetDefaultOutputDevice();
        const PaStreamParameters parameters{
            index, channels, paFloat32, Pa_GetDeviceInfo(index)->defaultHighOutputLatency, nullptr};
        PaError error = Pa_OpenStream(&stream, nullptr, &parameters, sample_rate_Hz,
                                      paFramesPerBufferUnspecified, paNoFlag, &Output::fill, this);
        if (error == paNoError) {
            error = Pa_StartStream(stream);
        }
        if (error != paNoError) {
            close_stream();
            refuse(fmt::format("the sound output \"{}\" cannot be opened ({})", name,
                               Pa_GetErrorText(error)));
        }
    }
    ~Output() {
        noise.end();
        // What was asked for before the end is still played after the fade.
        if (is_playing()) {
            std::this_thread::sleep_for(kFade + latency());
        }
        close_stream();
    }
    Output(const Output &) = delete;
    Output &operator=(const Output &) = delete;

    [[nodiscard]] std::chrono::duration<double> latency() const {
        const PaStreamInfo *const info = Pa_GetStreamInfo(stream);
        return std::chrono::duration<double>(info == nullptr ? 0.0 : info->outputLatency);
    }
    [[nodiscard]] bool is_playing() const {
        constexpr std::chrono::milliseconds kMaxGap{500};
        const Clock::time_point requested{Clock::duration(last_requested.load())};
        return Pa_IsStreamActive(stream) == 1 && Clock::now() - requested < kMaxGap;
    }
    void close_stream() {
        const SilencedErrors silenced;
        if (stream != nullptr) {
            Pa_CloseStream(stream);
        }
    }

    /// On the sound system's thread: no allocation, no lock.
    static int fill(const void * /*input*/, void *to, unsigned long frames,
                    const PaStreamCallbackTimeInfo * /*times*/, PaStreamCallbackFlags flags,
                    void *self) {
        Output &output = *static_cast<Output *>(self);
        if ((flags & paOutputUnderflow) != 0) {
            output.underruns.fetch_add(1, std::memory_order_relaxed);
        }
        output.last_requested.store(Clock::now().time_since_epoch().count(),
                                    std::memory_order_relaxed);
        const auto channels = static_cast<std::size_t>(output.channels);
        const std::span<float> samples(static_cast<float *>(to), frames * channels);
        // The same in both ears: filled from the front, then spread from the back.
        output.noise.fill(samples.first(frames));
        for (std::size_t frame = frames; channels > 1 && frame-- > 0;) {
            const float sample = samples[frame];
            std::ranges::fill(samples.subspan(frame * channels, channels), sample);
        }
        return paContinue;
    }

    PortAudio library;
    std::string name;
    double sample_rate_Hz;
    int channels;
    FadedNoise noise;
    std::atomic<int> underruns{0};
    std::atomic<Clock::rep> last_requested{Clock::now().time_since_epoch().count()};
    PaStream *stream = nullptr;
};

MaskingNoise::MaskingNoise(double level_dBFS) : output_(std::make_unique<Output>(level_dBFS)) {}
MaskingNoise::~MaskingNoise() = default;
MaskingNoise::MaskingNoise(MaskingNoise &&) noexcept = default;
MaskingNoise &MaskingNoise::operator=(MaskingNoise &&) noexcept = default;

std::string MaskingNoise::device() const { return output_->name; }
bool MaskingNoise::is_playing() const { return output_->is_playing(); }
int MaskingNoise::underruns() const { return output_->underruns.load(std::memory_order_relaxed); }

} // namespace springdrive::app
