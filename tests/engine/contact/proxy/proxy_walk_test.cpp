// Covers engine/contact/proxy/proxy.cpp: what must hold on every shape, whatever the tip does; and
// on tessellated spheres, the nearest point found by brute force.
#include "engine/contact/proxy/proxy.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::contact {
namespace {

using testing::corners;
using testing::random_direction;
using testing::random_vector;

/// The tangential offset that a proxy at rest may keep [m]: solutions of the same planes differ by
/// round-off, and it does not move by less than this.
constexpr double kSettled_m = 1e-10;

/// A random motion of the tip: mostly smooth, sometimes with jumps, never farther than `reach_m`.
class RandomWalk {
public:
    RandomWalk(std::uint64_t seed, const Vector3 &start_m, double reach_m, double step_m)
        : random_(seed), tip_m_(start_m), reach_m_(reach_m), step_m_(step_m) {}

    Vector3 next() {
        heading_ = (heading_ + 0.3 * random_direction(random_)).normalized();
        tip_m_ += step_m_ * heading_;
        if (random_() % 100 == 0) {
            tip_m_ += 20.0 * step_m_ * random_direction(random_);
        }
        if (tip_m_.norm() > reach_m_) {
            tip_m_ *= reach_m_ / tip_m_.norm();
            heading_ = random_direction(random_);
        }
        return tip_m_;
    }

private:
    std::mt19937_64 random_;
    Vector3 tip_m_;
    Vector3 heading_{Vector3::UnitX()};
    double reach_m_;
    double step_m_;
};

/// Same numbers, bit by bit.
bool is_identical(const Contact &a, const Contact &b) {
    return a.touching == b.touching && a.x0_m == b.x0_m &&
           a.tangent_projector == b.tangent_projector && a.normal == b.normal && a.eta == b.eta &&
           a.active_constraints == b.active_constraints && a.triangle == b.triangle;
}

void expect_sound(const Contact &contact, const Vector3 &tip) {
    const Matrix3 &P = contact.tangent_projector;
    ASSERT_LT((P - P.transpose()).norm(), 1e-14);
    ASSERT_LT((P * P - P).norm(), 1e-9); // edges between planes 1e-6 apart lose digits
    ASSERT_NEAR(P.trace(), 3.0 - contact.active_constraints, 1e-9);
    ASSERT_EQ(contact.touching, contact.active_constraints > 0);
    if (!contact.touching) {
        ASSERT_EQ(contact.x0_m, tip);
        return;
    }
    const Vector3 gap = contact.x0_m - tip;
    ASSERT_NEAR(contact.normal.norm(), 1.0, 1e-14);
    // The proxy is pulled in no direction in which it may move.
    ASSERT_LT((P * gap).norm(), 1.001 * kSettled_m);
    ASSERT_NEAR(contact.normal.dot(gap), gap.norm(), 1e-14);
}

class ProxyWalk : public ::testing::TestWithParam<TriangleSoup> {};

TEST_P(ProxyWalk, StaysOutsideAndSoundAndSettled) {
    const TriangleSoup &soup = GetParam();
    const HapticSurface mesh(soup);
    ASSERT_EQ(mesh.report().closed_components, mesh.report().components);
    RandomWalk walk(1, {0.0, 0.06, 0.0}, 0.06, 0.5e-3);
    Proxy proxy;
    proxy.reset({0.0, 0.06, 0.0});
    int touching = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(mesh, tip);
        expect_sound(contact, tip);
        // Converged: the same tip again leaves it where it is.
        Proxy again = proxy;
        ASSERT_EQ(again.update(mesh, tip).x0_m, contact.x0_m) << i;
        if (i % 20 == 0) {
            ASSERT_NEAR(testing::winding_number(soup, contact.x0_m), 0.0, 1e-3) << i;
        }
        if (HasFatalFailure()) {
            FAIL() << "in tick " << i;
        }
        touching += contact.touching ? 1 : 0;
    }
    EXPECT_GT(touching, 1000); // not vacuous
}

TEST_P(ProxyWalk, StaysOutsideHoweverFastTheTip) {
    // 5 m/s at 1 kHz, and jumps of 100 mm: through the shape and out on its other side.
    const TriangleSoup &soup = GetParam();
    const HapticSurface mesh(soup);
    RandomWalk walk(7, {0.0, 0.06, 0.0}, 0.06, 5e-3);
    Proxy proxy;
    proxy.reset({0.0, 0.06, 0.0});
    for (int i = 0; i < 2000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(mesh, tip);
        expect_sound(contact, tip);
        // A path that crosses the surface once changes the winding number by one.
        ASSERT_NEAR(testing::winding_number(soup, contact.x0_m), 0.0, 1e-3) << i;
        ASSERT_LT((contact.x0_m - tip).norm(), 0.2);
    }
}

INSTANTIATE_TEST_SUITE_P(
    ClosedShapes, ProxyWalk,
    ::testing::Values(testing::icosphere(3, 0.04), testing::bumpy_sphere(3, 0.04),
                      testing::bumpy_sphere(1, 0.04),
                      // Shapes that interpenetrate: creases that are not edges of the mesh.
                      testing::joined(testing::bumpy_sphere(2, 0.03),
                                      testing::moved(testing::bumpy_sphere(2, 0.03),
                                                     Eigen::Isometry3d(Eigen::Translation3d(
                                                         0.02, 0.015, 0.01))))));

TEST(ProxyOnAnyMesh, IsInvariantUnderRigidMotions) {
    const TriangleSoup soup = testing::bumpy_sphere(3, 0.04);
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.translate(Vector3(0.03, -0.05, 0.02));
    motion.rotate(Eigen::AngleAxisd(1.1, Vector3(1, 2, -3).normalized()));
    const HapticSurface mesh(soup);
    const HapticSurface moved_mesh(testing::moved(soup, motion));
    RandomWalk walk(5, {0.0, 0.06, 0.0}, 0.06, 0.5e-3);
    Proxy proxy;
    Proxy moved_proxy;
    proxy.reset({0.0, 0.06, 0.0});
    moved_proxy.reset(motion * Vector3(0.0, 0.06, 0.0));
    int touching = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(mesh, tip);
        const Contact moved = moved_proxy.update(moved_mesh, motion * tip);
        // Corners of the moved mesh are rounded to 1e-17 m, the planes through them turn by that
        // over the size of a facet, and three planes meet at that over the smallest sine between
        // them.
        ASSERT_LT((motion * contact.x0_m - moved.x0_m).norm(), 1e-10) << i;
        const Matrix3 expected =
            motion.linear() * contact.tangent_projector * motion.linear().transpose();
        ASSERT_LT((expected - moved.tangent_projector).norm(), 1e-9) << i;
        touching += contact.touching ? 1 : 0;
    }
    EXPECT_GT(touching, 1000); // not vacuous
}

TEST(ProxyOnAnyMesh, GivesTheSameBitsForTheSameInput) {
    const TriangleSoup soup = testing::bumpy_sphere(3, 0.04);
    const HapticSurface mesh(soup);
    const HapticSurface same_mesh(soup);
    RandomWalk walk(6, {0.0, 0.06, 0.0}, 0.06, 0.5e-3);
    Proxy proxy;
    Proxy same_proxy;
    for (int i = 0; i < 5000; ++i) {
        const Vector3 tip = walk.next();
        ASSERT_TRUE(is_identical(proxy.update(mesh, tip), same_proxy.update(same_mesh, tip)));
    }
}

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

} // namespace
} // namespace springdrive::contact
