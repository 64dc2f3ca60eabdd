// Covers engine/lab/rig/scenario/sphere_triangulation.cpp.
#include "engine/lab/rig/scenario/sphere_triangulation.h"

#include "tests/engine/lab/rig/scenario/soup_measures.h"

#include <gtest/gtest.h>

#include <random>

namespace springdrive::rig {
namespace {

SphereTriangulation grown(std::size_t points) {
    SphereTriangulation mesh;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> weight(0.01, 1.0);
    while (mesh.points().size() < points) {
        const auto triangle = static_cast<std::uint32_t>(random() % mesh.triangles().size());
        Vector3 direction = Vector3::Zero();
        for (const std::uint32_t corner : mesh.triangles()[triangle]) {
            direction += weight(random) * mesh.points()[corner];
        }
        mesh.insert(triangle, direction.normalized());
    }
    return mesh;
}

contact::TriangleSoup soup_of(const SphereTriangulation &mesh) {
    contact::TriangleSoup soup;
    soup.vertices_m = mesh.points();
    soup.triangles = mesh.triangles();
    return soup;
}

TEST(SphereTriangulation, StartsWithTheOctahedron) {
    const contact::TriangleSoup soup = soup_of(SphereTriangulation());
    EXPECT_EQ(soup.triangles.size(), 8U);
    EXPECT_TRUE(testing::is_closed(soup));
    EXPECT_NEAR(testing::volume_m3(soup), 4.0 / 3.0, 1e-15);
}

TEST(SphereTriangulation, IsClosedAndCoversTheSphereOnce) {
    const contact::TriangleSoup soup = soup_of(grown(1000));
    EXPECT_EQ(soup.triangles.size(), 2 * soup.vertices_m.size() - 4); // Euler
    EXPECT_TRUE(testing::is_closed(soup));
    for (const auto &[a, b, c] : soup.triangles) {
        EXPECT_GT(soup.vertices_m[a].cross(soup.vertices_m[b]).dot(soup.vertices_m[c]), 0.0);
    }
}

TEST(SphereTriangulation, NoPointIsWithinACircumscribedCircle) {
    const SphereTriangulation mesh = grown(600);
    for (const auto &[a, b, c] : mesh.triangles()) {
        const Vector3 from = mesh.points()[a];
        const Vector3 normal =
            (mesh.points()[b] - from).cross(mesh.points()[c] - from).normalized();
        for (const Vector3 &point : mesh.points()) {
            ASSERT_LT(normal.dot(point - from), 1e-10); // round-off, over small triangles
        }
    }
}

} // namespace
} // namespace springdrive::rig
