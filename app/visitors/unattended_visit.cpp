#include "app/visitors/unattended_visit.h"

#include "engine/study/observers/simulated_sitting.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace springdrive::app::visitors {

namespace {

using study_screen::InputSource;
using study_screen::ParticipantInput;
using study_screen::ParticipantPicture;
using study_screen::SittingFrame;
using study_screen::SittingState;
using study_screen::SittingStep;

constexpr double kReading_s = 4.0;  ///< until a visitor who is made up goes on
constexpr double kThinking_s = 0.6; ///< until the answer

/// Steps that wait for any key.
bool waits_for_key(SittingStep step) {
    switch (step) {
    case SittingStep::instructions:
    case SittingStep::practice_begins:
    case SittingStep::practice_ends:
    case SittingStep::block_begins:
    case SittingStep::in_break:
    case SittingStep::over:
        return true;
    default:
        return false;
    }
}

ParticipantInput key_press(std::string name, double clock_s) {
    ParticipantInput input;
    input.name = std::move(name);
    input.clock_s = clock_s;
    return input;
}

} // namespace

bool has_acted(const std::vector<ParticipantInput> &inputs) {
    return std::ranges::any_of(inputs, &ParticipantInput::is_press);
}

bool is_pressed(const std::vector<ParticipantInput> &inputs, std::string_view key,
                std::size_t choice) {
    return std::ranges::any_of(inputs, [&](const ParticipantInput &input) {
        return input.is_press && (input.source == InputSource::choice
                                      ? input.choice == choice
                                      : input.source == InputSource::key && input.name == key);
    });
}

UnattendedVisit::UnattendedVisit(session::Session &session, const study::Protocol &protocol,
                                 std::optional<study::SimulatedParticipant> made_up)
    : session_(session), protocol_(protocol), made_up_(made_up), presence_(session.servo().now_s()),
      stop_(session.servo().inputs().requested_stop), step_since_s_(session.servo().now_s()) {}

ParticipantPicture UnattendedVisit::for_visitors(ParticipantPicture picture, SittingStep step) {
    if (std::exchange(step_, step) != step) {
        step_since_s_ = session_.servo().now_s();
    }
    was_asked_ = is_asking();
    picture.choices_take_clicks = true;
    if (waits_for_key(step)) {
        picture.choices = {{"Go on", study_screen::shown_key("enter", false)}};
    } else if (step == SittingStep::device_stopped) {
        picture.choices = {{"Let it go on", study_screen::shown_key("enter", false)}};
    }
    if (made_up_) {
        picture.footer = "A made-up visitor answers. Escape: back to the start.";
    }
    if (was_asked_) {
        picture.heading = "Still there?";
        picture.text = "Press any key.";
        picture.is_calm_stop = false;
        picture.choices = {{"Yes", study_screen::shown_key("enter", false)}};
    }
    return picture;
}

bool UnattendedVisit::is_asking() const {
    return !made_up_ && presence_.away_s(session_.servo().now_s()) > kAskedAfter_s;
}

void UnattendedVisit::stop(SittingFrame &frame, VisitEnd why) {
    frame.orders.stops = true;
    end_ = why;
}

/// Answers to what the method asks for, not to what was delivered: that is in no picture.
void UnattendedVisit::act_made_up(const SittingState &state, SittingFrame &frame) {
    const double now_s = session_.servo().now_s();
    const double shown_s = now_s - step_since_s_;
    if (waits_for_key(state.step) && shown_s >= kReading_s) {
        frame.inputs.push_back(key_press("enter", now_s));
    } else if (state.step == SittingStep::response && shown_s >= kThinking_s) {
        const study::SimulatedAnswer answer =
            study::simulated_answer(protocol_, *made_up_, *state.trial, state.trial->level.value());
        const auto *chosen = std::get_if<study::Chosen>(&answer.response);
        const auto alternative = static_cast<std::size_t>(chosen ? chosen->alternative - 1 : 0);
        frame.inputs.push_back(
            key_press(study_screen::input_name(protocol_.responses.keys.at(alternative)), now_s));
    } else if (state.trials.size() >= kShownTrials) {
        stop(frame, VisitEnd::seen_enough);
    }
}

void UnattendedVisit::watch(SittingFrame &frame) {
    const double now_s = session_.servo().now_s();
    const bool is_real = !session_.hand().is_simulated();
    const std::uint32_t requested = session_.servo().inputs().requested_stop; // no input's key
    const bool is_stopped = std::exchange(stop_, requested) != requested;
    presence_.update(now_s, has_acted(frame.inputs) || is_stopped,
                     is_real ? std::optional(session_.latest().tip_m) : std::nullopt);
    if (!made_up_ && presence_.away_s(now_s) > kGoneAfter_s) {
        stop(frame, VisitEnd::gone);
    }
}

SittingFrame UnattendedVisit::for_sitting(SittingFrame frame, const SittingState &state) {
    watch(frame);
    if (is_pressed(frame.inputs, "escape", SIZE_MAX)) {
        stop(frame, VisitEnd::left);
    }
    if (was_asked_) { // it answers that, and nothing that was behind it
        frame.inputs.clear();
    }
    if (state.step == SittingStep::device_stopped && is_pressed(frame.inputs, "enter", 0)) {
        frame.orders.resets_device = true;
    }
    if (state.step == SittingStep::over) { // their curve follows at once
        frame.inputs.push_back(key_press("enter", session_.servo().now_s()));
    }
    if (made_up_) {
        act_made_up(state, frame);
    }
    return frame;
}

} // namespace springdrive::app::visitors
