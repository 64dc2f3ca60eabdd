#include "engine/scene/gltf_json.h"

#include "base/input_error.h"
#include "engine/scene/gltf_text.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace springdrive::scene::gltf {

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

json parse_or_nothing(std::string_view text) {
    return json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
}

void check_whole(const json &object, const char *key, const std::string &owner) {
    if (object.is_object() && object.contains(key) && !object[key].is_number_unsigned()) {
        throw InputError(owner + ": its " + key + " is " + one_line(object[key].dump(), 40) +
                         "; it must be a whole number from 0");
    }
}

} // namespace

void check_byte_offsets(std::string_view text) {
    json document = parse_or_nothing(text);
    std::size_t index = 0;
    for (const json &view : array_member(document, "bufferViews")) {
        const std::string owner = "buffer view " + std::to_string(index++);
        check_whole(view, "byteOffset", owner);
        check_whole(view, "byteStride", owner);
    }
    index = 0;
    for (const json &accessor : array_member(document, "accessors")) {
        const std::string owner = "accessor " + std::to_string(index++);
        check_whole(accessor, "byteOffset", owner);
        const json sparse = accessor.is_object() ? accessor.value("sparse", json()) : json();
        for (const char *part : {"indices", "values"}) {
            if (sparse.is_object() && sparse.contains(part)) {
                check_whole(sparse[part], "byteOffset", owner + ": sparse " + part);
            }
        }
    }
}

std::string without_what_tinygltf_refuses(std::string_view text) {
    json document = parse_or_nothing(text);
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

} // namespace springdrive::scene::gltf
