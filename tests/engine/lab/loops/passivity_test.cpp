// Covers engine/lab/loops/passivity.cpp: against the sums themselves, against a shaker at the
// winding in time, against linear hands by eigenvalues, and (12) where the period is short.
#include "engine/control/velocity_filter.h"
#include "engine/lab/loops/passivity.h"
#include "tests/support/cases.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace springdrive::loops {
namespace {

using PortNumber = std::complex<double>;

constexpr double kPortDamping = 3e-6; // [N·m·s/rad] of the PHANTOM's joints, at the rotor

class PassivityTest : public ::testing::Test {
protected:
    double between(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    double on_a_logarithm(double low, double high) {
        return std::exp(between(std::log(low), std::log(high)));
    }

    SpringDrive any_drive() {
        SpringDrive drive;
        drive.motor = testing::phantom_motor();
        drive.tuning.dR_Ohm = on_a_logarithm(0.1, 1.0);
        drive.tuning.K_P_V_per_rad = on_a_logarithm(1.0, 50.0);
        drive.tuning.K_D_Vs_per_rad = between(0.0, 0.05);
        drive.tuning.lambda_rad_per_s = on_a_logarithm(100.0, 5000.0);
        drive.period_s = on_a_logarithm(1e-4, 4e-3);
        drive.delay_periods = between(0.0, 1.0) < 0.3 ? 0.0 : between(0.0, 2.5);
        return drive;
    }

    std::mt19937 random_{20261129};
};

SpringDrive drive_at_1_kHz(double dR_Ohm, double K_P_V_per_rad) {
    SpringDrive drive;
    drive.motor = testing::phantom_motor();
    drive.tuning.dR_Ohm = dR_Ohm;
    drive.tuning.K_P_V_per_rad = K_P_V_per_rad;
    drive.tuning.K_D_Vs_per_rad = 0.001;
    drive.tuning.lambda_rad_per_s = 500.0;
    drive.period_s = 1e-3;
    drive.delay_periods = 0.0;
    return drive;
}

/// g_n, q_n and c_n of one alias, as the header defines them.
struct Alias {
    double g = 0.0;
    PortNumber q;
    PortNumber c;

    Alias(const SpringDrive &drive, const Port &port, double omega, long n) {
        const PortNumber j(0.0, 1.0);
        const double T = drive.period_s;
        const double k_T = drive.motor.torque_constant_Nm_per_A;
        const double here = omega + 2.0 * std::numbers::pi * static_cast<double>(n) / T;
        const PortNumber Y = 1.0 / (drive.dR_Ohm() + j * here * drive.motor.inductance_H);
        const PortNumber z1 = std::exp(-j * omega * T);
        const PortNumber H =
            std::exp(-j * here * drive.delay_periods * T) * (1.0 - z1) / (j * here * T);
        const double a = std::exp(-drive.tuning.lambda_rad_per_s * T);
        const PortNumber D = (1.0 - a) * (1.0 - z1) / (T * (1.0 - a * z1));
        const PortNumber C =
            port.held * (drive.tuning.K_P_V_per_rad + drive.tuning.K_D_Vs_per_rad * D) -
            (1.0 - port.held) * k_T * D;
        g = k_T * k_T * Y.real() + port.damping_Nms_per_rad;
        q = k_T * Y * H * C;
        c = std::conj(1.0 / (j * here));
    }
};

TEST_F(PassivityTest, ClosedFormsAreTheSums) {
    for (int run = 0; run < 40; ++run) {
        SpringDrive drive = any_drive();
        const Port port{on_a_logarithm(1e-6, 1e-4), between(0.0, 1.0)};
        drive.period_s = run % 10 == 0 ? 0.05 : drive.period_s; // e^(pT) is no number then
        const double omega = between(0.02, 1.0) * std::numbers::pi / drive.period_s;
        PortNumber both;
        double of_q = 0.0;
        double of_c = 0.0;
        double magnitudes = 0.0;
        constexpr long kTerms = 40000;
        for (long n = -kTerms; n <= kTerms; ++n) {
            const Alias at(drive, port, omega, n);
            both += std::conj(at.c) * at.q / at.g;
            of_q += std::norm(at.q) / at.g;
            of_c += std::norm(at.c) / at.g;
            magnitudes += std::abs(at.c * at.q) / at.g;
        }
        // Beyond, g is b and |c|² = 1/Ω²; of the others it is less than 1e-6.
        of_c += 2.0 * std::pow(drive.period_s / (2.0 * std::numbers::pi), 2) /
                ((kTerms + 0.5) * port.damping_Nms_per_rad);
        const double passive =
            1.0 + 0.5 * (both.real() - std::sqrt(of_q * of_c - both.imag() * both.imag()));
        const double size = 1.0 + std::sqrt(of_q * of_c);
        EXPECT_NEAR(least_absorbed(drive, port, omega), passive, 2e-6 * size) << run;
        // That sum of magnitudes is taken a little larger than it is.
        const double linear = std::abs(1.0 + 0.5 * both) - 0.5 * magnitudes;
        const double found = distance_to_linear_hands(drive, port, omega);
        EXPECT_LE(found, linear + 2e-6 * size) << run;
        EXPECT_GT(found, linear - 2e-3 * magnitudes) << run;
    }
}

/// A vice that turns the rotor by given motions at Ω_n, and the winding's current in time by
/// Runge-Kutta steps.
class Shaker {
public:
    Shaker(const SpringDrive &drive, const Port &port, double omega, Eigen::VectorXcd v, long first)
        : drive_(drive), port_(port), v_(std::move(v)) {
        for (Eigen::Index i = 0; i < v_.size(); ++i) {
            omega_.push_back(omega + 2.0 * std::numbers::pi *
                                         static_cast<double>(first + static_cast<long>(i)) /
                                         drive.period_s);
        }
        held_V_.assign(static_cast<std::size_t>(std::floor(drive.delay_periods)) + 2, 0.0);
    }

