// The wire protocol between driver and board; PROTOCOL.md is its description for other languages.
//
//   driver ──► Command, 64 bytes ──► board      one of each in a servo tick, on interrupt endpoints
//   driver ◄── Report,  64 bytes ◄── board
//   driver ◄─► control requests on endpoint 0: identity, capabilities, zeroing, calibration, test
//
// Freestanding: no heap, exceptions or library calls, for driver, board and emulator alike. All
// numbers are little-endian, and are encoded and decoded byte by byte, so that neither alignment
// nor the order of bytes on a machine matters. Frames and payloads have a fixed size, the protocol
// version in their first byte, their kind in the second, and CRC-32 in the last four.
//
// `float24` is an IEEE 754 single without its lowest eight bits, truncated: at most 2^-15 closer to
// zero. With it both matrices fit one packet of 64 bytes, which full speed allows, too, and high
// speed in an interface's first setting. Of an R̂ of 2.8 Ω this is at most 61 µΩ, on the diagonal
// always less cancelled, where dR is at least 11 mΩ and a sensor's gain is known to 20 mΩ.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace springdrive::usb {

inline constexpr std::uint8_t kProtocolVersion = 1;

// Of pid.codes, for tests only: a board that is sold needs its own.
inline constexpr std::uint16_t kVendorId = 0x1209;
inline constexpr std::uint16_t kProductId = 0x0001;
inline constexpr std::uint8_t kInterfaceClass = 0xff; ///< vendor-specific
inline constexpr std::uint8_t kInterfaceSubclass = 0x53;
inline constexpr std::uint8_t kInterfaceProtocol = kProtocolVersion;

inline constexpr std::size_t kFrameSize = 64;
using Frame = std::array<std::uint8_t, kFrameSize>;

inline constexpr std::size_t kChannels = 3;
using Triple = std::array<float, kChannels>;

inline constexpr float kNotMeasured = std::numeric_limits<float>::quiet_NaN();

// Watchdog periods and report periods that a board may be asked for; capabilities narrow them.
inline constexpr std::uint16_t kMinWatchdog_us = 500;
inline constexpr std::uint16_t kMaxWatchdog_us = 50'000;
inline constexpr std::uint32_t kMinReportPeriod_us = 125;
inline constexpr std::uint32_t kMaxReportPeriod_us = 50'000;

/// A report's phase stays as it is: Command::report_after_us.
inline constexpr std::uint16_t kKeepPhase = 0xffff;
/// A command is not applied yet, or was applied later than this: Report::applied_after_us.
inline constexpr std::uint16_t kNotApplied = 0xffff;

/// What became of a frame or payload. The first that applies; from `beyond_limits` on, only a board
/// says so.
enum class FrameStatus : std::uint8_t {
    ok,
    wrong_size,
    wrong_crc,
    wrong_version,
    wrong_kind,
    unknown_value, ///< a mode, state, flag or index that this version does not have
    not_finite,
    out_of_range,  ///< a number that no board accepts
    beyond_limits, ///< of this board
    coupled,       ///< off-diagonal elements, to a board whose channels are independent
    repeated,      ///< the number of the last accepted command again
    stale,         ///< a number before that of the last accepted command
};
inline constexpr std::size_t kFrameStatuses = 12;

/// First byte after the version: frames, then control requests, of which it is also bRequest.
enum class Kind : std::uint8_t {
    command = 0x01,
    report = 0x02,
    identity = 0x10,     ///< in
    capabilities = 0x11, ///< in
    counters = 0x12,     ///< in
    zero = 0x20,         ///< out
    report_rate = 0x21,  ///< out
    calibration = 0x22,  ///< in and out; wValue is the block's index
    self_test = 0x23,    ///< out: starts it; in: its result
};

// bmRequestType of control requests: vendor, to the interface whose number is wIndex (requests to
// the device would not reach a function behind Linux's FunctionFS).
inline constexpr std::uint8_t kRequestIn = 0xc1;
inline constexpr std::uint8_t kRequestOut = 0x41;

/// What the amplifiers do; the same numbers as device::CommandMode.
enum class Mode : std::uint8_t { brake, drive, open };

/// A symmetric 3 × 3 matrix.
struct SymmetricMatrix {
    Triple diagonal{};     ///< (1,1), (2,2), (3,3)
    Triple off_diagonal{}; ///< (1,2), (1,3), (2,3)

    [[nodiscard]] constexpr bool is_diagonal() const {
        return off_diagonal[0] == 0.0F && off_diagonal[1] == 0.0F && off_diagonal[2] == 0.0F;
    }
};

