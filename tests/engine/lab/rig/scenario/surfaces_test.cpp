// Covers engine/lab/rig/scenario/{blob_shape,machined_surface,pressed_tips,scanned_surface,
// test_surfaces}.cpp and closest_point.cpp: generated surfaces against what is known of their
// shapes.
#include "engine/lab/rig/closest_point.h"
#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/lab/rig/scenario/scanned_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include "base/input_error.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "tests/support/configurations.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace springdrive::rig {
namespace {

using contact::TriangleSoup;

/// How edges are shared, where vertices are.
struct EdgeUse {
    std::size_t paired = 0; ///< run through once each way: two triangles wound alike
    std::size_t open = 0;   ///< of one triangle
    std::size_t other = 0;
};

EdgeUse edge_use(const TriangleSoup &soup) {
    // The ends, the lower first, and 1 where they are run through in this order.
    std::vector<std::array<std::uint32_t, 3>> edges;
    edges.reserve(3 * soup.triangles.size());
    for (const auto &t : soup.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [lower, upper] = std::minmax(t[i], t[(i + 1) % 3]);
            edges.push_back({lower, upper, lower == t[i] ? 1U : 0U});
        }
    }
    std::ranges::sort(edges);
    EdgeUse use;
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i + 1;
        while (end < edges.size() && edges[end][0] == edges[i][0] && edges[end][1] == edges[i][1]) {
            ++end;
        }
        const bool is_pair = end == i + 2 && edges[i][2] != edges[i + 1][2];
        ++(end == i + 1 ? use.open : is_pair ? use.paired : use.other);
        i = end;
    }
    return use;
}

/// A closed surface about the origin without holes or handles, wound outwards, no vertex unused.
void expect_closed(const TriangleSoup &soup) {
    const EdgeUse use = edge_use(soup);
    EXPECT_EQ(use.open + use.other, 0U);
    EXPECT_EQ(soup.triangles.size(), 2 * soup.vertices_m.size() - 4); // Euler
}

/// Of a tetrahedron to the origin, six times: positive where its triangle is wound outwards.
double spanned(const TriangleSoup &soup, std::size_t triangle) {
    const auto &[a, b, c] = soup.triangles[triangle];
    return soup.vertices_m[a].cross(soup.vertices_m[b]).dot(soup.vertices_m[c]);
}

double volume_m3(const TriangleSoup &soup) {
    double sum = 0.0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        sum += spanned(soup, i);
    }
    return sum / 6.0;
}

/// The longest edge over the height on it.
double slenderness(const TriangleSoup &soup, std::size_t triangle) {
    const auto &[a, b, c] = soup.triangles[triangle];
    const Vector3 to_b = soup.vertices_m[b] - soup.vertices_m[a];
    const Vector3 to_c = soup.vertices_m[c] - soup.vertices_m[a];
    const double longest_squared =
        std::max({to_b.squaredNorm(), to_c.squaredNorm(), (to_c - to_b).squaredNorm()});
    return longest_squared / to_b.cross(to_c).norm();
}

std::map<std::uint32_t, std::size_t> triangles_at_vertices(const TriangleSoup &soup) {
    std::map<std::uint32_t, std::size_t> valence;
    for (const auto &triangle : soup.triangles) {
        for (const std::uint32_t corner : triangle) {
            ++valence[corner];
        }
    }
    return valence;
}

TEST(BlobShape, OfOneBlobIsASphere) {
    // (1 − r²)³ = 1/8 at r² = 1/2.
    const BlobShape shape{{{Vector3::Zero(), 1.0}}, 0.125};
    const Vector3 direction = Vector3(1.0, -2.0, 0.5).normalized();
    EXPECT_NEAR(shape.distance(direction), std::sqrt(0.5), 1e-15);
    EXPECT_NEAR((shape.outward_normal(0.7 * direction) - direction).norm(), 0.0, 1e-15);
    EXPECT_EQ(shape.field(1.01 * direction), 0.0);
}

TEST(BlobShape, OrganicSurfaceIsOnItsLevelWithTheNormalOfItsField) {
    const BlobShape &shape = organic_shape();
    std::mt19937_64 random(2);
    for (int i = 0; i < 500; ++i) {
        const Vector3 direction = testing::random_vector(random, 1.0).normalized();
        const Vector3 point = shape.distance(direction) * direction;
        ASSERT_NEAR(shape.field(point), shape.level, 1e-13);
        // Central differences.
        constexpr double kStep = 1e-5;
        Vector3 descent;
        for (int axis = 0; axis < 3; ++axis) {
            const Vector3 step = kStep * Vector3::Unit(axis);
            descent[axis] = (shape.field(point - step) - shape.field(point + step)) / (2.0 * kStep);
        }
        ASSERT_LT((descent.normalized() - shape.outward_normal(point)).norm(), 1e-6);
    }
}

