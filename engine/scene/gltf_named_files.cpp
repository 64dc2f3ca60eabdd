#include "engine/scene/gltf_named_files.h"

#include "engine/scene/gltf_file.h"
#include "engine/scene/gltf_json.h"
#include "engine/scene/gltf_uri.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

/// The JSON, in a file of its own or as the first chunk of a .glb.
std::string_view naming_text(const Bytes &bytes) {
    const std::string_view all(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    constexpr std::size_t kBeforeChunk = 20;
    if (!all.starts_with("glTF") || all.size() < kBeforeChunk) {
        return all;
    }
    std::uint32_t length = 0;
    std::memcpy(&length, all.data() + 12, sizeof length);
    return all.substr(kBeforeChunk, length);
}

} // namespace

std::vector<std::filesystem::path> files_named_in(const std::filesystem::path &scene) noexcept {
    std::vector<std::filesystem::path> files;
    try {
        const Bytes bytes = read_bytes(scene);
        const nlohmann::json document = parse_json(naming_text(bytes));
        for (const char *list : {"buffers", "images"}) {
            if (!document.contains(list)) {
                continue;
            }
            for (const nlohmann::json &member : document[list]) {
                if (!member.is_object() || !member.contains("uri") || !member["uri"].is_string()) {
                    continue;
                }
                const std::string uri = member["uri"].get<std::string>();
                if (!is_data_uri(uri)) {
                    files.push_back(scene.parent_path() / uri);
                    files.push_back(scene.parent_path() / percent_decoded(uri));
                }
            }
        }
    } catch (const std::exception &) {
        return files; // loading it will say what is wrong
    }
    return files;
}

} // namespace springdrive::scene::gltf
