#include "engine/scene/gltf_material.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "engine/scene/gltf_accessor.h"

#include <stb/stb_image.h>
#include <tiny_gltf.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>

namespace springdrive::scene::gltf {

namespace {

constexpr std::size_t kMaxPixels = 134'217'728; // 512 MB once decoded, over all textures

template <typename Item>
const Item &checked(const std::vector<Item> &items, int index, const std::string &what) {
    if (index < 0 || static_cast<std::size_t>(index) >= items.size()) {
        throw InputError(what + " " + std::to_string(index) + " is not in the file, which has " +
                         std::to_string(items.size()));
    }
    return items[static_cast<std::size_t>(index)];
}

std::array<double, 2> read_pair(const tinygltf::Value &object, const std::string &key,
                                const std::array<double, 2> &otherwise) {
    const tinygltf::Value &pair = object.Get(key);
    if (!pair.IsArray() || pair.ArrayLen() != 2 || !pair.Get(0).IsNumber() ||
        !pair.Get(1).IsNumber()) {
        return otherwise;
    }
    return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

void read_texture(const tinygltf::TextureInfo &info, BaseColour &colour) {
    colour.texture = info.index;
    colour.texture_set = info.texCoord;
    const auto extension = info.extensions.find("KHR_texture_transform");
    if (extension == info.extensions.end() || !extension->second.IsObject()) {
        return;
    }
    const tinygltf::Value &transform = extension->second;
    colour.transform.offset = read_pair(transform, "offset", colour.transform.offset);
    colour.transform.scale = read_pair(transform, "scale", colour.transform.scale);
    if (transform.Get("rotation").IsNumber()) {
        colour.transform.rotation_rad = transform.Get("rotation").GetNumberAsDouble();
    }
    if (transform.Get("texCoord").IsInt()) {
        colour.texture_set = transform.Get("texCoord").GetNumberAsInt();
    }
}

/// The encoded image, or nothing with the reason in `problem`.
std::span<const unsigned char> encoded_bytes(const tinygltf::Model &model,
                                             const tinygltf::Image &image, std::string &problem) {
    const std::span<const unsigned char> bytes = image.bufferView >= 0
                                                     ? view_bytes(model, image.bufferView)
                                                     : std::span<const unsigned char>(image.image);
    constexpr std::array<unsigned char, 4> kPng{0x89, 'P', 'N', 'G'};
    constexpr std::array<unsigned char, 3> kJpeg{0xff, 0xd8, 0xff};
    const auto starts_with = [&](const auto &magic) {
        return bytes.size() > magic.size() &&
               std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
    };
    if (bytes.empty()) {
        problem = image.uri.empty() ? "is empty" : in_quotes(image.uri) + " cannot be read";
        return {};
    }
    if (bytes.size() > std::numeric_limits<int>::max() ||
        (!starts_with(kPng) && !starts_with(kJpeg))) {
        problem = "is neither PNG nor JPEG";
        return {};
    }
    return bytes;
}

/// Writes the alpha mode into the pixels, so that drawing needs their alpha only.
void apply_alpha(std::span<std::uint8_t> rgba, AlphaMode mode, double cutoff) {
    if (mode == AlphaMode::blend) {
        return;
    }
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
        const bool solid = mode == AlphaMode::opaque || rgba[i] / 255.0 >= cutoff;
        rgba[i] = solid ? 255 : 0;
    }
}

bool any_see_through(std::span<const std::uint8_t> rgba) {
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
        if (rgba[i] < 255) {
            return true;
        }
    }
    return false;
}

/// @return no pixels, and the reason in `problem`, when the bytes are no image or too large a one
Texture decode(std::span<const unsigned char> bytes, std::size_t max_pixels, std::string &problem) {
    Texture texture;
    int channels = 0;
    const auto size = static_cast<int>(bytes.size());
    if (stbi_info_from_memory(bytes.data(), size, &texture.width, &texture.height, &channels) ==
        0) {
        problem = "is damaged";
        return {};
    }
    const auto pixels =
        static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
    if (pixels == 0 || pixels > max_pixels) {
        problem = "is too large with " + std::to_string(texture.width) + " x " +
                  std::to_string(texture.height) + " pixels";
        return {};
    }
    const std::unique_ptr<stbi_uc, void (*)(void *)> rgba(
        stbi_load_from_memory(bytes.data(), size, &texture.width, &texture.height, &channels, 4),
        &stbi_image_free);
    if (rgba == nullptr) {
        problem = "is damaged";
        return {};
    }
    texture.rgba.assign(rgba.get(), rgba.get() + 4 * pixels);
    return texture;
}

Texture::Wrap wrap_from(int gl_mode) {
    switch (gl_mode) {
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return Texture::Wrap::clamp;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return Texture::Wrap::mirror;
    default:
        return Texture::Wrap::repeat;
    }
}

} // namespace

