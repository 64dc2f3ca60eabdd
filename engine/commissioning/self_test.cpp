#include "engine/commissioning/self_test.h"

#include "base/assertions.h"
#include "base/input_error.h"
#include "device/core/board_faults.h"

#include <fmt/format.h>

#include <algorithm>

namespace springdrive::commissioning {

namespace {

/// Between two questions whether the pulses are over.
constexpr int kTicksBetweenLooks = 20;
/// After the last stop was reached, for the hand to come to rest.
constexpr int kLeastRepeats = 1;

device::Bench &bench_of(device::HapticDevice &device) {
    device::Bench *const bench = device.bench();
    SPRINGDRIVE_ASSERT(bench != nullptr);
    return *bench;
}

} // namespace

SelfTest::SelfTest(device::HapticDevice &device, const SelfTestOptions &options)
    : device_(device), bench_(bench_of(device)), options_(options), motion_(device.description()) {
    SPRINGDRIVE_ASSERT(options.repeats >= kLeastRepeats);
}

bool SelfTest::step() {
    if (stage_ == SelfTestStage::done) {
        return false;
    }
    const device::Measurement measured = device_.read();
    if (measured.health == device::DeviceHealth::lost) {
        throw InputError("the board does not answer any more; plug it in again, and begin anew");
    }
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.number = measured.number;
    device_.write(command);
    now_s_ = measured.time_s;
    if (stage_began_s_ < 0.0) {
        stage_began_s_ = now_s_;
    }
    ++ticks_;
    if (measured.faults.any()) {
        faults_ = {{Problem::board_fault, std::nullopt,
                    "the board reports " + device::names_of(measured.faults),
                    "remove the cause; `springdrive device info` shows what it measures"}};
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

void SelfTest::rest(const device::Measurement & /*measured*/) {
    if (now_s_ - stage_began_s_ >= options_.rest_s) {
        bench_.start_pulses(options_.pulse);
        stage_ = SelfTestStage::pulses;
        stage_began_s_ = now_s_;
        ticks_ = 0;
    }
}

void SelfTest::pulse() {
    if (ticks_ % kTicksBetweenLooks != 0) {
        return;
    }
    const device::PulseResult result = bench_.pulses();
    if (result.state == device::PulseState::running) {
        return;
    }
    pulses_.push_back(result);
    if (result.state == device::PulseState::completed && std::ssize(pulses_) < options_.repeats) {
        bench_.start_pulses(options_.pulse);
        return;
    }
    stage_ =
        result.state == device::PulseState::completed ? SelfTestStage::motion : SelfTestStage::done;
    stage_began_s_ = now_s_;
}

void SelfTest::move(const device::Measurement &measured) {
    motion_.take(measured);
    if (now_s_ - stage_began_s_ >= options_.longest_motion_s) {
        finish_motion();
    }
}

void SelfTest::finish_motion() {
    has_motion_ = true;
    stage_ = SelfTestStage::done;
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
        return static_cast<double>(pulses_.size()) / options_.repeats;
    case SelfTestStage::motion:
        return motion_.share();
    case SelfTestStage::done:
        break;
    }
    return 1.0;
}

SelfTestReport SelfTest::report() const {
    SelfTestReport report;
    report.is_complete = has_motion_;
    report.pulses = pulses_;
    report.findings = faults_;
    const auto add = [&](const std::vector<Finding> &more) {
        report.findings.insert(report.findings.end(), more.begin(), more.end());
    };
    if (!pulses_.empty()) {
        report.windings = check_windings(device_.description(), pulses_);
        add(report.windings.findings);
    }
    if (has_motion_) {
        report.motion = motion_.report(report.windings, device_.is_zeroed());
        add(report.motion.findings);
    }
    return report;
}

} // namespace springdrive::commissioning
