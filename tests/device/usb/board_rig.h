// Boards in process: one with windings and rotors behind its bridge, a clock, and a host that sends
// commands, all in double precision, independent of the board's own arithmetic; and the host of an
// emulated one.
#pragma once

#include "device/usb/board/board.h"
#include "device/usb/emulator/emulated_board.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>

namespace springdrive::testing {

/// One motor: a winding and a rotor, with the amplifier's view of them.
struct RigMotor {
    double resistance_Ohm = 2.18;
    double inductance_H = 0.238e-3;
    double torque_constant_Nm_per_A = 23.4e-3;
    double inertia_kg_m2 = 1.1e-5; ///< with the linkage
    double damping_Nms_per_rad = 1e-6;
    bool is_held = true;
    double sensor_gain = 1.0;
    double sensor_offset_A = 0.0;
    double current_A = 0.0;
    double rate_rad_per_s = 0.0;
    double angle_rad = 0.0;

    /// Exact for the winding at a constant rate, then the rotor.
    void run(board::Stage stage, double voltage_V, double step_s) {
        if (stage == board::Stage::open) {
            current_A = 0.0;
        } else {
            const double e_V = (stage == board::Stage::drive ? voltage_V : 0.0) -
                               torque_constant_Nm_per_A * rate_rad_per_s;
            const double settled_A = e_V / resistance_Ohm;
            current_A = settled_A +
                        (current_A - settled_A) * std::exp(-resistance_Ohm * step_s / inductance_H);
        }
        if (!is_held) {
            rate_rad_per_s +=
                step_s / inertia_kg_m2 *
                (torque_constant_Nm_per_A * current_A - damping_Nms_per_rad * rate_rad_per_s);
            angle_rad += step_s * rate_rad_per_s;
        }
    }
};

class BoardRig {
public:
    explicit BoardRig(const board::BoardSettings &settings = {}, std::uint32_t start_us = 0)
        : settings_(settings), board_(settings, {}), start_us_(start_us) {}

    std::array<RigMotor, 3> motor;
    /// Which motor is behind each bridge, sensor and encoder.
    std::array<std::size_t, 3> motor_of_sensor{0, 1, 2};
    std::array<std::size_t, 3> motor_of_encoder{0, 1, 2};
    std::array<double, 3> encoder_sign{1.0, 1.0, 1.0};
    double supply_V = 15.0;
    /// Changes the samples before the board sees them.
    std::function<void(board::Samples &)> tamper;
    /// What the host sends each millisecond, if anything; its number is set by the rig.
    usb::Command command;
    bool host_sends = false;

    /// Through the offsets' measurement, with a host that has begun numbering and brakes.
    void start() {
        run_ms(40);
        begin();
        host_sends = true;
        run_ms(2);
    }

    void begin(bool resets_faults = false) {
        usb::Command first;
        first.begins_numbering = true;
        first.resets_faults = resets_faults;
        (void)send(first);
    }

    usb::FrameStatus send(usb::Command sent) {
        sent.number = ++number_;
        return send_as(sent);
    }
    usb::FrameStatus send_as(const usb::Command &sent) {
        const usb::Frame frame = usb::encode(sent);
        return board_.receive(frame.data(), frame.size(), now_us());
    }

    /// The answer to a control request.
    template <class Value> Value ask(usb::Kind kind, std::uint16_t index = 0) {
        std::array<std::uint8_t, board::kMaxPayload> payload{};
        const std::size_t size =
            board_.control_in(static_cast<std::uint8_t>(kind), index, payload.data());
        Value value;
        EXPECT_EQ(usb::decode(payload.data(), size, value), usb::FrameStatus::ok);
        return value;
    }
    /// @return whether the board takes it
    template <class Value> bool request(usb::Kind kind, const Value &value) {
        const auto payload = usb::encode(value);
        return board_.control_out(static_cast<std::uint8_t>(kind), payload.data(), payload.size());
    }

