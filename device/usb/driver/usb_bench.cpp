#include "device/usb/driver/usb_device.h"

#include "base/input_error.h"
#include "device/core/device_file.h"
#include "device/core/haptic_device.h"
#include "device/usb/driver/board_request.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace springdrive::usb {

using device::Fact;
using namespace std::chrono_literals;

namespace {

/// In which a board has stored a block: PROTOCOL.md, request 0x22.
constexpr auto kStoring = 50ms;

device::ChannelPulse pulse_of(const ChannelTest &test) {
    const auto has = [&](std::uint16_t finding) { return (test.findings & finding) != 0; };
    device::ChannelPulse pulse;
    pulse.resistance_Ohm = static_cast<double>(test.resistance_Ohm);
    pulse.inductance_H = static_cast<double>(test.inductance_H);
    for (std::size_t i = 0; i < kChannels; ++i) {
        pulse.moved_counts[i] = test.moved_counts[i];
    }
    pulse.is_open = has(ChannelFindings::kOpenWinding);
    pulse.has_reversed_sensor = has(ChannelFindings::kReversedSensor);
    pulse.has_crossed_sensor = has(ChannelFindings::kCrossedSensor);
    pulse.has_no_motion = has(ChannelFindings::kNoMotion);
    pulse.has_reversed_encoder = has(ChannelFindings::kReversedEncoder);
    pulse.has_crossed_encoder = has(ChannelFindings::kCrossedEncoder);
    pulse.is_at_limit = has(ChannelFindings::kLimit);
    return pulse;
}

const char *yes_or_no(bool is_so) { return is_so ? "yes" : "no"; }

std::string each(const Triple &values, const char *unit) {
    return fmt::format("{:.4g}, {:.4g}, {:.4g} {}", values[0], values[1], values[2], unit);
}

void add_identity(std::vector<Fact> &facts, const BoardStatus &board) {
    const Identity &identity = board.identity;
    facts.push_back({"board", fmt::format("{}, revision {}", text_of(identity.name),
                                          identity.hardware_revision)});
    facts.push_back({"serial number", text_of(identity.serial)});
    facts.push_back({"firmware", fmt::format("{}.{}.{}", identity.firmware[0], identity.firmware[1],
                                             identity.firmware[2])});
    facts.push_back(
        {"protocol", fmt::format("versions {} to {}, this program has {}", identity.oldest_version,
                                 identity.newest_version, kProtocolVersion)});
    facts.push_back({"connection", board.speed});
}

void add_capabilities(std::vector<Fact> &facts, const Capabilities &board) {
    const auto milli = [](float value) { return 1e3 * static_cast<double>(value); };
    facts.push_back({"amplifiers' loop", fmt::format("{} Hz", board.loop_rate_hz)});
    facts.push_back(
        {"actuation lag", fmt::format("{:.4g} us", 1e3 * milli(board.actuation_lag_s))});
    facts.push_back({"coupled channels", fmt::format("resistance {}, inductance {}",
                                                     yes_or_no(board.couples_resistance),
                                                     yes_or_no(board.couples_inductance))});
    facts.push_back(
        {"counts per turn", fmt::format("{}, {}, {}", board.counts_per_turn[0],
                                        board.counts_per_turn[1], board.counts_per_turn[2])});
    facts.push_back({"largest voltage", fmt::format("{:.4g} V", board.largest_e_W_V)});
    facts.push_back({"current limit", fmt::format("{:.4g} A", board.current_limit_A)});
    facts.push_back(
        {"current sensors", fmt::format("range {:.4g} A, resolution {:.4g} mA",
                                        board.current_range_A, milli(board.current_resolution_A))});
    facts.push_back({"largest cancelled R", each(board.largest_cancelled_Ohm, "Ohm")});
    facts.push_back(
        {"largest cancelled L", fmt::format("{:.4g} mH", milli(board.largest_cancelled_H))});
    facts.push_back({"supply must be", fmt::format("{:.4g} to {:.4g} V", board.smallest_supply_V,
                                                   board.largest_supply_V)});
    facts.push_back({"report periods", fmt::format("{} to {} us", board.shortest_report_period_us,
                                                   board.longest_report_period_us)});
    facts.push_back({"watchdog periods", fmt::format("{} to {} us", board.shortest_watchdog_us,
                                                     board.longest_watchdog_us)});
    facts.push_back(
        {"stop switch, enable line", fmt::format("{}, {}", yes_or_no(board.has_stop_switch),
                                                 yes_or_no(board.has_enable_line))});
}

void add_state(std::vector<Fact> &facts, const Report &now) {
    facts.push_back({"state", description_of(now.state)});
    facts.push_back({"faults", device::names_of(device::BoardFaults{now.faults})});
    facts.push_back({"stop switch pressed", yes_or_no(now.is_stopped)});
    facts.push_back({"enable line closed", yes_or_no(now.is_enabled)});
    facts.push_back({"supply", is_finite(now.supply_V) ? fmt::format("{:.2f} V", now.supply_V)
                                                       : "not measured"});
    static constexpr std::array<const char *, kTemperatures> kNames{"power stages", "motor 1",
                                                                    "motor 2", "motor 3"};
    for (std::size_t i = 0; i < kTemperatures; ++i) {
        if (is_finite(now.temperature_C[i])) {
            facts.push_back(
                {kNames[i], fmt::format("{:.1f} degrees Celsius", now.temperature_C[i])});
        }
    }
}

void add_counters(std::vector<Fact> &facts, const Counters &counters) {
    facts.push_back(
        {"commands accepted",
         fmt::format("{}", counters.frames[static_cast<std::size_t>(FrameStatus::ok)])});
    for (std::size_t i = 1; i < kFrameStatuses; ++i) {
        if (counters.frames[i] > 0) {
            facts.push_back(
                {fmt::format("commands with {}", description_of(static_cast<FrameStatus>(i))),
                 fmt::format("{}", counters.frames[i])});
        }
    }
    facts.push_back({"silences while driving", fmt::format("{}", counters.silences)});
    facts.push_back({"late loops", fmt::format("{}", counters.late_loops)});
    facts.push_back({"reports not collected", fmt::format("{}", counters.reports_replaced)});
}

constexpr double kDecikelvin_K = 0.1;
constexpr double kCentidegree_C = 0.01;

/// The numbers of a motor's calibration, in the order of its block.
std::array<device::CalibrationField, device::kCalibrationFields> numbers_of_block() {
    return device::calibration_fields({}, 0, 0.0);
}

MotorCalibrationBlock block_of_motor(const device::Calibration &calibration, std::size_t motor) {
    MotorCalibrationBlock block;
    block.air_error_dK = static_cast<std::uint8_t>(
        std::clamp(std::ceil(calibration.air_error_K / kDecikelvin_K - 1e-6), 1.0, 255.0));
    block.air_cC = static_cast<std::int16_t>(std::lround(calibration.air_C / kCentidegree_C));
    block.made_at_s = static_cast<std::uint32_t>(calibration.made_at_s);
    for (std::size_t i = 0; i < block.number.size(); ++i) {
        block.number[i] = static_cast<float>(calibration.motor[motor].*numbers_of_block()[i].value);
    }
    return block;
}

} // namespace

