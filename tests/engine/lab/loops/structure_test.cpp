// Covers compliant structure in engine/lab/loops/stability_case.cpp and linear_loop.cpp, and
// cable_compliance of device/core/device_description.h.
#include "device/core/phantom/dynamics.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/lab/loops/tuning_constraints.h"
#include "tests/support/configurations.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace springdrive::loops {
namespace {

/// ∂x/∂θ by differences of the tip's position.
Matrix3 tip_per_motor(const device::DeviceDescription &device, const Vector3 &q_rad) {
    constexpr double kStep_rad = 1e-5;
    Matrix3 J;
    for (Eigen::Index j = 0; j < 3; ++j) {
        Vector3 turned = Vector3::Zero();
        turned[j] = kStep_rad / device.geometry.transmission_ratio[j];
        J.col(j) = (device::tip_position_m(device.geometry, q_rad + turned) -
                    device::tip_position_m(device.geometry, q_rad - turned)) /
                   (2.0 * kStep_rad);
    }
    return J;
}

/// Any structure, device, pose, hand and tuning.
StabilityCase random_structured_case(std::mt19937_64 &random) {
    testing::Draw draw(random);
    StabilityCase which;
    which.device = testing::phantom_1_0();
    for (device::MotorParameters &motor : which.device.motor) {
        motor = testing::random_motor(random);
    }
    const bool is_undamped = draw.whole(0, 2) == 0;
    which.device.structure = {draw.by_ratio(500.0, 3e4),
                              is_undamped ? 0.0 : draw.by_ratio(0.1, 5.0),
                              {},
                              is_undamped ? 0.0 : draw.by_ratio(0.005, 0.1)};
    which.device.inertia.tip_load_kg = draw.whole(0, 2) == 0 ? draw.by_ratio(0.005, 0.1) : 0.0;
    which.tuning = testing::random_tuning(which.device.motor[1], random);
    which.tuning.K_P_V_per_rad *= 6.0;
    which.tuning.map =
        draw.whole(0, 1) == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
    which.period_s = draw.by_ratio(2e-4, 2e-3);
    which.delay_periods = draw.whole(0, 1) == 0 ? draw.whole(0, 2) : draw.even(0.0, 2.5);
    which.q_rad = testing::random_workspace_angles(which.device, random);
    which.hands = {draw.whole(0, 2) == 0 ? no_hand() : hand_of_firmness(draw.even(0.0, 1.0))};
    const int kind = draw.whole(0, 3);
    which.structures = {{kind == 0 ? 0.0 : kind == 1 ? 1.0 : draw.even(0.05, 0.95)}};
    return which;
}

/// Of critical for the rotor alone.
double cable_damping(const device::DeviceDescription &device, std::size_t motor, double kappa) {
    return 2.0 * device.structure.cable_damping_ratio *
           std::sqrt(kappa * device.motor[motor].rotor_inertia_kg_m2);
}

TEST(CableStiffness, GivesTheTipItsShareOfTheComplianceAtTheDefaultPose) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Matrix3 J = tip_per_motor(device, device::default_pose_rad());
    for (const double share : {0.1, 0.5, 1.0}) {
        const std::array<device::CableCompliance, 3> cables =
            device::cable_compliance(device, share);
        for (Eigen::Index j = 0; j < 3; ++j) {
            // A unit force along the motion of the tip turns the motor's linkage against its cable.
            const double lever = J.col(j).norm();
            const double moved_m =
                lever * lever / cables[static_cast<std::size_t>(j)].stiffness_Nm_per_rad;
            EXPECT_NEAR(moved_m, share / device.structure.stiffness_N_per_m, 1e-9 * moved_m);
        }
    }
}

