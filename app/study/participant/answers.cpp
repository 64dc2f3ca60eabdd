#include "app/study/participant/answers.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

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

std::span<const Gesture> gestures() { return kGestures; }

std::string validate_answers(const study::ResponseWays &ways) {
    struct Names {
        bool (*has)(std::string_view);
        const char *what;
    };
    const Names names =
        ways.device == study::ResponseDevice::keyboard
            ? Names{is_key_name, "a key is a letter, a digit or one of left, right, up, down, "
                                 "enter, f1 and so on"}
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
    const InputSource wanted =
        ways.device == study::ResponseDevice::mouse ? InputSource::mouse_button : InputSource::key;
    const bool is_meant = ways.device != study::ResponseDevice::gesture && input.source == wanted;
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
