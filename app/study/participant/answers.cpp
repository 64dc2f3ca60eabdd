#include "app/study/participant/answers.h"

#include "base/text.h"

#include <GLFW/glfw3.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <clocale>
#include <cwctype>
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

/// Whether some keyboard may have such a character beyond ASCII on a key by itself: a letter as it
/// is without the shift key, of a script that is typed letter by letter.
/// @param character  one, in UTF-8
bool is_typed(std::string_view character) {
    static const locale_t kUnicode = newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
    unsigned code = static_cast<unsigned char>(character.front()) & (0x7fU >> character.size());
    for (const char byte : character.substr(1)) {
        code = code << 6U | (static_cast<unsigned char>(byte) & 0x3fU);
    }
    constexpr unsigned kFirstIdeograph = 0x3400; // typed by a choice, as those beyond
    const bool is_letter =
        kUnicode == nullptr || (iswalpha_l(code, kUnicode) != 0 && iswupper_l(code, kUnicode) == 0);
    return (is_letter && code < kFirstIdeograph) || character == "²" || character == "§" ||
           character == "½";
}

constexpr std::size_t kMaxKeys = 9; ///< of a question's choices: digits from 1

const std::array<Gesture, 6> kGestures{{
    {"left", -Vector3::UnitX()},
    {"right", Vector3::UnitX()},
    {"up", Vector3::UnitY()},
    {"down", -Vector3::UnitY()},
    {"towards", Vector3::UnitZ()}, // the user
    {"away", -Vector3::UnitZ()},
}};

bool is_gesture_name(std::string_view name) {
    return std::ranges::count(kGestures, name, &Gesture::name) > 0;
}

std::optional<std::size_t> index_of(const study::ResponseWays &ways, std::string_view name) {
    const auto found = std::ranges::find_if(
        ways.keys, [name](const std::string &key) { return input_name(key) == name; });
    return found == ways.keys.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(found - ways.keys.begin()));
}

