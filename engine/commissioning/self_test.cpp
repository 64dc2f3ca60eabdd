#include "engine/commissioning/self_test.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "device/core/haptic_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace springdrive::commissioning {

namespace {

/// Between two questions whether the pulses are over.
constexpr int kTicksBetweenLooks = 20;
/// At the start, for the board to clear latched faults, and to measure its sensors' offsets.
constexpr double kResetting_s = 0.2;
/// Each read waits for a report by itself.
constexpr int kMaxSilence_reads = 20;
/// Of an encoder, while nobody moves the device.
constexpr int kStillCounts = 2;

device::Bench &bench_of(device::HapticDevice &device) {
    device::Bench *const bench = device.bench();
    SPRINGDRIVE_ASSERT(bench != nullptr);
    return *bench;
}

Finding board_finding(const device::BoardFaults &faults) {
    return {Problem::board_fault, std::nullopt, "the board reports " + device::names_of(faults),
            "remove the cause; `springdrive device info` shows what it measures"};
}

/// What a board says of a winding that seems to generate while it brakes, as where a sensor or an
/// encoder is reversed or crossed. It goes on braking, so the test can go on, to name the cause.
bool says_disagreement(const device::BoardFaults &faults) {
    return (faults.bits & ~device::BoardFaults::kPressed) ==
           (device::BoardFaults::kOverCurrent | device::BoardFaults::kEncoder);
}

/// Of those that were measured in it, the largest.
double largest_A(const PulseRound &round) {
    double largest = 0.0;
    for (const device::ChannelPulse &channel : round.result.channel) {
        largest = std::fmax(largest, round.order.voltage_V / channel.resistance_Ohm); // not for NaN
    }
    return largest;
}

} // namespace

SelfTest::SelfTest(device::HapticDevice &device, const SelfTestOptions &options, Mover mover)
    : device_(device), bench_(bench_of(device)), options_(options), mover_(std::move(mover)),
      reset_(options.lets_go_on), motion_(device.description()) {
    SPRINGDRIVE_ASSERT(options.repeats >= 1);
    options_.pulse.duration_s = std::max(options.pulse.duration_s, bench_.shortest_pulse_s());
}

bool SelfTest::step() {
    if (stage_ == SelfTestStage::done) {
        return false;
    }
    const device::Measurement measured = device_.read();
    if (measured.health == device::DeviceHealth::lost) {
        throw InputError("the board does not answer any more; plug it in again, and begin anew");
    }
    require_news(measured);
    now_s_ = measured.time_s;
    counts_ = measured.counts;
    if (stage_began_s_ < 0.0) {
        stage_began_s_ = now_s_;
    }
    const bool is_resetting =
        stage_ == SelfTestStage::rest && now_s_ - stage_began_s_ < kResetting_s;
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.number = measured.number;
    command.resets_faults = reset_.may_follow(measured) && is_resetting;
    device_.write(command);
    ++ticks_;
    device::BoardFaults faults = measured.faults;
    if (reset_.has_stop()) {
        faults.bits |= device::BoardFaults::kStop;
    } else if (is_resetting) {
        return true;
    }
    if (stage_ == SelfTestStage::motion && says_disagreement(faults)) {
        disagreement_ = board_finding(faults);
    } else if (faults.any()) {
        faults_ = {board_finding(faults)};
        stage_ = SelfTestStage::done;
        return false;
    }
    switch (stage_) {
    case SelfTestStage::rest:
        rest(measured);
        break;
    case SelfTestStage::pulses:
        pulse();
        break;
    case SelfTestStage::motion:
        move(measured);
        break;
    case SelfTestStage::done:
        break;
    }
    return stage_ != SelfTestStage::done;
}

void SelfTest::require_news(const device::Measurement &measured) {
    silent_reads_ = device::is_new(measured.arrival) ? 0 : silent_reads_ + 1;
    if (silent_reads_ > kMaxSilence_reads) {
        throw InputError("the board sends no reports any more; plug it in again, and begin anew");
    }
}

/// A still device has no current: what sensors read then is their offset.
void SelfTest::rest(const device::Measurement &measured) {
    bool is_still = rest_ticks_ > 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto now = static_cast<std::int64_t>(measured.counts[i]);
        is_still = is_still && std::abs(now - rest_counts_[i]) <= kStillCounts;
    }
    if (!is_still) {
        rest_counts_ = measured.counts;
        rest_sum_A_ = Vector3::Zero();
        rest_ticks_ = 0;
    }
    rest_sum_A_ += measured.current_A;
    ++rest_ticks_;
    if (now_s_ - stage_began_s_ < kResetting_s + options_.rest_s) {
        return;
    }
    constexpr int kMinTicks = 100; // a tenth of the noise
    if (rest_ticks_ >= kMinTicks && rest_sum_A_.allFinite()) {
        motion_.set_offsets(rest_sum_A_ / rest_ticks_);
    }
    start_pulses();
    stage_ = SelfTestStage::pulses;
    stage_began_s_ = now_s_;
}

