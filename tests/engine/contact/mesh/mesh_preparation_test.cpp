// Covers engine/contact/mesh/mesh_preparation.cpp and mesh_warnings.cpp.
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/mesh_warnings.h"
#include "tests/engine/contact/mesh/meshes.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace springdrive::contact {
namespace {

using testing::add_triangle;
using testing::box_soup;
using testing::Corners;
using testing::corners;
using testing::joined;
using testing::unshared;

const Vector3 kLower_m(-0.01, -0.01, -0.01);
const Vector3 kUpper_m(0.01, 0.02, 0.03);

bool are_all(const PreparedMesh &mesh, FacetSides sides) {
    return std::ranges::all_of(mesh.facets,
                               [sides](const FacetSource &facet) { return facet.sides == sides; });
}

TEST(MeshPreparation, WeldsABoxOfLooseTrianglesShut) {
    const PreparedMesh mesh = prepare_mesh(unshared(box_soup(kLower_m, kUpper_m)));
    EXPECT_EQ(mesh.report.triangles_given, 12U);
    EXPECT_EQ(mesh.report.triangles_kept, 12U);
    EXPECT_EQ(mesh.report.welded_vertices, 36U - 8U);
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_EQ(mesh.report.components, 1U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_EQ(mesh.report.inward_components, 0U);
    EXPECT_TRUE(are_all(mesh, FacetSides::one));
}

TEST(MeshPreparation, TreatsEachComponentOnItsOwn) {
    const TriangleSoup soup = joined(box_soup(kLower_m, kUpper_m), testing::sheet(1, 0.05));
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.components, 2U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    for (const FacetSource &facet : mesh.facets) {
        EXPECT_EQ(facet.sides, facet.triangle < 12 ? FacetSides::one : FacetSides::two);
    }
}

TEST(MeshPreparation, MakesABodyGivenInBothWindingsTouchableFromBothSides) {
    const TriangleSoup box = box_soup(kLower_m, kUpper_m);
    TriangleSoup both = box;
    for (const auto &[a, b, c] : testing::turned_inside_out(box).triangles) {
        both.triangles.push_back({a, b, c});
        both.material_of_triangle.push_back(0);
    }
    const PreparedMesh mesh = prepare_mesh(both);
    EXPECT_EQ(mesh.facets.size(), 12U);
    EXPECT_EQ(mesh.report.merged_triangles, 12U);
    EXPECT_EQ(mesh.report.inward_components, 0U);
    EXPECT_TRUE(are_all(mesh, FacetSides::two));
}

TEST(MeshPreparation, MergesTheWallBetweenVoxelsOfOneMaterial) {
    const Vector3 step(0.02, 0.0, 0.0);
    TriangleSoup soup =
        joined(box_soup(kLower_m, kUpper_m), box_soup(kLower_m + step, kUpper_m + step));
    for (std::uint16_t &material : soup.material_of_triangle) {
        material = 0;
    }
    std::vector<std::size_t> wall;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const Corners all = corners(soup, i);
        if (std::ranges::all_of(all, [](const Vector3 &p) { return p.x() == 0.01; })) {
            wall.push_back(i);
        }
    }
    ASSERT_EQ(wall.size(), 4U);
    // The diagonals of the wall differ: let the second box have those of the first.
    for (std::size_t i = 0; i < 2; ++i) {
        const auto &[a, b, c] = soup.triangles[wall[i]];
        soup.triangles[wall[2 + i]] = {a, c, b};
    }
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.merged_triangles, 2U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_EQ(mesh.report.components, 1U);
    for (const FacetSource &facet : mesh.facets) {
        const bool is_wall = std::ranges::count(wall, facet.triangle) > 0;
        EXPECT_EQ(facet.sides, is_wall ? FacetSides::two : FacetSides::one);
    }
}

TEST(MeshPreparation, DropsDegenerateTrianglesAndStaysClosed) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    // A sliver between two halves of a triangle: corner, corner, and the middle of their edge.
    const auto [a, b, c] = soup.triangles[0];
    const Vector3 middle = 0.5 * (soup.vertices_m[a] + soup.vertices_m[b]);
    const Corners first = {middle, soup.vertices_m[b], soup.vertices_m[c]};
    soup.triangles[0] = {a, static_cast<std::uint32_t>(soup.vertices_m.size()), c};
    soup.vertices_m.push_back(middle);
    add_triangle(soup, first);
    add_triangle(soup, {soup.vertices_m[a], soup.vertices_m[b], middle});
    // And triangles that collapse to a segment and to a point.
    add_triangle(soup, {middle, middle, soup.vertices_m[c]});
    add_triangle(soup, {middle, middle, middle});
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.degenerate_triangles, 3U);
    EXPECT_EQ(mesh.report.triangles_kept, 13U);
    EXPECT_EQ(mesh.report.closed_components, 1U);
    EXPECT_TRUE(are_all(mesh, FacetSides::one));
}

