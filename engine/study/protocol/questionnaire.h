// What a participant is asked before a session's first trial and after its last, apart from the
// trials: of tables [[questions]] in protocol files.
#pragma once

#include "base/field.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class QuestionnaireTime : std::uint8_t {
    before, ///< the session's first trial
    after   ///< its last
};
inline constexpr std::array<std::string_view, 2> kQuestionnaireTimeNames{"before", "after"};

enum class QuestionnaireKind : std::uint8_t {
    text,  ///< free text
    scale, ///< whole numbers between two labels
    choice ///< one of several texts
};
inline constexpr std::array<std::string_view, 3> kQuestionnaireKindNames{"text", "scale", "choice"};

/// One question. An answer is a text: what was written, the number in digits, or the choice as it
/// is in `choices`. A participant need not answer.
struct QuestionnaireItem {
    std::string name = {}; ///< in data: a-z, 0-9 and _, beginning with a letter; no other's
    QuestionnaireTime when = QuestionnaireTime::before;
    std::string text = {}; ///< what is asked, in the protocol's language
    QuestionnaireKind kind = QuestionnaireKind::text;
    int lowest = 1;                 ///< of a scale
    int highest = 7;                ///< of a scale
    std::string lowest_label = {};  ///< of a scale: what its lowest number means
    std::string highest_label = {}; ///< and its highest
    std::vector<std::string> choices = {};

    friend bool operator==(const QuestionnaireItem &, const QuestionnaireItem &) = default;
};

/// Of `QuestionnaireItem::choices`; at least two.
inline constexpr std::size_t kMaxChoices = 20;
/// A scale has at most so many steps: 0 to 100 is possible.
inline constexpr int kMaxScaleSteps = 100;
/// Of a free text [bytes].
inline constexpr std::size_t kMaxAnswer = 10'000;

inline constexpr auto kQuestionFields = std::to_array<Field<QuestionnaireItem>>({
    {"name", &QuestionnaireItem::name, "of its column in tables of answers: a-z, 0-9, _",
     kRequired},
    {"when", choice_of<&QuestionnaireItem::when>(kQuestionnaireTimeNames),
     "the session's first trial, or its last", kRequired},
    {"text", &QuestionnaireItem::text, "what is asked", kReadable, "", kRequired},
    {"kind", choice_of<&QuestionnaireItem::kind>(kQuestionnaireKindNames),
     "how it is answered: a free text, a whole number, or one of several texts", kRequired},
});
inline constexpr auto kScaleFields = std::to_array<Field<QuestionnaireItem>>({
    {"lowest", &QuestionnaireItem::lowest, "scale: its lowest number", -1000.0, 1000.0, "",
     kRequired},
    {"highest", &QuestionnaireItem::highest, "scale: its highest number, at most 100 above",
     -1000.0, 1000.0, "", kRequired},
    {"lowest_label", &QuestionnaireItem::lowest_label, "scale: what its lowest number means",
     kRequired},
    {"highest_label", &QuestionnaireItem::highest_label, "scale: and its highest", kRequired},
});
inline constexpr auto kChoiceFields = std::to_array<Field<QuestionnaireItem>>({
    {"choices", &QuestionnaireItem::choices, "choice: the possible answers", 2.0, kMaxChoices, "",
     kRequired},
});

/// The first that makes an item as its fields allow it none: "KEY is VALUE; it must be …". Empty if
/// there is none.
[[nodiscard]] std::string validate(const QuestionnaireItem &item);

/// "answer is VALUE; it must be …" if it is no possible answer; else empty. A free text may be
/// empty and may have lines.
[[nodiscard]] std::string validate_answer(const QuestionnaireItem &item, const std::string &answer);

/// The possible answers of a scale or choice, in order; none of a free text.
[[nodiscard]] std::vector<std::string> possible_answers(const QuestionnaireItem &item);

} // namespace springdrive::study
