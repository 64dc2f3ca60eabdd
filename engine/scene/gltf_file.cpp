#include "engine/scene/gltf_file.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"
#include "engine/scene/gltf_accessor.h"

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

using nlohmann::json;

constexpr std::size_t kMaxFile_bytes = 2'000'000'000;
constexpr std::size_t kGlbHeader_bytes = 12;
constexpr std::size_t kChunkHeader_bytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;   // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942; // "BIN"

std::uint32_t read_uint32(std::span<const unsigned char> bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes[offset], sizeof value);
    return value;
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

/// The bytes of the chunk after the JSON, in which a .glb keeps its first buffer.
/// @param bytes that `check_glb` accepts
std::span<const unsigned char> binary_chunk(std::span<const unsigned char> bytes) {
    const std::size_t length = read_uint32(bytes, 8);
    const std::size_t at =
        kGlbHeader_bytes + kChunkHeader_bytes + read_uint32(bytes, kGlbHeader_bytes);
    if (at >= length || read_uint32(bytes, at + 4) != kBinaryChunk) {
        return {};
    }
    return bytes.subspan(at + kChunkHeader_bytes, read_uint32(bytes, at));
}

bool is_draco_compressed(const json &primitive) {
    const auto extensions = primitive.find("extensions");
    return extensions != primitive.end() && extensions->is_object() &&
           extensions->contains(kDracoExtension);
}

/// The accessor of a primitive's triangles, as tinygltf refuses it.
struct IndicesWithoutView {
    std::size_t mesh;
    std::size_t primitive;
    int accessor;
};

bool has_view(const json &document, int accessor) {
    const auto accessors = document.find("accessors");
    const bool exists = accessor >= 0 && accessors != document.end() &&
                        static_cast<std::size_t>(accessor) < accessors->size();
    return exists && (*accessors)[static_cast<std::size_t>(accessor)].contains("bufferView");
}

/// Takes the indices out whose accessor has no buffer view: tinygltf refuses them, though they are
/// valid. Those of Draco-compressed primitives are not needed.
/// @return the others
std::vector<IndicesWithoutView> take_indices_without_view(json &document) {
    std::vector<IndicesWithoutView> taken;
    json none = json::array();
    json &meshes = document.contains("meshes") ? document["meshes"] : none;
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        json &primitives = meshes[m]["primitives"];
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            json &primitive = primitives[p];
            const int accessor = primitive.value("indices", -1);
            if (is_draco_compressed(primitive)) {
                primitive.erase("indices");
            } else if (accessor >= 0 && !has_view(document, accessor)) {
                taken.push_back({m, p, accessor});
                primitive.erase("indices");
            }
        }
    }
    return taken;
}

/// Takes an array out of the document, so that tinygltf does not see it.
json take_array(json &document, const char *name) {
    const auto found = document.find(name);
    if (found == document.end()) {
        return json::array();
    }
    json array = std::move(*found);
    document.erase(found);
    return array;
}

/// Takes out what is not needed, so that tinygltf refuses no animation that is valid in a later
/// extension.
void take_out_unneeded(json &document) {
    for (const char *name : {"animations", "cameras", "extensions"}) {
        document.erase(name);
    }
}

Bytes first_bytes(std::span<const unsigned char> bytes, std::size_t max_bytes) {
    const std::span first = bytes.first(std::min(max_bytes, bytes.size()));
    return {first.begin(), first.end()};
}

/// @param chunk of a .glb, for its first buffer if that has no URI
/// @param place for messages: "buffer 3"
Bytes read_buffer(const json &buffer, std::span<const unsigned char> chunk,
                  const std::filesystem::path &folder, const std::string &place,
                  WarningList &warnings) {
    const auto length = buffer["byteLength"].get<std::size_t>();
    const bool has_uri = buffer.contains("uri");
    if ((!has_uri && chunk.empty()) || length == 0) {
        return {}; // missed only if something refers to it
    }
    if (length > kMaxFile_bytes) {
        throw InputError(place + " is larger than 2 GB; split or simplify it");
    }
    const auto uri = buffer.value("uri", std::string());
    const std::string source =
        place + ": " + (has_uri ? name_of_uri(uri) : "the .glb's binary chunk") + " ";
    Bytes bytes;
    try {
        bytes = has_uri ? read_uri(uri, folder, length, &warnings) : first_bytes(chunk, length);
    } catch (const InputError &error) {
        throw InputError(source + error.what());
    }
    if (bytes.size() < length) {
        throw InputError(source + "has " + std::to_string(bytes.size()) +
                         " bytes, but its byteLength is " + std::to_string(length) +
                         "; copy or export it again");
    }
    return bytes;
}

