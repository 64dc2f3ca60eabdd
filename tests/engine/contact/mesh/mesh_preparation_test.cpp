// Covers engine/contact/mesh/mesh_preparation.cpp and mesh_report.cpp.
#include "base/cancellation.h"
#include "base/input_error.h"
#include "engine/contact/mesh/fan_grading.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/mesh_report.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>

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

TEST(MeshPreparation, RefusesWhatNoTipReaches) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    for (const double x_m : {-1e4, -1e3, -999.0, 999.0, 1e3, 1e4, 1e300, kInfinite, double{NAN}}) {
        TriangleSoup soup = box_soup(kLower_m, kUpper_m);
        soup.vertices_m[5].x() = x_m;
        if (std::isfinite(x_m) && std::abs(x_m) >= 1e3) {
            try {
                static_cast<void>(prepare_mesh(soup));
                ADD_FAILURE() << x_m;
            } catch (const InputError &refusal) {
                EXPECT_NE(std::string(refusal.what()).find("vertex 5 "), std::string::npos);
            }
        } else {
            EXPECT_GT(prepare_mesh(soup).report.triangles_kept, 0U) << x_m; // not finite: left out
        }
    }
}

TEST(MeshPreparation, ClosesASphereOfPerturbedTriangles) {
    std::mt19937_64 random(1);
    for (int level = 2; level <= 6; ++level) {
        const TriangleSoup sphere = testing::icosphere(level, 0.03);
        const PreparedMesh mesh = prepare_mesh(testing::shaken(unshared(sphere), 1e-6, random));
        EXPECT_TRUE(testing::is_watertight(testing::place_keys(mesh.facets)));
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
    EXPECT_TRUE(testing::is_watertight(testing::place_keys(turned.facets)));
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
    EXPECT_EQ(merged.report.merged_triangles, sphere.triangles.size());
    EXPECT_EQ(merged.report.inward_components, 0U);
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
        EXPECT_TRUE(testing::is_watertight(testing::place_keys(mesh.facets)));
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
        auto expected = testing::place_keys(prepare_mesh(soup).facets);
        auto found = testing::place_keys(prepare_mesh(testing::shuffled(soup, random)).facets);
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
    for (const double size_m : {450.0, 1e-300}) { // larger: refused
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

using testing::area_m2;

/// A surface around a vertex, r(φ) (cos φ, h(φ), sin φ) at its rim, turned and moved at random.
struct RimShape {
    double radius_m = 5e-3;
    double jagged = 0.0; ///< by which part of it r may be smaller
    double slope = 0.0;  ///< of h, the same everywhere
    double wave = 0.0;   ///< of h, twice around
    double rough = 0.0;  ///< of h, at random
    double turn = 2.0 * std::numbers::pi;
};

struct Given {
    std::vector<MeshTriangle> triangles;
    std::vector<FacetSource> facets;
    std::size_t vertices = 0;
    Vector3 apex_m{Vector3::Zero()};
};

Given fan_of(std::uint32_t count, const RimShape &shape, std::mt19937_64 &random) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const Matrix3 turn =
        Eigen::AngleAxisd(6.0 * part(random), testing::random_vector(random, 1.0).normalized())
            .toRotationMatrix();
    const Vector3 apex_m = testing::random_vector(random, 0.1);
    const bool is_closed = shape.turn > 6.0;
    std::vector<Vector3> rim_m;
    for (std::uint32_t i = 0; i < count + (is_closed ? 0 : 1); ++i) {
        const double phi = shape.turn * i / count;
        const double out_m = shape.radius_m * (1.0 - shape.jagged * part(random));
        const double height =
            shape.slope + shape.wave * std::cos(2.0 * phi) + shape.rough * part(random);
        rim_m.emplace_back(apex_m + out_m * (turn * Vector3(std::cos(phi), height, std::sin(phi))));
    }
    Given given;
    given.apex_m = apex_m;
    given.vertices = rim_m.size() + 1;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto next = static_cast<std::uint32_t>((i + 1) % rim_m.size());
        // Each begins at another of its corners.
        VertexTriple vertices = {0, 1 + next, 1 + i};
        Corners corners_m = {apex_m, rim_m[next], rim_m[i]};
        std::rotate(vertices.begin(), vertices.begin() + i % 3, vertices.end());
        std::rotate(corners_m.begin(), corners_m.begin() + i % 3, corners_m.end());
        given.triangles.push_back({vertices, i});
        given.facets.push_back({corners_m, FacetSides::two, i});
    }
    return given;
}

double nearest_m(const Vector3 &point_m, const std::vector<FacetSource> &facets) {
    double min_m = INFINITY;
    for (const FacetSource &facet : facets) {
        min_m = std::min(min_m, testing::distance_to_triangle(facet.corners_m, point_m));
    }
    return min_m;
}

Vector3 middle_m(const FacetSource &facet) {
    return (facet.corners_m[0] + facet.corners_m[1] + facet.corners_m[2]) / 3.0;
}

/// From a point of one of the facets to the nearest of others.
double distance_m(const FacetSource &facet, const std::vector<FacetSource> &others,
                  std::mt19937_64 &random) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    Vector3 weights(part(random), part(random), part(random));
    weights = weights.array().pow(3.0); // often near a corner or an edge
    weights /= weights.sum();
    const Vector3 point_m = weights[0] * facet.corners_m[0] + weights[1] * facet.corners_m[1] +
                            weights[2] * facet.corners_m[2];
    return nearest_m(point_m, others);
}

