// A warm-up on the servo's own thread, watched from another.
#pragma once

#include "engine/servo/input_course.h"
#include "engine/study/stimuli/warm_up.h"

#include <atomic>

namespace springdrive::study {

class LiveWarmUp final : public servo::InputCourse {
public:
    LiveWarmUp(const device::DeviceDescription &device, const WindingBand &band, double period_s)
        : warm_up_(device, band, period_s) {}

    /// Thread of the servo only.
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override {
        if (!warm_up_.is_over()) {
            warm_up_.update(last, next);
            off_band_K_.store(warm_up_.off_band_K(), std::memory_order_relaxed);
            phase_.store(warm_up_.phase(), std::memory_order_release);
        }
    }

    [[nodiscard]] WarmUpPhase phase() const { return phase_.load(std::memory_order_acquire); }
    [[nodiscard]] bool is_over() const {
        return phase() == WarmUpPhase::done || phase() == WarmUpPhase::failed;
    }
    /// See WarmUp.
    [[nodiscard]] double off_band_K() const { return off_band_K_.load(std::memory_order_relaxed); }
    /// @pre is_over()
    [[nodiscard]] WarmUpFailure failure() const { return warm_up_.failure(); }

private:
    WarmUp warm_up_;
    std::atomic<double> off_band_K_{0.0};
    std::atomic<WarmUpPhase> phase_{WarmUpPhase::waiting};
};

} // namespace springdrive::study
