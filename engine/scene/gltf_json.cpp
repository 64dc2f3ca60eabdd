#include "engine/scene/gltf_file.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/text.h"
#include "engine/scene/gltf_accessor.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::scene::gltf {

namespace {

using nlohmann::json;

constexpr std::size_t kDeepestJson = 100; // glTF itself needs about ten

/// Follows the parser through a text that it refuses, to the place where it does.
class PlaceOfError : public nlohmann::json_sax<json> {
public:
    bool null() override { return next(); }
    bool boolean(bool /*value*/) override { return next(); }
    bool number_integer(number_integer_t /*value*/) override { return next(); }
    bool number_unsigned(number_unsigned_t /*value*/) override { return next(); }
    bool number_float(number_float_t /*value*/, const string_t & /*text*/) override {
        return next();
    }
    bool string(string_t & /*value*/) override { return next(); }
    bool binary(binary_t & /*value*/) override { return next(); }
    bool start_object(std::size_t /*elements*/) override { return begin(false); }
    bool start_array(std::size_t /*elements*/) override { return begin(true); }
    bool end_object() override { return end(); }
    bool end_array() override { return end(); }
    bool key(string_t &name) override {
        levels_.back().key = name;
        return true;
    }
    bool parse_error(std::size_t /*position*/, const std::string &last_read,
                     const nlohmann::detail::exception &error) override {
        constexpr int kNumberOutOfRange = 406;
        if (error.id == kNumberOutOfRange) {
            message_ = place() + " is " + one_line(last_read, 40) +
                       "; it must be a number that is finite in double precision";
        } else {
            const std::string what = error.what(); // "[json.exception.…] parse error at …"
            const std::size_t prefix = what.find("] ");
            message_ = "is no valid glTF: " +
                       one_line(prefix == std::string::npos ? what : what.substr(prefix + 2));
        }
        return false;
    }

    [[nodiscard]] const std::string &message() const { return message_; }

private:
    struct Level {
        bool is_array;
        std::size_t index = 0;
        std::string key;
    };

    bool begin(bool is_array) {
        levels_.push_back({is_array, 0, {}});
        return true;
    }
    bool end() {
        levels_.pop_back();
        return next();
    }
    bool next() {
        if (!levels_.empty()) {
            ++levels_.back().index;
        }
        return true;
    }
    /// As JavaScript has it: "materials[0].emissiveFactor[2]".
    [[nodiscard]] std::string place() const {
        std::string path;
        for (const Level &level : levels_) {
            path += level.is_array ? "[" + std::to_string(level.index) + "]"
                                   : (path.empty() ? "" : ".") + one_line(level.key, 40);
        }
        return path.empty() ? "its JSON" : path;
    }

