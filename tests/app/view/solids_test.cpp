// Covers app/view/solids.cpp: shapes, where they are placed, and
// that no part of the linkage passes through another.

#include "app/view/marks.h"
#include "app/view/solids.h"
#include "app/view/view_state.h"
#include "tests/support/devices.h"
#include "tests/support/framed_box.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

constexpr double kFloat_m = 1e-6; // of coordinates below a metre in float, summed a few times

glm::vec3 to_vec3(const std::array<float, 3> &v) { return {v[0], v[1], v[2]}; }

/// The position of a point of the unit shape in the world.
Vector3 placed(const Solid &solid, const glm::vec3 &point) {
    return to_vector3(glm::vec3(solid.model * glm::vec4(point, 1.0F)));
}

Vector3 start_of(const Solid &solid) { return placed(solid, {0.0F, 0.0F, 0.0F}); }
Vector3 end_of(const Solid &solid) { return placed(solid, {0.0F, 0.0F, 1.0F}); }

Solid only_one(const std::vector<Solid> &solids, Shape shape) {
    const auto is_it = [&](const Solid &solid) { return solid.shape == shape; };
    EXPECT_EQ(std::count_if(solids.begin(), solids.end(), is_it), 1);
    const auto found = std::find_if(solids.begin(), solids.end(), is_it);
    return found == solids.end() ? Solid{} : *found;
}

class EveryShape : public ::testing::TestWithParam<Shape> {};

TEST_P(EveryShape, IsWoundOutwardAlongItsNormals) {
    const ShapeMesh mesh = make_shape(GetParam());
    int with_area = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const scene::VisualVertex &a = mesh.vertices.at(mesh.indices[i]);
        const scene::VisualVertex &b = mesh.vertices.at(mesh.indices[i + 1]);
        const scene::VisualVertex &c = mesh.vertices.at(mesh.indices[i + 2]);
        const glm::vec3 area = glm::cross(to_vec3(b.position_m) - to_vec3(a.position_m),
                                          to_vec3(c.position_m) - to_vec3(a.position_m));
        if (glm::length(area) < 1e-5F) {
            continue; // at a pole
        }
        ++with_area;
        for (const scene::VisualVertex *corner : {&a, &b, &c}) {
            ASSERT_NEAR(glm::length(to_vec3(corner->normal)), 1.0F, 1e-5F);
            ASSERT_GT(glm::dot(area, to_vec3(corner->normal)), 0.0F);
        }
    }
    EXPECT_GT(with_area, 40);
}

/// Divergence theorem: the volume within is a third of the flux of the position.
TEST_P(EveryShape, EnclosesItsVolume) {
    const ShapeMesh mesh = make_shape(GetParam());
    double volume = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::vec3 a = to_vec3(mesh.vertices[mesh.indices[i]].position_m);
        const glm::vec3 b = to_vec3(mesh.vertices[mesh.indices[i + 1]].position_m);
        const glm::vec3 c = to_vec3(mesh.vertices[mesh.indices[i + 2]].position_m);
        volume += static_cast<double>(glm::dot(a, glm::cross(b, c))) / 6.0;
    }
    constexpr double kPi = std::numbers::pi;
    const auto end = static_cast<double>(kTaperEnd);
    const double half_thickness = static_cast<double>(kRingThickness) / 2.0;
    double expected = 0.0;
    switch (GetParam()) {
    case Shape::ball:
        expected = 4.0 / 3.0 * kPi;
        break;
    case Shape::cylinder:
        expected = kPi;
        break;
    case Shape::taper:
        expected = kPi / 3.0 * (1.0 + end + end * end);
        break;
    case Shape::cone:
        expected = kPi / 3.0;
        break;
    case Shape::ring:
        expected = 2.0 * kPi * kPi * half_thickness * half_thickness;
        break;
    }
    // Facets lie inside: an octagon, the coarsest outline here, has 0.90 of its circle's area.
    EXPECT_LT(volume, expected);
    EXPECT_GT(volume, 0.88 * expected);
}

INSTANTIATE_TEST_SUITE_P(All, EveryShape, ::testing::ValuesIn(kShapes));

