// Covers engine/contact/proxy/haptic_surface.cpp and engine/contact/proxy/proxy.cpp on analytic
// shapes: exact where a mesh is an approximation.
#include "engine/contact/proxy/proxy.h"

#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::random_direction;
using testing::random_vector;

/// Places are sums of a few numbers of 0.1 m, and directions over 10 nm lose eight digits of 16.
constexpr double kShapePlace_m = 1e-11;

HapticSurface shape(const AnalyticShape::Size &size,
                    const Eigen::Isometry3d &placement = Eigen::Isometry3d::Identity()) {
    TriangleSoup soup;
    soup.materials = {{"shape", 0.25}};
    return HapticSurface(soup, {AnalyticShape(size, placement, 0)});
}

/// A tip that wanders between 30 mm about the origin, 0.2 mm a step, from outside at first.
template <typename Visit> void random_walk(std::uint64_t seed, const Visit &visit) {
    std::mt19937_64 random(seed);
    Vector3 tip(0.03, 0.03, 0.03);
    Vector3 heading = -tip.normalized();
    for (int i = 0; i < 20000; ++i) {
        heading = (heading + 0.2 * random_direction(random)).normalized();
        tip += 2e-4 * heading;
        for (int axis = 0; axis < 3; ++axis) {
            if (std::abs(tip[axis]) > 0.03) {
                heading[axis] = -std::copysign(heading[axis], tip[axis]);
            }
        }
        visit(tip, i);
    }
}

TEST(ProxyOnShapes, IsTheNearestPointOfASphere) {
    for (const double reach_m : {kClearance_m, 0.5e-3}) {
        const HapticSurface ball = shape(Sphere{0.02});
        Proxy proxy(reach_m);
        proxy.reset({0.031, 0.031, 0.031});
        int touching = 0;
        random_walk(1, [&](const Vector3 &tip, int i) {
            const Contact contact = proxy.update(ball, tip);
            if (contact.touching && tip.norm() > 0.005) { // at the centre all places are alike
                ++touching;
                EXPECT_LT((contact.x0_m - (0.02 + reach_m) * tip.normalized()).norm(), 1e-8) << i;
                EXPECT_EQ(contact.eta, 0.25);
                EXPECT_EQ(contact.active_constraints, 1);
                EXPECT_NEAR(contact.surface_m.norm(), 0.02, kShapePlace_m);
                EXPECT_EQ(contact.barycentric, Vector3::Zero());
                EXPECT_EQ(contact.triangle, 0U); // of none before it
                EXPECT_FALSE(contact.sticking);
            }
            EXPECT_GT(contact.x0_m.norm(), 0.02 + reach_m - 2e-12) << i;
        });
        EXPECT_GT(touching, 1000);
    }
}

/// BoxShapes and their triangles, of one material.
struct BoxShapes {
    TriangleSoup soup;
    std::vector<AnalyticShape> shapes;

    explicit BoxShapes(const SurfaceMaterial &material) { soup.materials = {material}; }

    void add(const Vector3 &lower_m, const Vector3 &upper_m) {
        Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
        placement.translation() = 0.5 * (lower_m + upper_m);
        shapes.emplace_back(Box{0.5 * (upper_m - lower_m)}, placement, 0);
        const TriangleSoup one = testing::box_soup(lower_m, upper_m);
        const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.insert(soup.vertices_m.end(), one.vertices_m.begin(), one.vertices_m.end());
        for (const auto &[a, b, c] : one.triangles) {
            soup.triangles.push_back({first + a, first + b, first + c});
            soup.material_of_triangle.push_back(0);
        }
    }
};

/// The number of contacts while proxies on boxes and on their triangles agreed.
int touches_alike(const BoxShapes &boxes, std::uint64_t seed) {
    TriangleSoup none;
    none.materials = boxes.soup.materials;
    const HapticSurface exact(none, boxes.shapes);
    const HapticSurface mesh(boxes.soup);
    Proxy on_shapes;
    Proxy on_mesh;
    on_shapes.reset({0.031, 0.031, 0.031});
    on_mesh.reset({0.031, 0.031, 0.031});
    int touching = 0;
    random_walk(seed, [&](const Vector3 &tip, int i) {
        const Contact expected = on_mesh.update(mesh, tip);
        const Contact contact = on_shapes.update(exact, tip);
        EXPECT_LT((contact.x0_m - expected.x0_m).norm(), kShapePlace_m) << i;
        EXPECT_EQ(contact.touching, expected.touching) << i;
        EXPECT_EQ(contact.sticking, expected.sticking) << i;
        EXPECT_EQ(contact.eta, expected.eta) << i;
        if (contact.touching) {
            EXPECT_LT((contact.normal - expected.normal).norm(), 1e-6) << i;
            EXPECT_LT((contact.surface_m - expected.surface_m).norm(), kShapePlace_m) << i;
            EXPECT_LT((contact.tangent_projector - expected.tangent_projector).norm(), 1e-6) << i;
        }
        touching += contact.touching ? 1 : 0;
    });
    return touching;
}

