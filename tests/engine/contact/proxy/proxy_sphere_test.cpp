// Covers engine/contact/proxy/proxy.cpp on tessellated spheres: the finer the mesh, the nearer to
// the exact sphere; and on any mesh, the nearest point found by brute force.
#include "engine/contact/proxy/proxy.h"

#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace springdrive::contact {
namespace {

constexpr double kRadius_m = 0.05;

/// A tip that moves around under the surface at 0.1 m/s and 1 kHz, 1 to 2 mm deep.
class Lissajous {
public:
    Vector3 next() {
        const Vector3 now = direction(phase_);
        const double per_phase = (direction(phase_ + 1e-6) - now).norm() / 1e-6;
        phase_ += 1e-4 / kRadius_m / std::max(per_phase, 1e-3);
        return (kRadius_m - 1.5e-3 - 0.5e-3 * std::sin(40.0 * phase_)) * now;
    }

private:
    static Vector3 direction(double t) {
        return Vector3(std::sin(t + 0.3), std::sin(1.31 * t + 1.1), 1.2 * std::sin(1.73 * t) + 0.01)
            .normalized();
    }

    double phase_ = 0.0;
};

class ProxyOnSphere : public ::testing::TestWithParam<int> {};

TEST_P(ProxyOnSphere, IsTheNearestPointOfAll) {
    const TriangleSoup soup = testing::icosphere(GetParam(), kRadius_m);
    const HapticSurface surface(soup);
    const auto [a, b, c] = testing::corners(soup, 0);
    const double edge_m = (b - a).norm();
    // Largest angle between a facet and the sphere: at its corners, for triangles that are not
    // quite equilateral a quarter more than edge / (√3 R).
    const double facet_angle = 1.25 * edge_m / (std::sqrt(3.0) * kRadius_m);
    Lissajous path;
    Proxy proxy;
    proxy.reset(1.2 * path.next());
    for (int i = 0; i < 4000; ++i) {
        const Vector3 tip = path.next();
        const Contact contact = proxy.update(surface, tip);
        ASSERT_TRUE(contact.touching);
        ASSERT_TRUE(contact.settled);
        const double error_rad = std::acos(std::min(1.0, contact.normal.dot(tip.normalized())));
        ASSERT_LT(error_rad, facet_angle) << i;
        if (i % 40 != 0) {
            continue;
        }
        const double nearest_m = testing::distance_to_soup(soup, tip);
        ASSERT_NEAR((contact.x0_m - tip).norm(), nearest_m + kClearance_m, 1e-12) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Levels, ProxyOnSphere, ::testing::Values(3, 4, 5, 6));

TEST(ProxyOnFineSphere, DoesNotLag) {
    // Where the tip is under a point of the sphere, there is the proxy.
    const HapticSurface surface(testing::icosphere(6, kRadius_m));
    Lissajous path;
    Proxy proxy;
    proxy.reset(1.2 * path.next());
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = path.next();
        const Contact contact = proxy.update(surface, tip);
        const Vector3 across = contact.x0_m - tip.normalized().dot(contact.x0_m) * tip.normalized();
        // A facet's foot is off the radius by depth times the facet's angle: 2 mm · 0.014.
        ASSERT_LT(across.norm(), 2e-3 * 0.014) << i;
    }
}

TEST(ProxyOnFineSphere, ComesBackTheWayItWent) {
    const HapticSurface surface(testing::icosphere(5, kRadius_m));
    Lissajous path;
    std::vector<Vector3> tips(3000);
    for (Vector3 &tip : tips) {
        tip = path.next();
    }
    Proxy proxy;
    proxy.reset(1.2 * tips[0]);
    std::vector<Vector3> there;
    there.reserve(tips.size());
    for (const Vector3 &tip : tips) {
        there.push_back(proxy.update(surface, tip).x0_m);
    }
    for (std::size_t i = tips.size(); i-- > 0;) {
        ASSERT_LT((proxy.update(surface, tips[i]).x0_m - there[i]).norm(), 1e-10) << i;
    }
}

TEST(ProxyOnCoarseSphere, ChangesDirectionByTheAngleBetweenFacets) {
    // 80 triangles: every change of direction is the angle between two of their normals.
    const TriangleSoup soup = testing::icosphere(1, kRadius_m);
    std::vector<Vector3> normals;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto [a, b, c] = testing::corners(soup, i);
        normals.push_back((b - a).cross(c - a).normalized());
    }
    const HapticSurface surface(soup);
    Lissajous path;
    Proxy proxy;
    proxy.reset(1.2 * path.next());
    Vector3 last = Vector3::Zero();
    int changes = 0;
    for (int i = 0; i < 20000; ++i) {
        // Deep enough to be under every facet: these are up to 3.4 mm within the sphere.
        const Contact contact = proxy.update(surface, 0.9 * path.next());
        ASSERT_TRUE(contact.touching);
        double nearest = INFINITY;
        for (const Vector3 &normal : normals) {
            nearest = std::min(nearest, (contact.normal - normal).norm());
        }
        ASSERT_LT(nearest, 1e-9) << i;
        changes += i > 0 && (contact.normal - last).norm() > 1e-9 ? 1 : 0;
        last = contact.normal;
    }
    EXPECT_GT(changes, 50);
}

TEST(ProxyOnAnySphere, MakesNoEnergyOnAClosedPath) {
    // The spring between tip and proxy, its proxy the nearest point of a fixed surface, gives back
    // no more than was put in, however the path closes.
    std::mt19937_64 random(4);
    for (const int level : {1, 3, 5}) {
        const HapticSurface surface(testing::icosphere(level, kRadius_m));
        for (int path = 0; path < 10; ++path) {
            const Vector3 a = testing::random_direction(random);
            const Vector3 b = testing::random_direction(random);
            const auto tip_at = [&](double s) {
                const double t = 2.0 * std::numbers::pi * s;
                const Vector3 u =
                    a + 0.5 * std::cos(t) * b + 0.3 * std::sin(t) * a.unitOrthogonal();
                return Vector3((kRadius_m + 2e-3 - 6e-3 * std::sin(0.5 * t) * std::sin(0.5 * t)) *
                               u.normalized());
            };
            Vector3 tip = tip_at(0.0);
            Proxy proxy;
            proxy.reset(tip);
            double work = 0.0; // over the stiffness [m²]
            constexpr int kSteps = 4000;
            for (int i = 1; i <= kSteps; ++i) {
                const Contact contact = proxy.update(surface, tip);
                const Vector3 next = tip_at(static_cast<double>(i) / kSteps);
                if (contact.touching) {
                    work += 0.5 * ((contact.x0_m - next).squaredNorm() -
                                   (contact.x0_m - tip).squaredNorm());
                }
                tip = next;
            }
            // The proxy is constant within a tick, which always costs the hand work: the nearest
            // point would have followed. Round-off of 4000 terms of 1e-6 m².
            EXPECT_GT(work, -1e-15);
        }
    }
}

} // namespace
} // namespace springdrive::contact