TEST(Spindle, RunsFromPointToPointAtItsRadiusUnmirrored) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> coordinate(-0.3, 0.3);
    for (int i = 0; i < 200; ++i) {
        const Vector3 from_m(coordinate(random), coordinate(random), coordinate(random));
        const Vector3 to_m(coordinate(random), coordinate(random), coordinate(random));
        const Solid solid = spindle(Shape::cylinder, from_m, to_m, 0.02, kForceColour);
        ASSERT_LT((start_of(solid) - from_m).norm(), kFloat_m);
        ASSERT_LT((end_of(solid) - to_m).norm(), kFloat_m);
        const Vector3 side_m = placed(solid, {0.6F, 0.8F, 0.0F}) - from_m;
        ASSERT_NEAR(side_m.norm(), 0.02, kFloat_m);
        ASSERT_NEAR(side_m.dot((to_m - from_m).normalized()), 0.0, kFloat_m);
        ASSERT_GT(glm::determinant(glm::mat3(solid.model)), 0.0F);
    }
}

TEST(Spindle, PointsOfSolidsAreWhereTheyAreDrawn) {
    const std::vector<Solid> solids{
        spindle(Shape::cylinder, {0.0, 0.1, 0.0}, {0.0, 0.4, 0.0}, 0.02, kTipColour)};
    Vector3 lower_m = Vector3::Constant(1e9);
    Vector3 upper_m = Vector3::Constant(-1e9);
    for (const Vector3 &point_m : drawn_points(solids)) {
        lower_m = lower_m.cwiseMin(point_m);
        upper_m = upper_m.cwiseMax(point_m);
    }
    EXPECT_LT((lower_m - Vector3(-0.02, 0.1, -0.02)).norm(), kFloat_m);
    EXPECT_LT((upper_m - Vector3(0.02, 0.4, 0.02)).norm(), kFloat_m);
}

TEST(LinkageSolids, ForearmRunsFromTheElbowToTheTip) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const device::LinkagePose pose = device::linkage_pose(geometry, Vector3(0.3, 0.2, -0.15));
    const Solid forearm = only_one(linkage_solids(pose, -0.06, false), Shape::taper);
    EXPECT_LT((start_of(forearm) - pose.elbow_m).norm(), kFloat_m);
    EXPECT_LT((end_of(forearm) - pose.tip_m).norm(), kFloat_m);
}

TEST(LinkageSolids, AreFiniteWhereTheLinkageIsSingularToo) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    constexpr double kRightAngle = std::numbers::pi / 2.0;
    for (const Vector3 &q : {Vector3(0.0, 0.0, kRightAngle), Vector3(0.0, kRightAngle, 0.0),
                             Vector3(0.5, 0.0, -kRightAngle)}) {
        const device::LinkagePose pose = device::linkage_pose(geometry, q);
        for (const Solid &solid : linkage_solids(pose, -0.06, false)) {
            ASSERT_TRUE(start_of(solid).allFinite() && end_of(solid).allFinite());
            ASSERT_GT(glm::determinant(glm::mat3(solid.model)), 0.0F);
        }
    }
}

TEST(LinkageSolids, AreRedWhenTripped) {
    const device::PhantomGeometry geometry = testing::phantom_1_0().geometry;
    const device::LinkagePose pose = device::linkage_pose(geometry, Vector3::Zero());
    for (const Solid &solid : linkage_solids(pose, -0.06, true)) {
        EXPECT_GT(solid.colour.r, 2.0F * solid.colour.g);
        EXPECT_GT(solid.colour.r, 2.0F * solid.colour.b);
    }
}

/// Inside the unit shape by more than float's rounding of coordinates; see
/// solids.h.
bool is_inside(Shape shape, const glm::vec4 &at) {
    constexpr float kInside = 1.0F - 1e-4F;
    const float across = std::hypot(at.x, at.y);
    if (shape == Shape::ball) {
        return std::hypot(across, at.z) < kInside;
    }
    const float radius = shape == Shape::taper ? 1.0F + at.z * (kTaperEnd - 1.0F) : 1.0F;
    return at.z > 1.0F - kInside && at.z < kInside && across < kInside * radius;
}

