#include "device/usb/board/link.h"

#include "device/usb/board/self_test.h"

namespace springdrive::board {

namespace {

using usb::FrameStatus;

bool is_at_rest(const LoopStatus &loop) {
    return loop.report.state != usb::BoardState::driving &&
           loop.report.state != usb::BoardState::testing;
}

template <class Value> std::size_t write(const Value &value, std::uint8_t *payload) {
    const auto bytes = usb::encode(value);
    static_assert(bytes.size() <= kMaxPayload);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        payload[i] = bytes[i];
    }
    return bytes.size();
}

template <class Value> bool read(const std::uint8_t *data, std::size_t size, Value &value) {
    return usb::decode(data, size, value) == FrameStatus::ok;
}

} // namespace

Link::Link(const BoardSettings &settings, const usb::Identity &identity)
    : settings_(settings), identity_(identity) {
    for (std::uint16_t index = 0; index < kCalibrationBlocks; ++index) {
        block_[index].index = index;
    }
    block_[0] = usb::block_of(orders_.calibration);
}

FrameStatus Link::receive(const std::uint8_t *data, std::size_t size, std::uint32_t arrived_at_us,
                          const LoopStatus &loop) {
    usb::Command command;
    if (const FrameStatus status = usb::decode(data, size, command); status != FrameStatus::ok) {
        return reject(status);
    }
    if (const FrameStatus status = check_number(command); status != FrameStatus::ok) {
        return reject(status);
    }
    if (const FrameStatus status = check_limits(command, settings_, loop.largest_cancelled_Ohm);
        status != FrameStatus::ok) {
        return reject(status);
    }
    has_number_ = true;
    ++counters_.frames[static_cast<std::size_t>(FrameStatus::ok)];
    ++orders_.command_changes;
    orders_.command = command;
    orders_.command_arrived_at_us = arrived_at_us;
    if (command.resets_faults) {
        ++orders_.reset_changes;
    }
    return FrameStatus::ok;
}

FrameStatus Link::check_number(const usb::Command &command) const {
    if (command.begins_numbering) {
        return FrameStatus::ok;
    }
    if (!has_number_) {
        return FrameStatus::stale;
    }
    const std::int32_t newer = usb::difference(command.number, orders_.command.number);
    return newer > 0 ? FrameStatus::ok : newer == 0 ? FrameStatus::repeated : FrameStatus::stale;
}

FrameStatus Link::reject(FrameStatus status) {
    ++counters_.frames[static_cast<std::size_t>(status)];
    ++rejected_frames_;
    last_rejection_ = status;
    return status;
}

bool Link::take_report(usb::Frame &frame, const LoopStatus &loop) {
    if (loop.reports == reports_taken_) {
        return false;
    }
    counters_.reports_replaced += loop.reports - reports_taken_ - 1U;
    reports_taken_ = loop.reports;
    usb::Report report = loop.report;
    report.last_rejection = last_rejection_;
    report.rejected_frames = rejected_frames_;
    frame = usb::encode(report);
    return true;
}

bool Link::control_out(std::uint8_t request, const std::uint8_t *data, std::size_t size,
                       const LoopStatus &loop) {
    if (request == static_cast<std::uint8_t>(usb::Kind::report_rate)) {
        usb::ReportRate rate;
        if (!read(data, size, rate) || rate.period_us < shortest_report_period_us()) {
            return false;
        }
        orders_.report_period_us = rate.period_us;
        return true;
    }
    if (!is_at_rest(loop)) {
        return false;
    }
    if (request == static_cast<std::uint8_t>(usb::Kind::zero)) {
        const bool is_read = read(data, size, orders_.zeroing);
        orders_.zeroing_changes += is_read ? 1U : 0U;
        return is_read;
    }
    if (request == static_cast<std::uint8_t>(usb::Kind::self_test)) {
        usb::SelfTestOrder order;
        if (!has_number_ || loop.report.state != usb::BoardState::braking || orders_.is_storing ||
            !read(data, size, order) || !SelfTest::accepts(order, settings_)) {
            return false;
        }
        orders_.self_test = order;
        ++orders_.self_test_changes;
        return true;
    }
    usb::CalibrationBlock block;
    return request == static_cast<std::uint8_t>(usb::Kind::calibration) && may_store() &&
           read(data, size, block) && write_block(block, true);
}

/// Storing may stop the loop: not after a command to drive, whether or not the loop has seen it.
bool Link::may_store() const { return !has_number_ || orders_.command.mode != usb::Mode::drive; }

