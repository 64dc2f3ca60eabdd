// Covers engine/contact/proxy/proxy.cpp and engine/contact/proxy/haptic_surface.cpp: known shapes
// with known results. Properties of any shape and path are in proxy_walk_test.cpp.
#include "engine/contact/proxy/proxy.h"

#include "tests/engine/contact/mesh/soups.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
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

TEST(Proxy, IsTheTipInFreeSpace) {
    const HapticSurface mesh(cube());
    Proxy proxy;
    proxy.reset({0.0, 0.05, 0.0});
    std::mt19937_64 random(1);
    for (int i = 0; i < 1000; ++i) {
        const Vector3 tip = Vector3(0.0, 0.05, 0.0) + random_vector(random, 0.029);
        expect_free_at(proxy.update(mesh, tip), tip);
    }
}

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

TEST(Proxy, ArrivesAtTheSamePlaceInOneTickAsInMany) {
    const HapticSurface mesh(cube());
    for (const int ticks : {1, 7, 1000}) {
        const Contact contact =
            contact_after(mesh, {{-0.015, 0.03, 0.0}, {0.015, 0.018, 0.01}}, ticks);
        EXPECT_LT((contact.x0_m - Vector3(0.015, 0.02, 0.01)).norm(), kPlace_m);
    }
}

TEST(Proxy, IsFreeAfterTheTipLeavesTheSurface) {
    const HapticSurface mesh(cube());
    const Vector3 end(0.001, 0.0201, 0.0);
    expect_free_at(contact_after(mesh, {{0, 0.03, 0}, {0, 0.015, 0}, end}), end);
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

TEST(Proxy, HasThreeConstraintsInACorner) {
    const HapticSurface room(turned_inside_out(cube()));
    const Contact contact = contact_after(room, {Vector3::Zero(), {0.03, -0.04, 0.05}}, 1);
    EXPECT_LT((contact.x0_m - Vector3(0.02, -0.02, 0.02)).norm(), kPlace_m);
    EXPECT_EQ(contact.active_constraints, 3);
    EXPECT_EQ(contact.tangent_projector, Matrix3::Zero());
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
    EXPECT_EQ(contact_after(mesh, {Vector3::Zero(), -0.03 * kY}).eta, 0.5);
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

TEST(Proxy, StaysBoundedAmongRandomTriangles) {
    std::mt19937_64 random(3);
    const HapticSurface mesh(testing::random_soup(random, 3000, 0.03, 0.02));
    Proxy proxy;
    proxy.reset(Vector3::Zero());
    for (int i = 0; i < 5000; ++i) {
        const Contact contact = proxy.update(mesh, random_vector(random, 0.05));
        ASSERT_TRUE(contact.x0_m.allFinite());
        ASSERT_LT(contact.x0_m.norm(), 0.1);
    }
}

TEST(HapticSurface, ReportsItsContents) {
    const HapticSurface mesh(cube());
    EXPECT_EQ(mesh.report().triangles_kept, 12U);
    EXPECT_EQ(mesh.report().closed_components, 1U);
    EXPECT_EQ(HapticSurface().report().triangles_kept, 0U);
    SearchBudget budget{1000};
    const std::optional<SurfaceStop> hit =
        mesh.first_stop(0.04 * kY, Vector3::Zero(), kClearance_m, budget);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->stop.fraction, (0.02 - kClearance_m) / 0.04, 1e-12);
}

} // namespace
} // namespace springdrive::contact