    /// The mean power that it puts in over so many periods, after as many ten times [W].
    double mean_power_W(int periods) {
        for (int i = 0; i < 10 * periods; ++i) {
            run_period();
        }
        energy_J_ = 0.0;
        for (int i = 0; i < periods; ++i) {
            run_period();
        }
        return energy_J_ / (periods * drive_.period_s);
    }

private:
    [[nodiscard]] double motion(double time_s, bool is_rate) const {
        const PortNumber j(0.0, 1.0);
        PortNumber sum;
        for (std::size_t i = 0; i < omega_.size(); ++i) {
            const PortNumber turning =
                v_[static_cast<Eigen::Index>(i)] * std::exp(j * omega_[i] * time_s);
            sum += is_rate ? turning : turning / (j * omega_[i]);
        }
        return 2.0 * sum.real();
    }

    void run_period() {
        const double T = drive_.period_s;
        const double start_s = static_cast<double>(tick_++) * T;
        const double theta = motion(start_s, false);
        const double pole = control::velocity_filter_pole(drive_.tuning.lambda_rad_per_s, T);
        rate_ = pole * rate_ + (1.0 - pole) * (theta - theta_) / T;
        theta_ = theta;
        const double k_T = drive_.motor.torque_constant_Nm_per_A;
        held_V_.push_front(-port_.held * (drive_.tuning.K_P_V_per_rad * theta_ +
                                          drive_.tuning.K_D_Vs_per_rad * rate_) +
                           (1.0 - port_.held) * k_T * rate_);
        held_V_.pop_back();
        const double whole = std::floor(drive_.delay_periods);
        const double late_s = (drive_.delay_periods - whole) * T;
        const auto n = static_cast<std::size_t>(whole);
        advance(start_s, late_s, held_V_[n + 1]);
        advance(start_s + late_s, T - late_s, held_V_[n]);
    }

