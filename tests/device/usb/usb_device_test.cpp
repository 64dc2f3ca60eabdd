// The driver against the board's core in process: with a frame clock, and with time and jitter.
#include "device/usb/driver/usb_device.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/emulated_port.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace springdrive::usb {
namespace {

using device::Arrival;
using device::DeviceHealth;
using device::Measurement;
using emulator::BoardClock;
using emulator::EmulatedBoard;
using emulator::EmulatedBoardOptions;
using testing::EmulatedPort;

constexpr double kTick_s = 1e-3;

EmulatedBoardOptions options(double delay_periods = 0.3) {
    EmulatedBoardOptions options;
    options.start_tip_m = testing::kOffCentre_m;
    options.delay_periods = delay_periods;
    return options;
}

/// A board, and a driver that is connected to it.
struct Connected {
    explicit Connected(const EmulatedBoardOptions &options = usb::options(),
                       const device::DeviceDescription &description = testing::phantom_1_0())
        : board(description, options), port(new EmulatedPort(board)),
          device(std::unique_ptr<BoardPort>(port), description, "", kTick_s, Pacing::reports) {}

    Measurement tick(const device::DeviceCommand &command = device::DeviceCommand::braking()) {
        Measurement measured = device.read();
        device::DeviceCommand answer = command;
        answer.number = measured.number;
        device.write(answer);
        return measured;
    }

    void ticks(int count, const device::DeviceCommand &command = device::DeviceCommand::braking()) {
        for (int i = 0; i < count; ++i) {
            tick(command);
        }
    }
    /// Faults are gone once it has seen the command.
    void reset() {
        device::DeviceCommand command = device::DeviceCommand::braking();
        command.resets_faults = true;
        tick(command);
        tick();
        EXPECT_FALSE(tick().faults.any());
    }
    /// The hand moves the tip, so that a reversed encoder is at another angle.
    void move_hand() {
        board.phantom().set_hand_target(testing::kOffCentre_m + Vector3(0.0, 0.03, 0.03));
        ticks(500);
    }

    [[nodiscard]] board::State state() const { return board.board().loop().state(); }