std::size_t count_at(const Vector3 &point_m, const std::vector<FacetSource> &facets) {
    return static_cast<std::size_t>(std::ranges::count_if(facets, [&](const FacetSource &facet) {
        return std::ranges::find(facet.corners_m, point_m) != facet.corners_m.end();
    }));
}

/// Each edge as often in one direction as it is used, less how often in the other.
using EdgeBalance = std::map<std::array<double, 6>, int>;

EdgeBalance edge_balance(const std::vector<FacetSource> &facets) {
    EdgeBalance balance;
    const auto key = [](const Vector3 &a, const Vector3 &b) {
        return std::array{a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
    };
    for (const FacetSource &facet : facets) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &from = facet.corners_m[i];
            const Vector3 &to = facet.corners_m[(i + 1) % 3];
            ++balance[key(from, to)];
            --balance[key(to, from)];
        }
    }
    std::erase_if(balance, [](const auto &edge) { return edge.second == 0; });
    return balance;
}

const std::vector<RimShape> kSmooth = {
    {.jagged = 0.5}, // flat, as of a cap with any outline
    {.slope = 0.3},  // as of a pole
    {.slope = -2.0}, {.wave = 0.2}, {.slope = 0.1, .turn = 2.5}, {.radius_m = 1e-4, .slope = 0.5},
};

TEST(FanGrading, KeepsWhereSmoothFansAreWithFewTrianglesAtTheVertex) {
    std::mt19937_64 random(1);
    for (const RimShape &shape : kSmooth) {
        for (const std::uint32_t count : {100U, 333U, 1500U}) {
            Given given = fan_of(count, shape, random);
            const std::vector<FacetSource> before = given.facets;
            const GradedFans graded = grade_fans(given.facets, given.triangles, {}, given.vertices);
            ASSERT_EQ(graded.all, 1U) << shape.slope << " " << count;
            EXPECT_LE(graded.coarse, count >= kMinGradedFan ? 1U : 0U)
                << shape.slope << " " << count;
            EXPECT_LE(count_at(given.apex_m, given.facets), std::min(52U, (count + 1) / 2))
                << shape.slope << " " << count;
            EXPECT_LE(given.facets.size(), 9 * count);
            // Round-off of points within 0.2 m.
            const double allowed_m =
                (graded.coarse == 0 ? kGradingError_m : kCoarseGradingError_m) + 1e-15;
            for (int i = 0; i < 40; ++i) {
                ASSERT_LE(distance_m(before[random() % before.size()], given.facets, random),
                          allowed_m);
                ASSERT_LE(distance_m(given.facets[random() % given.facets.size()], before, random),
                          allowed_m);
            }
        }
    }
}

/// What is left of its edges, without those that two triangles share, is that of the given fan.
TEST(FanGrading, LeavesNoGaps) {
    std::mt19937_64 random(2);
    for (const RimShape &shape : kSmooth) {
        if (shape.turn < 6.0) {
            continue; // its first and last spoke are divided
        }
        for (const std::uint32_t count : {97U, 128U, 1024U}) {
            Given given = fan_of(count, shape, random);
            const EdgeBalance before = edge_balance(given.facets);
            const double area_before_m2 = area_m2(given.facets);
            ASSERT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
            EXPECT_EQ(edge_balance(given.facets), before);
            EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-3 * area_before_m2);
        }
    }
}