/// From the driver. It holds until the next one, at most for the watchdog period.
struct Command {
    std::uint32_t number = 0; ///< one more than that of the previous command, modulo 2^32
    Mode mode = Mode::brake;
    bool begins_numbering = false; ///< accepted whatever its number; brakes
    bool resets_faults = false;    ///< clears faults whose causes have gone; brakes
    std::uint16_t watchdog_us = 5000;
    /// The next report is measured this long after this command's arrival.
    std::uint16_t report_after_us = kKeepPhase;
    Triple e_W_V{};
    SymmetricMatrix cancelled_resistance_Ohm; ///< R̂
    SymmetricMatrix cancelled_inductance_H;   ///< L̂; negative: inductance is added
};

/// State of a board. A number, once used, keeps its meaning.
enum class BoardState : std::uint8_t {
    starting, ///< windings open, current sensors' offsets are measured
    braking,
    driving,
    opened, ///< windings open on command
    testing,
    fault_braking, ///< until a reset
    fault_open,    ///< until a reset
};
inline constexpr std::size_t kBoardStates = 7;

/// Faults, one bit each; they latch until a reset. The first six are those of device::BoardFaults.
struct Faults {
    static constexpr std::uint16_t kAmplifier = 1U << 0U;   ///< a power stage: opens the windings
    static constexpr std::uint16_t kOverCurrent = 1U << 1U; ///< the board's own limit was reached
    static constexpr std::uint16_t kTemperature = 1U << 2U; ///< of power stages or motors
    static constexpr std::uint16_t kSupply = 1U << 3U;      ///< too high or too low
    static constexpr std::uint16_t kEncoder = 1U << 4U;     ///< a jump that no motor makes
    static constexpr std::uint16_t kNoCommand = 1U << 5U;   ///< none came in time
    static constexpr std::uint16_t kStop = 1U << 6U;        ///< stop switch or enable line
    static constexpr std::uint16_t kHeat = 1U << 7U;        ///< I²t of a winding
    static constexpr std::uint16_t kSensor = 1U << 8U;      ///< a current sensor: opens
    static constexpr std::uint16_t kOverrun = 1U << 9U;     ///< the amplifiers' loop was late
    static constexpr std::uint16_t kKnown = (1U << 10U) - 1U;
    /// A winding generates: R̂ is above R, or its encoder does not say how it turns. Nobody can tell
    /// which, so both are said, and the counts' zero is void.
    static constexpr std::uint16_t kGenerating = kOverCurrent | kEncoder;
};

/// Limits that act at the time of a report, one bit each.
struct ActingLimits {
    static constexpr std::uint8_t kVoltage = 1U << 0U; ///< e_A is scaled down to the supply
    static constexpr std::uint8_t kCurrent = 1U << 1U; ///< a winding is at the current limit
    static constexpr std::uint8_t kKnown = 3U;
};

/// Temperatures of a report, by index.
inline constexpr std::size_t kPowerStages = 0; ///< the hottest
inline constexpr std::size_t kFirstMotor = 1;
inline constexpr std::size_t kTemperatures = 4;

/// From the board: what it measured at one time, and its status then.
struct Report {
    std::uint32_t number = 0;         ///< one more than that of the previous report, modulo 2^32
    std::uint32_t measured_at_us = 0; ///< board time, modulo 2^32 (71.6 minutes)
    std::array<std::int32_t, kChannels> counts{}; ///< encoders
    Triple current_A{};                           ///< NaN: the sensor failed
    float supply_V = kNotMeasured;
    std::array<float, kTemperatures> temperature_C{kNotMeasured, kNotMeasured, kNotMeasured,
                                                   kNotMeasured};
    BoardState state = BoardState::starting;
    bool is_enabled = false;   ///< hardware enable line
    bool is_stopped = false;   ///< stop switch
    bool has_command = false;  ///< whether the four members from `command_number` on are valid
    std::uint8_t zeroings = 0; ///< since power-up, modulo 16: counts before and after differ
    std::uint16_t faults = 0;  ///< Faults
    std::uint8_t limits = 0;   ///< ActingLimits
    FrameStatus last_rejection = FrameStatus::ok; ///< of the last rejected frame, since power-up
    std::uint16_t rejected_frames = 0;            ///< since power-up, modulo 2^16
    std::uint32_t command_number = 0;             ///< of the last accepted command
    std::uint32_t command_arrived_at_us = 0;      ///< board time
    std::uint16_t applied_after_us = kNotApplied; ///< from its arrival to the windings
};

// Control payloads.

inline constexpr std::size_t kSerialSize = 16;
inline constexpr std::size_t kNameSize = 32;

struct Identity {
    std::uint8_t oldest_version = kProtocolVersion; ///< of the protocol, that the board accepts
    std::uint8_t newest_version = kProtocolVersion;
    std::array<std::uint16_t, 3> firmware{}; ///< major, minor, patch
    std::uint16_t hardware_revision = 0;
    std::array<char, kSerialSize> serial{}; ///< ASCII, padded with zeros
    std::array<char, kNameSize> name{};     ///< the same
};
inline constexpr std::size_t kIdentitySize = 64;

