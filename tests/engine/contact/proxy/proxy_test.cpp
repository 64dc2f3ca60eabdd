// Covers engine/contact/proxy/proxy.cpp, proxy_solver.cpp and haptic_surface.cpp: known shapes with
// known results, and Coulomb's law; what must hold on every shape, whatever the tip does; and on
// tessellated spheres, the nearest point found by brute force.
#include "engine/contact/proxy/proxy.h"

#include "base/degrees.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <type_traits>

namespace springdrive::contact {
namespace {

using testing::box_soup;
using testing::random_vector;
using testing::turned_inside_out;

/// Places of rest are known up to the clearance; round corners and roots of sums add to that.
constexpr double kPlace_m = 2.0 * kClearance_m;

const Vector3 kX = Vector3::UnitX();
const Vector3 kY = Vector3::UnitY();
const Vector3 kZ = Vector3::UnitZ();

/// A cube of 40 mm about the origin.
TriangleSoup cube(double eta = 0.0) {
    return box_soup(Vector3::Constant(-0.02), Vector3::Constant(0.02), eta);
}

/// Where the proxy ends when the tip moves straight from one place to another, in `ticks` steps.
Contact moved_tip(Proxy &proxy, const HapticSurface &mesh, const Vector3 &from, const Vector3 &to,
                  int ticks) {
    Contact contact;
    for (int i = 1; i <= ticks; ++i) {
        contact = proxy.update(mesh, from + (to - from) * i / ticks);
    }
    return contact;
}

/// Starts free at the first point and goes straight to each of the others.
Contact contact_after(const HapticSurface &mesh, std::initializer_list<Vector3> path,
                      int ticks = 10) {
    Proxy proxy;
    Contact contact;
    const Vector3 *before = nullptr;
    for (const Vector3 &point : path) {
        if (before == nullptr) {
            proxy.reset(point);
        } else {
            contact = moved_tip(proxy, mesh, *before, point, ticks);
        }
        before = &point;
    }
    return contact;
}

void expect_free_at(const Contact &contact, const Vector3 &tip) {
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.x0_m, tip);
    EXPECT_EQ(contact.tangent_projector, Matrix3::Identity());
    EXPECT_EQ(contact.normal, Vector3::Zero());
    EXPECT_EQ(contact.eta, 1.0);
    EXPECT_EQ(contact.active_constraints, 0);
}

static_assert(std::is_nothrow_move_constructible_v<HapticSurface>);

TEST(Proxy, IsTheTipOnAnEmptyMesh) {
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    expect_free_at(proxy.update(HapticSurface(), kX), kX);
    expect_free_at(proxy.update(HapticSurface(TriangleSoup()), kY), kY);
}

TEST(Proxy, RestsOverTheTipOnAFace) {
    const HapticSurface mesh(cube(0.25));
    const Contact contact = contact_after(mesh, {{0.001, 0.03, 0.002}, {0.003, 0.01, 0.004}});
    EXPECT_TRUE(contact.touching);
    EXPECT_LT((contact.x0_m - Vector3(0.003, 0.02, 0.004)).norm(), kPlace_m);
    EXPECT_GT(contact.x0_m.y(), 0.02);
    EXPECT_LT((contact.normal - kY).norm(), 1e-12);
    EXPECT_LT((contact.tangent_projector - (Matrix3::Identity() - kY * kY.transpose())).norm(),
              1e-12);
    EXPECT_EQ(contact.active_constraints, 1);
    EXPECT_EQ(contact.eta, 0.25);
    EXPECT_TRUE(contact.triangle == 6 || contact.triangle == 7); // box_soup's top
}

TEST(Proxy, MovesAroundAConvexEdgeWithinOneTick) {
    const HapticSurface mesh(cube());
    Proxy proxy;
    proxy.reset({0.019, 0.03, 0.0});
    EXPECT_LT(proxy.update(mesh, {0.019, 0.018, 0.0}).normal.x(), 0.5); // on the top
    // The tip moves on within the cube, to where the side is near and the top out of reach.
    const Contact contact = proxy.update(mesh, {0.0205, 0.01, 0.0});
    expect_free_at(contact, {0.0205, 0.01, 0.0});
    const Contact side = proxy.update(mesh, {0.018, 0.005, 0.0});
    EXPECT_LT((side.x0_m - Vector3(0.02, 0.005, 0.0)).norm(), kPlace_m);
    EXPECT_LT((side.normal - kX).norm(), 1e-12);
}

TEST(Proxy, HasTwoConstraintsInAConcaveEdge) {
    const HapticSurface room(turned_inside_out(cube()));
    const Contact contact = contact_after(room, {Vector3::Zero(), {0.023, -0.024, 0.005}}, 1);
    EXPECT_LT((contact.x0_m - Vector3(0.02, -0.02, 0.005)).norm(), kPlace_m);
    EXPECT_EQ(contact.active_constraints, 2);
    EXPECT_LT((contact.tangent_projector - kZ * kZ.transpose()).norm(), 1e-12);
    EXPECT_LT((contact.normal - Vector3(-0.6, 0.8, 0.0)).norm(), 1e-4); // clearance over gap
}

TEST(Proxy, HasTwoConstraintsWhereTwoSolidsCross) {
    // An L of two boxes that overlap without sharing an edge.
    const HapticSurface mesh(testing::joined(box_soup({-0.05, -0.02, -0.05}, {0.05, 0.0, 0.05}),
                                             box_soup({-0.05, -0.01, -0.05}, {0.0, 0.03, 0.05})));
    const Contact contact = contact_after(mesh, {{0.01, 0.01, 0.0}, {-0.003, -0.004, 0.01}}, 3);
    EXPECT_LT((contact.x0_m - Vector3(0.0, 0.0, 0.01)).norm(), kPlace_m);
    EXPECT_EQ(contact.active_constraints, 2);
    EXPECT_LT((contact.tangent_projector - kZ * kZ.transpose()).norm(), 1e-12);
}

TEST(Proxy, ReachesIntoAnAcuteWedgeOnlyAsFarAsItsClearanceAllows) {
    // Two sheets that meet in the line x = y = 0 at 2 · 0.01 rad and open towards +x.
    TriangleSoup wedge;
    for (const double side : {1.0, -1.0}) {
        const double y = side * 0.05 * std::tan(0.01);
        testing::add_triangle(wedge,
                              {Vector3(0, 0, -0.05), Vector3(0, 0, 0.05), Vector3(0.05, y, 0)});
    }
    const HapticSurface mesh(wedge);
    const Contact contact = contact_after(mesh, {{0.03, 0.0, 0.0}, {-0.02, 0.0, 0.0}});
    EXPECT_EQ(contact.active_constraints, 2);
    EXPECT_NEAR(contact.x0_m.x(), kClearance_m / std::sin(0.01), 1e-9);
    EXPECT_NEAR(contact.x0_m.y(), 0.0, 1e-9);
}

TEST(Proxy, TakesTheMostRigidOfTheMaterialsItTouches) {
    TriangleSoup room = turned_inside_out(cube(0.75));
    room.materials.push_back({"floor", 0.5});
    room.material_of_triangle[4] = room.material_of_triangle[5] = 1; // box_soup's bottom
    const HapticSurface mesh(room);
    EXPECT_EQ(contact_after(mesh, {Vector3::Zero(), 0.03 * kX}).eta, 0.75);
    const Contact on_floor = contact_after(mesh, {Vector3::Zero(), -0.03 * kY});
    EXPECT_EQ(on_floor.eta, 0.5);
    EXPECT_EQ(on_floor.material, 1);
    EXPECT_NEAR(on_floor.surface_m.y(), -0.02, 1e-15);
    EXPECT_EQ(contact_after(mesh, {Vector3::Zero(), 0.03 * kX - 0.04 * kY}).eta, 0.5);
}

TEST(Proxy, LeavesASolidFreelyAndThenFindsItTouchable) {
    const HapticSurface mesh(cube());
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    for (int i = 0; i <= 30; ++i) {
        const Vector3 tip(0.0, 0.001 * i, 0.0);
        expect_free_at(proxy.update(mesh, tip), tip);
    }
    const Contact contact = proxy.update(mesh, {0.0, 0.01, 0.0});
    EXPECT_LT((contact.x0_m - 0.02 * kY).norm(), kPlace_m);
}

TEST(Proxy, IsHeldByAnOpenSheetFromBothSides) {
    const HapticSurface mesh(testing::sheet(5, 0.05));
    for (const double side : {1.0, -1.0}) {
        const Contact contact =
            contact_after(mesh, {{0.003, side * 0.01, 0.0}, {0.011, -side * 0.02, 0.007}});
        EXPECT_LT((contact.x0_m - Vector3(0.011, 0.0, 0.007)).norm(), kPlace_m);
        EXPECT_GT(side * contact.x0_m.y(), 0.0);
        EXPECT_LT((contact.normal - side * kY).norm(), 1e-12);
        EXPECT_EQ(contact.active_constraints, 1);
    }
}

TEST(Proxy, SlipsRoundTheBorderOfAnOpenSheet) {
    const HapticSurface mesh(testing::sheet(5, 0.05));
    Proxy proxy;
    proxy.reset({0.04, 0.01, 0.0});
    EXPECT_TRUE(proxy.update(mesh, {0.04, -0.01, 0.0}).touching);
    expect_free_at(proxy.update(mesh, {0.06, -0.01, 0.0}), {0.06, -0.01, 0.0});
    expect_free_at(proxy.update(mesh, {0.0, -0.01, 0.0}), {0.0, -0.01, 0.0});
}

TEST(Proxy, ForgetsWhatHeldItOnAnotherSurface) {
    const HapticSurface fine(testing::icosphere(4, 0.03));
    const HapticSurface coarse(cube());
    Proxy proxy;
    proxy.reset({0.0, 0.05, 0.0});
    EXPECT_TRUE(proxy.update(fine, {0.0, 0.028, 0.0}).touching);
    const Contact contact = proxy.update(coarse, {0.001, 0.017, 0.0});
    EXPECT_TRUE(contact.touching);
    EXPECT_LT((contact.x0_m - Vector3(0.001, 0.02, 0.0)).norm(), kPlace_m);
    EXPECT_FALSE(proxy.update(HapticSurface(), {0.001, 0.017, 0.0}).touching);
}

TEST(Proxy, SurvivesATipThatIsNotFinite) {
    const HapticSurface mesh(cube());
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Proxy proxy;
    proxy.reset({0.0, 0.03, 0.0});
    const Contact before = proxy.update(mesh, {0.0, 0.01, 0.0});
    for (const double bad : {kNaN, kInfinity, -kInfinity, 1e200}) {
        const Contact contact = proxy.update(mesh, {0.0, bad, 0.0});
        expect_free_at(contact, before.x0_m);
        proxy.reset({bad, 0.0, 0.0});
    }
    const Contact after = proxy.update(mesh, {0.0, 0.01, 0.0});
    EXPECT_EQ(after.x0_m, before.x0_m);
    EXPECT_TRUE(after.touching);
}

/// How much farther from the tip a proxy may end: it steps over ridges of up to 10 µm and descends
/// on their other side.
constexpr double kJump_m = 1.2e-5;

/// A box that protrudes from the top of another. In their crease, an extrapolated slide on one of
/// them once ended 35 mm away around an edge.
TEST(ProxySolver, IsNotCarriedAwayFromTheTipInACrease) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() =
        Vector3(-0.016851951473135212, 0.01693078811656986, -0.0043772161063318181);
    pose.linear() << 0.18458380798980045, -0.38106674033730736, 0.90593430072863645, //
        0.34153266664254511, -0.83945673057696568, -0.42269118172143555,             //
        0.92156619699510278, 0.38742810545665202, -0.024803379976381601;
    const HapticSurface surface(
        testing::box_soup({-0.04, -0.05, -0.04}, {0.04, 0.0, 0.04}),
        {AnalyticShape(Box{{0.0059338335564660593, 0.013667825344417399, 0.019736503283795708}},
                       pose, 0)});
    const Vector3 from_m(-0.0058666682528241785, 0.00059118778190269533, 0.0059168305426440648);
    const Vector3 tip_m(-0.0070584584738168331, -0.0016894539568893206, 0.00076325675554547614);
    Proxy proxy;
    proxy.reset(from_m);
    const Contact contact = proxy.update(surface, tip_m);
    EXPECT_TRUE(contact.settled);
    EXPECT_LT((contact.x0_m - tip_m).norm(), (from_m - tip_m).norm());
    for (const Vector3 &place_m : proxy.path()) {
        EXPECT_LE((place_m - tip_m).norm(), (from_m - tip_m).norm() + kJump_m);
    }
}

