// The content of each included scene. Sizes suit the workspace of the PHANTOM 1.0, a box of
// 254 × 178 × 127 mm around (0, 30, −15) mm; the tip's zero pose, the origin, is left free.
#include "assets/scenes/shapes.h"

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

/// 120 × 10 × 80 mm, its top 5 mm below the origin.
SceneDescription plate() {
    Part slab = box(Vector3(-0.060, -0.015, -0.055), Vector3(0.060, -0.005, 0.025));
    return {"plate", true, {named(std::move(slab), "plate", {0.10, 0.27, 0.42})}, kToFeelAWall};
}

SceneDescription sphere() {
    Part ball = geodesic_sphere(kSphereFrequency);
    for (Vector3 &position : ball.positions_m) {
        position = Vector3(0.0, 0.050, -0.015) + kSphereRadius_m * position;
    }
    return {
        "sphere", true, {named(std::move(ball), "sphere", {0.72, 0.28, 0.10})}, kToFeelRoundness};
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
            true,
            {named(std::move(block), "stepped block", {0.33, 0.42, 0.20})},
            kToFeelEdges};
}

/// Lumps on a body, like a coral or a potato; fitted to the device's workspace.
SceneDescription organic() {
    constexpr int kFrequency = 39; // 30,420 triangles
    Part coral = blob_union(rig::organic_shape(), kFrequency);
    return {"organic", false, {named(std::move(coral), "coral", {1.0, 1.0, 1.0})}, kToFeelAShape};
}

/// Three pads of 36 × 15 × 60 mm side by side, from rigid to soft.
SceneDescription compliance() {
    SceneDescription scene{"compliance", true, {}, kToCompareStiffness};
    const auto add_pad = [&](double centre_x_m, double eta, std::string name,
                             const std::array<double, 3> &colour) {
        Part pad = named(box(Vector3(centre_x_m - 0.018, -0.020, -0.045),
                             Vector3(centre_x_m + 0.018, -0.005, 0.015)),
                         std::move(name), colour);
        pad.eta = eta;
        scene.parts.push_back(std::move(pad));
    };
    add_pad(-0.042, 0.0, "rigid", {0.08, 0.22, 0.45});
    add_pad(0.0, 0.4, "firm", {0.14, 0.42, 0.20});
    add_pad(0.042, 0.75, "soft", {0.75, 0.20, 0.28});
    return scene;
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
            true,
            {named(std::move(rail), "rail", {0.30, 0.24, 0.45})},
            kToFollowAProfile,
            true};
}

} // namespace

std::vector<SceneDescription> all_scenes() {
    return {plate(), sphere(), stepped_block(), organic(), compliance(), profile()};
}

} // namespace springdrive::scenes
