// Covers device/usb/protocol.h; and replays inputs that the fuzzer found (tests/fuzz/run), for both
// ends of the wire protocol.
#include "device/usb/protocol.h"

#include "device/core/haptic_device.h"
#include "tests/fuzz/usb_targets.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <bitset>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace springdrive::usb {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// By the definition: long division of the message by the polynomial, most significant bit first,
/// on messages whose bytes are mirrored.
std::uint32_t crc32_by_division(const Bytes &message) {
    std::vector<bool> bits;
    for (const std::uint8_t byte : message) {
        for (int bit = 0; bit < 8; ++bit) {
            bits.push_back(((byte >> bit) & 1) != 0);
        }
    }
    bits.insert(bits.end(), 32, false);
    for (std::size_t i = 0; i < 32; ++i) {
        bits[i] = !bits[i];
    }
    const std::bitset<33> polynomial("100000100110000010001110110110111");
    for (std::size_t i = 0; i + 32 < bits.size(); ++i) {
        if (bits[i]) {
            for (std::size_t j = 0; j <= 32; ++j) {
                bits[i + j] = bits[i + j] != polynomial[32 - j];
            }
        }
    }
    std::uint32_t remainder = 0;
    for (std::size_t i = 0; i < 32; ++i) { // mirrored
        remainder |= static_cast<std::uint32_t>(!bits[bits.size() - 32 + i]) << i;
    }
    return remainder;
}

TEST(Crc32, HasTheCheckValue) {
    const Bytes digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(crc32(digits.data(), digits.size()), 0xcbf43926U);
    EXPECT_EQ(crc32_by_division(digits), 0xcbf43926U);
}

TEST(Crc32, AgreesWithLongDivision) {
    std::mt19937 random(1);
    for (std::size_t size = 1; size < 130; ++size) {
        Bytes message(size);
        for (std::uint8_t &byte : message) {
            byte = static_cast<std::uint8_t>(random());
        }
        EXPECT_EQ(crc32(message.data(), size), crc32_by_division(message)) << size;
    }
}

class Source {
public:
    explicit Source(std::uint32_t seed) : random_(seed) {}

    std::uint32_t bits() { return static_cast<std::uint32_t>(random_()); }
    bool flag() { return (bits() & 1U) != 0; }
    std::uint32_t up_to(std::uint32_t largest) { return bits() % (largest + 1); }
    /// Any finite float, with denormals and both zeros.
    float number() {
        for (;;) {
            const auto value = std::bit_cast<float>(bits());
            if (std::isfinite(value)) {
                return value;
            }
        }
    }
    Triple triple() {
        const float first = number();
        const float second = number();
        return {first, second, number()};
    }
    SymmetricMatrix matrix() {
        const Triple diagonal = triple();
        return truncated(SymmetricMatrix{diagonal, triple()});
    }

private:
    std::mt19937 random_;
};

Command random_command(Source &source) {
    Command command;
    command.number = source.bits();
    command.mode = static_cast<Mode>(source.up_to(2));
    command.begins_numbering = command.mode == Mode::brake && source.flag();
    command.resets_faults = command.mode == Mode::brake && source.flag();
    command.watchdog_us = static_cast<std::uint16_t>(
        kMinWatchdog_us + source.up_to(kMaxWatchdog_us - kMinWatchdog_us));
    command.report_after_us =
        source.flag() ? kKeepPhase : static_cast<std::uint16_t>(source.up_to(kMaxReportPeriod_us));
    command.e_W_V = source.triple();
    command.cancelled_resistance_Ohm = source.matrix();
    command.cancelled_inductance_H = source.matrix();
    return command;
}

void expect_equal(const SymmetricMatrix &left, const SymmetricMatrix &right) {
    EXPECT_EQ(left.diagonal, right.diagonal);
    EXPECT_EQ(left.off_diagonal, right.off_diagonal);
}

void expect_equal(const Command &left, const Command &right) {
    EXPECT_EQ(left.number, right.number);
    EXPECT_EQ(left.mode, right.mode);
    EXPECT_EQ(left.begins_numbering, right.begins_numbering);
    EXPECT_EQ(left.resets_faults, right.resets_faults);
    EXPECT_EQ(left.watchdog_us, right.watchdog_us);
    EXPECT_EQ(left.report_after_us, right.report_after_us);
    EXPECT_EQ(left.e_W_V, right.e_W_V);
    expect_equal(left.cancelled_resistance_Ohm, right.cancelled_resistance_Ohm);
    expect_equal(left.cancelled_inductance_H, right.cancelled_inductance_H);
}

