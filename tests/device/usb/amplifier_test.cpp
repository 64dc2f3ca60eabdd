// Covers device/usb/board/amplifier.{h,cpp}: on windings in double precision, and in a board with
// the simulated PHANTOM behind its bridge, whose currents must be those of the simulated
// amplifiers.
#include "device/usb/board/amplifier.h"

#include "base/vector.h"
#include "device/simulated/simulated_phantom.h"
#include "device/usb/board/board.h"
#include "device/usb/board/link.h"
#include "tests/device/usb/board_rig.h"
#include "tests/support/devices.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>
#include <unsupported/Eigen/MatrixFunctions>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace springdrive::board {
namespace {

constexpr double kR_Ohm = 2.18;
constexpr double kL_H = 0.238e-3;

Triple to_triple(const Vector3 &v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
SymmetricMatrix to_matrix(const Matrix3 &M) {
    return {to_triple(M.diagonal()), to_triple({M(0, 1), M(0, 2), M(1, 2)})};
}

struct Trial {
    Matrix3 R_hat_Ohm = Matrix3::Zero();
    Matrix3 L_hat_H = Matrix3::Zero();
    Vector3 e_W_V{0.1, -0.05, 0.08};
    Vector3 start_A{0.0, 0.0, 0.0};
};

BoardSettings at_rate(std::uint32_t loop_rate_hz) {
    BoardSettings settings;
    settings.loop_rate_hz = loop_rate_hz;
    settings.lead_bandwidth_rad_per_s = static_cast<float>(loop_rate_hz); // the same in periods
    return settings;
}

/// Sampled in the middle of a PWM period, applied in the next, as on a board.
Vector3 amplified_A(const Trial &trial, double duration_s, const BoardSettings &settings) {
    Amplifier amplifier(settings);
    const double half_s = 0.5 / settings.loop_rate_hz;
    usb::Command command;
    command.e_W_V = to_triple(trial.e_W_V);
    command.cancelled_resistance_Ohm = to_matrix(trial.R_hat_Ohm);
    command.cancelled_inductance_H = to_matrix(trial.L_hat_H);
    const DriveSettings drive =
        drive_settings(command, settings.actuation_lag_periods * settings.loop_period_s());
    Vector3 current_A = trial.start_A;
    amplifier.forget(to_triple(current_A));
    Vector3 applied_V = trial.e_W_V + trial.R_hat_Ohm * current_A;
    const double decay = std::exp(-kR_Ohm * half_s / kL_H);
    const auto run = [&] {
        current_A = applied_V / kR_Ohm + decay * (current_A - applied_V / kR_Ohm);
    };
    const auto loops = static_cast<int>(std::lround(duration_s * settings.loop_rate_hz));
    for (int i = 0; i < loops; ++i) {
        amplifier.observe(to_triple(current_A));
        const Triple next_V = amplifier.voltage_V(drive);
        run();
        applied_V = Vector3(next_V[0], next_V[1], next_V[2]);
        run();
    }
    return current_A;
}

/// (L − L̂) di/dt + (R − R̂) i = e_W, by the matrix exponential.
Vector3 exact_A(const Trial &trial, double duration_s) {
    const Matrix3 Z_R = kR_Ohm * Matrix3::Identity() - trial.R_hat_Ohm;
    const Matrix3 Z_L = kL_H * Matrix3::Identity() - trial.L_hat_H;
    const Matrix3 exponent = -duration_s * (Z_L.inverse() * Z_R);
    const Vector3 settled_A = Z_R.inverse() * trial.e_W_V;
    return settled_A + Matrix3(exponent.exp()) * (trial.start_A - settled_A);
}

/// The largest difference over a rise, by the settled current.
double rise_error(const Trial &trial, const BoardSettings &settings) {
    double largest = 0.0;
    for (const double duration_s : {0.2e-3, 0.4e-3, 0.6e-3, 1.0e-3, 1.6e-3}) {
        const double error_A =
            (amplified_A(trial, duration_s, settings) - exact_A(trial, duration_s)).norm();
        largest = std::max(largest, error_A / exact_A(trial, 1.0).norm());
    }
    return largest;
}

Trial diagonal_trial(double dR_Ohm, double inductance_share) {
    Trial trial;
    trial.R_hat_Ohm = (kR_Ohm - dR_Ohm) * Matrix3::Identity();
    trial.L_hat_H = inductance_share * kL_H * Matrix3::Identity();
    return trial;
}

/// R − R̂ = dR M, L − L̂ = L M, with M's eigenvalues 1, 1.6 and 2.4 in odd directions.
Trial coupled_trial(double dR_Ohm, bool couples_inductance) {
    const Vector3 a = Vector3(1.0, 2.0, -1.0).normalized();
    const Vector3 b = a.cross(Vector3(0.3, 0.2, 1.0)).normalized();
    const Matrix3 M = Matrix3::Identity() + 0.6 * a * a.transpose() + 1.4 * b * b.transpose();
    Trial trial;
    trial.R_hat_Ohm = kR_Ohm * Matrix3::Identity() - dR_Ohm * M;
    if (couples_inductance) {
        trial.L_hat_H = kL_H * (Matrix3::Identity() - M);
    }
    return trial;
}

TEST(Amplifier, WithoutCancellationIsThePlainWinding) {
    // The first voltage acts from half a period on.
    const Trial trial = diagonal_trial(kR_Ohm, 0.0);
    EXPECT_LT(rise_error(trial, BoardSettings()), 1e-6);
}

TEST(Amplifier, CancelsResistanceAndInductance) {
    for (const double dR_Ohm : {1.0, 0.5, 0.2}) {
        for (const double inductance_share : {-1.0, -0.5, 0.0, 0.3}) {
            EXPECT_LT(rise_error(diagonal_trial(dR_Ohm, inductance_share), BoardSettings()),
                      inductance_share > 0.0 ? 0.05 : 0.03) // the lead's bandwidth
                << dR_Ohm << " Ω, L̂ " << inductance_share << " L";
        }
    }
}

TEST(Amplifier, CouplesChannels) {
    for (const double dR_Ohm : {1.0, 0.5, 0.2}) {
        for (const bool couples_inductance : {false, true}) {
            EXPECT_LT(rise_error(coupled_trial(dR_Ohm, couples_inductance), BoardSettings()), 0.03);
        }
    }
}

/// Compensated for its lag, the loop errs in second order only: four times less at twice the rate,
/// until the rounding of `float` shows.
TEST(Amplifier, ErrsInSecondOrderOfItsPeriod) {
    for (const Trial &trial : {diagonal_trial(0.5, 0.0), coupled_trial(0.5, false)}) {
        const double coarse = rise_error(trial, at_rate(40'000));
        const double fine = rise_error(trial, at_rate(80'000));
        const double finest = rise_error(trial, at_rate(160'000));
        EXPECT_GT(coarse / fine, 3.0);
        EXPECT_GT(fine / finest, 3.0);
        EXPECT_GT(coarse, 1e-4); // not vacuous
    }
}

/// Without compensation it would add R̂ τ to L, 18 % at 40 kHz.
TEST(Amplifier, WithoutCompensationWouldAddInductance) {
    BoardSettings settings;
    settings.actuation_lag_periods = 0.0F;
    const Trial trial = diagonal_trial(0.5, 0.0);
    EXPECT_GT(rise_error(trial, settings), 0.04);
    Trial slower = trial;
    const double lag_s = 25e-6;
    const Matrix3 added_H = lag_s * trial.R_hat_Ohm;
    slower.L_hat_H = -added_H;
    const double duration_s = 0.6e-3;
    EXPECT_LT((amplified_A(trial, duration_s, settings) - exact_A(slower, duration_s)).norm(),
              0.02 * exact_A(trial, 1.0).norm());
}

TEST(Amplifier, SettlesWhereResistanceSaysWhateverTheInductance) {
    for (const bool couples_inductance : {false, true}) {
        const Trial trial = coupled_trial(0.5, couples_inductance);
        const Vector3 settled_A = exact_A(trial, 1.0);
        EXPECT_LT((amplified_A(trial, 0.05, BoardSettings()) - settled_A).norm(),
                  1e-5 * settled_A.norm());
    }
}

/// The corners of the permitted range of R̂ and L̂ are stable: currents decay.
TEST(Amplifier, IsStableAtItsLimits) {
    const BoardSettings settings;
    for (const double R_hat_Ohm : {2.1, 0.0, -static_cast<double>(settings.largest_added_Ohm)}) {
        for (const double L_hat_H : {static_cast<double>(settings.largest_cancelled_H), 0.0,
                                     -static_cast<double>(settings.largest_added_H)}) {
            Trial trial = diagonal_trial(kR_Ohm - R_hat_Ohm, L_hat_H / kL_H);
            trial.e_W_V.setZero();
            trial.start_A = {1.0, -0.5, 0.3};
            EXPECT_LT(amplified_A(trial, 0.06, settings).norm(), 1e-2)
                << R_hat_Ohm << " Ω, " << L_hat_H << " H";
        }
    }
}

TEST(Amplifier, OverCancellationGrowsAsInTheClosedForm) {
    Trial trial = diagonal_trial(-0.1, 0.0);
    trial.e_W_V.setZero();
    trial.start_A = {0.1, 0.0, 0.0};
    const double duration_s = 5e-3;
    EXPECT_NEAR(amplified_A(trial, duration_s, BoardSettings())[0] /
                    (0.1 * std::exp(0.1 * duration_s / kL_H)),
                1.0, 0.05);
}

TEST(AmplifierLimits, ScaleToTheLargestVoltageAndKeepTheDirection) {
    const Amplifier amplifier{BoardSettings()};
    std::uint8_t acting = 0;
    EXPECT_EQ(amplifier.limited_V({12.0F, -3.0F, 1.0F}, 12.0F, acting),
              (Triple{12.0F, -3.0F, 1.0F}));
    EXPECT_EQ(acting, 0);
    const Triple limited_V = amplifier.limited_V({24.0F, -3.0F, 1.0F}, 12.0F, acting);
    EXPECT_EQ(limited_V, (Triple{12.0F, -1.5F, 0.5F}));
    EXPECT_EQ(acting, usb::ActingLimits::kVoltage);
}

/// One winding that differs from the board's settings, its rotor turned from outside, and what the
/// board reads of its current. Exact, as voltage and speed are held for half a period.
struct LimitedWinding {
    double R_Ohm = kR_Ohm;
    double L_H = kL_H;
    double emf_V = 0.0;
    double supply_share = 1.0; ///< true voltage by the one that the board takes it for
    double current_A = 0.0;
    double applied_V = 0.0;
    double peak_A = 0.0;

    void run(double time_s) {
        const double settled_A = (supply_share * applied_V - emf_V) / R_Ohm;
        current_A = settled_A + (current_A - settled_A) * std::exp(-R_Ohm * time_s / L_H);
        peak_A = std::max(peak_A, std::abs(current_A));
    }
};

constexpr double kHalf_s = 12.5e-6;

/// At 2 m/s of the tip, whose joint is the upper arm of 139.7 mm behind a transmission of 13.3.
constexpr double kFastestEmf_V = 23.4e-3 * 13.3 * 2.0 / 0.1397;

/// R at 15 °C, 5 % below the file's, at the best angle of the commutator.
constexpr double kColdest_Ohm = 0.98 * 0.95 * (1.0 - 0.0039 * 10.0) * kR_Ohm;

double settled_A(double R_Ohm, double emf_V, float commanded_V) {
    const BoardSettings settings;
    Amplifier amplifier(settings);
    LimitedWinding winding{.R_Ohm = R_Ohm, .emf_V = emf_V};
    for (int loop = 0; loop < 400; ++loop) {
        amplifier.observe({static_cast<float>(winding.current_A), 0.0F, 0.0F});
        std::uint8_t acting = 0;
        const Triple next_V =
            amplifier.limited_V({commanded_V, 0.0F, 0.0F}, settings.largest_voltage_V, acting);
        amplifier.apply(next_V);
        winding.run(kHalf_s);
        winding.applied_V = static_cast<double>(next_V[0]);
        winding.run(kHalf_s);
    }
    EXPECT_LE(winding.peak_A, std::abs(winding.current_A) + 1e-3); // nor on the way there
    return winding.current_A;
}

/// The limit of a sensor with an error of 1 %: what would settle below it is not touched, whatever
/// would settle above it settles at it.
TEST(AmplifierLimits, CurrentLimitOnBothSides) {
    constexpr double kLimit_A = 0.99 * 5.5;
    for (const double side : {1.0, -1.0}) {
        for (const double emf_V : {0.0, -kFastestEmf_V, kFastestEmf_V}) {
            for (const double R_Ohm : {kColdest_Ohm, kR_Ohm}) {
                for (const double requested_A :
                     {0.98 * kLimit_A, 1.02 * kLimit_A, 2.0 * kLimit_A}) {
                    const double V = side * (R_Ohm * requested_A + emf_V);
                    if (std::abs(V) > 12.0) {
                        continue;
                    }
                    EXPECT_NEAR(settled_A(R_Ohm, side * emf_V, static_cast<float>(V)),
                                side * std::min(requested_A, kLimit_A), 1e-3)
                        << R_Ohm << " Ω, " << emf_V << " V, " << V << " V";
                }
            }
        }
    }
    // Braking passes on what the hand drives, and what would be more is opposed.
    EXPECT_NEAR(settled_A(kColdest_Ohm, -4.0, 0.0F), 4.0 / kColdest_Ohm, 1e-3);
    EXPECT_NEAR(settled_A(kColdest_Ohm, -12.0, 0.0F), kLimit_A, 1e-3);
}

/// Whatever the host commands that check_limits accepts, for windings from the coldest to the
/// hottest that are turned at up to 2 m/s of the tip. A rotor without a linkage, at the peak
/// current, gains 125,000 rad/s²: k_T of it is 73 mV a loop, of which e lags by less than three.
TEST(AmplifierLimits, NoCommandDrivesACurrentBeyondThePeak) {
    constexpr double kPeak_A = 5.5;
    constexpr double kAcceleration_V_per_s = 23.4e-3 * 125e3;
    constexpr double kLag_A = 3.0 * 25e-6 * kAcceleration_V_per_s / (0.5 * kL_H / 25e-6);
    constexpr double kNoise_A = 0.015; // the sensor's of 3 mA, as it is amplified
    std::mt19937_64 random(42);
    const auto any = [&](double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random);
    };
    const BoardSettings settings;
    double highest_A = 0.0;
    int limited_loops = 0;
    for (int trial = 0; trial < 120; ++trial) {
        Amplifier amplifier(settings);
        std::array<LimitedWinding, 3> windings;
        std::array<double, 3> gain{};
        std::array<double, 3> acceleration_V_per_s{};
        for (std::size_t i = 0; i < 3; ++i) {
            windings[i].R_Ohm = trial % 2 == 0 ? kColdest_Ohm : any(kColdest_Ohm, 3.1);
            windings[i].L_H = kL_H * any(0.9, 1.1);
            windings[i].supply_share = any(0.97, 1.03);
            gain[i] = any(0.99, 1.01);
        }
        DriveSettings drive;
        for (int loop = 0; loop < 2000; ++loop) {
            if (loop % 40 == 0) {
                usb::Command command;
                command.mode = usb::Mode::drive;
                do {
                    const auto share = static_cast<float>(any(0.0, 1.0));
                    for (std::size_t i = 0; i < 3; ++i) {
                        command.e_W_V[i] = static_cast<float>(any(-12.0, 12.0));
                        command.cancelled_resistance_Ohm.diagonal[i] =
                            static_cast<float>(any(-4.4, 2.289));
                        command.cancelled_resistance_Ohm.off_diagonal[i] =
                            share * static_cast<float>(any(-1.0, 1.0));
                        command.cancelled_inductance_H.diagonal[i] =
                            static_cast<float>(any(-0.48e-3, 0.12e-3));
                    }
                } while (check_limits(command, settings, settings.largest_cancelled_Ohm) !=
                         usb::FrameStatus::ok);
                drive = drive_settings(command, settings.loop_period_s());
            }
            Triple measured_A;
            for (std::size_t i = 0; i < 3; ++i) {
                if (loop % 97 == 0) {
                    acceleration_V_per_s[i] = kAcceleration_V_per_s * any(-1.0, 1.0);
                }
                windings[i].emf_V = std::clamp(windings[i].emf_V + 25e-6 * acceleration_V_per_s[i],
                                               -kFastestEmf_V, kFastestEmf_V);
                const double noisy_A =
                    gain[i] * windings[i].current_A + std::normal_distribution(0.0, 3e-3)(random);
                const double step_A = static_cast<double>(settings.current_resolution_A);
                measured_A[i] = static_cast<float>(step_A * std::round(noisy_A / step_A));
            }
            amplifier.observe(measured_A);
            std::uint8_t acting = 0;
            const Triple next_V =
                amplifier.limited_V(amplifier.voltage_V(drive), settings.largest_voltage_V, acting);
            amplifier.apply(next_V);
            limited_loops += (acting & usb::ActingLimits::kCurrent) != 0 ? 1 : 0;
            for (std::size_t i = 0; i < 3; ++i) {
                windings[i].run(kHalf_s);
                windings[i].applied_V = static_cast<double>(next_V[i]);
                windings[i].run(kHalf_s);
                highest_A = std::max(highest_A, windings[i].peak_A);
                ASSERT_LE(std::abs(next_V[i]), 1.00001F * settings.largest_voltage_V);
            }
        }
    }
    EXPECT_LE(highest_A, kPeak_A + kLag_A + kNoise_A);
    EXPECT_GT(highest_A, 0.99 * kPeak_A); // not vacuous
    EXPECT_GT(limited_loops, 10'000);
    RecordProperty("highest_mA", static_cast<int>(1e3 * highest_A));
}

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

    void begin() {
        run_loops(1600);
        usb::Command first;
        first.begins_numbering = true;
        send(first);
        run_loops(40);
    }

    [[nodiscard]] SimulatedPhantom &plant() { return plant_; }

private:
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
};

/// What remains is the rounding of `float`.
TEST(SimulatedBoard, SettlesAtTheCurrentsOfTheSimulatedAmplifiers) {
    BoardAndPhantom board(testing::phantom_1_0());
    board.begin();
    SimulatedPhantom direct(testing::phantom_1_0(), options(kServo_s), testing::kOffCentre_m);
    const Vector3 e_W_V(0.3, -0.2, 0.25);
    for (int tick = 0; tick < 2000; ++tick) {
        board.send(testing::driving(e_W_V));
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
