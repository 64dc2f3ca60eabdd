// What a participant reads, in the protocol's language; and the list of these texts.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace springdrive::study {

/// The defaults are English.
struct Texts {
    std::string instructions =
        "Hold the stylus as you would hold a pen. You will feel something at its tip, twice.\n"
        "Then answer the question. There is no hurry; if you are not sure, guess.";
    std::string question = "In which interval did you feel it?";
    std::string practice_begins = "First, some trials to practise.";
    std::string practice_ends = "That was the practice. Now it counts.";
    std::string block_begins = "A new part begins. Press any answer key when you are ready.";
    std::string first_interval = "1";
    std::string second_interval = "2";
    std::string rest_at_spot = "Hold still above the mark.";
    std::string respond = "Your answer?";
    std::string correct = "Right.";
    std::string wrong = "It was the other one.";
    std::string too_slow = "No answer in time: this one comes again later.";
    std::string repeated = "This one did not count, through no fault of yours. It comes again.";
    std::string device_stopped =
        "The device has stopped itself, as it should. Let go, and wait a moment.";
    std::string pause = "Rest your hand.";
    std::string stop_key = "You may stop the device at any time: press the space bar.";
    std::string end = "That is all. Thank you!";

    friend bool operator==(const Texts &, const Texts &) = default;
};

struct ParticipantText {
    std::string_view key; ///< in files
    std::string Texts::*text = nullptr;
    std::string_view help; ///< when it is shown
};

inline constexpr std::array<ParticipantText, 17> kParticipantTexts{{
    {"instructions", &Texts::instructions, "before the first trial"},
    {"question", &Texts::question, "above every trial"},
    {"practice_begins", &Texts::practice_begins, "before the practice"},
    {"practice_ends", &Texts::practice_ends, "after it"},
    {"block_begins", &Texts::block_begins, "before each block after the first"},
    {"first_interval", &Texts::first_interval, "during the first interval"},
    {"second_interval", &Texts::second_interval, "during the second interval"},
    {"rest_at_spot", &Texts::rest_at_spot, "until the hand rests at the spot"},
    {"respond", &Texts::respond, "when an answer is waited for"},
    {"correct", &Texts::correct, "after a right answer in practice"},
    {"wrong", &Texts::wrong, "after a wrong answer in practice"},
    {"too_slow", &Texts::too_slow, "after `response_s` without an answer"},
    {"repeated", &Texts::repeated, "after a trial that was marked"},
    {"device_stopped", &Texts::device_stopped, "after a trip of the safety monitor"},
    {"pause", &Texts::pause, "in a break, with the time left"},
    {"stop_key", &Texts::stop_key, "with the instructions: how to stop the device"},
    {"end", &Texts::end, "after the last trial"},
}};

} // namespace springdrive::study
