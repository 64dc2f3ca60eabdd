// What a session shows between its trials: questions, the noise, breaks, the warm-up.
#include "app/study/session/study_session.h"

#include "app/study/participant/answers.h"
#include "base/input_error.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/stimuli/stimulus.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kFarewell_s = 5.0;

} // namespace

/// The servo follows the schedule as long as this exists. Not in the unnamed namespace, as
/// coroutines hold it.
class Followed {
public:
    Followed(session::ServoRun &servo, study::LiveWarmUp &schedule) : servo_(servo) {
        servo.follow(&schedule);
    }
    ~Followed() {
        servo_.follow(nullptr);
        servo_.paused([] {}); // it must not use the schedule any more
    }
    Followed(const Followed &) = delete;
    Followed &operator=(const Followed &) = delete;

private:
    session::ServoRun &servo_;
};

/// A break has a shortest time.
Resumable<> StudySession::rest(double seconds) {
    state_.step = StudySessionStep::in_break;
    since_break_ = 0;
    ParticipantPicture picture;
    picture.heading = plan_.protocol.texts.pause;
    const double until_s = session_.servo().now_s() + seconds;
    while (session_.servo().now_s() < until_s) {
        state_.left_s = until_s - session_.servo().now_s();
        picture.left_share = state_.left_s / seconds;
        picture.text = study::filled(plan_.protocol.texts.progress, "{}",
                                     fmt::format("{:.0f}", 100.0 * state_.progress));
        picture.left_text = study::filled(plan_.protocol.texts.break_left, "{}",
                                          fmt::format("{:.0f}", std::ceil(state_.left_s)));
        static_cast<void>(co_await show(picture));
    }
    orders_.skips_to_break = false; // this was one
}

/// Until the participant wants to go on, and not sooner than after so long.
Resumable<> StudySession::take_break(double seconds, StudySessionStep step) {
    co_await rest(seconds);
    const study::Texts &texts = plan_.protocol.texts;
    ParticipantPicture picture;
    if (step == StudySessionStep::block_begins) {
        picture.text = texts.block_begins;
    } else {
        picture.heading = texts.pause;
        picture.text = texts.break_over;
    }
    co_await show_until_key(step, picture);
}

Resumable<> StudySession::wait_while_paused() {
    while (orders_.is_paused) {
        state_.step = StudySessionStep::paused;
        ParticipantPicture picture;
        picture.heading = plan_.protocol.texts.paused;
        static_cast<void>(co_await show(picture));
    }
}

/// What is said before a trial.
Resumable<> StudySession::introduce(const study::PlannedTrial &planned) {
    const study::Texts &texts = plan_.protocol.texts;
    const bool is_practice = planned.is_practice;
    ParticipantPicture picture;
    if (has_presented_ && planned.place.block != last_block_) {
        co_await take_break(plan_.protocol.breaks.between_blocks_s, StudySessionStep::block_begins);
    } else if (std::exchange(orders_.skips_to_break, false) ||
               (plan_.protocol.breaks.every_trials > 0 &&
                since_break_ >= plan_.protocol.breaks.every_trials)) {
        co_await take_break(plan_.protocol.breaks.break_s, StudySessionStep::in_break);
    }
    if (is_practice && (!was_practising_ || !has_presented_)) {
        if (!was_practising_) {
            practised_.clear();
        }
        picture.heading = texts.practice_begins;
        picture.text = texts.ready;
        co_await show_until_key(StudySessionStep::practice_begins, picture);
    } else if (!is_practice && was_practising_) {
        co_await end_practice();
    }
    was_practising_ = is_practice;
    last_block_ = planned.place.block;
}

/// With two answer keys the participant may practise again, as often as it takes.
Resumable<> StudySession::end_practice() {
    const study::Texts &texts = plan_.protocol.texts;
    const study::ResponseWays &ways = plan_.protocol.responses;
    ParticipantPicture picture;
    picture.heading = texts.practice_ends;
    if (!plan_.offers_practice_again || ways.device == study::ResponseDevice::gesture ||
        ways.keys.size() < 2) {
        picture.text = texts.ready;
        co_await show_until_key(StudySessionStep::practice_ends, picture);
        co_return;
    }
    const bool is_mouse = ways.device == study::ResponseDevice::mouse;
    picture.text =
        study::filled(study::filled(texts.understood, "{again}", shown_key(ways.keys[0], is_mouse)),
                      "{begin}", shown_key(ways.keys[1], is_mouse));
    while (true) {
        state_.step = StudySessionStep::practice_ends;
        const StudySessionFrame frame = co_await show(picture);
        for (const ParticipantInput &input : frame.inputs) {
            const std::optional<std::size_t> key = alternative_of(ways, input);
            if (key == 0U) {
                co_await practise_again();
                break;
            }
            if (key) {
                co_return;
            }
        }
    }
}

/// The same trials as before. They are not of the sequence, and only notes tell of them, and of
/// stops in them.
Resumable<> StudySession::practise_again() {
    presented_again_ = 0;
    for (const study::PlannedTrial &planned : practised_) {
        co_await make_ready(planned);
        const std::optional<study::Trial> trial = co_await present_watched();
        if (trial) {
            ++*presented_again_;
            for (const study::SafetyEvent &event : trial->safety_events) {
                note("safety", event.text);
            }
            co_await tell_of(*trial, false);
        }
    }
    note_practice();
}