/// By energies, of bodies at speeds and springs at strains of their own.
TEST(DrivenLoad, WithStructureHasTheEnergyOfAllThatMovesAndGives) {
    std::mt19937_64 random(51);
    for (int i = 0; i < 60; ++i) {
        StabilityCase which = random_structured_case(random);
        which.freedom = Freedom::three_motors;
        const device::DeviceDescription &device = which.device;
        const LoopMember member = members(which).front();
        const DrivenLoad load = driven_load(which, member);
        const double s = *member.structure.cable_share;
        const double tip_kg = member.hand.mass_kg + device.inertia.tip_load_kg;
        const bool cable_gives = s > 0.0;
        const bool tip_gives = s < 1.0 && tip_kg > 0.0;
        ASSERT_EQ(load.coordinates(), 3 + (cable_gives ? 3 : 0) + (tip_gives ? 3 : 0));
        ASSERT_EQ(load.motors(), 3);

        const Matrix3 J = tip_per_motor(device, which.q_rad);
        const Vector3 rotor = testing::random_vector(random, 1.0);
        const Vector3 links = cable_gives ? testing::random_vector(random, 1.0) : rotor;
        const Vector3 tip = tip_gives ? testing::random_vector(random, 0.02) : J * links;
        Eigen::VectorXd x(load.coordinates());
        x.head<3>() = rotor;
        if (cable_gives) {
            x.segment<3>(3) = links;
        }
        if (tip_gives) {
            x.tail<3>() = tip;
        }
        const Vector3 q = device::joint_from_motor(device.geometry, links);
        const device::LinkageMoments moments =
            device::linkage_moments(device.geometry, device.inertia, 0.0);
        double inertia =
            q.dot(device::mass_matrix(moments, which.q_rad) * q) + tip_kg * tip.squaredNorm();
        for (Eigen::Index j = 0; j < 3; ++j) {
            inertia +=
                device.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2 * rotor[j] * rotor[j];
        }
        const Matrix3 default_J = tip_per_motor(device, device::default_pose_rad());
        double damping = device.friction.viscous_Nms_per_rad * q.squaredNorm() +
                         member.hand.damping_Ns_per_m * tip.squaredNorm();
        double stiffness = member.hand.stiffness_N_per_m * tip.squaredNorm();
        for (Eigen::Index j = 0; j < 3 && cable_gives; ++j) {
            const double twist = std::pow(links[j] - rotor[j], 2.0);
            const double kappa =
                device.structure.stiffness_N_per_m * default_J.col(j).squaredNorm() / s;
            stiffness += kappa * twist;
            damping += cable_damping(device, static_cast<std::size_t>(j), kappa) * twist;
        }
        if (tip_gives) {
            const double stretch = (tip - J * links).squaredNorm() / (1.0 - s);
            stiffness += device.structure.stiffness_N_per_m * stretch;
            damping += device.structure.damping_Ns_per_m * stretch;
        }
        const auto power = [&x](const Eigen::MatrixXd &matrix) { return x.dot(matrix * x); };
        // Differences over 1e-5 rad: second order, and round-off of 1e-16 over that.
        EXPECT_NEAR(power(load.inertia_kg_m2), inertia, 1e-8 * inertia);
        EXPECT_NEAR(power(load.damping_Nms_per_rad), damping, 1e-8 * damping);
        EXPECT_NEAR(power(load.stiffness_Nm_per_rad), stiffness, 1e-8 * stiffness);
        for (const Eigen::MatrixXd &matrix :
             {load.inertia_kg_m2, load.damping_Nms_per_rad, load.stiffness_Nm_per_rad}) {
            EXPECT_LE((matrix - matrix.transpose()).norm(), 1e-14 * matrix.norm());
        }
    }
}

/// Two inertias on a spring without a law: ω² = κ(1/J₁ + 1/J₂), and with a damper in parallel the
/// roots of s² + (c s + κ)(1/J₁ + 1/J₂). In common they coast.
TEST(StructuredLoop, OfAFreeRotorAndItsLinkageRingsAtTheCablesFrequency) {
    std::mt19937_64 random(52);
    for (int i = 0; i < 50; ++i) {
        StabilityCase which = random_structured_case(random);
        which.structures = {{1.0}};
        which.hands = {no_hand()};
        which.device.friction.viscous_Nms_per_rad = 0.0;
        which.device.inertia.tip_load_kg = 0.0;
        const int j = i % 3;
        const LoopMember member{j, no_hand(), {1.0}};
        DrivenLoad load = driven_load(which, member);
        load.torque_Nm_per_A.setZero(); // an open winding
        const double N = which.device.geometry.transmission_ratio[j];
        const device::LinkageMoments moments =
            device::linkage_moments(which.device.geometry, which.device.inertia, 0.0);
        const double links = device::mass_matrix(moments, which.q_rad)(j, j) / (N * N);
        const double rotor = which.device.motor[static_cast<std::size_t>(j)].rotor_inertia_kg_m2;
        const double per_inertia = 1.0 / rotor + 1.0 / links;
        const double lever =
            tip_per_motor(which.device, device::default_pose_rad()).col(j).squaredNorm();
        const double cable = which.device.structure.stiffness_N_per_m * lever;
        const double kappa = cable * per_inertia;
        const double c =
            cable_damping(which.device, static_cast<std::size_t>(j), cable) * per_inertia;
        const std::complex<double> root = std::sqrt(std::complex<double>(0.25 * c * c - kappa));
        const double T = 5e-5; // below half a period of all
        const Eigen::VectorXcd found =
            Eigen::MatrixXd(sampled_load(load, T).topLeftCorner(4, 4)).eigenvalues();
        for (const std::complex<double> &s : {-0.5 * c + root, -0.5 * c - root}) {
            EXPECT_LT((found.array() - std::exp(s * T)).abs().minCoeff(), 1e-7) << s;
        }
        EXPECT_EQ(((found.array() - 1.0).abs() < 1e-6).count(), 2);
    }
}