std::vector<tinygltf::Image> images_of(const json &images) {
    std::vector<tinygltf::Image> result(images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
        const auto name = images[i].find("name");
        if (name != images[i].end() && name->is_string()) {
            result[i].name = name->get<std::string>();
        }
        result[i].uri = images[i].value("uri", "");
        result[i].bufferView = images[i].value("bufferView", -1);
    }
    return result;
}

} // namespace

Bytes read_bytes(const std::filesystem::path &file) {
    return read_first_bytes(file, std::numeric_limits<std::size_t>::max());
}

Bytes read_first_bytes(const std::filesystem::path &file, std::size_t max_bytes) {
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
    const std::uintmax_t size =
        std::min<std::uintmax_t>(std::filesystem::file_size(file, error), max_bytes);
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

std::filesystem::path folder_of(const std::filesystem::path &file) {
    return std::filesystem::absolute(file).parent_path();
}

tinygltf::Model read_model(const std::filesystem::path &file, WarningList &warnings) {
    const Bytes bytes = read_bytes(file);
    const bool is_binary = is_glb(bytes);
    json document = parse_json(is_binary ? check_glb(bytes) : check_text(bytes));
    check_members(document);
    check_versions_and_extensions(document);
    warn_about_left_out(document, warnings);
    const json buffers = take_array(document, "buffers"); // may be most of the file
    const json images = take_array(document, "images");
    const json skins = take_array(document, "skins"); // refused without inverseBindMatrices
    take_out_unneeded(document);
    const std::vector<IndicesWithoutView> taken = take_indices_without_view(document);
    tinygltf::Model model = parse(std::exchange(document, {}).dump());
    for (const IndicesWithoutView &indices : taken) {
        model.meshes[indices.mesh].primitives[indices.primitive].indices = indices.accessor;
    }
    model.images = images_of(images);
    for (const json &skin : skins) {
        model.skins.emplace_back();
        model.skins.back().joints = skin["joints"].get<std::vector<int>>();
        model.skins.back().inverseBindMatrices = skin.value("inverseBindMatrices", -1);
    }
    std::span<const unsigned char> chunk;
    if (is_binary) {
        chunk = binary_chunk(bytes);
    }
    for (const json &buffer : buffers) {
        const std::string place = "buffer " + std::to_string(model.buffers.size());
        model.buffers.emplace_back();
        model.buffers.back().data =
            read_buffer(buffer, std::exchange(chunk, {}), folder_of(file), place, warnings);
    }
    decode_meshopt_views(model);
    return model;
}

std::vector<std::filesystem::path> files_named_in(const std::filesystem::path &scene) noexcept {
    std::vector<std::filesystem::path> files;
    try {
        const Bytes bytes = read_bytes(scene);
        const json document = parse_json(is_glb(bytes) ? check_glb(bytes) : check_text(bytes));
        for (const char *list : {"buffers", "images"}) {
            for (const json &member : document.value(list, json::array())) {
                if (!member.is_object() || !member.contains("uri") || !member["uri"].is_string()) {
                    continue;
                }
                const std::string uri = member["uri"].get<std::string>();
                if (!is_data_uri(uri)) {
                    files.push_back(scene.parent_path() / uri);
                    files.push_back(scene.parent_path() / percent_decoded(uri));
                    (void)error_text_of([&] { files.push_back(file_of(uri, folder_of(scene))); });
                }
            }
        }
    } catch (const std::exception &) {
        return files; // loading it will say what is wrong
    }
    return files;
}

namespace {

constexpr std::string_view kData = "data:";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lowered(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool ends_with_any_case(std::string_view text, std::string_view end) {
    return text.size() >= end.size() &&
           std::ranges::equal(text.substr(text.size() - end.size()), end, {}, lowered, lowered);
}

/// "http" of "http://…", "C" of "C:\…"; empty for a relative reference.
std::string_view scheme_of(std::string_view uri) {
    const std::size_t end = uri.find_first_of(":/?#");
    if (end == std::string_view::npos || uri[end] != ':' || end == 0 || !is_letter(uri[0])) {
        return {};
    }
    const std::string_view scheme = uri.substr(0, end);
    const bool is_scheme = std::ranges::all_of(scheme, [](char c) {
        return is_letter(c) || is_digit(c) || c == '+' || c == '-' || c == '.';
    });
    return is_scheme ? scheme : std::string_view{};
}

std::optional<unsigned> hexadecimal_digit(char c) {
    if (is_digit(c)) {
        return static_cast<unsigned>(c - '0');
    }
    const char low = lowered(c);
    return low >= 'a' && low <= 'f' ? std::optional(static_cast<unsigned>(low - 'a') + 10U)
                                    : std::nullopt;
}

/// The value of each base64 digit, −1 for other bytes.
std::array<int, 256> base64_values() {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<int, 256> values{};
    values.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i) {
        values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    }
    return values;
}

Bytes decode_base64(std::string_view text) {
    static const std::array<int, 256> kValues = base64_values();
    while (text.ends_with('=')) {
        text.remove_suffix(1);
    }
    Bytes bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t held = 0;
    unsigned held_bits = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        stop_if_given_up(i);
        const int value = kValues[static_cast<unsigned char>(text[i])];
        if (value < 0) {
            throw InputError("is damaged: character " + std::to_string(i + 1) +
                             " of its data is no base64 digit; export it again");
        }
        held = held << 6U | static_cast<std::uint32_t>(value);
        held_bits += 6;
        if (held_bits >= 8) {
            held_bits -= 8;
            bytes.push_back(static_cast<unsigned char>(held >> held_bits & 0xffU));
        }
    }
    return bytes;
}

} // namespace

