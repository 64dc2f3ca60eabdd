// Covers engine/lab/model_selection/model_run.cpp.
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/model_run.h"
#include "engine/scene/shape_fit.h"
#include "tests/engine/lab/model_selection/model_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace springdrive::model_selection {
namespace {

constexpr double kBandwidth_hz = 100.0;
constexpr double kPeriod_s = 1e-3;

/// A run with given forces.
ModelRun run_of(std::size_t ticks, const std::function<Vector3(double time_s)> &force_N) {
    ModelRun run;
    for (std::size_t i = 0; i < ticks; ++i) {
        run.force_N.push_back(force_N(static_cast<double>(i) * kPeriod_s));
        contact::Contact contact;
        contact.touching = true;
        run.contacts.push_back(contact);
    }
    return run;
}

TEST(ModelError, OfARunAgainstItselfIsZero) {
    const contact::HapticSurface surface(testing::ball(3));
    const ModelSetting setting = testing::exploring(surface, testing::box_of(testing::ball(3)));
    for (const simulated::PlantModel &plant : simulated::kPlantModels) {
        Model model;
        model.plant = plant;
        const ModelRun once = run_model(setting, model, surface);
        const ModelRun again = run_model(setting, model, surface);
        ASSERT_TRUE(once.touches());
        const ModelError error = model_error(again, once, kPeriod_s, kBandwidth_hz);
        EXPECT_EQ(error.force_N, 0.0) << plant.name;
        EXPECT_EQ(error.direction_rad, 0.0) << plant.name;
    }
}

TEST(ModelError, OfASineIsThatAfterTheLowPass) {
    for (const double frequency_hz : {1.0, 20.0, 100.0, 400.0}) {
        const double omega = 2.0 * std::numbers::pi * frequency_hz;
        const auto still = run_of(20'000, [](double) { return Vector3(0.0, 1.0, 0.0); });
        const auto moved =
            run_of(20'000, [&](double t) { return Vector3(0.3 * std::sin(omega * t), 1.0, 0.0); });
        // Of y[k] = a y[k−1] + (1 − a) u[k].
        const double a = std::exp(-2.0 * std::numbers::pi * kBandwidth_hz * kPeriod_s);
        const std::complex<double> z = std::polar(1.0, omega * kPeriod_s);
        const double gain = std::abs((1.0 - a) / (1.0 - a / z));
        const double expected_N = 0.3 * gain / std::sqrt(2.0);
        const ModelError error = model_error(moved, still, kPeriod_s, kBandwidth_hz);
        // 20 s hold whole periods; the remaining error is the start from zero, 2 ms of 20 s.
        EXPECT_NEAR(error.force_N, expected_N, 1e-3 * expected_N + 1e-5) << frequency_hz;
    }
}

TEST(ModelError, OfATurnedForceIsItsAngle) {
    const auto up = run_of(1000, [](double) { return Vector3(0.0, 1.0, 0.0); });
    for (const double angle_rad : {1e-6, 0.1, 2.0}) {
        auto turned = run_of(
            1000, [&](double) { return Vector3(std::sin(angle_rad), std::cos(angle_rad), 0.0); });
        EXPECT_NEAR(model_error(turned, up, kPeriod_s, kBandwidth_hz).direction_rad, angle_rad,
                    1e-12);
        for (contact::Contact &contact : turned.contacts) {
            contact.touching = false;
        }
        EXPECT_EQ(model_error(turned, up, kPeriod_s, kBandwidth_hz).direction_rad, 0.0);
    }
}

TEST(ModelError, OfWeakForcesHasNoDirection) {
    const auto faint = run_of(100, [](double) { return Vector3(0.0, 0.19, 0.0); });
    const auto aside = run_of(100, [](double) { return Vector3(0.19, 0.0, 0.0); });
    EXPECT_EQ(model_error(faint, aside, kPeriod_s, kBandwidth_hz).direction_rad, 0.0);
}

TEST(ModelError, OfARunawayIsInfinite) {
    const auto good = run_of(10, [](double) { return Vector3(0.0, 1.0, 0.0); });
    auto bad = good;
    bad.force_N[5].z() = std::nan("");
    EXPECT_EQ(model_error(bad, good, kPeriod_s, kBandwidth_hz).force_N,
              std::numeric_limits<double>::infinity());
}

TEST(ModelRun, ErrorOfASimplifiedMeshGrowsWithFewerTriangles) {
    const contact::TriangleSoup fine = testing::ball(5); // 20,480 triangles
    const contact::HapticSurface surface(fine);
    const ModelSetting setting = testing::exploring(surface, testing::box_of(fine));
    const ModelRun fullest = run_model(setting, {}, surface);
    double last_N = 0.0;
    for (const int divisor : {4, 16, 64, 256}) {
        const contact::HapticSurface fewer(simplified(fine, divisor));
        const double error_N =
            model_error(run_model(setting, {}, fewer), fullest, kPeriod_s, kBandwidth_hz).force_N;
        EXPECT_GT(error_N, last_N) << divisor;
        last_N = error_N;
    }
    EXPECT_GT(last_N, 0.1);
}

TEST(ModelRun, StartsAtRestInFreeSpace) {
    const contact::TriangleSoup mesh = testing::ball(2);
    const contact::HapticSurface surface(mesh);
    ModelSetting setting = testing::exploring(surface, testing::box_of(mesh));
    setting.scenario.simulation.path = simulated::HandPath({{0.0, setting.scenario.start_m}});
    setting.scenario.duration_s = 0.0;
    const ModelRun run = run_model(setting, {}, surface);
    ASSERT_FALSE(run.configurations.empty());
    EXPECT_EQ(run.configurations.front().theta_rate_rad_per_s, Vector3(Vector3::Zero()));
    EXPECT_FALSE(run.contacts.front().touching);
    EXPECT_EQ(run.contacts.front().x0_m, run.configurations.front().tip_m);
}

TEST(ModelRun, ErrorBetweenASphereAndItsMeshGrowsWithCoarseness) {
    // The sagitta of its facets is 1/4 as large with each division, and the force follows it, down
    // to where an encoder's count or a joint's sticking decides: 0.02 N.
    double last_N = 10.0;
    for (const int divisions : {2, 3, 4}) {
        const contact::TriangleSoup mesh = testing::ball(divisions);
        const contact::HapticSurface surface(mesh);
        const std::optional<scene::RecognisedShape> fit = scene::recognise_shape(mesh, 0);
        ASSERT_TRUE(fit) << divisions;
        contact::TriangleSoup none;
        none.materials = mesh.materials;
        const contact::HapticSurface sphere(none, {fit->shape});
        const ModelSetting setting = testing::exploring(surface, testing::box_of(mesh));
        const ModelRun fullest = run_model(setting, {}, surface);
        const double error_N =
            model_error(run_model(setting, {}, sphere), fullest, kPeriod_s, kBandwidth_hz).force_N;
        EXPECT_LT(error_N, 0.6 * last_N) << divisions;
        last_N = error_N;
    }
    EXPECT_LT(last_N, 0.06);
}

TEST(ModelRun, InThePlaneTwoJointsAreAsGoodAsThree) {
    const scene::Scene scene = testing::own_scene("profile");
    const contact::HapticSurface surface(scene.surface);
    rig::Exploration how;
    how.planar = true;
    const ModelSetting setting = testing::exploring(surface, testing::box_of(scene), how);
    Model three;
    Model two;
    two.planar = true;
    const ModelRun run = run_model(setting, three, surface);
    ASSERT_TRUE(run.touches());
    const ModelError error =
        model_error(run_model(setting, two, surface), run, kPeriod_s, kBandwidth_hz);
    EXPECT_LT(error.force_N, 1e-3); // at most a count of the base's encoder
}

TEST(ModelCost, IsReportedForEachCandidateInOrder) {
    const contact::HapticSurface surface(testing::ball(3));
    const ModelSetting setting = testing::exploring(surface, testing::box_of(testing::ball(3)));
    Model once;
    Model often;
    often.steps = 4;
    const ModelRun run = run_model(setting, once, surface);
    const std::vector<std::vector<Cost>> all = {
        plant_costs(setting, {once, often}, run), contact_costs({&surface, &surface}, run),
        control_costs(setting, {kMotionControllers.begin(), kMotionControllers.end()}, run)};
    EXPECT_EQ(all[0].size(), 2U);
    EXPECT_EQ(all[2].size(), kMotionControllers.size());
    for (const std::vector<Cost> &costs : all) {
        for (const Cost &cost : costs) {
            EXPECT_GT(cost.min_ns, 0.0);
            EXPECT_LE(cost.min_ns, cost.median_ns); // each piece's minimum, compared with a whole
                                                    // repeat
            EXPECT_LE(cost.median_ns, cost.max_ns);
        }
    }
}

} // namespace
} // namespace springdrive::model_selection
