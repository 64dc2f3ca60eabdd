#include "engine/study/stimuli/live_stimulus.h"

#include <cmath>
#include <limits>

namespace springdrive::study {

namespace {

double clock_of(const servo::ServoSample &sample) {
    return std::isnan(sample.clock_s) ? sample.time_s : sample.clock_s;
}

} // namespace

LiveStimulus::LiveStimulus(const device::DeviceDescription &device, const Stimulus &stimulus,
                           double period_s)
    : run_(device, stimulus, period_s), meter_(device, stimulus, period_s),
      began_s_(std::numeric_limits<double>::quiet_NaN()), ended_s_(began_s_), failed_s_(began_s_),
      contact_(stimulus.contact) {}

void LiveStimulus::update(const servo::ServoSample &last, servo::LawInputs &next) noexcept {
    has_begun_.store(true, std::memory_order_release);
    const StimulusPhase before = run_.phase();
    run_.set_contact(contact_.latest());
    if (is_finished_.load(std::memory_order_acquire)) {
        run_.finish();
    }
    run_.update(last, next);
    if (before == StimulusPhase::done || before == StimulusPhase::failed) {
        return; // whoever waited for the end may be reading
    }
    meter_.take(last, run_);
    const StimulusPhase now = run_.phase();
    if (std::isnan(began_s_) && run_.presented_s() >= 0.0) {
        began_s_ = clock_of(last);
    }
    if (before == StimulusPhase::presenting) {
        ended_s_ = clock_of(last);
    }
    if (now == StimulusPhase::failed) {
        trip_ = last.safety;
        failed_s_ = clock_of(last);
    }
    phase_.store(now, std::memory_order_release);
}

} // namespace springdrive::study