/// Points all over the surface, in the world.
std::vector<glm::vec4> surface_points(const Solid &solid) {
    constexpr int kAroundShape = 16;
    constexpr int kAlongShape = 40;
    std::vector<glm::vec4> points;
    for (int row = 0; row <= kAlongShape; ++row) {
        for (int column = 0; column < kAroundShape; ++column) {
            const float angle =
                2.0F * std::numbers::pi_v<float> * static_cast<float>(column) / kAroundShape;
            const float along = static_cast<float>(row) / kAlongShape;
            float radius = solid.shape == Shape::taper ? 1.0F + along * (kTaperEnd - 1.0F) : 1.0F;
            float z = along;
            if (solid.shape == Shape::ball) {
                z = 2.0F * along - 1.0F;
                radius = std::sqrt(std::max(0.0F, 1.0F - z * z));
            }
            points.push_back(solid.model * glm::vec4(radius * std::cos(angle),
                                                     radius * std::sin(angle), z, 1.0F));
        }
    }
    return points;
}

/// A joint's axis, about which two parts meet, and how far from it.
struct Joint {
    Vector3 at_m{Vector3::Zero()};
    double radius_m = 0.0;
};

/// Where a pair may meet: not at all where the radius is 0. The radii are those
/// of the drums and pins of solids.cpp, with a tenth of a millimetre
/// for facets and rounding.
Joint joint_of(LinkagePart a, LinkagePart b, const device::LinkagePose &pose) {
    using enum LinkagePart;
    const auto is = [&](LinkagePart first, LinkagePart second) {
        return (a == first && b == second) || (a == second && b == first);
    };
    if (is(base, upper_arm) || is(base, crank)) {
        return {pose.base_m, 0.0171};
    }
    if (is(upper_arm, forearm)) {
        return {pose.elbow_m, 0.0086};
    }
    if (is(crank, rod)) {
        return {pose.crank_m, 0.0049};
    }
    if (is(rod, forearm)) {
        return {pose.coupling_m, 0.0049};
    }
    return {};
}

Vector3 axis_of(double q1_rad) { return {std::cos(q1_rad), 0.0, -std::sin(q1_rad)}; }

class Linkage : public ::testing::TestWithParam<device::DeviceDescription> {};