TEST(ProxySolver, NeverEndsFartherFromTheTipThanItBegan) {
    constexpr int kTicks = 600;
    constexpr double kStep_m = 7e-4;
    constexpr double kDeepest_m = 6e-3;
    constexpr std::array kReaches_m{kClearance_m, 1e-3};
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        std::mt19937_64 random(seed);
        Eigen::Isometry3d pose(
            Eigen::AngleAxisd(static_cast<double>(seed), testing::random_direction(random)));
        pose.translation() = testing::random_vector(random, 0.03);
        const AnalyticShape shape(Cylinder{0.02, 0.02}, pose, 0);
        const HapticSurface surface(testing::bumpy_sphere(3, 0.03), {shape});
        Proxy proxy(kReaches_m[seed % 2]);
        Vector3 tip_m = 0.08 * testing::random_direction(random);
        proxy.reset(tip_m);
        Vector3 heading = -tip_m.normalized();
        Vector3 before_m = tip_m;
        for (int tick = 0; tick < kTicks; ++tick) {
            heading = (heading + 0.2 * testing::random_direction(random)).normalized();
            if ((before_m - tip_m).norm() > kDeepest_m || tip_m.norm() > 0.08) {
                heading = ((tip_m.norm() > 0.08 ? Vector3::Zero() : before_m) - tip_m).normalized();
            }
            tip_m += kStep_m * heading;
            const Contact contact = proxy.update(surface, tip_m);
            ASSERT_LE((contact.x0_m - tip_m).norm(), (before_m - tip_m).norm() + kJump_m)
                << "seed " << seed << ", tick " << tick;
            before_m = contact.x0_m;
        }
    }
}

