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
                                const Vector3 &target_m, const ContactPlanes &planes = {}) {
    const HapticSurface surface(soup);
    Neighbourhood near;
    SearchBudget budget{1000};
    surface.find_near(point_m, 1e-3, budget, near);
    const DownhillDirections found = downhill_directions(
        surface, near, point_m, target_m, kVertex_m, MotionsAbove(planes, point_m, kLength_m));
    return {found.begin(), found.end()};
}

bool has(const std::vector<Vector3> &directions, const Vector3 &wanted) {
    return std::ranges::any_of(directions, [&](const Vector3 &direction) {
        return (direction - wanted.normalized()).norm() < 1e-9;
    });
}

TEST(DownhillDirections, LeadAlongEdgesWhereEveryFacetLeadsToTheNext) {
    const Vector3 target_m(0, -2e-3, 0);
    const std::vector<Vector3> found = directions(saddle(), {0, 1e-8, 0}, target_m);
    EXPECT_EQ(found.size(), 2U);
    EXPECT_TRUE(has(found, {0, -1e-4, 1e-3}));
    EXPECT_TRUE(has(found, {0, -1e-4, -1e-3}));
    for (const Vector3 &direction : found) {
        EXPECT_NEAR(direction.norm(), 1.0, 1e-15);
        EXPECT_GT(direction.dot(target_m), 0.0);
    }
}

TEST(DownhillDirections, LeadAcrossTheFacetThatTheTargetIsUnder) {
    const Vector3 target_m(2e-3, -2e-3, 2e-3);
    const std::vector<Vector3> found = directions(saddle(), {0, 1e-8, 0}, target_m);
    const Vector3 normal = Vector3(0, -1e-4, 1e-3).cross(Vector3(1e-3, 1e-4, 0)).normalized();
    const Vector3 to_target_m = target_m - Vector3(0, 1e-8, 0);
    EXPECT_TRUE(has(found, to_target_m - normal.dot(to_target_m) * normal));
    EXPECT_TRUE(has(found, {1e-3, 1e-4, 0}));
    EXPECT_TRUE(has(found, {0, -1e-4, 1e-3}));
    EXPECT_EQ(found.size(), 3U);
}

TEST(DownhillDirections, LeaveOutWhatLeadsBelowAPlane) {
    ContactPlanes planes;
    planes.add({Vector3::UnitZ(), 0.0, 0});
    const std::vector<Vector3> found = directions(saddle(), {0, 1e-8, 0}, {0, -2e-3, 0}, planes);
    EXPECT_EQ(found.size(), 1U);
    EXPECT_TRUE(has(found, {0, -1e-4, 1e-3}));
}

TEST(DownhillDirections, LeadOverTheRim) {
    TriangleSoup soup;
    testing::add_triangle(soup, {Vector3(0, 0, -1e-3), Vector3(0, 0, 1e-3), Vector3(1e-3, 0, 0)});
    const std::vector<Vector3> found = directions(soup, {0, 1e-8, 0}, {-1e-3, -1e-3, 0});
    EXPECT_TRUE(has(found, -Vector3::UnitX()));
}

TEST(DownhillDirections, AreNoneInAPit) {
    TriangleSoup soup;
    const std::vector<Vector3> rim{
        {1e-3, 1e-4, 0}, {0, 2e-4, 1e-3}, {-1e-3, 1e-4, 0}, {0, 3e-4, -1e-3}};
    for (std::size_t i = 0; i < rim.size(); ++i) {
        testing::add_triangle(soup, {Vector3::Zero(), rim[(i + 1) % rim.size()], rim[i]});
    }
    EXPECT_TRUE(directions(soup, {0, 1.5e-8, 0}, {1e-5, -2e-3, 1e-5}).empty());
}

TEST(DownhillDirections, LeaveOutWhatIsFarAndWhatEnds) {
    EXPECT_TRUE(directions(saddle(), {0, 1e-4, 0}, {0, -2e-3, 0}).empty());
    // Halfway along an edge it leads on.
    const Vector3 on_edge_m = 0.5 * Vector3(0, -1e-4, 1e-3) + Vector3(0, 1e-8, 0);
    EXPECT_EQ(directions(saddle(), on_edge_m, {0, -2e-3, 0.5e-3}).size(), 1U);
    // At the end of an edge nothing leads on along it.
    const Vector3 end_m = Vector3(0, -1e-4, 1e-3) + Vector3(0, 1e-8, 0);
    const std::vector<Vector3> found = directions(saddle(), end_m, {0, -2e-3, 5e-3});
    EXPECT_FALSE(has(found, {0, -1e-4, 1e-3}));
}

} // namespace
} // namespace springdrive::contact
