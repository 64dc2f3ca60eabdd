// Covers engine/session/loaded_scene.cpp. Measures models of several scenes: some seconds each.
#include "engine/session/session.h"

#include "base/input_error.h"
#include "device/core/device_file.h"
#include "engine/lab/model_selection/selection_cache.h"
#include "engine/session/model/model_selection.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <thread>

namespace springdrive::session {
namespace {

constexpr const char *kVersion = "a version";

/// Every test has its own cache, independent of the others.
class SessionModel : public ::testing::Test {
protected:
    SessionModel() : cache_(testing::fresh_folder("session_model_cache")) {
        setenv("XDG_CACHE_HOME", cache_.c_str(), 1);
    }
    ~SessionModel() override { unsetenv("XDG_CACHE_HOME"); }

    [[nodiscard]] bool is_empty() const { return std::filesystem::is_empty(cache_); }

    [[nodiscard]] static SessionOptions headless(const std::string &scene) {
        SessionOptions options = testing::scripted();
        options.scene = testing::assets() / "scenes" / scene;
        options.program_version = kVersion;
        options.model.chooser = model_selection::cached_chooser();
        return options;
    }

private:
    std::filesystem::path cache_;
};

TEST_F(SessionModel, ByDefaultIsTheMostDetailedAndNothingIsMeasured) {
    const Session session(headless("sphere.gltf"));
    EXPECT_FALSE(session.models().choice());
    EXPECT_FALSE(session.scenes().now().choice);
    EXPECT_EQ(session.scenes().now().surface.report().triangles_given, 20'480U);
    EXPECT_TRUE(is_empty());
}

void expect_touches_with_its_own_model(Session &session) {
    ASSERT_TRUE(session.models().choice());
    EXPECT_TRUE(session.scenes().now().choice);
    const model_selection::Model model = model_selection::model_of(*session.models().choice());
    EXPECT_EQ(session.servo().inputs().tuning.map, model.controller.map);
    EXPECT_EQ(session.servo().inputs().tuning.alpha_mode, model.controller.alpha_mode);
    EXPECT_GT(testing::frames_in_contact(session), 50);
}

TEST_F(SessionModel, AutomaticModelsTouchAndDoNotTrip) {
    SessionOptions options = headless("profile.gltf");
    options.model.automatic = true;
    Session session(options);
    expect_touches_with_its_own_model(session);
    EXPECT_FALSE(is_empty());
}

TEST_F(SessionModel, IsMeasuredInTheBackgroundOnRequestAndThenRemembered) {
    SessionOptions options = headless("plate.gltf");
    Session session(options);
    session.start();
    session.measure_model();
    EXPECT_TRUE(session.models().measurement().is_running());
    while (session.models().measurement().is_running()) {
        session.advance(testing::kFrame_s);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(session.models().choice()) << session.models().measurement().error();
    EXPECT_FALSE(session.scenes().now().choice);
    options.model.automatic = true;
    Session later(options); // from the cache: the same to the last digit
    EXPECT_EQ(later.models().choice()->cost_ns, session.models().choice()->cost_ns);
    expect_touches_with_its_own_model(later);
}

TEST_F(SessionModel, EachPartCanBeSetIndividually) {
    SessionOptions options = headless("sphere.gltf");
    options.model.surface =
        model_selection::ContactShape{model_selection::ContactShape::Kind::simplified, 16};
    options.model.plant = *model_selection::plant_model_named("rigid_tip");
    options.model.longest_step_s = 1e-3;
    Session session(options);
    EXPECT_LE(session.scenes().now().surface.report().triangles_given, 20'480U / 16);
    EXPECT_EQ(session.scenes().now().scene.surface.triangles.size(),
              20'480U); // the visual mesh is not changed
    EXPECT_GT(testing::frames_in_contact(session), 50);
    EXPECT_FALSE(session.scenes().now().choice);
    EXPECT_TRUE(is_empty());

    SessionOptions impossible = headless("stepped_block.gltf");
    impossible.model.surface =
        model_selection::ContactShape{model_selection::ContactShape::Kind::primitives, 1};
    EXPECT_THROW(Session{impossible}, InputError);
}

/// Caches an unmeasured model for a scene of the project.
void remember(const SessionOptions &options, const std::string &scene, const char *plant,
              const char *joints, const char *controller) {
    const device::DeviceDescription device = device::read_device_file(options.device.file);
    scene::LoadProgress progress;
    const auto loaded = load_scene(options.scene.parent_path() / scene, device.workspace, progress);
    model_selection::ModelSelection choice;
    choice.tolerance = loaded->scene.tolerance;
    for (const auto &[axis, name] :
         {std::pair("plant", plant), std::pair("steps", "20"), std::pair("joints", joints),
          std::pair("surface", "given"), std::pair("controller", controller)}) {
        choice.axes.push_back({axis, {{name, {}, {}}}, 0, {}});
    }
    const std::string key =
        model_selection::model_selection_key({&loaded->scene, device, options.tuning, 1e-3, 0},
                                             testing::contents_of(options.device.file), kVersion);
    ASSERT_TRUE(
        model_selection::write_model_selection(model_selection::model_cache_folder(), key, choice));
}

/// A hand that follows the mouse, over a scene with a cached model.
SessionOptions by_hand(const SessionOptions &headless) {
    SessionOptions options = headless;
    options.plays_script = false;
    options.model.automatic = true;
    remember(options, "profile.gltf", "rigid_tip", "2", "transpose_global");
    remember(options, "plate.gltf", "electromechanical", "3", "transpose_on_the_fly");
    return options;
}

void show(Session &session, const std::string &scene) {
    session.request_scene(testing::assets() / "scenes" / scene);
    ASSERT_TRUE(testing::run_until_loaded(session));
    ASSERT_EQ(session.scenes().error(), "");
    ASSERT_EQ(session.scenes().now().scene.file.filename(), scene);
    testing::run(session, 0.1);
}

void move_hand_sideways(Session &session) {
    session.hand().move_to(session.hand().target_m() + Vector3(0.02, 0.0, 0.0));
    testing::run(session, 2.0);
}

/// Lateral distance of the tip from the hand's target.
double behind_m(const Session &session) {
    return std::abs(session.latest().tip_m.x() - session.hand().target_m().x());
}

/// Deflection of a hand of 300 N/m under the arm's weight of about 0.5 N.
constexpr double kNearTheHand_m = 2e-3;

TEST_F(SessionModel, ANonPlanarSceneReleasesTheBase) {
    Session session(by_hand(headless("profile.gltf")));
    session.start();
    testing::run(session, 2.5); // wait and ramp
    EXPECT_TRUE(session.simulation().planar);
    EXPECT_EQ(session.servo().inputs().tuning.alpha_mode, control::AlphaMode::global);
    const double plane_m = session.latest().tip_m.x();
    move_hand_sideways(session);
    EXPECT_EQ(session.latest().tip_m.x(), plane_m);

    show(session, "plate.gltf");
    EXPECT_FALSE(session.simulation().planar);
    EXPECT_TRUE(session.scenes().now().choice);
    EXPECT_EQ(session.models().choice()->chosen(model_selection::ModelAspect::plant),
              "electromechanical");
    EXPECT_EQ(session.servo().inputs().tuning.alpha_mode, control::AlphaMode::on_the_fly);
    move_hand_sideways(session);
    EXPECT_LT(behind_m(session), kNearTheHand_m);
    EXPECT_EQ(session.latest().safety.state, servo::SafetyState::running)
        << servo::description(session.latest().safety);

    show(session, "profile.gltf"); // a moving base is not locked
    EXPECT_TRUE(session.scenes().now().choice);
    EXPECT_FALSE(session.simulation().planar);
    move_hand_sideways(session);
    EXPECT_LT(behind_m(session), kNearTheHand_m);
}

TEST_F(SessionModel, AFoundModelCanBeRun) {
    SessionOptions options = by_hand(headless("plate.gltf"));
    remember(options, "plate.gltf", "rigid_tip", "3", "transpose_global");
    options.model.automatic = false;
    Session session(options);
    session.start();
    session.measure_model();
    ASSERT_TRUE(session.models().choice());
    EXPECT_FALSE(session.scenes().now().choice);
    EXPECT_NE(session.servo().inputs().tuning.alpha_mode, control::AlphaMode::global);

    session.choose_models();
    ASSERT_TRUE(testing::run_until_loaded(session));
    EXPECT_EQ(session.scenes().error(), "");
    EXPECT_TRUE(session.scenes().now().choice);
    EXPECT_EQ(session.servo().inputs().tuning.alpha_mode, control::AlphaMode::global);
    show(session, "profile.gltf"); // from now on every scene has its own model
    EXPECT_TRUE(session.scenes().now().choice);
}

TEST_F(SessionModel, IsThatForTheActiveGains) {
    const SessionOptions options = headless("plate.gltf");
    SessionOptions tuned = options;
    tuned.tuning.K_P_V_per_rad = 3.0;
    remember(tuned, "plate.gltf", "rigid_tip", "3", "transpose_global");
    Session session(options);
    session.start();
    session.tuning().change(tuned.tuning, session.plot_time_s());
    session.measure_model();
    ASSERT_TRUE(session.models().choice()); // cached for these gains
    EXPECT_EQ(session.models().choice()->chosen(model_selection::ModelAspect::plant), "rigid_tip");
}

TEST_F(SessionModel, ATunedControllerStays) {
    SessionOptions options = headless("plate.gltf");
    options.tuning.map = control::MotionMap::inverse;
    options.model.automatic = true;
    options.model.takes_controller = false;
    remember(options, "plate.gltf", "rigid_tip", "3", "transpose_global");
    const Session session(options);
    EXPECT_TRUE(session.scenes().now().choice);
    EXPECT_EQ(session.servo().inputs().tuning.map, control::MotionMap::inverse);
}

TEST_F(SessionModel, AControllerChosenByTheUserIsKeptForTheNextScene) {
    Session session(by_hand(headless("profile.gltf")));
    session.start();
    control::Tuning tuning = session.servo().inputs().tuning;
    tuning.map = control::MotionMap::inverse;
    session.tuning().change(tuning, session.plot_time_s());
    show(session, "plate.gltf");
    EXPECT_EQ(session.servo().inputs().tuning.map, control::MotionMap::inverse);
}

TEST_F(SessionModel, AnotherSceneIsMeasuredInTheBackgroundBeforeItIsShown) {
    Session session(by_hand(headless("profile.gltf")));
    session.start();
    session.request_scene(testing::assets() / "scenes/sphere.gltf");
    while (session.scenes().progress().find("measuring models") == std::string::npos) {
        session.advance(testing::kFrame_s);
        ASSERT_TRUE(session.scenes().is_loading());
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(session.scenes().now().scene.file.filename(), "profile.gltf");
    // A cancelled measurement is not waited for.
    show(session, "plate.gltf");
    EXPECT_EQ(session.scenes().id(), 2U);
    EXPECT_EQ(session.scenes().error(), "");
}

TEST_F(SessionModel, ASurfaceSetByOptionAppliesToEveryScene) {
    SessionOptions options = headless("sphere.gltf");
    options.model.surface =
        model_selection::ContactShape{model_selection::ContactShape::Kind::simplified, 16};
    Session session(options);
    session.start();
    show(session, "organic.gltf");
    const LoadedScene &shown = session.scenes().now();
    EXPECT_LE(shown.surface.report().triangles_given, shown.scene.surface.triangles.size() / 16);
}

TEST_F(SessionModel, AnotherSceneClearsTheErrorOfTheLast) {
    const Session session(headless("plate.gltf"));
    model_selection::ModelQuestion impossible;
    impossible.scene = &session.scenes().now().scene;
    impossible.device = session.description();
    impossible.delay_periods = simulated::SimulationOptions::kMaxDelay + 1;
    ModelMeasurement measurement;
    measurement.begin(model_selection::cached_chooser(), impossible, {});
    while (measurement.is_running()) {
        EXPECT_FALSE(measurement.take());
        std::this_thread::yield();
    }
    EXPECT_NE(measurement.error().find("delay"), std::string::npos) << measurement.error();
    measurement.discard();
    EXPECT_EQ(measurement.error(), "");
    EXPECT_TRUE(is_empty());
}

} // namespace
} // namespace springdrive::session

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