/// Whatever has ended it.
void StudySession::note_practice() {
    if (const std::optional<int> count = std::exchange(presented_again_, std::nullopt)) {
        note("practice", fmt::format("practised {} trials again, which are not stored", *count));
    }
}

/// Before the first trial, and whenever they have cooled below the band. A device that is stopped
/// or lost meanwhile is for make_ready.
/// @return whether there was anything to do
Resumable<bool> StudySession::warm_up() {
    const study::WindingBand &band = plan_.protocol.windings;
    if (!study::WarmUp::is_needed(band, study::estimated_windings_C(session_.latest()))) {
        co_return false;
    }
    study::LiveWarmUp schedule(session_.description(), band, session_.servo().period_s());
    const bool is_hot = study::estimated_windings_C(session_.latest()).maxCoeff() > band.to_C;
    ParticipantPicture picture;
    picture.heading = is_hot ? plan_.protocol.texts.cooling_down : plan_.protocol.texts.warming_up;
    picture.left_share = 1.0;
    double most_K = 0.0;
    {
        const Followed followed(session_.servo(), schedule);
        while (!schedule.is_over() &&
               session_.latest().safety.state != servo::SafetyState::tripped) {
            state_.step = StudySessionStep::warming_up;
            if (const double left_K = schedule.off_band_K(); left_K > 0.0) {
                most_K = std::max(most_K, left_K);
                picture.left_share = std::min(*picture.left_share, left_K / most_K);
            }
            static_cast<void>(co_await show(picture));
        }
    }
    stops_.watch();
    if (schedule.is_over() && schedule.failure() == study::WarmUpFailure::too_long) {
        throw InputError(fmt::format("{}: the windings cannot be warmed to {:g} °C: {}; lower "
                                     "windings.from_C",
                                     plan_.participant, band.from_C,
                                     study::description(schedule.failure())));
    }
    presenter_.lead_to_start();
    co_return true;
}

/// Before the first trial of the session.
Resumable<> StudySession::begin() {
    co_await ask_questions(study::QuestionnaireTime::before);
    if (noise_) {
        ParticipantPicture picture;
        picture.text = plan_.protocol.texts.noise_check + '\n' + plan_.protocol.texts.ready;
        co_await show_until_key(StudySessionStep::noise_check, picture);
    }
    const ParticipantPicture instructions = instructions_of(plan_.protocol);
    co_await show_until_key(StudySessionStep::instructions, instructions);
}

/// The device is not touched any more. @return how the session ends
Resumable<study::SessionEnding> StudySession::ask_after_last() {
    has_trials_left_ = false;
    session_.keep_released(true);
    end_noise();
    note_trials();
    if (open_questions(study::QuestionnaireTime::after).empty()) {
        co_return study::SessionEnding::completed; // whatever ended it with the last trial
    }
    if (!ending_) {
        co_await frames_.until_end(ask_questions(study::QuestionnaireTime::after));
    }
    co_return ending_.value_or(study::SessionEnding::completed);
}

Resumable<> StudySession::say_goodbye() {
    ParticipantPicture picture;
    picture.heading = plan_.protocol.texts.end;
    state_.progress = 1.0;
    co_await show_until_key(StudySessionStep::over, picture);
}

/// To a participant who leaves before the end: for some seconds, or until a key.
Resumable<> StudySession::let_go() {
    ParticipantPicture picture;
    picture.heading = plan_.protocol.texts.done_early;
    state_.step = StudySessionStep::over;
    const double until_s = session_.servo().now_s() + kFarewell_s;
    while (session_.servo().now_s() < until_s) {
        const StudySessionFrame frame = co_await show(picture);
        if (is_answer_key(frame.inputs)) {
            break;
        }
    }
}

/// A resumed session asks only what is missing.
std::vector<study::QuestionnaireItem>
StudySession::open_questions(study::QuestionnaireTime when) const {
    return study::open_questions(plan_.protocol, store_.contents(), plan_.participant, when);
}

/// One after the other; each answer is on the disk before the next question.
Resumable<> StudySession::ask_questions(study::QuestionnaireTime when) {
    const std::vector<study::QuestionnaireItem> open = open_questions(when);
    for (const study::QuestionnaireItem &item : open) {
        state_.step = StudySessionStep::questionnaire;
        const std::optional<std::string> answer = co_await answer_to(item);
        if (answer) {
            static_cast<void>(store_.add({plan_.participant, state_.session, item.name, item.text,
                                          *answer, study::utc_now()}));
        }
    }
}

/// Nothing if the participant would rather not say.
Resumable<std::optional<std::string>>
StudySession::answer_to(const study::QuestionnaireItem &item) {
    const std::vector<QuestionChoice> choices = choices_of(item, plan_.protocol.texts);
    ParticipantPicture picture = picture_of(item, plan_.protocol.texts);
    while (true) {
        const StudySessionFrame frame = co_await show(picture);
        picture.typed = typed_on(picture.typed, frame.inputs, study::kMaxAnswer);
        for (const ParticipantInput &input : frame.inputs) {
            if (const QuestionChoice *const chosen = chosen_by(choices, input)) {
                co_return picture.has_text_field && chosen->answer ? picture.typed : chosen->answer;
            }
        }
    }
}

} // namespace springdrive::app::study_screen
