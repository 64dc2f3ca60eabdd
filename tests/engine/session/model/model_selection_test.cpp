// Covers engine/session/model/model_selection.cpp; reading names is covered by
// selection_cache_test.cpp.
#include "engine/session/model/model_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace springdrive::model_selection {
namespace {

using Kind = ContactShape::Kind;

TEST(Model, EveryNameReadsBack) {
    for (const ContactShape shape :
         {ContactShape{Kind::primitives, 1}, ContactShape{Kind::flat, 1},
          ContactShape{Kind::given, 1}, ContactShape{Kind::simplified, 2},
          ContactShape{Kind::simplified, 4096}}) {
        EXPECT_EQ(contact_shape_named(name_of(shape)), shape) << name_of(shape);
    }
    for (const MotionController &controller : kMotionControllers) {
        ASSERT_NE(motion_controller_named(controller.name), nullptr);
        EXPECT_EQ(motion_controller_named(controller.name)->map, controller.map);
    }
    for (const simulated::PlantModel &plant : simulated::kPlantModels) {
        ASSERT_NE(plant_model_named(plant.name), nullptr);
        EXPECT_EQ(plant_model_named(plant.name)->name, plant.name);
    }
}

TEST(Model, OtherNamesAreUnknown) {
    for (const char *name : {"", "simplified", "simplified_", "simplified_1", "simplified_0",
                             "simplified_-2", "simplified_2x", "simplified_99999999999", "Given"}) {
        EXPECT_FALSE(contact_shape_named(name)) << name;
    }
    EXPECT_EQ(motion_controller_named("transpose"), nullptr);
    EXPECT_EQ(plant_model_named("none"), nullptr);
}

TEST(Model, SetsItsOwnOptionsOfASimulationAndNothingElse) {
    Model model;
    model.plant = *plant_model_named("coupling");
    model.steps = 8;
    model.planar = true;
    simulated::SimulationOptions simulation;
    simulation.servo_period_s = 2e-3;
    simulation.delay_periods = 3;
    apply(model, simulation);
    EXPECT_EQ(simulation.dynamics, simulated::PlantDynamics::coupling);
    EXPECT_FALSE(simulation.effects.gravity);
    EXPECT_TRUE(simulation.planar);
    EXPECT_EQ(simulation.longest_step_s, 2e-3 / 8);
    EXPECT_EQ(simulation.delay_periods, 3);
    EXPECT_TRUE(simulation.quantised_encoders);
}

TEST(Model, AControllerChangesTheMapAndNotTheGains) {
    control::Tuning tuning;
    tuning.K_P_V_per_rad = 7.0;
    const control::Tuning with = with_controller(*motion_controller_named("inverse"), tuning);
    EXPECT_EQ(with.map, control::MotionMap::inverse);
    EXPECT_EQ(with.K_P_V_per_rad, 7.0);
}

TEST(ModelSelection, GivesAShortReason) {
    const scene::ModelTolerance tolerance{0.05, 2.0 * M_PI / 180.0, 100.0};
    const double degree = M_PI / 180.0;
    EXPECT_EQ(verdict({0.05, 0.0}, tolerance), "meets");
    EXPECT_EQ(verdict({0.21, 0.0}, tolerance), "force 0.21 N > 0.05 N");
    EXPECT_EQ(verdict({0.0, 8.0 * degree}, tolerance), "direction 8° > 2°");
    EXPECT_EQ(verdict({1.0, 8.0 * degree}, tolerance), "force 1 N > 0.05 N, direction 8° > 2°");
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(verdict({infinity, infinity}, tolerance), "runs away");
}

} // namespace
} // namespace springdrive::model_selection