device::PulseOrder SelfTest::order() const {
    return {kPulseLevels[level_] * options_.pulse.voltage_V, options_.pulse.duration_s};
}

void SelfTest::start_pulses() {
    bench_.start_pulses(order());
    ticks_ = 0;
}

void SelfTest::pulse() {
    if (ticks_ % kTicksBetweenLooks != 0) {
        return;
    }
    const device::PulseResult result = bench_.pulses();
    if (result.state == device::PulseState::running) {
        return;
    }
    pulses_.push_back({order(), result});
    if (result.state != device::PulseState::completed) {
        faults_ = {{Problem::test_aborted, std::nullopt,
                    "the board ended its pulses before they were completed",
                    "hold the device still, and test again"}};
        stage_ = SelfTestStage::done;
        return;
    }
    ++level_;
    if (level_ == kPulseLevels.size() || largest_A(pulses_.back()) > kLastLevel_A) {
        level_ = 0;
        ++repeat_;
    }
    if (repeat_ < options_.repeats) {
        start_pulses();
        return;
    }
    motion_.set_windings(check_windings(device_.description(), pulses_));
    is_complete_ = !options_.has_motion;
    stage_ = options_.has_motion ? SelfTestStage::motion : SelfTestStage::done;
    stage_began_s_ = now_s_;
    if (mover_ && options_.has_motion) {
        options_.longest_motion_s =
            std::min(options_.longest_motion_s, mover_(options_.longest_motion_s));
    }
}

void SelfTest::move(const device::Measurement &measured) {
    motion_.take(measured);
    if (now_s_ - stage_began_s_ >= options_.longest_motion_s) {
        finish_motion();
    }
}

void SelfTest::finish_motion() {
    if (stage_ == SelfTestStage::motion) {
        is_complete_ = true;
        stage_ = SelfTestStage::done;
    }
}

Vector3 SelfTest::theta_rad() const {
    return device_.description().rad_per_count() * Vector3(counts_[0], counts_[1], counts_[2]);
}

std::string SelfTest::instruction() const {
    switch (stage_) {
    case SelfTestStage::rest:
    case SelfTestStage::pulses:
        return "hold the stylus loosely and do not move it: short pulses follow";
    case SelfTestStage::motion: {
        const std::string missing = motion_.missing();
        return missing.empty() ? "all stops were reached" : missing + ", slowly";
    }
    case SelfTestStage::done:
        break;
    }
    return "";
}

double SelfTest::share() const {
    switch (stage_) {
    case SelfTestStage::rest:
        return stage_began_s_ < 0.0 ? 0.0
                                    : std::min(1.0, (now_s_ - stage_began_s_) / options_.rest_s);
    case SelfTestStage::pulses:
        return (repeat_ + static_cast<double>(level_) / kPulseLevels.size()) / options_.repeats;
    case SelfTestStage::motion:
        return motion_.share();
    case SelfTestStage::done:
        break;
    }
    return 1.0;
}

namespace {

bool is_of_encoder(const Finding &finding) {
    return finding.problem == Problem::reversed_encoder ||
           finding.problem == Problem::crossed_encoders;
}

/// Then the board's report of it is a consequence.
bool explains_disagreement(const Finding &finding) {
    return is_of_encoder(finding) || finding.problem == Problem::reversed_sensor ||
           finding.problem == Problem::crossed_sensors;
}

} // namespace

SelfTestReport SelfTest::report() const {
    SelfTestReport report;
    report.is_complete = is_complete_;
    report.has_motion = is_complete_ && options_.has_motion;
    report.pulses = pulses_;
    report.findings = faults_;
    const auto add = [&](const std::vector<Finding> &more) {
        report.findings.insert(report.findings.end(), more.begin(), more.end());
    };
    if (!pulses_.empty()) {
        report.windings = check_windings(device_.description(), pulses_);
        add(report.windings.findings);
    }
    if (report.has_motion) {
        report.motion = motion_.report(device_.is_zeroed());
        // A pulse moves an encoder by some counts, which a hand may do, too: motion decides.
        std::erase_if(report.findings, is_of_encoder);
        add(report.motion.findings);
        if (disagreement_ && std::ranges::none_of(report.findings, explains_disagreement)) {
            report.findings.insert(report.findings.begin(), *disagreement_);
        }
        // R follows from the voltage.
        if (std::ranges::count(report.findings, Problem::wrong_voltage, &Finding::problem) > 0) {
            std::erase_if(report.findings, [](const Finding &finding) {
                return finding.problem == Problem::wrong_resistance;
            });
        }
    }
    return report;
}

} // namespace springdrive::commissioning
