#include "tests/usb/fault_storm.h"

#include "engine/control/motion_control.h"
#include "tests/support/devices.h"
#include "tests/support/fault_judge.h"
#include "tests/support/surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>

namespace springdrive::testing {

namespace {

using device::BoardFaults;
using device::Direction;
using device::Fault;
using device::FaultKind;
using device::LinkStatus;
using servo::TripCause;

constexpr double kPublished_s = 0.04; ///< the driver publishes its counters every 32 ticks
constexpr double kAfterwards_s = 0.1;
constexpr double kHottest_C = 85.0; ///< of a power stage
constexpr double kMinSupply_V = 13.0;
constexpr double kMaxSupply_V = 18.0;

// ---- Random cases.

class StormDice {
public:
    StormDice(std::uint64_t seed, int number)
        : random_(seed + static_cast<std::uint64_t>(number)) {}

    double even(double from, double to) {
        return std::uniform_real_distribution(from, to)(random_);
    }
    double by_ratio(double from, double to) { return from * std::pow(to / from, even(0.0, 1.0)); }
    bool flip() { return even(0.0, 1.0) < 0.5; }
    std::size_t below(std::size_t bound) {
        return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random_);
    }

private:
    std::mt19937_64 random_;
};

/// Beyond limits or within them, but not so near that the outcome is open.
double random_supply_V(StormDice &dice) {
    constexpr std::array<std::array<double, 2>, 4> kRanges{
        {{0.0, 5.8}, {6.2, 12.9}, {13.1, 17.9}, {18.1, 25.0}}};
    const auto &[from, to] = kRanges.at(dice.below(kRanges.size()));
    return dice.even(from, to);
}

Fault random_fault(StormDice &dice, FaultKind kind) {
    Fault fault;
    fault.kind = kind;
    fault.direction = dice.flip() ? Direction::in : Direction::out;
    switch (dice.below(3)) {
    case 0: // all
        break;
    case 1:
        fault.share = dice.even(0.01, 0.9);
        break;
    default:
        fault.packet = kind == FaultKind::stall ? 0 : 1; // the first; set when it is known
        break;
    }
    fault.periods = dice.even(0.5, 7.0);
    fault.channel = dice.below(3);
    const double gain = dice.by_ratio(0.8, 1.25);
    fault.other_channel = (fault.channel + 1 + dice.below(2)) % 3;
    const double supply_V = random_supply_V(dice);
    const double temperature_C = dice.flip() ? dice.even(86.0, 150.0) : dice.even(30.0, 84.0);
    fault.size.setConstant(kind == FaultKind::brown_out   ? supply_V
                           : kind == FaultKind::hot_stage ? temperature_C
                                                          : gain);
    return fault;
}

/// The default, a softer and a stiffer one, all stable with d up to 1.
control::Tuning random_gains(StormDice &dice) {
    constexpr std::array<std::array<double, 2>, 3> kGains{{{0.5, 6.0}, {0.8, 3.0}, {0.3, 7.0}}};
    control::Tuning tuning;
    const auto &[dR_Ohm, K_P_V_per_rad] = kGains.at(dice.below(kGains.size()));
    tuning.dR_Ohm = dR_Ohm;
    tuning.K_P_V_per_rad = K_P_V_per_rad;
    tuning.map = dice.flip() ? control::MotionMap::inverse : control::MotionMap::transpose;
    return tuning;
}

// ---- What the documentation names.

using Causes = std::uint32_t;

constexpr Causes set_of(TripCause cause) { return 1U << static_cast<unsigned>(cause); }

/// Force, speed or energy of a loop that does not do what it is told, or does it too late:
/// safety_status.h, "a faulty measurement comes before its consequences".
constexpr Causes kConsequences = set_of(TripCause::current) | set_of(TripCause::tip_force) |
                                 set_of(TripCause::tip_speed) | set_of(TripCause::energy) |
                                 set_of(TripCause::voltage);
/// Of a motor whose current, encoder and voltage are not of each other.
constexpr Causes kWrongMotor = kConsequences | set_of(TripCause::motor_contradicted);
/// The same, of wrong angles.
constexpr Causes kWrongAngles =
    kWrongMotor | set_of(TripCause::encoder_jump) | set_of(TripCause::beyond_stops);

/// An additional delay that counts as one.
constexpr double kLater_s = 0.1e-3;

using HasRisen = bool (*)(const LinkStatus &before, const LinkStatus &after);

bool says_nothing(const LinkStatus & /*before*/, const LinkStatus & /*after*/) { return true; }
bool says_rejected(const LinkStatus &before, const LinkStatus &after) {
    return after.rejected > before.rejected;
}
bool says_lost(const LinkStatus &before, const LinkStatus &after) {
    return after.absent > before.absent && after.lost > before.lost;
}
bool says_corrupt(const LinkStatus &before, const LinkStatus &after) {
    return after.corrupt > before.corrupt;
}
bool says_repeated(const LinkStatus &before, const LinkStatus &after) {
    return after.repeated > before.repeated;
}
bool says_stale(const LinkStatus &before, const LinkStatus &after) {
    return after.stale > before.stale;
}

/// A command that comes late is applied later, or overtaken by the next one.
bool says_later_or_rejected(const LinkStatus &before, const LinkStatus &after) {
    return says_rejected(before, after) ||
           after.longest_delay_s > before.longest_delay_s + kLater_s;
}
/// A report that comes late is missed, and then comes after newer ones, or each comes later.
bool says_later_or_stale(const LinkStatus &before, const LinkStatus &after) {
    return after.absent > before.absent || says_stale(before, after) ||
           after.longest_delay_s > before.longest_delay_s + kLater_s;
}

/// How a fault is named.
struct Naming {
    FaultKind kind = FaultKind::drop;
    Direction direction = Direction::out; ///< of packets
    HasRisen counters = says_nothing;     ///< where it struck a packet
    std::uint16_t bits = 0;               ///< of the board, with TripCause::board_fault
    Causes causes = 0;                    ///< others
    /// That must trip where the fault is total (not of some packets only) and lasts so long, within
    /// the same time and what a report takes.
    TripCause must = TripCause::none;
    double after_periods = 0.0;
    double after_s = 0.0;
};

/// One period to the next report, one to the servo's tick that reads it, one for rounding.
constexpr double kReported_periods = 3.0;

/// PROTOCOL.md: "no accepted command for the period → fault 5", which the driver sets to 5 T.
constexpr double kWatchdog_periods = 5.0;

/// docs/servo.md: "stale measurement: 5 ms without a new one".
constexpr double kStale_s = 5e-3;

/// docs/board.md: "supply: below 13 or above 18 V: firmware brakes within 1.2 ms".
constexpr double kSlowCheck_s = 1.2e-3;

constexpr auto kSilence = BoardFaults::kNoCommand;
constexpr Causes kStaleCause = set_of(TripCause::stale_measurement);
constexpr Causes kLostCause = set_of(TripCause::device_lost);
constexpr auto kIn = Direction::in;
constexpr auto kOut = Direction::out;

// PROTOCOL.md, "Late, lost, repeated, corrupt", and "Watchdog". A lost command is named by nothing:
// it leaves the last one in force.
constexpr std::array<Naming, 14> kPacketNamings{{
    {FaultKind::drop, kOut, says_nothing, kSilence, kConsequences, TripCause::board_fault,
     kWatchdog_periods},
    {FaultKind::stall, kOut, says_nothing, kSilence, kConsequences, TripCause::board_fault,
     kWatchdog_periods},
    {FaultKind::corrupt, kOut, says_rejected, kSilence, kConsequences, TripCause::board_fault,
     kWatchdog_periods},
    {FaultKind::truncate, kOut, says_rejected, kSilence, kConsequences, TripCause::board_fault,
     kWatchdog_periods},
    {FaultKind::delay, kOut, says_later_or_rejected, kSilence, kConsequences},
    {FaultKind::reorder, kOut, says_rejected, kSilence, kConsequences},
    {FaultKind::repeat, kOut, says_rejected},
    {FaultKind::drop, kIn, says_lost, 0, kStaleCause | kConsequences, TripCause::stale_measurement,
     0.0, kStale_s},
    {FaultKind::stall, kIn, says_lost, 0, kStaleCause | kConsequences, TripCause::stale_measurement,
     0.0, kStale_s},
    {FaultKind::corrupt, kIn, says_corrupt, 0, kStaleCause | kConsequences,
     TripCause::stale_measurement, 0.0, kStale_s},
    {FaultKind::truncate, kIn, says_corrupt, 0, kStaleCause | kConsequences,
     TripCause::stale_measurement, 0.0, kStale_s},
    {FaultKind::delay, kIn, says_later_or_stale, 0, kStaleCause | kConsequences},
    {FaultKind::reorder, kIn, says_stale, 0, kConsequences},
    {FaultKind::repeat, kIn, says_repeated},
}};

// Where nothing must trip, only a self-test names the fault (PROTOCOL.md, "Control requests",
// findings 0 to 5). In operation it may go unnoticed, or show by its consequences.
/// What a board finds where the sign of a current or of a turn is wrong: a winding that generates.
constexpr std::uint16_t kGenerates = BoardFaults::kOverCurrent | BoardFaults::kEncoder;
constexpr std::array<Naming, 17> kBoardNamings{{
    {FaultKind::stuck_encoder, kOut, says_nothing, BoardFaults::kEncoder, kWrongAngles},
    {FaultKind::reversed_encoder, kOut, says_nothing, kGenerates, kWrongAngles},
    {FaultKind::crossed_encoders, kOut, says_nothing, kGenerates, kWrongAngles},
    {FaultKind::lost_counts, kOut, says_nothing, BoardFaults::kEncoder, kWrongAngles},
    {FaultKind::failed_sensor, kOut, says_nothing, BoardFaults::kSensor, 0, TripCause::board_fault},
    {FaultKind::reversed_sensor, kOut, says_nothing, kGenerates, kWrongMotor},
    {FaultKind::crossed_sensors, kOut, says_nothing, kGenerates, kWrongMotor},
    {FaultKind::sensor_gain, kOut, says_nothing, 0, kWrongMotor},
    {FaultKind::open_winding, kOut, says_nothing, 0, kWrongMotor},
    {FaultKind::crossed_motors, kOut, says_nothing, kGenerates, kWrongMotor},
    {FaultKind::failed_stage, kOut, says_nothing, BoardFaults::kAmplifier, 0,
     TripCause::board_fault},
    {FaultKind::hot_stage, kOut, says_nothing, BoardFaults::kTemperature, 0, TripCause::board_fault,
     0.0, kSlowCheck_s},
    {FaultKind::brown_out, kOut, says_nothing, BoardFaults::kSupply, 0, TripCause::board_fault, 0.0,
     kSlowCheck_s},
    {FaultKind::stop, kOut, says_nothing, BoardFaults::kStop, 0, TripCause::board_fault},
    {FaultKind::disable, kOut, says_nothing, BoardFaults::kStop, 0, TripCause::board_fault},
    {FaultKind::restart, kOut, says_nothing, 0, kLostCause, TripCause::device_lost},
    {FaultKind::unplug, kOut, says_nothing, 0, kLostCause, TripCause::device_lost},
}};

/// Without enough supply for its processor, the board leaves the bus.
constexpr Naming kOff{FaultKind::brown_out,  kOut, says_nothing, 0, kLostCause,
                      TripCause::device_lost};

bool is_within_limits(const Fault &fault) {
    return (fault.kind == FaultKind::hot_stage && fault.size[0] <= kHottest_C) ||
           (fault.kind == FaultKind::brown_out && fault.size[0] >= kMinSupply_V &&
            fault.size[0] <= kMaxSupply_V);
}

/// One loop of the board suffices, and lasting is not needed to be reported.
bool is_latched(FaultKind kind) {
    return kind == FaultKind::failed_sensor || kind == FaultKind::failed_stage ||
           kind == FaultKind::stop || kind == FaultKind::disable || kind == FaultKind::restart;
}

Naming naming_of(const Fault &fault) {
    if (is_within_limits(fault)) {
        return {.kind = fault.kind};
    }
    if (fault.kind == FaultKind::brown_out &&
        fault.size[0] < emulator::EmulatedBoard::kMinLogicSupply_V) {
        return kOff;
    }
    const bool has_direction = device::is_of_packets(fault.kind);
    const auto is_its = [&](const Naming &naming) {
        return naming.kind == fault.kind && (!has_direction || naming.direction == fault.direction);
    };
    return has_direction ? *std::ranges::find_if(kPacketNamings, is_its)
                         : *std::ranges::find_if(kBoardNamings, is_its);
}

// ---- The run.

/// What may be exceeded for so long: the response of limit and trip.
constexpr double kOver_s = 0.02;
constexpr double kMax_m_per_s = 2.2; ///< 2 m/s, at which the servo trips, and its response

class Storm {
public:
    explicit Storm(const StormCase &what)
        : what_(what), servo_(phantom_1_0(), options(what), what.period_s),
          box_(box_soup(Vector3(-0.15, -0.05, -0.15), Vector3(0.15, 0.0, 0.15))),
          trip_A_(options(what).settings.current_trip_A) {
        servo_.inputs.surface = &box_;
        servo_.inputs.tuning = what.tuning;
        Fault fault = what.fault;
        const double start_s = servo_.board.time_s();
        fault.begin_s += start_s;
        fault.end_s += start_s;
        if (fault.packet != 0) { // of its direction, within the fault's time
            const auto since =
                static_cast<std::uint64_t>(std::ceil(what.fault.begin_s / what.period_s) + 2.0);
            fault.packet = servo_.board.line(fault.direction).packets() + since;
        }
        servo_.board.set_fault(fault);
    }