struct Capabilities {
    bool couples_resistance = false; ///< R̂ may have off-diagonal elements
    bool couples_inductance = false;
    bool cancels_inductance = false; ///< L̂ may differ from zero at all
    bool measures_supply = false;
    bool has_stop_switch = false;
    bool has_enable_line = false;
    std::array<bool, kTemperatures> measures_temperature{};
    bool is_high_speed = false; ///< the present connection
    std::uint32_t loop_rate_hz = 0;
    std::array<std::uint32_t, kChannels> counts_per_turn{};
    float largest_e_W_V = 0.0F;
    float current_limit_A = 0.0F;
    float current_range_A = 0.0F; ///< of the sensors
    float current_resolution_A = 0.0F;
    float smallest_supply_V = 0.0F;
    float largest_supply_V = 0.0F;
    Triple largest_cancelled_Ohm{};   ///< diag(this) − R̂ must be positive definite; when cold
    float largest_added_Ohm = 0.0F;   ///< R̂ + this must be positive definite
    float largest_cancelled_H = 0.0F; ///< the same for L̂
    float largest_added_H = 0.0F;     ///< the same
    float lead_bandwidth_rad_per_s = 0.0F; ///< of di/dt
    float actuation_lag_s = 0.0F; ///< from sampling currents to the middle of the voltage's action
    std::uint32_t shortest_watchdog_us = kMinWatchdog_us;
    std::uint32_t longest_watchdog_us = kMaxWatchdog_us;
    std::uint32_t shortest_report_period_us = kMinReportPeriod_us; ///< at the present speed
    std::uint32_t longest_report_period_us = kMaxReportPeriod_us;
    std::uint16_t calibration_blocks = 0;
};
inline constexpr std::size_t kCapabilitiesSize = 100;

struct Counters {
    /// Commands by what became of them, indexed by FrameStatus; [ok] were accepted.
    std::array<std::uint32_t, kFrameStatuses> frames{};
    std::uint32_t silences = 0;         ///< of commands, while driving
    std::uint32_t late_loops = 0;       ///< of the amplifiers
    std::uint32_t reports_replaced = 0; ///< by newer ones, before the host collected them
};
inline constexpr std::size_t kCountersSize = 68;

/// The counts that the present angles shall have.
struct Zeroing {
    std::array<std::int32_t, kChannels> counts{};
};
inline constexpr std::size_t kZeroingSize = 20;

struct ReportRate {
    std::uint32_t period_us = 1000;
};
inline constexpr std::size_t kReportRateSize = 12;

inline constexpr std::size_t kCalibrationBytes = 56;
/// Block 0 is the board's own, BoardCalibration; the others are the host's.
struct CalibrationBlock {
    std::uint16_t index = 0;
    std::array<std::uint8_t, kCalibrationBytes> bytes{};
};
inline constexpr std::size_t kCalibrationBlockSize = 64;

/// Contents of calibration block 0, which the board uses itself.
struct BoardCalibration {
    Triple current_gain{1.0F, 1.0F, 1.0F}; ///< true current per measured
    Triple largest_cancelled_Ohm{};        ///< of a winding at 25 °C; 0: the board's default
    std::array<std::int8_t, kChannels> encoder_sign{1, 1, 1}; ///< 1 or −1
};

/// Layout of the blocks from kFirstMotorBlock on: 1 has twelve numbers, each with 32 bits.
inline constexpr std::uint8_t kMotorBlockLayout = 2;
/// Calibration block of the first motor; the others follow. Blocks full of zeros hold none.
inline constexpr std::uint16_t kFirstMotorBlock = 1;

/// Contents of a motor's calibration block, which the host uses.
struct MotorCalibrationBlock {
    std::uint8_t layout = kMotorBlockLayout;
    std::uint8_t air_error_dK = 0; ///< of the air's temperature, in 0.1 K
    std::int16_t air_cC = 0;       ///< in 0.01 °C
    std::uint32_t made_at_s = 0;   ///< UTC, since 1970; the same in all three blocks
    /// Those of a device file's [[calibration.motor]], in order, as float24.
    std::array<float, 16> number{};
};

/// A board needs as many loops for each pulse.
inline constexpr std::uint32_t kMinPulse_loops = 320;

struct SelfTestOrder {
    float voltage_V = 0.0F;
    std::uint32_t pulse_us = 0; ///< one of each sign on each channel
};
inline constexpr std::size_t kSelfTestOrderSize = 16;

enum class SelfTestState : std::uint8_t { never, running, completed, aborted };

