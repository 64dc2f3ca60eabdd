// Covers engine/contact/proxy/proxy.cpp where proxies fail: thin walls, fast tips, edges and
// corners of every kind, and meshes with faults. Each has a result that is known without a proxy.
#include "engine/contact/proxy/proxy.h"

#include "engine/scene/fit.h"
#include "tests/engine/contact/proxy/optimality.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::contact {
namespace {

using testing::box_soup;
using testing::random_direction;
using testing::random_vector;

/// A tip at 1 kHz that moves randomly within a box at a given speed.
class RandomBoxWalk {
public:
    RandomBoxWalk(std::uint64_t seed, const Vector3 &start_m, const Vector3 &half_m,
                  double speed_m_per_s)
        : random_(seed), tip_m_(start_m), half_m_(half_m), step_m_(1e-3 * speed_m_per_s) {}

    Vector3 next() {
        heading_ = (heading_ + 0.3 * random_direction(random_)).normalized();
        tip_m_ += step_m_ * heading_;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::abs(tip_m_[axis]) > half_m_[axis]) {
                tip_m_[axis] = std::clamp(tip_m_[axis], -half_m_[axis], half_m_[axis]);
                heading_[axis] = -heading_[axis];
            }
        }
        return tip_m_;
    }

private:
    std::mt19937_64 random_;
    Vector3 tip_m_;
    Vector3 half_m_;
    double step_m_;
    Vector3 heading_{Vector3::UnitX()};
};

class ProxyAtSpeed : public ::testing::TestWithParam<double> {};

TEST_P(ProxyAtSpeed, NeverPassesAPlateOfATenthOfAMillimetre) {
    const HapticSurface plate(box_soup({-0.1, -0.05e-3, -0.1}, {0.1, 0.05e-3, 0.1}));
    RandomBoxWalk walk(1, {0.0, 0.02, 0.0}, {0.08, 0.03, 0.08}, GetParam());
    Proxy proxy;
    proxy.reset({0.0, 0.02, 0.0});
    const double top_m = 0.05e-3 + kClearance_m;
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(plate, tip);
        // The tip never gets around the plate, so this is where the proxy is.
        const Vector3 expected(tip.x(), std::max(tip.y(), top_m), tip.z());
        ASSERT_LT((contact.x0_m - expected).norm(), 1e-12) << i;
    }
}

TEST_P(ProxyAtSpeed, FollowsTheWallsEdgesAndCornersOfARoom) {
    const Vector3 half(0.02, 0.03, 0.04);
    const HapticSurface room(testing::turned_inside_out(box_soup(-half, half)));
    RandomBoxWalk walk(2, Vector3::Zero(), 1.3 * half, GetParam());
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    std::array<int, 4> seen{};
    const Vector3 inner = half - Vector3::Constant(kClearance_m);
    for (int i = 0; i < 20000; ++i) {
        const Vector3 tip = walk.next();
        const Contact contact = proxy.update(room, tip);
        ASSERT_LT((contact.x0_m - tip.cwiseMin(inner).cwiseMax(-inner)).norm(), 1e-12) << i;
        ++seen[static_cast<std::size_t>(contact.active_constraints)];
    }
    EXPECT_GT(*std::ranges::min_element(seen), 10); // walls, edges and corners
}

TEST_P(ProxyAtSpeed, NeverEntersASolidWhateverItsEdges) {
    // A knife of two degrees, a needle of fifteen, and a bowl with a wall of a millimetre.
    for (const TriangleSoup &soup : {testing::knife(), testing::needle(), testing::bowl(12)}) {
        const HapticSurface solid(soup);
        ASSERT_EQ(solid.report().closed_components, 1U);
        ASSERT_EQ(solid.report().inward_components, 0U);
        RandomBoxWalk walk(3, Vector3::Constant(0.02), Vector3::Constant(0.021), GetParam());
        Proxy proxy;
        proxy.reset(Vector3::Constant(0.02));
        int touching = 0;
        const int steps = GetParam() < 0.5 ? 20000 : 4000;
        for (int i = 0; i < steps; ++i) {
            const Vector3 tip = walk.next();
            const Contact contact = proxy.update(solid, tip);
            ASSERT_TRUE(contact.settled) << i;
            touching += contact.touching ? 1 : 0;
            if (contact.touching) {
                ASSERT_GT(testing::distance_to_soup(soup, contact.x0_m), kClearance_m - 2e-12) << i;
                ASSERT_NEAR(testing::winding_number(soup, contact.x0_m), 0.0, 1e-3) << i;
                ASSERT_LT(testing::unexplained_m(
                              contact.x0_m - tip,
                              testing::pushes(soup, contact.x0_m, kClearance_m, 1e-10)),
                          1e-9)
                    << i;
            }
        }
        EXPECT_GT(touching, 10);
    }
}

INSTANTIATE_TEST_SUITE_P(MetresPerSecond, ProxyAtSpeed, ::testing::Values(0.1, 1.0, 10.0));

/// A path over a sphere of 30 mm, 1 mm under its surface, at 0.1 m/s.
Vector3 tip_under_sphere(int tick) {
    const double t = 1e-4 / 0.029 * tick;
    return 0.029 * Vector3(std::sin(t), std::cos(t), std::sin(0.3 * t)).normalized();
}

