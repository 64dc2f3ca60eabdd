#include "app/study/sitting/questions.h"

#include <fmt/core.h>

#include <algorithm>

namespace springdrive::app::study_screen {

namespace {

constexpr std::size_t kMaxKeys = 9; ///< digits from 1

} // namespace

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