/// Findings on a channel, one bit each.
struct ChannelFindings {
    static constexpr std::uint16_t kOpenWinding = 1U << 0U;     ///< hardly any current
    static constexpr std::uint16_t kReversedSensor = 1U << 1U;  ///< current against the voltage
    static constexpr std::uint16_t kCrossedSensor = 1U << 2U;   ///< current in another channel
    static constexpr std::uint16_t kNoMotion = 1U << 3U;        ///< held, or no encoder
    static constexpr std::uint16_t kReversedEncoder = 1U << 4U; ///< counts against the voltage
    static constexpr std::uint16_t kCrossedEncoder = 1U << 5U;  ///< another counts more
    static constexpr std::uint16_t kLimit = 1U << 6U;           ///< aborted by a limit
    static constexpr std::uint16_t kKnown = (1U << 7U) - 1U;
};

struct ChannelTest {
    float resistance_Ohm = kNotMeasured; ///< as the current sensor sees it
    float inductance_H = kNotMeasured;   ///< the same
    std::uint16_t findings = 0;
    std::array<std::int16_t, kChannels> moved_counts{}; ///< of each encoder, for a positive voltage
};

struct SelfTestResult {
    SelfTestState state = SelfTestState::never;
    std::array<ChannelTest, kChannels> channel;
};
inline constexpr std::size_t kSelfTestResultSize = 56;

/// Difference of two numbers or board times modulo 2^32, later minus earlier; negative if `later`
/// is the earlier one. Right while they are less than 2^31 apart (of times: 35 minutes).
[[nodiscard]] constexpr std::int32_t difference(std::uint32_t later, std::uint32_t earlier) {
    return static_cast<std::int32_t>(later - earlier);
}

namespace detail {

inline constexpr std::uint32_t kReflectedPolynomial = 0xedb88320U;

constexpr std::array<std::uint32_t, 16> nibble_table() {
    std::array<std::uint32_t, 16> table{};
    for (std::uint32_t i = 0; i < 16; ++i) {
        std::uint32_t remainder = i;
        for (int bit = 0; bit < 4; ++bit) {
            remainder = (remainder >> 1U) ^ ((remainder & 1U) != 0 ? kReflectedPolynomial : 0U);
        }
        table[i] = remainder;
    }
    return table;
}

inline constexpr std::array<std::uint32_t, 16> kNibbleTable = nibble_table();

} // namespace detail

/// CRC-32 of IEEE 802.3 and zlib: polynomial 0x04c11db7, reflected, initially and finally inverted.
/// That of "123456789" is 0xcbf43926.
[[nodiscard]] constexpr std::uint32_t crc32(const std::uint8_t *data, std::size_t size) {
    std::uint32_t crc = 0xffffffffU;
    for (std::size_t i = 0; i < size; ++i) {
        crc ^= data[i];
        crc = (crc >> 4U) ^ detail::kNibbleTable[crc & 15U];
        crc = (crc >> 4U) ^ detail::kNibbleTable[crc & 15U];
    }
    return ~crc;
}

[[nodiscard]] constexpr bool is_finite(float value) {
    return (std::bit_cast<std::uint32_t>(value) & 0x7f800000U) != 0x7f800000U;
}
[[nodiscard]] constexpr bool is_nan(float value) {
    return (std::bit_cast<std::uint32_t>(value) & 0x7fffffffU) > 0x7f800000U;
}
[[nodiscard]] constexpr bool is_finite(const Triple &values) {
    return is_finite(values[0]) && is_finite(values[1]) && is_finite(values[2]);
}
[[nodiscard]] constexpr bool is_finite(const SymmetricMatrix &matrix) {
    return is_finite(matrix.diagonal) && is_finite(matrix.off_diagonal);
}
[[nodiscard]] constexpr bool is_infinite(float value) {
    return !is_finite(value) && !is_nan(value);
}

/// What remains of a value that is sent as `float24`.
[[nodiscard]] constexpr float truncated(float value) {
    return is_nan(value) ? kNotMeasured
                         : std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & 0xffffff00U);
}
[[nodiscard]] constexpr SymmetricMatrix truncated(const SymmetricMatrix &matrix) {
    SymmetricMatrix sent;
    for (std::size_t i = 0; i < kChannels; ++i) {
        sent.diagonal[i] = truncated(matrix.diagonal[i]);
        sent.off_diagonal[i] = truncated(matrix.off_diagonal[i]);
    }
    return sent;
}

// Encoding and decoding. The layout of each frame and payload is one function, `Layout::exchange`,
// which a `ByteWriter` runs over a value to encode it, and a `ByteReader` to decode it.

