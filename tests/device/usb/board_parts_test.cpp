// Covers device/usb/board/loop_parts.h, values.h, link.h and exchange.h, and
// tests/device/usb/core_checks.h.
#include "device/usb/board/exchange.h"
#include "device/usb/board/link.h"
#include "device/usb/board/loop_parts.h"

#include "base/vector.h"
#include "device/core/motor/winding_heat.h"
#include "tests/device/usb/core_checks.h"
#include "tests/support/devices.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace springdrive::board {
namespace {

TEST(Encoder, FollowsRandomMotionsOverManyTurnsOfTheCounter) {
    std::mt19937_64 random(1);
    for (const std::int8_t sign : {std::int8_t{1}, std::int8_t{-1}}) {
        Encoder encoder;
        std::int64_t truth = 12345;
        const std::int64_t start = truth;
        EXPECT_TRUE(encoder.update(static_cast<std::uint16_t>(truth & 0xffff), 1000));
        std::int64_t drift = 0;
        std::int64_t farthest = 0;
        for (int i = 0; i < 1'000'000; ++i) {
            if (i % 5000 == 0) {
                drift = std::uniform_int_distribution<std::int64_t>(-900, 900)(random);
            }
            truth += drift + std::uniform_int_distribution<std::int64_t>(-100, 100)(random);
            EXPECT_TRUE(encoder.update(static_cast<std::uint16_t>(truth & 0xffff), 1000));
            ASSERT_EQ(encoder.counts(sign), sign * (truth - start));
            farthest = std::max(farthest, std::abs(truth - start));
        }
        EXPECT_GT(farthest, 10 * 65536); // not vacuous
    }
}

TEST(Encoder, RejectsAJumpOnBothSidesOfTheLimit) {
    for (const int limit : {1, 64, 32000}) {
        for (const int direction : {-1, 1}) {
            Encoder encoder;
            std::uint16_t counter = 65000;
            EXPECT_TRUE(encoder.update(counter, limit));
            counter = static_cast<std::uint16_t>(counter + direction * limit);
            EXPECT_TRUE(encoder.update(counter, limit));
            counter = static_cast<std::uint16_t>(counter + direction * (limit + 1));
            EXPECT_FALSE(encoder.update(counter, limit));
            EXPECT_EQ(encoder.counts(1), direction * (2 * limit + 1)); // still followed
        }
    }
}

TEST(Encoder, RollsOverAt32BitsWithoutOverflow) {
    Encoder encoder;
    EXPECT_TRUE(encoder.update(0, 10));
    encoder.declare(std::numeric_limits<std::int32_t>::max() - 3, 1);
    EXPECT_TRUE(encoder.update(7, 10));
    EXPECT_EQ(encoder.counts(1), std::numeric_limits<std::int32_t>::min() + 3);
}

TEST(Encoder, DeclaresCountsWithEitherSign) {
    for (const std::int8_t sign : {std::int8_t{1}, std::int8_t{-1}}) {
        Encoder encoder;
        (void)encoder.update(100, 1000);
        (void)encoder.update(150, 1000);
        encoder.declare(-7, sign);
        EXPECT_EQ(encoder.counts(sign), -7);
        (void)encoder.update(152, 1000);
        EXPECT_EQ(encoder.counts(sign), -7 + 2 * sign);
    }
}

Matrix3 to_eigen(const SymmetricMatrix &M) {
    Matrix3 eigen;
    eigen << M.diagonal[0], M.off_diagonal[0], M.off_diagonal[1], //
        M.off_diagonal[0], M.diagonal[1], M.off_diagonal[2],      //
        M.off_diagonal[1], M.off_diagonal[2], M.diagonal[2];
    return eigen;
}

SymmetricMatrix from_eigen(const Matrix3 &M) {
    const auto f = [&](int row, int column) { return static_cast<float>(M(row, column)); };
    return {{f(0, 0), f(1, 1), f(2, 2)}, {f(0, 1), f(0, 2), f(1, 2)}};
}

/// Eigenvectors at random.
Matrix3 random_rotation(std::mt19937_64 &random) {
    std::normal_distribution<double> element;
    Matrix3 matrix;
    for (int i = 0; i < 9; ++i) {
        matrix(i / 3, i % 3) = element(random);
    }
    return Eigen::SelfAdjointEigenSolver<Matrix3>(matrix + matrix.transpose()).eigenvectors();
}

TEST(Matrix, ProductsAgreeWithEigen) {
    std::mt19937_64 random(2);
    std::normal_distribution<double> element;
    for (int i = 0; i < 1000; ++i) {
        const Matrix3 rotation = random_rotation(random);
        const Vector3 eigenvalues(element(random), element(random), element(random));
        const SymmetricMatrix M =
            from_eigen(rotation * eigenvalues.asDiagonal() * rotation.transpose());
        const Triple a{1.0F, -2.0F, 0.5F};
        const Triple b{0.3F, 0.7F, -1.1F};
        const Triple sum = add_product(a, M, b);
        const Vector3 expected = Vector3(1.0, -2.0, 0.5) + to_eigen(M) * Vector3(0.3, 0.7, -1.1);
        EXPECT_LT((Vector3(sum[0], sum[1], sum[2]) - expected).norm(), 2e-6);
        const SymmetricMatrix diagonal{M.diagonal, {}};
        EXPECT_EQ(add_product(a, diagonal, b), add_diagonal_product(a, diagonal, b));
    }
}

TEST(Matrix, DefinitenessAgreesWithEigenvalues) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> eigenvalue(-1.0, 4.0);
    int positive = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Matrix3 rotation = random_rotation(random);
        const Vector3 eigenvalues(eigenvalue(random), eigenvalue(random), eigenvalue(random));
        if (std::abs(eigenvalues.minCoeff()) < 1e-4) {
            continue; // within the rounding of float
        }
        const SymmetricMatrix M =
            from_eigen(rotation * eigenvalues.asDiagonal() * rotation.transpose());
        EXPECT_EQ(is_positive_definite(M), eigenvalues.minCoeff() > 0.0);
        positive += is_positive_definite(M) ? 1 : 0;
    }
    EXPECT_GT(positive, 5000);
    EXPECT_FALSE(is_positive_definite({{kNotMeasured, 1.0F, 1.0F}, {}}));
    EXPECT_FALSE(is_positive_definite({{1.0F, 1.0F, 1.0F}, {0.0F, kNotMeasured, 0.0F}}));
    EXPECT_FALSE(is_positive_definite({{1.0F, 1.0F, 1.0F}, {3e30F, 0.0F, 0.0F}}));
}

