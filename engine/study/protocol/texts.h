// What a participant reads, in the protocol's language; and the list of these texts.
#pragma once

#include "base/field.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

/// The defaults are English.
struct Texts {
    // Before the trials.
    std::string instructions =
        "Hold the stylus as you would hold a pen. You will feel something at its tip, twice.\n"
        "Then answer the question. There is no hurry; if you are not sure, guess.";
    std::string question = "In which interval did you feel it?";
    std::string stop_key = "You may stop the device at any time: press the space bar.";
    std::string gesture_help =
        "To answer, hold still for a moment, then move the tip to the side of your answer.";
    std::string noise_check = "You should hear a steady noise. Is it comfortable? If it is too "
                              "loud or too soft, say so now.";
    std::string warming_up = "The device is warming up. Do not hold it, please.";
    std::string practice_begins = "First, some trials to practise.";
    std::string practice_ends = "That was the practice. Now it counts.";
    std::string understood = "Press {again} to practise again, {begin} to begin.";
    std::string ready = "Press any answer key when you are ready.";
    std::string block_begins = "A new part begins. Press any answer key when you are ready.";

    // In a trial.
    std::string first_interval = "1";
    std::string second_interval = "2";
    std::string show_standard = "Compare with this.";
    std::string rest_at_spot = "Hold still above the mark.";
    std::string respond = "Your answer?";
    std::string answer_no = "no";
    std::string answer_yes = "yes";
    std::string correct = "Correct.";
    std::string wrong = "It was the other one.";
    std::string too_slow = "No answer in time: this one comes again later.";
    std::string repeated = "This one did not count, through no fault of yours. It comes again.";

    // Between trials.
    std::string progress = "{} % done";
    std::string pause = "Rest your hand.";
    std::string break_left = "{} s left";
    std::string break_over = "Go on when you are ready: press any answer key.";
    std::string paused = "The experimenter has paused. Rest your hand.";
    std::string cooling_down = "The device is cooling down. Rest your hand, please.";
    std::string device_stopped =
        "The device has stopped itself, as it should. Let go, and wait a moment.";
    std::string please_lift = "Lift the tip off the surface, please.";
    std::string device_lost = "The device is not connected. Please wait.";

    // Questions, and the end.
    std::string questionnaire_before = "A few questions before we begin.";
    std::string questionnaire_after = "A few questions about how it was.";
    std::string next_question = "Next";
    std::string no_answer = "I prefer not to answer";
    std::string end = "That is all. Thank you!";
    std::string done_early = "You may leave now; thank you.";

    friend bool operator==(const Texts &, const Texts &) = default;
};

/// With when each is shown. What a default has in braces is filled in, see `filled`.
inline constexpr auto kTextFields = std::to_array<Field<Texts>>({
    {"instructions", &Texts::instructions, "before the first trial", kReadable},
    {"question", &Texts::question, "above every trial", kReadable},
    {"stop_key", &Texts::stop_key, "with the instructions: how to stop the device", kReadable},
    {"gesture_help", &Texts::gesture_help, "with the instructions, if gestures answer", kReadable},
    {"noise_check", &Texts::noise_check, "before the first trial, if there is a noise", kReadable},
    {"warming_up", &Texts::warming_up, "while the windings are warmed", kReadable},
    {"practice_begins", &Texts::practice_begins, "before the practice", kReadable},
    {"practice_ends", &Texts::practice_ends, "after it", kReadable},
    {"understood", &Texts::understood, "after it, with two answer keys: whether to practise again",
     kReadable},
    {"ready", &Texts::ready, "below all that is read before the first trial that counts",
     kReadable},
    {"block_begins", &Texts::block_begins, "before each block after the first", kReadable},
    {"first_interval", &Texts::first_interval, "during the first interval", kReadable},
    {"second_interval", &Texts::second_interval, "during the second interval", kReadable},
    {"show_standard", &Texts::show_standard, "during a standard that is presented first",
     kReadable},
    {"rest_at_spot", &Texts::rest_at_spot, "until the hand rests at the spot", kReadable},
    {"respond", &Texts::respond, "when an answer is waited for", kReadable},
    {"answer_no", &Texts::answer_no, "on the answer no of a yes/no task", kReadable},
    {"answer_yes", &Texts::answer_yes, "on the answer yes of a yes/no task", kReadable},
    {"correct", &Texts::correct, "after a right answer in practice", kReadable},
    {"wrong", &Texts::wrong, "after a wrong answer in practice", kReadable},
    {"too_slow", &Texts::too_slow, "after `response_s` without an answer", kReadable},
    {"repeated", &Texts::repeated, "after a trial that was marked", kReadable},
    {"progress", &Texts::progress, "between trials: how much is done", kReadable},
    {"pause", &Texts::pause, "in a break, with the time left", kReadable},
    {"break_left", &Texts::break_left, "in a break: the seconds left of it", kReadable},
    {"break_over", &Texts::break_over, "after the shortest time of a break", kReadable},
    {"paused", &Texts::paused, "while the experimenter has paused", kReadable},
    {"cooling_down", &Texts::cooling_down, "while the windings cool", kReadable},
    {"device_stopped", &Texts::device_stopped, "after a trip of the safety monitor", kReadable},
    {"please_lift", &Texts::please_lift, "after a presentation or a stop, until the tip is free",
     kReadable},
    {"device_lost", &Texts::device_lost, "while the device is not connected", kReadable},
    {"questionnaire_before", &Texts::questionnaire_before, "above the questions before", kReadable},
    {"questionnaire_after", &Texts::questionnaire_after, "above the questions after", kReadable},
    {"next_question", &Texts::next_question, "on the button to the next question", kReadable},
    {"no_answer", &Texts::no_answer, "on the button that leaves a question out", kReadable},
    {"end", &Texts::end, "after the last trial", kReadable},
    {"done_early", &Texts::done_early, "when leaving before the end", kReadable},
});

/// The first placeholder of a default that a text lacks or has twice, or "{…}" that is none:
/// "KEY has …". Empty if there is none.
[[nodiscard]] std::string validate(const Texts &texts);

/// The text with its `placeholder` replaced; the text itself where it has none.
[[nodiscard]] std::string filled(std::string text, std::string_view placeholder,
                                 std::string_view value);

// What a participant is asked before a session's first trial and after its last, apart from the
// trials: of tables [[questions]] in protocol files.

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

/// The possible answers of a scale or choice, in order; none of a free text.
[[nodiscard]] std::vector<std::string> possible_answers(const QuestionnaireItem &item);

} // namespace springdrive::study