bool is_data_uri(std::string_view uri) {
    return ends_with_any_case(uri.substr(0, kData.size()), kData);
}

std::string percent_decoded(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size()) {
            const std::optional<unsigned> high = hexadecimal_digit(text[i + 1]);
            const std::optional<unsigned> low = hexadecimal_digit(text[i + 2]);
            if (high && low) {
                bytes += static_cast<char>(16 * *high + *low);
                i += 2;
                continue;
            }
        }
        bytes += text[i];
    }
    return bytes;
}

Bytes decode_data_uri(std::string_view uri) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) {
        throw InputError("is damaged: it has no comma; export it again");
    }
    const std::string data = percent_decoded(uri.substr(comma + 1));
    if (ends_with_any_case(uri.substr(0, comma), ";base64")) {
        return decode_base64(data);
    }
    return {data.begin(), data.end()};
}

namespace {

using Path = std::filesystem::path;

/// Adds the files that the names from `name` to `end` lead to, beginning at `at` in `folder`, where
/// each may stand for one that is `alike`. Of what lies outside the folder nothing is listed.
template <typename Alike>
void find_alike(const Path &folder, const Path &at, Path::iterator name, Path::iterator end,
                Alike &&alike, std::set<Path> &found) {
    if (name == end) {
        found.insert(at);
        return;
    }
    std::error_code none;
    for (const auto &entry : std::filesystem::directory_iterator(folder / at, none)) {
        stop_if_given_up();
        const Path next = at / entry.path().filename();
        if (alike(name->native(), next.filename().native()) &&
            error_text_of([&] { (void)contained_file(next.native(), folder, "scene"); }).empty()) {
            find_alike(folder, next, std::next(name), end, alike, found);
        }
    }
}

/// What either spelling leads to, where each name may stand for one that is `alike`.
template <typename Alike>
std::set<Path> all_alike(const Path &folder, const std::array<Path, 2> &spellings, Alike &&alike) {
    std::set<Path> found;
    for (const Path &spelling : spellings) {
        find_alike(folder, {}, spelling.begin(), spelling.end(), alike, found);
    }
    return found;
}

std::string names_of(const std::set<Path> &files) {
    std::string names;
    for (const Path &file : files) {
        names += (names.empty() ? "" : " and ") + in_quotes(file.native());
    }
    return one_line(names, 200);
}

/// Code points, those of Hangul syllables in parts.
std::u32string in_parts(std::string_view text) {
    std::u32string parts;
    for (const char32_t c : Path(text).u32string()) {
        constexpr char32_t kFirst = 0xac00;
        if (c < kFirst || c > 0xd7a3) {
            parts += c;
            continue;
        }
        const char32_t syllable = c - kFirst; // of 19 · 21 · 28
        parts += {0x1100 + syllable / 588, 0x1161 + syllable % 588 / 28};
        if (syllable % 28 != 0) {
            parts += 0x11a7 + syllable % 28;
        }
    }
    return parts;
}

/// An accent, or a voicing mark of kana.
bool is_mark(char32_t c) { return (c >= 0x300 && c <= 0x36f) || c == 0x3099 || c == 0x309a; }

/// Takes a composed letter off `one`, and a letter with its marks off `other`.
bool take_composed(std::u32string_view &one, std::u32string_view &other) {
    if (one[0] < 0x80 || is_mark(one[0]) || other.size() < 2 || !is_mark(other[1])) {
        return false;
    }
    one.remove_prefix(1);
    const auto end = std::find_if_not(other.begin() + 1, other.end(), is_mark);
    other.remove_prefix(static_cast<std::size_t>(end - other.begin()));
    return true;
}

} // namespace

