#include "engine/scene/gltf_uri.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace springdrive::scene::gltf {

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

std::filesystem::path file_of(std::string_view uri, const std::filesystem::path &folder) {
    const std::string path = percent_decoded(uri);
    if (!scheme_of(uri).empty()) {
        throw InputError("is not relative to the scene's file and is not read; put the file into "
                         "the scene's folder");
    }
    return contained_file(path, folder, "scene");
}

Bytes read_uri(std::string_view uri, const std::filesystem::path &folder, std::size_t max_bytes) {
    if (is_data_uri(uri)) {
        Bytes bytes = decode_data_uri(uri);
        bytes.resize(std::min(bytes.size(), max_bytes));
        return bytes;
    }
    const std::filesystem::path file = file_of(uri, folder);
    std::error_code error;
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