TEST(FanGrading, NamesTheTriangleBelow) {
    std::mt19937_64 random(3);
    Given given = fan_of(200, {.slope = 0.2}, random);
    const std::vector<FacetSource> before = given.facets;
    ASSERT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
    for (const FacetSource &facet : given.facets) {
        const double distance =
            testing::distance_to_triangle(before[facet.triangle].corners_m, middle_m(facet));
        // Next to it, where it lies on several.
        EXPECT_LT(distance, 0.3 * (middle_m(facet) - given.apex_m).norm());
    }
}

/// So rough that no two of its triangles may become one: that changes only what is within a
/// micrometre of its vertex.
TEST(FanGrading, MakesRoughFansCoarseAtTheirVertexOnly) {
    std::mt19937_64 random(8);
    for (const RimShape &shape : {RimShape{.rough = 0.2}, RimShape{.jagged = 0.5, .rough = 1.0},
                                  RimShape{.radius_m = 1e-4, .rough = 0.2}}) {
        for (const std::uint32_t count : {49U, 300U, 1024U}) {
            Given given = fan_of(count, shape, random);
            const std::vector<FacetSource> before = given.facets;
            const EdgeBalance edges_before = edge_balance(given.facets);
            const GradedFans graded = grade_fans(given.facets, given.triangles, {}, given.vertices);
            ASSERT_EQ(graded.all, 1U);
            EXPECT_EQ(graded.coarse, 1U);
            EXPECT_EQ(edge_balance(given.facets), edges_before);
            EXPECT_LE(count_at(given.apex_m, given.facets), 12U);
            std::size_t changed = 0;
            for (const FacetSource &facet : given.facets) {
                const bool is_near =
                    std::ranges::all_of(facet.corners_m, [&](const Vector3 &corner_m) {
                        return (corner_m - given.apex_m).norm() <= 0.5 * kCoarseGradingError_m;
                    });
                changed += is_near ? 1 : 0;
                if (!is_near && changed % 10 == 0) {
                    // In the plane of a given one, but for round-off of corners within 0.2 m.
                    ASSERT_LE(nearest_m(middle_m(facet), before), 1e-15);
                }
            }
            EXPECT_GT(changed, 12U);
        }
    }
}

TEST(FanGrading, LeavesSmallFans) {
    std::mt19937_64 random(4);
    Given small = fan_of(static_cast<std::uint32_t>(kMinGradedFan - 1), {}, random);
    EXPECT_EQ(grade_fans(small.facets, small.triangles, {}, small.vertices).all, 0U);
    EXPECT_TRUE(std::ranges::none_of(small.facets, &FacetSource::is_crowded));
}

/// A third triangle stands on one of the spokes. It belongs to another, larger fan, which has its
/// own vertex; the spoke stays, so that nothing passes below it.
TEST(FanGrading, KeepsASpokeOnWhichAThirdTriangleStands) {
    std::mt19937_64 random(9);
    Given given = fan_of(2001, {.slope = -0.3}, random);
    const std::size_t own = given.facets.size();
    const std::uint32_t foot = 1 + 751; // at the rim, and dissolved without the third triangle
    const Vector3 foot_m = given.facets[751].corners_m[1]; // begins at its second
    const Vector3 spoke_m = foot_m - given.apex_m;
    const auto top = static_cast<std::uint32_t>(given.vertices++);
    const Vector3 top_m = given.apex_m + spoke_m + 5e-3 * spoke_m.unitOrthogonal();
    const auto add = [&](const VertexTriple &vertices, const Corners &corners_m) {
        given.triangles.push_back({vertices, static_cast<std::uint32_t>(given.facets.size())});
        given.facets.push_back(
            {corners_m, FacetSides::two, static_cast<std::uint32_t>(given.facets.size())});
    };
    add({0, foot, top}, {given.apex_m, foot_m, top_m});
    Vector3 last_m = top_m + Vector3(1e-3, 0.0, 0.0);
    for (std::uint32_t i = 0; i < 2100; ++i) { // the larger fan
        const double phi = 2.0 * std::numbers::pi * (i + 1) / 2100;
        const Vector3 next_m = top_m + 1e-3 * Vector3(std::cos(phi), std::sin(phi), 0.0);
        const auto first = static_cast<std::uint32_t>(given.vertices++);
        add({top, first, first + 1}, {top_m, last_m, next_m});
        last_m = next_m;
    }
    ++given.vertices;
    ASSERT_LT(testing::distance_to_triangle(given.facets[750].corners_m, foot_m), 1e-15);
    EXPECT_GE(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 2U);
    std::erase_if(given.facets, [&](const FacetSource &facet) { return facet.triangle >= own; });
    for (double share = 0.001; share < 1.0; share *= 1.3) {
        // Round-off of corners within 0.2 m.
        EXPECT_LE(nearest_m(given.apex_m + share * spoke_m, given.facets), 1e-15) << share;
    }
}