TEST(ProxyOnShapes, OnBoxesMatchesTriangles) {
    BoxShapes one({"smooth", 0.25});
    one.add({-0.02, -0.01, -0.015}, {0.02, 0.01, 0.015});
    EXPECT_GT(touches_alike(one, 2), 1000);
    BoxShapes rough({"rough", 0.25, 0.5, 0.3});
    // No edges: on triangles the proxy also steps over edges that are hardly higher than its
    // position.
    rough.add({-0.1, -0.02, -0.1}, {0.1, 0.005, 0.1});
    EXPECT_GT(touches_alike(rough, 5), 1000);
    BoxShapes two({"smooth", 0.25}); // a gap of 4 mm, and steps on its far side
    two.add({-0.025, -0.01, -0.02}, {-0.002, 0.01, 0.02});
    two.add({0.002, -0.01, -0.02}, {0.025, 0.005, 0.02});
    EXPECT_GT(touches_alike(two, 6), 1000);
}

TEST(ProxyOnShapes, RestsSquareToTheSurfaceOfAnyShapeAndNeverEntersIt) {
    std::mt19937_64 random(3);
    for (const AnalyticShape::Size &size :
         {AnalyticShape::Size(Cylinder{0.015, 0.01}), AnalyticShape::Size(Capsule{0.01, 0.01}),
          AnalyticShape::Size(Plate{0.02, 0.015})}) {
        Eigen::Isometry3d placement(Eigen::AngleAxisd(1.0, random_direction(random)));
        placement.pretranslate(random_vector(random, 2e-3));
        const HapticSurface surface = shape(size, placement);
        const AnalyticShape &exact = surface.shapes()[0];
        Proxy proxy;
        proxy.reset({0.031, 0.031, 0.031});
        int touching = 0;
        random_walk(4, [&](const Vector3 &tip, int i) {
            const Contact contact = proxy.update(surface, tip);
            const NearestOnShape nearest = exact.nearest(contact.x0_m);
            EXPECT_GT(nearest.distance_m, kClearance_m - 2e-12) << i;
            if (contact.touching) {
                ++touching;
                EXPECT_NEAR(nearest.distance_m, kClearance_m, 1e-9) << i;
                EXPECT_GT(contact.normal.dot(nearest.normal), 1.0 - 1e-6) << i;
            }
        });
        EXPECT_GT(touching, 500);
    }
}

TEST(ProxyOnShapes, DoesNotTunnelHoweverFastTheTip) {
    std::mt19937_64 random(8);
    for (const AnalyticShape::Size &size :
         {AnalyticShape::Size(Plate{0.02, 0.015}), AnalyticShape::Size(Sphere{0.015}),
          AnalyticShape::Size(Box{{0.02, 0.0005, 0.02}}),
          AnalyticShape::Size(Cylinder{0.015, 0.01}), AnalyticShape::Size(Capsule{0.01, 0.01})}) {
        const HapticSurface surface = shape(size);
        Proxy proxy;
        proxy.reset({0.031, 0.031, 0.031});
        Vector3 tip(0.02, 0.02, 0.02);
        int touching = 0;
        for (int i = 0; i < 3000; ++i) {
            // Steps of all sizes: long ones change from one face to another or leave the shape.
            const double leap_m = std::pow(10.0, -1.5 - 3.0 * (i % 7) / 6.0);
            tip += random_vector(random, leap_m);
            tip = tip.cwiseMax(-0.02).cwiseMin(0.02);
            const Contact contact = proxy.update(surface, tip);
            touching += contact.touching ? 1 : 0;
            const ProxyPath &path = proxy.path();
            for (std::size_t piece = 0; piece + 1 < path.size(); ++piece) {
                for (int part = 0; part <= 20; ++part) {
                    const Vector3 point_m =
                        path[piece] + part / 20.0 * (path[piece + 1] - path[piece]);
                    ASSERT_GT(surface.shapes()[0].nearest(point_m).distance_m, kClearance_m - 2e-12)
                        << i;
                }
            }
        }
        EXPECT_GT(touching, 100);
    }
}

TEST(ProxyOnShapes, ChangesTheSurfaceInContact) {
    // The touched shape is elsewhere, or missing, in the next surface.
    Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
    aside.translate(Vector3(0.0, -2e-3, 0.0));
    const HapticSurface ball = shape(Sphere{0.02});
    const HapticSurface lower = shape(Sphere{0.02}, aside);
    const HapticSurface floor(testing::box_soup({-0.1, -0.02, -0.1}, {0.1, 0.019, 0.1}));
    Proxy proxy;
    proxy.reset({0.0, 0.03, 0.0});
    const Vector3 tip(0.0, 0.015, 0.0);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(proxy.update(ball, tip).x0_m.y(), 0.02 + kClearance_m, kShapePlace_m);
        EXPECT_NEAR(proxy.update(lower, tip).x0_m.y(), 0.018 + kClearance_m, kShapePlace_m);
        EXPECT_NEAR(proxy.update(lower, tip).x0_m.y(), 0.018 + kClearance_m, kShapePlace_m);
        proxy.reset({0.0, 0.03, 0.0});
        EXPECT_NEAR(proxy.update(floor, tip).x0_m.y(), 0.019 + kClearance_m, kShapePlace_m);
        proxy.reset({0.0, 0.03, 0.0});
    }
}