bool Link::write_block(const usb::CalibrationBlock &block, bool must_store) {
    if (block.index >= kCalibrationBlocks) {
        return false;
    }
    if (block.index == 0) {
        usb::BoardCalibration calibration;
        if (usb::calibration_in(block, calibration) != FrameStatus::ok) {
            return false;
        }
        constexpr float kMaxRaise = 1.25F;
        for (std::size_t i = 0; i < kChannels; ++i) {
            if (calibration.largest_cancelled_Ohm[i] >
                kMaxRaise * settings_.largest_cancelled_Ohm[i]) {
                return false;
            }
        }
        orders_.calibration = calibration;
    }
    block_[block.index] = block;
    must_store_[block.index] = must_store;
    orders_.is_storing = orders_.is_storing || must_store;
    is_unstored_[block.index] = false;
    return true;
}

std::size_t Link::control_in(std::uint8_t request, std::uint16_t value, std::uint8_t *payload,
                             const LoopStatus &loop) const {
    switch (static_cast<usb::Kind>(request)) {
    case usb::Kind::identity:
        return write(identity_, payload);
    case usb::Kind::capabilities:
        return write(capabilities(loop), payload);
    case usb::Kind::counters:
        return write(counters(loop), payload);
    case usb::Kind::self_test:
        return write(loop.self_test, payload);
    case usb::Kind::calibration:
        return value < kCalibrationBlocks && !is_unstored_[value] ? write(block_[value], payload)
                                                                  : 0;
    default:
        return 0;
    }
}

void Link::disconnect() {
    has_number_ = false;
    ++orders_.disconnections;
}

void Link::load(const usb::CalibrationBlock &block) { (void)write_block(block, false); }

bool Link::take_block_to_store(usb::CalibrationBlock &block) {
    for (std::size_t i = 0; i < kCalibrationBlocks; ++i) {
        if (must_store_[i]) {
            must_store_[i] = false;
            block = block_[i];
            return true;
        }
    }
    return false;
}

void Link::end_store(std::uint16_t index, bool is_stored) {
    is_unstored_[index] = !is_stored;
    orders_.is_storing = false;
    for (const bool must_store : must_store_) {
        orders_.is_storing = orders_.is_storing || must_store;
    }
}

std::uint32_t Link::shortest_report_period_us() const {
    constexpr std::uint32_t kFullSpeedFrame_us = 1000;
    return is_high_speed_ || settings_.shortest_report_period_us > kFullSpeedFrame_us
               ? settings_.shortest_report_period_us
               : kFullSpeedFrame_us;
}

usb::Capabilities Link::capabilities(const LoopStatus &loop) const {
    usb::Capabilities board;
    board.couples_resistance = settings_.couples_channels;
    board.couples_inductance = settings_.couples_channels;
    board.cancels_inductance = true;
    board.measures_supply = settings_.measures_supply;
    board.has_stop_switch = settings_.has_stop_switch;
    board.has_enable_line = settings_.has_enable_line;
    board.measures_temperature = settings_.measures_temperature;
    board.is_high_speed = is_high_speed_;
    board.loop_rate_hz = settings_.loop_rate_hz;
    board.counts_per_turn = settings_.counts_per_turn;
    board.largest_e_W_V = settings_.largest_voltage_V;
    board.current_limit_A = settings_.current_limit_A;
    board.current_range_A = settings_.current_range_A;
    board.current_resolution_A = settings_.current_resolution_A;
    board.smallest_supply_V = settings_.smallest_supply_V;
    board.largest_supply_V = settings_.largest_supply_V;
    board.largest_cancelled_Ohm = loop.largest_cancelled_Ohm;
    board.largest_added_Ohm = settings_.largest_added_Ohm;
    board.largest_cancelled_H = settings_.largest_cancelled_H;
    board.largest_added_H = settings_.largest_added_H;
    board.lead_bandwidth_rad_per_s = settings_.lead_bandwidth_rad_per_s;
    board.actuation_lag_s = settings_.actuation_lag_periods * settings_.loop_period_s();
    board.shortest_report_period_us = shortest_report_period_us();
    board.calibration_blocks = kCalibrationBlocks;
    return board;
}

usb::Counters Link::counters(const LoopStatus &loop) const {
    usb::Counters counters = counters_;
    counters.silences = loop.silences;
    counters.late_loops = loop.late_loops;
    return counters;
}

} // namespace springdrive::board
