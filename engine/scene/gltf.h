// glTF 2.0 files (.gltf, .glb) to scenes.
#pragma once

#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"

#include <filesystem>

namespace springdrive::scene {

/// Loads a glTF file and places it in the device's frame.
///
/// Its buffers and images may be in the file itself, or in files in its folder and those below; no
/// other file is opened. Draco and meshopt compression are decoded. Skins and morph targets are at
/// rest, as nodes and default weights have them; animations are left out. Of materials, the
/// metallic-roughness model with its textures, emission and the alpha modes are drawn; other models
/// are left out.
///
/// Fitted uniformly, largest that fits into 60 % of the workspace, centred there, unless the
/// file's scene or asset says `"extras": {"units": "m"}`: then its coordinates are metres in the
/// device frame as they stand.
///
/// The `"extras"` of a node say how it and its children feel; a child's own take precedence:
/// - `"eta"`: η, from 0 (rigid, the default) to 1 (free space).
/// - `"static_friction"`, `"dynamic_friction"`: Coulomb coefficients from 0 (the default) to 10,
///   dynamic not above static. A node that gives one gives both: the other is the same.
/// - `"sides"`: "one" for a surface that is touched only from the side its normals point to, "two"
///   for both. By default one if it is closed, two if it is open.
/// - `"smooth"`: true to touch and draw the curved surface that the normals of the file describe,
///   cut into facets that differ by 0.5° at most (up to two million in a scene), instead of the
///   file's triangles. It needs normals; split normals leave an edge sharp.
/// And for the node's own mesh alone:
/// - `"shape"`: "plate", "sphere", "box", "cylinder" or "capsule" to be touched exactly as that,
///   fitted to the box around the mesh, which is drawn as it is. See `fit_shape`.
/// - `"caption"`: words of at most 40 bytes, shown on it.
///
/// Of the scene or the asset as a whole:
/// - `"tolerance"`: how far a cheaper model of plant, surface and control may deviate from the
///   fullest, as `{"force_N": 0.05, "direction_deg": 5, "bandwidth_hz": 200}`; each of the three
///   may be left out, and these are the defaults. See docs/models.md.
/// - `"planar"`: true where the hand stays in the linkage's plane, x = const: then the base joint
///   need not be simulated.
/// - `"lesson"`: what to feel, as `{"title": "A wall", "feel": "Press on it: it stays.",
///   "point": [0, 0, 0], "normal": [0, 1, 0]}`; title and sentence have at most 40 and 200 bytes,
///   point and normal say where to touch, in the file's coordinates. All may be left out.
///
/// @throw InputError with one line that names the file, what is wrong in it and where: for a file
///        that is missing, is no glTF, is truncated, refers outside its buffers or arrays, holds
///        coordinates that are not finite, needs an extension that is not supported, has no such
///        scene or no triangle, or has extras about touch that contradict each other. Values other
///        than the above are another program's, which may use the same names: left out, with a
///        warning. Also for a scene that takes more than 8 GiB to load.
/// @throw Cancelled soon after `progress` was given up
/// @param progress is updated while loading; may be null
/// @param gltf_scene  name or number of the file's scene that is loaded. By default its default
///        scene; without one, the first that has triangles.
[[nodiscard]] Scene load_gltf(const std::filesystem::path &file, const device::Workspace &workspace,
                              LoadProgress *progress = nullptr, const std::string &gltf_scene = {});

} // namespace springdrive::scene
