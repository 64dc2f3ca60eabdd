// Surfaces of any fineness whose true shape is known, for trials, tests and benchmarks.
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::rig {

/// A part as a CAD system exports it: flat faces in few triangles, fillets and cylinders in many. A
/// block of 50 mm, its edges and corners rounded by 1 mm, with a stub shaft of 18 mm radius and
/// 20 mm length on both faces along x, rounded at its end and filleted at its foot. With a million
/// triangles:
///   edges of the block       2 × 200 needles of 1 : 6000 each
///   corners of the block     40,000 triangles of 8 µm each
///   flat faces along y and z two triangles
///   flat faces along x       fans of 3000 needles at each corner, up to 1 : 13,000, to the foot
///   fillets, rounded ends    12,000 × 6 × 2 triangles of 9 µm × 0.3 to 0.4 mm each
///   cylinders                2 × 12,000 needles of 1 : 1900 each
///   ends                     a fan of 12,000 needles: one about its middle, one from its rim
/// Closed, wound outwards, vertices shared. No ray from the origin meets it twice.
/// @param triangles  about; larger numbers are met more closely
[[nodiscard]] contact::TriangleSoup machined_surface(std::size_t triangles);

/// How far its true shape is from the origin in a direction of length 1.
[[nodiscard]] double machined_body_radius_m(const Vector3 &direction);

inline constexpr double kTestSphereRadius_m = 0.05;
inline constexpr double kTestBumpHeight_m = 0.5e-3;
inline constexpr double kTestBumpLength_m = 6e-3;
inline constexpr double kTestOrganicScale_m = 0.04; ///< of the unit of `organic_shape`
inline constexpr std::uint64_t kTestScanSeed = 1;

/// An icosahedron whose triangles are divided into four again and again, each time pushed out to a
/// sphere about the origin. Closed, wound outwards, vertices shared.
/// @param divisions  20 · 4^divisions triangles
[[nodiscard]] contact::TriangleSoup icosphere(int divisions, double radius_m);

/// The same with bumps and dents of `height_m` at most, `length_m` from one bump to the next.
[[nodiscard]] contact::TriangleSoup bumpy_sphere(int divisions, double radius_m, double height_m,
                                                 double length_m);

/// Like the icosphere, but each vertex pushed out to the shape, `scale_m` times its size: no two
/// triangles are alike, and all corners are on the true surface.
[[nodiscard]] contact::TriangleSoup organic_surface(int divisions, double scale_m);

/// A closed box of twelve triangles, wound outwards, each with corners of its own.
[[nodiscard]] contact::TriangleSoup solid_box(const Vector3 &lower_m, const Vector3 &upper_m);

/// What `sphere:N`, `bumpy:N` and `organic:N` name, with N triangles: 1280, 5120, 20480, 81920,
/// 327680 or 1310720; or `scan:N` (`scanned_surface`) and `cad:N` (`machined_surface`), with about
/// N, from 1000 to 2000000. Nothing for a name that does not begin so.
/// @throw InputError for another N.
[[nodiscard]] std::optional<contact::TriangleSoup> test_surface_named(std::string_view name);

/// What to touch, by name: loads a file as `load_gltf` does, or makes what `test_surface_named`
/// knows, in metres about the origin and with nothing to draw.
/// @throw InputError as these do.
/// @param progress receives the progress, if given
/// @param gltf_scene  as of `load_gltf`
[[nodiscard]] scene::Scene touch_scene(const std::string &name, const device::Workspace &workspace,
                                       scene::LoadProgress *progress = nullptr,
                                       const std::string &gltf_scene = {});

/// Whether it names a sphere without bumps: its true normals are known.
[[nodiscard]] bool names_test_sphere(std::string_view name);

} // namespace springdrive::rig