    StormOutcome run() {
        const int begin = servo_.ticks_in(what_.fault.begin_s);
        const int end = servo_.ticks_in(what_.until_s);
        for (int i = 0; i < end && outcome_.broken.empty(); ++i) {
            if (i == servo_.ticks_in(what_.press_s)) {
                servo_.board.phantom().set_hand_target(what_.target_m);
            }
            if (what_.period_s * i >= what_.lift_s) {
                servo_.board.phantom().set_hand_target(what_.lifted_m);
            }
            if (i == begin - 1) {
                outcome_.was_driving = servo_.state() == board::State::driving;
                outcome_.before = *servo_.device.link();
                struck_before_ = struck();
            }
            step(i);
            if (i >= begin) { // the driver forgets it after some hundred ticks
                outcome_.after.longest_delay_s =
                    std::max(outcome_.after.longest_delay_s, servo_.device.link()->longest_delay_s);
            }
        }
        const double longest_delay_s = outcome_.after.longest_delay_s;
        outcome_.after = *servo_.device.link();
        outcome_.after.longest_delay_s = longest_delay_s;
        outcome_.struck = struck() - struck_before_;
        outcome_.safety = servo_.last.safety;
        return outcome_;
    }

private:
    static emulator::EmulatedBoardOptions options(const StormCase &what) {
        emulator::EmulatedBoardOptions options;
        options.start_tip_m = what.start_m;
        options.delay_periods = what.delay_periods;
        options.simulation.hand = what.hand;
        options.seed = what.seed;
        return options;
    }

