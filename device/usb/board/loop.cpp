#include "device/usb/board/loop.h"

namespace springdrive::board {

namespace {

using usb::Faults;

bool is_due(std::uint32_t now_us, std::uint32_t due_us) {
    return usb::difference(now_us, due_us) >= 0;
}

} // namespace

Loop::Loop(const BoardSettings &settings)
    : settings_(settings), loop_period_us_(1e6F * settings.loop_period_s()),
      lag_s_(settings.actuation_lag_periods * settings.loop_period_s()), balances_(settings),
      amplifier_(settings) {
    for (std::size_t i = 0; i < kChannels; ++i) {
        heat_[i] =
            WindingHeat(settings.winding[i], settings.gain_tolerance, settings.motors_start_cold);
    }
}

BridgeOrder Loop::tick(const Samples &samples, const Orders &orders,
                       Published<LoopStatus> &status) {
    take_time(samples);
    measure(samples);
    check_fast(samples);
    if (loops_ % kSlowLoops == 0) {
        check_slow(samples);
    }
    take_orders(orders);
    check_watchdog();
    const BridgeOrder bridge = order(samples);
    note_application();
    report_when_due(samples, status);
    ++loops_;
    return bridge;
}

void Loop::take_time(const Samples &samples) {
    if (!has_time_) {
        has_time_ = true;
        report_due_us_ = samples.time_us;
        checked_at_us_ = samples.time_us;
    } else {
        passed_us_ = samples.time_us - time_us_;
        const auto passed_us = static_cast<float>(passed_us_);
        if (passed_us > 1.5F * loop_period_us_) {
            ++late_loops_;
            has_gap_ = true;
            if (passed_us > static_cast<float>(kLatestLoop) * loop_period_us_) {
                passed_us_ = 0;
                forget_lower_heat();
                if (state_ == State::driving) {
                    raise(Faults::kOverrun);
                }
            }
        }
    }
    time_us_ = samples.time_us;
}

void Loop::measure(const Samples &samples) {
    const usb::BoardCalibration &calibration = seen_.calibration;
    for (std::size_t i = 0; i < kChannels; ++i) {
        if (!encoder_[i].update(samples.encoder[i], settings_.largest_count_step)) {
            if ((faults_ & Faults::kEncoder) == 0) {
                renumber_counts(); // a host that misses the fault's reports shall know
            }
            raise(Faults::kEncoder);
        }
        counts_[i] = encoder_[i].counts(calibration.encoder_sign[i]);
        current_A_[i] =
            calibration.current_gain[i] * (samples.current_A[i] - offsets_.offset_A()[i]);
        square_sum_A2us_[i] += current_A_[i] * current_A_[i] * static_cast<float>(passed_us_);
    }
    if (has_gap_) {
        amplifier_.forget(current_A_);
        balances_.spoil();
        has_gap_ = false;
    } else {
        amplifier_.observe(current_A_);
    }
    summed_us_ += passed_us_;
    if (state_ == State::starting) {
        switch (offsets_.update(samples.current_A, settings_.largest_offset_A)) {
        case CurrentOffsets::Progress::measuring:
            break;
        case CurrentOffsets::Progress::failed:
            raise(Faults::kSensor);
            break;
        case CurrentOffsets::Progress::ready:
            amplifier_.forget({});
            handle(Event::offsets_ready);
            break;
        }
    }
}

void Loop::check_fast(const Samples &samples) {
    constexpr float kNearRange = 0.98F;
    bool is_over = false;
    present_ &= static_cast<std::uint16_t>(
        ~(Faults::kAmplifier | Faults::kSensor | Faults::kStop | Faults::kOverCurrent));
    for (std::size_t i = 0; i < kChannels; ++i) {
        if (!usb::is_finite(samples.current_A[i])) {
            raise(Faults::kSensor);
            current_A_[i] = 0.0F; // nothing below may see it
            square_sum_A2us_[i] = 0.0F;
            amplifier_.forget(current_A_);
            balances_.spoil();
        } else {
            is_over = is_over || magnitude(current_A_[i]) > settings_.current_trip_A ||
                      magnitude(samples.current_A[i]) > kNearRange * settings_.current_range_A;
        }
    }
    over_current_loops_ = is_over ? static_cast<std::uint8_t>(over_current_loops_ + 1U) : 0U;
    if (over_current_loops_ >= kConfirmingLoops) {
        over_current_loops_ = kConfirmingLoops;
        raise(Faults::kOverCurrent);
    }
    if (samples.stage_failed) {
        raise(Faults::kAmplifier);
    }
    if ((settings_.has_stop_switch && samples.is_stopped) ||
        (settings_.has_enable_line && !samples.is_enabled)) {
        raise(Faults::kStop);
    }
    check_braking(samples);
}

void Loop::check_braking(const Samples &samples) {
    const bool is_hard = over_current_loops_ >= kConfirmingLoops &&
                         (state_ == State::braking || state_ == State::fault_braking);
    if (!is_hard) {
        is_braking_hard_ = false;
    } else if (!is_braking_hard_) {
        is_braking_hard_ = true;
        braked_since_us_ = samples.time_us;
    } else if (samples.time_us - braked_since_us_ > kBrakingTime_us) {
        raise(Faults::kAmplifier);
    }
}

void Loop::check_slow(const Samples &samples) {
    present_ &= static_cast<std::uint16_t>(~(Faults::kSupply | Faults::kTemperature |
                                             Faults::kHeat | Faults::kEncoder | Faults::kOverrun));
    const bool is_supplied = !settings_.measures_supply ||
                             (samples.supply_V >= settings_.smallest_supply_V &&
                              samples.supply_V <= settings_.largest_supply_V); // not for NaN
    supply_loops_ = is_supplied ? 0U : static_cast<std::uint8_t>(supply_loops_ + 1U);
    if (supply_loops_ >= kConfirmingLoops) {
        supply_loops_ = kConfirmingLoops;
        raise(Faults::kSupply);
    }
    for (std::size_t i = 0; i < usb::kTemperatures; ++i) {
        if (settings_.measures_temperature[i] &&
            !(samples.temperature_C[i] <= settings_.largest_temperature_C[i])) {
            raise(Faults::kTemperature);
        }
    }
    check_timer();
    if (balances_.update(current_A_, counts_) &&
        (faults_ & Faults::kGenerating) != Faults::kGenerating) {
        if ((faults_ & Faults::kEncoder) == 0) {
            renumber_counts();
        }
        raise(Faults::kGenerating);
    }
    heat_windings();
    for (const WindingHeat &heat : heat_) {
        if (heat.is_too_hot()) {
            raise(Faults::kHeat);
        }
    }
}

/// Time-outs, reports and heat go by a timer of the chip: where it stands still, or is slow,
/// nothing else would notice.
void Loop::check_timer() {
    constexpr float kLoops = kSlowLoops;
    const std::uint32_t passed_us = time_us_ - checked_at_us_;
    checked_at_us_ = time_us_;
    if (loops_ > 0 && static_cast<float>(passed_us) < kSlowestTimer * kLoops * loop_period_us_) {
        forget_lower_heat();
        raise(Faults::kOverrun);
    }
}

void Loop::heat_windings() {
    if (summed_us_ < WindingHeat::kPeriod_us) {
        return;
    }
    for (std::size_t i = 0; i < kChannels; ++i) {
        heat_[i].update(square_sum_A2us_[i] / static_cast<float>(WindingHeat::kPeriod_us));
    }
    square_sum_A2us_ = {};
    summed_us_ -= WindingHeat::kPeriod_us;
}

void Loop::forget_lower_heat() {
    for (WindingHeat &heat : heat_) {
        heat.forget_lower();
    }
}

void Loop::raise(std::uint16_t fault) {
    present_ = static_cast<std::uint16_t>(present_ | fault);
    faults_ = static_cast<std::uint16_t>(faults_ | fault);
    handle((fault & kOpeningFaults) != 0 ? Event::opening_fault : Event::braking_fault);
}

void Loop::handle(Event event) {
    const State next = next_state(state_, event);
    if (state_ == State::testing && next != State::testing) {
        self_test_.abort(); // unless it has ended by itself
    }
    if (next == State::starting && state_ != State::starting) {
        offsets_.restart();
    }
    state_ = next;
}

void Loop::request_reset() {
    if (present_ == 0) {
        faults_ = 0;
        balances_.reset();
        handle(Event::reset);
    }
}

void Loop::take_orders(const Orders &orders) {
    if (orders.changes == seen_.changes) {
        return;
    }
    if (orders.command_changes != seen_.command_changes) {
        take_command(orders);
    }
    take_requests(orders);
    // USB code refuses a calibration while the board drives, but may not know yet that it does.
    const bool may_calibrate = state_ != State::driving && state_ != State::testing;
    const usb::BoardCalibration calibration =
        may_calibrate ? orders.calibration : seen_.calibration;
    if (calibration.encoder_sign != seen_.calibration.encoder_sign) {
        renumber_counts();
    }
    seen_ = orders;
    seen_.calibration = calibration;
}

/// Counts are others now than those that a host may know.
void Loop::renumber_counts() {
    if (has_command_) {
        zeroings_ = static_cast<std::uint8_t>((zeroings_ + 1U) & 15U);
    }
}

void Loop::take_command(const Orders &orders) {
    has_command_ = true;
    is_silent_ = false;
    is_applied_ = false;
    drive_ = drive_settings(orders.command, lag_s_);
    if (may_rephase_ && orders.command.report_after_us != usb::kKeepPhase) {
        report_due_us_ = orders.command_arrived_at_us + orders.command.report_after_us;
        may_rephase_ = false;
    }
    switch (orders.command.mode) {
    case usb::Mode::brake:
        handle(Event::command_brake);
        break;
    case usb::Mode::drive:
        handle(orders.is_storing ? Event::command_brake : Event::command_drive);
        break;
    case usb::Mode::open:
        handle(Event::command_open);
        break;
    }
}

void Loop::take_requests(const Orders &orders) {
    if (orders.reset_changes != seen_.reset_changes) {
        request_reset();
    }
    const bool is_at_rest = state_ != State::driving && state_ != State::testing;
    if (orders.zeroing_changes != seen_.zeroing_changes && is_at_rest) {
        for (std::size_t i = 0; i < kChannels; ++i) {
            const std::int8_t sign = seen_.calibration.encoder_sign[i];
            encoder_[i].declare(orders.zeroing.counts[i], sign);
            counts_[i] = encoder_[i].counts(sign);
        }
        zeroings_ = static_cast<std::uint8_t>((zeroings_ + 1U) & 15U);
    }
    if (orders.self_test_changes != seen_.self_test_changes && state_ == State::braking &&
        !orders.is_storing && self_test_.start(orders.self_test, settings_)) {
        handle(Event::test_started);
    }
    if (orders.disconnections != seen_.disconnections) {
        note_silence();
    }
}

void Loop::check_watchdog() {
    const std::int32_t age_us = usb::difference(time_us_, seen_.command_arrived_at_us);
    is_silent_ = is_silent_ || age_us > seen_.command.watchdog_us; // until the next command
    if (is_silent_) {
        note_silence();
    }
}

void Loop::note_silence() {
    if (state_ == State::driving || state_ == State::testing) {
        ++silences_;
        faults_ = static_cast<std::uint16_t>(faults_ | Faults::kNoCommand);
        handle(Event::silence);
    }
}

float Loop::usable_V(float supply_V) const {
    const float available_V = settings_.largest_duty_ratio * supply_V;
    return available_V < settings_.largest_voltage_V ? available_V : settings_.largest_voltage_V;
}

BridgeOrder Loop::order(const Samples &samples) {
    const float measured_V =
        settings_.measures_supply ? samples.supply_V : settings_.nominal_supply_V;
    // Below the least it is a fault, perhaps of its sensor only: voltages must not rise by it.
    const float supply_V =
        measured_V < settings_.smallest_supply_V ? settings_.smallest_supply_V : measured_V;
    const BridgeOrder order = order_of_state(supply_V);
    Triple voltage_V{};
    for (std::size_t i = 0; i < kChannels; ++i) {
        voltage_V[i] = order.duty_ratio[i] * supply_V; // 0 of stages that are not driven
    }
    amplifier_.apply(voltage_V);
    return order;
}

BridgeOrder Loop::order_of_state(float supply_V) {
    balances_.apply(state_ == State::driving ? drive_ : DriveSettings());
    switch (state_) {
    case State::driving:
        return order_of_drive(supply_V);
    case State::testing:
        balances_.spoil();
        return order_of_test(supply_V);
    case State::starting:
    case State::opened:
    case State::fault_open:
        balances_.spoil();
        return BridgeOrder::opening();
    case State::braking:
    case State::fault_braking:
        break;
    }
    return BridgeOrder::braking();
}

BridgeOrder Loop::order_of_drive(float supply_V) {
    std::uint8_t acting = 0;
    const Triple voltage_V =
        amplifier_.limited_V(amplifier_.voltage_V(drive_), usable_V(supply_V), acting);
    if ((acting & usb::ActingLimits::kVoltage) != 0) {
        balances_.spoil();
    }
    acting_ |= acting;
    BridgeOrder order;
    for (std::size_t i = 0; i < kChannels; ++i) {
        order.stage[i] = Stage::drive;
        order.duty_ratio[i] = voltage_V[i] / supply_V;
    }
    return checked(order);
}

BridgeOrder Loop::order_of_test(float supply_V) {
    const SelfTest::Step step = self_test_.update(current_A_, counts_, settings_);
    if (step.has_ended) {
        handle(Event::test_ended);
        return BridgeOrder::braking();
    }
    BridgeOrder order;
    order.stage = step.stage;
    for (std::size_t i = 0; i < kChannels; ++i) {
        order.duty_ratio[i] = step.voltage_V[i] / supply_V;
    }
    return checked(order);
}

/// The last barrier before the bridge. Limits have acted; what is beyond them, or not a number,
/// comes from a supply that is not known.
BridgeOrder Loop::checked(BridgeOrder order) {
    constexpr float kRounding = 1e-5F;
    const float largest = settings_.largest_duty_ratio;
    for (float &duty_ratio : order.duty_ratio) {
        if (!(magnitude(duty_ratio) <= largest + kRounding)) {
            raise(Faults::kSupply);
            return BridgeOrder::braking();
        }
        duty_ratio = duty_ratio > largest ? largest : duty_ratio;
        duty_ratio = duty_ratio < -largest ? -largest : duty_ratio;
    }
    return order;
}

/// Applied: its voltages act, or it brakes or opens. A command that a fault overrides is not.
void Loop::note_application() {
    if (is_applied_ || !has_command_) {
        return;
    }
    const usb::Mode mode = seen_.command.mode;
    const bool obeys = (mode == usb::Mode::drive && state_ == State::driving) ||
                       (mode == usb::Mode::brake &&
                        (state_ == State::braking || state_ == State::fault_braking)) ||
                       (mode == usb::Mode::open && state_ == State::opened);
    if (obeys) {
        is_applied_ = true;
        // Its action begins half a period before the middle of it.
        const float begins_us = 1e6F * lag_s_ - 0.5F * loop_period_us_;
        const std::uint32_t after_us =
            time_us_ + (begins_us > 0.0F ? static_cast<std::uint32_t>(begins_us) : 0U) -
            seen_.command_arrived_at_us;
        applied_after_us_ =
            static_cast<std::uint16_t>(after_us < usb::kNotApplied ? after_us : usb::kNotApplied);
    }
}

void Loop::report_when_due(const Samples &samples, Published<LoopStatus> &status) {
    if (!is_due(time_us_, report_due_us_)) {
        return;
    }
    report_due_us_ += seen_.report_period_us;
    if (is_due(time_us_, report_due_us_)) { // the loop stood still: no burst
        report_due_us_ = time_us_ + seen_.report_period_us;
    }
    may_rephase_ = true;
    ++reports_;
    LoopStatus &now = status.draft();
    now.reports = reports_;
    now.self_test = self_test_.result();
    now.silences = silences_;
    now.late_loops = late_loops_;
    for (std::size_t i = 0; i < kChannels; ++i) {
        const float cold_Ohm = seen_.calibration.largest_cancelled_Ohm[i] > 0.0F
                                   ? seen_.calibration.largest_cancelled_Ohm[i]
                                   : settings_.largest_cancelled_Ohm[i];
        now.largest_cancelled_Ohm[i] = cold_Ohm * heat_[i].certain_rise();
    }
    fill_in(now.report, samples);
    acting_ = 0;
    status.publish_draft();
}

void Loop::fill_in(usb::Report &report, const Samples &samples) const {
    report.number = reports_;
    report.measured_at_us = time_us_;
    report.counts = counts_;
    for (std::size_t i = 0; i < kChannels; ++i) {
        report.current_A[i] = usb::is_finite(samples.current_A[i]) ? current_A_[i] : kNotMeasured;
    }
    report.supply_V = settings_.measures_supply && usb::is_finite(samples.supply_V)
                          ? samples.supply_V
                          : kNotMeasured;
    for (std::size_t i = 0; i < usb::kTemperatures; ++i) {
        report.temperature_C[i] =
            settings_.measures_temperature[i] ? samples.temperature_C[i] : kNotMeasured;
    }
    report.state = state_;
    report.is_enabled = samples.is_enabled;
    report.is_stopped = samples.is_stopped;
    report.has_command = has_command_;
    report.zeroings = zeroings_;
    report.faults = faults_;
    report.limits = acting_;
    report.command_number = seen_.command.number;
    report.command_arrived_at_us = seen_.command_arrived_at_us;
    report.applied_after_us = is_applied_ ? applied_after_us_ : usb::kNotApplied;
}

} // namespace springdrive::board