std::array<double, 2> TextureTransform::operator()(double u, double v) const {
    const double c = std::cos(rotation_rad);
    const double s = std::sin(rotation_rad);
    const double scaled_u = scale[0] * u;
    const double scaled_v = scale[1] * v;
    return {offset[0] + c * scaled_u + s * scaled_v, offset[1] - s * scaled_u + c * scaled_v};
}

BaseColour read_base_colour(const tinygltf::Model &model, int material) {
    BaseColour colour;
    if (material < 0) {
        return colour;
    }
    const tinygltf::Material &source = checked(model.materials, material, "material");
    const std::vector<double> &factor = source.pbrMetallicRoughness.baseColorFactor;
    if (factor.size() != colour.factor.size()) {
        throw InputError("material " + std::to_string(material) + ": baseColorFactor has " +
                         std::to_string(factor.size()) + " numbers; it takes 4");
    }
    std::copy(factor.begin(), factor.end(), colour.factor.begin());
    if (source.pbrMetallicRoughness.baseColorTexture.index >= 0) {
        read_texture(source.pbrMetallicRoughness.baseColorTexture, colour);
    }
    colour.alpha_mode = source.alphaMode == "BLEND"  ? AlphaMode::blend
                        : source.alphaMode == "MASK" ? AlphaMode::mask
                                                     : AlphaMode::opaque;
    colour.alpha_cutoff = source.alphaCutoff;
    colour.double_sided = source.doubleSided;
    return colour;
}

int TextureLibrary::find_or_load(const BaseColour &colour, std::vector<std::string> &remarks) {
    if (colour.texture < 0) {
        return -1;
    }
    const auto key = std::tuple(colour.texture, colour.alpha_mode, colour.alpha_cutoff);
    const auto [entry, is_new] = loaded_.try_emplace(key, -1);
    if (!is_new) {
        return entry->second;
    }
    const tinygltf::Texture &source = checked(model_.textures, colour.texture, "texture");
    std::string problem;
    Texture texture;
    if (source.source < 0) {
        problem = "names no PNG or JPEG";
    } else {
        const tinygltf::Image &image = checked(model_.images, source.source, "image");
        const std::span<const unsigned char> bytes = encoded_bytes(model_, image, problem);
        if (problem.empty()) {
            texture = decode(bytes, kMaxPixels - pixels_, problem);
        }
    }
    if (!problem.empty()) {
        remarks.push_back("texture " + std::to_string(colour.texture) + " is left out: its image " +
                          problem);
        return -1;
    }
    if (source.sampler >= 0) {
        const tinygltf::Sampler &sampler = checked(model_.samplers, source.sampler, "sampler");
        texture.wrap_s = wrap_from(sampler.wrapS);
        texture.wrap_t = wrap_from(sampler.wrapT);
    }
    apply_alpha(texture.rgba, colour.alpha_mode, colour.alpha_cutoff);
    texture.has_alpha = any_see_through(texture.rgba);
    pixels_ += texture.rgba.size() / 4;
    entry->second = static_cast<int>(textures_.size());
    textures_.push_back(std::move(texture));
    return entry->second;
}

} // namespace springdrive::scene::gltf
