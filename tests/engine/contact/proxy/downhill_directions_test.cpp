// Covers engine/contact/proxy/downhill_directions.cpp.
#include "engine/contact/proxy/downhill_directions.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace springdrive::contact {
namespace {

constexpr double kVertex_m = 3e-8;
constexpr double kLength_m = 3e-7;

/// Four triangles about the origin: edges to +x and −x lead up, those to +z and −z down.
TriangleSoup saddle() {
    TriangleSoup soup;
    const std::vector<Vector3> rim{
        {1e-3, 1e-4, 0}, {0, -1e-4, 1e-3}, {-1e-3, 1e-4, 0}, {0, -1e-4, -1e-3}};
    for (std::size_t i = 0; i < rim.size(); ++i) {
        testing::add_triangle(soup, {Vector3::Zero(), rim[(i + 1) % rim.size()], rim[i]});
    }
    return soup;
}

std::vector<Vector3> directions(const TriangleSoup &soup, const Vector3 &point_m,
                                const Vector3 &target_m) {
    const HapticSurface surface(soup);
    Neighbourhood near;
    SearchBudget budget{1000};
    surface.find_near(point_m, 1e-3, budget, near);
    const DownhillDirections found =
        downhill_directions(surface, near, point_m, target_m, kVertex_m, kLength_m);
    return {found.begin(), found.end()};
}

TEST(DownhillDirections, LeadTowardsTheTargetAlongFacetsAndEdges) {
    const Vector3 target_m(0, -2e-3, 0);
    const std::vector<Vector3> found = directions(saddle(), {0, 1e-8, 0}, target_m);
    // One for each of the four facets, and each edge that leads down, from both of its facets.
    EXPECT_EQ(found.size(), 8U);
    for (const Vector3 &direction : found) {
        EXPECT_NEAR(direction.norm(), 1.0, 1e-15);
        EXPECT_GT(direction.dot(target_m), 0.0);
    }
    const Vector3 down = Vector3(0, -1e-4, 1e-3).normalized();
    EXPECT_EQ(std::ranges::count_if(
                  found, [&](const Vector3 &one) { return (one - down).norm() < 1e-14; }),
              2);
    const Vector3 up = Vector3(1e-3, 1e-4, 0).normalized();
    EXPECT_TRUE(
        std::ranges::none_of(found, [&](const Vector3 &one) { return (one - up).norm() < 1e-6; }));
}

TEST(DownhillDirections, LeaveOutWhatIsFarAndWhatEnds) {
    EXPECT_TRUE(directions(saddle(), {0, 1e-4, 0}, {0, -2e-3, 0}).empty());
    // Beside an edge, a facet only: the edge that is passed there leads both ways.
    const Vector3 on_edge_m = 0.5 * Vector3(0, -1e-4, 1e-3) + Vector3(0, 1e-8, 0);
    EXPECT_EQ(directions(saddle(), on_edge_m, {0, -2e-3, 0.5e-3}).size(), 4U);
    // At the end of an edge nothing leads on along it.
    const Vector3 end_m = Vector3(0, -1e-4, 1e-3) + Vector3(0, 1e-8, 0);
    const std::vector<Vector3> found = directions(saddle(), end_m, {0, -2e-3, 5e-3});
    const Vector3 along = Vector3(0, -1e-4, 1e-3).normalized();
    EXPECT_TRUE(std::ranges::none_of(
        found, [&](const Vector3 &one) { return (one - along).norm() < 1e-9; }));
}

} // namespace
} // namespace springdrive::contact
