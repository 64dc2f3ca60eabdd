#include "app/view/marks.h"

#include "app/view/solids.h"
#include "base/eigenvalues.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::app {

namespace {

constexpr double kMinForce_N = 0.05; // shorter arrows would be noise
constexpr double kNormalLength_m = 0.060;
constexpr double kNormalBeyondArrow_m = 0.015;
constexpr double kDash_m = 0.0040;
constexpr double kGap_m = 0.0025;

// Minimum sizes, in layout pixels.
constexpr double kTipRadius_px = 4.0;
constexpr double kProxyRadius_px = 5.0;
constexpr double kShaftRadius_px = 2.0;
constexpr double kLineRadius_px = 0.9;
constexpr double kTargetRadius_px = 10.0;
constexpr double kLightTarget = 0.55; // of the hand colour while the hand is not held

constexpr double kShaftRadius_m =
    2.6e-3;                           // more than the forearm's near the tip, which it may hide in
constexpr double kHeadPerShaft = 2.2; // radius of the arrow's head
constexpr double kHeadSlenderness = 2.8;

void append_line(std::vector<Solid> &solids, const Vector3 &from_m, const Vector3 &to_m,
                 const Colour &colour, const MarkerScale &scale) {
    if (from_m != to_m) {
        solids.push_back(
            spindle(Shape::cylinder, from_m, to_m, scale.length_m(kLineRadius_px, from_m), colour));
    }
}

void append_arrow(std::vector<Solid> &solids, const Vector3 &from_m, const Vector3 &along_m,
                  double thickness, const MarkerScale &scale) {
    const double shaft_m =
        thickness * std::max(kShaftRadius_m, scale.length_m(kShaftRadius_px, from_m));
    const double length_m = along_m.norm();
    const double head_m = std::min(kHeadSlenderness * kHeadPerShaft * shaft_m, 0.6 * length_m);
    const Vector3 neck_m = from_m + (1.0 - head_m / length_m) * along_m;
    solids.push_back(spindle(Shape::cylinder, from_m, neck_m, shaft_m, kForceColour));
    solids.push_back(
        spindle(Shape::cone, neck_m, from_m + along_m, kHeadPerShaft * shaft_m, kForceColour));
}

void append_normal(std::vector<Solid> &solids, const ViewState &state, double arrow_m,
                   const MarkerScale &scale) {
    const double end_m = std::max(kNormalLength_m, arrow_m + kNormalBeyondArrow_m);
    for (double at_m = 0.0; at_m + kDash_m < end_m; at_m += kDash_m + kGap_m) {
        append_line(solids, state.proxy_m + at_m * state.normal,
                    state.proxy_m + (at_m + kDash_m) * state.normal, kNormalColour, scale);
    }
}

void append_hand_target(std::vector<Solid> &solids, const ViewState &state,
                        const MarkerScale &scale) {
    Colour colour = kHandColour;
    if (!state.hand_held) {
        for (float &channel : colour) {
            channel *= static_cast<float>(kLightTarget);
        }
    }
    const Vector3 &centre_m = state.hand_target_m;
    const double radius_m = scale.length_m(kTargetRadius_px, centre_m);
    solids.push_back(ring(centre_m, scale.camera.forward(), radius_m, colour));
    for (const Vector3 &arm : {scale.camera.right(), scale.camera.up()}) {
        for (const double side : {-1.0, 1.0}) {
            append_line(solids, centre_m + side * 0.65 * radius_m * arm,
                        centre_m + side * 1.45 * radius_m * arm, colour, scale);
        }
    }
}

constexpr double kMinHeight_m = 1.0e-3; // shorter lines would hide in the tip
constexpr double kHeightLine_px = 0.7;  // its radius
constexpr double kFoot_m = 3.5e-3;      // radius of the ring
constexpr double kFoot_px = 5.0;
constexpr double kOffTheGround_m = 4.0e-4; // of the foot, which would flicker in the surface

constexpr double kGhostPerTip = 1.8; // radius
constexpr double kGhost_px = 6.5;

} // namespace