namespace detail {

inline constexpr std::size_t kEnvelopeStart = 2; ///< version and kind
inline constexpr std::size_t kEnvelopeEnd = 4;   ///< checksum

inline constexpr std::int32_t kNoTemperature = -32768; ///< of 0.01 °C

constexpr std::int32_t centidegrees(float temperature_C) {
    constexpr float kMax_C = 327.0F;
    if (!is_finite(temperature_C)) {
        return kNoTemperature;
    }
    const float above_C = temperature_C < -kMax_C ? -kMax_C : temperature_C;
    const float limited_C = above_C > kMax_C ? kMax_C : above_C;
    return static_cast<std::int32_t>(limited_C * 100.0F + (limited_C < 0.0F ? -0.5F : 0.5F));
}

/// Writes version, kind, numbers one after the other, and the checksum into the last four bytes.
template <std::size_t size> class ByteWriter {
public:
    constexpr explicit ByteWriter(Kind kind) {
        bytes(kProtocolVersion, 1);
        bytes(static_cast<std::uint32_t>(kind), 1);
    }

    template <class Integer> constexpr void number(Integer value) {
        bytes(static_cast<std::uint32_t>(value), sizeof(Integer));
    }
    constexpr void number(float value) { bytes(std::bit_cast<std::uint32_t>(value), 4); }
    template <class Value, std::size_t count>
    constexpr void number(const std::array<Value, count> &values) {
        for (const Value &value : values) {
            number(value);
        }
    }
    constexpr void float24(float value) {
        bytes(std::bit_cast<std::uint32_t>(truncated(value)) >> 8U, 3);
    }
    constexpr void temperature(float value_C) {
        bytes(static_cast<std::uint32_t>(centidegrees(value_C)), 2);
    }
    template <class Choice> constexpr void choice(Choice value, std::size_t /*choices*/) {
        bytes(static_cast<std::uint32_t>(value), 1);
    }
    /// Numbers of a few bits each share a byte.
    template <class Part> constexpr void part(Part value, std::uint32_t bits) {
        part_ |= static_cast<std::uint32_t>(value) << part_bits_;
        part_bits_ += bits;
        if (part_bits_ >= 8) {
            bytes(part_, 1);
            part_ = 0;
            part_bits_ = 0;
        }
    }
    constexpr void unused_part(std::uint32_t bits) { part(0U, bits); }
    constexpr void skip(std::uint32_t count) { bytes(0, count); }

    [[nodiscard]] constexpr std::size_t length() const { return next_ + kEnvelopeEnd; }

    [[nodiscard]] constexpr std::array<std::uint8_t, size> sealed() {
        next_ = size - kEnvelopeEnd;
        bytes(crc32(data_.data(), next_), 4);
        return data_;
    }

private:
    constexpr void bytes(std::uint32_t value, std::size_t count) {
        for (std::size_t i = 0; i < count && next_ < size; ++i) {
            data_[next_++] = static_cast<std::uint8_t>(value & 0xffU);
            value >>= 8U;
        }
    }

    std::array<std::uint8_t, size> data_{};
    std::size_t next_ = 0;
    std::uint32_t part_ = 0;
    std::uint32_t part_bits_ = 0;
};

/// Reads what a ByteWriter wrote, and notes what is wrong with it. Beyond the end it reads zeros.
class ByteReader {
public:
    constexpr ByteReader(const std::uint8_t *data, std::size_t size) : data_(data), size_(size) {}

    template <class Integer> constexpr void number(Integer &value) {
        value = static_cast<Integer>(bytes(sizeof(Integer)));
    }
    constexpr void number(float &value) { value = noted(std::bit_cast<float>(bytes(4))); }
    template <class Value, std::size_t count>
    constexpr void number(std::array<Value, count> &values) {
        for (Value &value : values) {
            number(value);
        }
    }
    constexpr void float24(float &value) { value = noted(std::bit_cast<float>(bytes(3) << 8U)); }
    constexpr void temperature(float &value_C) {
        const std::int32_t read = static_cast<std::int16_t>(bytes(2));
        value_C = read == kNoTemperature ? kNotMeasured : 0.01F * static_cast<float>(read);
    }
    template <class Choice> constexpr void choice(Choice &value, std::size_t choices) {
        const std::uint32_t read = bytes(1);
        has_unknown_ = has_unknown_ || read >= choices;
        value = static_cast<Choice>(read);
    }
    template <class Part> constexpr void part(Part &value, std::uint32_t bits) {
        if (part_bits_ == 0) {
            part_ = bytes(1);
        }
        value = static_cast<Part>((part_ >> part_bits_) & ((1U << bits) - 1U));
        part_bits_ = (part_bits_ + bits) % 8U;
    }
    constexpr void unused_part(std::uint32_t bits) {
        std::uint32_t value = 0;
        part(value, bits);
        has_unknown_ = has_unknown_ || value != 0;
    }
    constexpr void skip(std::uint32_t count) { has_unknown_ = bytes(count) != 0 || has_unknown_; }

