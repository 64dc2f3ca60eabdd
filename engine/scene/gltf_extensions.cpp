#include "engine/scene/gltf_extensions.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "engine/scene/gltf_accessor.h"
#include "engine/scene/gltf_meshopt.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

using nlohmann::json;

constexpr std::string_view kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

/// Extensions that are read, and those without which a scene has the same shape and base colours.
/// The materials are those in the registry of ratified extensions,
/// https://github.com/KhronosGroup/glTF/blob/main/extensions/README.md: what another one changes is
/// not known.
constexpr std::array<std::string_view, 20> kSupported = {kDracoExtension,
                                                         kMeshoptExtension,
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

bool is_supported(std::string_view extension) {
    return std::ranges::find(kSupported, extension) != kSupported.end();
}

json member_or(const json &object, const char *name, json otherwise) {
    return object.is_object() ? object.value(name, std::move(otherwise)) : otherwise;
}

/// Each material needs a colour that can be drawn.
void check_fallback(const json &document, std::string_view extension) {
    std::size_t index = 0;
    for (const json &material : member_or(document, "materials", json::array())) {
        if (member_or(material, "extensions", json::object()).contains(extension) &&
            !material.contains("pbrMetallicRoughness")) {
            throw InputError("material " + std::to_string(index) + " needs the extension " +
                             in_quotes(extension) +
                             ", which is not supported; export it with metallic-roughness");
        }
        ++index;
    }
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
        if (extension == kSpecularGlossiness) {
            check_fallback(document, extension);
        } else if (!is_supported(extension)) {
            throw InputError("needs the extension " + in_quotes(extension) +
                             ", which is not supported; export it without");
        }
    }
}

void warn_about_left_out(const json &document, WarningList &warnings) {
    for (const json &used : member_or(document, "extensionsUsed", json::array())) {
        const auto extension = used.get<std::string>();
        if (!is_supported(extension)) {
            warnings.add("extension " + in_quotes(extension) + " is left out");
        }
    }
    if (const std::size_t count = member_or(document, "animations", json::array()).size();
        count > 0) {
        warnings.add(std::to_string(count) +
                     " animation(s) are not played: the scene stands still");
    }
}

} // namespace springdrive::scene::gltf
