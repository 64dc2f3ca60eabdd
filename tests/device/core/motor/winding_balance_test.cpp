// Covers device/core/motor/winding_balance.h: windings in closed form on both sides of R, with the
// errors of sensors, counts, constants and delay.
#include "device/core/motor/winding_balance.h"

#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>

namespace springdrive::device {
namespace {

// A Maxon RE 25 118743 and the sensors of assets/devices/phantom_1_0.toml.
constexpr double kR_Ohm = 2.18;
constexpr double kL_H = 0.238e-3;
constexpr double kTorqueConstant = 23.4e-3;
constexpr double kCount_rad = 2.0 * std::numbers::pi / 4096.0;
constexpr double kNoise_A = 0.003;
constexpr double kResolution_A = 0.0027;
constexpr double kOffset_A = 0.02;

BalanceSettings settings(double period_s, double max_brush_V = 0.5) {
    BalanceSettings of;
    of.resistance_Ohm = 3.0F; // at 100 °C
    of.inductance_H = static_cast<float>(kL_H);
    of.torque_constant_Nm_per_A = static_cast<float>(kTorqueConstant);
    of.count_rad = static_cast<float>(kCount_rad);
    of.noise_A = static_cast<float>(6.0 * std::sqrt(2.0) * kNoise_A + kResolution_A);
    of.max_offset_A = static_cast<float>(kOffset_A);
    of.delay_s = static_cast<float>(0.3 * period_s);
    of.max_brush_V = static_cast<float>(max_brush_V);
    return of;
}

/// What differs between a motor and what is known of it.
struct Errors {
    double offset_A = 0.0;
    double sensor_gain = 1.0;
    double amplifier_gain = 1.0;
    double torque_constant_share = 1.0;
    double inductance_share = 1.0;
    double delay_periods = 0.0; ///< e_W acts so much later
    double noise_A = 0.0;
    bool is_rounded = false;

    static Errors drawn(std::mt19937_64 &random) {
        std::uniform_real_distribution<double> either(-1.0, 1.0);
        Errors drawn;
        drawn.offset_A = kOffset_A * either(random);
        drawn.sensor_gain += 0.01 * either(random);
        drawn.amplifier_gain += 0.02 * either(random);
        drawn.torque_constant_share += 0.03 * either(random);
        drawn.inductance_share += 0.05 * either(random);
        drawn.delay_periods = 0.3 * either(random);
        drawn.noise_A = kNoise_A;
        drawn.is_rounded = true;
        return drawn;
    }
};

/// A winding whose rotor turns as it is told, (11) in closed form over short parts of a period, and
/// what a servo of one period of delay knows of it.
class Motor {
public:
    static constexpr int kParts = 20; ///< so that 0.3 periods are a whole number of them

    Motor(double period_s, double dR_Ohm, double brush_V, const Errors &errors)
        : period_s_(period_s), brush_V_(brush_V), errors_(errors),
          R_hat_Ohm_((kR_Ohm - dR_Ohm) / (errors.sensor_gain * errors.amplifier_gain)),
          late_parts_(static_cast<int>(std::lround(errors.delay_periods * kParts))) {
        for (const bool brakes : {false, true}) {
            const double L_H = kL_H * errors.inductance_share;
            const double z = (brakes ? kR_Ohm : dR_Ohm) * period_s / kParts / L_H;
            decay_[brakes] = std::exp(-z);
            gain_[brakes] = (z == 0.0 ? 1.0 : -std::expm1(-z) / z) * period_s / kParts / L_H;
        }
    }

    /// A period with the command of the period before, and then one that is to act next.
    /// @param rate_rad_per_s  at its end; changes evenly
    BalanceInterval run(double next_e_W_V, double rate_rad_per_s, std::mt19937_64 &random) {
        const double part_s = period_s_ / kParts;
        const double before_rad = measured_rad_;
        const double before_A = measured_A_;
        const double change = (rate_rad_per_s - rate_rad_per_s_) / kParts;
        for (int part = 0; part < kParts; ++part) {
            // Late by some parts: still the last command; early: the next one already.
            const double e_W_V = part < late_parts_             ? last_e_W_V_
                                 : part >= kParts + late_parts_ ? next_e_W_V
                                                                : e_W_V_;
            const double rate = rate_rad_per_s_ + (part + 0.5) * change;
            step(errors_.amplifier_gain * e_W_V -
                 errors_.torque_constant_share * kTorqueConstant * rate);
            theta_rad_ += rate * part_s;
        }
        rate_rad_per_s_ = rate_rad_per_s;
        measure(random);
        const BalanceInterval interval{static_cast<float>(period_s_),
                                       static_cast<float>(e_W_V_),
                                       static_cast<float>(e_W_V_),
                                       static_cast<float>(next_e_W_V),
                                       static_cast<float>(brakes_ ? 0.0 : R_hat_Ohm_),
                                       static_cast<float>(before_A),
                                       static_cast<float>(measured_A_),
                                       static_cast<float>(measured_rad_ - before_rad)};
        last_e_W_V_ = std::exchange(e_W_V_, next_e_W_V);
        return interval;
    }