TEST(ProxyOnShapes, SlidesOverCurvedOnesInTwoMotions) {
    // Straight above the place of rest, and down.
    for (const AnalyticShape::Size &size :
         {AnalyticShape::Size(Sphere{0.02}), AnalyticShape::Size(Capsule{0.02, 0.05})}) {
        const HapticSurface surface = shape(size);
        Proxy proxy;
        proxy.reset({0.03, 0.0, 0.0});
        for (int i = 0; i < 1000; ++i) {
            const double angle = 0.005 * i;
            const Vector3 tip(0.018 * std::cos(angle), 2e-5 * i, 0.018 * std::sin(angle));
            ASSERT_TRUE(proxy.update(surface, tip).settled);
            ASSERT_LE(proxy.path().size(), 3U) << i;
        }
    }
}

TEST(ProxyOnShapes, NearlyAlwaysSettlesWhereTheyOverlap) {
    // In a crease deep inside, where slides along both converge slowly, the next tick continues.
    TriangleSoup soup;
    soup.materials = {{"shapes", 0.0}};
    Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
    aside.translate(Vector3(0.015, 0.005, 0.0));
    const AnalyticShape ball(Sphere{0.02}, Eigen::Isometry3d::Identity(), 0);
    const AnalyticShape other_ball(Sphere{0.015}, aside, 0);
    const AnalyticShape box(Box{Vector3(0.01, 0.02, 0.012)}, aside, 0);
    for (const std::vector<AnalyticShape> &shapes :
         {std::vector{ball}, std::vector{ball, other_ball}, std::vector{ball, box}}) {
        const HapticSurface surface(soup, shapes);
        Proxy proxy;
        proxy.reset({0.031, 0.031, 0.031});
        int unsettled = 0;
        random_walk(7, [&](const Vector3 &tip, int i) {
            const Contact contact = proxy.update(surface, tip);
            unsettled += contact.settled ? 0 : 1;
            for (const AnalyticShape &one : shapes) {
                EXPECT_GT(one.nearest(contact.x0_m).distance_m, 0.0) << i;
            }
        });
        EXPECT_LE(unsettled, shapes.size() == 1 ? 0 : 40); // of 20,000
    }
}

TEST(ProxyOnShapes, StartsFreeInsideASolidAndFindsItFromOutside) {
    const HapticSurface ball = shape(Sphere{0.02});
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    for (int i = 0; i <= 30; ++i) {
        const Vector3 tip(1e-3 * i, 0.0, 0.0);
        const Contact contact = proxy.update(ball, tip);
        EXPECT_FALSE(contact.touching);
        EXPECT_EQ(contact.x0_m, tip);
    }
    const Contact contact = proxy.update(ball, {0.01, 0.0, 0.0});
    EXPECT_TRUE(contact.touching);
    EXPECT_NEAR(contact.x0_m.x(), 0.02 + kClearance_m, kShapePlace_m);
}

TEST(ProxyOnShapes, UsesTheClosedFormOnlyWhereNoOtherObstacleIsInvolved) {
    // A ball half sunk into a floor, and another 1 mm beside it.
    TriangleSoup soup = testing::box_soup({-0.1, -0.02, -0.1}, {0.1, 0.0, 0.1});
    Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
    aside.translate(Vector3(0.041, 0.0, 0.0));
    const HapticSurface surface(soup,
                                {AnalyticShape(Sphere{0.02}, Eigen::Isometry3d::Identity(), 0),
                                 AnalyticShape(Sphere{0.02}, aside, 0)});
    const auto slides = [&](const Vector3 &from, const Vector3 &to) {
        const Vector3 from_m = (0.02 + kClearance_m) * from.normalized();
        Neighbourhood near;
        SearchBudget budget{1000};
        surface.find_near(from_m, 0.05, budget, near);
        return surface.slide_over(12, near, from_m, 0.018 * to.normalized(), kClearance_m)
            .has_value();
    };
    EXPECT_TRUE(slides({0.0, 1.0, 0.0}, {0.1, 1.0, 0.0}));
    EXPECT_TRUE(slides({-1.0, 0.3, 0.0}, {-1.0, 0.2, 0.0}));
    EXPECT_FALSE(slides({-1.0, 0.1, 0.0}, {-1.0, -0.1, 0.0})); // under the floor
    EXPECT_FALSE(slides({-1.0, 0.1, 0.0}, {-1.0, -0.001, 0.0}));
    EXPECT_TRUE(slides({1.0, 0.6, 0.0}, {1.0, 0.55, 0.0}));
    EXPECT_FALSE(slides({1.0, 0.3, 0.0}, {1.0, 0.0, 0.0})); // into the gap
    const Vector3 top_m(0.0, 0.02 + kClearance_m, 0.0);
    EXPECT_DEATH(static_cast<void>(surface.slide_over(12, Neighbourhood(), top_m, {0.0, 0.018, 0.0},
                                                      kClearance_m)),
                 "near.covers");
}

} // namespace
} // namespace springdrive::contact
