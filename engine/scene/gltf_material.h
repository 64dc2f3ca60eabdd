// The colours of a glTF's materials, and their textures, decoded when first asked for.
#pragma once

#include "base/assertions.h"
#include "engine/scene/remark_list.h"
#include "engine/scene/scene.h"

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
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

struct BaseColour {
    std::array<double, 4> factor{1.0, 1.0, 1.0, 1.0}; ///< linear
    int texture = -1;                                 ///< index into the model's textures
    int texture_set = 0;                              ///< n of TEXCOORD_n
    TextureTransform transform;
    std::array<double, 3> emission{0.0, 0.0, 0.0}; ///< linear
    int emissive_texture = -1;      ///< index into the model's textures; placed as the other one
    bool emission_left_out = false; ///< its texture is placed differently from the other one
    AlphaMode alpha_mode = AlphaMode::opaque;
    double alpha_cutoff = 0.5; ///< of AlphaMode::mask
    bool double_sided = false;
};

/// @param material index into the model's materials; −1 gives glTF's default material
/// @throw InputError for a material that does not exist, has too few numbers, or numbers that are
///        not finite.
[[nodiscard]] BaseColour read_base_colour(const tinygltf::Model &model, int material);

/// The textures of a scene, each decoded once for each way in which its alpha is used.
class TextureLibrary {
public:
    /// @param folder of the scene's file, in which its images are looked for
    TextureLibrary(const tinygltf::Model &model, std::filesystem::path folder)
        : model_(model), folder_(std::move(folder)) {}

    /// @return index into the textures, or −1 when the base colour has none or its image cannot
    ///         be decoded: then `remarks` gains the reason, once for each texture.
    /// @throw InputError for references to textures, images or samplers that do not exist.
    int find_or_load(const BaseColour &colour, RemarkList &remarks);

    /// The same for the texture of its emission, whose alpha is ignored.
    int find_or_load_emissive(const BaseColour &colour, RemarkList &remarks);

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
    std::map<std::tuple<int, AlphaMode, double>, int> loaded_;
    std::size_t pixels_ = 0;
};

} // namespace springdrive::scene::gltf
