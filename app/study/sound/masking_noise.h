// Steady pink noise from the system's sound output, so that a device is not heard.
//
// It is generated as it is played, on the sound system's own thread, and knows nothing of trials:
// it begins and ends with the object, softly, and is the same in every session.
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace springdrive::app {

/// A claim on the sound output. For one thread.
class MaskingNoise {
public:
    static constexpr std::chrono::milliseconds kFade{500}; ///< of start and end

    /// Begins to play, on the default output.
    /// @param level_dBFS  RMS of full scale, as `study::MaskingNoise::level_dBFS`
    /// @throw InputError if there is no sound output or it cannot be opened, with what to do
    explicit MaskingNoise(double level_dBFS);
    /// Fades out, which takes `kFade`, and closes the output.
    ~MaskingNoise();
    MaskingNoise(MaskingNoise &&) noexcept;
    MaskingNoise &operator=(MaskingNoise &&) noexcept;

    /// Name of the output, as the sound system gives it.
    [[nodiscard]] std::string device() const;

    /// Whether sound has been asked for within the last half second: false after the output was
    /// lost, or the sound system has stopped.
    [[nodiscard]] bool is_playing() const;

    /// Gaps so far, where the system did not ask in time: a click each.
    [[nodiscard]] int underruns() const;

private:
    struct Output;
    std::unique_ptr<Output> output_;
};

} // namespace springdrive::app