    [[nodiscard]] constexpr bool has_unknown() const { return has_unknown_; }
    [[nodiscard]] constexpr bool has_nan() const { return has_nan_; }
    [[nodiscard]] constexpr bool has_infinity() const { return has_infinity_; }

private:
    constexpr float noted(float value) {
        has_nan_ = has_nan_ || is_nan(value);
        has_infinity_ = has_infinity_ || is_infinite(value);
        return value;
    }
    constexpr std::uint32_t bytes(std::size_t count) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count && next_ < size_; ++i) {
            value |= static_cast<std::uint32_t>(data_[next_++]) << (8U * i);
        }
        return value;
    }

    const std::uint8_t *data_;
    std::size_t size_;
    std::size_t next_ = kEnvelopeStart;
    std::uint32_t part_ = 0;
    std::uint32_t part_bits_ = 0;
    bool has_unknown_ = false;
    bool has_nan_ = false;
    bool has_infinity_ = false;
};

template <class Wire, class Matrix> constexpr void exchange_matrix(Wire &wire, Matrix &matrix) {
    for (auto &element : matrix.diagonal) {
        wire.float24(element);
    }
    for (auto &element : matrix.off_diagonal) {
        wire.float24(element);
    }
}

/// `exchange` is the layout after version and kind; `is_valid` checks ranges.
template <class Value> struct Layout;

/// What all layouts have.
template <Kind kind, std::size_t size, bool may_be_nan = false> struct Shape {
    static constexpr Kind kKind = kind;
    static constexpr std::size_t kSize = size;
    static constexpr bool kMayBeNan = may_be_nan;
};

template <> struct Layout<Command> : Shape<Kind::command, kFrameSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &command) {
        wire.choice(command.mode, 3);
        wire.part(command.begins_numbering, 1);
        wire.part(command.resets_faults, 1);
        wire.unused_part(6);
        wire.number(command.number);
        wire.number(command.watchdog_us);
        wire.number(command.report_after_us);
        wire.number(command.e_W_V);
        exchange_matrix(wire, command.cancelled_resistance_Ohm);
        exchange_matrix(wire, command.cancelled_inductance_H);
    }
    static constexpr bool is_valid(const Command &command) {
        return command.watchdog_us >= kMinWatchdog_us && command.watchdog_us <= kMaxWatchdog_us &&
               (command.report_after_us <= kMaxReportPeriod_us ||
                command.report_after_us == kKeepPhase) &&
               (command.mode == Mode::brake ||
                !(command.begins_numbering || command.resets_faults));
    }
};

template <> struct Layout<Report> : Shape<Kind::report, kFrameSize, true> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &report) {
        wire.choice(report.state, kBoardStates);
        wire.part(report.is_enabled, 1);
        wire.part(report.is_stopped, 1);
        wire.part(report.has_command, 1);
        wire.unused_part(1);
        wire.part(report.zeroings, 4);
        wire.number(report.number);
        wire.number(report.measured_at_us);
        wire.number(report.counts);
        for (auto &current_A : report.current_A) {
            wire.float24(current_A);
        }
        wire.float24(report.supply_V);
        for (auto &temperature_C : report.temperature_C) {
            wire.temperature(temperature_C);
        }
        wire.number(report.faults);
        wire.number(report.limits);
        wire.choice(report.last_rejection, kFrameStatuses);
        wire.number(report.command_number);
        wire.number(report.command_arrived_at_us);
        wire.number(report.applied_after_us);
        wire.number(report.rejected_frames);
    }
    static constexpr bool is_valid(const Report &report) {
        return (report.faults & ~Faults::kKnown) == 0 &&
               (report.limits & ~ActingLimits::kKnown) == 0;
    }
};

/// Of every version of the protocol: `kIsOfAnyVersion`, so that a driver can name the board's.
template <> struct Layout<Identity> : Shape<Kind::identity, kIdentitySize> {
    static constexpr bool kIsOfAnyVersion = true;
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &identity) {
        wire.number(identity.oldest_version);
        wire.number(identity.newest_version);
        wire.number(identity.firmware);
        wire.number(identity.hardware_revision);
        wire.number(identity.serial);
        wire.number(identity.name);
    }
    template <std::size_t size> static constexpr bool is_text(const std::array<char, size> &text) {
        bool is_over = false;
        for (const char letter : text) {
            const bool is_printable = letter >= ' ' && letter <= '~';
            is_over = is_over || letter == '\0';
            if (is_over ? letter != '\0' : !is_printable) {
                return false;
            }
        }
        return true;
    }
    static constexpr bool is_valid(const Identity &identity) {
        return is_text(identity.serial) && is_text(identity.name) &&
               identity.oldest_version <= identity.newest_version;
    }
};