Report random_report(Source &source) {
    Report report;
    report.number = source.bits();
    report.measured_at_us = source.bits();
    for (std::int32_t &counts : report.counts) {
        counts = static_cast<std::int32_t>(source.bits());
    }
    for (float &current_A : report.current_A) {
        current_A = source.up_to(9) == 0 ? kNotMeasured : truncated(source.number());
    }
    report.supply_V = source.flag() ? kNotMeasured : truncated(source.number());
    for (float &temperature_C : report.temperature_C) {
        temperature_C =
            source.flag() ? kNotMeasured : 0.25F * static_cast<float>(source.up_to(1200)) - 150.0F;
    }
    report.state = static_cast<BoardState>(source.up_to(kBoardStates - 1));
    report.is_enabled = source.flag();
    report.is_stopped = source.flag();
    report.has_command = source.flag();
    report.zeroings = static_cast<std::uint8_t>(source.up_to(15));
    report.faults = static_cast<std::uint16_t>(source.bits() & Faults::kKnown);
    report.limits = static_cast<std::uint8_t>(source.bits() & ActingLimits::kKnown);
    report.last_rejection = static_cast<FrameStatus>(source.up_to(kFrameStatuses - 1));
    report.rejected_frames = static_cast<std::uint16_t>(source.bits());
    report.command_number = source.bits();
    report.command_arrived_at_us = source.bits();
    report.applied_after_us = static_cast<std::uint16_t>(source.bits());
    return report;
}

void expect_same(float left, float right, float tolerance = 0.0F) {
    if (std::isnan(left) || std::isnan(right)) {
        EXPECT_EQ(std::isnan(left), std::isnan(right));
    } else {
        EXPECT_NEAR(left, right, tolerance);
    }
}

void expect_equal(const Report &left, const Report &right) {
    EXPECT_EQ(left.number, right.number);
    EXPECT_EQ(left.measured_at_us, right.measured_at_us);
    EXPECT_EQ(left.counts, right.counts);
    for (std::size_t i = 0; i < kChannels; ++i) {
        expect_same(left.current_A[i], right.current_A[i]);
    }
    expect_same(left.supply_V, right.supply_V);
    for (std::size_t i = 0; i < kTemperatures; ++i) {
        expect_same(left.temperature_C[i], right.temperature_C[i], 1e-4F);
    }
    EXPECT_EQ(left.state, right.state);
    EXPECT_EQ(left.is_enabled, right.is_enabled);
    EXPECT_EQ(left.is_stopped, right.is_stopped);
    EXPECT_EQ(left.has_command, right.has_command);
    EXPECT_EQ(left.zeroings, right.zeroings);
    EXPECT_EQ(left.faults, right.faults);
    EXPECT_EQ(left.limits, right.limits);
    EXPECT_EQ(left.last_rejection, right.last_rejection);
    EXPECT_EQ(left.rejected_frames, right.rejected_frames);
    EXPECT_EQ(left.command_number, right.command_number);
    EXPECT_EQ(left.command_arrived_at_us, right.command_arrived_at_us);
    EXPECT_EQ(left.applied_after_us, right.applied_after_us);
}

template <class Value> Value decoded(const auto &bytes) {
    Value value;
    EXPECT_EQ(decode(bytes.data(), bytes.size(), value), FrameStatus::ok);
    return value;
}

template <class Value> FrameStatus status_of(const auto &bytes) {
    Value value;
    return decode(bytes.data(), bytes.size(), value);
}