TEST(MeshPreparation, RefusesATriangleWithoutVerticesOrMaterial) {
    TriangleSoup soup = box_soup(kLower_m, kUpper_m);
    soup.triangles[3][1] = 8;
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
    soup = box_soup(kLower_m, kUpper_m);
    soup.material_of_triangle[3] = 1;
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
    soup.material_of_triangle.pop_back();
    EXPECT_THROW(static_cast<void>(prepare_mesh(soup)), std::invalid_argument);
}

TEST(MeshPreparation, ClosesASphereOfPerturbedTriangles) {
    std::mt19937_64 random(1);
    for (int level = 2; level <= 6; ++level) {
        const TriangleSoup sphere = testing::icosphere(level, 0.03);
        const PreparedMesh mesh = prepare_mesh(testing::shaken(unshared(sphere), 1e-6, random));
        EXPECT_TRUE(testing::is_watertight(testing::places(mesh.facets)));
        EXPECT_EQ(mesh.report.closed_components, 1U);
        EXPECT_EQ(mesh.report.open_edges, 0U);
        EXPECT_GT(mesh.report.open_edges_given, 2 * sphere.triangles.size()); // of three each
        EXPECT_LE(mesh.report.largest_move_m, 2e-6);
        EXPECT_EQ(mesh.report.triangles_kept, sphere.triangles.size());
        EXPECT_TRUE(are_all(mesh, FacetSides::one));
        // Every vertex is within 1 µm of its place, so the surface is too.
        const double area = testing::area_m2(prepare_mesh(sphere).facets);
        const double volume = testing::volume_m3(prepare_mesh(sphere).facets);
        EXPECT_NEAR(testing::volume_m3(mesh.facets), volume, 1e-6 * 1.1 * area);
    }
}

TEST(MeshPreparation, ClosesAPerturbedSphereOfBothWindingsAndManyTurnedTriangles) {
    std::mt19937_64 random(1);
    const TriangleSoup sphere = testing::icosphere(3, 0.03);
    const PreparedMesh turned = prepare_mesh(
        testing::shaken(testing::partly_turned(unshared(sphere), 0.3, random), 1e-6, random));
    EXPECT_TRUE(testing::is_watertight(testing::places(turned.facets)));
    EXPECT_GT(testing::volume_m3(turned.facets), 0.0);
    EXPECT_GT(turned.report.flipped_triangles, 0U);

    TriangleSoup both = unshared(sphere);
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
        const auto [a, b, c] = corners(sphere, i);
        add_triangle(both, {a, c, b});
    }
    const PreparedMesh merged = prepare_mesh(testing::shaken(both, 1e-6, random));
    EXPECT_EQ(merged.facets.size(), sphere.triangles.size());
    EXPECT_EQ(merged.report.open_edges, 0U);
    EXPECT_TRUE(are_all(merged, FacetSides::two));
}

/// A box whose top is divided finely and whose walls are not, rounded to single precision.
TriangleSoup box_with_t_junctions(int cells, const Eigen::Isometry3d &motion) {
    TriangleSoup soup = box_soup({-0.05, -0.02, -0.05}, {0.05, 0.0, 0.05});
    const auto is_top = [&](const auto &triangle) {
        return std::ranges::all_of(
            triangle, [&](std::uint32_t vertex) { return soup.vertices_m[vertex].y() == 0.0; });
    };
    std::erase_if(soup.triangles, is_top);
    soup.material_of_triangle.resize(soup.triangles.size());
    soup = testing::moved(joined(soup, testing::sheet(cells, 0.05)), motion);
    for (Vector3 &vertex : soup.vertices_m) {
        vertex = vertex.cast<float>().cast<double>();
    }
    return soup;
}

