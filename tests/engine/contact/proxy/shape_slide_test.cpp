// Covers engine/contact/proxy/shape_slide.cpp: the closed form agrees with the descent, and no
// place nearby is nearer to the tip.
#include "engine/contact/proxy/shape_slide.h"

#include "engine/contact/proxy/proxy_solver.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/contact/proxy/shape_names.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace springdrive::contact {
namespace {

using testing::random_direction;
using testing::random_vector;

/// A few roundings of places within 0.5 m.
constexpr double kSlideRounding_m = 1e-15;

/// The descent ends 1e-11 m from its goal on the last tangent plane, and on a curved face that goal
/// is itself off by up to ten times as much.
constexpr double kSolverTolerance_m = 1e-10;

AnalyticShape::Size size_of(int kind) {
    const std::vector<AnalyticShape::Size> sizes = {Plate{0.03, 0.02}, Sphere{0.03},
                                                    Box{{0.02, 0.01, 0.03}}, Cylinder{0.02, 0.015},
                                                    Capsule{0.015, 0.02}};
    return sizes[static_cast<std::size_t>(kind)];
}

/// A proxy at rest on a shape, and a tip somewhere below.
struct Scene {
    const HapticSurface &surface;
    Rest rest;
    Vector3 tip_m;

    [[nodiscard]] const AnalyticShape &shape() const { return surface.shapes()[0]; }
    [[nodiscard]] std::optional<ShapeSlide> slide(double reach_m) const {
        return slide_over_face(shape(), rest.point_m, tip_m, reach_m);
    }
};

class ShapeSlides : public ::testing::TestWithParam<int> {
protected:
    std::mt19937_64 random{20260801};

    double between(double low, double high) {
        return std::uniform_real_distribution(low, high)(random);
    }

    /// A shape with a random placement.
    void place_shape() {
        centre_m_ = random_vector(random, 0.1);
        Eigen::Isometry3d placement(
            Eigen::AngleAxisd(between(-3.0, 3.0), random_direction(random)));
        placement.pretranslate(centre_m_);
        TriangleSoup soup;
        soup.materials = {{"shape", 0.25}};
        surface_ = HapticSurface(soup, {AnalyticShape(size_of(GetParam()), placement, 0)});
    }