    [[nodiscard]] std::uint64_t struck() const {
        return servo_.board.line(what_.fault.direction)
            .faults()[static_cast<std::size_t>(what_.fault.kind)];
    }

    void step(int tick) {
        if (servo_.board.unplug_requested() && servo_.port->is_connected()) {
            servo_.port->unplug();
        }
        if (!servo_.port->is_connected()) {
            servo_.board.pass(what_.period_s);
        }
        const bool had_tripped = servo_.has_tripped();
        servo_.tick();
        const double time_s = what_.period_s * tick;
        if (had_tripped && !servo_.has_tripped()) {
            outcome_.broken = "starts again by itself";
        }
        if (servo_.has_tripped() && !had_tripped) {
            outcome_.tripped_after_s = time_s - what_.fault.begin_s;
            if (time_s + what_.period_s < what_.fault.begin_s) {
                outcome_.broken =
                    "trips before any fault: " + servo::description(servo_.last.safety);
            }
        }
        check();
    }

    void check() {
        const double current_A = servo_.truth().current_A.cwiseAbs().maxCoeff();
        outcome_.largest_A = std::max(outcome_.largest_A, current_A);
        if (!(current_A < trip_A_)) {
            outcome_.broken = fmt::format("{:.3g} A in a winding", current_A);
        }
        const device::DeviceDescription &device = servo_.device.description();
        const TipAt tip(device.geometry, servo_.truth().theta_rad);
        const double force_N =
            tip.force_N(control::torque_constants(device).cwiseProduct(servo_.truth().current_A))
                .norm();
        over_s_ = force_N > device.limits.tip_force_N ? over_s_ + what_.period_s : 0.0;
        outcome_.longest_over_s = std::max(outcome_.longest_over_s, over_s_);
        outcome_.largest_N = std::max(outcome_.largest_N, force_N);
        if (over_s_ > kOver_s) {
            outcome_.broken = fmt::format("{:.3g} N for too long", outcome_.largest_N);
        }
        const double speed_m_per_s = servo_.truth().tip_velocity_m_per_s.norm();
        outcome_.largest_m_per_s = std::max(outcome_.largest_m_per_s, speed_m_per_s);
        if (!(speed_m_per_s < kMax_m_per_s)) {
            outcome_.broken = fmt::format("{:.3g} m/s", speed_m_per_s);
        }
        const device::DeviceCommand &command = servo_.last.command;
        if (servo_.has_tripped() &&
            (command.mode == device::CommandMode::drive || !command.e_W_V.isZero(0.0) ||
             !command.cancelled_resistance_Ohm.isZero(0.0))) {
            outcome_.broken = "drives although it tripped";
        }
    }