template <> struct Layout<Capabilities> : Shape<Kind::capabilities, kCapabilitiesSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &board) {
        wire.part(board.couples_resistance, 1);
        wire.part(board.couples_inductance, 1);
        wire.part(board.cancels_inductance, 1);
        wire.part(board.measures_supply, 1);
        wire.part(board.has_stop_switch, 1);
        wire.part(board.has_enable_line, 1);
        wire.part(board.is_high_speed, 1);
        wire.unused_part(1);
        for (auto &is_measured : board.measures_temperature) {
            wire.part(is_measured, 1);
        }
        wire.unused_part(4);
        wire.number(board.loop_rate_hz);
        wire.number(board.counts_per_turn);
        wire.number(board.largest_e_W_V);
        wire.number(board.current_limit_A);
        wire.number(board.current_range_A);
        wire.number(board.current_resolution_A);
        wire.number(board.smallest_supply_V);
        wire.number(board.largest_supply_V);
        wire.number(board.largest_cancelled_Ohm);
        wire.number(board.largest_added_Ohm);
        wire.number(board.largest_cancelled_H);
        wire.number(board.largest_added_H);
        wire.number(board.lead_bandwidth_rad_per_s);
        wire.number(board.actuation_lag_s);
        wire.number(board.shortest_watchdog_us);
        wire.number(board.longest_watchdog_us);
        wire.number(board.shortest_report_period_us);
        wire.number(board.longest_report_period_us);
        wire.number(board.calibration_blocks);
        wire.skip(2);
    }
    static constexpr bool is_valid(const Capabilities &board) {
        for (const float largest_Ohm : board.largest_cancelled_Ohm) {
            if (!(largest_Ohm >= 0.0F)) {
                return false;
            }
        }
        return board.loop_rate_hz > 0 && board.counts_per_turn[0] > 0 &&
               board.counts_per_turn[1] > 0 && board.counts_per_turn[2] > 0 &&
               board.largest_e_W_V > 0.0F && board.current_limit_A > 0.0F &&
               board.shortest_watchdog_us <= board.longest_watchdog_us &&
               board.shortest_watchdog_us <= kMaxWatchdog_us &&
               board.longest_watchdog_us >= kMinWatchdog_us &&
               board.shortest_report_period_us <= board.longest_report_period_us &&
               board.shortest_report_period_us >= kMinReportPeriod_us &&
               board.longest_report_period_us <= kMaxReportPeriod_us;
    }
};

template <> struct Layout<Counters> : Shape<Kind::counters, kCountersSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &counters) {
        wire.skip(2);
        wire.number(counters.frames);
        wire.number(counters.silences);
        wire.number(counters.late_loops);
        wire.number(counters.reports_replaced);
    }
    static constexpr bool is_valid(const Counters & /*any*/) { return true; }
};

template <> struct Layout<Zeroing> : Shape<Kind::zero, kZeroingSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &zeroing) {
        wire.skip(2);
        wire.number(zeroing.counts);
    }
    static constexpr bool is_valid(const Zeroing & /*any*/) { return true; }
};

template <> struct Layout<ReportRate> : Shape<Kind::report_rate, kReportRateSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &rate) {
        wire.skip(2);
        wire.number(rate.period_us);
    }
    static constexpr bool is_valid(const ReportRate &rate) {
        return rate.period_us >= kMinReportPeriod_us && rate.period_us <= kMaxReportPeriod_us;
    }
};

template <> struct Layout<CalibrationBlock> : Shape<Kind::calibration, kCalibrationBlockSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &block) {
        wire.number(block.index);
        wire.number(block.bytes);
    }
    static constexpr bool is_valid(const CalibrationBlock & /*any*/) { return true; }
};

/// As the contents of block 0.
template <> struct Layout<BoardCalibration> : Shape<Kind::calibration, kCalibrationBlockSize> {
    template <class Wire, class Value>
    static constexpr void exchange(Wire &wire, Value &calibration) {
        wire.skip(2);
        wire.number(calibration.current_gain);
        wire.number(calibration.largest_cancelled_Ohm);
        wire.number(calibration.encoder_sign);
    }
    static constexpr bool is_valid(const BoardCalibration &calibration) {
        for (std::size_t i = 0; i < kChannels; ++i) {
            const float gain = calibration.current_gain[i];
            const std::int8_t sign = calibration.encoder_sign[i];
            if (!(gain >= 0.8F && gain <= 1.25F && calibration.largest_cancelled_Ohm[i] >= 0.0F) ||
                (sign != 1 && sign != -1)) {
                return false;
            }
        }
        return true;
    }
};

