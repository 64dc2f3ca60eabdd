// The variants of shaders/lit.*: a mesh pays only for what its material needs.
#pragma once

#include "app/view/gl_objects.h"

#include <compare>
#include <map>

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

} // namespace springdrive::app
