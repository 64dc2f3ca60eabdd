// Covers engine/scene/curved_patches.cpp as it is felt: 80 triangles, smoothed, under a proxy.
#include "engine/scene/curved_patches.h"

#include "base/degrees.h"
#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::scene {
namespace {

constexpr double kSphereRadius_m = 0.05;

/// 80 triangles with the normals of a sphere, cut as finely as scenes are.
contact::HapticSurface smoothed_sphere() {
    contact::TriangleSoup soup = testing::icosphere(1, kSphereRadius_m);
    SmoothMesh coarse{soup.vertices_m, {}, soup.triangles};
    for (const Vector3 &vertex : coarse.positions) {
        coarse.normals.push_back(vertex.normalized());
    }
    const CurvedPatches patches(coarse);
    const SmoothMesh fine =
        patches.cut(patches.cuts_for(0.5 * kRadiansPerDegree, 128), 0, coarse.triangles.size());
    soup.vertices_m = fine.positions;
    soup.triangles = fine.triangles;
    soup.material_of_triangle.assign(fine.triangles.size(), 0);
    return contact::HapticSurface(soup);
}

Vector3 direction(double t) {
    return Vector3(std::sin(t + 0.3), std::sin(1.31 * t + 1.1), 1.2 * std::sin(1.73 * t) + 0.01)
        .normalized();
}

TEST(CurvedTouch, TurnsTheForceByLessThanADegreeATickOnEightyTriangles) {
    const contact::HapticSurface surface = smoothed_sphere();
    ASSERT_EQ(surface.report().closed_components, 1U);
    contact::Proxy proxy;
    proxy.reset(1.2 * kSphereRadius_m * direction(0.0));
    double phase = 0.0;
    Vector3 last = Vector3::Zero();
    double largest_rad = 0.0;
    for (int i = 0; i < 50000; ++i) {
        const Vector3 now = direction(phase);
        const contact::Contact contact = proxy.update(surface, (kSphereRadius_m - 1.5e-3) * now);
        ASSERT_TRUE(contact.touching);
        if (i > 0) {
            largest_rad =
                std::max(largest_rad, 2.0 * std::asin(0.5 * (contact.normal - last).norm()));
        }
        // Facets turn by 0.5° and, across the old edges, a little more; the radius through the tip
        // meets a facet at no more than that.
        ASSERT_LT((contact.normal - now).norm(), 0.75 * kRadiansPerDegree) << i;
        last = contact.normal;
        // 0.1 mm a tick on the surface.
        phase +=
            1e-4 / kSphereRadius_m / std::max(1e-3, (direction(phase + 1e-6) - now).norm() / 1e-6);
    }
    EXPECT_LT(largest_rad, 1.0 * kRadiansPerDegree);
    EXPECT_GT(largest_rad, 0.1 * kRadiansPerDegree); // that of the sphere itself in a tick
}

TEST(CurvedTouch, MakesNoEnergyOnAClosedPath) {
    const contact::HapticSurface surface = smoothed_sphere();
    std::mt19937_64 random(1);
    for (int path = 0; path < 20; ++path) {
        const Vector3 a = testing::random_direction(random);
        const Vector3 b = testing::random_direction(random);
        const auto tip_at = [&](double s) {
            const double t = 2.0 * std::numbers::pi * s;
            const Vector3 u = a + 0.5 * std::cos(t) * b + 0.3 * std::sin(t) * a.unitOrthogonal();
            return Vector3((kSphereRadius_m + 2e-3 - 6e-3 * std::sin(0.5 * t) * std::sin(0.5 * t)) *
                           u.normalized());
        };
        Vector3 tip = tip_at(0.0);
        contact::Proxy proxy;
        proxy.reset(tip);
        double work = 0.0; // of the hand, over the stiffness [m²]
        for (int i = 1; i <= 4000; ++i) {
            const contact::Contact contact = proxy.update(surface, tip);
            const Vector3 next = tip_at(i / 4000.0);
            if (contact.touching) {
                work += 0.5 *
                        ((contact.x0_m - next).squaredNorm() - (contact.x0_m - tip).squaredNorm());
            }
            tip = next;
        }
        EXPECT_GT(work, -1e-15); // round-off of 4000 terms of 1e-6 m²
    }
}

} // namespace
} // namespace springdrive::scene
