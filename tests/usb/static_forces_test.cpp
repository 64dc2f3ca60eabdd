// The same press on a USB board and in process: static forces within one encoder count.
//
// Both devices have the same description, hand, start and d. Off in both: Coulomb's friction, with
// which the rest depends on the way there. All else is on; without a device seed their sensors are
// ideal, so that both have the same truth.
//
// Between two counts nothing pulls back but the hand, so a rest lies at the edge of a count, and
// the servo chatters between two. Compared are means over 0.3 s.
//
// Bound, from a difference of one count δ on every motor, on a plane with normal n: the tip differs
// by J_j δ_j, the proxy slides along, so the spring's stretch differs by −n nᵀ J_j δ_j. With G the
// map, α W⁻¹ Jᵀ (23) or J⁻¹ (18):
//
//   |Δe_W| ≤ K_P Σ_j |G n nᵀ J_j| δ           |ΔF| ≤ Σ_j |J⁻ᵀ k_T/dR K_P G n nᵀ J_j| δ
//
// J itself differs by δ/N times a lever, which adds less than 1 % of that.
#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"
#include "tests/usb/fault_storm.h"

#include <Eigen/LU>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

namespace springdrive::usb {
namespace {

constexpr double kRestPeriod_s = 1e-3;
constexpr double kRestDelay_periods = 0.3;
constexpr double kStarting_s = 1.3;
constexpr double kSettling_s = 1.2;
constexpr double kMean_s = 0.3;
constexpr double kRoundOff_V = 1e-9;

struct Press {
    const char *name = "";
    Vector3 start_m;  ///< in free space
    Vector3 target_m; ///< of the hand, behind the surface
    device::HandParameters hand;
};

const device::HandParameters kRelaxed{0.1, 6.0, 300.0, 5.0};
const device::HandParameters kFirm{0.3, 30.0, 1500.0, 20.0};

/// On the top and on a side of a box.
const std::array<Press, 6> kPresses{{
    {"near the zero pose", {0.0, 0.015, 0.0}, {0.0, -0.004, 0.0}, kRelaxed},
    {"left, firmly", {-0.04, 0.012, 0.01}, {-0.038, -0.002, 0.008}, kFirm},
    {"right and back", {0.05, 0.02, -0.05}, {0.048, -0.006, -0.045}, kRelaxed},
    {"in front, firmly", {0.02, 0.015, 0.03}, {0.02, -0.0035, 0.03}, kFirm},
    {"side, below the top", {0.075, -0.015, -0.01}, {0.055, -0.015, -0.01}, kRelaxed},
    {"side, firmly", {0.075, -0.02, 0.0}, {0.0585, -0.02, 0.0}, kFirm},
}};

/// Means of a settled press.
struct Rest {
    Vector3 counts{Vector3::Zero()};
    Vector3 theta_rad{Vector3::Zero()}; ///< true
    Vector3 e_W_V{Vector3::Zero()};
    Vector3 tip_force_N{Vector3::Zero()};
    Vector3 normal{Vector3::Zero()};
    std::array<std::int32_t, 3> last_counts{};
};

int ticks_in(double seconds) { return static_cast<int>(std::lround(seconds / kRestPeriod_s)); }

simulated::SimulationOptions simulation(const Press &press) {
    simulated::SimulationOptions options;
    options.effects.coulomb_friction = false;
    options.hand = press.hand;
    options.delay_periods = kRestDelay_periods;
    return options;
}

/// @param tick  one tick of a servo, which returns its sample
/// @param truth  the plant's
template <class Tick, class Truth>
Rest settled(simulated::SimulatedWorld &world, const Press &press, const Tick &tick,
             const Truth &truth) {
    const auto run = [&](double seconds) {
        for (int i = 0; i < ticks_in(seconds); ++i) {
            tick();
        }
    };
    run(kStarting_s);
    world.set_hand_target(press.target_m);
    run(kSettling_s);
    Rest rest;
    const int ticks = ticks_in(kMean_s);
    for (int i = 0; i < ticks; ++i) {
        const servo::ServoSample sample = tick();
        EXPECT_EQ(sample.safety.state, servo::SafetyState::running);
        EXPECT_TRUE(sample.contact.touching);
        EXPECT_FALSE(sample.active_limits.holds_force());
        rest.counts += Vector3(sample.counts[0], sample.counts[1], sample.counts[2]) / ticks;
        rest.theta_rad += truth().theta_rad / ticks;
        rest.e_W_V += sample.command.e_W_V / ticks;
        rest.tip_force_N += sample.tip_force_N / ticks;
        rest.normal = sample.contact.normal;
        rest.last_counts = sample.counts;
    }
    return rest;
}

Rest on_usb(const Press &press, const servo::ServoInputs &inputs) {
    emulator::EmulatedBoardOptions options;
    options.simulation = simulation(press);
    options.start_tip_m = press.start_m;
    options.delay_periods = kRestDelay_periods;
    testing::ServoOnBoard rig(testing::phantom_1_0(), options, kRestPeriod_s);
    rig.inputs = inputs;
    return settled(
        rig.board.phantom(), press, [&] { return rig.tick(); }, [&] { return rig.truth(); });
}

Rest in_process(const Press &press, const servo::ServoInputs &inputs) {
    simulated::SimulatedPhantom phantom(testing::phantom_1_0(), simulation(press), press.start_m);
    servo::ServoLoop loop(phantom, kRestPeriod_s);
    return settled(
        phantom, press, [&] { return loop.tick(inputs); }, [&] { return phantom.truth(); });
}

/// What one count on every motor changes.
struct OneCount {
    Vector3 e_W_V{Vector3::Zero()};
    double tip_force_N = 0.0;
};

OneCount one_count(const Rest &rest, const control::Tuning &tuning) {
    const device::DeviceDescription device = testing::phantom_1_0();
    const Vector3 q_rad = device::joint_from_motor(device.geometry, rest.theta_rad);
    const Matrix3 J = device::motor_jacobian(device.geometry, q_rad);
    const Vector3 W = control::relative_stiffness(device);
    const Matrix3 G =
        tuning.map == control::MotionMap::inverse
            ? Matrix3(J.inverse())
            : Matrix3(control::alpha_bound(J, W) * W.cwiseInverse().asDiagonal() * J.transpose());
    const Matrix3 per_count_V = tuning.K_P_V_per_rad * device.rad_per_count() * G * rest.normal *
                                rest.normal.transpose() * J;
    const Matrix3 per_count_N = J.transpose().inverse() *
                                control::torque_constants(device).asDiagonal() * per_count_V /
                                tuning.dR_Ohm;
    constexpr double kOfJ = 1.01;
    return {kOfJ * per_count_V.cwiseAbs().rowwise().sum(),
            kOfJ * per_count_N.colwise().norm().sum()};
}

class StaticForces : public ::testing::TestWithParam<control::MotionMap> {};

TEST_P(StaticForces, OnUsbAreThoseInProcessWithinACount) {
    const contact::HapticSurface box(
        testing::box_soup(Vector3(-0.06, -0.05, -0.1), Vector3(0.06, 0.0, 0.1)));
    servo::ServoInputs inputs;
    inputs.surface = &box;
    inputs.tuning.map = GetParam();
    double worst_counts = 0.0;
    double worst_N = 0.0;
    double worst_share = 0.0;
    for (const Press &press : kPresses) {
        SCOPED_TRACE(press.name);
        const Rest usb = on_usb(press, inputs);
        const Rest here = in_process(press, inputs);
        const OneCount bound = one_count(here, inputs.tuning);
        const Vector3 counts = (usb.counts - here.counts).cwiseAbs();
        const Vector3 e_W_V = (usb.e_W_V - here.e_W_V).cwiseAbs();
        const double force_N = (usb.tip_force_N - here.tip_force_N).norm();

        EXPECT_LE(counts.maxCoeff(), 1.0);
        for (std::size_t j = 0; j < kChannels; ++j) {
            EXPECT_LE(std::abs(usb.last_counts[j] - here.last_counts[j]), 1) << j;
        }
        EXPECT_TRUE((e_W_V.array() <= bound.e_W_V.array() + kRoundOff_V).all())
            << e_W_V.transpose() << " of " << bound.e_W_V.transpose();
        EXPECT_LE(force_N, bound.tip_force_N);
        EXPECT_GT(here.tip_force_N.norm(), 0.5);
        worst_counts = std::max(worst_counts, counts.maxCoeff());
        worst_N = std::max(worst_N, force_N);
        worst_share = std::max(worst_share, force_N / bound.tip_force_N);
    }
    RecordProperty("worst_counts", std::to_string(worst_counts));
    RecordProperty("worst_force_N", std::to_string(worst_N));
    RecordProperty("worst_share_of_a_count", std::to_string(worst_share));
}

INSTANTIATE_TEST_SUITE_P(Maps, StaticForces,
                         ::testing::Values(control::MotionMap::transpose,
                                           control::MotionMap::inverse),
                         [](const auto &which) {
                             return std::string(control::name_of(which.param));
                         });

} // namespace
} // namespace springdrive::usb