    const StormCase &what_;
    ServoOnBoard servo_;
    contact::HapticSurface box_;
    double trip_A_;
    double over_s_ = 0.0;
    StormOutcome outcome_;
    std::uint64_t struck_before_ = 0;
};

} // namespace

std::string StormCase::description() const {
    const std::string packets =
        !device::is_of_packets(fault.kind)
            ? ""
            : fmt::format(" {}, {}, {:.1f} periods",
                          fault.direction == Direction::in ? "in" : "out",
                          fault.packet != 0 ? "one packet" : fmt::format("{:.2f}", fault.share),
                          fault.periods);
    return fmt::format("{}{}, channels {} and {}, size {:.2f}, from {:.5f} s to {:.5f} s; "
                       "{} at {:.3f} s; {:.0f} Hz, d {:.2f}, dR {}, {}",
                       device::name_of(fault.kind), packets, fault.channel + 1,
                       fault.other_channel + 1, fault.size[0], fault.begin_s, fault.end_s,
                       !presses                ? "moves"
                       : std::isfinite(lift_s) ? "presses and lifts"
                                               : "presses",
                       press_s, 1.0 / period_s, delay_periods, tuning.dR_Ohm,
                       control::name_of(tuning.map));
}

StormCase random_storm_case(std::uint64_t seed, int number) {
    StormDice dice(seed, number);
    StormCase what;
    // All kinds before this one: nothing is stored in operation.
    constexpr auto kKinds = static_cast<std::size_t>(FaultKind::failed_store);
    static_assert(kKinds + 1 == device::kNamedFaults);
    what.fault =
        random_fault(dice, static_cast<FaultKind>(static_cast<std::size_t>(number) % kKinds));
    what.presses = dice.flip();
    what.tuning = random_gains(dice);
    what.period_s = dice.flip() ? 1e-3 : 0.25e-3;
    what.delay_periods = dice.even(0.2, 1.0);
    what.seed = seed + static_cast<std::uint64_t>(number);
    what.hand = dice.flip() ? device::HandParameters{}
                            : device::HandParameters{0.3, 30.0, 1500.0, 20.0, 0.4};
    what.hand.max_speed_m_per_s = dice.by_ratio(0.05, 0.4);
    const auto across_m = [&] { return dice.even(-0.04, 0.04); };
    what.start_m = {across_m(), dice.even(0.012, 0.03), across_m()};
    what.target_m = {across_m(), dice.even(0.012, 0.03), across_m()};
    // The gains have risen after 1.1 s.
    what.press_s = dice.even(0.2, 1.3);
    what.fault.begin_s = dice.even(0.02, 1.8);
    if (what.presses) {
        constexpr double kSurface_N_per_m = 1800.0;
        const double force_N = dice.even(1.0, 12.0); // the servo limits it to 8.1 N
        what.target_m = what.start_m + Vector3(0.005, 0.0, -0.003);
        what.target_m.y() = -force_N * (1.0 / kSurface_N_per_m + 1.0 / what.hand.stiffness_N_per_m);
        what.press_s = dice.even(0.9, 1.5);
        what.fault.begin_s = dice.even(1.0, 1.8);
    }
    const double lasts_s = dice.by_ratio(2e-3, 0.6);
    what.fault.end_s = what.fault.begin_s + lasts_s;
    what.until_s = what.fault.end_s + kPublished_s + kAfterwards_s;
    if (what.presses && dice.flip()) { // from a surface that the servo may no longer know
        what.lift_s = std::max(what.press_s, what.fault.begin_s) + dice.even(0.0, 0.3);
        what.lifted_m = {across_m(), dice.even(0.02, 0.09), across_m()};
    }
    return what;
}