/// Then the plates are the other way round: each on its own side.
bool is_right_before_left(const study::ResponseWays &ways) {
    return ways.keys.size() == 2 && input_name(ways.keys[0]) == "right" &&
           input_name(ways.keys[1]) == "left";
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
    if (name.size() == 1) {
        return name.front() > ' ' && name.front() < '\x7f';
    }
    return is_utf8(name) && !name.empty() && !continues(name.front()) &&
           std::ranges::count_if(name.substr(1), std::not_fn(continues)) == 0 && is_typed(name);
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

std::span<const Gesture> gestures() { return kGestures; }

std::string validate_answers(const study::ResponseWays &ways) {
    struct Names {
        bool (*has)(std::string_view);
        const char *what;
    };
    const Names names =
        ways.device == study::ResponseDevice::keyboard
            ? Names{is_key_name, "a key is what it types by itself, without shift or AltGr: a "
                                 "letter or a digit; or one of left, right, up, down, enter, f1 "
                                 "and so on"}
        : ways.device == study::ResponseDevice::mouse
            ? Names{is_mouse_button_name, "a mouse button is left, right, middle, back or forward"}
            : Names{is_gesture_name, "a gesture is left, right, up, down, towards or away"};
    const auto wrong = std::ranges::find_if(
        ways.keys, [&](const std::string &key) { return !names.has(input_name(key)); });
    return wrong == ways.keys.end()
               ? std::string()
               : fmt::format("responses.keys has \"{}\"; {}", *wrong, names.what);
}

std::optional<std::size_t> alternative_of(const study::ResponseWays &ways,
                                          const ParticipantInput &input) {
    if (!input.is_press) {
        return std::nullopt;
    }
    if (input.source == InputSource::choice) {
        if (input.choice >= ways.keys.size()) {
            return std::nullopt;
        }
        return is_right_before_left(ways) ? 1 - input.choice : input.choice;
    }
    const InputSource expected =
        ways.device == study::ResponseDevice::mouse ? InputSource::mouse_button : InputSource::key;
    const bool is_meant = ways.device != study::ResponseDevice::gesture && input.source == expected;
    return is_meant ? index_of(ways, input.name) : std::nullopt;
}

std::optional<std::size_t> alternative_of(const study::ResponseWays &ways, const Vector3 &moved_m) {
    if (ways.device != study::ResponseDevice::gesture) {
        return std::nullopt;
    }
    std::optional<std::size_t> furthest;
    double way_m = kGesture_m;
    for (const Gesture &gesture : kGestures) {
        const std::optional<std::size_t> key = index_of(ways, gesture.name);
        if (const double along_m = gesture.direction.dot(moved_m); key && along_m >= way_m) {
            furthest = key;
            way_m = along_m;
        }
    }
    return furthest;
}

study::Response response_of(const study::Task &task, std::size_t alternative) {
    if (task.kind == study::TaskKind::yes_no) {
        return study::YesNo{alternative == 1}; // "no" and "yes"
    }
    return study::Chosen{static_cast<int>(alternative) + 1};
}

std::vector<AnswerChoice> choices_of(const study::Protocol &protocol) {
    std::vector<AnswerChoice> choices;
    const bool is_mouse = protocol.responses.device == study::ResponseDevice::mouse;
    for (const std::string &key : protocol.responses.keys) {
        choices.push_back({{}, shown_key(key, is_mouse)});
    }
    const study::Texts &texts = protocol.texts;
    if (protocol.task.kind == study::TaskKind::yes_no) {
        choices[0].text = texts.answer_no;
        choices[1].text = texts.answer_yes;
    } else if (protocol.task.kind == study::TaskKind::forced_choice_by_interval &&
               choices.size() == 2) {
        choices[0].text = texts.first_interval;
        choices[1].text = texts.second_interval;
    }
    for (AnswerChoice &choice : choices) {
        if (choice.key == choice.text) {
            choice.text.clear(); // once is enough
        }
    }
    if (is_right_before_left(protocol.responses)) {
        std::swap(choices[0], choices[1]);
    }
    return choices;
}

ParticipantPicture instructions_of(const study::Protocol &protocol) {
    const study::Texts &texts = protocol.texts;
    ParticipantPicture picture;
    picture.text = texts.instructions;
    if (protocol.responses.device == study::ResponseDevice::gesture) {
        picture.text += '\n' + texts.gesture_help;
    }
    picture.text += '\n' + texts.ready;
    return picture;
}

std::vector<QuestionChoice> choices_of(const study::QuestionnaireItem &item,
                                       const study::Texts &texts) {
    std::vector<QuestionChoice> choices;
    const std::vector<std::string> possible = study::possible_answers(item);
    for (std::size_t i = 0; i < possible.size(); ++i) {
        const bool is_scale = item.kind == study::QuestionnaireKind::scale;
        const std::string number = is_scale ? possible[i] : fmt::format("{}", i + 1);
        const std::string label = !is_scale                  ? possible[i]
                                  : i == 0                   ? item.lowest_label
                                  : i + 1 == possible.size() ? item.highest_label
                                                             : std::string();
        const bool has_key = is_scale ? is_key_name(number) : possible.size() <= kMaxKeys;
        const bool shows_number = is_scale || has_key;
        choices.push_back(
            {{label, shows_number ? number : ""}, has_key ? number : "", possible[i]});
    }
    if (possible.empty()) {
        choices.push_back({{texts.next_question, shown_key("enter", false)}, "enter", ""});
    }
    choices.push_back({{texts.no_answer, ""}, "", std::nullopt});
    return choices;
}

const QuestionChoice *chosen_by(const std::vector<QuestionChoice> &choices,
                                const ParticipantInput &input) {
    if (!input.is_press) {
        return nullptr;
    }
    if (input.source == InputSource::choice) {
        return input.choice < choices.size() ? &choices[input.choice] : nullptr;
    }
    if (input.source != InputSource::key || input.name.empty()) {
        return nullptr;
    }
    const auto found = std::ranges::find(choices, input.name, &QuestionChoice::key);
    return found == choices.end() ? nullptr : &*found;
}

ParticipantPicture picture_of(const study::QuestionnaireItem &item, const study::Texts &texts) {
    ParticipantPicture picture;
    picture.heading = item.when == study::QuestionnaireTime::before ? texts.questionnaire_before
                                                                    : texts.questionnaire_after;
    picture.text = item.text;
    for (const QuestionChoice &choice : choices_of(item, texts)) {
        picture.choices.push_back(choice.card);
    }
    picture.choices_take_clicks = true;
    picture.has_text_field = item.kind == study::QuestionnaireKind::text;
    return picture;
}

} // namespace springdrive::app::study_screen