    std::vector<Level> levels_;
    std::string message_;
};

enum class Kind : std::uint8_t {
    integer,    ///< an index or a code; −1 also stands for none
    whole,      ///< from 0
    int_whole,  ///< from 0, where tinygltf has an int
    number,     ///< any number
    text,       ///< a string
    numbers,    ///< an array of numbers
    integers,   ///< an array of integers
    texts,      ///< an array of strings
    object,     ///< with members
    indices_of, ///< an object of integers
    items,      ///< an array of objects with members
};

enum class Presence : std::uint8_t { optional, required };

struct Member {
    const char *name;
    Kind kind;
    Presence presence = Presence::optional;
    std::span<const Member> inner{};
    const char *item = ""; ///< what one of the items is called; default: by the member's name
};

constexpr auto kRequired = Presence::required;
constexpr auto kOptional = Presence::optional;

constexpr std::array kAsset{Member{"version", Kind::text, kRequired},
                            Member{"minVersion", Kind::text}};
constexpr std::array kBuffer{Member{"byteLength", Kind::whole, kRequired},
                             Member{"uri", Kind::text}};
constexpr std::array kBufferView{
    Member{"buffer", Kind::integer, kRequired}, Member{"byteOffset", Kind::whole},
    Member{"byteLength", Kind::whole, kRequired}, Member{"byteStride", Kind::whole}};
constexpr std::array kSparseIndices{Member{"bufferView", Kind::integer, kRequired},
                                    Member{"byteOffset", Kind::int_whole},
                                    Member{"componentType", Kind::integer, kRequired}};
constexpr std::array kSparseValues{Member{"bufferView", Kind::integer, kRequired},
                                   Member{"byteOffset", Kind::int_whole}};
constexpr std::array kSparse{Member{"count", Kind::int_whole, kRequired},
                             Member{"indices", Kind::object, kRequired, kSparseIndices},
                             Member{"values", Kind::object, kRequired, kSparseValues}};
constexpr std::array kAccessor{Member{"bufferView", Kind::integer},
                               Member{"byteOffset", Kind::whole},
                               Member{"componentType", Kind::integer, kRequired},
                               Member{"count", Kind::whole, kRequired},
                               Member{"type", Kind::text, kRequired},
                               Member{"sparse", Kind::object, kOptional, kSparse}};
constexpr std::array kTarget{Member{"POSITION", Kind::integer}, Member{"NORMAL", Kind::integer},
                             Member{"TANGENT", Kind::integer}};
constexpr std::array kPrimitive{Member{"attributes", Kind::indices_of, kRequired},
                                Member{"indices", Kind::integer}, Member{"material", Kind::integer},
                                Member{"mode", Kind::integer},
                                Member{"targets", Kind::items, kOptional, kTarget, "target"}};
constexpr std::array kMesh{Member{"primitives", Kind::items, kRequired, kPrimitive, "primitive"},
                           Member{"weights", Kind::numbers}};
constexpr std::array kNode{Member{"children", Kind::integers}, Member{"mesh", Kind::integer},
                           Member{"matrix", Kind::numbers},    Member{"translation", Kind::numbers},
                           Member{"rotation", Kind::numbers},  Member{"scale", Kind::numbers},
                           Member{"skin", Kind::integer},      Member{"weights", Kind::numbers}};
constexpr std::array kSkin{Member{"joints", Kind::integers, kRequired},
                           Member{"inverseBindMatrices", Kind::integer}};
constexpr std::array kScene{Member{"nodes", Kind::integers}};
constexpr std::array kTextureInfo{Member{"index", Kind::integer, kRequired},
                                  Member{"texCoord", Kind::integer}};
constexpr std::array kMetallicRoughness{
    Member{"baseColorFactor", Kind::numbers},
    Member{"baseColorTexture", Kind::object, kOptional, kTextureInfo}};
constexpr std::array kMaterial{
    Member{"pbrMetallicRoughness", Kind::object, kOptional, kMetallicRoughness},
    Member{"emissiveFactor", Kind::numbers},
    Member{"emissiveTexture", Kind::object, kOptional, kTextureInfo},
    Member{"alphaMode", Kind::text}, Member{"alphaCutoff", Kind::number}};
constexpr std::array kTexture{Member{"source", Kind::integer}, Member{"sampler", Kind::integer}};
constexpr std::array kImage{Member{"uri", Kind::text}, Member{"bufferView", Kind::integer}};
constexpr std::array kSampler{Member{"wrapS", Kind::integer}, Member{"wrapT", Kind::integer}};
constexpr std::array kDocument{
    Member{"asset", Kind::object, kRequired, kAsset},
    Member{"extensionsUsed", Kind::texts},
    Member{"extensionsRequired", Kind::texts},
    Member{"scene", Kind::integer},
    Member{"scenes", Kind::items, kOptional, kScene, "scene"},
    Member{"nodes", Kind::items, kOptional, kNode, "node"},
    Member{"meshes", Kind::items, kOptional, kMesh, "mesh"},
    Member{"skins", Kind::items, kOptional, kSkin, "skin"},
    Member{"materials", Kind::items, kOptional, kMaterial, "material"},
    Member{"textures", Kind::items, kOptional, kTexture, "texture"},
    Member{"images", Kind::items, kOptional, kImage, "image"},
    Member{"samplers", Kind::items, kOptional, kSampler, "sampler"},
    Member{"accessors", Kind::items, kOptional, kAccessor, "accessor"},
    Member{"bufferViews", Kind::items, kOptional, kBufferView, "buffer view"},
    Member{"buffers", Kind::items, kOptional, kBuffer, "buffer"},
    Member{"animations", Kind::items, kOptional, {}, "animation"}};

std::string text_of(Kind kind) {
    switch (kind) {
    case Kind::integer:
        return "a whole number of 32 bits";
    case Kind::whole:
        return "a whole number from 0";
    case Kind::int_whole:
        return "a whole number from 0 to 2147483647";
    case Kind::number:
        return "a number";
    case Kind::text:
        return "a text";
    case Kind::numbers:
        return "an array of numbers";
    case Kind::integers:
        return "an array of whole numbers";
    case Kind::texts:
        return "an array of texts";
    case Kind::object:
        return "an object";
    case Kind::indices_of:
        return "an object of whole numbers";
    case Kind::items:
        break;
    }
    return "an array of objects";
}

/// @param place in messages: "accessor 3"
[[noreturn]] void refuse(const std::string &place, const json &value, Kind kind) {
    throw InputError(place + " is " + one_line(value.dump(), 40) + "; it must be " + text_of(kind));
}

/// "4.0" becomes 4.
void make_whole(json &value) {
    constexpr double kMax = 9007199254740992.0; // up to which doubles hold all whole numbers
    if (value.is_number_float()) {
        const auto number = value.get<double>();
        if (number == std::floor(number) && std::abs(number) <= kMax) {
            value = number < 0.0 ? json(static_cast<std::int64_t>(number))
                                 : json(static_cast<std::uint64_t>(number));
        }
    }
}

bool is_integer(json &value) {
    make_whole(value);
    constexpr std::int64_t kLowest = std::numeric_limits<std::int32_t>::min();
    constexpr std::int64_t kHighest = std::numeric_limits<std::int32_t>::max();
    return value.is_number_unsigned()
               ? value.get<std::uint64_t>() <= static_cast<std::uint64_t>(kHighest)
               : value.is_number_integer() && value.get<std::int64_t>() >= kLowest;
}

bool is_whole(json &value) {
    make_whole(value);
    return value.is_number_unsigned();
}

template <typename Test> bool is_array_of(json &value, Test &&test) {
    return value.is_array() && std::ranges::all_of(value, test);
}

bool is_number(const json &value) { return value.is_number(); }
bool is_text(const json &value) { return value.is_string(); }

/// Whether `value` itself is of `kind`; not what is within items and objects with members.
bool is_of(Kind kind, json &value) {
    switch (kind) {
    case Kind::integer:
        return is_integer(value);
    case Kind::whole:
        return is_whole(value);
    case Kind::int_whole:
        return is_integer(value) && is_whole(value);
    case Kind::number:
        return is_number(value);
    case Kind::text:
        return is_text(value);
    case Kind::numbers:
        return is_array_of(value, is_number);
    case Kind::integers:
        return is_array_of(value, is_integer);
    case Kind::texts:
        return is_array_of(value, is_text);
    case Kind::indices_of:
        return value.is_object() && std::ranges::all_of(value, is_integer);
    case Kind::object:
        return value.is_object();
    case Kind::items:
        break;
    }
    return value.is_array();
}

void check_object(json &object, std::span<const Member> members, const std::string &place);

void check_items(json &items, const Member &member, const std::string &place) {
    std::size_t index = 0;
    for (json &item : items) {
        stop_if_given_up(index);
        const std::string item_place =
            (place.empty() ? "" : place + ": ") + member.item + " " + std::to_string(index++);
        if (!item.is_object()) {
            refuse(item_place, item, Kind::object);
        }
        check_object(item, member.inner, item_place);
    }
}

void check_object(json &object, std::span<const Member> members, const std::string &place) {
    for (const Member &member : members) {
        const auto found = object.find(member.name);
        if (found == object.end()) {
            if (member.presence == Presence::required) {
                throw InputError((place.empty() ? "is no valid glTF: it" : place) + " has no " +
                                 member.name);
            }
            continue;
        }
        const std::string owner = place.empty() ? "its " : place + ": its ";
        if (!is_of(member.kind, *found)) {
            refuse(owner + member.name, *found, member.kind);
        }
        if (member.kind == Kind::items) {
            check_items(*found, member, place);
        } else if (member.kind == Kind::object) {
            check_object(*found, member.inner,
                         (place.empty() ? "" : place + ": ") + std::string(member.name));
        }
    }
}

/// Extensions that are read, and those without which a scene has the same shape and base colours.
/// The materials are those in the registry of ratified extensions,
/// https://github.com/KhronosGroup/glTF/blob/main/extensions/README.md: what another one changes is
/// not known.
constexpr std::array<std::string_view, 22> kSupported = {kDracoExtension,
                                                         "EXT_mesh_gpu_instancing",
                                                         kMeshoptExtensions[0],
                                                         kMeshoptExtensions[1],
                                                         "KHR_animation_pointer",
                                                         "KHR_lights_punctual",
                                                         "KHR_materials_anisotropy",
                                                         "KHR_materials_clearcoat",
                                                         "KHR_materials_dispersion",
                                                         "KHR_materials_emissive_strength",
                                                         "KHR_materials_ior",
                                                         "KHR_materials_iridescence",
                                                         "KHR_materials_sheen",
                                                         "KHR_materials_specular",
                                                         "KHR_materials_transmission",
                                                         "KHR_materials_unlit",
                                                         "KHR_materials_variants",
                                                         "KHR_materials_volume",
                                                         "KHR_mesh_quantization",
                                                         "KHR_texture_transform",
                                                         "KHR_xmp",
                                                         "KHR_xmp_json_ld"};

/// Those without which a scene looks otherwise but has the same shape: left out, with a warning.
constexpr std::array<std::string_view, 15> kLooksOnly = {"ADOBE_materials_thin_transparency",
                                                         "CESIUM_primitive_outline",
                                                         "EXT_lights_ies",
                                                         "EXT_lights_image_based",
                                                         "EXT_texture_avif",
                                                         "EXT_texture_webp",
                                                         "KHR_materials_diffuse_transmission",
                                                         "KHR_materials_pbrSpecularGlossiness",
                                                         "KHR_materials_volume_scatter",
                                                         "KHR_techniques_webgl",
                                                         "KHR_texture_basisu",
                                                         "MSFT_packing_normalRoughnessMetallic",
                                                         "MSFT_packing_occlusionRoughnessMetallic",
                                                         "MSFT_texture_dds",
                                                         "VRMC_materials_mtoon"};

bool is_supported(std::string_view extension) {
    return std::ranges::find(kSupported, extension) != kSupported.end();
}

json member_or(const json &object, const char *name, json otherwise) {
    return object.is_object() ? object.value(name, std::move(otherwise)) : otherwise;
}

/// "2.1" as 2 and 1; nothing for what is no version.
std::array<int, 2> version_of(const std::string &text) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const std::size_t point = text.find('.');
    constexpr std::size_t kMaxDigits = 4;
    const bool is_version =
        point != std::string::npos && point > 0 && point <= kMaxDigits &&
        text.size() - point - 1 > 0 && text.size() - point - 1 <= kMaxDigits &&
        std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(point), is_digit) &&
        std::all_of(text.begin() + static_cast<std::ptrdiff_t>(point) + 1, text.end(), is_digit);
    if (!is_version) {
        return {0, 0};
    }
    return {std::stoi(text.substr(0, point)), std::stoi(text.substr(point + 1))};
}

} // namespace

