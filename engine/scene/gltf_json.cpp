#include "engine/scene/gltf_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace springdrive::gltf {

std::size_t json_nesting_depth(std::string_view json) {
    std::size_t depth = 0;
    std::size_t deepest = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
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

namespace {

using nlohmann::json;

/// The member if it is an array, else an empty one.
json &array_member(json &object, const char *name) {
    static json nothing = json::array();
    if (!object.is_object() || !object.contains(name) || !object[name].is_array()) {
        return nothing;
    }
    return object[name];
}

bool is_draco_compressed(const json &primitive) {
    return primitive.is_object() && primitive.contains("extensions") &&
           primitive["extensions"].is_object() &&
           primitive["extensions"].contains("KHR_draco_mesh_compression");
}

} // namespace

std::string without_what_tinygltf_refuses(std::string_view text) {
    json document = json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
    if (!document.is_object()) {
        return std::string(text);
    }
    document.erase("skins");
    for (json &mesh : array_member(document, "meshes")) {
        for (json &primitive : array_member(mesh, "primitives")) {
            if (is_draco_compressed(primitive)) {
                primitive.erase("indices");
            }
        }
    }
    return document.dump();
}

} // namespace springdrive::gltf