/// As the period goes to zero, a K_P alone makes rotor, winding, cable and linkage a continuous
/// system: (L s + dR)[(J₁ s² + c s + κ)(J₂ s² + (c + b) s + κ) − (c s + κ)²]
/// + k_T (k_T s + K_P)(J₂ s² + (c + b) s + κ) = 0.
TEST(StructuredLoop, OfAFastServoHasTheRootsOfTheContinuousSystem) {
    std::mt19937_64 random(53);
    for (int i = 0; i < 30; ++i) {
        StabilityCase which = random_structured_case(random);
        which.structures = {{1.0}};
        which.device.inertia.tip_load_kg = 0.0;
        which.delay_periods = 0.0;
        which.tuning.map = control::MotionMap::inverse;
        which.tuning.K_D_Vs_per_rad = 0.0;
        which.tuning.eta = 0.0;
        const LoopMember member{1, no_hand(), {1.0}};
        const device::MotorParameters &motor = which.device.motor[1];
        const double N = which.device.geometry.transmission_ratio[1];
        const device::LinkageMoments moments =
            device::linkage_moments(which.device.geometry, which.device.inertia, 0.0);
        const double links = device::mass_matrix(moments, which.q_rad)(1, 1) / (N * N);
        const double b = which.device.friction.viscous_Nms_per_rad / (N * N);
        const double lever =
            tip_per_motor(which.device, device::default_pose_rad()).col(1).squaredNorm();
        const double kappa = which.device.structure.stiffness_N_per_m * lever;
        const double c = cable_damping(which.device, 1, kappa);
        const double rotor = motor.rotor_inertia_kg_m2;
        const double k_T = motor.torque_constant_Nm_per_A;
        // [θ, θ_l, θ̇, θ̇_l, i]
        Eigen::Matrix<double, 5, 5> A;
        A << 0, 0, 1, 0, 0, //
            0, 0, 0, 1, 0,  //
            -kappa / rotor, kappa / rotor, -c / rotor, c / rotor, k_T / rotor, kappa / links,
            -kappa / links, c / links, -(c + b) / links, 0,
            -which.tuning.K_P_V_per_rad / motor.inductance_H, 0, -k_T / motor.inductance_H, 0,
            -which.dR_Ohm(motor) / motor.inductance_H;
        const double truth_per_s = A.eigenvalues().real().maxCoeff();
        const auto error_per_s = [&](double period_s) {
            which.period_s = period_s;
            return std::log(largest_eigenvalue(which, member)) / period_s - truth_per_s;
        };
        // A hold is late by half a period: first order.
        const double fast = error_per_s(1e-6);
        const double faster = error_per_s(5e-7);
        EXPECT_NEAR(faster, 0.5 * fast, 0.02 * std::abs(fast) + 1e-5) << i;
    }
}

