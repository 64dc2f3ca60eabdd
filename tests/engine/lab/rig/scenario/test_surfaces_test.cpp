// Covers engine/lab/rig/scenario/test_surfaces.cpp.
#include "engine/lab/rig/scenario/test_surfaces.h"

#include "base/input_error.h"
#include "engine/lab/rig/scenario/blob_shape.h"
#include "tests/engine/lab/rig/scenario/soup_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>

namespace springdrive::rig {
namespace {

using testing::is_closed;
using testing::volume_m3;

TEST(TestSurfaces, SphereIsClosedRoundAndEven) {
    for (int divisions = 0; divisions <= 5; ++divisions) {
        const contact::TriangleSoup soup = icosphere(divisions, 0.05);
        const std::size_t triangles = std::size_t{20} << (2 * divisions);
        ASSERT_EQ(soup.triangles.size(), triangles);
        ASSERT_EQ(soup.vertices_m.size(), 2 + triangles / 2); // Euler
        ASSERT_EQ(soup.material_of_triangle.size(), triangles);
        EXPECT_TRUE(is_closed(soup));
        double shortest_m = 1.0;
        double longest_m = 0.0;
        for (const auto &t : soup.triangles) {
            for (std::size_t i = 0; i < 3; ++i) {
                const double edge_m =
                    (soup.vertices_m[t[i]] - soup.vertices_m[t[(i + 1) % 3]]).norm();
                shortest_m = std::min(shortest_m, edge_m);
                longest_m = std::max(longest_m, edge_m);
            }
        }
        EXPECT_LT(longest_m, 1.3 * shortest_m); // 1.18 in the limit is well known
        for (const Vector3 &vertex : soup.vertices_m) {
            ASSERT_NEAR(vertex.norm(), 0.05, 1e-16);
        }
    }
}

TEST(TestSurfaces, VolumeNearsThatOfTheBall) {
    const double ball = 4.0 / 3.0 * std::numbers::pi * 0.05 * 0.05 * 0.05;
    double missing = ball;
    for (int divisions = 1; divisions <= 5; ++divisions) {
        const double next = ball - volume_m3(icosphere(divisions, 0.05));
        EXPECT_GT(next, 0.0);                                    // inscribed, wound outwards
        EXPECT_LT(next, missing / (divisions == 1 ? 1.0 : 3.5)); // second order: a quarter each
        missing = next;
    }
}

TEST(TestSurfaces, BumpsAreAsHighAndLongAsSaid) {
    const contact::TriangleSoup soup = bumpy_sphere(6, 0.05, 0.5e-3, 6e-3);
    EXPECT_TRUE(is_closed(soup));
    double max_m = 0.0;
    double min_m = 0.0;
    for (const Vector3 &vertex : soup.vertices_m) {
        max_m = std::max(max_m, vertex.norm() - 0.05);
        min_m = std::min(min_m, vertex.norm() - 0.05);
    }
    EXPECT_LE(max_m, 0.5e-3);
    EXPECT_GE(min_m, -0.5e-3);
    EXPECT_GT(max_m, 0.45e-3);
    EXPECT_LT(min_m, -0.45e-3);
    // One wavelength along x changes nothing, half of one turns bumps into dents.
    const auto height_near = [&](const Vector3 &place) {
        const auto nearest = std::ranges::min_element(soup.vertices_m, {}, [&](const Vector3 &v) {
            return (v.normalized() - place.normalized()).squaredNorm();
        });
        return nearest->norm() - 0.05;
    };
    const auto on_sphere = [](double x, double y) {
        return Vector3(x, y, std::sqrt(0.05 * 0.05 - x * x - y * y));
    };
    const double here_m = height_near(on_sphere(1.5e-3, 1.5e-3));
    EXPECT_GT(std::abs(here_m), 0.2e-3);
    EXPECT_LT(here_m * height_near(on_sphere(-1.5e-3, 1.5e-3)), 0.0);
    EXPECT_GT(here_m * height_near(on_sphere(-1.5e-3, -1.5e-3)), 0.0);
}

TEST(TestSurfaces, OrganicOnesAreClosedWithCornersOnTheShape) {
    const contact::TriangleSoup soup = organic_surface(4, 0.04);
    EXPECT_TRUE(is_closed(soup));
    EXPECT_GT(volume_m3(soup), 0.0); // wound outwards
    for (const Vector3 &vertex_m : soup.vertices_m) {
        ASSERT_NEAR(organic_shape().field(vertex_m / 0.04), organic_shape().level, 1e-12);
    }
}

TEST(TestSurfaces, ABoxHasItsVolumeByTheDivergenceTheorem) {
    EXPECT_NEAR(volume_m3(solid_box({-1.0, -2.0, 0.5}, {2.0, 1.0, 1.0})), 3.0 * 3.0 * 0.5, 1e-12);
}

TEST(TestSurfaces, AreFoundByName) {
    EXPECT_EQ(test_surface_named("sphere:1280")->triangles.size(), 1280U);
    EXPECT_EQ(test_surface_named("bumpy:5120")->triangles.size(), 5120U);
    EXPECT_EQ(test_surface_named("organic:1280")->triangles.size(), 1280U);
    EXPECT_GT(test_surface_named("scan:1280")->triangles.size(), 1200U);
    EXPECT_GT(test_surface_named("cad:1280")->triangles.size(), 1200U);
    EXPECT_FALSE(test_surface_named("sphere").has_value());
    EXPECT_FALSE(test_surface_named("sphere.gltf").has_value());
    EXPECT_TRUE(names_test_sphere("sphere:1280"));
    EXPECT_FALSE(names_test_sphere("bumpy:1280"));
    for (const char *name : {"sphere:", "sphere:1281", "sphere:320", "sphere:5242880",
                             "sphere:1280 ", "bumpy:-1280", "bumpy:1e3", "organic:30420"}) {
        try {
            static_cast<void>(test_surface_named(name));
            FAIL() << name;
        } catch (const InputError &error) {
            EXPECT_NE(std::string(error.what()).find("1310720"), std::string::npos);
            EXPECT_EQ(std::string(error.what()).find(name), 0U);
        }
    }
}

TEST(TestSurfaces, OfAnyNumberHaveALeastAndALargest) {
    for (const char *name :
         {"scan:", "scan:999", "scan:2000001", "cad:1e6", "cad:99999999999999999999"}) {
        try {
            static_cast<void>(test_surface_named(name));
            FAIL() << name;
        } catch (const InputError &error) {
            EXPECT_EQ(error.what(), std::string(name) + ": triangles must be from 1000 to 2000000");
        }
    }
}

} // namespace
} // namespace springdrive::rig