    /// At rest, for the time that a start takes.
    void brake(WindingBalance &balance, std::mt19937_64 &random) {
        brakes_ = true;
        for (double time_s = 0.0; time_s < 0.25; time_s += period_s_) {
            balance.update(run(0.0, 0.0, random));
        }
        brakes_ = false;
    }

    [[nodiscard]] double R_hat_Ohm() const { return R_hat_Ohm_; }
    [[nodiscard]] double current_A() const { return current_A_; }
    void set_current(double current_A) { current_A_ = current_A; }

private:
    void step(double net_V) {
        const double feedback_V = brakes_ ? 0.0 : R_hat_Ohm_ * errors_.offset_A;
        const double free_V = net_V + errors_.amplifier_gain * feedback_V;
        const double sign =
            current_A_ != 0.0 ? std::copysign(1.0, current_A_) : std::copysign(1.0, free_V);
        if (current_A_ == 0.0 && std::abs(free_V) <= brush_V_) {
            return;
        }
        const double next_A =
            decay_[brakes_] * current_A_ + gain_[brakes_] * (free_V - sign * brush_V_);
        current_A_ = brush_V_ > 0.0 && next_A * sign < 0.0 ? 0.0 : next_A;
    }

    void measure(std::mt19937_64 &random) {
        std::normal_distribution<double> noise(0.0, errors_.noise_A > 0.0 ? errors_.noise_A : 1.0);
        measured_A_ = errors_.sensor_gain * current_A_ + errors_.offset_A;
        measured_rad_ = theta_rad_;
        if (errors_.is_rounded) {
            measured_A_ = std::round((measured_A_ + noise(random)) / kResolution_A) * kResolution_A;
            measured_rad_ = std::round(theta_rad_ / kCount_rad) * kCount_rad;
        }
    }

