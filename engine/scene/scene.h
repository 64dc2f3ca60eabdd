// A scene as loaded from a glTF file: what is drawn, what is touched, and how it was fitted.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/contact/proxy/analytic_shape.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/lesson.h"
#include "engine/scene/model_tolerance.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::scene {

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

} // namespace springdrive::scene