/// Motors with cables, their linkage and a hand on a compliant tip, integrated by Runge-Kutta steps
/// between samples: all of it written from the equations, by forces on each body.
/// @tparam n  1: a motor by itself, the tip along its motion; 3: all of the linkage
template <int n> class StructuredMotorsInTime {
    using Vector = Eigen::Matrix<double, n, 1>;
    using Matrix = Eigen::Matrix<double, n, n>;

public:
    /// @param index  of the motor, if it is one
    explicit StructuredMotorsInTime(const StabilityCase &which, int index = 0)
        : which_(which), hand_(which.hands.front()), share_(*which.structures.front().cable_share) {
        const device::DeviceDescription &device = which.device;
        const device::StructuralCompliance &structure = device.structure;
        const device::LinkageMoments moments =
            device::linkage_moments(device.geometry, device.inertia, 0.0);
        const Matrix3 mass = device::mass_matrix(moments, which.q_rad);
        const Matrix3 default_J = tip_per_motor(device, device::default_pose_rad());
        const Matrix3 J = tip_per_motor(device, which.q_rad);
        const auto motor_of = [&](Eigen::Index i) { return n == 1 ? index : static_cast<int>(i); };
        double fastest = bandwidth_per_s_;
        for (Eigen::Index i = 0; i < n; ++i) {
            const int j = motor_of(i);
            const device::MotorParameters &motor = device.motor[static_cast<std::size_t>(j)];
            const double N = device.geometry.transmission_ratio[j];
            rotor_kg_m2_[i] = motor.rotor_inertia_kg_m2;
            k_T_[i] = motor.torque_constant_Nm_per_A;
            inductance_H_[i] = motor.inductance_H;
            dR_Ohm_[i] = which.dR_Ohm(motor);
            friction_[i] = device.friction.viscous_Nms_per_rad / (N * N);
            kappa_[i] = structure.stiffness_N_per_m * default_J.col(j).squaredNorm() / share_;
            c_[i] = cable_damping(device, static_cast<std::size_t>(j), kappa_[i]);
            for (Eigen::Index k = 0; k < n; ++k) {
                const int other = motor_of(k);
                links_kg_m2_(i, k) =
                    mass(j, other) / (N * device.geometry.transmission_ratio[other]);
            }
            fastest += std::abs(dR_Ohm_[i]) / inductance_H_[i] +
                       k_T_[i] / std::sqrt(inductance_H_[i] * rotor_kg_m2_[i]);
        }
        if constexpr (n == 1) {
            levers_m_(0, 0) = J.col(index).norm();
        } else {
            levers_m_ = J;
        }
        tip_kg_ = hand_.mass_kg + device.inertia.tip_load_kg;
        Matrix moved = links_kg_m2_; // with all that is tied to the linkage rigidly
        if (!has_tip()) {
            moved += tip_kg_ * levers_m_.transpose() * levers_m_;
        }
        if (!has_linkage()) {
            moved.diagonal() += rotor_kg_m2_;
        }
        per_inertia_ = moved.inverse();
        // The fastest rate, from above: each spring and damper on each of its two bodies.
        const auto on_bodies = [&](bool cable, bool tie, const Vector &in_cable, double at_tip,
                                   double of_hand) {
            const Vector cables = cable ? in_cable : Vector::Zero();
            const double tied = tie ? at_tip / (1.0 - share_) : 0.0;
            Matrix on_linkage = (tied + of_hand) * levers_m_.transpose() * levers_m_;
            on_linkage.diagonal() += cables;
            return cables.cwiseQuotient(rotor_kg_m2_).sum() + (per_inertia_ * on_linkage).trace() +
                   (tie ? n * (tied + of_hand) / tip_kg_ : 0.0);
        };
        fastest_per_s_ =
            fastest +
            std::sqrt(on_bodies(has_linkage(), has_tip(), kappa_, structure.stiffness_N_per_m,
                                hand_.stiffness_N_per_m)) +
            on_bodies(has_linkage(), has_tip(), c_, structure.damping_Ns_per_m,
                      hand_.damping_Ns_per_m);
    }

    [[nodiscard]] bool has_linkage() const { return share_ > 0.0; }
    [[nodiscard]] bool has_tip() const { return share_ < 1.0 && tip_kg_ > 0.0; }
    /// Rotor, linkage, tip, each with its speed, where they move by themselves; current, last angle
    /// and filtered rate, and commands on their way.
    [[nodiscard]] Eigen::Index states() const {
        return n * (2 * (1 + (has_linkage() ? 1 : 0) + (has_tip() ? 1 : 0)) + 3 + held());
    }

    /// The map over a period, column by column.
    [[nodiscard]] Eigen::MatrixXd map() const {
        Eigen::MatrixXd all(states(), states());
        for (Eigen::Index i = 0; i < states(); ++i) {
            all.col(i) = after_period(Eigen::VectorXd::Unit(states(), i));
        }
        return all;
    }

private:
    struct Motion {
        Vector rotor{Vector::Zero()}, links{Vector::Zero()}, tip{Vector::Zero()};
        Vector rotor_rate{Vector::Zero()}, links_rate{Vector::Zero()}, tip_rate{Vector::Zero()};
        Vector current{Vector::Zero()};
    };

    [[nodiscard]] Eigen::Index held() const {
        return static_cast<Eigen::Index>(std::ceil(which_.delay_periods));
    }

    /// Where a body is tied rigidly to the one before it.
    void follow(Motion &m) const {
        if (!has_linkage()) {
            m.links = m.rotor;
            m.links_rate = m.rotor_rate;
        }
        if (!has_tip()) {
            m.tip = levers_m_ * m.links;
            m.tip_rate = levers_m_ * m.links_rate;
        }
    }

    [[nodiscard]] Motion rates(const Motion &m, const Vector &u) const {
        const device::StructuralCompliance &of = which_.device.structure;
        const Vector hand_N =
            -hand_.stiffness_N_per_m * m.tip - hand_.damping_Ns_per_m * m.tip_rate;
        Vector on_links_Nm = -friction_.cwiseProduct(m.links_rate);
        Vector tip_N = hand_N;
        if (has_tip()) {
            const Vector tie_N = (of.stiffness_N_per_m * (levers_m_ * m.links - m.tip) +
                                  of.damping_Ns_per_m * (levers_m_ * m.links_rate - m.tip_rate)) /
                                 (1.0 - share_);
            tip_N += tie_N;
            on_links_Nm -= levers_m_.transpose() * tie_N;
        } else {
            on_links_Nm += levers_m_.transpose() * hand_N;
        }
        Vector on_rotor_Nm = k_T_.cwiseProduct(m.current);
        if (has_linkage()) {
            const Vector tie_Nm = kappa_.cwiseProduct(m.rotor - m.links) +
                                  c_.cwiseProduct(m.rotor_rate - m.links_rate);
            on_rotor_Nm -= tie_Nm;
            on_links_Nm += tie_Nm;
        } else {
            on_links_Nm += on_rotor_Nm;
        }
        Motion dm;
        dm.rotor = m.rotor_rate;
        dm.links = m.links_rate;
        dm.tip = m.tip_rate;
        dm.links_rate = per_inertia_ * on_links_Nm;
        dm.rotor_rate =
            has_linkage() ? Vector(on_rotor_Nm.cwiseQuotient(rotor_kg_m2_)) : dm.links_rate;
        dm.tip_rate = has_tip() ? Vector(tip_N / tip_kg_) : Vector(levers_m_ * dm.links_rate);
        dm.current =
            is_spring_
                ? Vector((u - dR_Ohm_.cwiseProduct(m.current) - k_T_.cwiseProduct(m.rotor_rate))
                             .cwiseQuotient(inductance_H_))
                : Vector(bandwidth_per_s_ * (u - m.current));
        return dm;
    }

    static Motion added(const Motion &m, double h, const Motion &dm) {
        return {m.rotor + h * dm.rotor,
                m.links + h * dm.links,
                m.tip + h * dm.tip,
                m.rotor_rate + h * dm.rotor_rate,
                m.links_rate + h * dm.links_rate,
                m.tip_rate + h * dm.tip_rate,
                m.current + h * dm.current};
    }

    void advance(Motion &m, const Vector &u, double time_s) const {
        constexpr double kStepsPerTime = 25.0;
        const int steps = static_cast<int>(std::ceil(kStepsPerTime * fastest_per_s_ * time_s));
        for (int i = 0; i < steps; ++i) {
            const double h = time_s / steps;
            const Motion k1 = rates(m, u);
            const Motion k2 = rates(added(m, 0.5 * h, k1), u);
            const Motion k3 = rates(added(m, 0.5 * h, k2), u);
            const Motion k4 = rates(added(m, h, k3), u);
            m = added(added(added(added(m, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
        }
    }

    /// The share of a motion that the law treats as an error: (18), or (23) with the largest α.
    [[nodiscard]] Vector error(const Vector &moved) const {
        Vector all = moved;
        if (which_.tuning.map == control::MotionMap::transpose) {
            const Matrix softness = (k_T_ / k_T_.mean()).cwiseInverse().asDiagonal() *
                                    (levers_m_.transpose() * levers_m_);
            all = softness * moved;
            all /= softness.eigenvalues().real().maxCoeff();
        }
        return (1.0 - which_.tuning.eta) * all;
    }

    [[nodiscard]] Vector command(const Vector &angle, const Vector &rate) const {
        const control::Tuning &tuning = which_.tuning;
        if (is_spring_) {
            return k_T_.cwiseProduct(rate - error(rate)) -
                   error(tuning.K_D_Vs_per_rad * rate + tuning.K_P_V_per_rad * angle);
        }
        const Vector force_N =
            -(1.0 - tuning.eta) * levers_m_ *
            (which_.wall.stiffness_N_per_m * angle + which_.wall.damping_Ns_per_m * rate);
        return Vector(levers_m_.transpose() * force_N).cwiseQuotient(k_T_);
    }

    [[nodiscard]] Eigen::VectorXd after_period(const Eigen::VectorXd &state) const {
        Motion m;
        Eigen::Index next = 0;
        const auto read_one = [&](Vector &into) {
            into = state.segment<n>(next);
            next += n;
        };
        const auto read = [&](bool is_there, Vector &place, Vector &rate) {
            if (is_there) {
                read_one(place);
                read_one(rate);
            }
        };
        read(true, m.rotor, m.rotor_rate);
        read(has_linkage(), m.links, m.links_rate);
        read(has_tip(), m.tip, m.tip_rate);
        follow(m);
        Vector last_rad;
        Vector last_rate;
        for (Vector *each : {&m.current, &last_rad, &last_rate}) {
            read_one(*each);
        }
        std::deque<Vector> commands; // the oldest first
        for (Eigen::Index i = 0; i < held(); ++i) {
            commands.emplace_back();
            read_one(commands.back());
        }
        const double a = std::exp(-which_.tuning.lambda_rad_per_s * which_.period_s);
        const Vector rate = a * last_rate + (1.0 - a) * (m.rotor - last_rad) / which_.period_s;
        const Vector now_rad = m.rotor;
        commands.push_back(command(now_rad, rate));
        const double until = which_.delay_periods - std::floor(which_.delay_periods);
        if (until > 0.0) {
            advance(m, commands[0], until * which_.period_s);
            advance(m, commands[1], (1.0 - until) * which_.period_s);
        } else {
            advance(m, commands[0], which_.period_s);
        }
        commands.pop_front();
        Eigen::VectorXd after(states());
        next = 0;
        const auto write_one = [&](const Vector &value) {
            after.segment<n>(next) = value;
            next += n;
        };
        const auto write = [&](bool is_there, const Vector &place, const Vector &speed) {
            if (is_there) {
                write_one(place);
                write_one(speed);
            }
        };
        write(true, m.rotor, m.rotor_rate);
        write(has_linkage(), m.links, m.links_rate);
        write(has_tip(), m.tip, m.tip_rate);
        for (const Vector &each : {m.current, now_rad, rate}) {
            write_one(each);
        }
        for (const Vector &each : commands) {
            write_one(each);
        }
        return after;
    }

    StabilityCase which_;
    Hand hand_;
    bool is_spring_ = which_.drive == device::AmplifierKind::spring_drive;
    double bandwidth_per_s_ = 2.0 * std::numbers::pi * which_.device.amplifier.current_bandwidth_hz;
    double share_;
    Vector rotor_kg_m2_, k_T_, inductance_H_, dR_Ohm_;
    Vector friction_; ///< of the linkage's joints, at the motors as all of it
    Vector kappa_, c_;
    Matrix links_kg_m2_, per_inertia_, levers_m_;
    double tip_kg_ = 0.0;
    double fastest_per_s_ = 0.0;
};

TEST(StructuredLoop, GrowsOrDecaysAsIntegratedInTime) {
    std::mt19937_64 random(54);
    int unstable = 0;
    int with_tip = 0;
    int with_cable = 0;
    for (int i = 0; i < 200; ++i) {
        StabilityCase which = random_structured_case(random);
        which.tuning.map = control::MotionMap::inverse;
        const bool is_free = i % 10 == 0;
        if (is_free) {
            which.tuning.eta = 1.0;
            which.hands.front().stiffness_N_per_m = 0.0;
        }
        if (i % 4 == 3) {
            which.drive = device::AmplifierKind::current_drive;
            which.wall = {testing::Draw(random).by_ratio(100.0, 1e4),
                          testing::Draw(random).by_ratio(0.3, 20.0)};
        }
        const int j = i % 3;
        const StructuredMotorsInTime<1> in_time(which, j);
        const LoopMember member{j, which.hands.front(), which.structures.front()};
        const double found = largest_eigenvalue(which, member);
        const Eigen::MatrixXd map = in_time.map();
        EXPECT_EQ(linear_loop(which, member).one_period_map(sampled_law(which, member)).rows(),
                  map.rows());
        const Eigen::VectorXcd eigenvalues = map.eigenvalues();
        Eigen::VectorXd sizes = eigenvalues.cwiseAbs();
        if (is_free) { // and may rest anywhere
            Eigen::Index nearest = 0;
            EXPECT_LT((eigenvalues.array() - 1.0).abs().minCoeff(&nearest), 1e-7);
            sizes[nearest] = 0.0;
        }
        const double truth = sizes.maxCoeff();
        // Steps of a 25th of the fastest time constant: (1/25)⁴/120 = 2e-8 in a time constant. What
        // is that fast decays; the rest is slower by far.
        EXPECT_NEAR(found, truth, 1e-7 * truth)
            << "K " << which.device.structure.stiffness_N_per_m << ", share "
            << *member.structure.cable_share << ", " << member.hand.name;
        unstable += truth > 1.0 ? 1 : 0;
        with_tip += in_time.has_tip() ? 1 : 0;
        with_cable += in_time.has_linkage() ? 1 : 0;
        // Run for a while, it has grown or decayed so.
        if (!is_free && std::abs(truth - 1.0) > 0.05) {
            Eigen::VectorXd state = Eigen::VectorXd::Unit(map.rows(), 0);
            for (int k = 0; k < 1000; ++k) {
                state = map * state;
                state /= k < 900 ? state.norm() : 1.0;
            }
            EXPECT_EQ(state.norm() > 1.0, found > 1.0);
        }
    }
    EXPECT_GT(unstable, 30);
    EXPECT_LT(unstable, 170);
    EXPECT_GT(with_tip, 50);
    EXPECT_GT(with_cable, 100);
}

/// All motors, coupled by the linkage's masses, by their maps and by the hand.
TEST(StructuredLoop, OfTheWholeLinkageIsAsIntegratedInTime) {
    std::mt19937_64 random(58);
    int unstable = 0;
    constexpr int kCases = 40;
    for (int i = 0; i < kCases; ++i) {
        StabilityCase which = random_structured_case(random);
        which.freedom = Freedom::three_motors;
        if (i % 4 == 3) {
            which.drive = device::AmplifierKind::current_drive;
            which.wall = {testing::Draw(random).by_ratio(100.0, 1e4),
                          testing::Draw(random).by_ratio(0.3, 20.0)};
        }
        const StructuredMotorsInTime<3> in_time(which);
        const LoopMember member = members(which).front();
        const double truth = in_time.map().eigenvalues().cwiseAbs().maxCoeff();
        // As above, with levers by differences that are off by 1e-10.
        EXPECT_NEAR(largest_eigenvalue(which, member), truth, 1e-7 * truth)
            << structure_text(member.structure) << ", " << member.hand.name;
        unstable += truth > 1.0 ? 1 : 0;
    }
    EXPECT_GT(unstable, kCases / 6);
    EXPECT_LT(unstable, kCases * 5 / 6);
}

/// Where the links are perpendicular, and their axes are those of the default pose's levers, three
/// motors with structure are three loops of one.
TEST(StructuredLoop, OfAPerpendicularLinkageIsThreeLoopsOfOneMotor) {
    std::mt19937_64 random(55);
    for (int i = 0; i < 30; ++i) {
        StabilityCase which = random_structured_case(random);
        const double fold = testing::Draw(random).even(-0.4, 0.6);
        which.q_rad = {testing::Draw(random).even(-0.5, 0.5), fold, fold};
        which.tuning.map = control::MotionMap::inverse;
        which.freedom = Freedom::one_motor;
        double truth = 0.0;
        for (const LoopMember &member : members(which)) {
            truth = std::max(truth, largest_eigenvalue(which, member));
        }
        which.freedom = Freedom::three_motors;
        // J by differences over 1e-5 rad is off by 1e-11; structures are up to 1e4 times as stiff
        // as the rest of the loop.
        EXPECT_NEAR(largest_eigenvalue(which, members(which).front()), truth, 1e-7) << i;
    }
}

/// With damping in proportion, so that the parts' modes do not become the slowest.
device::StructuralCompliance structure_of(double stiffness_N_per_m) {
    const double times = stiffness_N_per_m / 3500.0;
    return {stiffness_N_per_m, times, {}, 0.1 * std::sqrt(times)};
}

TEST(StructuredLoop, ApproachesRigidLinksAsTheStructureStiffens) {
    std::mt19937_64 random(56);
    for (const Freedom freedom : {Freedom::one_motor, Freedom::three_motors}) {
        for (int i = 0; i < 20; ++i) {
            StabilityCase which = random_structured_case(random);
            which.device.structure = structure_of(3500.0);
            which.freedom = freedom;
            const LoopMember rigid{i % 3, which.hands.front(), {}};
            const double truth = largest_eigenvalue(which, rigid);
            LoopMember member{i % 3, which.hands.front(), {0.5}};
            const auto difference = [&](double stiffness_N_per_m) {
                which.device.structure = structure_of(stiffness_N_per_m);
                return largest_eigenvalue(which, member) - truth;
            };
            const double stiff = std::abs(difference(2e5));
            EXPECT_LT(stiff, 0.02) << i;
            // Half for the first order in 1/K, a quarter for the second. Where two modes are near
            // each other, an eigenvalue is off by the root of round-off, which grows with K.
            constexpr double kNearDouble = 3e-7;
            EXPECT_LE(std::abs(difference(4e5)), 0.55 * stiff + kNearDouble) << i;

            // A share of the compliance goes to zero: what is left is all at the tip.
            which.device.structure = structure_of(3500.0);
            member.structure = {0.0};
            const double at_tip = largest_eigenvalue(which, member);
            const auto left = [&](double share) {
                member.structure = {share};
                return largest_eigenvalue(which, member) - at_tip;
            };
            // Of s, and of s√s by the cable's damping; where these cancel, of twice as much.
            const double more = std::max(std::abs(left(0.002)), std::abs(left(0.004)));
            EXPECT_LE(std::abs(left(0.001)), 0.6 * more + kNearDouble) << i;
            EXPECT_EQ(left(0.0009), 0.0) << "a part without a share";
        }
    }
}

/// Behind a hand that only weighs, the statics of the whole loop are the drive's stiffness and the
/// structure in series.
TEST(FeltStiffness, IsThatOfTheLoopAtRest) {
    std::mt19937_64 random(57);
    for (int i = 0; i < 60; ++i) {
        StabilityCase which = random_structured_case(random);
        which.freedom = Freedom::three_motors;
        which.tuning.map = control::MotionMap::inverse;
        which.hands = {{"mass", 0.1, 0.0, 0.0}};
        const LoopMember member = members(which).front();
        const DrivenLoad load = driven_load(which, member);
        const Eigen::MatrixXd give = static_stiffness(load, sampled_law(which, member)).inverse();
        const Matrix3 J = tip_per_motor(which.device, which.q_rad);
        const bool tip_gives = *member.structure.cable_share < 1.0;
        const Matrix3 at_end = give.bottomRightCorner(3, 3);
        const Matrix3 truth = tip_gives ? at_end : Matrix3(J * at_end * J.transpose());
        // K_DC of motors that differ
        Vector3 K_q;
        for (Eigen::Index j = 0; j < 3; ++j) {
            const device::MotorParameters &motor = which.device.motor[static_cast<std::size_t>(j)];
            K_q[j] = (1.0 - which.tuning.eta) * motor.torque_constant_Nm_per_A *
                     which.tuning.K_P_V_per_rad / which.dR_Ohm(motor);
        }
        const Matrix3 rendered = J.inverse().transpose() * K_q.asDiagonal() * J.inverse();
        const Matrix3 felt = felt_stiffness_N_per_m(
            rendered, structural_compliance_m_per_N(which.device, member.structure, which.q_rad));
        // Differences of 1e-5 rad, amplified by a J that is nearly singular.
        EXPECT_LT((felt * truth - Matrix3::Identity()).norm(), 1e-6) << i;
        EXPECT_LT((felt - felt.transpose()).norm(), 1e-8 * felt.norm());
        EXPECT_LT(felt.trace(), rendered.trace());
    }
}

TEST(FeltStiffness, IsASpringInSeriesWhereTheDriveHoldsOneDirectionOnly) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 n = Vector3(1.0, 2.0, -0.5).normalized();
    for (const double share : {0.0, 0.3, 1.0}) {
        const Matrix3 C =
            structural_compliance_m_per_N(device, {share}, device::default_pose_rad());
        for (const double k : {0.0, 500.0, 2e4}) {
            const Matrix3 felt = felt_stiffness_N_per_m(k * n * n.transpose(), C);
            const double truth = k / (1.0 + k * n.dot(C * n));
            EXPECT_LT((felt - truth * n * n.transpose()).norm(), 1e-12 * (1.0 + k));
        }
        EXPECT_GT(n.dot(C * n), 0.5 / device.structure.stiffness_N_per_m);
    }
    // All at the tip: 3.5 N/mm in series, in every direction.
    const Matrix3 C = structural_compliance_m_per_N(device, {0.0}, Vector3::Zero());
    const Matrix3 felt = felt_stiffness_N_per_m(3500.0 * Matrix3::Identity(), C);
    EXPECT_LT((felt - 1750.0 * Matrix3::Identity()).norm(), 1e-9);
    EXPECT_EQ(structural_compliance_m_per_N(device, {}, Vector3::Zero()), Matrix3::Zero());
}

/// The factors by which gains found on rigid links may rise, found with small models of their own:
/// 0.7, 0.43 and 0.31, between an undamped cable and one with the file's damping.
TEST(StructuredCase, GainsOfRigidLinksAreTooHighForACable) {
    struct Tuned {
        double servo_hz, dR_Ohm, K_P_V_per_rad, K_D_Vs_per_rad, factor;
    };
    for (const Tuned &tuned :
         {Tuned{1000.0, 0.2, 13.4, 0.0136, 0.7}, Tuned{1000.0, 0.5, 40.5, 0.0529, 0.43},
          Tuned{4000.0, 0.5, 135.0, 0.149, 0.31}}) {
        for (const double damping : {0.0, 1.0}) {
            StabilityCase which = testing::firm();
            which.device.structure.damping_Ns_per_m = damping;
            which.device.structure.cable_damping_ratio *= damping;
            which.period_s = 1.0 / tuned.servo_hz;
            which.tuning.dR_Ohm = tuned.dR_Ohm;
            which.tuning.lambda_rad_per_s = 5000.0;
            const auto is_stable_at = [&](const Structure &structure, double gain) {
                which.structures = {structure};
                which.tuning.K_P_V_per_rad = gain * tuned.K_P_V_per_rad;
                which.tuning.K_D_Vs_per_rad = gain * tuned.K_D_Vs_per_rad;
                return is_stable(which);
            };
            EXPECT_TRUE(is_stable_at({}, 1.29));
            EXPECT_FALSE(is_stable_at({}, 1.32));
            EXPECT_TRUE(is_stable_at({1.0}, 0.9 * tuned.factor)) << tuned.K_P_V_per_rad;
            EXPECT_FALSE(is_stable_at({1.0}, 1.1 * tuned.factor)) << tuned.K_P_V_per_rad;
            EXPECT_TRUE(is_stable_at({0.0}, 1.1)) << "a tip that gives hardly matters";
        }
    }
}

TEST(StructuredCase, IsAsUnstableAsItsWorstStructure) {
    StabilityCase which = testing::firm();
    which.tuning.K_P_V_per_rad = 13.4;
    which.tuning.K_D_Vs_per_rad = 0.0136;
    which.tuning.lambda_rad_per_s = 5000.0;
    which.tuning.dR_Ohm = 0.2;
    EXPECT_TRUE(which.is_rigid());
    EXPECT_TRUE(is_stable(which));
    const std::size_t rigid_members = members(which).size();
    which.structures = all_structures();
    EXPECT_FALSE(which.is_rigid());
    EXPECT_EQ(members(which).size(), 4 * rigid_members);
    const WorstMember worst = worst_member(which);
    EXPECT_FALSE(worst.is_stable());
    double truth = 0.0;
    for (const Structure &structure : all_structures()) {
        which.structures = {structure};
        const WorstMember one = worst_member(which);
        if (one.eigenvalue > truth) {
            truth = one.eigenvalue;
            EXPECT_EQ(structure_text(one.member.structure), structure_text(structure));
        }
    }
    EXPECT_EQ(worst.eigenvalue, truth);
    EXPECT_EQ(structure_text(worst.member.structure), "compliant cable");
    const std::vector<std::string> texts{"rigid links", "compliant tip", "compliant cable",
                                         "0.5 of the compliance in the cable"};
    for (std::size_t i = 0; i < texts.size(); ++i) {
        EXPECT_EQ(structure_text(all_structures()[i]), texts[i]);
    }
    // A load of its own has no structure.
    which.structures = all_structures();
    which.rotor = device::RotorLoad{1e-5, 1e-5, 0.0};
    EXPECT_TRUE(which.is_rigid());
    EXPECT_EQ(members(which).size(), which.hands.size());
    EXPECT_EQ(driven_load(which, {1, no_hand(), {1.0}}).coordinates(), 1);
    // At a tip without mass nothing moves by itself: the hand is then on the linkage.
    which.rotor.reset();
    const Hand spring{"spring", 0.0, 1.0, 300.0};
    EXPECT_EQ(largest_eigenvalue(which, {1, spring, {0.0}}),
              largest_eigenvalue(which, {1, spring}));
    EXPECT_EQ(driven_load(which, {1, spring, {0.5}}).coordinates(), 2);
    EXPECT_EQ(driven_load(which, {1, hand_of_firmness(0.5), {0.5}}).coordinates(), 3);
}

TEST(StructuredCase, TuningConstraintsHaveEachStructure) {
    StabilityCase which = testing::firm();
    which.hands = {no_hand(), hand_of_firmness(1.0)};
    const std::size_t rigid = TuningConstraints(which).count();
    which.structures = all_structures();
    const TuningConstraints loops(which);
    EXPECT_EQ(loops.count(), 4 * rigid);
    std::set<std::string> structures;
    for (std::size_t i = 0; i < loops.count(); ++i) {
        structures.insert(structure_text(loops[i].structure));
    }
    EXPECT_EQ(structures.size(), 4U);
    which.tuning.K_P_V_per_rad = 13.4;
    which.tuning.K_D_Vs_per_rad = 0.0136;
    which.tuning.lambda_rad_per_s = 5000.0;
    which.tuning.dR_Ohm = 0.2;
    TuningConstraints at_02(which);
    const std::size_t failed = at_02.first_unstable(gains_of(which.tuning));
    ASSERT_LT(failed, at_02.count());
    EXPECT_GT(at_02[failed].structure.in_cable(), 0.0);
}

} // namespace
} // namespace springdrive::loops
