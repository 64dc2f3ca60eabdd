#include "device/usb/board/self_test.h"

#include "device/usb/board/values.h"

namespace springdrive::board {

namespace {

std::int16_t saturated(std::int32_t counts) {
    constexpr std::int32_t kMax = 32767;
    const std::int32_t above = counts < -kMax ? -kMax : counts;
    return static_cast<std::int16_t>(above > kMax ? kMax : above);
}

/// An eighth of the shortest pulse, of usb::kMinPulse_loops, is 1 ms at 40 kHz: ten electrical
/// time constants.
std::uint64_t loops_of(const usb::SelfTestOrder &order, const BoardSettings &settings) {
    return static_cast<std::uint64_t>(order.pulse_us) * settings.loop_rate_hz / 1'000'000U;
}

std::int32_t magnitude_of(std::int32_t counts) { return counts < 0 ? -counts : counts; }

} // namespace

bool SelfTest::accepts(const usb::SelfTestOrder &order, const BoardSettings &settings) {
    const SelfTestLimits &limits = settings.self_test;
    return order.voltage_V > 0.0F && order.voltage_V <= limits.largest_voltage_V &&
           order.pulse_us <= limits.longest_pulse_us &&
           loops_of(order, settings) >= usb::kMinPulse_loops;
}

bool SelfTest::start(const usb::SelfTestOrder &order, const BoardSettings &settings) {
    if (!accepts(order, settings)) {
        return false;
    }
    *this = SelfTest();
    result_.state = usb::SelfTestState::running;
    voltage_V_ = order.voltage_V;
    pulse_loops_ = static_cast<std::uint32_t>(loops_of(order, settings));
    rest_loops_ = settings.loop_rate_hz / kRestShare_hz;
    return true;
}

std::int32_t SelfTest::moved(std::size_t encoder,
                             const std::array<std::int32_t, kChannels> &counts) const {
    return usb::difference(static_cast<std::uint32_t>(counts[encoder]),
                           static_cast<std::uint32_t>(counts_at_start_[encoder]));
}

bool SelfTest::is_beyond(const Triple &current_A, const std::array<std::int32_t, kChannels> &counts,
                         const SelfTestLimits &limits) const {
    for (std::size_t i = 0; i < kChannels; ++i) {
        const bool is_within = magnitude(current_A[i]) <= limits.abort_current_A &&
                               magnitude_of(moved(i, counts)) <= limits.abort_counts;
        if (!is_within) { // also for NaN
            return true;
        }
    }
    return false;
}

void SelfTest::begin_channel(const std::array<std::int32_t, kChannels> &counts) {
    positive_ = {};
    negative_ = {};
    after_change_A_ = 0.0F;
    counts_at_start_ = counts;
}

SelfTest::Step SelfTest::update(const Triple &current_A,
                                const std::array<std::int32_t, kChannels> &counts,
                                const BoardSettings &settings) {
    Step step;
    if (loop_ == 0) {
        begin_channel(counts);
    }
    if (is_beyond(current_A, counts, settings.self_test)) {
        result_.channel[channel_].findings |= usb::ChannelFindings::kLimit;
        result_.state = usb::SelfTestState::aborted;
        step.has_ended = true;
        return step;
    }
    if (loop_ < 2 * pulse_loops_) {
        add_currents(current_A);
        step.stage = {Stage::open, Stage::open, Stage::open};
        step.stage[channel_] = Stage::drive;
        step.voltage_V[channel_] = loop_ < pulse_loops_ ? voltage_V_ : -voltage_V_;
    }
    ++loop_;
    if (loop_ == 2 * pulse_loops_) {
        judge_channel(counts, settings);
    } else if (loop_ == 2 * pulse_loops_ + rest_loops_) {
        loop_ = 0;
        if (++channel_ == kChannels) {
            result_.state = usb::SelfTestState::completed;
            step.has_ended = true;
        }
    }
    return step;
}

/// Means are taken from 4/8 to 7/8 of the first pulse, and from 1/8 to 4/8 of the second, each of
/// them in halves: near the change of sign, and far from it.
void SelfTest::add_currents(const Triple &current_A) {
    const std::uint32_t eighth = pulse_loops_ / 8;
    const bool is_positive = loop_ < pulse_loops_;
    const std::uint32_t distance = is_positive ? pulse_loops_ - loop_ : loop_ - pulse_loops_;
    if (!is_positive && distance > 0 && distance <= eighth) {
        after_change_A_ += current_A[channel_];
    }
    if (distance > eighth && distance <= 4 * eighth) {
        Sums &sums = is_positive ? positive_ : negative_;
        Triple &sum_A = distance <= eighth + 3 * eighth / 2 ? sums.near_A : sums.far_A;
        for (std::size_t i = 0; i < kChannels; ++i) {
            sum_A[i] += current_A[i];
        }
    }
}

float SelfTest::mean_A(const Sums &sums, std::size_t channel) const {
    const std::uint32_t eighth = pulse_loops_ / 8;
    return (sums.near_A[channel] + sums.far_A[channel]) / static_cast<float>(3U * eighth);
}

/// Of the driven channel, at a distance from the change of sign in loops: the line through the
/// means of both halves.
float SelfTest::line_A(const Sums &sums, float distance) const {
    const std::uint32_t eighth = pulse_loops_ / 8;
    const std::uint32_t near_loops = 3 * eighth / 2;
    const std::uint32_t far_loops = 3 * eighth - near_loops;
    const float near_A = sums.near_A[channel_] / static_cast<float>(near_loops);
    const float far_A = sums.far_A[channel_] / static_cast<float>(far_loops);
    const float between = 0.5F * static_cast<float>(near_loops + far_loops); // of their middles
    const float near_at = static_cast<float>(eighth) + 0.5F * static_cast<float>(near_loops + 1U);
    return near_A + (far_A - near_A) * (distance - near_at) / between;
}

/// L/R, from what the current lags behind its line after the change of sign. The voltage changes
/// half a loop before the middle of its first action: for a change half a loop after a sample, the
/// sum of the lags is their integral, to (R T/L)²/24.
float SelfTest::time_constant_s(const BoardSettings &settings) const {
    const std::uint32_t eighth_loops = pulse_loops_ / 8;
    const auto eighth = static_cast<float>(eighth_loops);
    const float step_A = line_A(positive_, 0.0F) - line_A(negative_, 0.0F);
    const float lag_A = after_change_A_ - eighth * line_A(negative_, 0.5F * (eighth + 1.0F));
    const float loops = lag_A / step_A - (settings.actuation_lag_periods - 1.0F);
    return loops * settings.loop_period_s();
}

void SelfTest::judge_channel(const std::array<std::int32_t, kChannels> &counts,
                             const BoardSettings &settings) {
    using usb::ChannelFindings;
    usb::ChannelTest &test = result_.channel[channel_];
    const float expected_A = voltage_V_ / settings.winding[channel_].resistance_Ohm;
    const auto half_swing_A = [&](std::size_t i) {
        return 0.5F * (mean_A(positive_, i) - mean_A(negative_, i));
    };
    const float own_A = half_swing_A(channel_);
    if (magnitude(own_A) < 0.25F * expected_A) {
        test.findings |= ChannelFindings::kOpenWinding;
    } else {
        test.resistance_Ohm = voltage_V_ / magnitude(own_A);
        test.inductance_H = test.resistance_Ohm * time_constant_s(settings);
        test.findings |= own_A < 0.0F ? ChannelFindings::kReversedSensor : 0U;
    }
    std::size_t farthest = channel_;
    for (std::size_t i = 0; i < kChannels; ++i) {
        if (i != channel_ && magnitude(half_swing_A(i)) >= 0.25F * expected_A) {
            test.findings |= ChannelFindings::kCrossedSensor;
        }
        test.moved_counts[i] = saturated(moved(i, counts));
        if (magnitude_of(moved(i, counts)) > magnitude_of(moved(farthest, counts))) {
            farthest = i;
        }
    }
    if (magnitude_of(moved(farthest, counts)) < settings.self_test.min_counts) {
        test.findings |= ChannelFindings::kNoMotion;
    } else if (farthest != channel_) {
        test.findings |= ChannelFindings::kCrossedEncoder;
    } else if (moved(channel_, counts) < 0) {
        test.findings |= ChannelFindings::kReversedEncoder;
    }
}

} // namespace springdrive::board