HapticSurface floor_with(double static_friction, double dynamic_friction) {
    TriangleSoup soup = testing::box_soup({-0.1, -0.02, -0.1}, {0.1, 0.0, 0.1});
    soup.materials[0].static_friction = static_friction;
    soup.materials[0].dynamic_friction = dynamic_friction;
    return HapticSurface(soup);
}

/// Between the force and the floor's normal [rad].
double angle(const Contact &contact) {
    return std::atan2(std::hypot(contact.normal.x(), contact.normal.z()), contact.normal.y());
}

/// A proxy pressed straight into the floor at x.
Proxy pressed(const HapticSurface &floor, double x_m, double depth_m) {
    Proxy proxy;
    proxy.reset({x_m, 0.01, 0.0});
    static_cast<void>(proxy.update(floor, {x_m, -depth_m, 0.0}));
    return proxy;
}

TEST(Friction, SlipsAtTheAngleOfTheStaticAndSlidesAtThatOfTheDynamicCoefficient) {
    std::mt19937_64 random(1);
    for (int i = 0; i < 40; ++i) {
        const double mu_s = 0.05 + 0.05 * (i % 20);
        const double mu_d = 0.7 * mu_s;
        const HapticSurface floor = floor_with(mu_s, mu_d);
        const double depth_m = 1e-3 + 1e-4 * static_cast<double>(random() % 30);
        const double heading = 0.1 * static_cast<double>(random() % 60);
        Proxy proxy = pressed(floor, 0.0, depth_m);
        double slipped_at = 0.0;
        double sliding_at = 0.0;
        // Steps of 2 µm: at a depth of a millimetre a tenth of a degree.
        for (int step = 1; step < 4000; ++step) {
            const double way_m = 2e-6 * step;
            const Contact contact = proxy.update(
                floor, {way_m * std::cos(heading), -depth_m, way_m * std::sin(heading)});
            ASSERT_TRUE(contact.touching);
            if (contact.sticking) {
                ASSERT_EQ(contact.tangent_projector, Matrix3::Zero());
                slipped_at = angle(contact);
            } else {
                sliding_at = angle(contact);
                ASSERT_EQ(contact.active_constraints, 1);
            }
        }
        EXPECT_NEAR(slipped_at, std::atan(mu_s), 0.2 * kRadiansPerDegree);
        EXPECT_NEAR(sliding_at, std::atan(mu_d), 0.01 * kRadiansPerDegree);
    }
}