std::vector<Solid> marker_solids(const ViewState &state, const MarkerScale &scale) {
    std::vector<Solid> solids;
    // A force that is not finite draws no arrow.
    const bool has_force = state.tip_force_N.allFinite() && state.tip_force_N.norm() > kMinForce_N;
    const Vector3 arrow_m =
        has_force ? Vector3(state.arrow.m_per_N * state.tip_force_N) : Vector3::Zero();
    if (state.touching && state.shown.shows(Thing::proxy)) {
        const double min_m = scale.length_m(kProxyRadius_px, state.proxy_m);
        solids.push_back(ball(state.proxy_m, std::max(kProxyRadius_m, min_m), kProxyColour));
        append_line(solids, state.proxy_m, state.tip_m, kTipColour, scale);
    }
    if (state.touching && state.shown.shows(Thing::normal)) {
        append_normal(solids, state, arrow_m.norm(), scale);
    }
    if (has_force && state.shown.shows(Thing::force)) {
        append_arrow(solids, state.touching ? state.proxy_m : state.tip_m, arrow_m,
                     state.arrow.thickness, scale);
    }
    if (state.shown.shows(Thing::hand)) {
        append_hand_target(solids, state, scale);
    }
    return solids;
}

Solid tip_solid(const ViewState &state, const MarkerScale &scale) {
    const double min_m = scale.length_m(kTipRadius_px, state.tip_m);
    return ball(state.tip_m, std::max(kTipRadius_m, min_m), kTipColour);
}

std::vector<Solid> height_line(const ViewState &state, const MarkerScale &scale) {
    const Vector3 &top_m = state.touching ? state.proxy_m : state.tip_m;
    if (!state.shown.shows(Thing::height) || !state.below ||
        !((top_m - state.below->point_m).norm() > kMinHeight_m)) {
        return {};
    }
    const auto &[foot_m, normal] = *state.below;
    const double foot_radius_m = std::max(kFoot_m, scale.length_m(kFoot_px, foot_m));
    return {
        spindle(Shape::cylinder, top_m, foot_m, scale.length_m(kHeightLine_px, foot_m), kTipColour),
        ring(foot_m + kOffTheGround_m * normal, normal, foot_radius_m, kTipColour)};
}

TipMarks tip_marks(const ViewState &state, const MarkerScale &scale) {
    if (!state.shown.shows(Thing::tip)) {
        return {};
    }
    const double min_m = scale.length_m(kGhost_px, state.tip_m);
    return {{tip_solid(state, scale)},
            {ring(state.tip_m, scale.camera.forward(), std::max(kGhostPerTip * kTipRadius_m, min_m),
                  kTipColour)}};
}

namespace {

constexpr int kCorners = 64; // of an ellipse

Vector3 on_ellipse(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m, int corner) {
    const double angle_rad = 2.0 * std::numbers::pi * corner / kCorners;
    return centre_m + std::cos(angle_rad) * a_m + std::sin(angle_rad) * b_m;
}

glm::vec4 with_alpha(const Colour &colour, float alpha) {
    return {colour[0], colour[1], colour[2], alpha};
}

constexpr double kArrow_px = 9.0; // wider than the measured force, which lies in it
constexpr double kPlane_m = 0.016;
constexpr double kOffThePlane_m = 3.0e-4;
constexpr double kSetPoint_m = 4.0e-3;
constexpr double kSetPoint_px = 9.0;
constexpr double kTrace_px = 2.5;
constexpr double kPlace_m = 1.5e-3;
constexpr double kPlace_px = 2.1;
constexpr float kBodyOpacity = 0.20F;

void append_forces(FlatShapes &shapes, const ViewState &state) {
    constexpr double kMin_N = 0.02;
    const auto append = [&](const std::optional<Vector3> &force_N, const Colour &colour) {
        if (force_N && force_N->allFinite() && force_N->norm() > kMin_N) {
            shapes.arrow(state.proxy_m, state.arrow.m_per_N * *force_N,
                         state.arrow.thickness * kArrow_px, colour);
        }
    };
    append(state.touch.inverse_force_N, kInverseColour);
    append(state.touch.transpose_force_N, kTransposeColour);
}

void append_contact_plane(FlatShapes &shapes, const ViewState &state) {
    const Vector3 centre_m = state.proxy_m + kOffThePlane_m * state.normal;
    const Vector3 a_m = kPlane_m * state.normal.unitOrthogonal();
    const Vector3 b_m = state.normal.cross(a_m);
    shapes.disc(centre_m, a_m, b_m, kNormalColour, 0.20F);
    shapes.ellipse(centre_m, a_m, b_m, 1.6, kNormalColour, 0.9F);
    for (const Vector3 &arm_m : {a_m, b_m}) {
        shapes.line(centre_m - arm_m, centre_m + arm_m, 1.0, kNormalColour, 0.6F);
    }
}

void append_set_point(FlatShapes &shapes, const Vector3 &at_m, const MarkerScale &scale) {
    const double radius_m = std::max(kSetPoint_m, scale.length_m(kSetPoint_px, at_m));
    const Vector3 right_m = radius_m * scale.camera.right();
    const Vector3 up_m = radius_m * scale.camera.up();
    shapes.ellipse(at_m, right_m, up_m, 2.2, kSetPointColour);
    shapes.dot(at_m, 0.35 * radius_m, kSetPointColour);
}

void append_stiffness(FlatShapes &shapes, const ViewState &state) {
    const Matrix3 &K = *state.touch.inverse_stiffness_N_per_m;
    const double scale = stiffness_scale(K);
    const PrincipalAxes axes = principal_axes(K);
    const double radius_m = scale * *state.touch.transpose_stiffness_N_per_m;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const Vector3 u = axes.eigenvectors.col(i);
        const Vector3 v = axes.eigenvectors.col(j);
        shapes.ellipse(state.tip_m, scale * axes.eigenvalues[i] * u,
                       scale * axes.eigenvalues[j] * v, 1.3, kInverseColour, 0.85F);
        shapes.ellipse(state.tip_m, radius_m * u, radius_m * v, 1.3, kTransposeColour, 0.85F);
    }
}

