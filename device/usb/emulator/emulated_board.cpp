#include "device/usb/emulator/emulated_board.h"

#include "base/input_error.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

namespace springdrive::emulator {

namespace {

/// After which `pass` wants to be called again.
constexpr double kWallClockCall_s = 100e-6;
constexpr double kIdleCall_s = 5e-3;

/// For the offsets of the current sensors: twice the time that they take at 40 kHz.
constexpr double kLongestStart_s = 0.06;

/// Two reports are never farther apart: a command moves the next one by at most one such period.
constexpr double kLongestReport_s = 2e-6 * usb::kLongestReportPeriod_us;

const EmulatedBoardOptions &checked(const EmulatedBoardOptions &options) {
    if (!(options.delay_periods >= 0.0 &&
          options.delay_periods <= EmulatedBoard::kLongestDelay_periods)) {
        throw InputError(fmt::format("emulated board: the delay is {} periods; it must be 0 to {}",
                                     options.delay_periods, EmulatedBoard::kLongestDelay_periods));
    }
    return options;
}

/// A line of its own for each direction, so that one does not depend on the other's packets.
std::uint64_t seed_of(Direction direction, std::uint64_t seed) {
    return 2 * seed + (direction == Direction::in ? 0U : 1U);
}

PlantFaults plant_faults(std::span<const Fault> faults) {
    PlantFaults plant;
    const auto cross = [&](std::size_t PlantFaults::Channel::*part, const Fault &fault) {
        std::swap(plant.channel[fault.channel].*part, plant.channel[fault.other_channel].*part);
    };
    for (const Fault &fault : faults) {
        PlantFaults::Channel &channel = plant.channel[fault.channel];
        switch (fault.kind) {
        case FaultKind::stuck_encoder:
            channel.has_stuck_encoder = true;
            break;
        case FaultKind::reversed_encoder:
            channel.has_reversed_encoder = true;
            break;
        case FaultKind::crossed_encoders:
            cross(&PlantFaults::Channel::encoder_motor, fault);
            break;
        case FaultKind::lost_counts:
            channel.lost_share = fault.share;
            break;
        case FaultKind::sensor_gain:
            channel.sensor_gain = fault.gain;
            break;
        case FaultKind::failed_sensor:
            channel.has_failed_sensor = true;
            break;
        case FaultKind::reversed_sensor:
            channel.has_reversed_sensor = true;
            break;
        case FaultKind::crossed_sensors:
            cross(&PlantFaults::Channel::sensor_bridge, fault);
            break;
        case FaultKind::open_winding:
            channel.has_open_winding = true;
            break;
        case FaultKind::crossed_motors:
            cross(&PlantFaults::Channel::bridge_motor, fault);
            break;
        case FaultKind::failed_stage:
            plant.has_failed_stage = true;
            break;
        case FaultKind::hot_stage:
            plant.stage_C = fault.temperature_C;
            break;
        case FaultKind::brown_out:
            plant.supply_V = fault.supply_V;
            break;
        case FaultKind::stop:
            plant.is_stopped = true;
            break;
        case FaultKind::disable:
            plant.is_disabled = true;
            break;
        case FaultKind::failed_store:
            plant.has_failed_store = true;
            break;
        case FaultKind::drop:
        case FaultKind::delay:
        case FaultKind::reorder:
        case FaultKind::corrupt:
        case FaultKind::repeat:
        case FaultKind::truncate:
        case FaultKind::stall:
        case FaultKind::restart:
        case FaultKind::unplug:
            break;
        }
    }
    return plant;
}

template <std::size_t size>
void write_text(std::string_view text, std::array<char, size> &characters) {
    std::copy_n(text.begin(), std::min(text.size(), size), characters.begin());
}

} // namespace

usb::Identity emulated_identity(std::string_view serial) {
    const bool is_printable =
        std::ranges::all_of(serial, [](char letter) { return letter > ' ' && letter <= '~'; });
    if (serial.empty() || serial.size() > usb::kSerialSize || !is_printable) {
        throw InputError(fmt::format("emulated board: '{}' is no serial number; give 1 to {} "
                                     "letters, digits or signs of ASCII",
                                     serial, usb::kSerialSize));
    }
    usb::Identity identity;
    write_text(serial, identity.serial);
    write_text("springdrive emulator", identity.name);
    return identity;
}

EmulatedBoard::EmulatedBoard(const device::DeviceDescription &description,
                             const EmulatedBoardOptions &options)
    : options_(checked(options)),
      plant_(description, options.settings, options.simulation,
             options.start_tip_m.value_or(description.workspace.centre_m), options.start_us),
      in_(Direction::in, seed_of(Direction::in, options.seed)),
      out_(Direction::out, seed_of(Direction::out, options.seed)),
      is_active_(options.faults.size()) {
    active_.reserve(options.faults.size());
    power_up();
    const std::uint64_t longest = loop_at(kLongestStart_s);
    while (plant_.loops() < longest && board_->loop().state() == usb::BoardState::starting) {
        run_loop();
    }
}

void EmulatedBoard::power_up() {
    board::BoardSettings settings = options_.settings;
    settings.motors_start_cold = settings.motors_start_cold || plant_.loops() == 0;
    board_.emplace(settings, options_.identity);
    board_->set_speed(is_high_speed_);
    board::start(plant_, *board_);
    period_us_ = usb::ReportRate().period_us;
    out_.clear();
}

std::uint64_t EmulatedBoard::loop_at(double time_s) const {
    const double loop = std::ceil(time_s * options_.settings.loop_rate_hz - 1e-6);
    constexpr double kLast = 9e18;
    return static_cast<std::uint64_t>(std::clamp(loop, 0.0, kLast));
}

double EmulatedBoard::period_loops() const { return period_s() * options_.settings.loop_rate_hz; }

/// The loop that sees a packet is the one after its arrival, and applies it a lag later, but for
/// half a loop: its action begins half a period before the middle of it.
double EmulatedBoard::least_delay_periods() const {
    const double begins_loops = static_cast<double>(options_.settings.actuation_lag_periods) - 0.5;
    return (1.0 + begins_loops) / period_loops();
}

std::uint64_t EmulatedBoard::arrival_loop() const {
    if (options_.clock == BoardClock::wall || silence_s_ > kSilence_s) {
        return plant_.loops();
    }
    const double beyond_least = options_.delay_periods - least_delay_periods();
    const auto waits = std::llround(std::max(0.0, beyond_least) * period_loops());
    return taken_loop_ + static_cast<std::uint64_t>(waits);
}

void EmulatedBoard::put(std::span<const std::uint8_t> packet) {
    if (!is_attached_) {
        return;
    }
    const std::uint64_t due_loop = arrival_loop();
    if (silence_s_ > kSilence_s) {
        usb::Frame old; // not to be taken for the report that this packet permits
        static_cast<void>(board_->take_report(old));
    }
    silence_s_ = 0.0;
    offers_report_ = false;
    // Or every later report would be one ahead, too, and d a period longer.
    if (ahead_ > 0) {
        --ahead_;
    } else {
        ++permitted_;
    }
    if (is_powered_) {
        out_.put({packet, due_loop, 0}, active_, period_loops());
    }
}

std::size_t EmulatedBoard::take(usb::Frame &packet) {
    if (!is_attached_) {
        return 0;
    }
    std::optional<Packet> next = in_.take(plant_.loops());
    if (!next && (options_.clock == BoardClock::wall || offers_report_)) {
        const bool is_offer = offers_report_;
        offers_report_ = !collect_report() && offers_report_;
        next = in_.take(plant_.loops());
        ahead_ += is_offer && next ? 1 : 0;
    } else if (!next && permitted_ > 0) {
        --permitted_;
        run_to_report();
        next = in_.take(plant_.loops());
    }
    if (!next) {
        return 0;
    }
    taken_loop_ = next->measured_loop;
    const std::size_t size = std::min(next->size, packet.size());
    std::copy_n(next->bytes.begin(), size, packet.begin());
    return size;
}

bool EmulatedBoard::control_out(std::uint8_t request, std::uint16_t /*value*/,
                                std::span<const std::uint8_t> payload) {
    if (!is_powered_ || !board_->control_out(request, payload.data(), payload.size())) {
        return false;
    }
    if (usb::ReportRate rate;
        usb::decode(payload.data(), payload.size(), rate) == usb::FrameStatus::ok) {
        period_us_ = rate.period_us;
    }
    board::run_background(plant_, *board_);
    return true;
}

std::size_t EmulatedBoard::control_in(std::uint8_t request, std::uint16_t value,
                                      std::span<std::uint8_t> payload) {
    if (!is_powered_ || payload.size() < board::kLargestPayload) {
        return 0;
    }
    return board_->control_in(request, value, payload.data());
}

void EmulatedBoard::attach(bool is_high_speed) {
    is_attached_ = true;
    is_high_speed_ = is_high_speed;
    board_->set_speed(is_high_speed);
    usb::Frame old;
    static_cast<void>(board_->take_report(old));
    permitted_ = 1;
    ahead_ = 0;
    offers_report_ = false;
    silence_s_ = 0.0;
    taken_loop_ = plant_.loops();
}

void EmulatedBoard::detach() {
    is_attached_ = false;
    board_->disconnect();
    in_.clear();
    out_.clear();
    permitted_ = 0;
}

double EmulatedBoard::pass(double elapsed_s) {
    const double passed_s = elapsed_s > 0.0 && std::isfinite(elapsed_s) ? elapsed_s : 0.0;
    const bool waits = is_attached_ && options_.clock == BoardClock::frame;
    if (!waits) {
        owed_s_ += passed_s;
    } else {
        const double before_s = silence_s_;
        silence_s_ += passed_s;
        if (std::floor(silence_s_ / kSilence_s) > std::floor(before_s / kSilence_s)) {
            offers_report_ = true;
        }
        owed_s_ += std::max(0.0, silence_s_ - std::max(before_s, kSilence_s));
    }
    run_owed();
    return is_attached_ && options_.clock == BoardClock::wall ? kWallClockCall_s : kIdleCall_s;
}

void EmulatedBoard::run_owed() {
    if (owed_s_ > kLongestStep_s) {
        late_s_ += owed_s_ - kLongestStep_s;
        owed_s_ = kLongestStep_s;
    }
    constexpr double kRoundOff = 1e-6; // of a loop
    const double rate_hz = options_.settings.loop_rate_hz;
    const auto loops =
        static_cast<std::uint64_t>(std::max(0.0, std::floor(owed_s_ * rate_hz + kRoundOff)));
    for (std::uint64_t i = 0; i < loops; ++i) {
        run_loop();
    }
    owed_s_ -= static_cast<double>(loops) / rate_hz;
}

void EmulatedBoard::run_loop() {
    update_faults();
    if (!is_powered_) {
        plant_.apply(board::BridgeOrder::opening());
        static_cast<void>(plant_.sample());
        return;
    }
    while (const std::optional<Packet> packet = out_.take(plant_.loops())) {
        static_cast<void>(board_->receive(packet->bytes.data(), packet->size, plant_.now_us()));
    }
    board::run_loop(plant_, *board_);
}

/// @return whether there was one
bool EmulatedBoard::collect_report() {
    usb::Frame frame;
    if (!is_powered_ || !board_->take_report(frame)) {
        return false;
    }
    in_.put({frame, plant_.loops(), plant_.loops()}, active_, period_loops());
    return true;
}

/// Without power there is none, but a period passes.
void EmulatedBoard::run_to_report() {
    const std::uint64_t begin = plant_.loops();
    const std::uint64_t longest = loop_at(kLongestReport_s);
    do {
        run_loop();
        if (collect_report()) {
            return;
        }
    } while (plant_.loops() - begin <
             (is_powered_ ? longest : static_cast<std::uint64_t>(std::llround(period_loops()))));
}

void EmulatedBoard::set_fault(const Fault &fault) {
    options_.faults.push_back(fault);
    is_active_.push_back(false);
    active_.reserve(options_.faults.size());
    next_change_loop_ = 0;
    update_faults();
}

void EmulatedBoard::clear_faults() {
    options_.faults.clear();
    is_active_.clear();
    next_change_loop_ = 0;
    update_faults();
}

bool EmulatedBoard::is_stalled(Direction direction) const {
    return std::ranges::any_of(active_, [&](const Fault &fault) {
        return fault.kind == FaultKind::stall && fault.direction == direction;
    });
}

void EmulatedBoard::update_faults() {
    const std::uint64_t now = plant_.loops();
    if (now < next_change_loop_) {
        return;
    }
    active_.clear();
    next_change_loop_ = std::numeric_limits<std::uint64_t>::max();
    bool restarts = false;
    for (std::size_t i = 0; i < options_.faults.size(); ++i) {
        const Fault &fault = options_.faults[i];
        const std::uint64_t begin = loop_at(fault.begin_s);
        const std::uint64_t end = loop_at(fault.end_s);
        const bool acts = now >= begin && now < end;
        if (acts) {
            active_.push_back(fault);
            restarts = restarts || (fault.kind == FaultKind::restart && !is_active_[i]);
        }
        is_active_[i] = acts;
        for (const std::uint64_t change : {begin, end}) {
            if (change > now) {
                next_change_loop_ = std::min(next_change_loop_, change);
            }
        }
    }
    apply_faults();
    if (restarts && is_powered_) {
        set_power(false);
        set_power(true);
    }
}

void EmulatedBoard::apply_faults() {
    const PlantFaults faults = plant_faults(active_);
    plant_.set_faults(faults);
    is_unplug_wanted_ =
        std::ranges::find(active_, FaultKind::unplug, &Fault::kind) != active_.end();
    const bool has_power = !(faults.supply_V && *faults.supply_V < kLeastLogicSupply_V);
    if (has_power != is_powered_) {
        set_power(has_power);
    }
}

void EmulatedBoard::set_power(bool is_powered) {
    is_powered_ = is_powered;
    out_.clear();
    if (is_powered) {
        plant_.restart();
        plant_.apply(board::BridgeOrder::opening());
        power_up();
        ++restarts_;
    }
}

} // namespace springdrive::emulator
