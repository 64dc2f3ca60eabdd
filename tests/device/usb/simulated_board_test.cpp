// A board in process, with the simulated PHANTOM behind its bridge, against the simulated PHANTOM's
// own amplifiers: both render the same static forces.
#include "device/simulated/simulated_phantom.h"
#include "device/usb/board/board.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>

namespace springdrive::board {
namespace {

using simulated::SimulatedPhantom;
using simulated::SimulationOptions;

constexpr double kServo_s = 1e-3;
constexpr std::uint32_t kLoop_hz = 40'000;
constexpr float kSupply_V = 15.0F;

SimulationOptions options(double period_s) {
    SimulationOptions options;
    options.servo_period_s = period_s;
    options.effects.coulomb_friction = false; // it would leave the place of rest open
    options.hand = {0.2, 8.0, 300.0, 20.0, 0.4};
    return options;
}

/// What a host computes in a tick: (10) with a locked set-point, by counts.
class Law {
public:
    explicit Law(const device::DeviceDescription &device)
        : rad_per_count_(device.rad_per_count()) {}

    Vector3 e_W_V(const std::array<std::int32_t, 3> &counts) {
        Vector3 theta_rad;
        for (Eigen::Index j = 0; j < 3; ++j) {
            theta_rad[j] = rad_per_count_ * counts[static_cast<std::size_t>(j)];
        }
        const Vector3 rate =
            has_last_ ? Vector3((theta_rad - last_rad_) / kServo_s) : Vector3(Vector3::Zero());
        has_last_ = true;
        last_rad_ = theta_rad;
        filtered_ += 0.6 * (rate - filtered_);
        return -6.0 * (theta_rad - set_point_rad) - 0.01 * filtered_;
    }

    Vector3 set_point_rad{Vector3::Zero()};

private:
    double rad_per_count_;
    bool has_last_ = false;
    Vector3 last_rad_{Vector3::Zero()};
    Vector3 filtered_{Vector3::Zero()};
};

constexpr double kR_hat_Ohm = 1.68;

/// The board drives the windings with e_A alone: the plant cancels nothing.
class BoardAndPhantom {
public:
    explicit BoardAndPhantom(const device::DeviceDescription &device)
        : plant_(device, options(1.0 / kLoop_hz), testing::kOffCentre_m),
          board_({.motors_start_cold = true}, {}) {}

    void run_loops(int loops) {
        for (int i = 0; i < loops; ++i) {
            const device::Measurement measured = plant_.advance(applied_);
            Samples samples;
            samples.time_us = static_cast<std::uint32_t>(++loops_ * 25U);
            for (std::size_t j = 0; j < 3; ++j) {
                samples.encoder[j] = static_cast<std::uint16_t>(measured.counts[j] & 0xffff);
                samples.current_A[j] =
                    static_cast<float>(measured.current_A[static_cast<Eigen::Index>(j)]);
            }
            samples.supply_V = kSupply_V;
            samples.temperature_C[0] = 30.0F;
            apply(board_.tick(samples));
        }
    }

    void send(usb::Command command) {
        command.number = ++number_;
        command.report_after_us = 975;
        const usb::Frame frame = usb::encode(command);
        ASSERT_EQ(
            board_.receive(frame.data(), frame.size(), static_cast<std::uint32_t>(loops_ * 25U)),
            usb::FrameStatus::ok);
    }

    [[nodiscard]] usb::Report report() {
        usb::Frame frame;
        if (board_.take_report(frame)) {
            EXPECT_EQ(usb::decode(frame.data(), frame.size(), report_), usb::FrameStatus::ok);
        }
        return report_;
    }

    void begin() {
        run_loops(1600);
        usb::Command first;
        first.begins_numbering = true;
        send(first);
        usb::Frame frame;
        (void)board_.take_report(frame);
        const auto zero = usb::encode(usb::Zeroing{plant_counts()});
        ASSERT_TRUE(board_.control_out(static_cast<std::uint8_t>(usb::Kind::zero), zero.data(),
                                       zero.size()));
        run_loops(40);
    }

    [[nodiscard]] SimulatedPhantom &plant() { return plant_; }
    [[nodiscard]] State state() const { return board_.loop().state(); }

private:
    [[nodiscard]] std::array<std::int32_t, 3> plant_counts() const {
        std::array<std::int32_t, 3> counts{};
        for (std::size_t j = 0; j < 3; ++j) {
            counts[j] = static_cast<std::int32_t>(
                std::lround(plant_.truth().theta_rad[static_cast<Eigen::Index>(j)] /
                            plant_.description().rad_per_count()));
        }
        return counts;
    }

    void apply(const BridgeOrder &order) {
        applied_ = device::DeviceCommand();
        switch (order.stage[0]) {
        case Stage::brake:
            applied_.mode = device::CommandMode::brake;
            break;
        case Stage::open:
            applied_.mode = device::CommandMode::open;
            break;
        case Stage::drive:
            for (std::size_t j = 0; j < 3; ++j) {
                applied_.e_W_V[static_cast<Eigen::Index>(j)] =
                    static_cast<double>(kSupply_V) * static_cast<double>(order.duty_ratio[j]);
            }
            break;
        }
    }

