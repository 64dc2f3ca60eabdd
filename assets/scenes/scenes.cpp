// The content of each included scene. Sizes suit the workspace of the PHANTOM 1.0, a box of
// 254 × 178 × 127 mm around (0, 30, −15) mm; the tip's zero pose, the origin, is left free.
#include "assets/scenes/shapes.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace springdrive::scenes {

namespace {

Part named(Part part, std::string name, const std::array<double, 3> &base_colour) {
    part.name = std::move(name);
    part.base_colour = base_colour;
    return part;
}

// Tolerances, each for the purpose of its scene. Humans distinguish forces that differ by about a
// tenth, and press with some 1 to 3 N here; they notice directions from 25° on (paper, section V).

constexpr Tolerance kToFeelAWall = {0.15, 12.0, 100.0};      // presence and flatness
constexpr Tolerance kToFeelRoundness = {0.12, 5.0, 100.0};   // change of force direction
constexpr Tolerance kToFeelEdges = {0.05, 3.0, 300.0};       // sudden and sharp
constexpr Tolerance kToFeelAShape = {0.20, 8.0, 100.0};      // while seeing it
constexpr Tolerance kToCompareStiffness = {0.30, 5.0, 30.0}; // pressed, not struck
constexpr Tolerance kToFollowAProfile = {0.10, 4.0, 100.0};  // slopes, by direction

constexpr std::array<double, 3> kSteel{0.10, 0.27, 0.42};
constexpr std::array<double, 3> kBrass{0.55, 0.36, 0.10};

Part moved(Part part, double scale, const Vector3 &to_m) {
    for (Vector3 &position : part.positions_m) {
        position = to_m + scale * position;
    }
    return part;
}

/// 120 × 10 × 80 mm, its top 5 mm below the origin.
SceneDescription plate() {
    Part slab = box(Vector3(-0.060, -0.015, -0.055), Vector3(0.060, -0.005, 0.025));
    return {"plate",
            {"A stiff wall",
             "Press on it: it stays where it is, as stiff as the motors can make "
             "it.",
             {}},
            true,
            {named(std::move(slab), "plate", kSteel)},
            kToFeelAWall};
}

/// A plate of 110 × 12 × 70 mm that falls by two in five to the right, without friction.
SceneDescription slope() {
    constexpr double kFall = 0.4;
    Part slab =
        sheared(box(Vector3(-0.055, -0.034, -0.050), Vector3(0.055, -0.022, 0.020)), -kFall, 0.0);
    return {"slope",
            {"A slope without friction",
             "Press on it and drag along: without friction, the slope pushes only "
             "square to itself.",
             {}},
            true,
            {named(std::move(slab), "slope", {0.25, 0.40, 0.46})},
            kToFeelAShape};
}

/// The place of most wrong force among those that can be pressed from above with ease, and the fall
/// of the surface there, to the front: rounded, as found by a search over all of them.
constexpr double kWrongY_m = -0.0412;
constexpr double kWrongZ_m = 0.0358;
constexpr double kWrongFall = 0.37;

/// A plate of 70 × 9 × 48 mm, sloping to the front, with an orange square of 12 mm on it.
SceneDescription wrong_direction() {
    const double top_m = kWrongY_m + kWrongFall * kWrongZ_m; // of the plate before it is sheared
    const CellGrid grid = {{-0.035, -0.006, 0.006, 0.035},
                           {top_m - 0.009, top_m},
                           {0.0, kWrongZ_m - 0.006, kWrongZ_m + 0.006, 0.048}};
    Part slab = cell_solid(grid, [](int, int, int) { return true; });
    constexpr std::array<std::uint8_t, 4> kPlain{70, 78, 88, 255};
    constexpr std::array<std::uint8_t, 4> kSquare{235, 92, 10, 255};
    for (std::size_t i = 0; i < slab.positions_m.size(); i += 4) { // face by face
        Vector3 middle_m = Vector3::Zero();
        for (std::size_t corner = 0; corner < 4; ++corner) {
            middle_m += 0.25 * slab.positions_m[i + corner];
        }
        const bool is_square = slab.normals[i].y() > 0.5 && std::abs(middle_m.x()) < 0.006 &&
                               std::abs(middle_m.z() - kWrongZ_m) < 0.006;
        slab.colours.insert(slab.colours.end(), 4, is_square ? kSquare : kPlain);
    }
    return {"wrong_direction",
            {"The wrong direction",
             "Press on the orange square, then press M: one map pushes square to the surface, the "
             "other far to the side.",
             Spot{{0.0, kWrongY_m, kWrongZ_m}, {0.0, 1.0, kWrongFall}}},
            true,
            {named(sheared(std::move(slab), 0.0, -kWrongFall), "plate", {1.0, 1.0, 1.0})},
            kToFeelRoundness};
}

SceneDescription sphere() {
    Part ball =
        moved(geodesic_sphere(kSphereFrequency), kSphereRadius_m, Vector3(0.0, 0.050, -0.015));
    return {"sphere",
            {"Round", "Go round it: the push turns with the surface.", {}},
            true,
            {named(std::move(ball), "sphere", {0.72, 0.28, 0.10})},
            kToFeelRoundness};
}

/// The same few triangles twice: as they are, and bent by their normals.
SceneDescription spheres() {
    const Part ball = geodesic_sphere(kPairFrequency);
    const auto at = [](double x_m) { return Vector3(x_m, -0.0315, -0.015); };
    Part coarse = named(faceted(moved(ball, kPairRadius_m, at(-0.033))), "coarse", kBrass);
    coarse.caption = "coarse";
    Part smooth = named(moved(ball, kPairRadius_m, at(0.033)), "smooth", kBrass);
    smooth.smooth = true;
    smooth.caption = "smooth";
    return {"spheres",
            {"Coarse and smooth",
             "Stroke one, then the other: both are the same 80 triangles, on "
             "the right bent by their normals.",
             {}},
            true,
            {std::move(coarse), std::move(smooth)},
            kToFeelEdges};
}

/// Three steps rising to the right. The middle one has a blind pocket, the highest an open groove:
/// convex and concave edges and corners of every kind.
SceneDescription stepped_block() {
    const CellGrid grid = {{-0.060, -0.020, -0.010, 0.010, 0.020, 0.060},
                           {-0.045, -0.030, -0.024, -0.012, -0.006, 0.006},
                           {-0.055, -0.025, -0.020, -0.010, -0.005, 0.025}};
    constexpr std::array<int, 5> kLayers = {1, 3, 3, 3, 5}; // how high each column reaches
    Part block = cell_solid(grid, [&](int i, int j, int k) {
        const bool in_pocket = i == 2 && j == 2 && k >= 1 && k <= 3;
        const bool in_groove = i == 4 && j == 4 && k == 2;
        return j < kLayers[static_cast<std::size_t>(i)] && !in_pocket && !in_groove;
    });
    return {"stepped_block",
            {"Edges and corners",
             "Feel your way over the steps: edges turn the push at once, the "
             "pocket's corners hold the tip.",
             {}},
            true,
            {named(std::move(block), "stepped block", {0.33, 0.42, 0.20})},
            kToFeelEdges};
}

/// Lumps on a body, like a coral or a potato; fitted to the device's workspace.
SceneDescription organic() {
    constexpr int kFrequency = 39; // 30,420 triangles
    Part coral = blob_union(rig::organic_shape(), kFrequency);
    return {"organic",
            {"A living shape",
             "Stroke it lightly: the hand finds the lumps that the eye sees, and "
             "none of its 30,420 triangles.",
             {}},
            false,
            {named(std::move(coral), "coral", {1.0, 1.0, 1.0})},
            kToFeelAShape};
}

/// Pads of 22 × 35 × 60 mm side by side, from rigid to almost free.
SceneDescription compliance() {
    SceneDescription scene{
        "compliance",
        {"From hard to soft", "Press pad after pad: each is softer than the one before.", {}},
        true,
        {},
        kToCompareStiffness};
    constexpr std::array<std::array<double, 3>, kPadEta.size()> kColours{{{0.08, 0.22, 0.45},
                                                                          {0.10, 0.34, 0.36},
                                                                          {0.20, 0.42, 0.18},
                                                                          {0.55, 0.38, 0.10},
                                                                          {0.70, 0.20, 0.24}}};
    constexpr std::array<const char *, kPadEta.size()> kNames{"rigid", "firm", "medium", "soft",
                                                              "softest"};
    constexpr std::array<const char *, kPadEta.size()> kCaptions{"η 0", "η 0.25", "η 0.5", "η 0.75",
                                                                 "η 0.9"};
    for (std::size_t i = 0; i < kPadEta.size(); ++i) {
        const double centre_x_m = 0.025 * (static_cast<double>(i) - 2.0);
        Part pad = named(box(Vector3(centre_x_m - 0.011, -0.040, -0.045),
                             Vector3(centre_x_m + 0.011, -0.005, 0.015)),
                         kNames[i], kColours[i]);
        pad.eta = kPadEta[i];
        pad.caption = kCaptions[i];
        scene.parts.push_back(std::move(pad));
    }
    return scene;
}

/// 110 × 1 × 70 mm, to be touched from both sides.
SceneDescription thin_plate() {
    Part sheet =
        box(Vector3(-0.055, -0.012 - kSheetThickness_m, -0.050), Vector3(0.055, -0.012, 0.020));
    return {"thin_plate",
            {"As thin as a coin",
             "Press as hard as you like: one millimetre holds, and round its "
             "edge you get below it.",
             {}},
            true,
            {named(std::move(sheet), "sheet", {0.50, 0.52, 0.55})},
            kToFeelAWall};
}

/// An anvil, low enough to strike from above.
SceneDescription blow() {
    const CellGrid grid = {{-0.045, -0.030, -0.014, 0.014, 0.030, 0.045},
                           {-0.058, -0.050, -0.038, -0.024},
                           {-0.040, -0.028, -0.002, 0.010}};
    Part anvil = cell_solid(grid, [](int i, int j, int k) {
        const bool is_core = i == 2 && k == 1;
        const bool is_foot = i >= 1 && i <= 3;
        const bool is_face = k == 1;
        return j == 0 ? is_foot : j == 1 ? is_core : is_face;
    });
    return {"blow",
            {"A blow",
             "Lift the tip and strike: it is hard from the first instant, by the windings "
             "and before any computing.",
             {}},
            true,
            {named(std::move(anvil), "anvil", {0.16, 0.17, 0.19})},
            kToFeelAWall};
}

/// A rail across the workspace, for the hand to follow in the linkage's plane: flat, a slope up, a
/// ridge, a slope down, a step and a groove. 60 × 25 × 80 mm.
SceneDescription profile() {
    Part rail = extrusion({{-0.055, -0.015},
                           {-0.045, -0.015},
                           {-0.030, -0.005},
                           {-0.022, -0.008},
                           {-0.008, -0.008},
                           {-0.006, -0.014},
                           {0.004, -0.014},
                           {0.008, -0.018},
                           {0.012, -0.014},
                           {0.025, -0.014}},
                          -0.030, 0.030);
    return {"profile",
            {"A profile",
             "Follow the rail from back to front: a slope, a ridge, a step and a "
             "groove, each by its direction alone.",
             {}},
            true,
            {named(std::move(rail), "rail", {0.30, 0.24, 0.45})},
            kToFollowAProfile,
            true};
}

} // namespace

std::vector<SceneDescription> all_scenes() {
    return {plate(),   slope(),      wrong_direction(), compliance(), stepped_block(), profile(),
            organic(), thin_plate(), sphere(),          spheres(),    blow()};
}

} // namespace springdrive::scenes