TEST(Friction, DoesNotCreepWhileItSticks) {
    // For 20 s at 1 kHz, the tip trembling within the cone of friction.
    const HapticSurface floor = floor_with(0.4, 0.3);
    Proxy proxy = pressed(floor, 0.01, 2e-3);
    const Vector3 held = proxy.update(floor, {0.01, -2e-3, 0.0}).x0_m;
    for (int tick = 0; tick < 20000; ++tick) {
        const double t = 1e-3 * tick;
        const Vector3 vibration(0.7e-3 * std::sin(9.0 * t), 1e-4 * std::sin(50.0 * t),
                                1e-4 * t / 20.0);
        const Contact contact = proxy.update(floor, Vector3(0.01, -2e-3, 0.0) + vibration);
        ASSERT_TRUE(contact.sticking);
        ASSERT_EQ(contact.x0_m, held) << "tick " << tick;
    }
}

TEST(Friction, SlipsRightOutsideOfItsConeAndNotRightInside) {
    const HapticSurface floor = floor_with(0.5, 0.5);
    for (const double share : {0.99999, 1.00001}) {
        Proxy proxy = pressed(floor, 0.0, 1e-3);
        const Contact contact =
            proxy.update(floor, {0.0, -1e-3, share * 0.5 * (1e-3 + kClearance_m)});
        EXPECT_EQ(contact.sticking, share < 1.0);
    }
}