TEST(TestSurfaces, SphereIsClosedRoundAndEven) {
    const double ball = 4.0 / 3.0 * std::numbers::pi * 0.05 * 0.05 * 0.05;
    double missing = ball;
    for (int divisions = 0; divisions <= 5; ++divisions) {
        const TriangleSoup soup = icosphere(divisions, 0.05);
        const std::size_t triangles = std::size_t{20} << (2 * divisions);
        ASSERT_EQ(soup.triangles.size(), triangles);
        ASSERT_EQ(soup.material_of_triangle.size(), triangles);
        expect_closed(soup);
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
        const double next = ball - volume_m3(soup);
        EXPECT_GT(next, 0.0);                                   // inscribed, wound outwards
        EXPECT_LT(next, missing / (divisions < 2 ? 1.0 : 3.5)); // second order: a quarter each
        missing = next;
    }
}

TEST(TestSurfaces, BumpsAreAsHighAndLongAsSaid) {
    const TriangleSoup soup = bumpy_sphere(6, 0.05, 0.5e-3, 6e-3);
    expect_closed(soup);
    double max_m = 0.0;
    double min_m = 0.0;
    for (const Vector3 &vertex : soup.vertices_m) {
        max_m = std::max(max_m, vertex.norm() - 0.05);
        min_m = std::min(min_m, vertex.norm() - 0.05);
    }
    EXPECT_NEAR(max_m, 0.475e-3, 0.025e-3);
    EXPECT_NEAR(min_m, -0.475e-3, 0.025e-3);
    // Half of a wavelength along x turns bumps into dents, and half of one along y turns them back.
    const auto height_near = [&](double x, double y) {
        const Vector3 place = Vector3(x, y, std::sqrt(0.05 * 0.05 - x * x - y * y)).normalized();
        const auto nearest = std::ranges::min_element(soup.vertices_m, {}, [&](const Vector3 &v) {
            return (v.normalized() - place).squaredNorm();
        });
        return nearest->norm() - 0.05;
    };
    const double here_m = height_near(1.5e-3, 1.5e-3);
    EXPECT_GT(std::abs(here_m), 0.2e-3);
    EXPECT_LT(here_m * height_near(-1.5e-3, 1.5e-3), 0.0);
    EXPECT_GT(here_m * height_near(-1.5e-3, -1.5e-3), 0.0);
}

TEST(TestSurfaces, OrganicOnesAreClosedWithCornersOnTheShape) {
    const TriangleSoup soup = organic_surface(4, 0.04);
    expect_closed(soup);
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
    struct Case {
        const char *name;
        const char *said;
    };
    for (const Case &one :
         {Case{"sphere:", "or 1310720"}, Case{"sphere:1281", "or 1310720"},
          Case{"sphere:320", "or 1310720"}, Case{"sphere:5242880", "or 1310720"},
          Case{"sphere:1280 ", "or 1310720"}, Case{"bumpy:-1280", "or 1310720"},
          Case{"bumpy:1e3", "or 1310720"}, Case{"organic:30420", "or 1310720"},
          Case{"scan:", "from 1000 to 2000000"}, Case{"scan:999", "from 1000 to 2000000"},
          Case{"scan:2000001", "from 1000 to 2000000"}, Case{"cad:1e6", "from 1000 to 2000000"},
          Case{"cad:99999999999999999999", "from 1000 to 2000000"}}) {
        const std::string text =
            error_text_of([&one] { static_cast<void>(test_surface_named(one.name)); });
        EXPECT_TRUE(text.starts_with(std::string(one.name) + ": ")) << text;
        EXPECT_TRUE(text.ends_with(one.said)) << text;
    }
}

