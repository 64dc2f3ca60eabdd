// A scene as loaded from a glTF file: what is drawn, what is touched, and how it was fitted.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::scene {

/// Where a scene is to be touched.
struct TouchSpot {
    Vector3 point_m{Vector3::Zero()}; ///< on the surface
    Vector3 normal{Vector3::UnitY()}; ///< unit, out of the surface
};

/// What a scene is there to let one feel. All of it may be absent.
struct Lesson {
    std::string title;
    std::string feel;              ///< one sentence: what to do, and what to feel
    std::optional<TouchSpot> spot; ///< where the direction of the force is to be seen

    [[nodiscard]] bool is_empty() const { return title.empty() && feel.empty() && !spot; }
};

/// Words on a part of the scene.
struct Caption {
    std::string text;
    Vector3 at_m{Vector3::Zero()}; ///< the middle of the part's upper side
};

/// What a cheaper model of a scene may be off. The defaults are what hands hardly tell: about the
/// device's own friction (0.04 N at the tip), a fifth of the 25° at which the paper has directions
/// noticed, and the frequencies of touch up to where texture begins.
struct ModelTolerance {
    double force_N = 0.05;         ///< rms of the force on the hand
    double direction_rad = 0.0873; ///< rms of its direction while touching; 5°
    double bandwidth_hz = 200.0;   ///< both below this frequency
};

// Placing a scene of unknown units in the device's workspace.

/// An axis-aligned box; empty until it includes a point.
struct BoundingBox {
    Vector3 lower;
    Vector3 upper;

    BoundingBox();
    void include(const Vector3 &point);
    [[nodiscard]] Vector3 extent() const { return upper - lower; }
};

/// p ↦ to + scale (p − from)
struct Fit {
    Vector3 from{Vector3::Zero()};
    Vector3 to_m{Vector3::Zero()};
    double scale = 1.0; ///< metres per unit

    [[nodiscard]] Vector3 operator()(const Vector3 &point) const {
        return to_m + scale * (point - from);
    }
};

/// How much of the workspace a fitted scene may fill, along each axis.
inline constexpr double kFilledShare = 0.6;

/// The largest uniform scale at which `box` fits into `kFilledShare` of the workspace, centred.
/// @throw InputError for a box without extent, or with coordinates too large to scale.
[[nodiscard]] Fit fit_into(const device::Workspace &workspace, const BoundingBox &box);

/// Whether `box`, in the device's frame, lies within the workspace.
[[nodiscard]] bool lies_within(const device::Workspace &workspace, const BoundingBox &box);

struct VisualVertex {
    std::array<float, 3> position_m; ///< device frame
    std::array<float, 3> normal;     ///< unit
    std::array<float, 4> colour;     ///< base colour × vertex colour, linear, straight alpha
    std::array<float, 2> texture_coordinate;
};

/// How light is reflected: glTF's metallic-roughness model. Textures are indices into
/// Scene::textures, −1 for none, all read at the vertices' texture coordinates.
struct Finish {
    float metallic = 0.0F;               ///< 0 dielectric, 1 metal
    float roughness = 1.0F;              ///< 0 mirror, 1 matt
    int metallic_roughness_texture = -1; ///< its green multiplies roughness, its blue metallic
    int normal_texture = -1;             ///< red along the tangent, green along the bitangent
    float normal_scale = 1.0F;           ///< of red and green
    int occlusion_texture = -1;          ///< red: what arrives of the light from all around
    float occlusion_strength = 1.0F;
};

/// One triangle list with one texture of each kind. Large ones come in pieces; see `in_pieces`.
struct VisualMesh {
    std::string name; ///< the glTF node's name
    std::vector<VisualVertex> vertices;
    /// Of the file, one a vertex: unit, and as the fourth number the sign of the bitangent. Empty
    /// where the file has none; then they follow from the texture coordinates.
    std::vector<std::array<float, 4>> tangents;
    std::vector<std::uint32_t> indices;              ///< three a triangle
    int texture = -1;                                ///< index into Scene::textures, −1 for none
    std::array<float, 3> emission{0.0F, 0.0F, 0.0F}; ///< light of its own, linear
    int emissive_texture = -1;                       ///< multiplies it; at the same coordinates
    Finish finish;
    bool double_sided = false;
    bool translucent = false;          ///< by its colours or its texture
    std::optional<float> alpha_cutoff; ///< where alpha is less, there is nothing
    Vector3 centre_m{Vector3::Zero()}; ///< of its vertices
};

/// Its two ends, device frame.
using LineSegment = std::array<std::array<float, 3>, 2>;

struct Texture {
    enum class Wrap : std::uint8_t { repeat, mirror, clamp };
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba; ///< four bytes a pixel, top row first
    bool holds_numbers = false;     ///< from 0 to 1, such as normals; otherwise sRGB colours
    Wrap wrap_s = Wrap::repeat;
    Wrap wrap_t = Wrap::repeat;
    bool has_alpha = false; ///< some pixel is see-through
};

struct Scene {
    std::filesystem::path file;
    std::vector<VisualMesh> meshes;
    std::vector<Texture> textures;
    std::vector<LineSegment> creases; ///< drawn as lines over `meshes`
    contact::TriangleSoup surface;    ///< the triangles that can be touched
    std::vector<contact::AnalyticShape>
        shapes; ///< touched too; their materials are those of `surface`
    /// `surface` with the file's own flat triangles where nodes are smooth; empty where none is.
    contact::TriangleSoup flat_surface;
    Vector3 lower_m{Vector3::Zero()}; ///< bounding box, device frame
    Vector3 upper_m{Vector3::Zero()};
    double metres_per_unit = 1.0;      ///< how the file's units were scaled
    bool in_metres = false;            ///< the file asked for metres, so nothing was fitted
    bool planar = false;               ///< the hand stays in the linkage's plane
    ModelTolerance tolerance;          ///< what a cheaper model may be off
    Lesson lesson;                     ///< what there is to feel
    std::vector<Caption> captions;     ///< of single nodes
    std::vector<std::string> warnings; ///< what of the file cannot be touched or drawn, by name
};

/// Prepares the haptic surface of a scene.
/// @throw InputError naming the file, if none of its triangles can be touched, or for what takes
///        too many steps or too much memory.
[[nodiscard]] contact::HapticSurface haptic_surface_of(const Scene &scene);

} // namespace springdrive::scene
