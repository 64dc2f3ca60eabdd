#include "device/usb/driver/usb_device.h"

#include "base/input_error.h"
#include "device/usb/driver/board_request.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <span>
#include <utility>

namespace springdrive::usb {

using device::Arrival;
using device::DeviceCommand;
using device::Measurement;

namespace {

constexpr double kMicrosecond_s = 1e-6;

/// The board starts by measuring its sensors' offsets, for some 40 ms.
constexpr double kAnswer_s = 1.0;

/// In a tick paced by the host's clock, for a report that is about to arrive: a share of T.
constexpr double kWaitingShare = 0.25;

/// Paced by reports, for the next one: longer than any board's period.
constexpr double kMaxWait_s = 0.05;

/// R̂ must be below the board's bound, not at it.
constexpr double kBelowBound = 1.0 - 1e-4;

constexpr int kDelaySamples = 32; ///< before the first tick
constexpr std::uint32_t kTicksBetweenSnapshots = 32;

Mode mode_of(device::CommandMode mode) { return static_cast<Mode>(mode); }
static_assert(static_cast<int>(device::CommandMode::brake) == static_cast<int>(Mode::brake) &&
              static_cast<int>(device::CommandMode::drive) == static_cast<int>(Mode::drive) &&
              static_cast<int>(device::CommandMode::open) == static_cast<int>(Mode::open));

Triple triple_of(const Vector3 &vector) {
    return {static_cast<float>(vector[0]), static_cast<float>(vector[1]),
            static_cast<float>(vector[2])};
}

std::uint32_t period_us(double period_s) {
    return static_cast<std::uint32_t>(std::lround(period_s / kMicrosecond_s));
}

} // namespace

UsbDevice::UsbDevice(std::unique_ptr<BoardPort> port, const device::DeviceDescription &description,
                     std::string serial, double period_s, Pacing pacing, double watchdog_periods)
    : port_(std::move(port)),
      bench_(*port_,
             [this] {
                 return BoardStatus{name(), std::string(port_->speed()), board_, capabilities_,
                                    stream_.newest()};
             }),
      file_description_(description), description_(description), serial_(std::move(serial)),
      period_s_(period_s), pacing_(pacing), watchdog_periods_(watchdog_periods),
      number_(static_cast<std::uint32_t>(
          static_cast<std::uint64_t>(port_->now_s() / kMicrosecond_s))) { // no other program's
    connect();
}

std::string UsbDevice::name() const {
    return identity_.serial.empty() ? "the USB board" : "the USB board " + identity_.serial;
}

void UsbDevice::connect() {
    port_->open(serial_);
    is_open_ = true;
    try {
        check_identity();
        check_capabilities();
        request_report_rate(period_s_);
        stream_.begin();
        phase_ = ReportPhase();
        const bool has_report = wait_for_report(port_->now_s() + kAnswer_s);
        is_zeroed_ = is_zeroed_ && has_report && has_kept_counts();
        meter_ = DelayMeter();
        begin_numbering();
        pass_over_old_reports();
        settle_delay();
    } catch (...) {
        is_zeroed_ = is_zeroed_ && !stream_.has_restarted();
        port_->close();
        is_open_ = false;
        throw;
    }
}

void UsbDevice::check_identity() {
    board_ = ask<Identity>(*port_, Kind::identity, 0, name(), "identity");
    identity_ = {"USB", text_of(board_.serial),
                 fmt::format("{} {}.{}.{}, board revision {}", text_of(board_.name),
                             board_.firmware[0], board_.firmware[1], board_.firmware[2],
                             board_.hardware_revision)};
    if (kProtocolVersion < board_.oldest_version || kProtocolVersion > board_.newest_version) {
        throw InputError(fmt::format(
            "{}: its firmware {}.{}.{} has versions {} to {} of the protocol, this program has "
            "version {}; install the firmware or the program that fits the other",
            name(), board_.firmware[0], board_.firmware[1], board_.firmware[2],
            board_.oldest_version, board_.newest_version, kProtocolVersion));
    }
}

/// Of a board with lower limits than the device file's, its own apply.
void UsbDevice::check_capabilities() {
    capabilities_ = ask<Capabilities>(*port_, Kind::capabilities, 0, name(), "capabilities");
    const auto file_counts = static_cast<std::uint32_t>(file_description_.encoder_counts_per_turn);
    description_ = file_description_;
    double bound_Ohm = description_.amplifier.max_cancelled_Ohm;
    for (std::size_t i = 0; i < kChannels; ++i) {
        if (capabilities_.counts_per_turn[i] != file_counts) {
            throw InputError(fmt::format(
                "{}: encoder {} has {} counts a turn, but the device file says {}; use the device "
                "file of this machine",
                name(), i + 1, capabilities_.counts_per_turn[i], file_counts));
        }
        bound_Ohm = std::min(
            bound_Ohm, kBelowBound * static_cast<double>(capabilities_.largest_cancelled_Ohm[i]));
        description_.motor[i].supply_V = std::min(description_.motor[i].supply_V,
                                                  static_cast<double>(capabilities_.largest_e_W_V));
        description_.motor[i].peak_current_A =
            std::min(description_.motor[i].peak_current_A,
                     static_cast<double>(capabilities_.current_limit_A));
    }
    description_.amplifier.max_cancelled_Ohm = bound_Ohm;
}

void UsbDevice::take_calibration(const device::Calibration &calibration) {
    file_description_.calibration = calibration;
    description_.calibration = calibration;
    pass_over_old_reports(); // it took a while to ask for it
}

void UsbDevice::request_report_rate(double period_s) {
    const std::uint32_t requested_us = period_us(period_s);
    if (requested_us < capabilities_.shortest_report_period_us ||
        requested_us > capabilities_.longest_report_period_us) {
        const bool is_too_fast = requested_us < capabilities_.shortest_report_period_us;
        throw InputError(fmt::format(
            "{}: measures {} every {} us at {}, but a servo at {:.6g} Hz needs every {} us; use a "
            "servo rate of {} Hz",
            name(), is_too_fast ? "at most" : "at least",
            is_too_fast ? capabilities_.shortest_report_period_us
                        : capabilities_.longest_report_period_us,
            port_->speed(), 1.0 / period_s, requested_us,
            1'000'000 / (is_too_fast ? capabilities_.shortest_report_period_us
                                     : capabilities_.longest_report_period_us)));
    }
    const auto payload = encode(ReportRate{requested_us});
    if (!port_->control_out(Kind::report_rate, 0, payload)) {
        throw InputError(
            fmt::format("{}: refuses a report every {} us, which its capabilities allow; its "
                        "firmware is at fault",
                        name(), requested_us));
    }
    watchdog_us_ = static_cast<std::uint16_t>(
        std::clamp(watchdog_periods_ * requested_us,
                   static_cast<double>(std::max<std::uint32_t>(capabilities_.shortest_watchdog_us,
                                                               kMinWatchdog_us)),
                   static_cast<double>(std::min<std::uint32_t>(capabilities_.longest_watchdog_us,
                                                               kMaxWatchdog_us))));
    period_s_ = period_s;
}

bool UsbDevice::wait_for_report(double deadline_s) noexcept {
    Packet packet;
    while (port_->receive(packet, deadline_s)) {
        if (stream_.take(packet)) {
            meter_.take(stream_.newest(), packet.arrived_s);
            return true;
        }
    }
    return false;
}

/// A board that kept its power still knows a command of this driver; one that another program used
/// meanwhile, or that restarted, does not.
bool UsbDevice::has_kept_counts() const {
    const Report &report = stream_.newest();
    return report.has_command && report.zeroings == zeroings_ &&
           meter_.has_sent(report.command_number);
}

void UsbDevice::begin_numbering() {
    const std::uint32_t before = number_;
    const double deadline_s = port_->now_s() + kAnswer_s;
    Command first;
    first.begins_numbering = true;
    do {
        send(first, 0, false);
        if (!wait_for_report(port_->now_s() + 3.0 * period_s_)) {
            continue;
        }
        const Report &report = stream_.newest();
        if (report.has_command && difference(report.command_number, before) > 0 &&
            difference(report.command_number, number_) <= 0) {
            return;
        }
    } while (port_->is_connected() && port_->now_s() < deadline_s);
    throw InputError(fmt::format(
        "{}: accepts no command within {:.0f} s{}; plug it in again", name(), kAnswer_s,
        stream_.has_report() && stream_.newest().last_rejection != FrameStatus::ok
            ? std::string(", the last one had ") + description_of(stream_.newest().last_rejection)
            : ""));
}

/// A board that waits for its host may have reports ready that nobody asked for. Each would stay
/// one ahead of the answers.
void UsbDevice::pass_over_old_reports() {
    constexpr double kSilence_s = 0.02;
    constexpr double kMax_s = 0.1; // of a board that does not wait
    const double end_s = port_->now_s() + kMax_s;
    while (pacing_ == Pacing::reports &&
           wait_for_report(std::min(end_s, port_->now_s() + kSilence_s))) {
    }
}

/// A first value of d, from braking commands.
void UsbDevice::settle_delay() {
    int samples = 0;
    do {
        send({}, stream_.newest().measured_at_us, true);
    } while (++samples < kDelaySamples && wait_for_report(port_->now_s() + 3.0 * period_s_));
    delay_s_ = meter_.delay().mean_s();
    static_cast<void>(stream_.settle(port_->now_s(), period_s_, false));
    stream_.forget_counts(); // before, no host collected reports
    publish();
}

double UsbDevice::delay_periods() const {
    const double delay_s = delay_s_.load(std::memory_order_relaxed);
    return delay_s > 0.0 ? delay_s / period_s_ : 1.0;
}

double UsbDevice::read_deadline_s(double now_s) const noexcept {
    return now_s + (pacing_ == Pacing::clock ? kWaitingShare * period_s_ : kMaxWait_s);
}

Measurement UsbDevice::read() noexcept {
    tick_s_ = port_->now_s();
    const double deadline_s = read_deadline_s(tick_s_);
    bool has_new = false;
    const std::uint32_t command_before = stream_.newest().command_number;
    for (Packet packet; port_->receive(packet, has_new ? tick_s_ : deadline_s);) {
        if (!stream_.take(packet)) {
            continue;
        }
        has_new = true;
        const Report &report = stream_.newest();
        if (report.zeroings != zeroings_ || // by a calibration, or somebody else
            has_fault(device::BoardFaults::kEncoder)) {
            is_zeroed_ = false;
        }
        measured_at_[stream_.number() % kRememberedReports] = {stream_.number(),
                                                               report.measured_at_us};
        if (const auto round_trip_s = meter_.take(report, packet.arrived_s)) {
            phase_.take(*round_trip_s);
        }
        if (pacing_ == Pacing::reports) {
            break; // one a tick
        }
    }
    if (stream_.has_restarted()) {
        is_zeroed_ = false;
    }
    has_new_command_ = stream_.newest().command_number != command_before;
    delay_s_.store(meter_.delay().mean_s(), std::memory_order_relaxed);
    if (++ticks_ % kTicksBetweenSnapshots == 0) {
        publish();
    }
    return measurement(stream_.settle(port_->now_s(), period_s_, pacing_ == Pacing::clock));
}

Measurement UsbDevice::measurement(Arrival arrival) const noexcept {
    const Report &report = stream_.newest();
    Measurement measured;
    measured.counts = report.counts;
    for (std::size_t i = 0; i < kChannels; ++i) {
        measured.current_A[static_cast<Eigen::Index>(i)] = static_cast<double>(report.current_A[i]);
    }
    measured.number = stream_.number();
    measured.time_s = stream_.measured_s();
    measured.arrival = arrival;
    measured.health = is_open_ && port_->is_connected() && !stream_.has_restarted()
                          ? device::DeviceHealth::ok
                          : device::DeviceHealth::lost;
    measured.faults.bits = report.faults;
    if ((capabilities_.has_stop_switch && report.is_stopped) ||
        (capabilities_.has_enable_line && !report.is_enabled)) {
        measured.faults.bits |= device::BoardFaults::kPressed;
    }
    measured.supply_V = static_cast<double>(report.supply_V);
    measured.zeroing = is_zeroed_ ? static_cast<std::uint8_t>(1 + zeroings_) : std::uint8_t{0};
    measured.has_new_command = has_new_command_;
    return measured;
}

std::uint32_t UsbDevice::measured_at_us(std::uint64_t number) const noexcept {
    const MeasuredAt &remembered = measured_at_[number % kRememberedReports];
    return remembered.number == number ? remembered.us : stream_.newest().measured_at_us;
}

bool UsbDevice::send(Command command, std::uint32_t measured_at_us, bool is_first) noexcept {
    command.number = ++number_;
    command.watchdog_us = watchdog_us_;
    const double now_s = port_->now_s();
    if (!port_->send(encode(command))) {
        ++unsent_;
        return false;
    }
    // What did not leave must not push out the last that did: by it a board is known again.
    meter_.sent(command.number, measured_at_us, is_first, now_s);
    return true;
}

void UsbDevice::write(const DeviceCommand &requested) noexcept {
    if (requested.voids_zero) {
        is_zeroed_ = false;
    }
    if (!is_open_) {
        return;
    }
    Command command;
    command.mode = mode_of(requested.mode);
    command.resets_faults = requested.resets_faults && requested.mode == device::CommandMode::brake;
    if (requested.mode == device::CommandMode::drive) {
        command.e_W_V = triple_of(requested.e_W_V);
        command.cancelled_resistance_Ohm.diagonal = triple_of(requested.cancelled_resistance_Ohm);
    }
    if (pacing_ == Pacing::clock) {
        command.report_after_us = phase_.report_after_us(port_->now_s() - tick_s_, period_s_);
    }
    send(command, measured_at_us(requested.number), requested.number != answered_);
    answered_ = requested.number;
}

void UsbDevice::publish() noexcept {
    snapshot_.publish({stream_.counts(), meter_.delay().mean_s(), meter_.delay().largest_s(),
                       meter_.round_trip().mean_s(), meter_.round_trip().largest_s(), unsent_,
                       stream_.newest()});
}

std::optional<device::LinkStatus> UsbDevice::link() const {
    const Snapshot &now = snapshot_.latest();
    const FrameStatus rejection = now.newest.last_rejection;
    const FrameStatus damage = now.counts.last_damage;
    std::string problem;
    if (rejection != FrameStatus::ok) {
        problem = std::string("a command with ") + description_of(rejection);
    } else if (damage != FrameStatus::ok) {
        problem = std::string("a report with ") + description_of(damage);
    }
    return device::LinkStatus{std::string(port_->speed()),
                              description_of(now.newest.state),
                              std::string(port_->warning()),
                              std::move(problem),
                              1.0 / period_s_,
                              now.delay_s,
                              now.longest_delay_s,
                              now.round_trip_s,
                              now.longest_round_trip_s,
                              now.counts.reports,
                              now.counts.lost,
                              now.counts.late,
                              now.counts.absent,
                              now.counts.repeated,
                              now.counts.stale,
                              now.counts.corrupt,
                              now.unsent,
                              now.newest.rejected_frames};
}

void UsbDevice::set_period(double period_s) {
    if (!is_open_) {
        period_s_ = period_s;
        return;
    }
    request_report_rate(period_s);
}

bool UsbDevice::has_fault(std::uint16_t fault) const noexcept {
    return device::BoardFaults{stream_.newest().faults}.has(fault);
}

/// Brakes for each report, as in a tick. @return whether `is_done` in time
/// @param reset  null: nothing is reset
template <typename IsDone>
bool UsbDevice::exchange_until(device::BoardReset *reset, IsDone is_done) {
    const double deadline_s = port_->now_s() + kAnswer_s;
    bool has_come = false;
    do {
        const bool is_new = wait_for_report(port_->now_s() + 3.0 * period_s_);
        has_come = is_new && is_done();
        Command command;
        command.resets_faults =
            reset != nullptr &&
            reset->may_follow(measurement(is_new ? Arrival::fresh : Arrival::absent));
        send(command, stream_.newest().measured_at_us, false);
    } while (!has_come && port_->is_connected() && port_->now_s() < deadline_s);
    return has_come;
}

void UsbDevice::zero(const Vector3 &theta_rad) {
    const auto has_encoder_fault = [this] { return has_fault(device::BoardFaults::kEncoder); };
    device::BoardReset reset(false); // of a latched fault, which would hide the next one
    if (has_encoder_fault() && !exchange_until(&reset, [&] { return !has_encoder_fault(); })) {
        throw InputError(name() + (reset.has_stop()
                                       ? ": its stop was pressed; release it, let the device go "
                                         "on, then zero it again"
                                       : ": its encoders are still at fault; look at their plugs "
                                         "and cables, then zero it again"));
    }
    Zeroing zeroing;
    for (std::size_t i = 0; i < kChannels; ++i) {
        zeroing.counts[i] = static_cast<std::int32_t>(
            std::lround(theta_rad[static_cast<Eigen::Index>(i)] / description_.rad_per_count()));
    }
    const auto next = static_cast<std::uint8_t>((stream_.newest().zeroings + 1U) & 15U);
    if (!port_->control_out(Kind::zero, 0, encode(zeroing))) {
        throw InputError(name() + ": refuses to be zeroed; stop its motors first");
    }
    const bool is_confirmed =
        exchange_until(nullptr, [&] { return stream_.newest().zeroings == next; });
    if (has_encoder_fault()) { // which counts as a zeroing, too
        throw InputError(name() + ": an encoder failed while it was zeroed; look at its plug and "
                                  "cable, then zero it again");
    }
    if (!is_confirmed) {
        throw InputError(name() + ": does not confirm that it was zeroed; plug it in again");
    }
    is_zeroed_ = true;
    zeroings_ = next;
}

void UsbDevice::close() noexcept {
    if (!is_open_) {
        return;
    }
    const double deadline_s = port_->now_s() + 3.0 * period_s_;
    send({}, stream_.newest().measured_at_us, false);
    while (wait_for_report(deadline_s) && stream_.newest().state == BoardState::driving) {
        send({}, stream_.newest().measured_at_us, false);
    }
    is_open_ = false;
    port_->close();
}

void UsbDevice::reconnect() {
    if (serial_.empty()) {
        serial_ = identity_.serial;
    }
    close();
    connect();
}

} // namespace springdrive::usb