    EmulatedBoard board;
    EmulatedPort *port; ///< of the device
    UsbDevice device;
};

device::DeviceCommand driving(double e_W_V = 1.0) {
    device::DeviceCommand command;
    command.e_W_V = Vector3::Constant(e_W_V);
    command.cancelled_resistance_Ohm = Vector3::Constant(1.0);
    return command;
}

Vector3 theta_rad(const Measurement &measured, const device::DeviceDescription &description) {
    return description.rad_per_count() *
           Vector3(measured.counts[0], measured.counts[1], measured.counts[2]);
}

TEST(UsbDevice, ConnectsAndSaysWhatItIs) {
    Connected rig;
    EXPECT_EQ(rig.device.identity().kind, "USB");
    EXPECT_EQ(rig.device.identity().serial, "emulated");
    EXPECT_EQ(rig.device.clock(), device::DeviceClock::own);
    EXPECT_FALSE(rig.device.is_zeroed());
    const Measurement measured = rig.tick();
    EXPECT_EQ(measured.health, DeviceHealth::ok);
    EXPECT_EQ(measured.arrival, Arrival::fresh);
    EXPECT_NEAR(measured.supply_V, 15.0, 0.5);
    EXPECT_EQ(rig.device.link()->speed, "high speed (480 Mbit/s)");
}

TEST(UsbDevice, GivesTheRotorsAnglesOnceZeroed) {
    Connected rig;
    const device::DeviceDescription &description = rig.device.description();
    const Vector3 truth_rad = rig.board.plant().phantom().truth().theta_rad;
    rig.device.zero(truth_rad);
    EXPECT_TRUE(rig.device.is_zeroed());
    const Measurement measured = rig.tick();
    const Vector3 now_rad = rig.board.plant().phantom().truth().theta_rad;
    // A count for rounding the zero, one for the encoder's own, one for the motion since.
    EXPECT_LE((theta_rad(measured, description) - now_rad).cwiseAbs().maxCoeff(),
              3.0 * description.rad_per_count());
}

TEST(UsbDevice, MeasuresTheDelayThatIsImposed) {
    for (const double d : {0.1, 0.3, 1.0, 1.7, 2.4, 8.0}) {
        Connected rig(options(d));
        rig.ticks(300);
        const double loop_periods = 1.0 / (40'000.0 * kTick_s);
        EXPECT_NEAR(rig.device.delay_periods(), d, 1.01 * loop_periods);
        EXPECT_NEAR(rig.device.link()->delay_s, d * kTick_s, 1.01 * loop_periods * kTick_s);
    }
}

TEST(UsbDevice, PassesCommandsOnAndStopsWithTheSafeState) {
    Connected rig;
    rig.device.zero(Vector3::Zero());
    rig.ticks(20, driving());
    EXPECT_EQ(rig.state(), board::State::driving);
    const Measurement measured = rig.tick(driving());
    // e_W = 1 V, R̂ = 1 Ω: the current is near 1 / 1.18 A where the rotor barely turns.
    EXPECT_GT(measured.current_A.minCoeff(), 0.2);
    device::DeviceCommand open = device::DeviceCommand::braking();
    open.mode = device::CommandMode::open;
    rig.ticks(5, open);
    EXPECT_EQ(rig.state(), board::State::opened);
    rig.tick(driving());
    rig.device.close();
    EXPECT_EQ(rig.state(), board::State::braking);
    EXPECT_EQ(rig.device.read().health, DeviceHealth::lost);
    rig.device.write(driving()); // reaches nothing
    rig.device.close();          // a second time
}

TEST(UsbDevice, CancelsAtMostWhatWasAskedFor) {
    for (const double R_hat_Ohm : {1.68, 2.0 / 3.0, 1.9999999}) {
        Command command;
        command.cancelled_resistance_Ohm.diagonal.fill(static_cast<float>(R_hat_Ohm));
        Command read;
        const Frame frame = encode(command);
        ASSERT_EQ(decode(frame.data(), frame.size(), read), FrameStatus::ok);
        const auto sent_Ohm = static_cast<double>(read.cancelled_resistance_Ohm.diagonal[0]);
        EXPECT_LE(sent_Ohm, R_hat_Ohm * (1.0 + 6e-8)); // half a unit in the last place of a float
        EXPECT_GT(sent_Ohm, R_hat_Ohm * (1.0 - 0x1p-15 - 6e-8));
    }
}

TEST(UsbDevice, IsLostWhenUnpluggedAndTheBoardBrakesAtOnce) {
    Connected rig;
    rig.device.zero(Vector3::Zero());
    rig.ticks(20, driving());
    ASSERT_EQ(rig.state(), board::State::driving);
    rig.port->unplug();
    rig.port->pass(2e-3);
    EXPECT_EQ(rig.state(), board::State::fault_braking);
    const Measurement measured = rig.device.read();
    EXPECT_EQ(measured.health, DeviceHealth::lost);
    EXPECT_FALSE(device::is_new(measured.arrival));
    rig.ticks(1000, driving()); // the servo goes on
    EXPECT_NE(error_text_of([&] { rig.device.reconnect(); }), "");

    rig.port->is_plugged = true;
    rig.device.reconnect();
    EXPECT_TRUE(rig.device.is_zeroed()); // the board had power all the time
    // It does not drive before a reset.
    rig.ticks(20, driving(0.1));
    EXPECT_EQ(rig.state(), board::State::fault_braking);
    EXPECT_TRUE(rig.tick().faults.has(device::BoardFaults::kNoCommand));
    rig.reset();
    rig.ticks(5, driving(0.1));
    EXPECT_EQ(rig.state(), board::State::driving);
}

TEST(UsbDevice, ABoardThatLostPowerMustBeZeroedAgain) {
    Connected rig;
    rig.device.zero(Vector3::Zero());
    rig.tick();
    device::Fault restart = device::parse_fault("restart");
    restart.begin_s = rig.board.time_s();
    rig.board.set_fault(restart);
    rig.ticks(100);
    EXPECT_EQ(rig.device.read().health, DeviceHealth::lost);
    rig.board.clear_faults();
    rig.device.reconnect();
    EXPECT_FALSE(rig.device.is_zeroed());
    EXPECT_EQ(rig.tick().health, DeviceHealth::ok);
}

TEST(UsbDevice, ACommandThatContradictsTheZeroVoidsIt) {
    Connected rig;
    rig.device.zero(Vector3::Zero());
    EXPECT_NE(rig.tick().zeroing, 0);
    device::DeviceCommand command = device::DeviceCommand::braking();
    command.voids_zero = true;
    rig.tick(command);
    EXPECT_FALSE(rig.device.is_zeroed());
    EXPECT_EQ(rig.tick().zeroing, 0);
    rig.device.reconnect();
    EXPECT_FALSE(rig.device.is_zeroed());
    rig.device.zero(Vector3::Zero());
    EXPECT_NE(rig.tick().zeroing, 0);
}

TEST(UsbDevice, AFaultOfAnEncoderVoidsTheZeroUntilItIsZeroedWithoutOne) {
    Connected rig;
    const auto fail_encoder = [&](bool fails) {
        rig.board.clear_faults();
        if (fails) {
            rig.board.set_fault(device::parse_fault("reversed-encoder:2")); // at another angle
        }
    };
    rig.move_hand();
    rig.device.zero(Vector3::Zero());
    ASSERT_NE(rig.tick().zeroing, 0);
    fail_encoder(true);
    Measurement failed = rig.tick();
    for (int i = 0; i < 3 && !failed.faults.any(); ++i) {
        EXPECT_NE(failed.zeroing, 0);
        failed = rig.tick();
    }
    EXPECT_TRUE(failed.faults.has(device::BoardFaults::kEncoder));
    EXPECT_EQ(failed.zeroing, 0); // in the same tick
    rig.reset();
    EXPECT_FALSE(rig.device.is_zeroed()); // a reset does not find it again
    fail_encoder(false);
    rig.tick();
    EXPECT_TRUE(rig.tick().faults.has(device::BoardFaults::kEncoder));
    const Vector3 truth_rad = rig.board.phantom().truth().theta_rad;
    rig.device.zero(truth_rad); // which clears what would hide the next fault
    const Measurement found = rig.tick();
    EXPECT_FALSE(found.faults.any());
    EXPECT_NE(found.zeroing, 0);
    EXPECT_LE((theta_rad(found, rig.device.description()) - rig.board.phantom().truth().theta_rad)
                  .cwiseAbs()
                  .maxCoeff(),
              3.0 * rig.device.description().rad_per_count());
}

/// It came while reports were lost, and a reset of the servo's cleared it.
TEST(UsbDevice, AFaultOfAnEncoderThatNoReportShowedVoidsTheZero) {
    Connected rig;
    rig.move_hand();
    rig.device.zero(Vector3::Zero());
    ASSERT_NE(rig.tick().zeroing, 0);
    Packet lost; // each command lets the board send one
    device::DeviceCommand command = device::DeviceCommand::braking();
    rig.board.set_fault(device::parse_fault("reversed-encoder:2"));
    for (const bool resets : {false, true, false}) {
        ASSERT_GT(rig.board.take(lost.data), 0U);
        command.resets_faults = resets;
        rig.device.write(command);
    }
    EXPECT_EQ(rig.board.board().loop().faults(), 0);
    const Measurement measured = rig.tick();
    EXPECT_EQ(measured.arrival, Arrival::fresh);
    EXPECT_FALSE(measured.faults.any());
    EXPECT_EQ(measured.zeroing, 0);
}

/// Only a person may clear a stop, and only at the servo.
TEST(UsbDevice, AZeroingClearsNoStop) {
    Connected rig;
    rig.move_hand();
    rig.board.set_fault(device::parse_fault("reversed-encoder:2"));
    rig.tick();
    ASSERT_TRUE(rig.tick().faults.has(device::BoardFaults::kEncoder));
    device::Fault stop = device::parse_fault("stop");
    stop.begin_s = rig.board.time_s();
    stop.end_s = stop.begin_s + 0.03;
    rig.board.set_fault(stop);
    const std::string error = springdrive::error_text_of([&] { rig.device.zero(Vector3::Zero()); });
    EXPECT_NE(error.find("stop"), std::string::npos) << error;
    EXPECT_FALSE(rig.device.is_zeroed());
    EXPECT_TRUE(rig.tick().faults.has(device::BoardFaults::kStop));
}

TEST(UsbDevice, ARestartAtAnyTimeOfAConnectionVoidsTheZero) {
    int restarted = 0;
    for (int delay_ms = 0; delay_ms < 80; ++delay_ms) {
        Connected rig;
        rig.device.zero(Vector3::Zero());
        rig.tick();
        rig.port->unplug();
        rig.tick();
        rig.port->is_plugged = true;
        device::Fault restart = device::parse_fault("restart");
        restart.begin_s = rig.board.time_s() + 1e-3 * delay_ms;
        rig.board.set_fault(restart);
        static_cast<void>(springdrive::error_text_of([&] { rig.device.reconnect(); }));
        rig.tick();
        EXPECT_EQ(rig.device.is_zeroed(), rig.board.restarts() == 0) << delay_ms << " ms";
        restarted += rig.board.restarts() > 0 ? 1 : 0;
    }
    EXPECT_GT(restarted, 20);
    EXPECT_LT(restarted, 80);
}

/// With as many commands and zeroings as the first, so that only its numbers tell the two apart.
TEST(UsbDevice, ABoardThatAnotherProgramUsedAfterARestartMustBeZeroedAgain) {
    Connected rig;
    const auto use = [](auto &&tick, UsbDevice &device) {
        device.zero(Vector3::Zero());
        for (int i = 0; i < 100; ++i) {
            tick();
        }
    };
    use([&] { rig.tick(); }, rig.device);
    ASSERT_TRUE(rig.device.is_zeroed());
    rig.port->unplug();
    rig.tick();
    device::Fault restart = device::parse_fault("restart");
    restart.begin_s = rig.board.time_s();
    rig.board.set_fault(restart);
    rig.port->pass(0.1);
    ASSERT_EQ(rig.board.restarts(), 1U);
    rig.board.clear_faults();
    {
        UsbDevice other(std::make_unique<EmulatedPort>(rig.board), testing::phantom_1_0(), "",
                        kTick_s, Pacing::reports);
        use(
            [&] {
                device::DeviceCommand command = device::DeviceCommand::braking();
                command.number = other.read().number;
                other.write(command);
            },
            other);
    }
    rig.port->is_plugged = true;
    rig.device.reconnect();
    EXPECT_FALSE(rig.device.is_zeroed());
}

TEST(UsbDevice, FullSpeedHasItsOwnRateAndSaysSo) {
    Connected rig;
    rig.device.close();
    rig.port->is_high_speed = false;
    rig.device.reconnect();
    EXPECT_EQ(rig.device.link()->speed, "full speed (12 Mbit/s)");
    const std::string error = error_text_of([&] { rig.device.set_period(0.25e-3); });
    EXPECT_NE(error.find("full speed"), std::string::npos) << error;
    EXPECT_NE(error.find("servo rate of 1000 Hz"), std::string::npos) << error;
    EXPECT_EQ(rig.tick().health, DeviceHealth::ok); // as before
    EXPECT_EQ(rig.device.link()->report_rate_hz, 1000.0);
}

TEST(UsbDevice, TheBoardsOwnLimitsApplyWhereTheyAreLower) {
    EmulatedBoardOptions weak = options();
    weak.settings.largest_voltage_V = 9.0F;
    weak.settings.current_limit_A = 3.0F;
    weak.settings.largest_cancelled_Ohm = {1.5F, 2.0F, 2.0F};
    const Connected rig(weak);
    const device::DeviceDescription &description = rig.device.description();
    EXPECT_EQ(description.motor[1].supply_V, 9.0);
    EXPECT_EQ(description.motor[1].peak_current_A, 3.0);
    EXPECT_LT(description.amplifier.max_cancelled_Ohm, 1.5);
    EXPECT_GT(description.amplifier.max_cancelled_Ohm, 1.499);
}

/// A port whose board answers otherwise.
class AlteredPort final : public BoardPort {
public:
    AlteredPort(EmulatedBoard &board, std::function<void(Kind, std::span<std::uint8_t>)> alter)
        : port_(board), alter_(std::move(alter)) {}

    bool send(const Frame &frame) noexcept override { return port_.send(frame); }
    bool receive(Packet &packet, double deadline_s) noexcept override {
        return port_.receive(packet, deadline_s);
    }
    [[nodiscard]] bool is_connected() const noexcept override { return port_.is_connected(); }
    [[nodiscard]] double now_s() const noexcept override { return port_.now_s(); }
    std::size_t control_in(Kind request, std::uint16_t value,
                           std::span<std::uint8_t> answer) override {
        const std::size_t size = port_.control_in(request, value, answer);
        alter_(request, answer.first(size));
        return size;
    }
    bool control_out(Kind request, std::uint16_t value,
                     std::span<const std::uint8_t> payload) override {
        return port_.control_out(request, value, payload);
    }
    void close() noexcept override { port_.close(); }
    void open(const std::string &serial) override { port_.open(serial); }
    [[nodiscard]] std::string_view speed() const override { return port_.speed(); }

private:
    EmulatedPort port_;
    std::function<void(Kind, std::span<std::uint8_t>)> alter_;
};

std::string error_about(const std::function<void(Kind, std::span<std::uint8_t>)> &alter,
                        const EmulatedBoardOptions &what = options()) {
    EmulatedBoard board(testing::phantom_1_0(), what);
    return error_text_of([&] {
        const UsbDevice device(std::make_unique<AlteredPort>(board, alter), testing::phantom_1_0(),
                               "", kTick_s, Pacing::reports);
    });
}

/// A payload of the board, changed and sealed again.
template <class Value, class Change> std::string error_with(Kind kind, const Change &change) {
    return error_about([&](Kind requested, std::span<std::uint8_t> answer) {
        if (requested == kind) {
            Value value;
            ASSERT_EQ(decode(answer.data(), answer.size(), value), FrameStatus::ok);
            change(value);
            std::ranges::copy(encode(value), answer.begin());
        }
    });
}

TEST(UsbDevice, RefusesABoardThatDoesNotFitInOneLine) {
    EXPECT_EQ(error_about([](Kind, std::span<std::uint8_t>) {}), "");

    const std::string version = error_with<Identity>(Kind::identity, [](Identity &identity) {
        identity.oldest_version = 2;
        identity.newest_version = 3;
    });
    EXPECT_NE(version.find("versions 2 to 3"), std::string::npos) << version;
    EXPECT_NE(version.find("firmware"), std::string::npos) << version;

    const std::string counts = error_with<Capabilities>(
        Kind::capabilities, [](Capabilities &board) { board.counts_per_turn[1] = 2000; });
    EXPECT_NE(counts.find("encoder 2 has 2000 counts"), std::string::npos) << counts;

    const std::string slow = error_with<Capabilities>(
        Kind::capabilities, [](Capabilities &board) { board.shortest_report_period_us = 2000; });
    EXPECT_NE(slow.find("servo rate of 500 Hz"), std::string::npos) << slow;

    const std::string damaged = error_about([](Kind requested, std::span<std::uint8_t> answer) {
        if (requested == Kind::capabilities) {
            answer[30] ^= 4U;
        }
    });
    EXPECT_NE(damaged.find("checksum"), std::string::npos) << damaged;

    EmulatedBoardOptions deaf = options();
    deaf.faults = {device::parse_fault("drop:out:1")};
    const std::string silent = error_about([](Kind, std::span<std::uint8_t>) {}, deaf);
    EXPECT_NE(silent.find("accepts no command"), std::string::npos) << silent;
    for (const std::string &text : {version, counts, slow, damaged, silent}) {
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        EXPECT_NE(text.find(';'), std::string::npos) << text; // says what to do
    }
}

/// A servo on the host's clock, which computes for a while in each tick.
struct TimedRun {
    std::uint64_t fresh = 0;
    std::uint64_t ticks = 0;
    double delay_periods = 0.0;
    double largest_age_s = 0.0; ///< of a report at its tick, by the board's clock
};

TimedRun timed_run(const testing::TimedPort::Way &way, double computing_s, double period_s) {
    EmulatedBoardOptions options = usb::options();
    options.clock = BoardClock::wall;
    EmulatedBoard board(testing::phantom_1_0(), options);
    auto *const port = new testing::TimedPort(board, way);
    UsbDevice device(std::unique_ptr<BoardPort>(port), testing::phantom_1_0(), "", period_s,
                     Pacing::clock);
    TimedRun run;
    const double start_s = port->now_s();
    for (int i = 1; i <= 2000; ++i) {
        port->sleep_until(start_s + i * period_s);
        device::DeviceCommand command = device::DeviceCommand::braking();
        const Measurement measured = device.read();
        port->sleep_until(port->now_s() + computing_s);
        command.number = measured.number;
        device.write(command);
        if (i > 500) { // the phase has settled
            ++run.ticks;
            run.fresh += measured.arrival == Arrival::fresh ? 1U : 0U;
        }
    }
    run.delay_periods = device.delay_periods();
    return run;
}

TEST(UsbDevice, PlacesReportsJustBeforeTicksWhateverTheClocksDo) {
    for (const double drift : {0.0, 1e-4, -1e-4}) {
        testing::TimedPort::Way way;
        way.drift = drift;
        const double computing_s = 50e-6;
        const TimedRun run = timed_run(way, computing_s, kTick_s);
        EXPECT_GE(static_cast<double>(run.fresh), 0.99 * static_cast<double>(run.ticks)) << drift;
        // Report, waiting and command: twice 60 to 120 µs, the 60 µs margin, and the computation;
        // one loop to sample, half a one to act. A report placed at random would add half a period.
        EXPECT_GT(run.delay_periods * kTick_s, 2 * way.min_s + computing_s) << drift;
        EXPECT_LT(run.delay_periods * kTick_s, 2 * way.max_s + 60e-6 + computing_s + 90e-6)
            << drift;
    }
}

TEST(UsbDevice, KeepsTheServosPeriodAtEveryRate) {
    for (const double period_s : {0.5e-3, 2e-3, 4e-3}) {
        const TimedRun run = timed_run({}, 50e-6, period_s);
        EXPECT_GE(static_cast<double>(run.fresh), 0.99 * static_cast<double>(run.ticks))
            << period_s;
        EXPECT_LT(run.delay_periods * period_s, 0.5e-3) << period_s;
    }
}

} // namespace
} // namespace springdrive::usb