    void advance(double start_s, double duration_s, double e_W_V) {
        constexpr int kSteps = 60;
        const double h = duration_s / kSteps;
        for (int i = 0; i < kSteps && h > 0.0; ++i) {
            const double t = start_s + i * h;
            const double v0 = motion(t, true);
            const double v1 = motion(t + 0.5 * h, true);
            const double v2 = motion(t + h, true);
            const auto current_rate = [&](double current_A, double v) {
                return (e_W_V - drive_.dR_Ohm() * current_A -
                        drive_.motor.torque_constant_Nm_per_A * v) /
                       drive_.motor.inductance_H;
            };
            const auto power_W = [&](double current_A, double v) {
                return port_.damping_Nms_per_rad * v * v -
                       drive_.motor.torque_constant_Nm_per_A * current_A * v;
            };
            const double k1 = current_rate(current_A_, v0);
            const double k2 = current_rate(current_A_ + 0.5 * h * k1, v1);
            const double k3 = current_rate(current_A_ + 0.5 * h * k2, v1);
            const double k4 = current_rate(current_A_ + h * k3, v2);
            const double after_A = current_A_ + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            const double middle_A =
                0.5 * (current_A_ + after_A) + h / 8.0 * (k1 - current_rate(after_A, v2));
            energy_J_ +=
                h / 6.0 *
                (power_W(current_A_, v0) + 4.0 * power_W(middle_A, v1) + power_W(after_A, v2));
            current_A_ = after_A;
        }
    }

