// What callers owe: functions with a precondition let through what just meets it, and stop at what
// just does not. The dear ones look in builds for debugging alone, as under the sanitizers.
#include "base/sha256.h"
#include "device/core/split_delay.h"
#include "engine/contact/bvh/box_tree_build.h"
#include "engine/contact/mesh/facet.h"
#include "engine/contact/mesh/mesh_stitching.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/mesh/vertex_search.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/proxy_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace springdrive {
namespace {

using namespace contact;

const Eigen::AlignedBox3d kUnitBox(Vector3(0.0, 0.0, 0.0), Vector3(1.0, 1.0, 1.0));

FacetSource triangle_up_to(double x_m) {
    FacetSource source;
    source.corners_m = {Vector3::Zero(), Vector3::UnitY(), Vector3(x_m, 0.0, 0.0)};
    return source;
}

TEST(PreconditionsDeathTest, OfOneNumber) {
    EXPECT_EQ(device::split_delay(0.0).whole, 0);
    EXPECT_DEATH(static_cast<void>(device::split_delay(-1e-300)),
                 "delay_periods >= 0.0, device/core/split_delay.h:");
    EXPECT_DEATH(static_cast<void>(device::split_delay(std::nan(""))), "delay_periods >= 0.0");

    PreparationAllowance allowance(1);
    const auto weld = [&allowance](double tolerance_m, unsigned threads) {
        return weld_vertices({Vector3::Zero()}, tolerance_m, allowance, threads).size();
    };
    EXPECT_EQ(weld(1e-300, 1), 1U);
    EXPECT_DEATH(static_cast<void>(weld(0.0, 1)), "tolerance_m > 0.0");
    EXPECT_DEATH(static_cast<void>(weld(1.0, 0)), "threads > 0");

    const std::uint32_t end = std::uint32_t{1} << 30U;
    EXPECT_EQ(NumberedBox(kUnitBox, end - 1).number(), end - 1);
    EXPECT_DEATH(NumberedBox(kUnitBox, end), "engine/contact/bvh/box_tree_build.cpp:");

    EXPECT_DEATH(TriangleSets(kMaxTriangles + 1), "count <= kMaxTriangles");
}

TEST(PreconditionsDeathTest, OfTwoNumbers) {
    const std::vector<Vector3> vertices_m{Vector3::Zero()};
    static_cast<void>(VertexGrid(vertices_m, 0.5, 1.0));
    EXPECT_DEATH(VertexGrid(vertices_m, 0.5, std::nextafter(1.0, 0.0)),
                 "cell_m >= 2.0 \\* reach_m");
}

TEST(PreconditionsDeathTest, OfWhatHasRoom) {
    ProxyPath path;
    path.restart(Vector3::Zero());
    while (path.size() < ProxyPath::kCapacity) {
        path.add(Vector3::UnitX());
    }
    EXPECT_EQ(path[ProxyPath::kCapacity - 1], Vector3::UnitX());
    EXPECT_DEATH(path.add(Vector3::UnitX()),
                 "size_ < kCapacity, engine/contact/proxy/proxy_solver.h");

    FacetSource source = triangle_up_to(1.0);
    source.sides = FacetSides::two;
    const Facet sheet(source); // which takes two places
    Neighbourhood near;
    near.begin(1, Vector3::Zero());
    for (int i = 0; i < Neighbourhood::kCapacity; i += 2) {
        near.add(0, sheet);
    }
    EXPECT_EQ(near.size(), Neighbourhood::kCapacity);
    EXPECT_DEATH(near.add(0, sheet), "<= kCapacity, engine/contact/proxy/haptic_surface.cpp");
}

TEST(PreconditionsDeathTest, OfWhatMustNotBeOver) {
    Sha256 sha256;
    sha256.add(1.0);
    EXPECT_EQ(sha256.hex().size(), 64U);
    EXPECT_DEATH(sha256.add(1.0), "is_complete");
    EXPECT_DEATH(static_cast<void>(sha256.hex()), "is_complete");
}

TEST(PreconditionsDeathTest, OfAFacetWithAnArea) {
    EXPECT_EQ(Facet(triangle_up_to(1e-6)).normal(), -Vector3::UnitZ());
    EXPECT_DEATH(Facet(triangle_up_to(0.0)), "engine/contact/mesh/facet.cpp");
}

// The dear ones.

const std::vector<MeshTriangle> kTwoTriangles{{{0, 1, 2}, 0, false}, {{2, 1, 3}, 1, false}};

TEST(PreconditionsDeathTest, WhatIsLookedAtInDebugBuildsLetsThroughWhatMeetsIt) {
    EXPECT_EQ(EdgeTable(kTwoTriangles, 4, 1).uses_of(1, 2).size(), 2U);
    EXPECT_EQ(lay_out_boxes(std::vector{kUnitBox, kUnitBox}, 1).order.size(), 2U);
    const std::vector<Vector3> vertices_m{Vector3::Zero(), Vector3::Zero()};
    VertexGrid grid(vertices_m, 0.5, 1.0);
    grid.insert(0);
    grid.insert(1); // in the same cell
    const AnalyticShape sphere(Sphere{0.01}, Eigen::Isometry3d::Identity(), 0);
    EXPECT_EQ(sphere.nearest(Vector3::UnitX()).normal, Vector3::UnitX());
}

#if SPRINGDRIVE_AUDIT
TEST(PreconditionsDeathTest, WhatIsLookedAtInDebugBuildsStopsAtWhatDoesNot) {
    std::vector<MeshTriangle> triangles = kTwoTriangles;
    EXPECT_DEATH(EdgeTable(triangles, 3, 1), "engine/contact/mesh/mesh_topology.cpp");
    triangles.back().vertices = {2, 1, 2};
    EXPECT_DEATH(EdgeTable(triangles, 4, 1), "engine/contact/mesh/mesh_topology.cpp");

    const auto lay_out = [](const Eigen::AlignedBox3d &second) {
        static_cast<void>(lay_out_boxes(std::vector{kUnitBox, second}, 1));
    };
    EXPECT_DEATH(lay_out(Eigen::AlignedBox3d()), "isEmpty");
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_DEATH(lay_out({Vector3::Zero(), Vector3(1.0, infinity, 1.0)}), "allFinite");

    const std::vector<Vector3> vertices_m{Vector3::Zero()};
    VertexGrid grid(vertices_m, 0.5, 1.0);
    grid.insert(0);
    EXPECT_DEATH(grid.insert(0), "engine/contact/mesh/vertex_search.h");

    const AnalyticShape sphere(Sphere{0.01}, Eigen::Isometry3d::Identity(), 0);
    EXPECT_DEATH(static_cast<void>(sphere.nearest(Vector3(0.0, std::nan(""), 0.0))), "allFinite");

    EXPECT_EQ(Facet(triangle_up_to(2e-15)).normal(), -Vector3::UnitZ());
    EXPECT_DEATH(Facet(triangle_up_to(1e-16)), "kRoundOff_m");
}
#endif

} // namespace
} // namespace springdrive
