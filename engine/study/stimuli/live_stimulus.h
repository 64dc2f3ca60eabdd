// A stimulus on the servo's own thread: presented and measured there, watched from another.
//
//   servo's thread:  update() after each tick ──► StimulusRun, DeliveryMeter
//   any other:       phase(), ended_s(), and, once it is over, delivered() and failure()
#pragma once

#include "base/latest_value.h"
#include "engine/servo/input_course.h"
#include "engine/study/stimuli/delivery_meter.h"
#include "engine/study/stimuli/stimulus_run.h"
#include "engine/study/stimuli/warm_up.h"

#include <atomic>

namespace springdrive::study {

class LiveStimulus final : public servo::InputCourse {
public:
    LiveStimulus(const device::DeviceDescription &device, const Stimulus &stimulus,
                 double period_s);

    /// Thread of the servo only. What was added is still taken back after the end.
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override;

    /// The tuning in contact from the next tick on: of an adjustment. One thread, not the servo's.
    void set_contact(const control::Tuning &tuning) noexcept { contact_.publish(tuning); }
    /// Ends the presentation with the next tick.
    void finish() noexcept { is_finished_.store(true, std::memory_order_release); }

    /// Whether the servo has taken it up: then it uses none before it any more.
    [[nodiscard]] bool has_begun() const { return has_begun_.load(std::memory_order_acquire); }
    [[nodiscard]] StimulusPhase phase() const { return phase_.load(std::memory_order_acquire); }
    [[nodiscard]] bool is_over() const {
        return phase() == StimulusPhase::done || phase() == StimulusPhase::failed;
    }

    // @pre of all below: is_over()

    [[nodiscard]] StimulusFailure failure() const { return run_.failure(); }
    [[nodiscard]] DeliveredStimulus delivered() const { return meter_.delivered(); }
    /// Of the presentation, by `ServoSample::clock_s`; in lockstep by its `time_s`. NaN if it never
    /// began.
    [[nodiscard]] double began_s() const { return began_s_; }
    [[nodiscard]] double ended_s() const { return ended_s_; }
    /// What the monitor said when it tripped.
    [[nodiscard]] const servo::SafetyStatus &trip() const { return trip_; }
    /// When it was seen, by the same clock; NaN without a failure.
    [[nodiscard]] double failed_s() const { return failed_s_; }

private:
    StimulusRun run_;
    DeliveryMeter meter_;
    double began_s_;
    double ended_s_;
    double failed_s_;
    servo::SafetyStatus trip_;
    LatestValue<control::Tuning> contact_;
    std::atomic<bool> is_finished_{false};
    std::atomic<bool> has_begun_{false};
    std::atomic<StimulusPhase> phase_{StimulusPhase::waiting};
};

// A warm-up on the servo's own thread, watched from another.

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
