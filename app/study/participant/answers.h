// What a participant did, and from that to a response, by the protocol's ways of answering; what a
// participant sees of its instructions and questions, and which answer an input gives.
//
// Inputs are keys and mouse buttons by the names of protocol files, clicks on choices, and letters
// of a free text. The space bar and F12 stop the device and are never among them.
#pragma once

#include "app/study/participant/participant_picture.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/texts.h"
#include "engine/study/store/study_contents.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::study_screen {

enum class InputSource : std::uint8_t {
    key, ///< `name`: see `is_key_name`, or the letter or digit that the keyboard's layout has
         ///< there, lower case; those of the number pad are not told apart
    mouse_button, ///< `name`: one of kMouseButtonNames
    choice,       ///< a click on a plate: `name` is the choice's key, `choice` its index
    letter        ///< of a free text: `name` is one code point in UTF-8
};

struct ParticipantInput {
    InputSource source = InputSource::key;
    std::string name;
    std::size_t choice = 0; ///< index into ParticipantPicture::choices, of a choice only
    double clock_s = 0.0;   ///< of std::chrono::steady_clock, since its epoch, when it was noted
    bool is_press = true;   ///< a release is reported of keys and mouse buttons only

    friend bool operator==(const ParticipantInput &, const ParticipantInput &) = default;
};

inline constexpr std::array<std::string_view, 5> kMouseButtonNames{"left", "right", "middle",
                                                                   "back", "forward"};

/// Whether a key can be reported under this name, which is compared without regard to the case of
/// ASCII letters: that of a key which types nothing ("left", "enter", "f5"), a sign of ASCII, or
/// another letter that some keyboard types without shift and AltGr: "ä", not "Ä" or "€". Whether a
/// keyboard has it is not known before it is pressed.
[[nodiscard]] bool is_key_name(std::string_view name);
[[nodiscard]] bool is_mouse_button_name(std::string_view name);

/// The name as events have it: ASCII letters in lower case.
[[nodiscard]] std::string input_name(std::string_view name);

/// What a plate shows for it: arrows for "left", "right", "up", "down" of a keyboard, "↵" for
/// "enter", capital letters; other names as they are. Needs no translation as far as possible.
[[nodiscard]] std::string shown_key(std::string_view name, bool is_mouse);

/// A free text after letters, and backspaces, which take off one code point. Text that would be
/// longer than `max_bytes` is left as it is.
[[nodiscard]] std::string typed_on(std::string text, std::span<const ParticipantInput> inputs,
                                   std::size_t max_bytes = 4000);

/// Names of keys by GLFW's codes: of one that types nothing, and of one that types a letter, by the
/// keyboard's layout. Empty if it has none. @pre of the second: GLFW is initialised
[[nodiscard]] std::string name_of_silent_key(int key);
[[nodiscard]] std::string name_of_letter_key(int key, int scancode);

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