double UsbBench::shortest_pulse_s() const {
    constexpr double kMicrosecond_s = 1e-6; // rounding, of the order
    return static_cast<double>(kMinPulse_loops) /
               static_cast<double>(status_().capabilities.loop_rate_hz) +
           kMicrosecond_s;
}

void UsbBench::start_pulses(const device::PulseOrder &order) {
    const auto payload =
        encode(SelfTestOrder{static_cast<float>(order.voltage_V),
                             static_cast<std::uint32_t>(std::lround(1e6 * order.duration_s))});
    if (!port_.control_out(Kind::self_test, 0, payload)) {
        const BoardStatus board = status_();
        throw InputError(fmt::format(
            "{}: refuses test pulses of {:.3g} V and {:.3g} ms: it is {}; it takes them only while "
            "it brakes without faults, within limits of its own",
            board.name, order.voltage_V, 1e3 * order.duration_s,
            description_of(board.newest.state)));
    }
}

device::PulseResult UsbBench::pulses() {
    const auto board =
        ask<SelfTestResult>(port_, Kind::self_test, 0, status_().name, "test's result");
    device::PulseResult result;
    result.state = static_cast<device::PulseState>(board.state);
    static_assert(static_cast<int>(device::PulseState::aborted) ==
                  static_cast<int>(SelfTestState::aborted));
    for (std::size_t i = 0; i < kChannels; ++i) {
        result.channel[i] = pulse_of(board.channel[i]);
    }
    return result;
}

