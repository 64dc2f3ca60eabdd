// The shapes of the included scenes: closed meshes, wound counter-clockwise seen from outside.
//
// The coordinates use only + − × ÷ and √, which IEEE 754 rounds identically everywhere: the files
// that generate.cpp writes from them are the same bytes on every machine.
#pragma once

#include "base/vector.h"
#include "engine/lab/rig/scenario/known_shapes.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::scenes {

/// The content of one glTF node.
struct Part {
    std::string name;
    std::vector<Vector3> positions_m;
    std::vector<Vector3> normals;                     ///< unit, one per vertex
    std::vector<std::array<std::uint8_t, 4>> colours; ///< linear RGBA, one per vertex; may be empty
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::array<double, 3> base_colour{1.0, 1.0, 1.0}; ///< linear
    std::optional<double> eta;                        ///< η of (30), if the node has one
    bool smooth = false;                              ///< touched as its normals describe it
    std::string caption;                              ///< shown on it; may be empty
};

/// A grid of box cells with faces at these coordinates, each list ascending.
struct CellGrid {
    std::vector<double> x_m;
    std::vector<double> y_m;
    std::vector<double> z_m;
};

/// The solid of those cells (i, j, k) for which `is_solid` holds, with flat faces.
[[nodiscard]] Part cell_solid(const CellGrid &grid,
                              const std::function<bool(int, int, int)> &is_solid);

/// A box with flat faces, 12 triangles.
[[nodiscard]] Part box(const Vector3 &lower_m, const Vector3 &upper_m);

/// Moves each point up by `rise_x` times its x and `rise_z` times its z: what was level slopes.
/// Faces stay flat.
[[nodiscard]] Part sheared(Part part, double rise_x, double rise_z);

/// Each triangle with corners of its own, square to it: it is drawn, and smoothed, as a facet.
[[nodiscard]] Part faceted(const Part &part);

/// A point of a profile, seen along x.
struct ProfilePoint {
    double z_m;
    double y_m;
};

/// The solid between a profile, whose z rises from point to point, and a floor below all of it,
/// `half_width_m` to either side of x = 0. Flat faces.
[[nodiscard]] Part extrusion(const std::vector<ProfilePoint> &profile, double floor_y_m,
                             double half_width_m);

/// Directions over the unit sphere: an icosahedron with each edge divided into `frequency` pieces,
/// projected onto the sphere. 20 f² triangles over 10 f² + 2 vertices; `normals` equal the
/// positions.
[[nodiscard]] Part geodesic_sphere(int frequency);

/// The shape's surface seen from the origin, with a vertex on each direction of a geodesic sphere;
/// smooth normals, coloured by distance from the origin.
[[nodiscard]] Part blob_union(const rig::BlobShape &shape, int frequency);

/// Permitted error of a cheaper model of a scene relative to the full one; see docs/models.md.
struct Tolerance {
    double force_N;
    double direction_deg;
    double bandwidth_hz;
};

/// Where a scene is to be touched.
struct Spot {
    Vector3 point_m{Vector3::Zero()};
    Vector3 normal{Vector3::UnitY()}; ///< of any length
};

/// What a scene is there to let one feel.
struct Lesson {
    std::string title;
    std::string feel; ///< one sentence
    std::optional<Spot> spot;
};

/// An included scene file.
struct SceneDescription {
    std::string name;
    Lesson lesson;
    bool in_metres = false; ///< otherwise fitted to the device's workspace when loaded
    std::vector<Part> parts;
    Tolerance tolerance;
    bool planar = false; ///< the hand stays in the plane x = 0
};

/// Every scene, in the frame of the device: x right, y up, z towards the user.
[[nodiscard]] std::vector<SceneDescription> all_scenes();

inline constexpr double kSphereRadius_m = 0.045;
inline constexpr int kSphereFrequency = 32;

/// Of the pair of spheres.
inline constexpr double kPairRadius_m = 0.027;
inline constexpr int kPairFrequency = 2;

inline constexpr double kSheetThickness_m = 0.001;

/// Of the pads, from left to right.
inline constexpr std::array<double, 5> kPadEta{0.0, 0.25, 0.5, 0.75, 0.9};

} // namespace springdrive::scenes
