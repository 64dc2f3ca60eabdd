#include "device/usb/board/self_test.h"

#include "device/usb/board/matrix.h"

namespace springdrive::board {

namespace {

std::int16_t saturated(std::int32_t counts) {
    constexpr std::int32_t kLargest = 32767;
    const std::int32_t above = counts < -kLargest ? -kLargest : counts;
    return static_cast<std::int16_t>(above > kLargest ? kLargest : above);
}

/// An eighth of a pulse is then 1 ms at 40 kHz, ten electrical time constants.
constexpr std::uint64_t kFewestLoops = 320;

std::int32_t magnitude_of(std::int32_t counts) { return counts < 0 ? -counts : counts; }

} // namespace

bool SelfTest::start(const usb::SelfTestOrder &order, const BoardSettings &settings) {
    const SelfTestLimits &limits = settings.self_test;
    const std::uint64_t loops =
        static_cast<std::uint64_t>(order.pulse_us) * settings.loop_rate_hz / 1'000'000U;
    if (!(order.voltage_V > 0.0F && order.voltage_V <= limits.largest_voltage_V) ||
        order.pulse_us > limits.longest_pulse_us || loops < kFewestLoops) {
        return false;
    }
    *this = SelfTest();
    result_.state = usb::SelfTestState::running;
    voltage_V_ = order.voltage_V;
    pulse_loops_ = static_cast<std::uint32_t>(loops);
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
    positive_As_ = {};
    negative_As_ = {};
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

/// From 4/8 to 7/8 of the first pulse, and from 1/8 to 4/8 of the second.
void SelfTest::add_currents(const Triple &current_A) {
    const std::uint32_t eighth = pulse_loops_ / 8;
    const bool is_positive = loop_ < pulse_loops_;
    const std::uint32_t from_change = is_positive ? pulse_loops_ - loop_ : loop_ - pulse_loops_;
    if (from_change > eighth && from_change <= 4 * eighth) {
        Triple &sum_As = is_positive ? positive_As_ : negative_As_;
        for (std::size_t i = 0; i < kChannels; ++i) {
            sum_As[i] += current_A[i];
        }
    }
}

void SelfTest::judge_channel(const std::array<std::int32_t, kChannels> &counts,
                             const BoardSettings &settings) {
    using usb::ChannelFindings;
    usb::ChannelTest &test = result_.channel[channel_];
    const std::uint32_t eighth = pulse_loops_ / 8;
    const auto loops = static_cast<float>(3U * eighth);
    const float expected_A = voltage_V_ / settings.winding[channel_].resistance_Ohm;
    const auto half_swing_A = [&](std::size_t i) {
        return 0.5F * (positive_As_[i] - negative_As_[i]) / loops;
    };
    const float own_A = half_swing_A(channel_);
    if (magnitude(own_A) < 0.25F * expected_A) {
        test.findings |= ChannelFindings::kOpenWinding;
    } else {
        test.resistance_Ohm = voltage_V_ / magnitude(own_A);
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
    if (magnitude_of(moved(farthest, counts)) < settings.self_test.least_counts) {
        test.findings |= ChannelFindings::kNoMotion;
    } else if (farthest != channel_) {
        test.findings |= ChannelFindings::kCrossedEncoder;
    } else if (moved(channel_, counts) < 0) {
        test.findings |= ChannelFindings::kReversedEncoder;
    }
}

} // namespace springdrive::board
