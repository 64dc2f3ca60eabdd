// What a participant reads, in the protocol's language; and the list of these texts.
#pragma once

#include <array>
#include <string>
#include <string_view>

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

struct ParticipantText {
    std::string_view key; ///< in files
    std::string Texts::*text = nullptr;
    std::string_view help; ///< when it is shown
    /// What is filled in, each exactly once: `filled` does it. No other "{…}" is in a text.
    std::array<std::string_view, 2> placeholders{};
};

inline constexpr std::array<ParticipantText, 37> kParticipantTexts{{
    {"instructions", &Texts::instructions, "before the first trial"},
    {"question", &Texts::question, "above every trial"},
    {"stop_key", &Texts::stop_key, "with the instructions: how to stop the device"},
    {"gesture_help", &Texts::gesture_help, "with the instructions, if gestures answer"},
    {"noise_check", &Texts::noise_check, "before the first trial, if there is a noise"},
    {"warming_up", &Texts::warming_up, "while the windings are warmed"},
    {"practice_begins", &Texts::practice_begins, "before the practice"},
    {"practice_ends", &Texts::practice_ends, "after it"},
    {"understood",
     &Texts::understood,
     "after it, with two answer keys: whether to practise again",
     {"{again}", "{begin}"}},
    {"ready", &Texts::ready, "below all that is read before the first trial that counts"},
    {"block_begins", &Texts::block_begins, "before each block after the first"},
    {"first_interval", &Texts::first_interval, "during the first interval"},
    {"second_interval", &Texts::second_interval, "during the second interval"},
    {"show_standard", &Texts::show_standard, "during a standard that is presented first"},
    {"rest_at_spot", &Texts::rest_at_spot, "until the hand rests at the spot"},
    {"respond", &Texts::respond, "when an answer is waited for"},
    {"answer_no", &Texts::answer_no, "on the answer no of a yes/no task"},
    {"answer_yes", &Texts::answer_yes, "on the answer yes of a yes/no task"},
    {"correct", &Texts::correct, "after a right answer in practice"},
    {"wrong", &Texts::wrong, "after a wrong answer in practice"},
    {"too_slow", &Texts::too_slow, "after `response_s` without an answer"},
    {"repeated", &Texts::repeated, "after a trial that was marked"},
    {"progress", &Texts::progress, "between trials: how much is done", {"{}"}},
    {"pause", &Texts::pause, "in a break, with the time left"},
    {"break_left", &Texts::break_left, "in a break: the seconds left of it", {"{}"}},
    {"break_over", &Texts::break_over, "after the shortest time of a break"},
    {"paused", &Texts::paused, "while the experimenter has paused"},
    {"cooling_down", &Texts::cooling_down, "while the windings cool"},
    {"device_stopped", &Texts::device_stopped, "after a trip of the safety monitor"},
    {"please_lift", &Texts::please_lift, "after a presentation or a stop, until the tip is free"},
    {"device_lost", &Texts::device_lost, "while the device is not connected"},
    {"questionnaire_before", &Texts::questionnaire_before, "above the questions before"},
    {"questionnaire_after", &Texts::questionnaire_after, "above the questions after"},
    {"next_question", &Texts::next_question, "on the button to the next question"},
    {"no_answer", &Texts::no_answer, "on the button that leaves a question out"},
    {"end", &Texts::end, "after the last trial"},
    {"done_early", &Texts::done_early, "when leaving before the end"},
}};

/// The first placeholder that is missing or there twice, or "{…}" that is none: "KEY has …". Empty
/// if there is none.
[[nodiscard]] std::string what_is_wrong_with(const Texts &texts);

/// The text with its `placeholder` replaced; the text itself where it has none.
[[nodiscard]] std::string filled(std::string text, std::string_view placeholder,
                                 std::string_view value);

} // namespace springdrive::study
