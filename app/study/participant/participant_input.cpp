#include "app/study/participant/participant_input.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <functional>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

struct NamedKey {
    int key;
    std::string_view name;
};

/// By what is printed on them, whatever the keyboard's layout: also digits, which some layouts have
/// only with the shift key. Both keys of a pair have one name, as have number pad and others.
constexpr std::array kNamedKeys{
    NamedKey{GLFW_KEY_LEFT, "left"},
    NamedKey{GLFW_KEY_RIGHT, "right"},
    NamedKey{GLFW_KEY_UP, "up"},
    NamedKey{GLFW_KEY_DOWN, "down"},
    NamedKey{GLFW_KEY_ENTER, "enter"},
    NamedKey{GLFW_KEY_KP_ENTER, "enter"},
    NamedKey{GLFW_KEY_BACKSPACE, "backspace"},
    NamedKey{GLFW_KEY_TAB, "tab"},
    NamedKey{GLFW_KEY_INSERT, "insert"},
    NamedKey{GLFW_KEY_DELETE, "delete"},
    NamedKey{GLFW_KEY_HOME, "home"},
    NamedKey{GLFW_KEY_END, "end"},
    NamedKey{GLFW_KEY_PAGE_UP, "page_up"},
    NamedKey{GLFW_KEY_PAGE_DOWN, "page_down"},
    NamedKey{GLFW_KEY_ESCAPE, "escape"},
    NamedKey{GLFW_KEY_MENU, "menu"},
    NamedKey{GLFW_KEY_PRINT_SCREEN, "print"},
    NamedKey{GLFW_KEY_LEFT_SHIFT, "shift"},
    NamedKey{GLFW_KEY_RIGHT_SHIFT, "shift"},
    NamedKey{GLFW_KEY_LEFT_CONTROL, "ctrl"},
    NamedKey{GLFW_KEY_RIGHT_CONTROL, "ctrl"},
    NamedKey{GLFW_KEY_LEFT_ALT, "alt"},
    NamedKey{GLFW_KEY_RIGHT_ALT, "alt"},
    NamedKey{GLFW_KEY_LEFT_SUPER, "super"},
    NamedKey{GLFW_KEY_RIGHT_SUPER, "super"},
};

constexpr int kFirstFunctionKey = 1;
constexpr int kLastFunctionKey = 11; ///< F12 stops the device

constexpr std::array kPadKeys{
    NamedKey{GLFW_KEY_KP_DECIMAL, "."},  NamedKey{GLFW_KEY_KP_DIVIDE, "/"},
    NamedKey{GLFW_KEY_KP_MULTIPLY, "*"}, NamedKey{GLFW_KEY_KP_SUBTRACT, "-"},
    NamedKey{GLFW_KEY_KP_ADD, "+"},      NamedKey{GLFW_KEY_KP_EQUAL, "="},
};

/// Empty if it is none of them.
template <typename Keys> std::string_view name_in(const Keys &keys, int key) {
    const auto found = std::ranges::find(keys, key, &NamedKey::key);
    return found == keys.end() ? std::string_view() : found->name;
}

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
    const std::string plain = input_name(name);
    for (int number = kFirstFunctionKey; number <= kLastFunctionKey; ++number) {
        if (plain == "f" + std::to_string(number)) {
            return true;
        }
    }
    if (std::ranges::find(kNamedKeys, plain, &NamedKey::name) != kNamedKeys.end()) {
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

std::string name_of_silent_key(int key) {
    const int number = key - GLFW_KEY_F1 + 1;
    if (number >= kFirstFunctionKey && number <= kLastFunctionKey) {
        return "f" + std::to_string(number);
    }
    return std::string(name_in(kNamedKeys, key));
}

std::string name_of_letter_key(int key, int scancode) {
    for (const int zero : {GLFW_KEY_0, GLFW_KEY_KP_0}) {
        if (key >= zero && key <= zero + 9) {
            return std::to_string(key - zero);
        }
    }
    if (const std::string_view pad = name_in(kPadKeys, key); !pad.empty()) {
        return std::string(pad);
    }
    // By the keyboard's layout: GLFW's own codes are those of a US keyboard.
    const char *const name = glfwGetKeyName(key, scancode);
    return name != nullptr ? input_name(name) : std::string();
}

} // namespace springdrive::app::study_screen