    void run_loops(int loops) {
        const double half_s = 0.5 / settings_.loop_rate_hz;
        for (int i = 0; i < loops; ++i) {
            if (host_sends && loops_ % (settings_.loop_rate_hz / 1000) == 0) {
                last_status = send(command);
            }
            const board::Samples samples = sample();
            // Sampled in the middle of a PWM period; the new duty ratios act in the next one.
            const board::BridgeOrder next = board_.tick(samples);
            run_motors(half_s);
            order = next;
            run_motors(half_s);
            ++loops_;
            usb::Frame frame;
            if (board_.take_report(frame)) {
                last_decoded = usb::decode(frame.data(), frame.size(), report);
                ++reports;
            }
        }
    }
    void run_ms(int duration_ms) {
        run_loops(duration_ms * static_cast<int>(settings_.loop_rate_hz / 1000));
    }

    [[nodiscard]] std::uint32_t now_us() const {
        return start_us_ + static_cast<std::uint32_t>(loops_ * 1'000'000 / settings_.loop_rate_hz);
    }
    void pass_time_us(std::uint32_t duration_us) { start_us_ += duration_us; }

    [[nodiscard]] board::Board &board() { return board_; }
    [[nodiscard]] board::State state() const { return board_.loop().state(); }
    [[nodiscard]] std::uint16_t faults() const { return board_.loop().faults(); }
    [[nodiscard]] double current_A(std::size_t i) const { return motor[i].current_A; }

    board::BridgeOrder order = board::BridgeOrder::opening();
    usb::Report report;
    usb::FrameStatus last_decoded = usb::FrameStatus::wrong_size;
    usb::FrameStatus last_status = usb::FrameStatus::ok;
    int reports = 0;

private:
    [[nodiscard]] board::Samples sample() const {
        board::Samples samples;
        samples.time_us = now_us();
        for (std::size_t i = 0; i < 3; ++i) {
            const RigMotor &sensed = motor[motor_of_sensor[i]];
            samples.current_A[i] =
                static_cast<float>(sensed.sensor_gain * sensed.current_A + sensed.sensor_offset_A);
            const double counts = encoder_sign[i] * motor[motor_of_encoder[i]].angle_rad *
                                  settings_.counts_per_turn[i] / (2.0 * M_PI);
            samples.encoder[i] = static_cast<std::uint16_t>(std::llround(counts) & 0xffff);
        }
        samples.supply_V = static_cast<float>(supply_V);
        samples.temperature_C[0] = 30.0F;
        if (tamper) {
            tamper(samples);
        }
        return samples;
    }

    void run_motors(double step_s) {
        for (std::size_t i = 0; i < 3; ++i) {
            motor[i].run(order.stage[i], supply_V * static_cast<double>(order.duty_ratio[i]),
                         step_s);
        }
    }

