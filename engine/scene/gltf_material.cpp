#include "engine/scene/gltf_material.h"

#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/gltf_accessor.h"
#include "engine/scene/gltf_file.h"

#include <stb/stb_image.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>

namespace springdrive::scene::gltf {

namespace {

constexpr std::size_t kMaxPixels = 134'217'728; // 512 MB once decoded, over all textures

/// Everything is drawn in single precision.
/// @param what in messages: "material 3: baseColorFactor"
/// @param is in messages, what it ought to be
void require_drawable(std::span<const double> numbers, const std::string &what,
                      const std::string &is = "a colour is from 0 to 1, and") {
    for (const double number : numbers) {
        if (!(std::abs(number) <= static_cast<double>(std::numeric_limits<float>::max()))) {
            throw InputError(what + " is " + shortest_text(number) + "; " + is +
                             " must be finite in single precision");
        }
    }
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

/// Where a texture is drawn.
struct TexturePlace {
    int set = 0; ///< n of TEXCOORD_n
    TextureTransform transform;

    [[nodiscard]] bool operator==(const TexturePlace &) const = default;
};

/// @param info of tinygltf, which has a type for each kind of texture
template <typename Info> TexturePlace place_of(const Info &info) {
    TexturePlace place;
    place.set = info.texCoord;
    const auto extension = info.extensions.find("KHR_texture_transform");
    if (extension == info.extensions.end() || !extension->second.IsObject()) {
        return place;
    }
    const tinygltf::Value &transform = extension->second;
    place.transform.offset = read_pair(transform, "offset", place.transform.offset);
    place.transform.scale = read_pair(transform, "scale", place.transform.scale);
    if (transform.Get("rotation").IsNumber()) {
        place.transform.rotation_rad = transform.Get("rotation").GetNumberAsDouble();
    }
    if (transform.Get("texCoord").IsInt()) {
        place.set = transform.Get("texCoord").GetNumberAsInt();
    }
    return place;
}

bool has_texture(const DrawnMaterial &material) {
    return material.base_texture >= 0 || material.metallic_roughness_texture >= 0 ||
           material.normal_texture >= 0 || material.occlusion_texture >= 0;
}

/// A vertex has one pair of texture coordinates, which the first of a material's textures places.
/// @return whether a further one is drawn: not where it is placed differently
template <typename Info> bool add_texture(const Info &info, DrawnMaterial &material, int &texture) {
    const TexturePlace place = place_of(info);
    if (!has_texture(material)) {
        material.texture_set = place.set;
        material.transform = place.transform;
    } else if (place != TexturePlace{material.texture_set, material.transform}) {
        return false;
    }
    texture = info.index;
    return true;
}

constexpr const char *kElsewhere = ", as it is placed differently from the material's others";

/// @param name in warnings: "metallicFactor"
double share(double number, const std::string &name, DrawnMaterial &material) {
    const double drawn = std::clamp(number, 0.0, 1.0);
    if (drawn != number) {
        material.warnings.push_back("its material's " + name + " is " + shortest_text(number) +
                                    ", drawn as " + shortest_text(drawn) + ": it is from 0 to 1");
    }
    return drawn;
}

/// Reads how metallic and how rough the surface is, its normal map and its occlusion.
void read_finish(const tinygltf::Material &source, const std::string &place,
                 DrawnMaterial &material) {
    const tinygltf::PbrMetallicRoughness &finish = source.pbrMetallicRoughness;
    material.metallic = share(finish.metallicFactor, "metallicFactor", material);
    material.roughness = share(finish.roughnessFactor, "roughnessFactor", material);
    if (finish.metallicRoughnessTexture.index >= 0 &&
        !add_texture(finish.metallicRoughnessTexture, material,
                     material.metallic_roughness_texture)) {
        material.warnings.push_back(std::string("its texture of metal and roughness is left out") +
                                    kElsewhere);
    }
    if (source.normalTexture.index >= 0) {
        material.normal_scale = source.normalTexture.scale;
        require_drawable(std::array{material.normal_scale}, place + ": the normal texture's scale",
                         "a number");
        if (!add_texture(source.normalTexture, material, material.normal_texture)) {
            material.warnings.push_back(std::string("its normal map is left out") + kElsewhere);
        }
    }
    if (source.occlusionTexture.index >= 0) {
        material.occlusion_strength =
            share(source.occlusionTexture.strength, "occlusion strength", material);
        if (!add_texture(source.occlusionTexture, material, material.occlusion_texture)) {
            material.warnings.push_back(std::string("its occlusion is left out") + kElsewhere);
        }
    }
}

/// An encoded image: in a buffer view, or read.
struct EncodedImage {
    Bytes read;
    std::span<const unsigned char> bytes;
};

void read_emission(const tinygltf::Material &source, const std::string &place,
                   DrawnMaterial &material) {
    if (source.emissiveFactor.size() != material.emission.size()) {
        throw InputError(place + ": emissiveFactor has " +
                         std::to_string(source.emissiveFactor.size()) + " numbers; it takes 3");
    }
    std::copy(source.emissiveFactor.begin(), source.emissiveFactor.end(),
              material.emission.begin());
    const auto strength = source.extensions.find("KHR_materials_emissive_strength");
    if (strength != source.extensions.end() && strength->second.IsObject() &&
        strength->second.Get("emissiveStrength").IsNumber()) {
        for (double &part : material.emission) {
            part *= strength->second.Get("emissiveStrength").GetNumberAsDouble();
        }
    }
    require_drawable(material.emission, place + ": emissiveFactor");
    if (source.emissiveTexture.index < 0 || material.emission == std::array{0.0, 0.0, 0.0}) {
        return;
    }
    if (!add_texture(source.emissiveTexture, material, material.emissive_texture)) {
        material.emission = {0.0, 0.0, 0.0};
        material.warnings.push_back(
            "its emission is left out, as its texture is placed differently "
            "from the material's others");
    }
}

/// "'wood.png'", by its file or else its name; else its number.
std::string name_of(const tinygltf::Image &image, int index) {
    if (!image.uri.empty() && !is_data_uri(image.uri)) {
        return name_of_uri(image.uri);
    }
    return image.name.empty() ? std::to_string(index) : in_quotes(image.name);
}

/// The encoded image, or nothing with the reason in `problem`.
EncodedImage read_image(const tinygltf::Model &model, const tinygltf::Image &image,
                        const std::filesystem::path &folder, WarningList &warnings,
                        std::string &problem) {
    EncodedImage encoded;
    if (image.bufferView >= 0) {
        encoded.bytes = view_bytes(model, image.bufferView);
    } else if (!image.uri.empty()) {
        try {
            encoded.read =
                read_uri(image.uri, folder, std::numeric_limits<std::size_t>::max(), &warnings);
        } catch (const InputError &error) {
            problem = error.what();
            return encoded;
        }
        encoded.bytes = encoded.read;
    }
    constexpr std::array<unsigned char, 4> kPng{0x89, 'P', 'N', 'G'};
    constexpr std::array<unsigned char, 3> kJpeg{0xff, 0xd8, 0xff};
    const auto starts_with = [&](const auto &magic) {
        return encoded.bytes.size() > magic.size() &&
               std::memcmp(encoded.bytes.data(), magic.data(), magic.size()) == 0;
    };
    if (encoded.bytes.empty()) {
        problem = "is empty";
    } else if (encoded.bytes.size() > std::numeric_limits<int>::max() ||
               (!starts_with(kPng) && !starts_with(kJpeg))) {
        problem = "is neither PNG nor JPEG";
    }
    return encoded;
}

void make_opaque(std::span<std::uint8_t> rgba) {
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
        rgba[i] = 255;
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

struct ImageSize {
    std::size_t width = 0;
    std::size_t height = 0;
};

/// By the image's header; nothing if it is damaged. stb itself refuses a PNG that is too large for
/// it as it refuses a damaged one.
ImageSize size_of(std::span<const unsigned char> bytes) {
    constexpr std::size_t kPngHeader_bytes = 24; // signature, length, "IHDR", width, height
    if (bytes[0] == 0x89 && bytes.size() >= kPngHeader_bytes) {
        const auto read = [&](std::size_t at) {
            return std::size_t{bytes[at]} << 24U | std::size_t{bytes[at + 1]} << 16U |
                   std::size_t{bytes[at + 2]} << 8U | std::size_t{bytes[at + 3]};
        };
        return {read(16), read(20)};
    }
    int width = 0;
    int height = 0;
    int channels = 0;
    const bool is_known = stbi_info_from_memory(bytes.data(), static_cast<int>(bytes.size()),
                                                &width, &height, &channels) != 0;
    return is_known && width > 0 && height > 0
               ? ImageSize{static_cast<std::size_t>(width), static_cast<std::size_t>(height)}
               : ImageSize{};
}

/// @return no pixels, and the reason in `problem`, when the bytes are no image or too large a one
Texture decode(std::span<const unsigned char> bytes, std::size_t max_pixels, std::string &problem) {
    const ImageSize size = size_of(bytes);
    if (size.height > 0 && size.width > max_pixels / size.height) {
        problem = "is too large with " + std::to_string(size.width) + " x " +
                  std::to_string(size.height) + " pixels: of " + std::to_string(kMaxPixels) +
                  " for all textures together, " + std::to_string(max_pixels) + " are left";
        return {};
    }
    Texture texture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void *)> rgba(
        stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &texture.width,
                              &texture.height, &channels, 4),
        &stbi_image_free);
    if (rgba == nullptr) {
        problem = "is damaged";
        return {};
    }
    const auto pixels =
        static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
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

DrawnMaterial read_material(const tinygltf::Model &model, int material) {
    DrawnMaterial drawn;
    if (material < 0) {
        return drawn;
    }
    const tinygltf::Material &source = checked(model.materials, material, "material");
    const std::string place = "material " + std::to_string(material);
    const std::vector<double> &factor = source.pbrMetallicRoughness.baseColorFactor;
    if (factor.size() != drawn.base_factor.size()) {
        throw InputError(place + ": baseColorFactor has " + std::to_string(factor.size()) +
                         " numbers; it takes 4");
    }
    require_drawable(factor, place + ": baseColorFactor");
    std::copy(factor.begin(), factor.end(), drawn.base_factor.begin());
    if (source.pbrMetallicRoughness.baseColorTexture.index >= 0) {
        add_texture(source.pbrMetallicRoughness.baseColorTexture, drawn, drawn.base_texture);
    }
    read_finish(source, place, drawn);
    read_emission(source, place, drawn);
    drawn.alpha_mode = source.alphaMode == "BLEND"  ? AlphaMode::blend
                       : source.alphaMode == "MASK" ? AlphaMode::mask
                                                    : AlphaMode::opaque;
    drawn.alpha_cutoff = source.alphaCutoff;
    require_drawable(std::array{drawn.alpha_cutoff}, place + ": alphaCutoff", "a number");
    drawn.double_sided = source.doubleSided;
    return drawn;
}

int TextureLibrary::find_or_load(int texture_index, TextureUse use, WarningList &warnings) {
    if (texture_index < 0) {
        return -1;
    }
    const auto [entry, is_new] = loaded_.try_emplace(std::pair(texture_index, use), -1);
    if (!is_new) {
        return entry->second;
    }
    const tinygltf::Texture &source = checked(model_.textures, texture_index, "texture");
    if (source.source < 0) {
        warnings.add_of("texture " + std::to_string(texture_index), nullptr,
                        "left out, as it names no PNG or JPEG");
        return -1;
    }
    const tinygltf::Image &image = checked(model_.images, source.source, "image");
    std::string problem;
    Texture texture;
    const EncodedImage encoded = read_image(model_, image, folder_, warnings, problem);
    if (problem.empty()) {
        texture = decode(encoded.bytes, kMaxPixels - pixels_, problem);
    }
    if (!problem.empty()) {
        warnings.add_of("image " + name_of(image, source.source), &image,
                        "left out, as it " + problem);
        return -1;
    }
    if (source.sampler >= 0) {
        const tinygltf::Sampler &sampler = checked(model_.samplers, source.sampler, "sampler");
        texture.wrap_s = wrap_from(sampler.wrapS);
        texture.wrap_t = wrap_from(sampler.wrapT);
    }
    if (use != TextureUse::colours_with_alpha) {
        make_opaque(texture.rgba);
    }
    texture.holds_numbers = use == TextureUse::numbers;
    texture.has_alpha = any_see_through(texture.rgba);
    pixels_ += texture.rgba.size() / 4;
    entry->second = static_cast<int>(textures_.size());
    textures_.push_back(std::move(texture));
    return entry->second;
}

} // namespace springdrive::scene::gltf