TEST(MeshPreparation, ClosesTJunctionsOfSinglePrecision) {
    std::mt19937_64 random(1);
    for (int cells = 2; cells < 40; cells += 3) {
        Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
        motion.rotate(
            Eigen::AngleAxisd(static_cast<double>(cells), testing::random_direction(random)));
        motion.pretranslate(testing::random_vector(random, 1.0));
        const PreparedMesh mesh = prepare_mesh(box_with_t_junctions(cells, motion));
        EXPECT_TRUE(testing::is_watertight(testing::places(mesh.facets)));
        EXPECT_EQ(mesh.report.closed_components, 1U);
        EXPECT_EQ(mesh.report.components, 1U);
        EXPECT_EQ(mesh.report.split_triangles, 4U);
        if (mesh.report.graded_fans.all == 0) { // of the divided triangles
            EXPECT_EQ(static_cast<int>(mesh.facets.size()),
                      10 + 4 * (cells - 1) + 2 * cells * cells);
        }
        EXPECT_EQ(mesh.report.triangles_kept, mesh.report.triangles_given);
        // Rounding moves vertices of up to 1 m by 1e-7 m at most.
        EXPECT_NEAR(testing::area_m2(mesh.facets), 0.028, 1e-6);
        EXPECT_NEAR(testing::volume_m3(mesh.facets), 2e-4, 3e-7 * 0.028);
    }
}

TEST(MeshPreparation, LeavesAFineScanAsItIs) {
    TriangleSoup scan = testing::icosphere(5, 5e-4); // edges of 17 to 21 µm
    scan.triangles.resize(scan.triangles.size() * 3 / 4);
    scan.material_of_triangle.resize(scan.triangles.size());
    const PreparedMesh mesh = prepare_mesh(scan);
    EXPECT_EQ(mesh.facets.size(), scan.triangles.size());
    EXPECT_EQ(mesh.report.closed_cracks + mesh.report.split_triangles, 0U);
    EXPECT_EQ(mesh.report.open_edges, mesh.report.open_edges_given);
}

TEST(MeshPreparation, GivesTheSameFacetsInAnyOrderOfVerticesAndTriangles) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 20; ++round) {
        TriangleSoup soup = testing::partly_turned(testing::bumpy_sphere(2, 0.03), 0.1, random);
        soup.triangles.push_back(soup.triangles[7]);
        soup.triangles.resize(soup.triangles.size() - static_cast<std::size_t>(round % 3));
        soup.material_of_triangle.resize(soup.triangles.size());
        soup = joined(soup, box_with_t_junctions(5, Eigen::Isometry3d::Identity()));
        soup.material_of_triangle.assign(soup.triangles.size(), 0);
        auto expected = testing::places(prepare_mesh(soup).facets);
        auto found = testing::places(prepare_mesh(testing::shuffled(soup, random)).facets);
        std::ranges::sort(expected);
        std::ranges::sort(found);
        EXPECT_EQ(found, expected);
    }
}

TEST(MeshPreparation, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    TriangleSoup soup = testing::shaken(
        unshared(testing::partly_turned(testing::bumpy_sphere(5, 0.03), 0.4, random)), 2e-6,
        random);
    soup = joined(soup, testing::random_soup(random, 500, 1e-4, 1e-5));
    soup = joined(soup, box_with_t_junctions(7, Eigen::Isometry3d::Identity()));
    const PreparedMesh one = prepare_mesh(soup, 1);
    for (const unsigned threads : {2U, 3U, 5U}) {
        const PreparedMesh other = prepare_mesh(soup, threads);
        ASSERT_EQ(other.facets.size(), one.facets.size());
        for (std::size_t i = 0; i < one.facets.size(); ++i) {
            ASSERT_EQ(other.facets[i].corners_m, one.facets[i].corners_m);
            ASSERT_EQ(other.facets[i].sides, one.facets[i].sides);
            ASSERT_EQ(other.facets[i].triangle, one.facets[i].triangle);
        }
        EXPECT_EQ(other.report.open_edges, one.report.open_edges);
        EXPECT_EQ(other.report.largest_move_m, one.report.largest_move_m);
    }
}

TEST(MeshPreparation, AccountsForEveryTriangle) {
    std::mt19937_64 random(1);
    for (int round = 0; round < 50; ++round) {
        TriangleSoup soup = testing::random_soup(random, 60, 2e-5, 2e-5);
        for (int i = 0; i < 40; ++i) { // repeated, turned, thin ones
            auto triangle = soup.triangles[random() % 60];
            std::ranges::shuffle(triangle, random);
            triangle[0] = i % 5 == 0 ? triangle[1] : triangle[0];
            soup.triangles.push_back(triangle);
            soup.material_of_triangle.push_back(0);
        }
        const PreparedMesh mesh = prepare_mesh(soup);
        const MeshReport &report = mesh.report;
        EXPECT_EQ(report.triangles_kept + report.degenerate_triangles + report.duplicate_triangles +
                      report.merged_triangles,
                  100U);
        EXPECT_EQ(report.left_out_of_material.front(),
                  report.degenerate_triangles + report.duplicate_triangles);
        std::set<std::uint32_t> kept;
        for (const FacetSource &facet : mesh.facets) {
            kept.insert(facet.triangle);
        }
        EXPECT_EQ(report.triangles_kept, kept.size());
    }
}

