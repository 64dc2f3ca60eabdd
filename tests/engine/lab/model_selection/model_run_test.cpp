// Covers engine/lab/model_selection/{contact_shapes,model_run}.cpp.
#include "base/input_error.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/model_selection/contact_shapes.h"
#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/shape_fit.h"
#include "tests/engine/lab/model_selection/model_settings.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

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

using Kind = ContactShape::Kind;

bool has(const std::vector<ContactShape> &shapes, Kind kind) {
    return std::ranges::find(shapes, kind, &ContactShape::kind) != shapes.end();
}

TEST(ContactShapes, OfASphereRunFromThePrimitiveToWhatIsGiven) {
    const scene::Scene scene = testing::own_scene("sphere");
    const std::vector<ContactShape> shapes = contact_shapes_of(scene);
    EXPECT_EQ(shapes.front().kind, Kind::primitives);
    EXPECT_EQ(shapes.back(), ContactShape{});
    for (std::size_t i = 1; i + 2 < shapes.size(); ++i) {
        EXPECT_EQ(shapes[i].divisor, 2 * shapes[i + 1].divisor);
    }
    EXPECT_EQ(haptic_surface_of(scene, shapes.front()).shapes().size(), 1U);
    EXPECT_EQ(haptic_surface_of(scene, shapes.front()).report().triangles_given, 0U);
    EXPECT_LE(haptic_surface_of(scene, {Kind::simplified, 8}).report().triangles_given,
              20'480U / 8);
    EXPECT_EQ(haptic_surface_of(scene, {}).report().triangles_given, 20'480U);
}

TEST(ContactShapes, EveryNodeThatIsAPrimitiveBecomesOneWithItsMaterial) {
    const scene::Scene scene = testing::own_scene("compliance");
    const contact::HapticSurface surface = haptic_surface_of(scene, {Kind::primitives, 1});
    constexpr std::array kEta{0.0, 0.25, 0.5, 0.75, 0.9}; // as the scene's captions say
    ASSERT_EQ(surface.shapes().size(), kEta.size());
    for (std::uint16_t i = 0; i < kEta.size(); ++i) {
        EXPECT_EQ(surface.shapes()[i].material(), i);
        EXPECT_TRUE(std::holds_alternative<contact::Box>(surface.shapes()[i].size()));
        EXPECT_EQ(surface.materials()[i].eta, kEta[i]);
    }
}

TEST(ContactShapes, ShapesThatASceneLacksAreNeitherOfferedNorMade) {
    const scene::Scene scene = testing::own_scene("stepped_block");
    const std::vector<ContactShape> shapes = contact_shapes_of(scene);
    EXPECT_FALSE(has(shapes, Kind::primitives));
    EXPECT_FALSE(has(shapes, Kind::flat));
    EXPECT_THROW(static_cast<void>(haptic_surface_of(scene, {Kind::primitives, 1})), InputError);
    EXPECT_THROW(static_cast<void>(haptic_surface_of(scene, {Kind::flat, 1})), InputError);
}

TEST(ContactShapes, ASmoothSceneHasItsFlatTrianglesToo) {
    scene::GltfBuilder builder;
    const int positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    // Diverging normals, as on a dome.
    const int normals =
        builder.add_positions({-0.3F, -0.3F, 0.9F, 0.42F, -0.2F, 0.88F, -0.2F, 0.42F, 0.88F});
    builder.add_mesh(R"("attributes": {"POSITION": )" + std::to_string(positions) +
                     R"(, "NORMAL": )" + std::to_string(normals) + "}");
    builder.nodes = {R"({"mesh": 0, "extras": {"smooth": true}})"};
    const scene::Scene scene = scene::load(builder);
    ASSERT_EQ(scene.flat_surface.triangles.size(), 1U);
    EXPECT_GT(scene.surface.triangles.size(), 10U);
    EXPECT_TRUE(has(contact_shapes_of(scene), Kind::flat));
    EXPECT_EQ(haptic_surface_of(scene, {Kind::flat, 1}).report().triangles_given, 1U);
    // The corners of a curved patch are unchanged: both surfaces have the same placement.
    for (const Vector3 &corner_m : scene.flat_surface.vertices_m) {
        const auto &bent = scene.surface.vertices_m;
        EXPECT_TRUE(std::ranges::any_of(
            bent, [&](const Vector3 &v) { return (v - corner_m).norm() < 1e-12; }));
    }
    EXPECT_TRUE(testing::own_scene("plate").flat_surface.triangles.empty());
}

constexpr double kRadius_m = 0.05;

/// The largest distance of a triangle's middle from the sphere on which the vertices lie.
double max_sagitta_m(const contact::TriangleSoup &soup) {
    double max_m = 0.0;
    for (const auto &[a, b, c] : soup.triangles) {
        const Vector3 middle_m =
            (soup.vertices_m[a] + soup.vertices_m[b] + soup.vertices_m[c]) / 3.0;
        max_m = std::max(max_m, kRadius_m - middle_m.norm());
    }
    return max_m;
}

TEST(SimplifiedSurface, LeavesASphereClosedAndItsVerticesWhereTheyWere) {
    const contact::TriangleSoup sphere = rig::icosphere(4, kRadius_m); // 5120 triangles
    for (const int divisor : {2, 8, 32}) {
        const contact::TriangleSoup fewer = simplified(sphere, divisor);
        EXPECT_LE(fewer.triangles.size(), sphere.triangles.size() / static_cast<unsigned>(divisor));
        EXPECT_GE(fewer.triangles.size(),
                  sphere.triangles.size() / static_cast<unsigned>(2 * divisor));
        EXPECT_EQ(fewer.material_of_triangle.size(), fewer.triangles.size());
        const contact::MeshReport report = contact::HapticSurface(fewer).report();
        EXPECT_EQ(report.open_edges, 0U);
        EXPECT_EQ(report.closed_components, 1U);
        for (const auto &triangle : fewer.triangles) {
            for (const std::uint32_t corner : triangle) {
                // Icospheres are pushed out in double precision; nothing is moved here.
                ASSERT_NEAR(fewer.vertices_m[corner].norm(), kRadius_m, 1e-15);
            }
        }
    }
}

TEST(SimplifiedSurface, IsFartherFromTheShapeTheFewerItsTriangles) {
    const contact::TriangleSoup sphere = rig::icosphere(5, kRadius_m);
    double last_m = max_sagitta_m(sphere);
    for (const int divisor : {4, 16, 64, 256}) {
        const double sagitta_m = max_sagitta_m(simplified(sphere, divisor));
        EXPECT_GT(sagitta_m, 1.5 * last_m) << divisor; // about 4 for regular triangles
        last_m = sagitta_m;
    }
}

TEST(SimplifiedSurface, WithADivisorOfOneNothingIsLost) {
    const contact::TriangleSoup sphere = rig::icosphere(2, kRadius_m);
    EXPECT_EQ(simplified(sphere, 1).triangles.size(), sphere.triangles.size());
}

TEST(SimplifiedSurface, JoinsFacesThatHaveTheirOwnVertices) {
    const contact::TriangleSoup sphere = rig::icosphere(4, kRadius_m);
    contact::TriangleSoup apart;
    apart.materials = sphere.materials;
    apart.material_of_triangle = sphere.material_of_triangle;
    for (const auto &triangle : sphere.triangles) {
        const auto first = static_cast<std::uint32_t>(apart.vertices_m.size());
        for (const std::uint32_t corner : triangle) {
            apart.vertices_m.push_back(sphere.vertices_m[corner]);
        }
        apart.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_EQ(simplified(apart, 8).triangles.size(), simplified(sphere, 8).triangles.size());
    EXPECT_EQ(contact::HapticSurface(simplified(apart, 8)).report().open_edges, 0U);
}

TEST(SimplifiedSurface, KeepsEveryMaterialsTrianglesToItself) {
    contact::TriangleSoup two = rig::icosphere(3, kRadius_m);
    const contact::TriangleSoup other = rig::icosphere(4, 0.02);
    const auto first = static_cast<std::uint32_t>(two.vertices_m.size());
    for (const Vector3 &vertex_m : other.vertices_m) {
        two.vertices_m.emplace_back(vertex_m + Vector3(0.2, 0.0, 0.0));
    }
    for (const auto &[a, b, c] : other.triangles) {
        two.triangles.push_back({first + a, first + b, first + c});
        two.material_of_triangle.push_back(1);
    }
    two.materials.push_back({"other", 0.5});
    const contact::TriangleSoup fewer = simplified(two, 4);
    EXPECT_EQ(std::ranges::count(fewer.material_of_triangle, 0), 1280 / 4);
    EXPECT_EQ(std::ranges::count(fewer.material_of_triangle, 1), 5120 / 4);
    EXPECT_EQ(fewer.materials[1].eta, 0.5);
}

} // namespace
} // namespace springdrive::model_selection
