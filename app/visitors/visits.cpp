#include "app/visitors/visits.h"

#include "app/study/sitting/sitting.h"
#include "app/visitors/curve_of_answers.h"
#include "base/input_error.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/observers/simulated_sitting.h"

#include <fmt/core.h>

#include <utility>

namespace springdrive::app::visitors {

namespace {

using study_screen::AnswerChoice;
using study_screen::OwnCurve;
using study_screen::ParticipantPicture;
using study_screen::Resumable;
using study_screen::SittingFrame;
using study_screen::SittingStep;

constexpr const char *kVisitor = "V1"; ///< a code, as the study in memory wants one
constexpr const char *kNothingIsKept = "Nothing of this is kept: no answer, no name, no file.";
constexpr double kDot_s = 0.15;      ///< for which a reckoned answer is shown
constexpr double kShowStart_s = 6.0; ///< of a show

AnswerChoice card_of(std::string text, const std::string &key) {
    return {std::move(text), study_screen::shown_key(key, false)};
}

std::string result_heading(const OwnCurve &curve, Visitor visitor) {
    if (!curve.threshold) {
        return "There were no answers.";
    }
    switch (visitor) {
    case Visitor::guesses:
        return "These were guesses: without a device there is nothing to feel.";
    case Visitor::made_up:
        return "The made-up visitor feels a force that is turned by " + threshold_words(curve) +
               ".";
    case Visitor::feels:
        break;
    }
    return "You feel a force that is turned by " + threshold_words(curve) + ".";
}

std::string result_text(const study::PsychometricFunction &made_up, Visitor visitor) {
    const std::string explained =
        visitor == Visitor::made_up
            ? fmt::format("In truth it was {:.0f} degrees. Larger dots are more answers.",
                          made_up.threshold)
            : std::string("Larger dots are more answers; half of all guesses are right.");
    return explained + "\n" + kNothingIsKept;
}

} // namespace

Visits::Visits(VisitsPlan plan, session::Session &session, study_screen::ShowsScene show_scene)
    : plan_(std::move(plan)), session_(session), show_scene_(std::move(show_scene)) {}

study_screen::Frames::Next Visits::show(ParticipantPicture picture, SittingStep step) {
    state_ = {};
    state_.step = step;
    return frames_.show(std::move(picture));
}

void Visits::resume(SittingFrame frame) {
    if (frame.orders.stops) {
        session_.keep_released(true);
        frames_.end();
    } else {
        frames_.resume(std::move(frame));
    }
}

/// Each has answers of their own.
study::SimulatedParticipant Visits::made_up_visitor() const {
    study::SimulatedParticipant visitor;
    visitor.function = plan_.made_up;
    visitor.seed = static_cast<std::uint64_t>(begun_);
    return visitor;
}

Resumable<Visitor> Visits::wait_for_visitor() {
    ParticipantPicture picture;
    picture.heading = "Can you feel it?";
    picture.choices_take_clicks = true;
    picture.footer = kNothingIsKept;
    if (plan_.has_device) {
        picture.text = "A force pushes your hand back, sometimes a little to the side.\n"
                       "How little can you feel? It takes five minutes.";
        picture.choices = {card_of("Begin", "enter")};
    } else {
        picture.text = "There is no device here, so there is nothing to feel: the hand on this "
                       "screen is simulated.\nWatch a made-up visitor, or guess yourself.";
        picture.choices = {card_of("Watch", "1"), card_of("Guess", "2")};
    }
    const double from_s = session_.servo().now_s();
    while (true) {
        const SittingFrame frame = co_await show(picture, SittingStep::instructions);
        if (plan_.is_show) {
            if (session_.servo().now_s() - from_s > kShowStart_s) {
                co_return Visitor::made_up;
            }
        } else if (plan_.has_device && is_pressed(frame.inputs, "enter", 0)) {
            co_return Visitor::feels;
        } else if (!plan_.has_device && is_pressed(frame.inputs, "1", 0)) {
            co_return Visitor::made_up;
        } else if (!plan_.has_device && is_pressed(frame.inputs, "2", 1)) {
            co_return Visitor::guesses;
        }
    }
}

Resumable<VisitEnd> Visits::sit(study::StudyStore &store, Visitor visitor) {
    study_screen::SittingPlan plan{plan_.protocol, plan_.setting, plan_.folders, kVisitor};
    plan.offers_practice_again = false; // nobody has the time
    plan.keeps_records = false;
    plan.is_attended = false;
    const bool is_made_up = visitor == Visitor::made_up;
    if (is_made_up) {
        plan.protocol.practice = {}; // nobody has to learn it
    }
    UnattendedVisit visit(session_, plan_.protocol,
                          is_made_up ? std::optional(made_up_visitor()) : std::nullopt);
    session_.keep_released(false); // a device that is not zeroed stays released
    study_screen::Sitting sitting(store, std::move(plan), session_, show_scene_);
    sitting.start();
    while (!sitting.is_over()) {
        state_ = sitting.state();
        SittingFrame frame =
            co_await frames_.show(visit.for_visitors(sitting.picture(), state_.step));
        sitting.resume(visit.for_sitting(std::move(frame), state_));
    }
    if (sitting.ending() == study::SessionEnding::failed) {
        throw InputError("the device has failed for good: " +
                         servo::description(session_.latest().safety) + "; start it again");
    }
    co_return sitting.ending() == study::SessionEnding::completed ? VisitEnd::none
    : visit.end() == VisitEnd::none                               ? VisitEnd::gone
                                                                  : visit.end();
}

/// The trials that a made-up visitor was not shown with, answered at once: the curve grows.
/// @return whether to its end
Resumable<bool> Visits::reckon_rest(study::StudyStore &store) {
    study::Protocol protocol = plan_.protocol;
    protocol.practice = {};
    study::Session session;
    session.participant = kVisitor;
    session.started = study::utc_now();
    session.device = store.contents().sessions.front().device;
    session.software = SPRINGDRIVE_VERSION;
    session.id = store.begin(session);
    const study::SimulatedParticipant visitor = made_up_visitor();
    ParticipantPicture picture;
    picture.heading = "The other answers, in fast motion";
    picture.footer = kNothingIsKept;
    study::RunningSession running(store, protocol, session);
    while (const std::optional<study::PlannedTrial> planned = running.next()) {
        picture.curve = curve_of(protocol, result_of_visit(protocol, store.contents()));
        const double until_s = session_.servo().now_s() + kDot_s;
        while (session_.servo().now_s() < until_s) {
            const SittingFrame frame = co_await show(picture, SittingStep::after_response);
            if (is_pressed(frame.inputs, "escape", SIZE_MAX)) {
                co_return false;
            }
        }
        study::Trial trial(*planned);
        trial.response =
            study::simulated_answer(protocol, visitor, *planned, planned->level.value()).response;
        if (running.add(std::move(trial))) {
            co_return false;
        }
    }
    co_return true;
}

Resumable<> Visits::show_curve(const study::StudyContents &visit, Visitor visitor) {
    ParticipantPicture picture;
    picture.curve = curve_of(plan_.protocol, result_of_visit(plan_.protocol, visit));
    picture.heading = result_heading(*picture.curve, visitor);
    picture.text = result_text(plan_.made_up, visitor);
    picture.choices = {card_of("Next visitor", "enter")};
    picture.choices_take_clicks = true;
    double from_s = session_.servo().now_s();
    const double stays_s = plan_.is_show ? kShowResult_s : kResult_s;
    while (true) {
        const SittingFrame frame = co_await show(picture, SittingStep::over);
        const double now_s = session_.servo().now_s();
        if (is_pressed(frame.inputs, "enter", 0) || is_pressed(frame.inputs, "escape", SIZE_MAX) ||
            now_s - from_s > stays_s) {
            co_return;
        }
        from_s = has_acted(frame.inputs) ? now_s : from_s;
    }
}

Resumable<> Visits::visits() {
    while (true) {
        const Visitor visitor = co_await wait_for_visitor();
        ++begun_;
        study::StudyStore store = study::StudyStore::in_memory(
            {plan_.protocol.title, "can you feel it?", SPRINGDRIVE_VERSION}, study::utc_now());
        store.add({kVisitor, begun_, study::utc_now()});
        const VisitEnd end = co_await sit(store, visitor);
        bool has_all = end == VisitEnd::none;
        if (end == VisitEnd::seen_enough) {
            has_all = co_await reckon_rest(store);
        }
        if (has_all) {
            const study::StudyContents contents = store.contents();
            co_await show_curve(contents, visitor);
        }
    }
}

Resumable<> Visits::whole() { co_await frames_.until_end(visits()); }

} // namespace springdrive::app::visitors