void append_trace(FlatShapes &shapes, const std::vector<PlacedValue> &trace_N) {
    for (std::size_t i = 1; i < trace_N.size(); ++i) {
        shapes.line(trace_N[i - 1].at_m, trace_N[i].at_m, kTrace_px,
                    scale_colour(trace_N[i - 1].value / kTraceEnd_N),
                    scale_colour(trace_N[i].value / kTraceEnd_N));
    }
}

void append_workspace(FlatShapes &shapes, const WorkspaceField &field, const MarkerScale &scale) {
    for (const PlacedValue &place : field.places) {
        shapes.dot(place.at_m, std::max(kPlace_m, scale.length_m(kPlace_px, place.at_m)),
                   scale_colour(place.value / field.largest), 0.85F);
    }
}

/// The unit ball by a linear map about a point.
Solid body(const Matrix3 &map, const Vector3 &centre_m, const Colour &colour) {
    Solid solid{Shape::ball, glm::mat4(1.0F), linear(colour)};
    for (int column = 0; column < 3; ++column) {
        solid.model[column] = glm::vec4(to_glm(map.col(column)), 0.0F);
    }
    solid.model[3] = glm::vec4(to_glm(centre_m), 1.0F);
    solid.colour.a = kBodyOpacity;
    return solid;
}

bool has_stiffness(const ViewState &state) {
    return state.touch.inverse_stiffness_N_per_m && state.touch.transpose_stiffness_N_per_m &&
           *state.touch.transpose_stiffness_N_per_m > 0.0;
}

} // namespace

/// Unit, square to the line and to the line of sight; any where one looks along the line.
Vector3 FlatShapes::across(const Vector3 &at_m, const Vector3 &along_m) const {
    const Vector3 sight_m = at_m - scale_.camera.eye_m();
    const Vector3 across_m = along_m.cross(sight_m);
    constexpr double kAlong = 1e-6; // sine
    return across_m.norm() > kAlong * along_m.norm() * sight_m.norm() ? across_m.normalized()
                                                                      : scale_.camera.right();
}

void FlatShapes::triangle(const Vector3 &a_m, const Vector3 &b_m, const Vector3 &c_m,
                          const Colour &colour, float alpha) {
    for (const Vector3 *corner_m : {&a_m, &b_m, &c_m}) {
        vertices_.push_back({to_glm(*corner_m), with_alpha(colour, alpha)});
    }
}

