// A smooth shape without corners, given by a formula: where the field of some blobs falls to a
// level. Its true points and normals are known, however finely a mesh of it is cut.
//
// Only + − × ÷ and √ enter, which IEEE 754 rounds alike everywhere: the scene file that is written
// from it is the same on every machine.
#pragma once

#include "base/vector.h"

#include <vector>

namespace springdrive::rig {

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

} // namespace springdrive::rig