TEST_P(Linkage, NoPartPassesThroughAnotherAwayFromTheirJoint) {
    const device::DeviceDescription &device = GetParam();
    const double floor_m = device.workspace.centre_m.y() - device.workspace.size_m.y() / 2.0;
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> share(-0.5, 0.5);
    std::set<std::pair<LinkagePart, LinkagePart>> met;
    int poses = 0;
    for (int trial = 0; poses < 60 && trial < 1000; ++trial) {
        const Vector3 tip_m =
            device.workspace.centre_m + device.workspace.size_m.cwiseProduct(
                                            Vector3(share(random), share(random), share(random)));
        const auto q_rad = device::joint_angles_rad(device.geometry, tip_m);
        if (!q_rad || !device.joint_limits.allow(*q_rad)) {
            continue;
        }
        ++poses;
        const device::LinkagePose pose = device::linkage_pose(device.geometry, *q_rad);
        const Vector3 axis = axis_of((*q_rad)[0]);
        const std::vector<LinkageSolid> parts = linkage_parts(pose, floor_m, false);
        for (const LinkageSolid &one : parts) {
            const std::vector<glm::vec4> points = surface_points(one.solid);
            for (const LinkageSolid &other : parts) {
                if (one.part == other.part) {
                    continue;
                }
                const Joint joint = joint_of(one.part, other.part, pose);
                const glm::mat4 to_shape = glm::inverse(other.solid.model);
                for (const glm::vec4 &point : points) {
                    if (!is_inside(other.solid.shape, to_shape * point)) {
                        continue;
                    }
                    met.insert(std::minmax(one.part, other.part));
                    const Vector3 offset_m = Vector3(point.x, point.y, point.z) - joint.at_m;
                    const double from_axis_m = (offset_m - offset_m.dot(axis) * axis).norm();
                    ASSERT_LT(from_axis_m, joint.radius_m)
                        << "part " << static_cast<int>(one.part) << " is inside part "
                        << static_cast<int>(other.part) << " with the tip at " << tip_m.transpose();
                }
            }
        }
    }
    EXPECT_EQ(poses, 60);
    // Not vacuous: what shares a joint was found to meet; the crank's hub touches
    // the motors only.
    EXPECT_EQ(met.size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(Devices, Linkage,
                         ::testing::Values(testing::phantom_1_0(), testing::phantom_premium_1_5()));

constexpr PixelSize kFlatViewport{880.0, 485.0};

const Camera &flat_camera() {
    static const Camera kCamera =
        testing::framed_box(Vector3::Constant(-0.1), Vector3::Constant(0.1), kFlatViewport);
    return kCamera;
}

MarkerScale flat_scale() { return {flat_camera(), kFlatViewport.height_px, 1.0}; }

/// A touch at which there is something of everything, whatever is switched on.
ViewState full_state() {
    ViewState state;
    state.tip_m = {0.010, 0.002, 0.000};
    state.proxy_m = {0.010, 0.005, 0.000};
    state.normal = Vector3(0.0, 1.0, 0.2).normalized();
    state.tip_force_N = {0.1, 1.5, 0.0};
    state.hand_target_m = {0.010, -0.002, 0.000};
    state.touching = true;
    state.below = {{0.010, -0.050, 0.000}, Vector3::UnitY()};
    state.touch.inverse_force_N = {0.8, 1.2, 0.0};
    state.touch.transpose_force_N = {0.0, 1.5, 0.3};
    state.touch.set_point_m = {0.010, 0.004, 0.000};
    Matrix3 K;
    K << 3000.0, 500.0, 0.0, 500.0, 1500.0, 100.0, 0.0, 100.0, 2000.0;
    state.touch.inverse_stiffness_N_per_m = K;
    state.touch.transpose_stiffness_N_per_m = 1280.0;
    state.touch.trace_N = {
        {{0.0, 0.05, 0.0}, 0.0}, {{0.0, 0.02, 0.0}, 1.0}, {{0.01, 0.0, 0.0}, 9.0}};
    auto field = std::make_shared<WorkspaceField>();
    field->places = {{{0.05, 0.05, 0.05}, 0.1}, {{-0.05, 0.05, 0.05}, 0.7}};
    field->largest = 0.7;
    state.touch.workspace = field;
    return state;
}

/// What is drawn, counted by its kind.
struct MarksDrawn {
    std::size_t solids = 0;
    std::size_t flat = 0;

    bool operator==(const MarksDrawn &) const = default;
};

MarksDrawn marks_drawn(const ViewState &state) {
    const MarkerScale scale = flat_scale();
    const std::size_t solids = marker_solids(state, scale).size() +
                               tip_marks(state, scale).tip.size() +
                               height_line(state, scale).size() + stiffness_bodies(state).size();
    return {solids, flat_marks(state, scale).size()};
}

TEST(ShownThings, EachSwitchTakesSomethingAway) {
    ViewState all = full_state();
    for (const OverlayStyle &look : kThings) {
        all.shown.show(look.thing, true);
    }
    for (const OverlayStyle &look : kThings) {
        ViewState without = full_state();
        without.shown = all.shown;
        without.shown.show(look.thing, false);
        // What the values hold is computed only if it is switched on: app/demo/shown_values.cpp.
        TouchValues &touch = without.touch;
        switch (look.thing) {
        case Thing::both_forces:
            touch.inverse_force_N.reset();
            touch.transpose_force_N.reset();
            break;
        case Thing::set_point:
            touch.set_point_m.reset();
            break;
        case Thing::stiffness:
            touch.inverse_stiffness_N_per_m.reset();
            break;
        case Thing::trace:
            touch.trace_N.clear();
            break;
        case Thing::direction_errors: // of the two, the other one is on
            continue;
        case Thing::stiffnesses:
            touch.workspace.reset();
            break;
        default:
            break;
        }
        const MarksDrawn less = marks_drawn(without);
        EXPECT_LT(less.solids + less.flat, marks_drawn(all).solids + marks_drawn(all).flat)
            << look.label;
    }
}

TEST(ShownThings, OfTheTwoThatColourTheWorkspaceOneIsOn) {
    ShownThings shown;
    shown.show(Thing::stiffnesses, true);
    shown.show(Thing::direction_errors, true);
    EXPECT_TRUE(shown.shows(Thing::direction_errors));
    EXPECT_FALSE(shown.shows(Thing::stiffnesses));
}

TEST(ShownThings, AreInTheOrderOfTheirListWithWordsOfTheirOwn) {
    std::set<std::string> words;
    for (std::size_t i = 0; i < kThings.size(); ++i) {
        EXPECT_EQ(static_cast<std::size_t>(kThings[i].thing), i);
        words.insert(kThings[i].word);
    }
    EXPECT_EQ(words.size(), kThings.size());
    EXPECT_EQ(scale_colour(0.0), kScaleColours.front());
    EXPECT_EQ(scale_colour(1.0), kScaleColours.back());
    EXPECT_EQ(scale_colour(-1.0), kScaleColours.front());
    EXPECT_EQ(scale_colour(2.0), kScaleColours.back());
}

/// The vertices of that colour.
std::vector<Vector3> of_colour(const std::vector<FlatVertex> &vertices, const Colour &colour) {
    std::vector<Vector3> found;
    for (const FlatVertex &vertex : vertices) {
        if (vertex.colour.r == colour[0] && vertex.colour.g == colour[1] &&
            vertex.colour.b == colour[2]) {
            found.push_back(to_vector3(vertex.position_m));
        }
    }
    return found;
}

/// Without what is not meant.
ViewState bare_state() {
    ViewState state = full_state();
    state.touch = {};
    return state;
}

TEST(FlatMarks, ArrowsOfBothMapsEndAtTheirForcesInTheScaleOfTheMeasuredOne) {
    ViewState state = bare_state();
    state.touch.inverse_force_N = full_state().touch.inverse_force_N;
    state.touch.transpose_force_N = full_state().touch.transpose_force_N;
    const auto vertices = flat_marks(state, flat_scale());
    for (const auto &[force_N, colour] : {std::pair{*state.touch.inverse_force_N, kInverseColour},
                                          {*state.touch.transpose_force_N, kTransposeColour}}) {
        const Vector3 along = force_N.normalized();
        double farthest_m = -INFINITY;
        Vector3 end_m = Vector3::Zero();
        for (const Vector3 &vertex_m : of_colour(vertices, colour)) {
            const double at_m = (vertex_m - state.proxy_m).dot(along);
            if (at_m > farthest_m) {
                farthest_m = at_m;
                end_m = vertex_m;
            }
        }
        EXPECT_LT((end_m - (state.proxy_m + 0.015 * force_N)).norm(), kFloat_m);
    }
}

TEST(FlatMarks, EllipsoidAndSphereHaveTheAxesOfTheirStiffnesses) {
    ViewState state = bare_state();
    const Matrix3 K = *full_state().touch.inverse_stiffness_N_per_m;
    state.touch.inverse_stiffness_N_per_m = K;
    state.touch.transpose_stiffness_N_per_m = 1280.0;
    ASSERT_NEAR(stiffness_scale(K), 1e-5, 1e-12); // 10 mm for 1 N/mm
    const MarkerScale scale = flat_scale();
    const auto vertices = flat_marks(state, scale);
    const double line_m = scale.length_m(1.3, state.tip_m); // its width
    // Every point of the outlines is K n of a unit n: |K⁻¹ v| = 1; but for the line's width, and
    // the 64 corners.
    const auto ellipsoid = of_colour(vertices, kInverseColour);
    ASSERT_FALSE(ellipsoid.empty());
    const double least = Eigen::SelfAdjointEigenSolver<Matrix3>(K).eigenvalues()[0];
    const double most = Eigen::SelfAdjointEigenSolver<Matrix3>(K).eigenvalues()[2];
    double farthest_m = 0.0;
    for (const Vector3 &vertex_m : ellipsoid) {
        const Vector3 v = 1e5 * (vertex_m - state.tip_m);
        EXPECT_NEAR((K.inverse() * v).norm(), 1.0, 1e5 * line_m / least + 0.002);
        farthest_m = std::max(farthest_m, (vertex_m - state.tip_m).norm());
    }
    EXPECT_NEAR(farthest_m, 1e-5 * most, line_m);
    for (const Vector3 &vertex_m : of_colour(vertices, kTransposeColour)) {
        EXPECT_NEAR((vertex_m - state.tip_m).norm(), 0.0128, line_m);
    }
    // The bodies are the same, filled.
    const std::vector<Solid> bodies = stiffness_bodies(state);
    ASSERT_EQ(bodies.size(), 2U);
    const Vector3 n = Vector3(0.3, -0.5, 0.7).normalized();
    const auto image_m = [&](const Solid &solid) { return placed(solid, to_glm(n)); };
    EXPECT_LT((image_m(bodies[0]) - (state.tip_m + 0.0128 * n)).norm(), kFloat_m);
    EXPECT_LT((image_m(bodies[1]) - (state.tip_m + 1e-5 * K * n)).norm(), kFloat_m);
}

TEST(FlatMarks, AStiffTipsEllipsoidIsNoLongerThanStated) {
    for (const auto &[most, length_m] : {std::pair{5900.0, 0.059}, {6100.0, 0.060}, {9e4, 0.060}}) {
        Matrix3 K = 1000.0 * Matrix3::Identity();
        K(1, 1) = most;
        EXPECT_NEAR(stiffness_scale(K) * most, length_m, 1e-9);
    }
}

TEST(FlatMarks, ContactPlaneIsSquareToTheNormalAtTheProxy) {
    ViewState state = bare_state();
    state.shown.show(Thing::contact_plane, true);
    const MarkerScale scale = flat_scale();
    const auto plane = of_colour(flat_marks(state, scale), kNormalColour);
    ASSERT_FALSE(plane.empty());
    for (const Vector3 &vertex_m : plane) {
        EXPECT_NEAR((vertex_m - state.proxy_m).dot(state.normal), 3e-4,
                    scale.length_m(1.6, state.proxy_m));
    }
    state.touching = false;
    EXPECT_TRUE(flat_marks(state, scale).empty());
}

TEST(FlatMarks, TraceAndWorkspaceHaveTheColoursOfTheirScale) {
    ViewState state = bare_state();
    state.touch.trace_N = full_state().touch.trace_N;
    const MarkerScale scale = flat_scale();
    const auto trace = flat_marks(state, scale);
    EXPECT_EQ(trace.size(), 12U);                              // two lines of two triangles
    EXPECT_EQ(of_colour(trace, scale_colour(0.0)).size(), 3U); // both sides of its start, one twice
    EXPECT_FALSE(of_colour(trace, scale_colour(1.0 / kTraceEnd_N)).empty());
    EXPECT_FALSE(of_colour(trace, scale_colour(1.0)).empty()); // more than the end
    state = bare_state();
    state.touch.workspace = full_state().touch.workspace;
    const auto places = flat_marks(state, scale);
    EXPECT_EQ(of_colour(places, scale_colour(1.0)).size(), 6U);
    EXPECT_EQ(of_colour(places, scale_colour(0.1 / 0.7)).size(), 6U);
}

TEST(HeightLine, LeadsFromTipOrProxyToARingThatLiesOnWhatIsBelow) {
    const MarkerScale scale = flat_scale();
    ViewState state;
    state.tip_m = {0.02, 0.05, -0.01};
    state.proxy_m = {0.021, 0.055, -0.012};
    const Vector3 normal = Vector3(0.3, 0.9, 0.1).normalized();
    for (const bool touching : {false, true}) {
        state.touching = touching;
        const Vector3 top_m = touching ? state.proxy_m : state.tip_m;
        state.below = {{top_m.x(), -0.03, top_m.z()}, normal};
        const std::vector<Solid> solids = height_line(state, scale);
        ASSERT_EQ(solids.size(), 2U);
        EXPECT_EQ(solids[0].shape, Shape::cylinder);
        EXPECT_LT((start_of(solids[0]) - top_m).norm(), kFloat_m);
        EXPECT_LT((end_of(solids[0]) - state.below->point_m).norm(), kFloat_m);
        EXPECT_EQ(solids[1].shape, Shape::ring);
        const Vector3 centre_m = start_of(solids[1]);
        EXPECT_NEAR((centre_m - state.below->point_m).norm(), 4e-4, kFloat_m); // so as to be seen
        for (const auto &[x, y] : {std::pair{1.0F, 0.0F}, {0.0F, 1.0F}, {-0.6F, 0.8F}}) {
            const Vector3 radius_m = placed(solids[1], {x, y, 0.0F}) - centre_m;
            EXPECT_NEAR(radius_m.dot(normal), 0.0, kFloat_m);
            EXPECT_GT(radius_m.norm(), 3e-3);
        }
    }
}

TEST(HeightLine, IsNotThereWhereNothingIsBelowOrTheTipIsThere) {
    const MarkerScale scale = flat_scale();
    ViewState state;
    EXPECT_TRUE(height_line(state, scale).empty());
    for (const auto &[height_m, is_shown] : {std::pair{0.9e-3, false}, {1.1e-3, true}}) {
        state.below = {state.tip_m - Vector3(0.0, height_m, 0.0), Vector3::UnitY()};
        EXPECT_EQ(!height_line(state, scale).empty(), is_shown) << height_m;
    }
}

TEST(TipGhost, IsWiderThanTheTipFromNearAndFar) {
    Camera camera = flat_camera();
    for (const double steps : {0.0, -20.0, 35.0}) {
        camera.zoom(steps, camera.target_m());
        const MarkerScale scale{camera, kFlatViewport.height_px, 1.0};
        const ViewState state;
        const TipMarks marks = tip_marks(state, scale);
        ASSERT_EQ(marks.tip.size(), 1U);
        ASSERT_EQ(marks.ghost.size(), 1U);
        const Solid &tip = marks.tip.front();
        const Solid &ghost = marks.ghost.front();
        const auto radius_m = [](const Solid &solid) {
            return (placed(solid, {1.0F, 0.0F, 0.0F}) - start_of(solid)).norm();
        };
        EXPECT_GT((1.0 - 0.5 * kRingThickness) * radius_m(ghost), 1.4 * radius_m(tip));
        // It faces the camera.
        EXPECT_NEAR((end_of(ghost) - start_of(ghost)).normalized().dot(camera.forward()), 1.0,
                    1e-5); // float
    }
}

class Markers : public ::testing::Test {
protected:
    Markers() {
        camera =
            testing::framed_box(Vector3(-0.1, -0.1, -0.1), Vector3(0.1, 0.1, 0.1), {880.0, 520.0});
        state.touching = true;
        state.proxy_m = Vector3(0.02, 0.03, -0.01);
        state.normal = Vector3(2.0, 3.0, 6.0) / 7.0;
        state.tip_m = state.proxy_m - 0.004 * state.normal;
        state.tip_force_N = Vector3(1.0, 2.0, 2.0);
    }
    [[nodiscard]] std::vector<Solid> solids() const {
        return marker_solids(state, MarkerScale{camera, 520.0, 1.0});
    }

    Camera camera;
    ViewState state;
};

TEST_F(Markers, ArrowStandsOnTheProxyAndIsAsLongAsTheForce) {
    const Solid head = only_one(solids(), Shape::cone);
    const Vector3 expected_m = state.proxy_m + kArrowMetresPerNewton * state.tip_force_N;
    EXPECT_LT((end_of(head) - expected_m).norm(), kFloat_m);
    // The neck is on the way.
    const Vector3 neck_m = start_of(head) - state.proxy_m;
    EXPECT_LT(neck_m.cross(state.tip_force_N.normalized()).norm(), kFloat_m);
}

TEST_F(Markers, ArrowStandsOnTheTipInFreeSpace) {
    state.touching = false;
    const std::vector<Solid> drawn = solids();
    const Vector3 expected_m = state.tip_m + kArrowMetresPerNewton * state.tip_force_N;
    EXPECT_LT((end_of(only_one(drawn, Shape::cone)) - expected_m).norm(), kFloat_m);
    EXPECT_TRUE(std::none_of(drawn.begin(), drawn.end(),
                             [](const Solid &solid) { return solid.shape == Shape::ball; }));
}

TEST_F(Markers, ThereIsNoArrowWithoutAForceOrWithOneThatIsNoNumber) {
    for (const Vector3 &force_N :
         {Vector3(Vector3::Zero()),
          Vector3(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()))}) {
        state.tip_force_N = force_N;
        for (const Solid &solid : solids()) {
            ASSERT_NE(solid.shape, Shape::cone);
            ASSERT_TRUE(start_of(solid).allFinite());
        }
    }
}

TEST_F(Markers, BallsKeepALegibleSizeFromAfar) {
    camera.zoom(-15.0, camera.target_m());
    const Solid proxy = only_one(solids(), Shape::ball);
    const double radius_m = (end_of(proxy) - start_of(proxy)).norm();
    EXPECT_GT(radius_m, kProxyRadius_m);
    EXPECT_GT(radius_m / camera.metres_per_pixel(state.proxy_m, 520.0), 3.0);
}

TEST_F(Markers, TargetRingFacesTheCamera) {
    camera.orbit(123.0, 45.0);
    const Solid target = only_one(solids(), Shape::ring);
    const Vector3 axis = (end_of(target) - start_of(target)).normalized();
    EXPECT_NEAR(std::abs(axis.dot(camera.forward())), 1.0, 1e-5);
}

} // namespace
} // namespace springdrive::app
