// From what a participant does to a response, by the protocol's ways of answering; and what a
// participant sees of its instructions and questions, and which answer an input gives.
#pragma once

#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_picture.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/texts.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::study_screen {

/// Moves of the tip by which a participant answers, away from where it was at rest.
struct Gesture {
    std::string_view name;
    Vector3 direction; ///< unit, in device coordinates
};
[[nodiscard]] std::span<const Gesture> gestures();

/// So far a gesture goes, from where the tip rested [m].
inline constexpr double kGesture_m = 0.02;

/// The first name in `responses.keys` that this program cannot take as an answer, in a line; empty
/// if it can take all.
[[nodiscard]] std::string validate_answers(const study::ResponseWays &ways);

/// Which alternative an input gives, from 0.
[[nodiscard]] std::optional<std::size_t> alternative_of(const study::ResponseWays &ways,
                                                        const ParticipantInput &input);

/// Which alternative a tip gives that has moved by so much: that of the keys along which it went
/// furthest; nothing within `kGesture_m`.
[[nodiscard]] std::optional<std::size_t> alternative_of(const study::ResponseWays &ways,
                                                        const Vector3 &moved_m);

/// A forced choice or yes/no. @pre the task is no adjustment
[[nodiscard]] study::Response response_of(const study::Task &task, std::size_t alternative);

/// What is drawn of the ways to answer, with what they mean where the task says it: "no" and
/// "yes", the labels of intervals. Left is on the left of right.
[[nodiscard]] std::vector<AnswerChoice> choices_of(const study::Protocol &protocol);

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