usb::Command command_to_drive() {
    usb::Command command;
    command.mode = usb::Mode::drive;
    return command;
}

usb::FrameStatus check(const usb::Command &command, const BoardSettings &settings = {}) {
    return check_limits(command, settings, settings.largest_cancelled_Ohm);
}

TEST(CommandLimits, HoldOnBothSides) {
    using usb::FrameStatus;
    const BoardSettings settings;
    for (std::size_t i = 0; i < 3; ++i) {
        for (const float side : {1.0F, -1.0F}) {
            usb::Command command = command_to_drive();
            command.e_W_V[i] = side * settings.largest_voltage_V;
            EXPECT_EQ(check(command), FrameStatus::ok);
            command.e_W_V[i] *= 1.000001F;
            EXPECT_EQ(check(command), FrameStatus::beyond_limits);
        }
        const auto with = [&](float resistance_Ohm, float inductance_H) {
            usb::Command command = command_to_drive();
            command.cancelled_resistance_Ohm.diagonal[i] = resistance_Ohm;
            command.cancelled_inductance_H.diagonal[i] = inductance_H;
            return check(command);
        };
        EXPECT_EQ(with(0.9999F * settings.largest_cancelled_Ohm[i], 0.0F), FrameStatus::ok);
        EXPECT_EQ(with(1.0001F * settings.largest_cancelled_Ohm[i], 0.0F),
                  FrameStatus::beyond_limits);
        EXPECT_EQ(with(-0.9999F * settings.largest_added_Ohm, 0.0F), FrameStatus::ok);
        EXPECT_EQ(with(-1.0001F * settings.largest_added_Ohm, 0.0F), FrameStatus::beyond_limits);
        EXPECT_EQ(with(0.0F, 0.9999F * settings.largest_cancelled_H), FrameStatus::ok);
        EXPECT_EQ(with(0.0F, 1.0001F * settings.largest_cancelled_H), FrameStatus::beyond_limits);
        EXPECT_EQ(with(0.0F, -0.9999F * settings.largest_added_H), FrameStatus::ok);
        EXPECT_EQ(with(0.0F, -1.0001F * settings.largest_added_H), FrameStatus::beyond_limits);
    }
}

/// In no direction may the total resistance be less than the windings' minus the bound.
TEST(CommandLimits, HoldInEveryDirection) {
    std::mt19937_64 random(4);
    const BoardSettings settings;
    for (int i = 0; i < 2000; ++i) {
        const Matrix3 rotation = random_rotation(random);
        for (const double share : {0.999, 1.001}) {
            usb::Command command = command_to_drive();
            const Vector3 eigenvalues(share * settings.largest_cancelled_Ohm[0], 0.5, -1.0);
            command.cancelled_resistance_Ohm =
                from_eigen(rotation * eigenvalues.asDiagonal() * rotation.transpose());
            EXPECT_EQ(check(command),
                      share < 1.0 ? usb::FrameStatus::ok : usb::FrameStatus::beyond_limits);
        }
    }
}