/// As the contents of its block.
template <> struct Layout<MotorCalibrationBlock> : Shape<Kind::calibration, kCalibrationBlockSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &motor) {
        wire.skip(2);
        wire.number(motor.layout);
        wire.number(motor.air_error_dK);
        wire.number(motor.air_cC);
        wire.number(motor.made_at_s);
        for (std::size_t i = 0; i < motor.number.size(); ++i) {
            if (motor.layout != 1) {
                wire.float24(motor.number[i]);
            } else if (i < 12) {
                wire.number(motor.number[i]);
            }
        }
    }
    static constexpr bool is_valid(const MotorCalibrationBlock &motor) {
        return (motor.layout == 1 || motor.layout == kMotorBlockLayout) && motor.air_error_dK > 0 &&
               motor.made_at_s > 0;
    }
};

template <> struct Layout<SelfTestOrder> : Shape<Kind::self_test, kSelfTestOrderSize> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &order) {
        wire.skip(2);
        wire.number(order.voltage_V);
        wire.number(order.pulse_us);
    }
    static constexpr bool is_valid(const SelfTestOrder &order) {
        return order.voltage_V > 0.0F && order.pulse_us > 0;
    }
};

template <> struct Layout<SelfTestResult> : Shape<Kind::self_test, kSelfTestResultSize, true> {
    template <class Wire, class Value> static constexpr void exchange(Wire &wire, Value &result) {
        wire.choice(result.state, 4);
        wire.skip(1);
        for (auto &channel : result.channel) {
            wire.number(channel.resistance_Ohm);
            wire.number(channel.inductance_H);
            wire.number(channel.findings);
            wire.number(channel.moved_counts);
        }
    }
    static constexpr bool is_valid(const SelfTestResult &result) {
        return ((result.channel[0].findings | result.channel[1].findings |
                 result.channel[2].findings) &
                ~ChannelFindings::kKnown) == 0;
    }
};

/// Size, checksum, version, kind. The checksum comes before the version: of every version it is in
/// the last four bytes, so a wrong version is no damage.
constexpr FrameStatus check_envelope(const std::uint8_t *data, std::size_t size,
                                     std::size_t expected_size, Kind kind) {
    if (size != expected_size) {
        return FrameStatus::wrong_size;
    }
    std::uint32_t sent = 0;
    for (std::size_t i = 0; i < kEnvelopeEnd; ++i) {
        sent |= static_cast<std::uint32_t>(data[size - kEnvelopeEnd + i]) << (8U * i);
    }
    if (sent != crc32(data, size - kEnvelopeEnd)) {
        return FrameStatus::wrong_crc;
    }
    if (data[0] != kProtocolVersion) {
        return FrameStatus::wrong_version;
    }
    return data[1] == static_cast<std::uint8_t>(kind) ? FrameStatus::ok : FrameStatus::wrong_kind;
}

} // namespace detail

/// A frame or payload as bytes. Any value can be encoded, valid or not.
template <class Value>
[[nodiscard]] constexpr std::array<std::uint8_t, detail::Layout<Value>::kSize>
encode(const Value &value) {
    detail::ByteWriter<detail::Layout<Value>::kSize> writer(detail::Layout<Value>::kKind);
    detail::Layout<Value>::exchange(writer, value);
    return writer.sealed();
}

/// @return why the bytes are invalid; `value` is then unchanged
template <class Value>
[[nodiscard]] constexpr FrameStatus decode(const std::uint8_t *data, std::size_t size,
                                           Value &value) {
    using Layout = detail::Layout<Value>;
    if (const FrameStatus status = detail::check_envelope(data, size, Layout::kSize, Layout::kKind);
        status != FrameStatus::ok) {
        if (!(status == FrameStatus::wrong_version && requires { Layout::kIsOfAnyVersion; })) {
            return status;
        }
    }
    detail::ByteReader reader(data, size);
    Value read;
    Layout::exchange(reader, read);
    if (reader.has_unknown()) {
        return FrameStatus::unknown_value;
    }
    if (reader.has_infinity() || (reader.has_nan() && !Layout::kMayBeNan)) {
        return FrameStatus::not_finite;
    }
    if (!Layout::is_valid(read)) {
        return FrameStatus::out_of_range;
    }
    value = read;
    return FrameStatus::ok;
}

/// A calibration, the board's or a motor's, as the block with this index.
template <class Calibration>
[[nodiscard]] constexpr CalibrationBlock block_of(const Calibration &calibration,
                                                  std::uint16_t index = 0) {
    CalibrationBlock block;
    block.index = index;
    const auto payload = encode(calibration);
    for (std::size_t i = 0; i < kCalibrationBytes; ++i) {
        block.bytes[i] = payload[i + 4];
    }
    return block;
}

/// @return why its contents are no such calibration; `calibration` is then unchanged
template <class Calibration>
[[nodiscard]] constexpr FrameStatus calibration_in(const CalibrationBlock &block,
                                                   Calibration &calibration) {
    CalibrationBlock contents = block;
    contents.index = 0; // the contents have zeros in its place
    const auto payload = encode(contents);
    return decode(payload.data(), payload.size(), calibration);
}

} // namespace springdrive::usb