    SimulatedPhantom plant_;
    Board board_;
    device::DeviceCommand applied_ = device::DeviceCommand::braking();
    std::uint64_t loops_ = 0;
    std::uint32_t number_ = 0;
    usb::Report report_;
};

usb::Command to_command(const Vector3 &e_W_V) {
    usb::Command command;
    command.mode = usb::Mode::drive;
    for (std::size_t j = 0; j < 3; ++j) {
        command.e_W_V[j] = static_cast<float>(e_W_V[static_cast<Eigen::Index>(j)]);
        command.cancelled_resistance_Ohm.diagonal[j] = static_cast<float>(kR_hat_Ohm);
    }
    return command;
}

/// Means over the last ticks: at rest the law may alternate between two counts.
class AtRest {
public:
    static constexpr int kSettlingTicks = 2500;
    static constexpr int kTicks = 3500;

    void note(int tick, const SimulatedPhantom::Truth &truth) {
        if (tick >= kSettlingTicks) {
            constexpr double kShare = 1.0 / (kTicks - kSettlingTicks);
            theta_rad += kShare * truth.theta_rad;
            current_A += kShare * truth.current_A;
            force_N += kShare * truth.hand_force_N;
        }
    }

    Vector3 theta_rad{Vector3::Zero()};
    Vector3 current_A{Vector3::Zero()};
    Vector3 force_N{Vector3::Zero()};
};

AtRest pushed_directly(const Vector3 &target_m, const Vector3 &set_point_rad) {
    SimulatedPhantom device(testing::phantom_1_0(), options(kServo_s), testing::kOffCentre_m);
    Law law(device.description());
    law.set_point_rad = set_point_rad;
    device.set_hand_target(target_m);
    device::Measurement measured = device.advance(device::DeviceCommand::braking());
    AtRest rest;
    for (int tick = 0; tick < AtRest::kTicks; ++tick) {
        measured = device.advance(
            device::DeviceCommand{law.e_W_V(measured.counts), Vector3::Constant(kR_hat_Ohm)});
        rest.note(tick, device.truth());
    }
    return rest;
}

AtRest pushed_over_the_board(const Vector3 &target_m, const Vector3 &set_point_rad) {
    BoardAndPhantom device(testing::phantom_1_0());
    device.begin();
    Law law(device.plant().description());
    law.set_point_rad = set_point_rad;
    device.plant().set_hand_target(target_m);
    AtRest rest;
    for (int tick = 0; tick < AtRest::kTicks; ++tick) {
        device.send(to_command(law.e_W_V(device.report().counts)));
        device.run_loops(static_cast<int>(kLoop_hz / 1000));
        rest.note(tick, device.plant().truth());
    }
    EXPECT_EQ(device.state(), State::driving);
    return rest;
}

TEST(SimulatedBoard, RendersTheStaticForcesOfTheSimulatedDevice) {
    const SimulatedPhantom unmoved(testing::phantom_1_0(), options(kServo_s),
                                   testing::kOffCentre_m);
    const Vector3 set_point_rad = unmoved.truth().theta_rad;
    const double count_rad = unmoved.description().rad_per_count();
    // What one count of the law's angle changes, K_P times a count over dR, and 13 times k_T of it
    // at the end of a link. The difference is a hundredth of it: rounding, and float24.
    const double count_A = 6.0 * count_rad / (2.18 - kR_hat_Ohm);
    const double count_N = 13.3 * 23.4e-3 / 0.1397 * count_A;
    for (const Vector3 &push_m : {Vector3(0.008, 0.0, 0.0), Vector3(0.0, -0.01, 0.004)}) {
        const Vector3 target_m = testing::kOffCentre_m + push_m;
        const AtRest direct = pushed_directly(target_m, set_point_rad);
        const AtRest board = pushed_over_the_board(target_m, set_point_rad);
        EXPECT_GT(direct.force_N.norm(), 1.0); // not vacuous
        EXPECT_LT((board.theta_rad - direct.theta_rad).cwiseAbs().maxCoeff(), 0.05 * count_rad);
        EXPECT_LT((board.current_A - direct.current_A).cwiseAbs().maxCoeff(), 0.05 * count_A);
        EXPECT_LT((board.force_N - direct.force_N).norm(), 0.05 * count_N);
    }
}

/// Without a law, and the encoders' steps with it: what remains is the rounding of `float`.
TEST(SimulatedBoard, SettlesAtTheCurrentsOfTheSimulatedAmplifiers) {
    BoardAndPhantom board(testing::phantom_1_0());
    board.begin();
    SimulatedPhantom direct(testing::phantom_1_0(), options(kServo_s), testing::kOffCentre_m);
    const Vector3 e_W_V(0.3, -0.2, 0.25);
    for (int tick = 0; tick < 2000; ++tick) {
        board.send(to_command(e_W_V));
        board.run_loops(static_cast<int>(kLoop_hz / 1000));
        (void)direct.advance(device::DeviceCommand{e_W_V, Vector3::Constant(kR_hat_Ohm)});
    }
    // `float24` leaves R̂ up to 2^-15 smaller; the winding warms alike, and the ripple at nearly the
    // same angle. 2^-15 of R̂ by dR is 1e-4 of the current.
    const Vector3 difference_A = board.plant().truth().current_A - direct.truth().current_A;
    EXPECT_LT(difference_A.cwiseAbs().maxCoeff(), 3e-4 * direct.truth().current_A.norm());
}

} // namespace
} // namespace springdrive::board
