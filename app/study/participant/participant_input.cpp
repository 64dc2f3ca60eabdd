#include "app/study/participant/participant_input.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

/// Of keys with a sign that is known in every language.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSigns{{
    {"left", "←"},
    {"right", "→"},
    {"up", "↑"},
    {"down", "↓"},
    {"enter", "↵"},
    {"page_up", "Page ↑"},
    {"page_down", "Page ↓"},
}};

char lower(char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

char upper(char letter) {
    return letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
}

/// Whether a byte of UTF-8 is not the first one of its sequence.
bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

void take_off_last_code_point(std::string &text) {
    while (!text.empty()) {
        const char byte = text.back();
        text.pop_back();
        if (!continues(byte)) {
            return;
        }
    }
}

} // namespace

std::string input_name(std::string_view name) {
    std::string result(name);
    std::ranges::transform(result, result.begin(), lower);
    return result;
}

bool is_key_name(std::string_view name) {
    if (std::ranges::find(kKeyNames, input_name(name)) != kKeyNames.end()) {
        return true;
    }
    return !name.empty() && !continues(name.front()) &&
           std::ranges::count_if(name.substr(1), std::not_fn(continues)) == 0 &&
           static_cast<unsigned char>(name.front()) > ' ' && name != "\u007F" && name != "\u00A0";
}

bool is_mouse_button_name(std::string_view name) {
    return std::ranges::find(kMouseButtonNames, input_name(name)) != kMouseButtonNames.end();
}

std::string shown_key(std::string_view name, bool is_mouse) {
    std::string plain = input_name(name);
    if (is_mouse) {
        return plain;
    }
    const auto sign = std::ranges::find(kSigns, plain, &decltype(kSigns)::value_type::first);
    if (sign != kSigns.end()) {
        return std::string(sign->second);
    }
    const bool is_function_key = plain.size() > 1 && plain[0] == 'f' && plain[1] <= '9';
    if (plain.size() == 1 || is_function_key) {
        std::ranges::transform(plain, plain.begin(), upper);
    }
    return plain;
}

std::string typed_on(std::string text, std::span<const ParticipantInput> inputs,
                     std::size_t max_bytes) {
    for (const ParticipantInput &input : inputs) {
        if (input.source == InputSource::letter && text.size() + input.name.size() <= max_bytes) {
            text += input.name;
        } else if (input.source == InputSource::key && input.is_press &&
                   input.name == "backspace") {
            take_off_last_code_point(text);
        }
    }
    return text;
}

} // namespace springdrive::app::study_screen
