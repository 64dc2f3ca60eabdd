// Shapes given by a formula, and tips pressed into them, each with the true answer beside it.
#pragma once

#include "base/vector.h"

#include <cstddef>
#include <vector>

namespace springdrive::rig {

// A smooth shape without corners, given by a formula: where the field of some blobs falls to a
// level. Its true points and normals are known, however finely a mesh of it is cut.
//
// Only + − × ÷ and √ enter, which IEEE 754 rounds alike everywhere: the scene file that is written
// from it is the same on every machine.

/// Its field is (1 − |p − centre|²/radius²)³ inside, 0 outside.
struct Blob {
    Vector3 centre;
    double radius;
};

/// Where the sum of the blobs' fields is `level`. It must be star-shaped: no ray from the origin
/// may cross it twice. Any unit of length will do.
struct BlobShape {
    std::vector<Blob> blobs;
    double level = 0.0;

    [[nodiscard]] double field(const Vector3 &point) const;

    /// The unit vector down the field at a point that some blob reaches: out of the shape.
    [[nodiscard]] Vector3 outward_normal(const Vector3 &point) const;

    /// How far the surface is from the origin in a direction of length 1, by bisection to
    /// round-off.
    [[nodiscard]] double distance(const Vector3 &direction) const;
};

/// Lumps on a body, like a coral or a potato, about 1 from its middle to its skin: the shape of
/// the scene organic.gltf.
[[nodiscard]] const BlobShape &organic_shape();

/// Unit; a Lissajous figure of longitude, of a turn for each 2π of `phase`, and latitude. The ratio
/// of their frequencies is the golden one, so that it never closes.
[[nodiscard]] Vector3 lissajous_direction(double phase);

/// Swings from one depth to another and back, slowly and out of step with the figure.
[[nodiscard]] double swing_m(std::size_t tip, double min_m, double max_m);

/// Where the tip is, and what a proxy on the true surface would do: rest at the point from which
/// the tip was pushed in, along the normal there.
struct PressedTip {
    Vector3 tip_m{Vector3::Zero()};
    Vector3 surface_m{Vector3::Zero()};
    Vector3 normal{Vector3::Zero()}; ///< unit, out of the surface

    [[nodiscard]] double depth_m() const { return (surface_m - tip_m).norm(); }
};

// A tip each millisecond, 1 to 2 mm under the surface, along a curve that covers the surface. The
// surfaces bend so little that the point of entry is the nearest of all.

/// On the sphere of the test surfaces.
[[nodiscard]] std::vector<PressedTip> tips_in_sphere(std::size_t count);

/// On the organic one.
[[nodiscard]] std::vector<PressedTip> tips_in_organic_shape(std::size_t count);

/// Half the sides and half the thickness of the plate that `tips_in_thin_plate` press into.
[[nodiscard]] Vector3 thin_plate_half_size_m();

/// Pressed in from above, down to three quarters of the plate's thickness: beyond its middle.
[[nodiscard]] std::vector<PressedTip> tips_in_thin_plate(std::size_t count);

} // namespace springdrive::rig