    board::BoardSettings settings_;
    board::Board board_;
    std::uint32_t start_us_;
    std::uint64_t loops_ = 0;
    std::uint32_t number_ = 100;
};

/// A command that drives all motors.
inline usb::Command drive(float e_W_V = 0.2F, float R_hat_Ohm = 1.68F) {
    usb::Command command;
    command.mode = usb::Mode::drive;
    command.e_W_V = {e_W_V, -e_W_V, 0.5F * e_W_V};
    command.cancelled_resistance_Ohm.diagonal = {R_hat_Ohm, R_hat_Ohm, R_hat_Ohm};
    return command;
}

inline usb::Command mode(usb::Mode mode) {
    usb::Command command;
    command.mode = mode;
    return command;
}

/// A rig that drives.
class DrivingRig : public BoardRig {
public:
    explicit DrivingRig(std::uint32_t start_us = 0)
        : BoardRig({.motors_start_cold = true}, start_us) {
        start();
        command = drive();
        run_ms(5);
        EXPECT_EQ(state(), board::State::driving);
        EXPECT_EQ(faults(), 0);
    }
};

inline bool all_stages(const board::BridgeOrder &order, board::Stage stage) {
    return std::all_of(order.stage.begin(), order.stage.end(),
                       [&](board::Stage one) { return one == stage; });
}

/// Of an emulated board whose hand rests off the centre.
inline emulator::EmulatedBoardOptions emulated_options() {
    emulator::EmulatedBoardOptions options;
    options.simulation.effects.coulomb_friction = false; // it would leave the place of rest open
    options.simulation.hand = {0.2, 8.0, 300.0, 20.0, 0.4};
    options.start_tip_m = kOffCentre_m;
    return options;
}

inline usb::Command driving(const Vector3 &e_W_V) {
    constexpr double kR_hat_Ohm = 1.68;
    usb::Command command;
    command.mode = usb::Mode::drive;
    for (std::size_t j = 0; j < 3; ++j) {
        command.e_W_V[j] = static_cast<float>(e_W_V[static_cast<Eigen::Index>(j)]);
        command.cancelled_resistance_Ohm.diagonal[j] = static_cast<float>(kR_hat_Ohm);
    }
    return command;
}

template <class Value> Value ask(emulator::EmulatedBoard &board, usb::Kind kind) {
    std::array<std::uint8_t, board::kMaxPayload> payload{};
    const std::size_t size = board.control_in(static_cast<std::uint8_t>(kind), 0, payload);
    Value value;
    EXPECT_EQ(usb::decode(payload.data(), size, value), usb::FrameStatus::ok);
    return value;
}

template <class Value>
bool order(emulator::EmulatedBoard &board, usb::Kind kind, const Value &value) {
    return board.control_out(static_cast<std::uint8_t>(kind), 0, usb::encode(value));
}

/// Answers each report with one packet, as the frame clock wants it.
class Host {
public:
    explicit Host(const emulator::EmulatedBoardOptions &with = emulated_options())
        : board(phantom_1_0(), with) {}

    /// Up to a first accepted command, which brakes.
    void begin(int periods = 3) {
        board.attach(true);
        usb::Command first;
        first.begins_numbering = true;
        for (int i = 0; i < periods; ++i) {
            exchange(first);
        }
    }

    void send(usb::Command command) {
        command.number = ++number;
        measured_at_us[number] = report.measured_at_us;
        board.put(usb::encode(command));
    }

    /// @return whether a valid report came
    bool receive() {
        usb::Frame frame;
        const std::size_t size = board.take(frame);
        status = usb::decode(frame.data(), size, report);
        reports += status == usb::FrameStatus::ok ? 1 : 0;
        return status == usb::FrameStatus::ok;
    }

    bool exchange(const usb::Command &command) {
        const bool has_report = receive();
        send(command);
        return has_report;
    }
    void exchange(const usb::Command &command, int times) {
        for (int i = 0; i < times; ++i) {
            exchange(command);
        }
    }

    /// Without a packet of the host.
    void pass_ms(int duration_ms) {
        for (int i = 0; i < duration_ms; ++i) {
            board.pass(1e-3);
        }
    }

    /// d of the report's newest command, if it has been applied.
    [[nodiscard]] double delay_s() const {
        const auto from = measured_at_us.find(report.command_number);
        if (!report.has_command || report.applied_after_us == usb::kNotApplied ||
            from == measured_at_us.end()) {
            return std::nan("");
        }
        return 1e-6 * usb::difference(report.command_arrived_at_us + report.applied_after_us,
                                      from->second);
    }

    [[nodiscard]] usb::BoardState state() const { return board.board().loop().state(); }
    [[nodiscard]] std::uint16_t faults() const { return board.board().loop().faults(); }

    emulator::EmulatedBoard board;
    usb::Report report;
    usb::FrameStatus status = usb::FrameStatus::ok;
    int reports = 0;
    std::uint32_t number = 0;
    std::map<std::uint32_t, std::uint32_t> measured_at_us; ///< by the command computed from it
};

} // namespace springdrive::testing
