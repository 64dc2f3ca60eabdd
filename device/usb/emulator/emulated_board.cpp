#include "device/usb/emulator/emulated_board.h"

#include "base/input_error.h"
#include "base/split_mix.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace springdrive::emulator {

using device::Direction;
using device::Fault;
using device::FaultKind;

namespace {

/// After which `pass` wants to be called again.
constexpr double kWallClockCall_s = 100e-6;
constexpr double kIdleCall_s = 5e-3;

/// For the offsets of the current sensors: twice the time that they take at 40 kHz.
constexpr double kMaxStart_s = 0.06;

/// Two reports are never farther apart: a command moves the next one by at most one such period.
constexpr double kMaxReport_s = 2e-6 * usb::kMaxReportPeriod_us;

const EmulatedBoardOptions &checked(const EmulatedBoardOptions &options) {
    if (!(options.delay_periods >= 0.0 &&
          options.delay_periods <= EmulatedBoard::kMaxDelay_periods)) {
        throw InputError(fmt::format("emulated board: the delay is {} periods; it must be 0 to {}",
                                     options.delay_periods, EmulatedBoard::kMaxDelay_periods));
    }
    return options;
}

/// A line of its own for each direction, so that one does not depend on the other's packets.
std::uint64_t seed_of(Direction direction, std::uint64_t seed) {
    return 2 * seed + (direction == Direction::in ? 0U : 1U);
}

template <std::size_t size>
void write_text(std::string_view text, std::array<char, size> &characters) {
    std::copy_n(text.begin(), std::min(text.size(), size), characters.begin());
}

} // namespace

/// Uniform but for 2^-50 of it, and the same on every machine: the standard's distributions are
/// not.
std::uint64_t PacketLine::below(std::uint64_t bound) { return (random_() >> 11U) % bound; }

/// Draws whatever the outcome, so that one fault does not change when another one strikes.
bool PacketLine::strikes(const Fault &fault) {
    const double drawn = split_mix::unit_share(random_());
    const bool does = fault.kind == FaultKind::stall ||
                      (fault.packet != 0 ? fault.packet == packets_ : drawn < fault.share);
    counts_[static_cast<std::size_t>(fault.kind)] += does ? 1U : 0U;
    return does;
}

void PacketLine::flip_bits(Packet &packet) {
    if (packet.size == 0) {
        return;
    }
    // Distinct bits, so that none is flipped back.
    const std::uint64_t bits = 8 * packet.size;
    const std::uint64_t count = 1 + below(3);
    const std::uint64_t first = below(bits);
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t bit = (first + i * (1 + bits / 5)) % bits;
        packet.bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    }
}

void PacketLine::insert(const Packet &packet) {
    const auto place = std::ranges::upper_bound(queue_, packet.due_loop, {}, &Packet::due_loop);
    queue_.insert(place, packet);
}

void PacketLine::put(Packet packet, std::span<const Fault> faults, double period_loops) {
    ++packets_;
    bool is_lost = false;
    bool is_held = false;
    std::size_t copies = 1;
    double delay_periods = 0.0;
    for (const Fault &fault : faults) {
        if (!device::is_of_packets(fault.kind) || fault.direction != direction_ ||
            !strikes(fault)) {
            continue;
        }
        switch (fault.kind) {
        case FaultKind::delay:
            delay_periods += fault.periods;
            break;
        case FaultKind::reorder:
            is_held = true;
            break;
        case FaultKind::corrupt:
            flip_bits(packet);
            break;
        case FaultKind::repeat:
            ++copies;
            break;
        case FaultKind::truncate:
            if (packet.size > 1) {
                packet.size = 1 + below(packet.size - 1);
            }
            break;
        default: // drop, stall
            is_lost = true;
            break;
        }
    }
    if (is_lost) {
        return;
    }
    if (delay_periods > 0.0) {
        packet.due_loop += static_cast<std::uint64_t>(std::llround(delay_periods * period_loops));
    } else {
        packet.due_loop = std::max(packet.due_loop, last_due_loop_);
        last_due_loop_ = packet.due_loop;
    }
    if (is_held && !held_) {
        held_ = packet;
        return;
    }
    for (std::size_t i = 0; i < copies; ++i) {
        insert(packet);
    }
    if (held_) {
        held_->due_loop = std::max(held_->due_loop, packet.due_loop);
        insert(*std::exchange(held_, std::nullopt));
    }
}

std::optional<Packet> PacketLine::take(std::uint64_t now_loop) {
    if (queue_.empty() || queue_.front().due_loop > now_loop) {
        return std::nullopt;
    }
    const Packet packet = queue_.front();
    queue_.erase(queue_.begin());
    return packet;
}

void PacketLine::clear() {
    queue_.clear();
    held_.reset();
    last_due_loop_ = 0;
}

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
      out_(Direction::out, seed_of(Direction::out, options.seed)) {
    for (const Fault &fault : options.faults) {
        plant_.faults().add(fault);
    }
    power_up();
    const std::uint64_t longest = plant_.faults().tick_at(kMaxStart_s);
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

double EmulatedBoard::period_loops() const { return period_s() * options_.settings.loop_rate_hz; }

/// The loop that sees a packet is the one after its arrival, and applies it a lag later, but for
/// half a loop: its action begins half a period before the middle of it.
double EmulatedBoard::min_delay_periods() const {
    const double begins_loops = static_cast<double>(options_.settings.actuation_lag_periods) - 0.5;
    return (1.0 + begins_loops) / period_loops();
}

std::uint64_t EmulatedBoard::arrival_loop() const {
    if (options_.clock == BoardClock::wall || silence_s_ > kSilence_s) {
        return plant_.loops();
    }
    const double beyond_least = options_.delay_periods - min_delay_periods();
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
        out_.put({packet, due_loop, 0}, plant_.faults().active(), period_loops());
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
    if (!is_powered_ || payload.size() < board::kMaxPayload) {
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
    if (owed_s_ > kMaxStep_s) {
        late_s_ += owed_s_ - kMaxStep_s;
        owed_s_ = kMaxStep_s;
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
    in_.put({frame, plant_.loops(), plant_.loops()}, plant_.faults().active(), period_loops());
    return true;
}

/// Without power there is none, but a period passes.
void EmulatedBoard::run_to_report() {
    const std::uint64_t begin = plant_.loops();
    const std::uint64_t longest = plant_.faults().tick_at(kMaxReport_s);
    do {
        run_loop();
        if (collect_report()) {
            return;
        }
    } while (plant_.loops() - begin <
             (is_powered_ ? longest : static_cast<std::uint64_t>(std::llround(period_loops()))));
}

void EmulatedBoard::set_fault(const Fault &fault) {
    plant_.faults().add(fault);
    update_faults();
}

void EmulatedBoard::clear_faults() {
    plant_.faults().clear();
    update_faults();
}

void EmulatedBoard::update_faults() {
    device::FaultInjector &faults = plant_.faults();
    if (!faults.update(plant_.loops())) {
        return;
    }
    is_unplug_requested_ = faults.find(FaultKind::unplug) != nullptr;
    const Fault *brown_out = faults.find(FaultKind::brown_out);
    const bool has_power = !(brown_out && brown_out->size[0] < kMinLogicSupply_V);
    if (has_power != is_powered_) {
        set_power(has_power);
    }
    if (faults.has_begun(FaultKind::restart) && is_powered_) {
        set_power(false);
        set_power(true);
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
