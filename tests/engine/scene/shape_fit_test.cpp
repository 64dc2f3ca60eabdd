// Covers engine/scene/shape_fit.cpp and scene.cpp.
#include "assets/scenes/shapes.h"
#include "base/input_error.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scene.h"
#include "engine/scene/shape_fit.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::scene {
namespace {

constexpr double kShapeRounding_m = 1e-14; // a few double operations on metres

BoundingBox box_of(const Vector3 &lower, const Vector3 &upper) {
    BoundingBox box;
    box.include(lower);
    box.include(upper);
    return box;
}

BoundingBox box_of(const Vector3 &half_size) { return box_of(-half_size, half_size); }

contact::AnalyticShape fitted(ShapeKind kind, const Vector3 &half_size,
                              const Eigen::Affine3d &to_device = Eigen::Affine3d::Identity()) {
    return fit_shape(kind, box_of(half_size), to_device, 3, "node 'ball'");
}

void expect_refused(ShapeKind kind, const Vector3 &half_size, const std::string &why,
                    const Eigen::Affine3d &to_device = Eigen::Affine3d::Identity()) {
    const std::string message = error_text_of([&] { (void)fitted(kind, half_size, to_device); });
    EXPECT_EQ(message.find("node 'ball': cannot be touched as a " + name_of(kind) + ": "), 0U)
        << half_size.transpose() << ": " << message;
    EXPECT_NE(message.find(why), std::string::npos) << message;
}

/// A similarity that may mirror.
Eigen::Affine3d random_similarity(std::mt19937_64 &dice, bool mirrored) {
    std::normal_distribution<double> normal;
    Eigen::Affine3d transform = Eigen::Affine3d::Identity();
    transform.translate(Vector3(normal(dice), normal(dice), normal(dice)));
    transform.rotate(
        Eigen::Quaterniond(normal(dice), normal(dice), normal(dice), normal(dice)).normalized());
    transform.scale(std::exp(normal(dice)));
    return mirrored ? transform * Eigen::Scaling(1.0, -1.0, 1.0) : transform;
}

TEST(ShapeFit, SizesAreThoseOfTheBox) {
    EXPECT_EQ(std::get<contact::Sphere>(fitted(ShapeKind::sphere, {0.5, 0.5, 0.5}).size()).radius_m,
              0.5);
    const auto box = std::get<contact::Box>(fitted(ShapeKind::box, {0.25, 0.5, 1.0}).size());
    EXPECT_EQ(box.half_size_m, Vector3(0.25, 0.5, 1.0));
    const auto cylinder =
        std::get<contact::Cylinder>(fitted(ShapeKind::cylinder, {0.5, 2.0, 0.5}).size());
    EXPECT_EQ(cylinder.radius_m, 0.5);
    EXPECT_EQ(cylinder.half_height_m, 2.0);
    const auto capsule =
        std::get<contact::Capsule>(fitted(ShapeKind::capsule, {0.5, 2.0, 0.5}).size());
    EXPECT_EQ(capsule.radius_m, 0.5);
    EXPECT_EQ(capsule.half_axis_m, 1.5);
    EXPECT_EQ(fitted(ShapeKind::box, {0.25, 0.5, 1.0}).material(), 3);
}

TEST(ShapeFit, TheLargestExtentCountsWhereTessellationCutsSome) {
    EXPECT_EQ(
        std::get<contact::Sphere>(fitted(ShapeKind::sphere, {0.995, 1.0, 0.991}).size()).radius_m,
        1.0);
    EXPECT_EQ(
        std::get<contact::Cylinder>(fitted(ShapeKind::cylinder, {0.995, 2, 1}).size()).radius_m,
        1.0);
    EXPECT_EQ(std::get<contact::Capsule>(fitted(ShapeKind::capsule, {1.0, 0.991, 1.0}).size())
                  .half_axis_m,
              0.0);
}

TEST(ShapeFit, RefusesBoxesThatHoldNoSuchShape) {
    expect_refused(ShapeKind::sphere, {1.0, 1.0, 0.98},
                   "its mesh is 2 by 2 by 1.96; the three must");
    expect_refused(ShapeKind::sphere, {0.0, 0.0, 0.0}, "the three must agree");
    expect_refused(ShapeKind::cylinder, {1.0, 2.0, 0.98}, "its x and z must agree within 1 %");
    expect_refused(ShapeKind::cylinder, {1.0, 0.0, 1.0}, "it stands along y");
    expect_refused(ShapeKind::capsule, {1.0, 2.0, 1.02}, "its x and z must agree within 1 %");
    expect_refused(ShapeKind::capsule, {1.0, 0.98, 1.0}, "its y must not be less");
    expect_refused(ShapeKind::box, {1.0, 1.0, 0.0}, "a flat one is a plate");
    expect_refused(ShapeKind::plate, {1.0, 0.0101, 1.0}, "one of these must be below 1 %");
    expect_refused(ShapeKind::plate, {1.0, 0.0, 0.0}, "the others not 0");
}

TEST(ShapeFit, APlateLiesAcrossItsThinnestExtent) {
    for (int flat = 0; flat < 3; ++flat) {
        Vector3 half(0.3, 0.2, 0.1);
        half[flat] = 0.0009;
        const contact::AnalyticShape plate = fitted(ShapeKind::plate, half);
        half[flat] = 0.0;
        EXPECT_LT((plate.bounds().max() - half).norm(), kShapeRounding_m);
        EXPECT_LT((plate.bounds().min() + half).norm(), kShapeRounding_m);
        EXPECT_NEAR(std::abs(plate.nearest(Vector3::Unit(flat)).normal[flat]), 1.0,
                    kShapeRounding_m);
    }
}

TEST(ShapeFit, TurnedMirroredAndScaledTheShapeMovesWithItsMesh) {
    // Where the mesh's own frame says "distance d from the shape", the device's says "d times the
    // scale", at the point and along the direction that the transform gives.
    std::mt19937_64 dice(20260730);
    std::normal_distribution<double> normal;
    const Vector3 round(0.5, 0.75, 0.5);
    for (int i = 0; i < 300; ++i) {
        const Eigen::Affine3d to_device = random_similarity(dice, i % 2 == 0);
        const double scale = to_device.linear().col(0).norm();
        for (const ShapeKind kind : {ShapeKind::plate, ShapeKind::sphere, ShapeKind::box,
                                     ShapeKind::cylinder, ShapeKind::capsule}) {
            const Vector3 half = kind == ShapeKind::plate    ? Vector3(0.5, 0.75, 0.0)
                                 : kind == ShapeKind::sphere ? Vector3(0.5, 0.5, 0.5)
                                                             : round;
            const BoundingBox box =
                box_of(Vector3(1.0, 2.0, 3.0), Vector3(1.0, 2.0, 3.0) + 2.0 * half);
            const contact::AnalyticShape here =
                fit_shape(kind, box, Eigen::Affine3d::Identity(), 0, "node 0");
            const contact::AnalyticShape there = fit_shape(kind, box, to_device, 0, "node 0");
            const Vector3 query =
                Vector3(1.0, 2.0, 3.0) + half + Vector3(normal(dice), normal(dice), normal(dice));
            const contact::NearestOnShape a = here.nearest(query);
            const contact::NearestOnShape b = there.nearest(to_device * query);
            const double tolerance_m = 20.0 * kShapeRounding_m * (1.0 + scale);
            EXPECT_NEAR(b.distance_m, scale * a.distance_m, tolerance_m);
            EXPECT_LT((b.point_m - to_device * a.point_m).norm(), tolerance_m);
        }
    }
}

TEST(ShapeFit, PlatesAndBoxesMayBeStretchedAlongTheirAxes) {
    const Eigen::Affine3d stretched(Eigen::AngleAxisd(0.3, Vector3(1, 2, 3).normalized()) *
                                    Eigen::Scaling(2.0, -3.0, 4.0));
    const auto box =
        std::get<contact::Box>(fitted(ShapeKind::box, {0.5, 0.25, 0.125}, stretched).size());
    EXPECT_LT((box.half_size_m - Vector3(1.0, 0.75, 0.5)).norm(), kShapeRounding_m);
    const auto plate =
        std::get<contact::Plate>(fitted(ShapeKind::plate, {0.5, 0.0, 0.125}, stretched).size());
    EXPECT_NEAR(plate.half_x_m, 1.0, kShapeRounding_m);
    EXPECT_NEAR(plate.half_z_m, 0.5, kShapeRounding_m);
    const std::string same = "its transform scales by 2 by 3 by 4; the three must be the same";
    const Eigen::Affine3d plain(Eigen::Scaling(2.0, 3.0, 4.0));
    expect_refused(ShapeKind::sphere, {1, 1, 1}, same, plain);
    expect_refused(ShapeKind::cylinder, {1, 1, 1}, same, plain);
    expect_refused(ShapeKind::capsule, {1, 1, 1}, same, plain);
    EXPECT_NO_THROW(
        fitted(ShapeKind::sphere, {1, 1, 1}, Eigen::Affine3d(Eigen::Scaling(1.0, 1.00009, 1.0))));
    expect_refused(ShapeKind::sphere, {1, 1, 1}, "must be the same",
                   Eigen::Affine3d(Eigen::Scaling(1.0, 1.00011, 1.0)));
}

TEST(ShapeFit, ShearsAndFlatteningAreRefused) {
    // Turned by 45° and then stretched: right angles go.
    const Eigen::Affine3d sheared(Eigen::Scaling(1.0, 2.0, 1.0) *
                                  Eigen::AngleAxisd(0.785, Vector3::UnitZ()));
    const Eigen::Affine3d flattened(Eigen::Scaling(1.0, 0.0, 1.0));
    for (const ShapeKind kind : {ShapeKind::box, ShapeKind::plate}) {
        const Vector3 half = kind == ShapeKind::plate ? Vector3(1, 1, 0) : Vector3(1, 1, 1);
        expect_refused(kind, half, "its transform shears it", sheared);
        expect_refused(kind, half, "its transform flattens it", flattened);
    }
}

/// A cube of 2 units whose node says `members`; in metres.
GltfBuilder cube(const std::string &members) {
    GltfBuilder builder;
    builder.asset = kMetres;
    builder.add_positions(
        {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1});
    builder.add_accessor(std::vector<std::uint8_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6,
                                                   0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7,
                                                   0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5},
                         kUnsignedByte, "SCALAR");
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 1)");
    builder.nodes = {R"({"mesh": 0, )" + members + "}"};
    return builder;
}

