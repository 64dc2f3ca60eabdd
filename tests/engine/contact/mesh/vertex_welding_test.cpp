// Covers engine/contact/mesh/vertex_welding.cpp and vertex_grid.cpp.
#include "engine/contact/mesh/vertex_welding.h"

#include "tests/engine/contact/mesh/soups.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace springdrive::contact {
namespace {

using testing::random_direction;
using testing::random_vector;

constexpr double kWeldTolerance_m = 1e-7;

std::vector<std::uint32_t> welded(const std::vector<Vector3> &vertices_m, double tolerance_m) {
    PreparationAllowance allowance(vertices_m.size());
    return weld_vertices(vertices_m, tolerance_m, allowance);
}

TEST(VertexWelding, KeepsVerticesThatAreFarApart) {
    const std::vector<Vector3> vertices = {{0, 0, 0}, {3e-7, 0, 0}, {0, -3e-7, 0}, {0, 0, 1}};
    const std::vector<std::uint32_t> expected = {0, 1, 2, 3};
    EXPECT_EQ(welded(vertices, kWeldTolerance_m), expected);
}

TEST(VertexWelding, FindsPositiveAndNegativeZeroEqual) {
    const std::vector<Vector3> vertices = {{0.0, 0.0, 0.0}, {-0.0, -0.0, -0.0}};
    EXPECT_EQ(welded(vertices, kWeldTolerance_m)[1], 0U);
}

TEST(VertexWelding, MovesNoVertexByMoreThanTheToleranceAlongAChain) {
    std::vector<Vector3> chain;
    chain.reserve(100);
    for (int i = 0; i < 100; ++i) {
        chain.emplace_back(0.7 * kWeldTolerance_m * i, 0.0, 0.0);
    }
    const std::vector<std::uint32_t> stands_for = welded(chain, kWeldTolerance_m);
    for (std::size_t i = 0; i < chain.size(); ++i) {
        EXPECT_LE((chain[stands_for[i]] - chain[i]).norm(), kWeldTolerance_m);
    }
}

TEST(VertexWelding, FindsTheCopiesOfScatteredVerticesWhereverTheyLie) {
    std::mt19937_64 random(1);
    constexpr std::uint32_t kCount = 20000;
    std::vector<Vector3> vertices;
    for (std::uint32_t i = 0; i < kCount; ++i) {
        vertices.push_back(random_vector(random, 0.1)); // some 1e-3 m apart: never a pair
    }
    for (std::uint32_t i = 0; i < kCount; ++i) {
        vertices.emplace_back(vertices[i] + 0.99 * kWeldTolerance_m * random_direction(random));
    }
    const std::vector<std::uint32_t> stands_for = welded(vertices, kWeldTolerance_m);
    for (std::uint32_t i = 0; i < kCount; ++i) {
        ASSERT_EQ(stands_for[i], i);
        ASSERT_EQ(stands_for[kCount + i], i);
    }
}

TEST(VertexWelding, IsTheSameForAnyNumberOfThreads) {
    std::mt19937_64 random(1);
    std::vector<Vector3> vertices;
    vertices.reserve(3000);
    for (int i = 0; i < 3000; ++i) {
        vertices.push_back(random_vector(random, 1e-6));
    }
    PreparationAllowance allowance(vertices.size());
    const std::vector<std::uint32_t> one = welded(vertices, kWeldTolerance_m);
    EXPECT_EQ(weld_vertices(vertices, kWeldTolerance_m, allowance, 2), one);
    EXPECT_EQ(weld_vertices(vertices, kWeldTolerance_m, allowance, 5), one);
}

TEST(VertexWelding, LeavesVerticesThatAreNotFiniteAlone) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const std::vector<Vector3> vertices = {
        {kNaN, 0, 0}, {kNaN, 0, 0}, {kInfinity, 0, 0}, {0, 0, 1e300}, {0, 0, 1e300}};
    const std::vector<std::uint32_t> expected = {0, 1, 2, 3, 3};
    EXPECT_EQ(welded(vertices, kWeldTolerance_m), expected);
}

} // namespace
} // namespace springdrive::contact
