#include "engine/scene/gltf_file.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "base/wanted.h"
#include "engine/scene/gltf_accessor.h"

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace springdrive::scene::gltf {

namespace {

constexpr std::uintmax_t kMaxFile_bytes = 2'000'000'000; // tinygltf counts in 32 bits
constexpr std::size_t kDeepestJson = 100;                // glTF itself needs about ten
constexpr std::size_t kGlbHeader_bytes = 12;
constexpr std::size_t kChunkHeader_bytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A; // "JSON"

std::uint32_t read_uint32(std::span<const unsigned char> bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes[offset], sizeof value);
    return value;
}

void append_uint32(Bytes &bytes, std::size_t value) {
    const auto narrow = static_cast<std::uint32_t>(value);
    std::array<unsigned char, sizeof narrow> raw{};
    std::memcpy(raw.data(), &narrow, sizeof narrow);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
}

bool is_glb(std::span<const unsigned char> bytes) {
    return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

/// Checks the container as far as tinygltf does not.
/// @return the JSON text within
std::string_view check_glb(std::span<const unsigned char> bytes) {
    if (bytes.size() < kGlbHeader_bytes + kChunkHeader_bytes) {
        throw InputError("is truncated: " + std::to_string(bytes.size()) +
                         " bytes hold no .glb; export it again");
    }
    if (const std::uint32_t version = read_uint32(bytes, 4); version != 2) {
        throw InputError("is .glb version " + std::to_string(version) + "; only 2 is known");
    }
    const std::size_t length = read_uint32(bytes, 8);
    if (length > bytes.size()) {
        throw InputError("is truncated: its header promises " + std::to_string(length) +
                         " bytes, the file has " + std::to_string(bytes.size()) +
                         "; copy or export it again");
    }
    for (std::size_t at = kGlbHeader_bytes; at < length;) {
        if (length - at < kChunkHeader_bytes ||
            length - at - kChunkHeader_bytes < read_uint32(bytes, at)) {
            throw InputError("is damaged: the .glb chunk at byte " + std::to_string(at) +
                             " reaches beyond the file; export it again");
        }
        at += kChunkHeader_bytes + read_uint32(bytes, at);
    }
    if (length <= kGlbHeader_bytes || read_uint32(bytes, kGlbHeader_bytes + 4) != kJsonChunk) {
        throw InputError("is damaged: its first .glb chunk is no JSON; export it again");
    }
    const std::size_t json_length = read_uint32(bytes, kGlbHeader_bytes);
    return {reinterpret_cast<const char *>(&bytes[kGlbHeader_bytes]) + kChunkHeader_bytes,
            json_length};
}

std::string_view check_text(std::span<const unsigned char> bytes) {
    std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    const std::size_t start = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
    const std::size_t first = text.find_first_not_of(" \t\r\n", start);
    if (first == std::string_view::npos || text[first] != '{') {
        throw InputError("is neither .gltf nor .glb: it starts with neither '{' nor 'glTF'");
    }
    return text;
}

/// The same file with its JSON replaced.
Bytes with_json(std::span<const unsigned char> bytes, std::string json) {
    if (!is_glb(bytes)) {
        return {json.begin(), json.end()};
    }
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t length = read_uint32(bytes, 8);
    const std::size_t rest =
        kGlbHeader_bytes + kChunkHeader_bytes + read_uint32(bytes, kGlbHeader_bytes);
    Bytes result(bytes.begin(), bytes.begin() + 8);
    append_uint32(result, kGlbHeader_bytes + kChunkHeader_bytes + json.size() + (length - rest));
    append_uint32(result, json.size());
    append_uint32(result, kJsonChunk);
    result.insert(result.end(), json.begin(), json.end());
    result.insert(result.end(), bytes.begin() + static_cast<std::ptrdiff_t>(rest),
                  bytes.begin() + static_cast<std::ptrdiff_t>(length));
    return result;
}

bool is_supported(std::string_view extension) {
    constexpr std::array<std::string_view, 5> kSupported = {
        kDracoExtension, "KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual",
        "KHR_xmp_json_ld"};
    return std::ranges::find(kSupported, extension) != kSupported.end() ||
           extension.starts_with("KHR_materials_");
}

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
           primitive["extensions"].is_object() && primitive["extensions"].contains(kDracoExtension);
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

std::string adapted_to_tinygltf(std::string_view text) {
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

Bytes read_bytes(const std::filesystem::path &file) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) {
        throw InputError("there is no such file; check the name");
    }
    if (std::filesystem::is_directory(status)) {
        throw InputError("is a folder; name a .gltf or .glb file");
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw InputError("is no ordinary file; name a .gltf or .glb file");
    }
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error || size > kMaxFile_bytes) {
        throw InputError("is larger than 2 GB; split or simplify it");
    }
    Bytes bytes(size);
    std::ifstream stream(file, std::ios::binary);
    constexpr std::size_t kBlock = std::size_t{16} << 20U;
    for (std::size_t at = 0; stream && at < bytes.size(); at += kBlock) {
        stop_if_given_up();
        stream.read(reinterpret_cast<char *>(&bytes[at]),
                    static_cast<std::streamsize>(std::min(kBlock, bytes.size() - at)));
    }
    if (!stream) {
        throw InputError("cannot be read; check its permissions");
    }
    if (bytes.empty()) {
        throw InputError("is empty; export it again");
    }
    return bytes;
}

tinygltf::Model read_model(const std::filesystem::path &file) {
    Bytes bytes = read_bytes(file);
    const std::string_view text = is_glb(bytes) ? check_glb(bytes) : check_text(bytes);
    if (json_nesting_depth(text) > kDeepestJson) {
        throw InputError("nests its JSON deeper than " + std::to_string(kDeepestJson) +
                         " levels; no glTF does");
    }
    check_byte_offsets(text);
    if (text.find(kDracoExtension) != std::string_view::npos ||
        text.find("\"skins\"") != std::string_view::npos) {
        bytes = with_json(bytes, adapted_to_tinygltf(text));
    }
    tinygltf::Model model =
        parse(bytes, is_glb(bytes), std::filesystem::absolute(file).parent_path());
    if (!model.asset.version.starts_with("2.")) {
        throw InputError("is glTF version " + in_quotes(model.asset.version) +
                         "; export it as glTF 2.0");
    }
    for (const std::string &extension : model.extensionsRequired) {
        if (!is_supported(extension)) {
            throw InputError("needs the extension " + in_quotes(extension) +
                             ", which is not supported; export it without");
        }
    }
    return model;
}

std::vector<std::string> left_out_of(const tinygltf::Model &model) {
    std::vector<std::string> remarks;
    for (const std::string &extension : model.extensionsUsed) {
        if (!is_supported(extension)) {
            remarks.push_back("extension " + in_quotes(extension) + " is left out");
        }
    }
    if (!model.animations.empty()) {
        remarks.push_back(std::to_string(model.animations.size()) +
                          " animation(s) are not played: the scene stands still");
    }
    return remarks;
}

} // namespace springdrive::scene::gltf