TEST(ClosestPoint, IsThatOfTryingEveryTriangle) {
    std::mt19937_64 random(1);
    for (const TriangleSoup &soup :
         {icosphere(3, kTestSphereRadius_m), organic_surface(3, kTestOrganicScale_m)}) {
        ClosestPointFinder finder(soup);
        for (int i = 0; i < 300; ++i) { // each far from the last
            const Vector3 tip_m = testing::random_vector(random, 0.08);
            double min_m = std::numeric_limits<double>::infinity();
            for (const auto &[a, b, c] : soup.triangles) {
                const contact::TrianglePoint found = contact::nearest_on_triangle(
                    {soup.vertices_m[a], soup.vertices_m[b], soup.vertices_m[c]}, tip_m);
                min_m = std::min(min_m, (found.point_m - tip_m).norm());
            }
            const ClosestPoint closest = finder.closest(tip_m);
            // Round-off of distances below 0.2 m.
            ASSERT_NEAR((closest.point_m - tip_m).norm(), min_m, 1e-15);
            ASSERT_NEAR(closest.normal.norm(), 1.0, 1e-14);
            ASSERT_GT(closest.normal.dot(closest.point_m), 0.0); // out of the surface
        }
    }
}

TEST(PressedTips, AreAsDeepAsTheySayUnderTheSphere) {
    for (const PressedTip &tip : tips_in_sphere(5000)) {
        ASSERT_NEAR(tip.tip_m.norm(), kTestSphereRadius_m - tip.depth_m(), 1e-16);
        ASSERT_NEAR(tip.surface_m.norm(), kTestSphereRadius_m, 1e-16);
        ASSERT_GE(tip.depth_m(), 0.999e-3);
        ASSERT_LE(tip.depth_m(), 2.001e-3);
    }
}