    double period_s_;
    double brush_V_;
    Errors errors_;
    double R_hat_Ohm_;
    int late_parts_;
    std::array<double, 2> decay_{}; ///< driven, braking
    std::array<double, 2> gain_{};
    double current_A_ = 0.0;
    double rate_rad_per_s_ = 0.0;
    double theta_rad_ = 0.3 * kCount_rad;
    double measured_A_ = 0.0;
    double measured_rad_ = 0.0;
    double e_W_V_ = 0.0;
    double last_e_W_V_ = 0.0;
    bool brakes_ = false;
};

/// Ticks until a winding whose rotor is held is found to generate, from a current on, with a
/// constant e_W; 0: never while it is between 0.1 and 5.2 A.
int ticks_to_latch(Motor &motor, WindingBalance &balance, double current_A, double e_W_V,
                   std::mt19937_64 &random) {
    motor.set_current(0.0);
    static_cast<void>(motor.run(e_W_V, 0.0, random)); // the command is on its way
    motor.set_current(current_A);
    balance.update(motor.run(e_W_V, 0.0, random)); // across a jump that no winding makes
    for (int tick = 2; tick < 100; ++tick) {
        balance.update(motor.run(e_W_V, 0.0, random));
        if (balance.generates()) {
            return tick;
        }
        if (!(std::abs(motor.current_A()) > 0.1 && std::abs(motor.current_A()) < 5.2)) {
            break;
        }
    }
    return 0;
}

class WindingBalanceAt : public ::testing::TestWithParam<double> {
protected:
    double period_s_ = 1.0 / GetParam();
    std::mt19937_64 random_{1};
};

// Steady at an unstable equilibrium, e_W = dR i, and growing by itself.
TEST_P(WindingBalanceAt, FindsAnOhmTooMuchOfThreeTenthsWithinThreeMilliseconds) {
    const int runs = testing::cases(200, 20'000);
    double longest_s = 0.0;
    for (int run = 0; run < runs; ++run) {
        std::uniform_real_distribution<double> any(0.0, 1.0);
        const Errors errors = Errors::drawn(random_);
        Motor motor(period_s_, -0.3, 0.0, errors);
        WindingBalance balance(settings(period_s_));
        motor.brake(balance, random_);
        const double from_A = (any(random_) < 0.5 ? -1.0 : 1.0) * (0.17 + 0.8 * any(random_));
        // Less the offset, which R̂ feeds back.
        const double steady_V =
            -0.3 * from_A / errors.amplifier_gain - motor.R_hat_Ohm() * errors.offset_A;
        const double e_W_V =
            steady_V + 0.2 * std::abs(from_A) * any(random_) * std::copysign(1.0, from_A);
        const int ticks = ticks_to_latch(motor, balance, from_A, e_W_V, random_);
        ASSERT_GT(ticks, 0) << "run " << run << ", from " << from_A << " A";
        longest_s = std::max(longest_s, ticks * period_s_);
        ASSERT_LE(ticks * period_s_, 3e-3) << "run " << run << ", from " << from_A << " A";
    }
    std::printf("longest of %d: %.2f ms\n", runs, 1e3 * longest_s);
}

// Hands that press, stroke and let go, as currents and speeds that change evenly or by steps.
TEST_P(WindingBalanceAt, DoesNotTakeAHealthyWindingForOneThatGenerates) {
    const double hours = testing::cases(1, 1500) * 0.0033; // at each rate; 12 s by default
    const int runs = static_cast<int>(hours * 3600.0 / 4.0) + 1;
    for (int run = 0; run < runs; ++run) {
        std::uniform_real_distribution<double> any(0.0, 1.0);
        std::uniform_real_distribution<double> either(-1.0, 1.0);
        const double dR_Ohm = kR_Ohm * std::pow(0.02, any(random_));
        const double brush_V = any(random_) < 0.5 ? 0.0 : 0.5 * any(random_);
        const Errors errors = Errors::drawn(random_);
        Motor motor(period_s_, dR_Ohm, brush_V, errors);
        WindingBalance balance(settings(period_s_));
        if (any(random_) < 0.8) { // else its offset is not known
            motor.brake(balance, random_);
        }
        double target_A = 0.0;
        double smooth_A = 0.0;
        double target_rate = 0.0;
        double rate = 0.0;
        const double share = period_s_ / (1e-3 + 0.03 * any(random_));
        const double jitter_V = 0.3 * any(random_) * any(random_);
        for (double time_s = 0.0; time_s < 4.0; time_s += period_s_) {
            if (any(random_) < 20.0 * period_s_) {
                target_A = 4.0 * either(random_) * any(random_);
            }
            if (any(random_) < 10.0 * period_s_) {
                target_rate = any(random_) < 0.4 ? 0.0 : 100.0 * either(random_);
            }
            smooth_A += std::min(1.0, share) * (target_A - smooth_A);
            rate += std::min(1.0, 0.3 * share) * (target_rate - rate);
            const double e_W_V = dR_Ohm * smooth_A + std::copysign(brush_V, smooth_A) +
                                 kTorqueConstant * rate + jitter_V * either(random_);
            const BalanceInterval interval = motor.run(e_W_V, rate, random_);
            if (std::abs(motor.current_A()) < 5.2) {
                balance.update(interval);
            } else {
                balance.forget();
            }
            ASSERT_FALSE(balance.generates())
                << "run " << run << " at " << time_s << " s: dR " << dR_Ohm << " Ω, V_b " << brush_V
                << " V, " << motor.current_A() << " A";
        }
    }
}

// Exact measurements: 2 R − R̂ is left, less what the mean of the ends is too large by, which is up
// to 1.34 times at −0.5 Ω and 1 kHz.
TEST_P(WindingBalanceAt, LowersByTwiceTheExcess) {
    for (const double excess_Ohm : {0.05, 0.1, 0.3, 0.5}) {
        Motor motor(period_s_, -excess_Ohm, 0.0, {});
        WindingBalance balance(settings(period_s_, 0.0));
        motor.brake(balance, random_);
        ASSERT_GT(ticks_to_latch(motor, balance, 0.5, 0.0, random_), 0) << excess_Ohm;
        const double left_Ohm = kR_Ohm - static_cast<double>(balance.limit_Ohm());
        EXPECT_LT(left_Ohm, 1.02 * excess_Ohm);
        EXPECT_GT(left_Ohm, (2.0 / 1.35 - 1.0) * excess_Ohm);
    }
}

// Only what the brushes leave is seen to be generated. Up to half of their largest voltage, R̂ is
// below R at once; with no such bound known, when the current has grown on.
TEST_P(WindingBalanceAt, LeavesAResistanceBehindBrushes) {
    for (const double brush_V : {0.05, 0.1, 0.2, 0.25}) {
        Motor motor(period_s_, -0.3, brush_V, {});
        WindingBalance balance(settings(period_s_, 0.5));
        WindingBalance without(settings(period_s_, 0.0));
        motor.brake(balance, random_);
        const double from_A = 1.1 * brush_V / 0.3;
        ASSERT_GT(ticks_to_latch(motor, balance, from_A, 0.0, random_), 0) << brush_V;
        EXPECT_LT(static_cast<double>(balance.limit_Ohm()), kR_Ohm) << brush_V;

        Motor again(period_s_, -0.3, brush_V, {});
        again.brake(without, random_);
        ASSERT_GT(ticks_to_latch(again, without, from_A, 0.0, random_), 0) << brush_V;
        const double first_Ohm = static_cast<double>(without.limit_Ohm());
        Motor lowered(period_s_, kR_Ohm - first_Ohm, brush_V, {});
        if (first_Ohm > kR_Ohm + 0.1) {
            ASSERT_GT(ticks_to_latch(lowered, without, 4.0, 0.0, random_), 0) << brush_V;
            EXPECT_LT(static_cast<double>(without.limit_Ohm()), first_Ohm - 0.05) << brush_V;
        }
    }
}

// R times an offset of 20 mA is 0.3 Ω at 0.15 A: of a steady current below 0.17 A nothing can be
// said before the motor has been at rest.
TEST_P(WindingBalanceAt, MeasuresTheOffsetAtRest) {
    Errors errors;
    errors.offset_A = kOffset_A;
    for (const bool rests : {false, true}) {
        Motor motor(period_s_, -0.3, 0.0, errors);
        WindingBalance balance(settings(period_s_));
        if (rests) {
            motor.brake(balance, random_);
        }
        const double steady_V = 0.3 * 0.17 - motor.R_hat_Ohm() * kOffset_A;
        const int ticks = ticks_to_latch(motor, balance, -0.17, steady_V, random_);
        EXPECT_EQ(ticks > 0 && ticks * period_s_ <= 3e-3, rests) << ticks;
    }
}

TEST_P(WindingBalanceAt, LatchesUntilItIsReset) {
    Motor motor(period_s_, -0.3, 0.0, {});
    WindingBalance balance(settings(period_s_));
    motor.brake(balance, random_);
    ASSERT_GT(ticks_to_latch(motor, balance, 0.5, 0.0, random_), 0);
    const float limit_Ohm = balance.limit_Ohm();
    Motor healthy(period_s_, 0.5, 0.0, {});
    EXPECT_GT(ticks_to_latch(healthy, balance, 0.5, 0.25, random_), 0); // still
    balance.forget();
    EXPECT_EQ(balance.limit_Ohm(), limit_Ohm);
    balance.reset();
    EXPECT_FALSE(balance.generates());
    EXPECT_EQ(ticks_to_latch(healthy, balance, 0.5, 0.25, random_), 0);
}

TEST_P(WindingBalanceAt, IgnoresWhatIsNotANumber) {
    const float none = std::numeric_limits<float>::quiet_NaN();
    WindingBalance balance(settings(period_s_));
    Motor motor(period_s_, -0.3, 0.0, {});
    motor.brake(balance, random_);
    for (float BalanceInterval::*const value :
         {&BalanceInterval::e_W_V, &BalanceInterval::after_A, &BalanceInterval::turned_rad}) {
        BalanceInterval interval = motor.run(0.0, 0.0, random_);
        interval.*value = none;
        balance.update(interval);
        EXPECT_FALSE(balance.generates());
    }
    EXPECT_GT(ticks_to_latch(motor, balance, 0.5, 0.0, random_), 0);
}

INSTANTIATE_TEST_SUITE_P(Rates, WindingBalanceAt, ::testing::Values(1000.0, 4000.0),
                         [](const auto &rate) {
                             return std::to_string(static_cast<int>(rate.param)) + "Hz";
                         });

} // namespace
} // namespace springdrive::device