std::vector<Fact> UsbBench::facts() {
    const BoardStatus board = status_();
    std::vector<Fact> facts;
    add_identity(facts, board);
    add_state(facts, board.newest);
    add_capabilities(facts,
                     ask<Capabilities>(port_, Kind::capabilities, 0, board.name, "capabilities"));
    add_counters(facts, ask<Counters>(port_, Kind::counters, 0, board.name, "counters"));
    try {
        const std::optional<device::Calibration> stored = stored_calibration();
        facts.push_back({"calibration", stored ? device::text_of_utc(stored->made_at_s) : "none"});
    } catch (const InputError &error) {
        facts.push_back({"calibration", error.what()});
    }
    return facts;
}

CalibrationBlock UsbBench::kept_block(const BoardStatus &board, std::uint16_t index) {
    std::array<std::uint8_t, kCalibrationBlockSize> answer{};
    if (port_.control_in(Kind::calibration, index, answer) == 0) {
        throw InputError(board.name + ": could not store a calibration; unplug it to go on "
                                      "without, and keep the calibration in a file: springdrive "
                                      "device calibrate --out FILE");
    }
    return ask<CalibrationBlock>(port_, Kind::calibration, index, board.name, "calibration");
}

std::optional<device::Calibration> UsbBench::stored_calibration() {
    const BoardStatus board = status_();
    if (board.capabilities.calibration_blocks < kFirstMotorBlock + kChannels) {
        return std::nullopt;
    }
    const auto refuse = [&](const std::string &why) {
        throw InputError(fmt::format("{}: its stored calibration {}; calibrate it again: "
                                     "springdrive device calibrate --to-board",
                                     board.name, why));
    };
    device::Calibration calibration;
    calibration.serial = text_of(board.identity.serial);
    calibration.kind = "USB";
    std::size_t empty = 0;
    for (std::size_t motor = 0; motor < kChannels; ++motor) {
        const auto index = static_cast<std::uint16_t>(kFirstMotorBlock + motor);
        const CalibrationBlock block = kept_block(board, index);
        if (std::ranges::all_of(block.bytes, [](std::uint8_t byte) { return byte == 0; })) {
            ++empty;
            continue;
        }
        MotorCalibrationBlock contents;
        if (const FrameStatus status = calibration_in(block, contents); status != FrameStatus::ok) {
            refuse(fmt::format("has {} for motor {}", description_of(status), motor + 1));
        }
        if (empty > 0 || (motor > 0 && contents.made_at_s != calibration.made_at_s)) {
            refuse("is not complete");
        }
        calibration.made_at_s = contents.made_at_s;
        calibration.air_C = kCentidegree_C * contents.air_cC;
        calibration.air_error_K = kDecikelvin_K * contents.air_error_dK;
        for (std::size_t i = 0; i < contents.number.size(); ++i) {
            calibration.motor[motor].*numbers_of_block()[i].value =
                static_cast<double>(contents.number[i]);
        }
    }
    if (empty == kChannels) {
        return std::nullopt;
    }
    if (empty > 0) {
        refuse("is not complete");
    }
    return calibration;
}

void UsbBench::store(const device::Calibration &calibration) {
    const BoardStatus board = status_();
    for (std::size_t motor = 0; motor < kChannels; ++motor) {
        const auto index = static_cast<std::uint16_t>(kFirstMotorBlock + motor);
        const CalibrationBlock block = block_of(block_of_motor(calibration, motor), index);
        if (!port_.control_out(Kind::calibration, index, encode(block))) {
            throw InputError(fmt::format("{}: refuses a calibration: it is {}; it takes one only "
                                         "while it brakes, and has room for {} blocks",
                                         board.name, description_of(board.newest.state),
                                         board.capabilities.calibration_blocks));
        }
        std::this_thread::sleep_for(kStoring); // it stores in the background
        if (kept_block(board, index).bytes != block.bytes) {
            throw InputError(board.name +
                             ": does not keep a calibration; its firmware is at fault");
        }
    }
}

} // namespace springdrive::usb
