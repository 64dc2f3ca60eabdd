#include "app/visitors/visits.h"

#include "app/host/process.h"
#include "app/study/participant/answers.h"
#include "app/study/session/study_session.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "base/vector.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/session_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::app::visitors {

namespace {

using study_screen::AnswerChoice;
using study_screen::InputSource;
using study_screen::OwnCurve;
using study_screen::ParticipantInput;
using study_screen::ParticipantPicture;
using study_screen::Resumable;
using study_screen::StudySessionFrame;
using study_screen::StudySessionState;
using study_screen::StudySessionStep;

constexpr const char *kVisitor = "V1"; ///< a code, as the study in memory wants one
constexpr const char *kNothingIsKept = "Nothing of this is kept: no answer, no name, no file.";
constexpr double kDot_s = 0.15;      ///< for which a reckoned answer is shown
constexpr double kShowStart_s = 6.0; ///< of a show
constexpr double kReading_s = 4.0;   ///< until a visitor who is made up goes on
constexpr double kMove_m = 0.003;    ///< of a tip: more than a device that lies still drifts
constexpr double kThinking_s = 0.6;  ///< until the answer

constexpr std::array kTicks_deg{1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 90.0};
/// So near to an end of what is thought possible, an interval is open there: within a cell of the
/// usual grids.
constexpr double kEnd = 1.05;

struct Levels {
    double lowest;
    double highest;
};

Levels levels_of(const study::Protocol &protocol) {
    const std::vector<double> levels = study::presentable_levels(protocol);
    const auto [lowest, highest] = std::ranges::minmax(levels);
    return {lowest, highest};
}

/// Steps that wait for any key.
bool waits_for_key(StudySessionStep step) {
    switch (step) {
    case StudySessionStep::instructions:
    case StudySessionStep::practice_begins:
    case StudySessionStep::practice_ends:
    case StudySessionStep::block_begins:
    case StudySessionStep::in_break:
    case StudySessionStep::over:
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

/// Someone did something: any press.
bool has_acted(const std::vector<ParticipantInput> &inputs) {
    return std::ranges::any_of(inputs, &ParticipantInput::is_press);
}

/// A press of that key, or a click on the plate that shows it.
bool is_pressed(const std::vector<ParticipantInput> &inputs, std::string_view key,
                std::size_t choice) {
    return std::ranges::any_of(inputs, [&](const ParticipantInput &input) {
        return input.is_press && (input.source == InputSource::choice
                                      ? input.choice == choice
                                      : input.source == InputSource::key && input.name == key);
    });
}

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

std::string validate_for_visitors(const study::Protocol &protocol) {
    if (!study::is_forced_choice(protocol.task.kind) ||
        std::holds_alternative<study::Adjustment>(protocol.method)) {
        return "is no forced choice, of which a visitor's own curve could be drawn; name another "
               "protocol";
    }
    if (protocol.conditions.size() != 1) {
        return "has more than one condition, which visitors have no time for; leave one";
    }
    if (protocol.noise) {
        return "plays a masking noise, which nobody is there to turn down; remove its [noise]";
    }
    if (!protocol.questionnaire.empty()) {
        return "asks questions, whose answers would not be kept; remove its [[questions]]";
    }
    if (protocol.variable.parameter != "turn_deg" ||
        study::analysis_family(protocol).scale != study::Scale::logarithmic ||
        levels_of(protocol).lowest <= 0.0) {
        return "does not vary turn_deg on a logarithmic scale, which the words on the screen are "
               "for; name another protocol";
    }
    return {};
}

std::optional<study::SeriesResult> result_of_visit(const study::Protocol &protocol,
                                                   const study::StudyContents &visit) {
    if (visit.sessions.empty()) {
        return std::nullopt;
    }
    std::vector<study::Series> series =
        study::series_of(protocol, visit, visit.sessions.front().device);
    if (series.empty() || study::counting_trials(protocol, series.front()).empty()) {
        return std::nullopt;
    }
    return study::result_of(protocol, std::move(series.front()));
}

OwnCurve curve_of(const study::Protocol &protocol,
                  const std::optional<study::SeriesResult> &result) {
    const Levels levels = levels_of(protocol);
    OwnCurve curve;
    curve.lowest_level = levels.lowest;
    curve.highest_level = levels.highest;
    curve.guess = 1.0 / protocol.task.alternatives;
    std::ranges::copy_if(kTicks_deg, std::back_inserter(curve.ticks), [&](double tick) {
        return tick >= curve.lowest_level && tick <= curve.highest_level;
    });
    curve.level_label = "how far the force was turned (degrees)";
    curve.share_label = "right answers";
    if (!result) {
        return curve;
    }
    for (const study::LevelCount &count : result->counts) {
        curve.dots.push_back(
            {count.level, static_cast<double>(count.positive) / count.trials, count.trials});
    }
    if (result->fitted) {
        for (const study::FunctionPoint &point : result->fitted->course) {
            curve.course.push_back({point.level, point.proportion, point.low, point.high});
        }
        const study::PosteriorSummary &threshold = result->fitted->threshold;
        curve.threshold = {threshold.median, threshold.low, threshold.high};
    }
    return curve;
}

std::string threshold_words(const OwnCurve &curve) {
    if (!curve.threshold) {
        return {};
    }
    const OwnCurve::Threshold &threshold = *curve.threshold;
    if (threshold.high * kEnd >= curve.highest_level) {
        return fmt::format("more than {:.0f} degrees", threshold.low);
    }
    if (threshold.low <= kEnd * curve.lowest_level) {
        return fmt::format("less than {:.0f} degrees", threshold.high);
    }
    return fmt::format("{:.0f} degrees ({:.0f} to {:.0f})", threshold.level, threshold.low,
                       threshold.high);
}

/// A study session without an experimenter. Not in the unnamed namespace, as coroutines hold it.
class UnattendedVisit {
public:
    /// @param session  and the protocol: must outlive this
    /// @param made_up  answers in the visitor's place; nothing: a visitor does
    UnattendedVisit(session::Session &session, const study::Protocol &protocol,
                    std::optional<study::SimulatedParticipant> made_up)
        : session_(session), protocol_(protocol), made_up_(made_up),
          seen_s_(session.servo().now_s()), stop_(session.servo().inputs().requested_stop),
          step_since_s_(session.servo().now_s()) {}

    /// What is shown of a study session's picture. With a mouse all can be done by its left button.
    [[nodiscard]] ParticipantPicture for_visitors(ParticipantPicture picture,
                                                  StudySessionStep step) {
        const double now_s = session_.servo().now_s();
        if (std::exchange(step_, step) != step) {
            step_since_s_ = now_s;
        }
        was_asked_ = !made_up_ && now_s - seen_s_ > kAskedAfter_s;
        picture.choices_take_clicks = true;
        if (waits_for_key(step)) {
            picture.choices = {card_of("Go on", "enter")};
        } else if (step == StudySessionStep::device_stopped) {
            picture.choices = {card_of("Let it go on", "enter")};
        }
        if (made_up_) {
            picture.footer = "A made-up visitor answers. Escape: back to the start.";
        }
        if (was_asked_) {
            picture.heading = "Still there?";
            picture.text = "Press any key.";
            picture.is_calm_stop = false;
            picture.choices = {card_of("Yes", "enter")};
        }
        return picture;
    }

    /// What a study session gets of the frame in which that was shown.
    [[nodiscard]] StudySessionFrame for_study_session(StudySessionFrame frame,
                                                      const StudySessionState &state) {
        if (!made_up_ && away_s(frame.inputs) > kGoneAfter_s) {
            stop(frame, VisitEnd::gone);
        }
        if (is_pressed(frame.inputs, "escape", SIZE_MAX)) {
            stop(frame, VisitEnd::left);
        }
        if (was_asked_) { // it answers that, and nothing that was behind it
            frame.inputs.clear();
        }
        if (state.step == StudySessionStep::device_stopped &&
            is_pressed(frame.inputs, "enter", 0)) {
            frame.orders.resets_device = true;
        }
        if (state.step == StudySessionStep::over) { // their curve follows at once
            frame.inputs.push_back(key_press("enter", session_.servo().now_s()));
        }
        if (made_up_) {
            act_made_up(state, frame);
        }
        return frame;
    }

    [[nodiscard]] VisitEnd end() const { return end_; }

private:
    /// Since somebody acted, stopped the device, or moved the tip of a real one.
    [[nodiscard]] double away_s(const std::vector<ParticipantInput> &inputs) {
        const double now_s = session_.servo().now_s();
        const std::uint32_t requested = session_.servo().inputs().requested_stop; // no input's key
        const bool is_stopped = std::exchange(stop_, requested) != requested;
        const Vector3 &tip_m = session_.latest().tip_m;
        const bool has_moved =
            !session_.hand().is_simulated() && (!tip_m_ || (tip_m - *tip_m_).norm() > kMove_m);
        if (has_moved) {
            tip_m_ = tip_m;
        }
        if (has_acted(inputs) || is_stopped || has_moved) {
            seen_s_ = now_s;
        }
        return now_s - seen_s_;
    }

    /// Answers to what the method asks for, not to what was delivered: that is in no picture.
    void act_made_up(const StudySessionState &state, StudySessionFrame &frame) {
        const double now_s = session_.servo().now_s();
        const double shown_s = now_s - step_since_s_;
        if (waits_for_key(state.step) && shown_s >= kReading_s) {
            frame.inputs.push_back(key_press("enter", now_s));
        } else if (state.step == StudySessionStep::response && shown_s >= kThinking_s) {
            const study::SimulatedAnswer answer = study::simulated_answer(
                protocol_, *made_up_, *state.trial, state.trial->level.value());
            const auto *chosen = std::get_if<study::Chosen>(&answer.response);
            const auto alternative = static_cast<std::size_t>(chosen ? chosen->alternative - 1 : 0);
            frame.inputs.push_back(key_press(
                study_screen::input_name(protocol_.responses.keys.at(alternative)), now_s));
        } else if (state.trials.size() >= kShownTrials) {
            stop(frame, VisitEnd::seen_enough);
        }
    }

    void stop(StudySessionFrame &frame, VisitEnd why) {
        frame.orders.stops = true;
        end_ = why;
    }

    session::Session &session_;
    const study::Protocol &protocol_;
    std::optional<study::SimulatedParticipant> made_up_;
    double seen_s_;                ///< when somebody was there
    std::optional<Vector3> tip_m_; ///< of a real device, where it was when it was moved last
    std::uint32_t stop_;           ///< the last one requested here
    double step_since_s_;          ///< since when the present step is shown
    StudySessionStep step_ = StudySessionStep::instructions;
    bool was_asked_ = false; ///< in the present frame, whether somebody is still there
    VisitEnd end_ = VisitEnd::none;
};

Visits::Visits(VisitsPlan plan, session::Session &session, study_screen::ShowsScene show_scene)
    : plan_(std::move(plan)), session_(session), show_scene_(std::move(show_scene)) {}

study_screen::Frames::Next Visits::show(ParticipantPicture picture, StudySessionStep step) {
    state_ = {};
    state_.step = step;
    return frames_.show(std::move(picture));
}

void Visits::resume(StudySessionFrame frame) {
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
        const StudySessionFrame frame = co_await show(picture, StudySessionStep::instructions);
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
    study_screen::StudySessionPlan plan{plan_.protocol, plan_.setting, plan_.folders, kVisitor};
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
    study_screen::StudySession study_session(store, std::move(plan), session_, show_scene_);
    study_session.start();
    while (!study_session.is_over()) {
        state_ = study_session.state();
        StudySessionFrame frame =
            co_await frames_.show(visit.for_visitors(study_session.picture(), state_.step));
        study_session.resume(visit.for_study_session(std::move(frame), state_));
    }
    if (study_session.ending() == study::SessionEnding::failed) {
        throw InputError("the device has failed for good: " +
                         servo::description(session_.latest().safety) + "; start it again");
    }
    co_return study_session.ending() == study::SessionEnding::completed ? VisitEnd::none
    : visit.end() == VisitEnd::none                                     ? VisitEnd::gone
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
            const StudySessionFrame frame =
                co_await show(picture, StudySessionStep::after_response);
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
        const StudySessionFrame frame = co_await show(picture, StudySessionStep::over);
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

void VisitorWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot) {
    window_.show_scene(scene, spot, session_.description().workspace);
}

void VisitorWindow::obey_staff(const std::vector<ParticipantInput> &inputs) {
    for (const ParticipantInput &input : inputs) {
        if (input.source != InputSource::key) {
            continue;
        }
        if (!input.is_press) {
            held_keys_.erase(input.name);
            continue;
        }
        held_keys_.insert(input.name);
        if (!held_keys_.contains("ctrl") || !held_keys_.contains("alt")) {
            continue;
        }
        is_asked_to_end_ = is_asked_to_end_ || input.name == "q";
        if (input.name == "z") {
            if (const std::string error =
                    error_text_of([this] { session_.zero_device(Vector3::Zero()); });
                !error.empty()) {
                std::cerr << "springdrive: " << error << '\n';
            }
        }
    }
}

void VisitorWindow::report(const ParticipantPicture &picture,
                           const StudySessionState &state) const {
    const study_screen::ParticipantLayout &layout = window_.layout();
    ui::enter_at(layout.heading.box, "visitor/heading", "text", picture.heading);
    ui::enter_at(layout.text.box, "visitor/text", "text", picture.text);
    ui::enter_at(layout.footer.box, "visitor/footer", "text", picture.footer);
    ui::enter_at(layout.curve.plot, "visitor/curve", "text",
                 picture.curve ? fmt::format("{} dots", picture.curve->dots.size()) : "");
    ui::enter_at(layout.scene, "visitor/step", "text",
                 std::string(study_screen::description(state.step)));
    for (std::size_t i = 0; i < layout.choices.size(); ++i) {
        ui::enter_at(layout.choices[i].card, fmt::format("visitor/choice {}", i + 1), "button",
                     picture.choices[i].text);
    }
}

StudySessionFrame VisitorWindow::show(const ParticipantPicture &picture,
                                      const StudySessionState &state) {
    window_.show(picture);
    report(picture, state);
    if (window_.take_emergency_stop()) {
        session_.emergency_stop();
    }
    StudySessionFrame frame{window_.take_inputs(session_.servo()), {}};
    obey_staff(frame.inputs);
    frame.orders.stops = is_asked_to_end_ || asked_to_end();
    return frame;
}

} // namespace springdrive::app::visitors