TEST(PressedTips, OfTheOrganicShapeKnowTheNearestPointOfAll) {
    // Points of the surface, some 0.6 mm from one to the next.
    const TriangleSoup points = organic_surface(6, kTestOrganicScale_m);
    const std::vector<PressedTip> tips = tips_in_organic_shape(20'000);
    for (std::size_t i = 0; i < tips.size(); i += 97) {
        const PressedTip &tip = tips[i];
        double min_m = std::numeric_limits<double>::infinity();
        for (const Vector3 &point_m : points.vertices_m) {
            min_m = std::min(min_m, (point_m - tip.tip_m).norm());
        }
        ASSERT_GE(min_m, tip.depth_m() - 1e-15) << i;  // no point of the true surface is nearer
        ASSERT_LE(min_m, tip.depth_m() + 0.3e-3) << i; // and some of these are about as near
        ASSERT_NEAR(organic_shape().field(tip.surface_m / kTestOrganicScale_m),
                    organic_shape().level, 1e-12);
    }
}

TEST(PressedTips, MoveOnAsAHandDoes) {
    for (const auto &tips : {tips_in_sphere(20'000), tips_in_organic_shape(20'000)}) {
        double way_m = 0.0;
        for (std::size_t i = 1; i < tips.size(); ++i) {
            const double step_m = (tips[i].tip_m - tips[i - 1].tip_m).norm();
            ASSERT_LT(step_m, 0.4e-3);
            way_m += step_m;
        }
        EXPECT_NEAR(way_m / 20.0, 0.1, 0.05); // m/s at 1 kHz
    }
}

TEST(PressedTips, GoBeyondTheMiddleOfThePlateButNotThrough) {
    const Vector3 half_m = thin_plate_half_size_m();
    double min_m = half_m.y();
    for (const PressedTip &tip : tips_in_thin_plate(20'000)) {
        ASSERT_EQ(tip.surface_m.y(), half_m.y());
        ASSERT_LT(tip.tip_m.cwiseAbs().maxCoeff(), 0.8 * half_m.x());
        min_m = std::min(min_m, tip.tip_m.y());
    }
    EXPECT_NEAR(min_m, -0.5 * half_m.y(), 1e-6);
}

constexpr std::size_t kPartTriangles = 100'000;

const TriangleSoup &machined() {
    static const TriangleSoup soup = machined_surface(kPartTriangles);
    return soup;
}

TEST(MachinedSurface, IsClosedWithAboutAsManyTrianglesAsAsked) {
    for (const std::size_t triangles : {1000U, 1280U, 5000U, 20'000U, 300'000U}) {
        const TriangleSoup soup = machined_surface(triangles);
        const auto requested = static_cast<double>(triangles);
        EXPECT_NEAR(static_cast<double>(soup.triangles.size()), requested,
                    triangles < 20'000 ? 0.06 * requested : 2e-3 * requested);
        EXPECT_EQ(soup.material_of_triangle.size(), soup.triangles.size());
        expect_closed(soup);
    }
    const contact::HapticSurface prepared(machined()); // touched from outside
    EXPECT_EQ(prepared.report().triangles_kept, machined().triangles.size());
    EXPECT_EQ(prepared.report().components, 1U);
    EXPECT_EQ(prepared.report().closed_components, 1U);
}

TEST(MachinedSurface, HasTheVolumeOfItsParts) {
    // The block less its rounded edges (1 - π/4 of r², along 48 mm) and corners, and the shafts; of
    // the foot's fillet and the end's rounding by Pappus, with the centroid of what is left of a
    // square beside a quarter disc, 0.2234 r from its sides.
    constexpr double kPi = std::numbers::pi;
    constexpr double kLeft = 1.0 - 0.25 * kPi;
    const double block = 50.0 * 50.0 * 50.0 - 12.0 * 48.0 * kLeft - 8.0 * (1.0 - kPi / 6.0);
    const double shaft = kPi * 18.0 * 18.0 * 20.0;
    const double foot = kLeft * 1.5 * 1.5 * 2.0 * kPi * (18.0 + 0.2234 * 1.5);
    const double end = kLeft * 2.0 * kPi * (18.0 - 0.2234);
    const double exact = block + 2.0 * (shaft + foot - end);
    const auto error = [&](const TriangleSoup &soup) {
        return std::abs(1e9 * volume_m3(soup) - exact);
    };
    const double coarse = error(machined());
    EXPECT_LT(coarse, 1e-4 * exact);
    EXPECT_LT(error(machined_surface(1'000'000)),
              coarse / 3.5); // second order: fillets twice as fine
}

TEST(MachinedSurface, HasItsCornersOnTheTrueShape) {
    Vector3 largest_m = Vector3::Zero();
    for (const Vector3 &vertex_m : machined().vertices_m) {
        ASSERT_NEAR(vertex_m.norm(), machined_body_radius_m(vertex_m.normalized()), 1e-12);
        largest_m = largest_m.cwiseMax(vertex_m.cwiseAbs());
    }
    EXPECT_NEAR((largest_m - Vector3(45e-3, 25e-3, 25e-3)).norm(), 0.0, 1e-12);
}

/// A circle is divided into 2116 here, into 12,000 with a million triangles.
TEST(MachinedSurface, HasNeedlesFansAndFlatFacesOfTwoTriangles) {
    std::size_t needles = 0;
    std::size_t large = 0;
    for (std::size_t i = 0; i < machined().triangles.size(); ++i) {
        needles += slenderness(machined(), i) > 200.0 ? 1 : 0;
        const auto &[a, b, c] = machined().triangles[i];
        const auto &vertices_m = machined().vertices_m;
        large += (vertices_m[b] - vertices_m[a]).cross(vertices_m[c] - vertices_m[a]).norm() >
                         0.04 * 0.04
                     ? 1
                     : 0;
    }
    EXPECT_EQ(large, 8U);
    EXPECT_GT(needles, 8'000U);
    const auto fans = std::ranges::count_if(triangles_at_vertices(machined()),
                                            [](const auto &v) { return v.second > 400; });
    EXPECT_EQ(fans, 10); // the ends', and the corners of the two faces with a shaft
}

constexpr std::size_t kScanTriangles = 50'000;
constexpr std::uint64_t kSeed = 4;

const TriangleSoup &scanned() {
    static const TriangleSoup soup = scanned_surface(kScanTriangles, kSeed);
    return soup;
}

TEST(ScannedSurface, HasAboutAsManyTrianglesAsAskedTheSameForTheSameSeed) {
    for (const std::size_t triangles : {std::size_t{1000}, std::size_t{20'000}}) {
        const TriangleSoup soup = scanned_surface(triangles, kSeed);
        EXPECT_NEAR(static_cast<double>(soup.triangles.size()), static_cast<double>(triangles), 10);
        EXPECT_EQ(soup.material_of_triangle.size(), soup.triangles.size());
        const TriangleSoup again = scanned_surface(triangles, kSeed);
        EXPECT_EQ(again.vertices_m, soup.vertices_m);
        EXPECT_EQ(again.triangles, soup.triangles);
        EXPECT_NE(scanned_surface(triangles, kSeed + 1).vertices_m, soup.vertices_m);
    }
}

TEST(ScannedSurface, IsOpenAndWoundAlikeAndTouchedFromBothSides) {
    const EdgeUse use = edge_use(scanned());
    EXPECT_EQ(use.other, 0U);
    EXPECT_GT(use.open, 100U); // the underside's rim alone: 90 mm in edges of about 1 mm
    EXPECT_GT(use.paired, kScanTriangles);
    for (std::size_t i = 0; i < scanned().triangles.size(); ++i) {
        ASSERT_GT(spanned(scanned(), i), 0.0); // outwards, once
    }
    const contact::HapticSurface prepared(scanned());
    EXPECT_EQ(prepared.report().flipped_triangles, 0U);
    EXPECT_EQ(prepared.report().closed_components, 0U);
}

TEST(ScannedSurface, IsSomeCentimetresLargeWithNoiseOfTwentyMicrometres) {
    double sum_m2 = 0.0;
    for (const Vector3 &vertex_m : scanned().vertices_m) {
        ASSERT_GT(vertex_m.norm(), 0.02);
        ASSERT_LT(vertex_m.norm(), 0.07);
        const double noise_m = vertex_m.norm() - scanned_body_radius_m(vertex_m.normalized());
        ASSERT_LT(std::abs(noise_m), 150e-6);
        sum_m2 += noise_m * noise_m;
    }
    const double rms_m = std::sqrt(sum_m2 / static_cast<double>(scanned().vertices_m.size()));
    EXPECT_NEAR(rms_m, 20e-6, 2e-6);
}

TEST(ScannedSurface, HasNoTriangleWellWithinAHole) {
    const std::vector<ScanHole> holes = scan_holes(kSeed);
    EXPECT_EQ(holes.size(), 21U);
    for (const auto &[a, b, c] : scanned().triangles) {
        const auto &vertices_m = scanned().vertices_m;
        const Vector3 direction = (vertices_m[a] + vertices_m[b] + vertices_m[c]).normalized();
        for (const ScanHole &hole : holes) {
            ASSERT_GT(std::acos(std::min(1.0, direction.dot(hole.direction))),
                      hole.half_angle_rad - kMaxRaggedness_rad);
        }
    }
}

TEST(ScannedSurface, IsIrregularUnevenAndHasSlivers) {
    std::vector<double> areas;
    std::size_t slivers = 0;
    for (std::size_t i = 0; i < scanned().triangles.size(); ++i) {
        const auto &[a, b, c] = scanned().triangles[i];
        const auto &vertices_m = scanned().vertices_m;
        const Vector3 to_b = vertices_m[b] - vertices_m[a];
        areas.push_back(0.5 * to_b.cross(vertices_m[c] - vertices_m[a]).norm());
        slivers += slenderness(scanned(), i) > 30.0 ? 1 : 0;
    }
    std::ranges::sort(areas);
    EXPECT_GT(areas[areas.size() * 9 / 10], 5.0 * areas[areas.size() / 10]);
    EXPECT_GT(slivers, kScanTriangles / 600);
    EXPECT_LT(slivers, kScanTriangles / 50);
    const auto valence = triangles_at_vertices(scanned());
    const auto regular =
        std::ranges::count_if(valence, [](const auto &v) { return v.second == 6; });
    EXPECT_LT(static_cast<double>(regular), 0.5 * static_cast<double>(valence.size()));
}

TEST(SphereTriangulation, IsClosedCoversTheSphereOnceAndIsDelaunays) {
    SphereTriangulation mesh;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> weight(0.01, 1.0);
    while (mesh.points().size() < 600) {
        const auto triangle = static_cast<std::uint32_t>(random() % mesh.triangles().size());
        Vector3 direction = Vector3::Zero();
        for (const std::uint32_t corner : mesh.triangles()[triangle]) {
            direction += weight(random) * mesh.points()[corner];
        }
        mesh.insert(triangle, direction.normalized());
    }
    TriangleSoup soup;
    soup.vertices_m = mesh.points();
    soup.triangles = mesh.triangles();
    expect_closed(soup);
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        EXPECT_GT(spanned(soup, i), 0.0);
        const auto &[a, b, c] = soup.triangles[i];
        const Vector3 from = soup.vertices_m[a];
        const Vector3 normal =
            (soup.vertices_m[b] - from).cross(soup.vertices_m[c] - from).normalized();
        for (const Vector3 &point : soup.vertices_m) {  // none is within a circumscribed circle
            ASSERT_LT(normal.dot(point - from), 1e-10); // round-off, over small triangles
        }
    }
}

} // namespace
} // namespace springdrive::rig
