// How a glTF's materials are drawn, and their textures, decoded when first asked for.
#pragma once

#include "base/assertions.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace tinygltf {
class Model;
}

namespace springdrive::scene::gltf {

enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// KHR_texture_transform: scaled, then turned, then shifted.
struct TextureTransform {
    std::array<double, 2> offset{0.0, 0.0};
    double rotation_rad = 0.0;
    std::array<double, 2> scale{1.0, 1.0};

    [[nodiscard]] std::array<double, 2> operator()(double u, double v) const;
    [[nodiscard]] bool operator==(const TextureTransform &) const = default;
};

/// Textures are indices into the model's textures, −1 for none.
struct DrawnMaterial {
    std::array<double, 4> base_factor{1.0, 1.0, 1.0, 1.0}; ///< linear
    int base_texture = -1;
    double metallic = 1.0; ///< 0 to 1, as roughness and occlusion_strength
    double roughness = 1.0;
    int metallic_roughness_texture = -1;
    int normal_texture = -1;
    double normal_scale = 1.0;
    int occlusion_texture = -1;
    double occlusion_strength = 1.0;
    std::array<double, 3> emission{0.0, 0.0, 0.0}; ///< linear
    int emissive_texture = -1;
    int texture_set = 0;        ///< n of TEXCOORD_n, of all textures
    TextureTransform transform; ///< of all textures
    AlphaMode alpha_mode = AlphaMode::opaque;
    double alpha_cutoff = 0.5; ///< of AlphaMode::mask
    bool double_sided = false;
    std::vector<std::string> warnings; ///< on what of it is drawn differently
};

/// @param material index into the model's materials; −1 gives glTF's default material
/// @throw InputError for a material that does not exist, has too few numbers, or numbers that are
///        not finite.
[[nodiscard]] DrawnMaterial read_material(const tinygltf::Model &model, int material);

/// What a texture's pixels are.
enum class TextureUse : std::uint8_t { colours, colours_with_alpha, numbers };

/// The textures of a scene, each decoded once for each use.
class TextureLibrary {
public:
    /// @param folder of the scene's file, in which its images are looked for
    TextureLibrary(const tinygltf::Model &model, std::filesystem::path folder)
        : model_(model), folder_(std::move(folder)) {}

    /// @param texture_index into the model's textures, or −1
    /// @return index into the textures, or −1 when there is none or its image cannot be decoded:
    ///         then `warnings` gains the reason, once for each texture.
    /// @throw InputError for references to textures, images or samplers that do not exist.
    int find_or_load(int texture_index, TextureUse use, WarningList &warnings);

    /// Whether any of its pixels is not opaque. @pre `find_or_load` returned it
    [[nodiscard]] bool has_alpha(int texture) const {
        SPRINGDRIVE_ASSERT(texture >= 0 && static_cast<std::size_t>(texture) < textures_.size());
        return textures_[static_cast<std::size_t>(texture)].has_alpha;
    }

    [[nodiscard]] std::vector<Texture> take() { return std::move(textures_); }

private:
    const tinygltf::Model &model_;
    std::filesystem::path folder_;
    std::vector<Texture> textures_;
    std::map<std::pair<int, TextureUse>, int> loaded_;
    std::size_t pixels_ = 0;
};

} // namespace springdrive::scene::gltf