void FlatShapes::line(const Vector3 &from_m, const Vector3 &to_m, double width_px,
                      const Colour &from, const Colour &to, float alpha) {
    if (from_m == to_m) {
        return;
    }
    const Vector3 side = across(0.5 * (from_m + to_m), to_m - from_m);
    const Vector3 half_from_m = 0.5 * scale_.length_m(width_px, from_m) * side;
    const Vector3 half_to_m = 0.5 * scale_.length_m(width_px, to_m) * side;
    const FlatVertex left_from{to_glm(from_m - half_from_m), with_alpha(from, alpha)};
    const FlatVertex right_from{to_glm(from_m + half_from_m), with_alpha(from, alpha)};
    const FlatVertex left_to{to_glm(to_m - half_to_m), with_alpha(to, alpha)};
    const FlatVertex right_to{to_glm(to_m + half_to_m), with_alpha(to, alpha)};
    vertices_.insert(vertices_.end(),
                     {left_from, right_from, right_to, left_from, right_to, left_to});
}

void FlatShapes::ellipse(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m,
                         double width_px, const Colour &colour, float alpha) {
    for (int corner = 0; corner < kCorners; ++corner) {
        line(on_ellipse(centre_m, a_m, b_m, corner), on_ellipse(centre_m, a_m, b_m, corner + 1),
             width_px, colour, alpha);
    }
}

void FlatShapes::disc(const Vector3 &centre_m, const Vector3 &a_m, const Vector3 &b_m,
                      const Colour &colour, float alpha) {
    for (int corner = 0; corner < kCorners; ++corner) {
        triangle(centre_m, on_ellipse(centre_m, a_m, b_m, corner),
                 on_ellipse(centre_m, a_m, b_m, corner + 1), colour, alpha);
    }
}

void FlatShapes::arrow(const Vector3 &from_m, const Vector3 &along_m, double width_px,
                       const Colour &colour, float alpha) {
    constexpr double kHeadPerWidth = 2.4; // its width; its length is 0.9 of that
    const Vector3 end_m = from_m + along_m;
    const double head_m = scale_.length_m(kHeadPerWidth * width_px, end_m);
    const double length_m = along_m.norm();
    const Vector3 neck_m = end_m - std::min(0.9 * head_m / length_m, 0.6) * along_m;
    const Vector3 half_m = 0.5 * head_m * across(neck_m, along_m);
    line(from_m, neck_m, width_px, colour, alpha);
    triangle(neck_m - half_m, neck_m + half_m, end_m, colour, alpha);
}

void FlatShapes::dot(const Vector3 &centre_m, double radius_m, const Colour &colour, float alpha) {
    const Vector3 right_m = radius_m * scale_.camera.right();
    const Vector3 up_m = radius_m * scale_.camera.up();
    triangle(centre_m - right_m, centre_m - up_m, centre_m + right_m, colour, alpha);
    triangle(centre_m - right_m, centre_m + right_m, centre_m + up_m, colour, alpha);
}

double stiffness_scale(const Matrix3 &inverse_N_per_m) {
    constexpr double kMetres_per_N_per_m = 1e-5;
    constexpr double kMax_m = 0.060;
    const double longest_m = kMetres_per_N_per_m * symmetric_eigenvalues(inverse_N_per_m)[2];
    return longest_m > kMax_m ? kMetres_per_N_per_m * kMax_m / longest_m : kMetres_per_N_per_m;
}

std::vector<FlatVertex> flat_marks(const ViewState &state, const MarkerScale &scale) {
    FlatShapes shapes(scale);
    if (state.touch.workspace) {
        append_workspace(shapes, *state.touch.workspace, scale);
    }
    append_trace(shapes, state.touch.trace_N);
    if (has_stiffness(state)) {
        append_stiffness(shapes, state);
    }
    if (state.touching && state.shown.shows(Thing::contact_plane)) {
        append_contact_plane(shapes, state);
    }
    append_forces(shapes, state);
    if (state.touch.set_point_m) {
        append_set_point(shapes, *state.touch.set_point_m, scale);
    }
    return shapes.take();
}

std::vector<Solid> stiffness_bodies(const ViewState &state) {
    if (!has_stiffness(state)) {
        return {};
    }
    const Matrix3 &K = *state.touch.inverse_stiffness_N_per_m;
    const double scale = stiffness_scale(K);
    const double radius_m = scale * *state.touch.transpose_stiffness_N_per_m;
    return {body(radius_m * Matrix3::Identity(), state.tip_m, kTransposeColour),
            body(scale * K, state.tip_m, kInverseColour)};
}

} // namespace springdrive::app
