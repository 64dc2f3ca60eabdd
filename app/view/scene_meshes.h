// A scene's meshes and textures on the graphics card, and the variants of shaders/lit.* that draw
// them: a mesh pays only for what its material needs.
#pragma once

#include "app/view/gl_objects.h"
#include "app/view/painters.h"
#include "base/vector.h"
#include "engine/scene/scene.h"

#include <glm/vec3.hpp>

#include <compare>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

/// What a material needs beyond a base colour and a roughness.
struct LitVariant {
    bool metal = false;
    bool finish_texture = false; ///< of metal and roughness
    bool normal_texture = false;
    bool tangents = false; ///< of the file, for normal_texture
    bool occlusion_texture = false;
    bool emission = false;
    bool mask = false; ///< nothing where alpha is below alpha_cutoff
    bool translucent = false;

    [[nodiscard]] auto operator<=>(const LitVariant &) const = default;
};

// Units of textures in all variants; 2 and 3 are the shadow maps'.
inline constexpr int kBaseUnit = 0;
inline constexpr int kEmissiveUnit = 1;
inline constexpr int kSceneShadowUnit = 2;
inline constexpr int kMovingShadowUnit = 3;
inline constexpr int kFinishUnit = 4;
inline constexpr int kNormalUnit = 5;
inline constexpr int kOcclusionUnit = 6;

class LitPrograms {
public:
    /// Compiles the plain variant, without any of these.
    /// @throw std::runtime_error with OpenGL's log if it rejects the shader.
    LitPrograms() { with({}); }

    /// The variant, in use with its texture units set; compiled when first asked for.
    /// @throw std::runtime_error with OpenGL's log if it rejects the shader.
    const Program &with(const LitVariant &variant);

private:
    std::map<LitVariant, Program> programs_;
};

class SceneMeshes {
public:
    /// Makes the variant of shaders/lit.* ready to draw in the world.
    using Begin = std::function<const Program &(const LitVariant &variant)>;

    SceneMeshes() = default; ///< empty

    /// Nothing is uploaded yet. @param scene must exist until everything is uploaded
    explicit SceneMeshes(const scene::Scene &scene) : uploading_(&scene) {}

    /// Uploads for about `duration_s`. @return whether everything is uploaded
    bool upload(double duration_s);

    /// Warnings on textures of the scene that are not drawn as they are, each once.
    [[nodiscard]] std::vector<std::string> take_warnings() { return std::exchange(warnings_, {}); }

    /// The variants of shaders/lit.* that it is drawn with.
    [[nodiscard]] std::set<LitVariant> variants() const;

    // Both sides of a surface are drawn, as both can be touched.
    void draw_opaque(const Begin &begin) const;
    /// From the farthest to the nearest, of each the back faces before the front faces.
    /// @param forward unit, from the eye into the scene
    void draw_translucent(const Begin &begin, const Vector3 &forward) const;

    void draw_creases() const; ///< with shaders/creases.vert active

    void draw_solid_casters() const;       ///< what is neither translucent nor masked
    void draw_translucent_casters() const; ///< without textures
    /// With an active program that has MASK defined, whose uniforms of the mask it sets.
    void draw_masked_casters(const Program &program) const;

private:
    struct Item {
        GpuMesh mesh;
        scene::Finish finish; ///< with textures among textures_, −1 for none
        int texture;
        glm::vec3 emission;
        int emissive_texture;
        float alpha_cutoff; ///< of variant.mask
        Vector3 centre_m;
        LitVariant variant;
    };

    void draw(const Program &lit, const Item &item) const;
    void bind(int texture, int unit) const;
    void upload_next();
    void upload_mesh(const scene::VisualMesh &mesh);
    void upload_texture(const scene::Texture &texture);

    const scene::Scene *uploading_ = nullptr; ///< until upload is complete
    std::vector<Texture2D> textures_;         ///< the scene's, then a white one
    std::vector<Item> items_;                 ///< once uploaded, of one variant after the other
    std::optional<GpuLines> creases_;
    std::vector<std::string> warnings_;
};

} // namespace springdrive::app