    Scene random_scene(double reach_m) {
        constexpr int kScenesInAPlace = 100;
        if (scenes_++ % kScenesInAPlace == 0) {
            place_shape();
        }
        Scene scene{surface_, {}, {}};
        // From not far outside, so that it is over a face as often as over an edge.
        NearestOnShape under;
        do {
            under = scene.shape().nearest(centre_m_ + random_vector(random, 0.035));
        } while (under.distance_m <= 0.0);
        scene.rest.point_m = under.point_m + reach_m * under.normal;
        const std::optional<Stop> touch =
            scene.surface.touch(0, scene.rest.point_m, reach_m, 1e-12);
        EXPECT_TRUE(touch);
        scene.rest.held_by.add({touch->normal, touch->offset_m, 0});
        const double step_m = std::pow(10.0, between(-7.0, -1.5));
        scene.tip_m = scene.rest.point_m + step_m * random_direction(random) -
                      between(0.0, 5e-3) * under.normal;
        return scene;
    }

private:
    Vector3 centre_m_{Vector3::Zero()};
    HapticSurface surface_;
    int scenes_ = 0;
};

/// Samples of the two motions.
template <typename Visit>
void along(const Vector3 &from_m, const ShapeSlide &slide, const Visit &visit) {
    for (int i = 0; i <= 20; ++i) {
        visit(from_m + i / 20.0 * (slide.over_m - from_m));
        visit(slide.over_m + i / 20.0 * (slide.rest_m - slide.over_m));
    }
}

TEST_P(ShapeSlides, EndWhereTheSolverDoes) {
    for (const double reach_m : {kClearance_m, 0.5e-3}) {
        int slides = 0;
        for (int i = 0; i < 3000; ++i) {
            const Scene scene = random_scene(reach_m);
            const std::optional<ShapeSlide> slide = scene.slide(reach_m);
            if (!slide) {
                continue;
            }
            Neighbourhood near; // of all there is
            SearchBudget budget{1000};
            scene.surface.find_near(scene.rest.point_m, 0.5, budget, near);
            SolverBudget solver_budget;
            ProxyPath path;
            path.restart(scene.rest.point_m);
            Rest rest = scene.rest;
            const ProxySolver solver(scene.surface, near, reach_m, solver_budget, path);
            if (solver.solve(rest, scene.tip_m)) {
                ++slides;
                EXPECT_LT((rest.point_m - slide->rest_m).norm(), kSolverTolerance_m) << i;
                EXPECT_EQ(rest.held_by.size(), 1U);
                EXPECT_GT(rest.held_by[0].normal.dot(slide->normal), 1.0 - 1e-12) << i;
            }
        }
        EXPECT_GT(slides, 1000);
    }
}

TEST_P(ShapeSlides, NeverComeTooNearAndRestWithinReachStraightAboveTheTip) {
    for (const double reach_m : {kClearance_m, 0.5e-3}) {
        for (int i = 0; i < 3000; ++i) {
            const Scene scene = random_scene(reach_m);
            const std::optional<ShapeSlide> slide = scene.slide(reach_m);
            if (!slide) {
                continue;
            }
            along(scene.rest.point_m, *slide, [&](const Vector3 &point_m) {
                EXPECT_GT(scene.shape().nearest(point_m).distance_m, reach_m - kSlideRounding_m)
                    << i;
            });
            const NearestOnShape under = scene.shape().nearest(slide->rest_m);
            EXPECT_NEAR(under.distance_m, reach_m, kSlideRounding_m) << i;
            EXPECT_LT((under.point_m + slide->depth_m * -slide->normal - scene.tip_m).norm(),
                      kSlideRounding_m);
            EXPECT_NEAR(slide->normal.norm(), 1.0, 1e-15);
            EXPECT_TRUE(!slide->is_flat || slide->over_m == slide->rest_m);
        }
    }
}

TEST_P(ShapeSlides, LeaveNoNearbyPlaceThatIsNearerToTheTip) {
    constexpr double kReach_m = 0.2e-3;
    for (int i = 0; i < 1000; ++i) {
        const Scene scene = random_scene(kReach_m);
        const std::optional<ShapeSlide> slide = scene.slide(kReach_m);
        if (!slide) {
            continue;
        }
        const double rest_m = (slide->rest_m - scene.tip_m).norm();
        for (int j = 0; j < 50; ++j) {
            // Any nearby place, lifted until it keeps its distance.
            const Vector3 place_m = slide->rest_m + random_vector(random, 1e-5);
            const NearestOnShape under = scene.shape().nearest(place_m);
            if (under.normal.dot(slide->normal) < 0.5) {
                continue; // over an edge, on another face
            }
            const double lift_m = std::max(0.0, kReach_m - under.distance_m);
            EXPECT_GT((place_m + lift_m * under.normal - scene.tip_m).norm(),
                      rest_m - kSlideRounding_m)
                << i;
        }
    }
}

TEST_P(ShapeSlides, DoNotApplyToAProxyThatStartedTooNearOrATipThatLeaves) {
    for (int i = 0; i < 1000; ++i) {
        Scene scene = random_scene(kClearance_m);
        const Vector3 up = scene.rest.held_by[0].normal;
        EXPECT_FALSE(slide_over_face(scene.shape(), scene.rest.point_m, scene.tip_m, 2e-8));
        scene.tip_m = scene.rest.point_m + 1e-11 * up;
        EXPECT_FALSE(scene.slide(kClearance_m)) << i;
        scene.tip_m = scene.rest.point_m - 1e-11 * up;
        const std::optional<ShapeSlide> slide = scene.slide(kClearance_m);
        EXPECT_TRUE(!slide || slide->normal.dot(up) > 1.0 - 1e-12) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Every, ShapeSlides, ::testing::Range(0, 5), testing::shape_name);

std::optional<ShapeSlide> slide(const AnalyticShape::Size &size, const Vector3 &from_m,
                                const Vector3 &tip_m) {
    return slide_over_face(AnalyticShape(size, Eigen::Isometry3d::Identity(), 0), from_m, tip_m,
                           kClearance_m);
}

TEST(ShapeSlide, StaysOnItsSideHoweverDeepTheTip) {
    const double high_m = 0.01 + kClearance_m;
    const auto on_box = slide(Box{{0.02, 0.01, 0.03}}, {0.0, high_m, 0.0}, {0.01, -0.5, 0.02});
    ASSERT_TRUE(on_box);
    EXPECT_LT((on_box->rest_m - Vector3(0.01, high_m, 0.02)).norm(), 1e-16);
    const auto on_plate = slide(Plate{0.02, 0.03}, {0.0, -kClearance_m, 0.0}, {0.01, 0.5, 0.02});
    ASSERT_TRUE(on_plate);
    EXPECT_LT((on_plate->rest_m - Vector3(0.01, -kClearance_m, 0.02)).norm(), 1e-16);
    EXPECT_EQ(on_plate->depth_m, 0.5);
}

TEST(ShapeSlide, LeavesPathsOverEdgesToTheDescent) {
    const double high_m = 0.01 + kClearance_m;
    EXPECT_FALSE(slide(Box{{0.02, 0.01, 0.03}}, {0.0, high_m, 0.0}, {0.0201, 0.0, 0.0}));
    EXPECT_FALSE(slide(Box{{0.02, 0.01, 0.03}}, {0.0201, high_m, 0.0}, {0.01, 0.0, 0.0}));
    EXPECT_FALSE(slide(Plate{0.02, 0.03}, {0.0, kClearance_m, 0.0}, {0.0, -0.01, 0.0301}));
    EXPECT_FALSE(slide(Plate{0.02, 0.03}, {0.02 + kClearance_m, 0.0, 0.0}, {0.01, 0.0, 0.0}));
    const Cylinder cylinder{0.02, 0.01};
    const double wide_m = 0.02 + kClearance_m;
    EXPECT_TRUE(slide(cylinder, {0.0, high_m, 0.0}, {0.0, -0.5, 0.0199}));
    EXPECT_FALSE(slide(cylinder, {0.0, high_m, 0.0}, {0.0, 0.005, 0.0201}));
    EXPECT_TRUE(slide(cylinder, {wide_m, 0.0, 0.0}, {0.01, 0.0099, 0.0}));
    EXPECT_FALSE(slide(cylinder, {wide_m, 0.0, 0.0}, {0.01, 0.0101, 0.0}));
    EXPECT_FALSE(slide(cylinder, {wide_m, 0.0101, 0.0}, {0.01, 0.0, 0.0})); // from the rim
}

TEST(ShapeSlide, LeavesLongPathsAroundToTheDescent) {
    const double out_m = 0.02 + kClearance_m;
    const auto turned = [](double degrees, double radius_m) {
        const double angle = degrees * 3.14159265358979 / 180.0;
        return Vector3(radius_m * std::cos(angle), 0.0, radius_m * std::sin(angle));
    };
    for (const AnalyticShape::Size &size :
         {AnalyticShape::Size(Sphere{0.02}), AnalyticShape::Size(Capsule{0.02, 0.01}),
          AnalyticShape::Size(Cylinder{0.02, 0.01})}) {
        const Vector3 from_m(out_m, 0.0, 0.0);
        EXPECT_TRUE(slide(size, from_m, turned(25.0, 0.015))); // arccos 0.9 is 25.8 degrees
        EXPECT_FALSE(slide(size, from_m, turned(26.0, 0.015)));
        EXPECT_FALSE(slide(size, from_m, turned(180.0, 0.015))); // through the middle
        EXPECT_FALSE(slide(size, from_m, Vector3::Zero()));
        EXPECT_FALSE(slide(size, from_m, {1e-12, 0.0, 0.0}));
    }
}

} // namespace
} // namespace springdrive::contact
