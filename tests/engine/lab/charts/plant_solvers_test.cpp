// Covers engine/lab/charts/plant_solvers.cpp where joints stick and slip.
#include "engine/lab/charts/plant_solvers.h"

#include "tests/support/configurations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>

namespace springdrive::charts {
namespace {

constexpr std::array<bool, 3> kNoneReleased{};

/// Masses of any ratio and any coupling that a positive definite matrix may have.
rig::PlantMechanics random_mechanics(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> some(0.1, 2.0);
    std::uniform_real_distribution<double> share(-0.95, 0.95);
    rig::PlantMechanics made;
    made.inertia.axial_kg_m2 = some(random);
    made.inertia.two_kg_m2 = some(random);
    made.inertia.three_kg_m2 = some(random);
    made.inertia.coupling_kg_m2 =
        share(random) * std::sqrt(made.inertia.two_kg_m2 * made.inertia.three_kg_m2);
    made.torque_Nm = testing::random_vector(random, 2.0);
    return made;
}

/// The function that Gauss's principle of least constraint minimises: ½ aᵀ M a − τᵀ a + Σ τ_c |a|
/// for joints at rest.
double constraint(const rig::PlantMechanics &mechanics, const Vector3 &coulomb_Nm,
                  const Vector3 &acceleration) {
    const Matrix3 M = mechanics.inertia.matrix_kg_m2();
    return 0.5 * acceleration.dot(M * acceleration) - mechanics.torque_Nm.dot(acceleration) +
           coulomb_Nm.dot(acceleration.cwiseAbs());
}

TEST(StickSlipModes, FollowTheLeastConstraintFromRest) {
    const Vector3 coulomb_Nm(0.5, 0.7, 0.9);
    std::mt19937_64 random(611);
    int sticking = 0;
    int sliding = 0;
    for (int i = 0; i < 1000; ++i) {
        const rig::PlantMechanics mechanics = random_mechanics(random);
        const StickSlipModes modes =
            stick_slip_modes(mechanics, coulomb_Nm, Vector3::Zero(), kNoneReleased);
        const Vector3 a = stick_slip_motion(mechanics, coulomb_Nm, modes).acceleration_rad_per_s2;
        const double minimum = constraint(mechanics, coulomb_Nm, a);
        for (int trial = 0; trial < 20; ++trial) {
            const Vector3 other = a + testing::random_vector(random, trial < 10 ? 1e-3 : 1.0);
            ASSERT_GE(constraint(mechanics, coulomb_Nm, other),
                      minimum - 1e-14); // round-off of 1 J
        }
        for (std::size_t j = 0; j < 3; ++j) {
            ASSERT_EQ(modes[j] == 0, a[static_cast<Eigen::Index>(j)] == 0.0);
            (modes[j] == 0 ? sticking : sliding) += 1;
        }
    }
    EXPECT_GT(sticking, 100);
    EXPECT_GT(sliding, 100);
}

TEST(StickSlipModes, OfJointsThatMoveAreTheirDirections) {
    std::mt19937_64 random(612);
    const rig::PlantMechanics mechanics = random_mechanics(random);
    EXPECT_EQ(
        stick_slip_modes(mechanics, Vector3::Ones(), Vector3(1e-300, -2.0, 3.0), kNoneReleased),
        (StickSlipModes{1, -1, 1}));
}

/// A device without drive and with Coulomb friction only, pushed by a hand without mass.
struct Bare {
    device::DeviceDescription device = testing::phantom_1_0();
    simulated::SimulationOptions options;

    Bare() {
        for (device::MotorParameters &motor : device.motor) {
            motor.torque_constant_Nm_per_A = 1e-12;
        }
        options.hand = {0.0, 0.0, 0.0, 1e6, 1.0};
        options.effects = simulated::PlantEffects::none();
        options.effects.coulomb_friction = true;
    }
    [[nodiscard]] rig::PlantEquations equations(const Vector3 &target_m) const {
        rig::PlantEquations made(device, options);
        rig::PlantInputs inputs;
        inputs.target.position_m = target_m;
        made.set_inputs(inputs);
        return made;
    }
};

TEST(StickSlipSolver, ACoastingBaseStopsAtThePredictedPlaceAndStays) {
    // Slow enough for the links not to be thrown outwards: friction holds them.
    const Bare bare;
    const rig::PlantEquations equations = bare.equations(Vector3::Zero());
    const double rate = 0.05;
    rig::PlantState start = rig::PlantState::Zero();
    start[0] = 0.1;
    start[3] = rate;
    const double deceleration =
        bare.device.friction.coulomb_Nm[0] / equations.mechanics(0.0, start).inertia.axial_kg_m2;
    const double stops_s = rate / deceleration;
    StickSlipSolver solver(CvodeMethod::adams, 1e-12);
    for (const double share : {0.5, 0.99}) {
        const rig::PlantState y = solver.advance(equations, 0.0, share * stops_s, start);
        EXPECT_NEAR(y[3], (1.0 - share) * rate, 1e-11 * rate); // some hundred steps of 1e-12
    }
    const rig::PlantState stopped = solver.advance(equations, 0.0, 1.01 * stops_s, start);
    EXPECT_NEAR(stopped[0] - start[0], 0.5 * rate * stops_s, 1e-12); // of 0.1 rad
    EXPECT_EQ(stopped[3], 0.0);
    EXPECT_EQ(stopped.segment<2>(1), start.segment<2>(1));
    const rig::PlantState later = solver.advance(equations, 0.0, 1.0, stopped);
    EXPECT_EQ(later.head<6>(), stopped.head<6>());
}

TEST(StickSlipSolver, BreaksAwayAtTheTorqueOfFrictionAndNotBefore) {
    // A hand's spring pulls the tip sideways: k x l against τ_c at the base.
    Bare bare;
    bare.options.hand.stiffness_N_per_m = 1.0;
    const double reach_m = bare.device.geometry.upper_arm_m; // of the tip from the base's axis
    const double breaks_m = bare.device.friction.coulomb_Nm[0] / reach_m;
    StickSlipSolver solver(CvodeMethod::adams, 1e-12);
    const auto moved_rad = [&](double target_m) {
        return solver.advance(bare.equations(Vector3(target_m, 0.0, 0.0)), 0.0, 0.1,
                              rig::PlantState::Zero())[0];
    };
    for (const double side : {1.0, -1.0}) {
        EXPECT_EQ(moved_rad(0.999 * side * breaks_m), 0.0);
        EXPECT_GT(side * moved_rad(1.001 * side * breaks_m), 1e-6);
    }
}

} // namespace
} // namespace springdrive::charts
