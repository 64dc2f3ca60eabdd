#include "engine/scene/gltf_named_files.h"

#include "engine/scene/gltf_file.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

namespace {

constexpr std::size_t kDeepestNaming = 100; ///< levels of brackets

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

/// "a%20b" as "a b".
std::string percent_decoded(std::string_view uri) {
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned char value = 0;
        const bool is_coded =
            uri[i] == '%' && i + 2 < uri.size() &&
            std::from_chars(uri.data() + i + 1, uri.data() + i + 3, value, 16).ptr ==
                uri.data() + i + 3;
        text += is_coded ? static_cast<char>(value) : uri[i];
        i += is_coded ? 2 : 0;
    }
    return text;
}

} // namespace

std::vector<std::filesystem::path> files_named_in(const std::filesystem::path &scene) noexcept {
    std::vector<std::filesystem::path> files;
    try {
        const Bytes bytes = read_bytes(scene);
        const std::string_view text = naming_text(bytes);
        if (json_nesting_depth(text) > kDeepestNaming) {
            return {}; // refused when it is loaded
        }
        const auto document = nlohmann::json::parse(text.begin(), text.end(), nullptr, false);
        for (const char *list : {"buffers", "images"}) {
            if (!document.is_object() || !document.contains(list)) {
                continue;
            }
            for (const nlohmann::json &member : document[list]) {
                if (!member.is_object() || !member.contains("uri") || !member["uri"].is_string()) {
                    continue;
                }
                const std::string uri = member["uri"].get<std::string>();
                if (!uri.starts_with("data:")) {
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