std::size_t json_nesting_depth(std::string_view text) {
    std::size_t depth = 0;
    std::size_t deepest = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            i += c == '\\' ? 1 : 0;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            deepest = std::max(deepest, ++depth);
        } else if ((c == ']' || c == '}') && depth > 0) {
            --depth;
        }
    }
    return deepest;
}

json parse_json(std::string_view text) {
    if (json_nesting_depth(text) > kDeepestJson) {
        throw InputError("nests its JSON deeper than " + std::to_string(kDeepestJson) +
                         " levels; no glTF does");
    }
    json document = json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
    if (document.is_discarded()) {
        PlaceOfError place;
        (void)json::sax_parse(text.begin(), text.end(), &place);
        throw InputError(place.message());
    }
    if (!document.is_object()) {
        throw InputError("is no valid glTF: its JSON is no object");
    }
    return document;
}

void check_members(json &document) { check_object(document, kDocument, ""); }

void check_versions_and_extensions(const json &document) {
    const json &asset = document["asset"];
    const auto version = asset["version"].get<std::string>();
    if (version_of(version)[0] != 2) {
        throw InputError("is glTF version " + in_quotes(version) + "; export it as glTF 2.0");
    }
    const auto minimum = asset.value("minVersion", std::string("2.0"));
    if (version_of(minimum) != std::array{2, 0}) {
        throw InputError("needs glTF version " + in_quotes(minimum) +
                         " (its minVersion); export it as glTF 2.0");
    }
    for (const json &required : member_or(document, "extensionsRequired", json::array())) {
        const auto extension = required.get<std::string>();
        if (!is_supported(extension) &&
            std::ranges::find(kLooksOnly, extension) == kLooksOnly.end()) {
            throw InputError("needs the extension " + in_quotes(extension) +
                             ", which is not supported; export it without");
        }
    }
}

void warn_about_left_out(const json &document, WarningList &warnings) {
    std::set<std::string> left_out;
    for (const char *list : {"extensionsUsed", "extensionsRequired"}) {
        for (const json &item : member_or(document, list, json::array())) {
            const auto extension = item.get<std::string>();
            if (!is_supported(extension) && left_out.insert(extension).second) {
                warnings.add("extension " + in_quotes(extension) + " is left out");
            }
        }
    }
    if (const std::size_t count = member_or(document, "animations", json::array()).size();
        count > 0) {
        warnings.add(std::to_string(count) +
                     " animation(s) are not played: the scene stands still");
    }
}

} // namespace springdrive::scene::gltf