TEST(ShapeFit, ANodeWithAShapeIsDrawnAsItsMeshAndTouchedAsItsShape) {
    const Scene scene = load(cube(R"("name": "ball", "extras": {"shape": "sphere", "eta": 0.5},
                                     "translation": [1, 2, 3], "scale": [2, 2, 2])"));
    EXPECT_TRUE(scene.surface.triangles.empty());
    ASSERT_EQ(scene.meshes.size(), 1U);
    EXPECT_EQ(scene.meshes[0].indices.size(), 36U);
    ASSERT_EQ(scene.shapes.size(), 1U);
    EXPECT_EQ(std::get<contact::Sphere>(scene.shapes[0].size()).radius_m, 2.0);
    EXPECT_EQ(scene.shapes[0].nearest(Vector3(1, 2, 6)).distance_m, 1.0);
    ASSERT_EQ(scene.surface.materials.size(), 1U);
    EXPECT_EQ(scene.surface.materials[scene.shapes[0].material()].name, "ball");
    EXPECT_EQ(scene.surface.materials[scene.shapes[0].material()].eta, 0.5);
}

TEST(ShapeFit, ShapesAreFittedIntoTheWorkspaceWithTheScene) {
    GltfBuilder builder = cube(R"("extras": {"shape": "box"})");
    builder.asset = R"({"version": "2.0"})";
    const Scene scene = load(builder);
    ASSERT_EQ(scene.shapes.size(), 1U);
    EXPECT_LT((scene.shapes[0].bounds().min() - scene.lower_m).norm(), kShapeRounding_m);
    EXPECT_LT((scene.shapes[0].bounds().max() - scene.upper_m).norm(), kShapeRounding_m);
}

TEST(ShapeFit, ShapesAndTrianglesStandSideBySideWithMaterialsOfTheirOwn) {
    GltfBuilder builder = cube(R"("name": "mesh")");
    builder.nodes.emplace_back(R"({"mesh": 0, "name": "box", "extras": {"shape": "box"}})");
    builder.nodes.emplace_back(R"({"mesh": 0, "name": "last", "children": [3]})");
    builder.nodes.emplace_back(R"({"mesh": 0, "name": "rod", "extras": {"shape": "cylinder"}})");
    builder.scenes = {R"({"nodes": [0, 1, 2]})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.triangles.size(), 24U);
    EXPECT_EQ(scene.meshes.size(), 4U);
    ASSERT_EQ(scene.shapes.size(), 2U);
    EXPECT_EQ(scene.surface.materials[scene.shapes[0].material()].name, "box");
    EXPECT_EQ(scene.surface.materials[scene.shapes[1].material()].name, "rod");
    EXPECT_EQ(scene.surface.material_of_triangle.back(), 2);
}

TEST(ShapeFit, NoMoreShapesThanTheProxyTakes) {
    GltfBuilder builder = cube(R"("extras": {"shape": "box"})");
    while (builder.nodes.size() < contact::kMaxShapes) {
        builder.nodes.emplace_back(R"({"mesh": 0, "extras": {"shape": "box"}})");
    }
    const Scene scene = load(builder);
    EXPECT_EQ(contact::HapticSurface(scene.surface, scene.shapes).shapes().size(),
              contact::kMaxShapes);
    builder.nodes.emplace_back(R"({"mesh": 0, "extras": {"shape": "box"}})");
    expect_failure(builder, "more than 64 nodes that are touched as shapes");
}

TEST(ShapeFit, FilesWithShapesThatCannotBeAreRefusedInOneLine) {
    expect_failure(cube(R"("name": "X", "extras": {"shape": "plate"})"),
                   "node 'X': cannot be touched as a plate: its mesh is 2 by 2 by 2");
    expect_failure(cube(R"("name": "X", "extras": {"shape": "sphere"}, "scale": [1, 2, 1])"),
                   "node 'X': cannot be touched as a sphere: its transform scales by 1 by 2 by 1");
    GltfBuilder builder = cube(R"("name": "X")");
    builder.nodes.emplace_back(R"({"name": "empty", "extras": {"shape": "box"}})");
    EXPECT_TRUE(has_warning(load(builder),
                            "node 'empty': extras.shape is left out: it needs a mesh "
                            "on the same node, to be fitted to"));
}

contact::TriangleSoup soup_of(const scenes::Part &part, const Eigen::Isometry3d &place) {
    contact::TriangleSoup soup;
    for (const Vector3 &position : part.positions_m) {
        soup.vertices_m.emplace_back(place * position);
    }
    soup.triangles = part.triangles;
    soup.material_of_triangle.assign(part.triangles.size(), 0);
    soup.materials.push_back({"test", 0.0});
    return soup;
}

Eigen::Isometry3d anywhere(std::mt19937 &random) {
    std::normal_distribution<double> normal;
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.linear() =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
            .normalized()
            .toRotationMatrix();
    place.translation() = 0.05 * Vector3(normal(random), normal(random), normal(random));
    return place;
}

TEST(ShapeRecognition, ABoxIsABoxHoweverItLies) {
    const scenes::Part box =
        scenes::box(Vector3(-0.06, -0.015, -0.055), Vector3(0.06, -0.005, 0.025));
    std::mt19937 random(1);
    for (int round = 0; round < 20; ++round) {
        const auto fit = recognise_shape(soup_of(box, anywhere(random)), 0);
        ASSERT_TRUE(fit);
        ASSERT_TRUE(std::holds_alternative<contact::Box>(fit->shape.size()));
        EXPECT_LT(fit->deviation_m, 1e-9); // round-off
        Vector3 half_m = std::get<contact::Box>(fit->shape.size()).half_size_m;
        std::sort(half_m.data(), half_m.data() + 3);
        EXPECT_LT((half_m - Vector3(0.005, 0.04, 0.06)).norm(), 1e-9);
    }
}

TEST(ShapeRecognition, ASphereIsOffByTheSagittaOfItsFacets) {
    constexpr double kTrueRadius_m = 0.05;
    for (const int divisions : {3, 4, 5}) {
        const contact::TriangleSoup soup = rig::icosphere(divisions, kTrueRadius_m);
        double sagitta_m = 0.0;
        for (const auto &[a, b, c] : soup.triangles) {
            const Vector3 middle_m =
                (soup.vertices_m[a] + soup.vertices_m[b] + soup.vertices_m[c]) / 3.0;
            sagitta_m = std::max(sagitta_m, kTrueRadius_m - middle_m.norm());
        }
        const auto fit = recognise_shape(soup, 0);
        ASSERT_TRUE(fit);
        ASSERT_TRUE(std::holds_alternative<contact::Sphere>(fit->shape.size()));
        EXPECT_NEAR(std::get<contact::Sphere>(fit->shape.size()).radius_m, kTrueRadius_m, 1e-12);
        EXPECT_NEAR(fit->deviation_m, sagitta_m, 1e-9);
    }
}

TEST(ShapeRecognition, ACylinderIsOffByTheSagittaOfItsSides) {
    constexpr int kSides = 48;
    constexpr double kTrueRadius_m = 0.02;
    const auto fit = recognise_shape(
        testing::lathed(
            {{0.0, -0.035}, {kTrueRadius_m, -0.035}, {kTrueRadius_m, 0.035}, {0.0, 0.035}}, kSides),
        0);
    ASSERT_TRUE(fit);
    ASSERT_TRUE(std::holds_alternative<contact::Cylinder>(fit->shape.size()));
    const auto &cylinder = std::get<contact::Cylinder>(fit->shape.size());
    EXPECT_NEAR(cylinder.radius_m, kTrueRadius_m, 1e-4 * kTrueRadius_m);
    EXPECT_NEAR(cylinder.half_height_m, 0.035, 1e-12);
    const double sagitta_m = kTrueRadius_m * (1.0 - std::cos(std::numbers::pi / kSides));
    EXPECT_NEAR(fit->deviation_m, sagitta_m, 0.01 * sagitta_m);
}

TEST(ShapeRecognition, ARectangleIsAPlate) {
    contact::TriangleSoup soup;
    soup.vertices_m = {
        {-0.03, 0.01, -0.02}, {0.03, 0.01, -0.02}, {0.03, 0.01, 0.02}, {-0.03, 0.01, 0.02}};
    soup.triangles = {{0, 2, 1}, {0, 3, 2}};
    soup.material_of_triangle = {0, 0};
    soup.materials.push_back({"test", 0.0});
    const auto fit = recognise_shape(soup, 0);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(std::holds_alternative<contact::Plate>(fit->shape.size()));
    soup.triangles.pop_back(); // half of it is none
    soup.material_of_triangle.pop_back();
    EXPECT_FALSE(recognise_shape(soup, 0));
}

TEST(ShapeRecognition, WhatIsOpenInsideOutOrOtherIsNone) {
    contact::TriangleSoup bowl = rig::icosphere(4, 0.05);
    std::size_t kept = 0;
    for (const auto &triangle : bowl.triangles) {
        if (bowl.vertices_m[triangle[0]].y() < 0.0) {
            bowl.triangles[kept++] = triangle;
        }
    }
    bowl.triangles.resize(kept);
    bowl.material_of_triangle.resize(kept);
    EXPECT_FALSE(recognise_shape(bowl, 0));

    contact::TriangleSoup room = rig::icosphere(4, 0.05);
    for (auto &triangle : room.triangles) {
        std::swap(triangle[0], triangle[1]);
    }
    EXPECT_FALSE(recognise_shape(room, 0));

    contact::TriangleSoup sheet = rig::icosphere(4, 0.05); // to be touched from within, too
    sheet.materials[0].sides = contact::TouchSides::two;
    EXPECT_FALSE(recognise_shape(sheet, 0));

    EXPECT_FALSE(recognise_shape(rig::bumpy_sphere(4, 0.02, 0.002, 0.01), 0));
}

constexpr double kFitRounding = 1e-12; // relative, a few operations in double precision

TEST(Fit, FillsSixtyPercentAlongTheTightestAxisAndLessAlongTheOthers) {
    const device::Workspace workspace{Vector3(0.01, 0.02, 0.03), Vector3(0.3, 0.2, 0.1)};
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> coordinate(-100.0, 100.0);
    for (int round = 0; round < 200; ++round) {
        BoundingBox box;
        for (int corner = 0; corner < 2; ++corner) {
            box.include(Vector3(coordinate(random), coordinate(random), coordinate(random)));
        }
        const Fit fit = fit_into(workspace, box);
        const Vector3 lower = fit(box.lower);
        const Vector3 upper = fit(box.upper);
        EXPECT_LT((0.5 * (lower + upper) - workspace.centre_m).norm(), kFitRounding);
        const Vector3 share = (upper - lower).cwiseQuotient(workspace.size_m);
        EXPECT_NEAR(share.maxCoeff(), 0.6, kFitRounding);
        EXPECT_TRUE(lies_within(workspace, box_of(lower, upper)));
    }
}

TEST(Fit, AFlatSceneIsScaledByWhatItSpans) {
    const device::Workspace workspace{Vector3::Zero(), Vector3(0.3, 0.2, 0.1)};
    const Fit fit = fit_into(workspace, box_of(Vector3(0, 5, 0), Vector3(3, 5, 0.5)));
    EXPECT_NEAR(fit.scale, 0.06, kFitRounding); // 0.6 × 0.3 / 3
    EXPECT_NEAR(fit(Vector3(0, 5, 0)).y(), 0.0, kFitRounding);
}

TEST(Fit, RefusesAPointAndTheBoundless) {
    const device::Workspace workspace{Vector3::Zero(), Vector3(0.3, 0.2, 0.1)};
    EXPECT_THROW((void)fit_into(workspace, box_of(Vector3(1, 2, 3), Vector3(1, 2, 3))), InputError);
    EXPECT_THROW((void)fit_into(workspace, box_of(Vector3(-1.5e308, 0, 0), Vector3(1.5e308, 0, 0))),
                 InputError);
    EXPECT_THROW((void)fit_into(workspace, box_of(Vector3::Zero(), Vector3(1e-320, 0, 0))),
                 InputError);
}

TEST(Fit, WithinMeansOnEverySide) {
    const device::Workspace workspace{Vector3(1, 1, 1), Vector3(2, 2, 2)};
    EXPECT_TRUE(lies_within(workspace, box_of(Vector3(0, 0, 0), Vector3(2, 2, 2))));
    for (int axis = 0; axis < 3; ++axis) {
        Vector3 beyond = Vector3::Zero();
        beyond[axis] = 0.001;
        EXPECT_FALSE(lies_within(workspace, box_of(Vector3::Zero(), Vector3(2, 2, 2) + beyond)));
        EXPECT_FALSE(lies_within(workspace, box_of(-beyond, Vector3(2, 2, 2))));
    }
}

} // namespace
} // namespace springdrive::scene