bool may_be_composed_otherwise(std::string_view a, std::string_view b) {
    if (!is_utf8(a) || !is_utf8(b)) {
        return false;
    }
    const std::u32string parts_a = in_parts(a);
    const std::u32string parts_b = in_parts(b);
    std::u32string_view left = parts_a;
    std::u32string_view right = parts_b;
    while (!left.empty() && !right.empty()) {
        if (left[0] == right[0]) {
            left.remove_prefix(1);
            right.remove_prefix(1);
        } else if (!take_composed(left, right) && !take_composed(right, left)) {
            return false;
        }
    }
    return left.empty() && right.empty();
}

std::filesystem::path file_of(std::string_view uri, const std::filesystem::path &folder) {
    if (!scheme_of(uri).empty()) {
        throw InputError("is not relative to the scene's file and is not read; put the file into "
                         "the scene's folder");
    }
    const std::string path = percent_decoded(uri);
    const Path file = contained_file(path, folder, "scene");
    if (std::error_code ignored; std::filesystem::exists(file, ignored)) {
        return file;
    }
    std::array<Path, 2> spellings{path, uri};
    for (Path &spelling : spellings) {
        std::string text = spelling.native();
        std::ranges::replace(text, '\\', '/');
        static_cast<void>(contained_file(text, folder, "scene"));
        spelling = Path(text).lexically_normal();
    }
    const std::set<Path> found =
        all_alike(folder, spellings, [](std::string_view a, std::string_view b) {
            return std::ranges::equal(a, b, {}, lowered, lowered);
        });
    if (found.size() == 1) {
        return contained_file(found.begin()->native(), folder, "scene");
    }
    if (!found.empty()) {
        throw InputError("cannot be read: there is no such file, and it may mean " +
                         names_of(found) + "; rename the right one");
    }
    if (const std::set<Path> composed = all_alike(folder, spellings, may_be_composed_otherwise);
        !composed.empty()) {
        throw InputError(
            "cannot be read: there is no such file, but " + names_of(composed) +
            ", whose letters and accents are encoded otherwise (NFC or NFD); rename it");
    }
    return file;
}

Bytes read_uri(std::string_view uri, const std::filesystem::path &folder, std::size_t max_bytes,
               WarningList *warnings) {
    if (is_data_uri(uri)) {
        Bytes bytes = decode_data_uri(uri);
        bytes.resize(std::min(bytes.size(), max_bytes));
        return bytes;
    }
    const std::filesystem::path file = file_of(uri, folder);
    std::error_code error;
    if (warnings != nullptr && file != contained_file(percent_decoded(uri), folder, "scene")) {
        warnings->add(name_of_uri(uri) + " is read from " +
                      in_quotes(std::filesystem::relative(file, folder, error).native()));
    }
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    if (!std::filesystem::exists(status)) {
        throw InputError("cannot be read: there is no such file");
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw InputError("cannot be read: it is no ordinary file");
    }
    return read_first_bytes(file, max_bytes);
}

std::string name_of_uri(std::string_view uri) {
    return is_data_uri(uri) ? "its data: URI" : in_quotes(percent_decoded(uri));
}

} // namespace springdrive::scene::gltf