StormOutcome outcome_of(const StormCase &what) { return Storm(what).run(); }

std::string misnaming(const StormCase &what, const StormOutcome &outcome) {
    const Naming naming = naming_of(what.fault);
    const servo::SafetyStatus &safety = outcome.safety;
    const bool has_tripped = safety.state == servo::SafetyState::tripped;
    if (has_tripped && safety.cause == TripCause::board_fault) {
        const auto bits = static_cast<std::uint16_t>(safety.measured);
        if ((bits & ~naming.bits) != 0 || bits == 0) {
            return fmt::format("board faults {:#x}, not {:#x}", bits, naming.bits);
        }
    } else if (has_tripped && (naming.causes & set_of(safety.cause)) == 0) {
        return "trips by " + servo::description(safety);
    }
    if (outcome.struck > 0 && !naming.counters(outcome.before, outcome.after)) {
        return fmt::format("{} packets struck, but counters do not tell", outcome.struck);
    }
    const bool is_total = !device::is_of_packets(what.fault.kind) ||
                          what.fault.kind == FaultKind::stall ||
                          (what.fault.share >= 1.0 && what.fault.packet == 0);
    const bool is_watched = naming.bits != kSilence || outcome.was_driving;
    const double after_s = naming.after_periods * what.period_s + naming.after_s;
    const double reported_s = after_s + kReported_periods * what.period_s;
    const bool lasts =
        is_latched(naming.kind) || what.fault.end_s - what.fault.begin_s >= reported_s;
    if (naming.must == TripCause::none || !is_total || !is_watched || !lasts) {
        return "";
    }
    if (!has_tripped || safety.cause != naming.must) {
        return "must trip by " +
               std::string(servo::kTripCauseNames[static_cast<std::size_t>(naming.must)]) +
               ", but: " + servo::description(safety);
    }
    if (outcome.tripped_after_s > reported_s) {
        return fmt::format("trips after {:.2f} ms, not {:.2f} ms", 1e3 * outcome.tripped_after_s,
                           1e3 * reported_s);
    }
    return "";
}

std::string summary(const StormCase &what, const StormOutcome &outcome) {
    const std::string_view direction = !device::is_of_packets(what.fault.kind) ? ""
                                       : what.fault.direction == Direction::in ? " in"
                                                                               : " out";
    const bool has_tripped = outcome.safety.state == servo::SafetyState::tripped;
    return fmt::format("{}{}: {}", device::name_of(what.fault.kind), direction,
                       has_tripped
                           ? servo::kTripCauseNames[static_cast<std::size_t>(outcome.safety.cause)]
                           : "tolerated");
}

} // namespace springdrive::testing