/// Follows a clean sphere and one with faults; returns their largest difference.
double farthest_from_clean(const TriangleSoup &clean_soup, const TriangleSoup &faulty_soup) {
    const HapticSurface clean_surface(clean_soup);
    const HapticSurface faulty_surface(faulty_soup);
    Proxy clean;
    Proxy faulty;
    clean.reset({0.0, 0.05, 0.0});
    faulty.reset({0.0, 0.05, 0.0});
    double farthest_m = 0.0;
    for (int i = 0; i < 8000; ++i) {
        const Vector3 tip = tip_under_sphere(i);
        farthest_m = std::max(farthest_m, (clean.update(clean_surface, tip).x0_m -
                                           faulty.update(faulty_surface, tip).x0_m)
                                              .norm());
    }
    return farthest_m;
}

TEST(ProxyOnFaults, IsNotHeldOrLetThroughByCracks) {
    // Every triangle by itself, its corners off by up to 1 µm.
    std::mt19937_64 random(5);
    for (const int level : {2, 4}) {
        const TriangleSoup sphere = testing::icosphere(level, 0.03);
        TriangleSoup cracked;
        for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
            testing::Corners corners = testing::corners(sphere, i);
            for (Vector3 &corner : corners) {
                corner += random_vector(random, 1e-6 / std::sqrt(3.0));
            }
            testing::add_triangle(cracked, corners);
        }
        // Corners move by up to 2 µm when they become one, which turns facets by that over their
        // size: the foot of a tip a millimetre below moves by a few µm, to the next facet at most.
        const double facet_m = 0.03 * 1.1 / std::pow(2.0, level);
        EXPECT_LT(farthest_from_clean(sphere, cracked), 1.5e-3 * facet_m / 0.03);
    }
}

TEST(ProxyOnFaults, IsNotHeldOrLetThroughByFlippedTriangles) {
    std::mt19937_64 random(6);
    const TriangleSoup sphere = testing::icosphere(4, 0.03);
    TriangleSoup flipped = sphere;
    for (auto &triangle : flipped.triangles) {
        if (random() % 20 == 0) {
            std::swap(triangle[1], triangle[2]);
        }
    }
    EXPECT_LT(farthest_from_clean(sphere, flipped), 1e-12);
}

TEST(ProxyOnFaults, IsNotHeldOrLetThroughByDuplicatesAndSlivers) {
    const TriangleSoup sphere = testing::icosphere(4, 0.03);
    TriangleSoup faulty;
    for (std::size_t i = 0; i < sphere.triangles.size(); ++i) {
        const auto [a, b, c] = testing::corners(sphere, i);
        testing::add_triangle(faulty, {a, b, c});
        testing::add_triangle(faulty, {b, c, a});
        testing::add_triangle(faulty, {a, b, 0.5 * (a + b)});
        testing::add_triangle(faulty, {a, a, c});
    }
    EXPECT_LT(farthest_from_clean(sphere, faulty), 1e-12);
}

TEST(ProxyOnFaults, ClimbsStepsTooLowToFeelAndNoOthers) {
    // Two sheets side by side, one a little higher.
    for (const double step_m : {1e-9, 5e-8, 1e-6, 9.9e-6, 1.03e-5, 5e-5}) {
        TriangleSoup soup = box_soup({-0.05, -0.01, -0.05}, {0.0, 0.0, 0.05});
        soup = testing::joined(soup, box_soup({0.0, -0.01, -0.05}, {0.05, step_m, 0.05}));
        const HapticSurface surface(soup);
        Proxy proxy;
        proxy.reset({-0.002, 0.01, 0.0});
        Contact contact;
        for (int i = 0; i <= 23; ++i) {
            contact = proxy.update(surface, {-0.00211 + 1e-4 * i, -1.5e-3, 0.0});
        }
        // 0.19 mm past the step, 12 µm nearer on it: higher steps hold it as walls do.
        EXPECT_EQ(contact.x0_m.x() > 0.05e-3, step_m < 1e-5) << step_m;
    }
}

TEST(ProxyOnUnits, IsIndependentOfTheFilesUnits) {
    // The same shape in millimetres, metres and inches, fitted as scenes are.
    const device::Workspace workspace{Vector3(0.0, 0.03, -0.015), Vector3(0.2, 0.1, 0.1)};
    std::vector<HapticSurface> surfaces;
    for (const double units_per_metre : {1.0, 1000.0, 1.0 / 0.0254}) {
        TriangleSoup soup = testing::bumpy_sphere(5, 1.3);
        scene::BoundingBox box;
        for (Vector3 &vertex : soup.vertices_m) {
            vertex *= units_per_metre;
            box.include(vertex);
        }
        const scene::Fit fit = scene::fit_into(workspace, box);
        for (Vector3 &vertex : soup.vertices_m) {
            vertex = fit(vertex);
        }
        surfaces.emplace_back(std::move(soup));
    }
    std::array<Proxy, 3> proxies;
    RandomBoxWalk walk(7, {0.0, 0.06, 0.0}, {0.04, 0.08, 0.04}, 0.2);
    int touching = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vector3 tip = walk.next();
        if (i == 0) {
            for (Proxy &proxy : proxies) {
                proxy.reset(tip);
            }
        }
        const Contact first = proxies[0].update(surfaces[0], tip);
        touching += first.touching ? 1 : 0;
        for (std::size_t k = 1; k < 3; ++k) {
            ASSERT_LT((proxies[k].update(surfaces[k], tip).x0_m - first.x0_m).norm(), 1e-10) << i;
        }
    }
    EXPECT_GT(touching, 500);
}

} // namespace
} // namespace springdrive::contact