/// With a valid checksum again.
template <class Bytes> Bytes sealed(Bytes bytes) {
    const std::uint32_t crc = crc32(bytes.data(), bytes.size() - 4);
    for (std::size_t i = 0; i < 4; ++i) {
        bytes[bytes.size() - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
    }
    return bytes;
}

TEST(Protocol, FramesSurviveARoundTrip) {
    Source source(1);
    for (int i = 0; i < 20'000; ++i) {
        const Command command = random_command(source);
        expect_equal(decoded<Command>(encode(command)), command);
        const Report report = random_report(source);
        expect_equal(decoded<Report>(encode(report)), report);
    }
}

TEST(Protocol, Float24LosesAtMostOnePartIn2To15TowardsZero) {
    Source source(2);
    for (int i = 0; i < 100'000; ++i) {
        const float value = source.number();
        const double kept = truncated(value);
        EXPECT_LE(std::abs(kept), std::abs(static_cast<double>(value)));
        if (std::abs(value) > std::numeric_limits<float>::min()) {
            EXPECT_GE(std::abs(kept), std::abs(static_cast<double>(value)) * (1.0 - 0x1p-15));
        }
    }
    EXPECT_TRUE(std::isnan(truncated(std::bit_cast<float>(0x7f800001U)))); // not infinity
    EXPECT_NEAR(2.8F - truncated(std::nextafter(2.8F, 3.0F)), 0.0, 61.1e-6);
}

TEST(Protocol, EverySingleBitOfDamageIsRejected) {
    Source source(3);
    for (int trial = 0; trial < 20; ++trial) {
        const Frame command = encode(random_command(source));
        const Frame report = encode(random_report(source));
        for (std::size_t bit = 0; bit < 8 * kFrameSize; ++bit) {
            const auto flip = static_cast<std::uint8_t>(1U << (bit % 8));
            Frame damaged = command;
            damaged[bit / 8] ^= flip;
            EXPECT_EQ(status_of<Command>(damaged), FrameStatus::wrong_crc);
            damaged = report;
            damaged[bit / 8] ^= flip;
            EXPECT_EQ(status_of<Report>(damaged), FrameStatus::wrong_crc);
        }
    }
}

TEST(Protocol, EveryPairOfDamagedBitsIsRejected) {
    Source source(4);
    const Frame command = encode(random_command(source));
    for (std::size_t first = 0; first < 8 * kFrameSize; ++first) {
        for (std::size_t second = first + 1; second < 8 * kFrameSize; ++second) {
            Frame damaged = command;
            damaged[first / 8] ^= static_cast<std::uint8_t>(1U << (first % 8));
            damaged[second / 8] ^= static_cast<std::uint8_t>(1U << (second % 8));
            ASSERT_EQ(status_of<Command>(damaged), FrameStatus::wrong_crc);
        }
    }
}

TEST(Protocol, OtherSizesAreRejected) {
    const Frame frame = encode(Command());
    Bytes longer(frame.begin(), frame.end());
    longer.resize(3 * kFrameSize);
    for (std::size_t size = 0; size <= longer.size(); ++size) {
        Command command;
        EXPECT_EQ(decode(longer.data(), size, command),
                  size == kFrameSize ? FrameStatus::ok : FrameStatus::wrong_size);
    }
}

TEST(Protocol, NamesWhatIsWrong) {
    const auto changed = [](std::size_t position, std::uint8_t value) {
        Frame frame = encode(Command());
        frame[position] = value;
        return status_of<Command>(sealed(frame));
    };
    EXPECT_EQ(changed(0, kProtocolVersion + 1), FrameStatus::wrong_version);
    EXPECT_EQ(changed(1, static_cast<std::uint8_t>(Kind::report)), FrameStatus::wrong_kind);
    EXPECT_EQ(changed(2, 3), FrameStatus::unknown_value);
    EXPECT_EQ(changed(3, 4), FrameStatus::unknown_value);
    EXPECT_EQ(changed(2, 1), FrameStatus::ok);
    EXPECT_EQ(status_of<Report>(encode(Command())), FrameStatus::wrong_kind);
}

TEST(Protocol, RejectsCommandsThatAreNotFiniteOrOutOfRange) {
    const std::array<float, 3> bad{kNotMeasured, std::numeric_limits<float>::infinity(),
                                   -std::numeric_limits<float>::infinity()};
    for (const float value : bad) {
        for (std::size_t i = 0; i < 15; ++i) {
            Command command;
            const std::array<Triple *, 5> triples{&command.e_W_V,
                                                  &command.cancelled_resistance_Ohm.diagonal,
                                                  &command.cancelled_resistance_Ohm.off_diagonal,
                                                  &command.cancelled_inductance_H.diagonal,
                                                  &command.cancelled_inductance_H.off_diagonal};
            triples[i / 3]->at(i % 3) = value;
            EXPECT_EQ(status_of<Command>(encode(command)), FrameStatus::not_finite);
        }
    }
    const auto with = [](auto change) {
        Command command;
        change(command);
        return status_of<Command>(encode(command));
    };
    EXPECT_EQ(with([](Command &c) { c.watchdog_us = kMinWatchdog_us; }), FrameStatus::ok);
    EXPECT_EQ(with([](Command &c) { c.watchdog_us = kMinWatchdog_us - 1; }),
              FrameStatus::out_of_range);
    EXPECT_EQ(with([](Command &c) { c.watchdog_us = kMaxWatchdog_us; }), FrameStatus::ok);
    EXPECT_EQ(with([](Command &c) { c.watchdog_us = kMaxWatchdog_us + 1; }),
              FrameStatus::out_of_range);
    EXPECT_EQ(with([](Command &c) { c.report_after_us = 50'001; }), FrameStatus::out_of_range);
    for (const Mode mode : {Mode::drive, Mode::open}) {
        EXPECT_EQ(with([&](Command &c) { c.mode = mode, c.begins_numbering = true; }),
                  FrameStatus::out_of_range);
        EXPECT_EQ(with([&](Command &c) { c.mode = mode, c.resets_faults = true; }),
                  FrameStatus::out_of_range);
    }
}

TEST(Protocol, RandomBytesNeverPassAndChangeNothing) {
    Source source(5);
    Command command = random_command(source);
    const Command before = command;
    for (int i = 0; i < 200'000; ++i) {
        Bytes bytes(source.up_to(80));
        for (std::uint8_t &byte : bytes) {
            byte = static_cast<std::uint8_t>(source.bits());
        }
        EXPECT_NE(decode(bytes.data(), bytes.size(), command), FrameStatus::ok);
    }
    expect_equal(command, before);
}

/// Random contents in a valid envelope: whatever is accepted is finite, and encodes to the same.
TEST(Protocol, WhateverPassesEncodesToTheSameBytes) {
    Source source(6);
    int passed = 0;
    for (int i = 0; i < 300'000; ++i) {
        Frame frame;
        for (std::uint8_t &byte : frame) {
            byte = static_cast<std::uint8_t>(source.bits());
        }
        frame[0] = kProtocolVersion;
        frame[1] = 1;
        frame[2] %= 3;
        frame[3] = 0;
        frame = sealed(frame);
        Command command;
        if (decode(frame.data(), frame.size(), command) == FrameStatus::ok) {
            ++passed;
            EXPECT_EQ(encode(command), frame);
            EXPECT_TRUE(is_finite(command.e_W_V));
        }
    }
    EXPECT_GT(passed, 10'000); // not vacuous
}

/// The example of PROTOCOL.md, whose checksum was computed with Python's zlib.
TEST(Protocol, LayoutIsAsDocumented) {
    Command command;
    command.number = 0x01020304;
    command.mode = Mode::drive;
    command.watchdog_us = 5000;
    command.report_after_us = 800;
    command.e_W_V = {1.5F, -2.0F, 0.25F};
    command.cancelled_resistance_Ohm.diagonal = {1.5F, 1.75F, 2.0F};
    const Frame frame = encode(command);
    const Bytes start{0x01, 0x01, 0x01, 0x00, 0x04, 0x03, 0x02, 0x01, 0x88, 0x13, 0x20,
                      0x03, 0x00, 0x00, 0xc0, 0x3f, 0x00, 0x00, 0x00, 0xc0, 0x00, 0x00,
                      0x80, 0x3e, 0x00, 0xc0, 0x3f, 0x00, 0xe0, 0x3f, 0x00, 0x00, 0x40};
    EXPECT_EQ(Bytes(frame.begin(), frame.begin() + 33), start);
    const Bytes zeros(27, 0);
    EXPECT_EQ(Bytes(frame.begin() + 33, frame.begin() + 60), zeros);
    EXPECT_EQ(Bytes(frame.begin() + 60, frame.end()), (Bytes{0x64, 0x39, 0x89, 0x0a}));
}

template <class Value> bool fills_its_payload() {
    detail::ByteWriter<512> writer(detail::Layout<Value>::kKind);
    const Value value{};
    detail::Layout<Value>::exchange(writer, value);
    return writer.length() == detail::Layout<Value>::kSize;
}

TEST(Protocol, SizesAreThoseOfTheContents) {
    EXPECT_TRUE(fills_its_payload<Command>());
    EXPECT_TRUE(fills_its_payload<Report>());
    EXPECT_TRUE(fills_its_payload<Identity>());
    EXPECT_TRUE(fills_its_payload<Capabilities>());
    EXPECT_TRUE(fills_its_payload<Counters>());
    EXPECT_TRUE(fills_its_payload<Zeroing>());
    EXPECT_TRUE(fills_its_payload<ReportRate>());
    EXPECT_TRUE(fills_its_payload<CalibrationBlock>());
    EXPECT_TRUE(fills_its_payload<MotorCalibrationBlock>());
    EXPECT_TRUE(fills_its_payload<SelfTestOrder>());
    EXPECT_TRUE(fills_its_payload<SelfTestResult>());
}

Capabilities some_capabilities() {
    Capabilities board;
    board.couples_resistance = true;
    board.measures_supply = true;
    board.is_high_speed = true;
    board.measures_temperature = {true, false, true, true};
    board.loop_rate_hz = 40'000;
    board.counts_per_turn = {4096, 4000, 2000};
    board.largest_e_W_V = 12.0F;
    board.current_limit_A = 5.5F;
    board.largest_cancelled_Ohm = {2.1F, 2.2F, 2.3F};
    board.actuation_lag_s = 25e-6F;
    board.calibration_blocks = 4;
    return board;
}

TEST(Protocol, ControlPayloadsSurviveARoundTrip) {
    Identity identity;
    identity.firmware = {1, 2, 300};
    identity.hardware_revision = 7;
    identity.serial = {'A', '1'};
    identity.name = {'P', 'H', 'A', 'N', 'T', 'O', 'M'};
    EXPECT_EQ(encode(decoded<Identity>(encode(identity))), encode(identity));
    EXPECT_EQ(decoded<Identity>(encode(identity)).serial, identity.serial);

    const auto board = decoded<Capabilities>(encode(some_capabilities()));
    EXPECT_EQ(encode(board), encode(some_capabilities()));
    EXPECT_EQ(board.measures_temperature, some_capabilities().measures_temperature);
    EXPECT_EQ(board.counts_per_turn, some_capabilities().counts_per_turn);
    EXPECT_TRUE(board.couples_resistance && !board.couples_inductance && board.is_high_speed);

    const BoardCalibration calibration{{1.01F, 0.99F, 1.0F}, {2.2F, 2.1F, 0.0F}, {1, -1, 1}};
    const auto block = decoded<CalibrationBlock>(encode(block_of(calibration)));
    BoardCalibration read;
    EXPECT_EQ(calibration_in(block, read), FrameStatus::ok);
    EXPECT_EQ(read.current_gain, calibration.current_gain);
    EXPECT_EQ(read.encoder_sign, calibration.encoder_sign);

    for (const std::uint8_t layout : {std::uint8_t{1}, kMotorBlockLayout}) {
        MotorCalibrationBlock motor;
        motor.layout = layout;
        motor.air_error_dK = 20;
        motor.made_at_s = 1'764'000'000;
        for (std::size_t i = 0; i < motor.number.size(); ++i) {
            motor.number[i] = 2.1F * static_cast<float>(i + 1);
        }
        MotorCalibrationBlock found;
        ASSERT_EQ(calibration_in(block_of(motor, 2), found), FrameStatus::ok);
        for (std::size_t i = 0; i < motor.number.size(); ++i) {
            const float whole = i < 12 ? motor.number[i] : 0.0F;
            EXPECT_EQ(found.number[i], layout == 1 ? whole : truncated(motor.number[i])) << i;
        }
        motor.layout = 3;
        EXPECT_EQ(calibration_in(block_of(motor, 2), found), FrameStatus::out_of_range);
    }

    SelfTestResult result;
    result.state = SelfTestState::completed;
    result.channel[1].resistance_Ohm = 2.2F;
    result.channel[0].inductance_H = 0.2e-3F;
    result.channel[2].findings = ChannelFindings::kReversedEncoder;
    result.channel[2].moved_counts = {0, 3, -17};
    EXPECT_EQ(encode(decoded<SelfTestResult>(encode(result))), encode(result));

    EXPECT_EQ(decoded<Zeroing>(encode(Zeroing{{1, -2, 3}})).counts[1], -2);
    EXPECT_EQ(decoded<ReportRate>(encode(ReportRate{250})).period_us, 250U);
    EXPECT_EQ(decoded<SelfTestOrder>(encode(SelfTestOrder{0.5F, 5000})).pulse_us, 5000U);
    Counters counters;
    counters.frames[3] = 9;
    EXPECT_EQ(decoded<Counters>(encode(counters)).frames[3], 9U);
}

TEST(Protocol, InvalidControlPayloadsAreRejected) {
    Capabilities board = some_capabilities();
    board.loop_rate_hz = 0;
    EXPECT_EQ(status_of<Capabilities>(encode(board)), FrameStatus::out_of_range);
    board = some_capabilities();
    board.largest_e_W_V = kNotMeasured;
    EXPECT_EQ(status_of<Capabilities>(encode(board)), FrameStatus::not_finite);
    EXPECT_EQ(status_of<ReportRate>(encode(ReportRate{124})), FrameStatus::out_of_range);
    EXPECT_EQ(status_of<SelfTestOrder>(encode(SelfTestOrder{-1.0F, 5})), FrameStatus::out_of_range);
    Identity identity;
    identity.serial = {'\x1b'};
    EXPECT_EQ(status_of<Identity>(encode(identity)), FrameStatus::out_of_range);
    BoardCalibration calibration;
    calibration.encoder_sign[0] = 0;
    BoardCalibration read;
    EXPECT_EQ(calibration_in(block_of(calibration), read), FrameStatus::out_of_range);
}

TEST(Protocol, ABoardOfAnotherVersionIsIdentified) {
    Identity identity;
    identity.newest_version = 7;
    auto payload = encode(identity);
    payload[0] = 7;
    EXPECT_EQ(decoded<Identity>(sealed(payload)).newest_version, 7);
}

TEST(Protocol, NumbersRollOver) {
    EXPECT_EQ(difference(1, 0xffffffffU), 2);
    EXPECT_EQ(difference(0xffffffffU, 1), -2);
    EXPECT_EQ(difference(0x7fffffffU, 0), 0x7fffffff);
}

TEST(Protocol, ModesAndFaultsAreThoseOfTheDeviceInterface) {
    EXPECT_EQ(static_cast<int>(Mode::brake), static_cast<int>(device::CommandMode::brake));
    EXPECT_EQ(static_cast<int>(Mode::drive), static_cast<int>(device::CommandMode::drive));
    EXPECT_EQ(static_cast<int>(Mode::open), static_cast<int>(device::CommandMode::open));
    EXPECT_EQ(Faults::kAmplifier, device::BoardFaults::kAmplifier);
    EXPECT_EQ(Faults::kOverCurrent, device::BoardFaults::kOverCurrent);
    EXPECT_EQ(Faults::kTemperature, device::BoardFaults::kTemperature);
    EXPECT_EQ(Faults::kSupply, device::BoardFaults::kSupply);
    EXPECT_EQ(Faults::kEncoder, device::BoardFaults::kEncoder);
    EXPECT_EQ(Faults::kNoCommand, device::BoardFaults::kNoCommand);
}

} // namespace
} // namespace springdrive::usb

namespace springdrive::fuzz {

/// For GoogleTest.
inline void PrintTo(const UsbTarget &target, std::ostream *out) { *out << target.name; }

namespace {

namespace fs = std::filesystem;

std::vector<std::uint8_t> bytes_of(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

class FuzzCorpus : public ::testing::TestWithParam<UsbTarget> {};

TEST_P(FuzzCorpus, BreaksNothing) {
    const fs::path folder = testing::assets().parent_path() / "tests/fuzz/corpus";
    int files = 0;
    for (const auto &entry : fs::directory_iterator(folder / GetParam().name)) {
        const std::vector<std::uint8_t> input = bytes_of(entry.path());
        EXPECT_NO_THROW(GetParam().take(input)) << entry.path();
        // Cut off, the decisions after the end are others.
        EXPECT_NO_THROW(GetParam().take(std::span(input).first(input.size() / 2))) << entry.path();
        ++files;
    }
    EXPECT_GE(files, 10);
}

INSTANTIATE_TEST_SUITE_P(Usb, FuzzCorpus, ::testing::ValuesIn(kUsbTargets),
                         [](const ::testing::TestParamInfo<UsbTarget> &target) {
                             std::string name(target.param.name);
                             std::ranges::replace(name, '-', '_');
                             return name;
                         });

} // namespace
} // namespace springdrive::fuzz