TEST(MeshPreparation, LeavesAMobiusStripTwoSided) {
    std::mt19937_64 random(1);
    TriangleSoup soup;
    soup.triangles = testing::twisted_strip(20, 1);
    for (int i = 0; i < 40; ++i) {
        soup.vertices_m.push_back(testing::random_vector(random, 0.1));
    }
    soup.material_of_triangle.assign(40, 0);
    soup.materials = {{"strip", 0.0}};
    const PreparedMesh mesh = prepare_mesh(soup);
    EXPECT_EQ(mesh.report.unorientable_components, 1U);
    EXPECT_EQ(mesh.report.flipped_triangles, 0U);
    EXPECT_TRUE(are_all(mesh, FacetSides::two));
}

TEST(MeshPreparation, SurvivesMalformedSoups) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    std::mt19937_64 random(1);
    TriangleSoup all_equal;
    TriangleSoup none_finite;
    TriangleSoup copies;
    for (int i = 0; i < 30000; ++i) {
        add_triangle(all_equal, {kLower_m, kLower_m, kLower_m});
        add_triangle(none_finite, {kLower_m, kUpper_m, Vector3(kNaN, 0.0, 0.0)});
        add_triangle(copies, {kLower_m, kUpper_m, Vector3::Zero()});
    }
    EXPECT_EQ(prepare_mesh(all_equal).report.degenerate_triangles, 30000U);
    EXPECT_EQ(prepare_mesh(none_finite).report.degenerate_triangles, 30000U);
    EXPECT_EQ(prepare_mesh(copies).report.duplicate_triangles, 29999U);
    EXPECT_EQ(prepare_mesh(copies).facets.size(), 1U);
    for (const double size_m : {1e300, 1e160, 1e20, 1e-300}) {
        const PreparedMesh mesh = prepare_mesh(testing::random_soup(random, 2000, size_m, size_m));
        for (const FacetSource &facet : mesh.facets) {
            EXPECT_GE(min_height_m(facet.corners_m), 1e-9);
        }
    }
}

std::vector<std::string> warnings(const TriangleSoup &soup) {
    return warnings_about(prepare_mesh(soup).report, soup.materials);
}

TEST(MeshWarnings, TellHowAMeshDiffersFromAClosedOne) {
    using Lines = std::vector<std::string>;
    const TriangleSoup box = box_soup(kLower_m, kUpper_m);
    EXPECT_EQ(warnings(box), Lines{});

    TriangleSoup with_needle = box;
    with_needle.materials.push_back({"needle", 0.0});
    with_needle.triangles.push_back({0, 0, 1});
    with_needle.material_of_triangle.push_back(1);
    EXPECT_EQ(warnings(with_needle), Lines{"node 'needle': 1 of 13 triangles cannot be touched: "
                                           "too thin, or duplicates of others"});
    TriangleSoup open = box;
    open.triangles.pop_back();
    open.material_of_triangle.pop_back();
    EXPECT_EQ(warnings(open), Lines{"1 of 1 surfaces are open: touched from both sides"});
    open.materials.front().sides = TouchSides::one; // so that it is not promised
    EXPECT_EQ(warnings(open), Lines{"1 of 1 surfaces are open: touched from both sides, unless "
                                    "their nodes specify otherwise"});
    EXPECT_EQ(warnings(testing::turned_inside_out(box)),
              Lines{"1 closed surfaces face inwards: touched from within only"});
}

TEST(MeshWarnings, TellWhatWasDone) {
    MeshReport report;
    report.graded_fans = {3, 0}; // none of them coarse
    EXPECT_TRUE(warnings_about(report, {}).empty());
    report.open_edges_given = 12;
    report.closed_cracks = 5;
    report.split_triangles = 2;
    report.largest_move_m = 1.23e-6;
    report.graded_fans.coarse = 2;
    report.merged_triangles = 2;
    report.flipped_triangles = 1;
    report.unorientable_components = 1;
    std::vector<std::string> expected = {
        "12 edges were open: closed by moving 5 vertices and dividing 2 triangles, with moves of "
        "up to 1.3 µm; none is open now",
        "2 fans have many triangles at one vertex: divided anew, within 1.0 µm",
        "2 triangles are given in both windings: touched from both sides",
        "1 triangle was wound opposite to neighbours: turned",
        "1 surface has no outside, like a Möbius strip: touched from both sides"};
    EXPECT_EQ(warnings_about(report, {}), expected);
    report.open_edges = 4;
    EXPECT_TRUE(warnings_about(report, {}).front().ends_with("; 4 are open now"));
}

} // namespace
} // namespace springdrive::contact