TEST(CommandLimits, IndependentChannelsRejectOffDiagonals) {
    BoardSettings settings;
    settings.couples_channels = false;
    usb::Command command = command_to_drive();
    command.cancelled_resistance_Ohm.off_diagonal[1] = 1e-20F;
    EXPECT_EQ(check(command, settings), usb::FrameStatus::coupled);
    EXPECT_EQ(check(command), usb::FrameStatus::ok);
    command.mode = usb::Mode::brake;
    EXPECT_EQ(check(command, settings), usb::FrameStatus::ok);
}

TEST(CurrentOffsets, AreTheMeansOfOpenWindings) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0.0, 0.003);
    CurrentOffsets offsets;
    auto progress = CurrentOffsets::Progress::measuring;
    int loops = 0;
    while (progress == CurrentOffsets::Progress::measuring) {
        const float transient_A = loops < CurrentOffsets::kSettlingLoops ? 3.0F : 0.0F;
        const auto n = static_cast<float>(noise(random));
        progress =
            offsets.update({0.02F + n + transient_A, -0.05F + n, 0.0F + n}, /*largest_A=*/0.1F);
        ++loops;
    }
    EXPECT_EQ(progress, CurrentOffsets::Progress::ready);
    EXPECT_EQ(loops, CurrentOffsets::kSettlingLoops + CurrentOffsets::kMeasuredLoops);
    const double error_A = 5.0 * 0.003 / std::sqrt(CurrentOffsets::kMeasuredLoops);
    EXPECT_NEAR(offsets.offset_A()[0], 0.02, error_A);
    EXPECT_NEAR(offsets.offset_A()[1], -0.05, error_A);
}

TEST(CurrentOffsets, FailBeyondTheLimitAndForNaN) {
    for (const float current_A : {0.1001F, -0.1001F, kNotMeasured, 0.0999F}) {
        CurrentOffsets offsets;
        auto progress = CurrentOffsets::Progress::measuring;
        while (progress == CurrentOffsets::Progress::measuring) {
            progress = offsets.update({0.0F, 0.0F, current_A}, 0.1F);
        }
        EXPECT_EQ(progress == CurrentOffsets::Progress::ready, current_A == 0.0999F);
    }
}

/// Against the exact network of device/core, in double precision, with the bounds' extremes.
TEST(WindingHeat, BoundsContainTheTrueWinding) {
    const device::MotorParameters &motor = testing::phantom_motor();
    for (const double current_A : {0.3, 1.0, 1.24, 3.0}) {
        WindingHeat heat(WindingSettings(), 0.01F, true);
        constexpr double kPeriod_s = WindingHeat::kPeriod_s;
        device::WindingTemperature winding(motor.thermal, 25.0, kPeriod_s);
        for (int i = 0; i < 20 * 1200; ++i) {
            heat.update(static_cast<float>(current_A * current_A));
            winding.update(device::winding_resistance_Ohm(motor, winding.winding_C(), 0.1) *
                           current_A * current_A);
            if (heat.is_too_hot()) {
                break;
            }
            ASSERT_LE(winding.winding_C(), heat.upper_C());
            const double rise = 1.0 + motor.resistance_rise_per_K * (winding.winding_C() - 25.0);
            ASSERT_GE(rise, heat.certain_rise());
        }
        EXPECT_LE(winding.winding_C(), motor.thermal.max_winding_C);
    }
}

/// Over heating, rest, pauses of the loop, and power-ups, in any air and with any R of the
/// tolerance.
TEST(WindingHeat, BoundsHoldOverAnyHistory) {
    const device::MotorParameters file = testing::phantom_motor();
    std::mt19937_64 random(6);
    const auto any = [&](double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random);
    };
    int risen = 0;
    for (int history = 0; history < 200; ++history) {
        device::MotorParameters motor = file;
        motor.resistance_Ohm *= any(0.95, 1.05);
        const double air_C = any(15.0, 35.0);
        WindingHeat heat(WindingSettings(), 0.01F, history % 2 == 0);
        device::WindingTemperature truth(motor.thermal, air_C, WindingHeat::kPeriod_s);
        for (int part = 0; part < 30; ++part) {
            const double current_A = any(0.0, 5.5);
            for (int i = 0; i < 100; ++i) {
                const double true_A = heat.is_too_hot() ? 0.0 : current_A;
                const double measured_A = true_A * any(0.99, 1.01);
                heat.update(static_cast<float>(measured_A * measured_A));
                truth.update(
                    device::winding_resistance_Ohm(motor, truth.winding_C(), any(0.0, 6.0)) *
                    true_A * true_A);
                ASSERT_LE(truth.winding_C(), heat.upper_C() + 0.01F);
                const double rise = 1.0 + file.resistance_rise_per_K * (truth.winding_C() - 25.0);
                ASSERT_GE(std::max(1.0, rise), heat.certain_rise() - 1e-5F);
                risen += heat.certain_rise() > 1.02F ? 1 : 0;
            }
            if (part % 3 == 1) {
                const device::MotorTemperature before = truth.temperature();
                device::WindingTemperature rest(motor.thermal, air_C, any(0.0, 1000.0));
                rest.raise_to(before);
                rest.update(0.0);
                truth = device::WindingTemperature(motor.thermal, air_C, WindingHeat::kPeriod_s);
                truth.raise_to(rest.temperature());
                heat.forget_lower();
                if (random() % 2 == 0) {
                    heat = WindingHeat(WindingSettings(), 0.01F, false);
                }
            }
        }
    }
    EXPECT_GT(risen, 1000); // not vacuous
}