TEST(FanGrading, KeepsMaterialsApart) {
    std::mt19937_64 random(5);
    Given given = fan_of(200, {}, random);
    for (std::size_t i = 0; i < 100; ++i) {
        given.facets[i].material = 1;
    }
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 2U);
    std::array<std::vector<FacetSource>, 2> of_material;
    for (const FacetSource &facet : given.facets) {
        of_material[facet.material].push_back(facet);
    }
    EXPECT_NEAR(area_m2(of_material[0]), area_m2(of_material[1]), 1e-9 * area_m2(of_material[0]));
}

/// As CAD systems divide a round face: from a vertex of its outline, so that the first and the last
/// triangles are small.
TEST(FanGrading, GradesAFanFromAVertexOfItsOutline) {
    constexpr std::uint32_t kCount = 3000;
    constexpr double kRadius_m = 5e-3;
    Given given;
    const auto rim_m = [&](std::uint32_t i) {
        const double phi = 2.0 * std::numbers::pi * i / (kCount + 2);
        return Vector3(kRadius_m * std::cos(phi), 0.02, kRadius_m * std::sin(phi));
    };
    given.apex_m = rim_m(0);
    given.vertices = kCount + 2;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        given.triangles.push_back({{0, i + 2, i + 1}, i});
        given.facets.push_back({{given.apex_m, rim_m(i + 2), rim_m(i + 1)}, FacetSides::one, i});
    }
    const double area_before_m2 = area_m2(given.facets);
    const std::vector<FacetSource> before = given.facets;
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {}, given.vertices).all, 1U);
    EXPECT_LE(count_at(given.apex_m, given.facets), 250U);
    EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-9 * area_before_m2);
    std::mt19937_64 random(7);
    for (int i = 0; i < 100; ++i) {
        ASSERT_LE(distance_m(before[random() % before.size()], given.facets, random), 1e-15);
    }
}

/// One fan alone may take seconds.
TEST(FanGrading, CanBeGivenUpWithinAFan) {
    std::mt19937_64 random(8);
    const Given given = fan_of(300, {.rough = 0.04}, random);
    auto by_vertex = find_fan_triangles(given.triangles, {}, given.vertices, kMinGradedFan);
    ASSERT_EQ(by_vertex.size(), 1U);
    const std::vector<TriangleFan> fans = fans_of(by_vertex[0], given.facets);
    ASSERT_EQ(fans.size(), 1U);
    EXPECT_FALSE(rings_of(fans[0]).triangles.empty());
    const std::atomic<bool> is_cancelled{true};
    const StopScope by(&is_cancelled);
    EXPECT_THROW(static_cast<void>(rings_of(fans[0])), Cancelled);
    EXPECT_THROW(static_cast<void>(fans_of(by_vertex[0], given.facets)), Cancelled);
}

/// A triangle that was left out does not shift those that follow.
TEST(FanGrading, AllowsForTrianglesLeftOut) {
    std::mt19937_64 random(6);
    Given given = fan_of(120, {}, random);
    given.facets.erase(given.facets.begin() + 7);
    const double area_before_m2 = area_m2(given.facets);
    const EdgeBalance before = edge_balance(given.facets);
    EXPECT_EQ(grade_fans(given.facets, given.triangles, {7}, given.vertices).all, 1U);
    EXPECT_NEAR(area_m2(given.facets), area_before_m2, 1e-9 * area_before_m2);
    for (const auto &[edge, uses] : before) {
        const Vector3 from(edge[0], edge[1], edge[2]);
        const Vector3 to(edge[3], edge[4], edge[5]);
        if (from != given.apex_m && to != given.apex_m) {
            EXPECT_TRUE(edge_balance(given.facets).contains(edge));
        }
    }
}

} // namespace
} // namespace springdrive::contact
