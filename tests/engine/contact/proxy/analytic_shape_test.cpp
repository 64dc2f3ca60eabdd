// Covers engine/contact/proxy/analytic_shape.cpp: what is near a shape, and
// that a slide in closed form ends where the descent does, with no place nearby nearer to the tip.
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/proxy_solver.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace springdrive::contact {
namespace {

/// Of the kinds of AnalyticShape::Size, in their order.
std::string shape_name(const ::testing::TestParamInfo<int> &info) {
    const std::array<const char *, 5> names{"Plate", "Sphere", "Box", "Cylinder", "Capsule"};
    return names[static_cast<std::size_t>(info.param)];
}

/// A few roundings of coordinates up to 0.5 m: their last place is 1.1e-16 m at most there.
constexpr double kRounding_m = 1e-15;

/// Random points, directions and placements.
class RandomDraws {
public:
    double between(double low, double high) {
        return std::uniform_real_distribution(low, high)(engine_);
    }
    double sign() { return between(-1.0, 1.0) < 0.0 ? -1.0 : 1.0; }
    Vector3 direction() {
        std::normal_distribution<double> normal;
        return Vector3(normal(engine_), normal(engine_), normal(engine_)).normalized();
    }
    Vector3 within(const Vector3 &half) {
        return {between(-half.x(), half.x()), between(-half.y(), half.y()),
                between(-half.z(), half.z())};
    }
    Eigen::Isometry3d placement() {
        Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
        placement.translate(within(Vector3::Constant(0.3)));
        placement.rotate(Eigen::AngleAxisd(between(-3.0, 3.0), direction()));
        return placement;
    }

private:
    std::mt19937_64 engine_{20260729};
};

struct KnownPoint {
    Vector3 point_m;
    Vector3 normal; ///< outwards; of a plate to either side
};

/// A random point of a shape's surface in its own frame, edges aside.
struct SampleSurface {
    RandomDraws &dice;

    KnownPoint operator()(const Plate &s) const {
        return {{dice.between(-s.half_x_m, s.half_x_m), 0.0, dice.between(-s.half_z_m, s.half_z_m)},
                Vector3(0.0, dice.sign(), 0.0)};
    }
    KnownPoint operator()(const Sphere &s) const {
        const Vector3 u = dice.direction();
        return {s.radius_m * u, u};
    }
    KnownPoint operator()(const Box &s) const {
        KnownPoint sample{dice.within(s.half_size_m), Vector3::Zero()};
        const auto face = static_cast<Eigen::Index>(dice.between(0.0, 2.999));
        sample.normal[face] = dice.sign();
        sample.point_m[face] = sample.normal[face] * s.half_size_m[face];
        return sample;
    }
    KnownPoint operator()(const Cylinder &s) const {
        const double turn = dice.between(0.0, 2.0 * std::numbers::pi);
        const Vector3 radial(std::cos(turn), 0.0, std::sin(turn));
        if (dice.sign() < 0.0) {
            const double y = dice.between(-s.half_height_m, s.half_height_m);
            return {s.radius_m * radial + Vector3(0.0, y, 0.0), radial};
        }
        const Vector3 axial(0.0, dice.sign(), 0.0);
        const double r = s.radius_m * std::sqrt(dice.between(0.0, 1.0));
        return {r * radial + s.half_height_m * axial, axial};
    }
    KnownPoint operator()(const Capsule &s) const {
        const Vector3 u = dice.direction();
        if (dice.sign() < 0.0) {
            const Vector3 radial = Vector3(u.x(), 0.0, u.z()).normalized();
            const double y = dice.between(-s.half_axis_m, s.half_axis_m);
            return {s.radius_m * radial + Vector3(0.0, y, 0.0), radial};
        }
        return {s.radius_m * u + Vector3(0.0, std::copysign(s.half_axis_m, u.y()), 0.0), u};
    }
};

/// The farthest point of a shape in a direction of its own frame.
struct Farthest {
    Vector3 u;

    Vector3 operator()(const Plate &s) const {
        return {std::copysign(s.half_x_m, u.x()), 0.0, std::copysign(s.half_z_m, u.z())};
    }
    Vector3 operator()(const Sphere &s) const { return s.radius_m * u; }
    Vector3 operator()(const Box &s) const {
        return {std::copysign(s.half_size_m.x(), u.x()), std::copysign(s.half_size_m.y(), u.y()),
                std::copysign(s.half_size_m.z(), u.z())};
    }
    Vector3 operator()(const Cylinder &s) const {
        const Vector3 radial = Vector3(u.x(), 0.0, u.z()).normalized();
        return s.radius_m * radial + Vector3(0.0, std::copysign(s.half_height_m, u.y()), 0.0);
    }
    Vector3 operator()(const Capsule &s) const {
        return s.radius_m * u + Vector3(0.0, std::copysign(s.half_axis_m, u.y()), 0.0);
    }
};

/// Whether a point of the shape's own frame lies within the solid.
struct Holds {
    Vector3 p;

    bool operator()(const Plate & /*s*/) const { return false; }
    bool operator()(const Sphere &s) const { return p.norm() < s.radius_m; }
    bool operator()(const Box &s) const { return (p.array().abs() < s.half_size_m.array()).all(); }
    bool operator()(const Cylinder &s) const {
        return std::hypot(p.x(), p.z()) < s.radius_m && std::abs(p.y()) < s.half_height_m;
    }
    bool operator()(const Capsule &s) const {
        const double beyond = std::max(std::abs(p.y()) - s.half_axis_m, 0.0);
        return Vector3(p.x(), beyond, p.z()).norm() < s.radius_m;
    }
};

/// A shape with its placement and reference data.
struct PlacedShape {
    AnalyticShape::Size size;
    Eigen::Isometry3d placement;
    AnalyticShape shape;

    PlacedShape(const AnalyticShape::Size &of, const Eigen::Isometry3d &where)
        : size(of), placement(where), shape(of, where, 7) {}

    KnownPoint sample(RandomDraws &dice) const {
        const KnownPoint local = std::visit(SampleSurface{dice}, size);
        return {placement * local.point_m, placement.linear() * local.normal};
    }
    [[nodiscard]] bool holds(const Vector3 &point_m) const {
        return std::visit(Holds{placement.inverse() * point_m}, size);
    }
};

AnalyticShape::Size random_size(int kind, RandomDraws &dice) {
    const auto length_m = [&] { return dice.between(0.005, 0.1); };
    switch (kind) {
    case 0:
        return Plate{length_m(), length_m()};
    case 1:
        return Sphere{length_m()};
    case 2:
        return Box{{length_m(), length_m(), length_m()}};
    case 3:
        return Cylinder{length_m(), length_m()};
    default:
        return Capsule{length_m(), length_m()};
    }
}

class AnalyticShapes : public ::testing::TestWithParam<int> {
protected:
    RandomDraws dice;
    PlacedShape random_case() { return {random_size(GetParam(), dice), dice.placement()}; }
};

TEST_P(AnalyticShapes, TheNearestPointLiesStraightBelowTheQueryOnTheSurface) {
    for (int i = 0; i < 2000; ++i) {
        const PlacedShape c = random_case();
        const Vector3 query_m = c.placement.translation() + dice.within(Vector3::Constant(0.15));
        const NearestOnShape nearest = c.shape.nearest(query_m);
        EXPECT_NEAR(nearest.normal.norm(), 1.0, 1e-15);
        EXPECT_LT((nearest.point_m + nearest.distance_m * nearest.normal - query_m).norm(),
                  kRounding_m);
        EXPECT_EQ(nearest.distance_m < 0.0, c.holds(query_m));
        // On the surface: slightly inwards is within the solid, slightly outwards is not.
        const Vector3 offset_m = 1e-12 * nearest.normal;
        EXPECT_FALSE(c.holds(nearest.point_m + offset_m));
        if (c.shape.is_solid() && nearest.distance_m < 0.0) {
            EXPECT_TRUE(c.holds(nearest.point_m - offset_m));
        }
    }
}

TEST_P(AnalyticShapes, ThePlaneThroughTheNearestPointHasTheWholeShapeBehindIt) {
    for (int i = 0; i < 200; ++i) {
        const PlacedShape c = random_case();
        const Vector3 query_m = c.placement.translation() + dice.within(Vector3::Constant(0.15));
        const NearestOnShape nearest = c.shape.nearest(query_m);
        for (int j = 0; j < 100; ++j) {
            const KnownPoint other = c.sample(dice);
            EXPECT_LT(nearest.normal.dot(other.point_m - nearest.point_m), kRounding_m);
            // So none is nearer; this also holds from within, where the plane alone is no proof.
            EXPECT_GT((other.point_m - query_m).norm(), std::abs(nearest.distance_m) - kRounding_m);
        }
    }
}

TEST_P(AnalyticShapes, ATenthOfAMicrometreOffTheSurfaceIsMeasuredToTheLastPlaces) {
    for (int i = 0; i < 2000; ++i) {
        const PlacedShape c = random_case();
        const KnownPoint on = c.sample(dice);
        constexpr double kOff_m = 1e-7;
        const NearestOnShape outside = c.shape.nearest(on.point_m + kOff_m * on.normal);
        EXPECT_NEAR(outside.distance_m, kOff_m, kRounding_m);
        // A rounding of the query, 1e-16 m, turns a normal by that much of the distance or radius.
        EXPECT_LT((outside.normal - on.normal).norm(), 1e-8);
        if (c.shape.is_solid()) {
            const NearestOnShape inside = c.shape.nearest(on.point_m - kOff_m * on.normal);
            EXPECT_NEAR(std::abs(inside.distance_m), kOff_m, kRounding_m);
            EXPECT_LT(inside.distance_m, 0.0);
        }
    }
}

TEST_P(AnalyticShapes, AMotionSeparatedFromTheShapeKeepsItsDistance) {
    int parted = 0;
    int far_off = 0;
    for (int i = 0; i < 5000; ++i) {
        const PlacedShape c = random_case();
        const auto place_m = [&] {
            return Vector3(c.placement.translation() + dice.within(Vector3::Constant(0.2)));
        };
        const Vector3 from_m = place_m();
        const Vector3 to_m =
            from_m + std::pow(10.0, dice.between(-5.0, 0.0)) * (place_m() - from_m);
        const double clear_m = std::pow(10.0, dice.between(-8.0, -2.0));
        const bool is_parted = c.shape.is_parted_from(from_m, to_m, clear_m);
        for (int j = 0; is_parted && j <= 20; ++j) {
            const Vector3 point_m = from_m + j / 20.0 * (to_m - from_m);
            EXPECT_GT(c.shape.nearest(point_m).distance_m, clear_m - kRounding_m) << i;
        }
        parted += is_parted ? 1 : 0;
        // Except near the rims of a cylinder, motions shorter than the gap are separated.
        const double room_m = c.shape.nearest(from_m).distance_m - clear_m - (to_m - from_m).norm();
        if (room_m > 0.0 && !std::holds_alternative<Cylinder>(c.size)) {
            ++far_off;
            EXPECT_TRUE(is_parted) << i;
        }
        EXPECT_FALSE(c.holds(from_m) && is_parted) << i;
    }
    EXPECT_GT(parted, 1000);
    EXPECT_TRUE(far_off > 1000 || GetParam() == 3);
}

TEST_P(AnalyticShapes, BoundsTouchTheFarthestPointsAlongTheAxes) {
    for (int i = 0; i < 500; ++i) {
        const PlacedShape c = random_case();
        const Eigen::AlignedBox3d bounds = c.shape.bounds();
        for (int axis = 0; axis < 3; ++axis) {
            const Vector3 u = c.placement.linear().row(axis).transpose(); // the axis, turned back
            const Vector3 max_m = c.placement * std::visit(Farthest{u}, c.size);
            const Vector3 min_m = c.placement * std::visit(Farthest{-u}, c.size);
            EXPECT_NEAR(bounds.max()[axis], max_m[axis], kRounding_m);
            EXPECT_NEAR(bounds.min()[axis], min_m[axis], kRounding_m);
        }
    }
}

TEST_P(AnalyticShapes, NormalsAreUnitWhereverTheQueryLies) {
    const std::vector<double> special = {0.0,   -0.0,   0.01,    0.02,         0.03,  0.05,
                                         1e-17, 1e-160, 5e-324,  1e6,          -0.01, -0.02,
                                         -0.03, -1e-17, -5e-324, 0.01 + 1e-17, -1e6};
    const std::vector<AnalyticShape::Size> sizes = {Plate{0.01, 0.02}, Sphere{0.02},
                                                    Box{{0.01, 0.02, 0.03}}, Cylinder{0.01, 0.02},
                                                    Capsule{0.01, 0.02}};
    const AnalyticShape::Size &size = sizes[static_cast<std::size_t>(GetParam())];
    const AnalyticShape shape(size, Eigen::Isometry3d::Identity(), 0);
    for (const double x : special) {
        for (const double y : special) {
            for (const double z : special) {
                const NearestOnShape nearest = shape.nearest({x, y, z});
                EXPECT_NEAR(nearest.normal.norm(), 1.0, 1e-15) << x << ' ' << y << ' ' << z;
                EXPECT_TRUE(nearest.point_m.allFinite());
                EXPECT_TRUE(std::isfinite(nearest.distance_m));
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Every, AnalyticShapes, ::testing::Range(0, 5), shape_name);

TEST(AnalyticShape, RefusesInvalidSizes) {
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const auto refuses = [&](const AnalyticShape::Size &size) {
        EXPECT_THROW(AnalyticShape(size, here, 0), std::invalid_argument);
    };
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    refuses(Plate{0.0, 1.0});
    refuses(Plate{1.0, -1.0});
    refuses(Sphere{0.0});
    refuses(Sphere{kNaN});
    refuses(Box{{1.0, 1.0, 0.0}});
    refuses(Cylinder{1.0, 0.0});
    refuses(Cylinder{std::numeric_limits<double>::infinity(), 1.0});
    refuses(Capsule{0.0, 1.0});
    refuses(Capsule{1.0, -1e-9});
    EXPECT_NO_THROW(AnalyticShape(Capsule{1.0, 0.0}, here, 0));
}

using testing::random_direction;
using testing::random_vector;

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

/// Never too near on the way, and within reach straight above the tip at its end.
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
            along(scene.rest.point_m, *slide, [&](const Vector3 &point_m) {
                EXPECT_GT(scene.shape().nearest(point_m).distance_m, reach_m - kRounding_m) << i;
            });
            const NearestOnShape under = scene.shape().nearest(slide->rest_m);
            EXPECT_NEAR(under.distance_m, reach_m, kRounding_m) << i;
            EXPECT_LT((under.point_m + slide->depth_m * -slide->normal - scene.tip_m).norm(),
                      kRounding_m);
            EXPECT_NEAR(slide->normal.norm(), 1.0, 1e-15);
            EXPECT_TRUE(!slide->is_flat || slide->over_m == slide->rest_m);
        }
        EXPECT_GT(slides, 1000);
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

INSTANTIATE_TEST_SUITE_P(Every, ShapeSlides, ::testing::Range(0, 5), shape_name);

std::optional<ShapeSlide> slide(const AnalyticShape::Size &size, const Vector3 &from_m,
                                const Vector3 &tip_m) {
    return slide_over_face(AnalyticShape(size, Eigen::Isometry3d::Identity(), 0), from_m, tip_m,
                           kClearance_m);
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