    SpringDrive drive_;
    Port port_;
    Eigen::VectorXcd v_;
    std::vector<double> omega_;
    std::deque<double> held_V_; ///< the newest first
    long tick_ = 0;
    double theta_ = 0.0;
    double rate_ = 0.0;
    double current_A_ = 0.0;
    double energy_J_ = 0.0;
};

/// With five of the aliases, moved as the condition says is worst, a shaker gets out of an active
/// port the power predicted, and none out of a passive one however it moves.
TEST_F(PassivityTest, AShakerGetsOutWhatIsPredictedAndNothingOfAPassivePort) {
    constexpr long kFirst = -2;
    constexpr Eigen::Index kCount = 5;
    constexpr int kPeriods = 20;
    int active = 0;
    int passive = 0;
    for (int run = 0; run < 60; ++run) {
        SpringDrive drive = any_drive();
        drive.period_s = 1e-3; // so that the steps resolve L/dR, and the transient is over
        if (run % 2 == 0) {
            drive.tuning.K_P_V_per_rad = between(1.0, 4.0);
            drive.tuning.K_D_Vs_per_rad = 0.0;
            drive.tuning.lambda_rad_per_s = 300.0;
            drive.delay_periods = 0.0;
        }
        const Port port{kPortDamping, run % 4 == 0 ? 0.0 : 1.0};
        const double omega = std::uniform_int_distribution<int>(1, kPeriods / 2 - 1)(random_) *
                             2.0 * std::numbers::pi / (kPeriods * drive.period_s);
        Eigen::VectorXd g(kCount);
        Eigen::VectorXcd q(kCount);
        Eigen::VectorXcd c(kCount);
        for (Eigen::Index i = 0; i < kCount; ++i) {
            const Alias at(drive, port, omega, kFirst + static_cast<long>(i));
            g[i] = std::sqrt(at.g);
            q[i] = at.q / g[i];
            c[i] = at.c / g[i];
        }
        const Eigen::MatrixXcd half = q * c.adjoint();
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> modes(
            Eigen::MatrixXcd::Identity(kCount, kCount) + 0.5 * (half + half.adjoint()));
        const double least = modes.eigenvalues()[0];
        const Eigen::VectorXcd y = modes.eigenvectors().col(0); // Σ g|v|² = 1
        const Eigen::VectorXcd v = y.cwiseQuotient(g.cast<PortNumber>());
        const double exact = least_absorbed(drive, port, omega);
        // The steps' fourth order at the highest alias: (2π·2.5/60)⁴/2880 ≈ 2e-6 of each part.
        const double size = 1.0 + std::sqrt(q.squaredNorm() * c.squaredNorm());
        EXPECT_NEAR(Shaker(drive, port, omega, v, kFirst).mean_power_W(kPeriods), 2.0 * least,
                    5e-5 * size)
            << run;
        EXPECT_LE(exact, least + 1e-9 * size) << run; // all aliases can do more than five
        active += exact < 0.0 ? 1 : 0;
        if (exact >= 0.0) {
            ++passive;
            Eigen::VectorXcd any =
                Eigen::VectorXcd::Random(kCount).cwiseQuotient(g.cast<PortNumber>());
            EXPECT_GT(Shaker(drive, port, omega, any, kFirst).mean_power_W(kPeriods), -5e-5 * size)
                << run;
        }
    }
    EXPECT_GE(active, 10);
    EXPECT_GE(passive, 10);
}

/// The largest K_P up to which `holds`.
template <typename Holds> double limit_of_K_P(SpringDrive drive, const Holds &holds) {
    double low = 0.0;
    double high = 500.0;
    for (int i = 0; i < 30; ++i) {
        double &K_P = drive.tuning.K_P_V_per_rad = 0.5 * (low + high);
        (holds(drive) ? low : high) = K_P;
    }
    return low;
}

TEST_F(PassivityTest, OfAShortPeriodIsThatOfTheContinuousCoupling) {
    for (const double dR_Ohm : {0.2, 0.5, 1.0}) {
        SpringDrive drive = drive_at_1_kHz(dR_Ohm, 1.0);
        drive.period_s = 2e-7;
        drive.tuning.lambda_rad_per_s = 1000.0;
        const double sampled = limit_of_K_P(
            drive, [](const SpringDrive &one) { return passivity(one, kPortDamping).holds(); });
        const double continuous = limit_of_K_P(drive, [](const SpringDrive &one) {
            for (double omega = 1.0; omega < 1e6; omega *= 1.02) {
                const PortNumber velocity = analytic_stiffness(one, omega) / PortNumber(0.0, omega);
                if (velocity.real() + kPortDamping < 0.0) {
                    return false;
                }
            }
            return true;
        });
        // p T, of what the aliases add: 22 000 to 49 000 rad/s.
        EXPECT_NEAR(sampled / continuous, 1.0, 0.01) << dR_Ohm;
        // Without friction K_P ≤ k_T dR/L − K_D λ, or (k_T + K_D) dR/L.
        const double k_T = drive.motor.torque_constant_Nm_per_A;
        EXPECT_GE(continuous, dR_Ohm / drive.motor.inductance_H * k_T - 1.0 - 1e-3) << dR_Ohm;
    }
}

/// Of 3000 rotors with any inertia and spring and no losses but the joint's, how many are unstable.
int unstable_lossless_hands(const SpringDrive &drive) {
    std::mt19937 random(7);
    const auto on_a_logarithm = [&random](double low, double high) {
        return std::exp(
            std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
    };
    int unstable = 0;
    for (int run = 0; run < 3000; ++run) {
        DrivenLoad load = DrivenLoad::of(1);
        load.inertia_kg_m2(0, 0) = on_a_logarithm(1e-9, 1e-4);
        load.damping_Nms_per_rad(0, 0) = kPortDamping;
        load.stiffness_Nm_per_rad(0, 0) = on_a_logarithm(1e-3, 1e4);
        load.put_behind_spring_drive(0, drive.motor, drive.dR_Ohm());
        const Sampling sampling{drive.period_s, drive.delay_periods};
        const LinearLoop loop(load, sampling);
        unstable += loop.is_stable(drift_compensation(load.torque_Nm_per_A, gains_of(drive.tuning),
                                                      Eigen::MatrixXd::Ones(1, 1), sampling))
                        ? 0
                        : 1;
    }
    return unstable;
}

TEST_F(PassivityTest, WithinTheLimitNoLinearHandIsUnstableAndBeyondSomeAre) {
    for (const double dR_Ohm : {0.2, 0.5}) {
        SpringDrive drive = drive_at_1_kHz(dR_Ohm, 1.0);
        const double limit = limit_of_K_P(drive, [](const SpringDrive &one) {
            return stability_with_linear_hands(one, kPortDamping).holds();
        });
        const double passive = limit_of_K_P(
            drive, [](const SpringDrive &one) { return passivity(one, kPortDamping).holds(); });
        EXPECT_LT(passive, 0.9 * limit);
        drive.tuning.K_P_V_per_rad = 0.999 * limit;
        EXPECT_EQ(unstable_lossless_hands(drive), 0) << dR_Ohm;
        drive.tuning.K_P_V_per_rad = 1.2 * limit;
        EXPECT_GT(unstable_lossless_hands(drive), 0) << dR_Ohm;
    }
}

TEST_F(PassivityTest, WithoutLossesNothingIsPassive) {
    SpringDrive drive = drive_at_1_kHz(0.2, 1.0);
    EXPECT_TRUE(passivity(drive, kPortDamping).holds());
    EXPECT_FALSE(passivity(drive, 0.0).holds());
    EXPECT_FALSE(stability_with_linear_hands(drive, 0.0).holds());
    drive.tuning.dR_Ohm = -0.1;
    EXPECT_FALSE(passivity(drive, kPortDamping).holds());
    // In free space the filter's corner decides.
    drive.tuning.dR_Ohm = 0.2;
    drive.tuning.lambda_rad_per_s = 2000.0;
    const LeastAtPort active = passivity(drive, kPortDamping);
    EXPECT_FALSE(active.holds());
    EXPECT_EQ(active.held, 0.0);
}

/// A drive, pose and structure of any kind, gains as large as are passive. Without hands.
StabilityCase random_passive_case(std::mt19937_64 &random, bool motors_differ) {
    testing::Draw draw(random);
    while (true) {
        StabilityCase which;
        which.device =
            draw.whole(0, 1) == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        for (device::MotorParameters &motor : which.device.motor) {
            motor.torque_constant_Nm_per_A *= motors_differ ? draw.even(0.8, 1.25) : 1.0;
            motor.inductance_H *= motors_differ ? draw.even(0.8, 1.25) : 1.0;
        }
        which.device.structure = {draw.by_ratio(500.0, 3e4),
                                  draw.whole(0, 1) == 0 ? 0.0 : draw.by_ratio(0.1, 5.0),
                                  {},
                                  draw.by_ratio(0.001, 0.1)};
        const int kind = draw.whole(0, 3);
        which.structures = {kind == 0 ? Structure{}
                                      : Structure{kind == 1   ? 0.0
                                                  : kind == 2 ? 1.0
                                                              : draw.even(0.05, 0.95)}};
        which.freedom = Freedom::three_motors;
        which.q_rad = testing::random_workspace_angles(which.device, random);
        which.period_s = draw.by_ratio(1e-4, 2e-3);
        which.delay_periods = draw.whole(0, 1) == 0 ? 0.0 : draw.even(0.0, 2.0);
        which.tuning.map =
            draw.whole(0, 1) == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
        which.tuning.dR_Ohm = draw.by_ratio(0.1, 1.0);
        which.tuning.lambda_rad_per_s = draw.by_ratio(50.0, 2000.0);
        const double damped_s = draw.by_ratio(1e-5, 3e-3);
        const auto with_gain = [&](double K_P_V_per_rad) {
            which.tuning.K_P_V_per_rad = K_P_V_per_rad;
            which.tuning.K_D_Vs_per_rad = damped_s * K_P_V_per_rad;
            return which;
        };
        double low = 1e-3;
        double high = 500.0;
        if (!passivity(with_gain(low)).holds()) {
            continue; // free space alone is active
        }
        for (int i = 0; i < 12; ++i) {
            const double middle = std::sqrt(low * high);
            (passivity(with_gain(middle)).holds() ? low : high) = middle;
        }
        return with_gain(low);
    }
}

/// Anything that a hand may be, mostly without losses.
Hand random_passive_hand(std::mt19937_64 &random) {
    testing::Draw draw(random);
    return {"random", draw.by_ratio(1e-3, 10.0),
            draw.whole(0, 2) == 0 ? draw.by_ratio(1e-3, 100.0) : 0.0, draw.by_ratio(0.1, 1e5)};
}

TEST(PassiveTunings, AreUnstableInNoHandStructureOrPose) {
    std::mt19937_64 random(61);
    const int tunings = testing::cases(60, 1000);
    constexpr int kHands = 10;
    int beyond = 0;
    for (int i = 0; i < tunings; ++i) {
        StabilityCase which = random_passive_case(random, i % 3 == 0);
        testing::Draw draw(random);
        for (int k = 0; k < kHands; ++k) {
            which.hands = {random_passive_hand(random)};
            which.q_rad = testing::random_workspace_angles(which.device, random);
            which.tuning.eta = k == 0 ? 1.0 : k < 7 ? 0.0 : draw.even(0.0, 1.0);
            const LoopMember member = members(which).front();
            // A lossless hand has modes with |z| just below 1, pairs of them by round-off's root.
            EXPECT_LE(largest_eigenvalue(which, member), 1.0 + 1e-8)
                << structure_text(member.structure) << ", m " << member.hand.mass_kg << ", k "
                << member.hand.stiffness_N_per_m << ", η " << which.tuning.eta << ", T "
                << which.period_s << ", d " << which.delay_periods << ", tuning " << i;
            StabilityCase larger = which;
            larger.tuning.K_P_V_per_rad *= 4.0;
            beyond += largest_eigenvalue(larger, member) > 1.0 + 1e-6 ? 1 : 0;
        }
    }
    EXPECT_GT(beyond, tunings); // a tenth of the loops
}

/// The worst motor decides, wherever it is; a motor given by itself is the case's second one.
TEST(PassiveTunings, AreThoseOfTheWorstMotor) {
    StabilityCase which = testing::firm();
    which.tuning.lambda_rad_per_s = 500.0;
    which.tuning.dR_Ohm = 0.2;
    which.tuning.K_D_Vs_per_rad = 0.001;
    which.tuning.K_P_V_per_rad = 7.0;
    ASSERT_TRUE(passivity(which).holds());
    ASSERT_TRUE(stability_with_linear_hands(which).holds());
    for (std::size_t j = 0; j < 3; ++j) {
        StabilityCase other = which;
        other.device.motor[j].inductance_H *= 4.0; // K_P ≤ k_T dR/L
        EXPECT_FALSE(passivity(other).holds()) << j;
        EXPECT_FALSE(stability_with_linear_hands(other).holds()) << j;
        const double b = which.device.friction.viscous_Nms_per_rad /
                         which.device.geometry.transmission_ratio.cwiseAbs2().maxCoeff();
        other.rotor = device::RotorLoad{1e-5, b, 0.0};
        EXPECT_EQ(passivity(other).holds(), j != 1) << j;
    }
}

/// Between joint and rotor, friction is in series with the cable's damper.
TEST(PassiveTunings, HaveTheJointsFrictionBehindACable) {
    StabilityCase which = testing::firm();
    which.tuning.lambda_rad_per_s = 500.0;
    which.tuning.dR_Ohm = 0.2;
    which.tuning.K_D_Vs_per_rad = 0.001;
    which.tuning.K_P_V_per_rad = 5.0;
    which.device.structure.cable_damping_ratio = 0.003;
    const double N_square = which.device.geometry.transmission_ratio.cwiseAbs2().maxCoeff();
    const double b = which.device.friction.viscous_Nms_per_rad / N_square;
    const double rigid = passivity(which).value;
    which.structures = all_structures();
    double least = HUGE_VAL;
    for (const device::CableCompliance &cable : device::cable_compliance(which.device, 1.0)) {
        const double c = cable.damping_Nms_per_rad;
        ASSERT_LT(c, 10.0 * b);
        least = std::min(least, b * c / (b + c));
    }
    const SpringDrive drive{which.device.motor[0], which.tuning, which.period_s, 0.0};
    EXPECT_LT(passivity(which).value, rigid);
    EXPECT_NEAR(passivity(which).value, passivity(drive, least).value, 1e-9);
    which.device.structure.cable_damping_ratio = 0.0;
    EXPECT_FALSE(passivity(which).holds());
    which.structures = {{0.0}};
    EXPECT_NEAR(passivity(which).value, rigid, 1e-12);
}

} // namespace
} // namespace springdrive::loops