TEST(Friction, ReleasesWhereTheTipLeaves) {
    const HapticSurface floor = floor_with(0.8, 0.8);
    Proxy proxy = pressed(floor, 0.0, 1e-3);
    const Vector3 above(0.0, 1e-3, 0.0);
    const Contact contact = proxy.update(floor, above);
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.x0_m, above);
}

/// The hand's work on the spring between tip and proxy over a closed path, over the stiffness [m²].
/// @param tip_at  place of the tip from 0 to 1, above the surface at both
template <typename TipAt> double work_over_m2(const HapticSurface &surface, const TipAt &tip_at) {
    Vector3 tip = tip_at(0.0);
    Proxy proxy;
    proxy.reset(tip);
    double work_m2 = 0.0;
    constexpr int kSteps = 4000;
    for (int i = 1; i <= kSteps; ++i) {
        const Contact contact = proxy.update(surface, tip);
        const Vector3 next = tip_at(static_cast<double>(i) / kSteps);
        if (contact.touching) {
            // The proxy stays over the step, so the spring's energy is exact at both its ends.
            work_m2 +=
                0.5 * ((contact.x0_m - next).squaredNorm() - (contact.x0_m - tip).squaredNorm());
        }
        tip = next;
    }
    return work_m2;
}

/// A depth that begins and ends 2 mm above the surface and is 4 mm between.
double height_m(double turn) { return 2e-3 - 6e-3 * std::sin(0.5 * turn) * std::sin(0.5 * turn); }

/// The proxy is constant within a tick, which always costs the hand work: the nearest point would
/// have followed.
TEST(Proxy, GivesBackNoMoreWorkThanItTakesOnAnyClosedPath) {
    constexpr double kFullTurn = 2.0 * std::numbers::pi;
    std::mt19937_64 random(2);
    for (int path = 0; path < 30; ++path) {
        const HapticSurface floor = floor_with(0.1 * (path % 9), 0.07 * (path % 9));
        const double a = 1.0 + 0.1 * static_cast<double>(random() % 10);
        EXPECT_GT(work_over_m2(floor,
                               [&](double s) {
                                   return Vector3(0.02 * std::sin(kFullTurn * s),
                                                  height_m(kFullTurn * s),
                                                  0.01 * std::sin(2.0 * kFullTurn * s) * a);
                               }),
                  -1e-12);
    }
    for (const int level : {1, 3, 5}) {
        constexpr double kBallRadius_m = 0.05;
        const HapticSurface ball(testing::icosphere(level, kBallRadius_m));
        for (int path = 0; path < 10; ++path) {
            const Vector3 a = testing::random_direction(random);
            const Vector3 b = testing::random_direction(random);
            const auto tip_at = [&](double s) {
                const double t = kFullTurn * s;
                const Vector3 u =
                    a + 0.5 * std::cos(t) * b + 0.3 * std::sin(t) * a.unitOrthogonal();
                return Vector3((kBallRadius_m + height_m(t)) * u.normalized());
            };
            EXPECT_GT(work_over_m2(ball, tip_at), -1e-15); // round-off of 4000 terms of 1e-6 m²
        }
    }
}

using testing::corners;
using testing::random_direction;

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

constexpr double kSphereRadius_m = 0.05;

/// A tip that moves around under the surface at 0.1 m/s and 1 kHz, 1 to 2 mm deep.
class Lissajous {
public:
    Vector3 next() {
        const Vector3 now = direction(phase_);
        const double per_phase = (direction(phase_ + 1e-6) - now).norm() / 1e-6;
        phase_ += 1e-4 / kSphereRadius_m / std::max(per_phase, 1e-3);
        return (kSphereRadius_m - 1.5e-3 - 0.5e-3 * std::sin(40.0 * phase_)) * now;
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
    const TriangleSoup soup = testing::icosphere(GetParam(), kSphereRadius_m);
    const HapticSurface surface(soup);
    const auto [a, b, c] = testing::corners(soup, 0);
    const double edge_m = (b - a).norm();
    // Largest angle between a facet and the sphere: at its corners, for triangles that are not
    // quite equilateral a quarter more than edge / (√3 R).
    const double facet_angle = 1.25 * edge_m / (std::sqrt(3.0) * kSphereRadius_m);
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