TEST(WindingHeat, TripsSoonAtPeakAndNeverBelowTheContinuousCurrent) {
    const auto trips_after_s = [](float current_A) {
        WindingHeat heat(WindingSettings(), 0.01F, true);
        for (int i = 1; i < 20 * 3600; ++i) {
            heat.update(current_A * current_A);
            if (heat.is_too_hot()) {
                return i * static_cast<double>(WindingHeat::kPeriod_s);
            }
        }
        return 3600.0;
    };
    // At 5.5 A the most resistive winding takes up 73 W at 35 °C and 91 W at 100 °C, of which it
    // passes on 0 to 21 W, with a heat capacity of 3.87 J/K: 65 K take about 3.5 s.
    EXPECT_NEAR(trips_after_s(5.5F), 3.5, 0.3);
    // At 100 °C the network passes on 65 K/(17.1 K/W) = 3.80 W, from at most 3.08 Ω: 1.11 A.
    EXPECT_EQ(trips_after_s(1.10F), 3600.0);
    EXPECT_LT(trips_after_s(1.14F), 3600.0);
    // R that only certainly rises permits more R̂, at most the copper's share.
    WindingHeat heat(WindingSettings(), 0.01F, true);
    EXPECT_EQ(heat.certain_rise(), 1.0F);
}

// Every pair, written as a person reads the transitions, not as the table is stored.
TEST(StateMachine, EveryPairOfStateAndEvent) {
    using enum usb::BoardState;
    const auto expected = [](State state, Event event) {
        const bool is_fault = state == fault_braking || state == fault_open;
        switch (event) {
        case Event::offsets_ready:
            return state == starting ? braking : state;
        case Event::command_brake:
            return state == driving || state == opened ? braking : state;
        case Event::command_drive:
            return state == braking ? driving : state == testing ? braking : state;
        case Event::command_open:
            return state == starting        ? starting
                   : state == fault_braking ? fault_open
                   : state == fault_open    ? fault_open
                                            : opened;
        case Event::silence:
            return state == driving || state == testing ? fault_braking : state;
        case Event::braking_fault: // what is open stays open
            return state == starting || state == opened || state == fault_open ? fault_open
                                                                               : fault_braking;
        case Event::opening_fault:
            return fault_open;
        case Event::reset:
            return state == fault_open            ? starting
                   : is_fault || state == driving ? braking
                   : state == testing             ? braking
                                                  : state;
        case Event::test_started:
            return state == braking ? testing : state;
        case Event::test_ended:
            return state == testing ? braking : state;
        }
        return state;
    };
    for (std::size_t state = 0; state < usb::kBoardStates; ++state) {
        for (std::size_t event = 0; event < kEvents; ++event) {
            EXPECT_EQ(next_state(static_cast<State>(state), static_cast<Event>(event)),
                      expected(static_cast<State>(state), static_cast<Event>(event)))
                << "state " << state << ", event " << event;
        }
    }
}

TEST(Published, GivesTheNewestValue) {
    Published<int> number;
    EXPECT_EQ(number.copy(), 0);
    for (int i = 1; i < 10; ++i) {
        number.publish(i);
        EXPECT_EQ(number.copy(), i);
        EXPECT_EQ(number.newest(), i);
    }
}

// On the host; device/usb/board/arm/build runs the same checks on an emulated Cortex-M4.
TEST(CoreChecks, Hold) {
    for (const testing::CoreCheck &check : testing::kCoreChecks) {
        EXPECT_TRUE(check.holds()) << check.name;
    }
    EXPECT_EQ(testing::trial_checksum(), testing::kTrialChecksum);
}

} // namespace
} // namespace springdrive::board
