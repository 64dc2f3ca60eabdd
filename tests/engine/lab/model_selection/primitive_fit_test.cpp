// Covers engine/lab/model_selection/primitive_fit.cpp.
#include "engine/lab/model_selection/primitive_fit.h"

#include "assets/scenes/shapes.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace springdrive::model_selection {
namespace {

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

/// A prism of `sides` about y, with flat ends: the tessellation of a cylinder.
contact::TriangleSoup prism(int sides, double radius_m, double half_height_m) {
    contact::TriangleSoup soup;
    soup.materials.push_back({"test", 0.0});
    const auto ring = [&](int i, double y_m) {
        const double angle = 2.0 * std::numbers::pi * (i % sides) / sides;
        return Vector3(radius_m * std::sin(angle), y_m, radius_m * std::cos(angle));
    };
    const auto add = [&](const Vector3 &a, const Vector3 &b, const Vector3 &c) {
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.insert(soup.vertices_m.end(), {a, b, c});
        soup.triangles.push_back({first, first + 1, first + 2});
        soup.material_of_triangle.push_back(0);
    };
    const Vector3 up_m(0.0, half_height_m, 0.0);
    for (int i = 0; i < sides; ++i) {
        add(ring(i, -half_height_m), ring(i + 1, -half_height_m), ring(i + 1, half_height_m));
        add(ring(i, -half_height_m), ring(i + 1, half_height_m), ring(i, half_height_m));
        add(up_m, ring(i, half_height_m), ring(i + 1, half_height_m));
        add(-up_m, ring(i + 1, -half_height_m), ring(i, -half_height_m));
    }
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

TEST(PrimitiveFit, ABoxIsABoxHoweverItLies) {
    const scenes::Part box =
        scenes::box(Vector3(-0.06, -0.015, -0.055), Vector3(0.06, -0.005, 0.025));
    std::mt19937 random(1);
    for (int trial = 0; trial < 20; ++trial) {
        const auto fit = fit_primitive(soup_of(box, anywhere(random)), 0);
        ASSERT_TRUE(fit);
        ASSERT_TRUE(std::holds_alternative<contact::Box>(fit->shape.size()));
        EXPECT_LT(fit->deviation_m, 1e-9); // round-off
        Vector3 half_m = std::get<contact::Box>(fit->shape.size()).half_size_m;
        std::sort(half_m.data(), half_m.data() + 3);
        EXPECT_LT((half_m - Vector3(0.005, 0.04, 0.06)).norm(), 1e-9);
    }
}

TEST(PrimitiveFit, ASphereIsOffByTheSagittaOfItsFacets) {
    constexpr double kRadius_m = 0.05;
    for (const int divisions : {3, 4, 5}) {
        const contact::TriangleSoup soup = rig::icosphere(divisions, kRadius_m);
        double sagitta_m = 0.0;
        for (const auto &[a, b, c] : soup.triangles) {
            const Vector3 middle_m =
                (soup.vertices_m[a] + soup.vertices_m[b] + soup.vertices_m[c]) / 3.0;
            sagitta_m = std::max(sagitta_m, kRadius_m - middle_m.norm());
        }
        const auto fit = fit_primitive(soup, 0);
        ASSERT_TRUE(fit);
        ASSERT_TRUE(std::holds_alternative<contact::Sphere>(fit->shape.size()));
        EXPECT_NEAR(std::get<contact::Sphere>(fit->shape.size()).radius_m, kRadius_m, 1e-12);
        EXPECT_NEAR(fit->deviation_m, sagitta_m, 1e-9);
    }
}

TEST(PrimitiveFit, ACylinderIsOffByTheSagittaOfItsSides) {
    constexpr int kSides = 48;
    constexpr double kRadius_m = 0.02;
    const auto fit = fit_primitive(prism(kSides, kRadius_m, 0.035), 0);
    ASSERT_TRUE(fit);
    ASSERT_TRUE(std::holds_alternative<contact::Cylinder>(fit->shape.size()));
    const auto &cylinder = std::get<contact::Cylinder>(fit->shape.size());
    EXPECT_NEAR(cylinder.radius_m, kRadius_m, 1e-4 * kRadius_m);
    EXPECT_NEAR(cylinder.half_height_m, 0.035, 1e-12);
    const double sagitta_m = kRadius_m * (1.0 - std::cos(std::numbers::pi / kSides));
    EXPECT_NEAR(fit->deviation_m, sagitta_m, 0.01 * sagitta_m);
}

TEST(PrimitiveFit, ARectangleIsAPlate) {
    contact::TriangleSoup soup;
    soup.vertices_m = {
        {-0.03, 0.01, -0.02}, {0.03, 0.01, -0.02}, {0.03, 0.01, 0.02}, {-0.03, 0.01, 0.02}};
    soup.triangles = {{0, 2, 1}, {0, 3, 2}};
    soup.material_of_triangle = {0, 0};
    soup.materials.push_back({"test", 0.0});
    const auto fit = fit_primitive(soup, 0);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(std::holds_alternative<contact::Plate>(fit->shape.size()));
    soup.triangles.pop_back(); // half of it is none
    soup.material_of_triangle.pop_back();
    EXPECT_FALSE(fit_primitive(soup, 0));
}

TEST(PrimitiveFit, WhatIsOpenInsideOutOrOtherIsNone) {
    contact::TriangleSoup bowl = rig::icosphere(4, 0.05);
    std::size_t kept = 0;
    for (const auto &triangle : bowl.triangles) {
        if (bowl.vertices_m[triangle[0]].y() < 0.0) {
            bowl.triangles[kept++] = triangle;
        }
    }
    bowl.triangles.resize(kept);
    bowl.material_of_triangle.resize(kept);
    EXPECT_FALSE(fit_primitive(bowl, 0));

    contact::TriangleSoup room = rig::icosphere(4, 0.05);
    for (auto &triangle : room.triangles) {
        std::swap(triangle[0], triangle[1]);
    }
    EXPECT_FALSE(fit_primitive(room, 0));

    contact::TriangleSoup sheet = rig::icosphere(4, 0.05); // to be touched from within, too
    sheet.materials[0].sides = contact::TouchSides::two;
    EXPECT_FALSE(fit_primitive(sheet, 0));

    EXPECT_FALSE(fit_primitive(rig::bumpy_sphere(4, 0.02, 0.002, 0.01), 0));
}

} // namespace
} // namespace springdrive::model_selection
