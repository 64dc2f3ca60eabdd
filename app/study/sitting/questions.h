// What a participant sees of a protocol's own instructions and questions, and which answer an input
// gives.
#pragma once

#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_picture.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/texts.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

/// Before the first trial, until a key is pressed.
[[nodiscard]] ParticipantPicture instructions_of(const study::Protocol &protocol);

/// A way to answer a question: its plate, and what it stands for.
struct QuestionChoice {
    AnswerChoice card;
    std::string key;                   ///< as inputs name it; empty: by a click only
    std::optional<std::string> answer; ///< nothing: none is given; of a free text: what is typed
};

/// The last is to leave it out.
[[nodiscard]] std::vector<QuestionChoice> choices_of(const study::QuestionnaireItem &item,
                                                     const study::Texts &texts);

/// Null for an input that is none of them.
[[nodiscard]] const QuestionChoice *chosen_by(const std::vector<QuestionChoice> &choices,
                                              const ParticipantInput &input);

/// Before anything is answered.
[[nodiscard]] ParticipantPicture picture_of(const study::QuestionnaireItem &item,
                                            const study::Texts &texts);

} // namespace springdrive::app::study_screen
