#include "app/study/session/study_session.h"

#include "app/study/participant/answers.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/session_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace springdrive::app::study_screen {

namespace {

constexpr double kFeedback_s = 1.2;

study::DeviceKind kind_of(factory::DeviceKind kind) {
    return kind == factory::DeviceKind::usb        ? study::DeviceKind::usb
           : kind == factory::DeviceKind::emulated ? study::DeviceKind::emulated
                                                   : study::DeviceKind::simulated;
}

} // namespace

StudySession::StudySession(study::StudyStore &store, StudySessionPlan plan,
                           session::Session &session, ShowsScene show_scene)
    : store_(store), plan_(std::move(plan)), session_(session),
      presenter_({plan_.protocol, plan_.setting, plan_.folders, session_, state_,
                  std::move(show_scene),
                  [this](ParticipantPicture picture) { return show(std::move(picture)); }}),
      stops_(session_, plan_.is_attended || !session_.device().device().can_reach_a_hand(),
             [this](const std::string &what) { note("safety", what); }) {
    if (const std::string wrong = validate_for_participants(plan_.protocol, plan_.setting);
        !wrong.empty()) {
        throw InputError(wrong);
    }
    require_device_of_before();
}

void StudySession::fail() {
    if (begun_.id != 0 && !stored_ending_) {
        study::end_as_failed(store_, begun_.id);
    }
}

/// Trials choose the levels of those after them: a person's must not go on with a rehearsal's.
void StudySession::require_device_of_before() const {
    const study::DeviceKind now = kind_of(session_.device_choice().kind);
    for (const study::Session &before : store_.contents().sessions) {
        if (before.participant == plan_.participant && before.device != now) {
            throw InputError(fmt::format("{}: {} has sessions on another kind of device ({}); "
                                         "begin with a new code, or give the device of before",
                                         store_.file().string(), plan_.participant,
                                         study::name_of(before.device)));
        }
    }
}

/// Every frame of a session.
Frames::Next StudySession::show(ParticipantPicture picture) {
    if (!picture.has_text_field) { // where the space bar writes
        picture.footer = plan_.protocol.texts.stop_key;
    }
    picture.progress = state_.progress;
    return frames_.show(std::move(picture));
}

bool StudySession::is_answer_key(const std::vector<ParticipantInput> &inputs) const {
    return std::ranges::any_of(inputs, [this](const ParticipantInput &input) {
        const bool is_gesture = plan_.protocol.responses.device == study::ResponseDevice::gesture;
        return input.is_press &&
               (alternative_of(plan_.protocol.responses, input) || input.name == "enter" ||
                (is_gesture && input.source == InputSource::key));
    });
}

Resumable<> StudySession::show_until_key(StudySessionStep step, const ParticipantPicture &picture) {
    state_.step = step;
    StudySessionFrame frame;
    while (!is_answer_key(frame.inputs)) {
        frame = co_await show(picture);
    }
}

void StudySession::note(const std::string &kind, const std::string &text) {
    store_.append(study::Note{study::utc_now(), kind, text, plan_.participant, state_.session});
}

/// Until the motors run.
Resumable<> StudySession::make_ready(const study::PlannedTrial &planned) {
    co_await presenter_.set_up(planned);
    presenter_.lead_to_start();
    stops_.begin_calm();
    bool is_lead_lost = false;
    while (true) {
        co_await wait_while_paused();
        stops_.watch();
        const servo::ServoSample &latest = session_.latest();
        const bool is_there = latest.health != device::DeviceHealth::lost && session_.is_zeroed();
        if (is_there && latest.safety.state == servo::SafetyState::running) {
            const bool has_taken_a_while = co_await warm_up();
            if (!has_taken_a_while) {
                co_return;
            }
            continue; // it took a while, in which anything may have happened
        }
        ParticipantPicture picture;
        if (!is_there) {
            state_.step = StudySessionStep::device_lost;
            picture.text = plan_.protocol.texts.device_lost;
            picture.is_calm_stop = true;
            stops_.begin_calm();
            is_lead_lost = true;
        } else if (latest.safety.state == servo::SafetyState::tripped) {
            state_.step = StudySessionStep::device_stopped;
            picture.text = plan_.protocol.texts.device_stopped;
            picture.is_calm_stop = true;
            stops_.reset_when_calm();
        } else {
            if (std::exchange(is_lead_lost, false)) {
                presenter_.lead_to_start(); // of a hand that is simulated anew
            }
            picture = presenter_.picture(StudySessionStep::setting_up);
            picture.text = latest.contact.touching ? plan_.protocol.texts.please_lift
                                                   : plan_.protocol.texts.rest_at_spot;
            picture.tip_m = latest.tip_m;
        }
        static_cast<void>(co_await show(picture));
    }
}

/// Feedback, which in the practice tells right from wrong. What is not stored does not come again.
Resumable<> StudySession::tell_of(const study::Trial &trial, bool is_stored) {
    const study::Texts &texts = plan_.protocol.texts;
    const std::optional<bool> is_right = study::is_correct(plan_.protocol.task, trial);
    state_.marks = trial.marks;
    for (const std::string &mark : study::marks_of(plan_.protocol.marking, trial.presentations)) {
        state_.marks.push_back(mark);
    }
    ParticipantPicture picture;
    if (!trial.safety_events.empty()) {
        co_return; // make_ready tells of it
    }
    const bool is_silent = std::holds_alternative<study::NoResponse>(trial.response);
    const bool comes_again =
        study::comes_again(plan_.protocol.marking, state_.marks, trial.response);
    if (comes_again || is_silent) {
        if (!is_stored) {
            co_return;
        }
        picture.text = comes_again ? texts.repeated : texts.too_slow;
    } else if (trial.is_practice && is_right) {
        picture.heading = *is_right ? texts.correct : texts.wrong;
    } else {
        co_return;
    }
    state_.step = StudySessionStep::after_response;
    co_await presenter_.wait(kFeedback_s, picture);
}

/// A stop in it is stored with it.
Resumable<std::optional<study::Trial>> StudySession::present_watched() {
    stops_.begin_trial();
    std::optional<study::Trial> trial = co_await presenter_.present();
    stops_.end_trial(trial && !trial->safety_events.empty());
    co_return trial;
}

/// Fills `presented_`.
Resumable<> StudySession::present(const study::PlannedTrial &planned) {
    co_await introduce(planned);
    std::optional<study::Trial> trial;
    while (!trial) { // if the device is lost, the trial begins anew when it is back
        co_await make_ready(planned);
        keep_noise();
        if (plan_.keeps_records) {
            session_.start_recording(store_.new_record_file(plan_.participant, planned.place),
                                     {Existing::replace, Readers::owner});
        }
        orders_.repeats = false;
        trial = co_await present_watched();
        session_.recording().stop();
    }
    co_await frames_.until_end(tell_of(*trial, true)); // what was answered is stored all the same
    if (std::exchange(orders_.repeats, false)) {
        trial->marks.emplace_back("repeated at the experimenter's wish");
        trial->is_presented_again = true;
    }
    if (plan_.keeps_records) {
        note_gaps_of_record();
        trial->record = store_.link_to(session_.recording().file());
    }
    const bool counts = state_.marks.empty() && trial->safety_events.empty() &&
                        !trial->is_presented_again &&
                        !std::holds_alternative<study::NoResponse>(trial->response);
    if (planned.is_practice && counts) {
        practised_.push_back(planned);
    }
    has_presented_ = true;
    ++since_break_;
    presented_ = std::move(trial);
}

/// A record that a slow disk has left incomplete is linked all the same.
void StudySession::note_gaps_of_record() {
    const record::RecorderStatus record = session_.recording().status();
    if (record.error.empty() && record.lost == 0) {
        return;
    }
    const std::string what =
        record.error.empty() ? fmt::format("{} ticks are missing", record.lost) : record.error;
    note("record", session_.recording().file().filename().string() + ": " + what);
}

study::Session StudySession::begun() const {
    study::Session begun;
    begun.participant = plan_.participant;
    begun.started = study::utc_now();
    begun.device = kind_of(session_.device_choice().kind);
    begun.device_name = session_.description().name;
    begun.device_serial = session_.device().identity().serial;
    begun.software = SPRINGDRIVE_VERSION;
    begun.host = machine_name();
    begun.facts = plan_.facts;
    if (noise_) {
        begun.facts.push_back({"noise_level_dBFS", plan_.protocol.noise->level_dBFS});
        begun.facts.push_back({"noise_output", noise_->device()});
    }
    return begun;
}

/// An output may have been pulled out, or its system restarted.
/// @throw InputError  there is none any more
void StudySession::keep_noise() {
    if (noise_ && !noise_->is_playing()) {
        note("noise", "the masking noise had stopped, and was begun again");
        noise_gaps_ += noise_->underruns();
        noise_.reset();
        noise_.emplace(plan_.protocol.noise->level_dBFS);
    }
}

/// It fades out. Gaps in it may have been heard.
void StudySession::end_noise() {
    if (!noise_) {
        return;
    }
    if (!noise_->is_playing()) {
        note("noise", "the masking noise had stopped");
    }
    noise_gaps_ += noise_->underruns();
    if (noise_gaps_ > 0) {
        note("noise", fmt::format("the masking noise had {} gaps", noise_gaps_));
    }
    noise_.reset();
}

void StudySession::note_trials() {
    state_.trials = study::trials_of(store_.contents(), plan_.participant);
    const double most = std::max(1, study::session_length(plan_.protocol).max_trials);
    state_.progress = std::min(1.0, static_cast<double>(state_.trials.size()) / most);
}

/// What is shown before the first trial, and between two.
Resumable<> StudySession::before_next() {
    if (!std::exchange(has_begun_, true)) {
        co_await begin();
    } else if (has_presented_) {
        state_.step = StudySessionStep::after_response;
        const ParticipantPicture nothing;
        co_await presenter_.wait(plan_.protocol.timing.between_trials_s, nothing);
    }
}

/// Who was stopped after the practice is asked then whether it was understood.
void StudySession::recall_practice() {
    const study::StudyContents contents = store_.contents();
    study::Sequence sequence(plan_.protocol,
                             study::participant_of(contents, plan_.participant).number);
    for (const study::Trial &trial : study::trials_of(contents, plan_.participant)) {
        if (trial.is_practice && !was_practising_) {
            practised_.clear();
        }
        was_practising_ = trial.is_practice;
        if (trial.is_practice && trial.marks.empty()) {
            practised_.push_back(trial);
        }
        sequence.add(trial);
    }
    has_trials_left_ = sequence.next().has_value();
}

void StudySession::start() {
    recall_practice();
    if (plan_.protocol.noise && plan_.plays_noise && has_trials_left_) {
        noise_.emplace(plan_.protocol.noise->level_dBFS); // or there is no session
    }
    begun_ = begun();
    begun_.id = store_.begin(begun_);
    state_.participant = plan_.participant;
    state_.session = begun_.id;
    frames_.start(whole());
}

/// Until the participant is through, or something ends it. @return how
Resumable<study::SessionEnding> StudySession::trials() {
    study::RunningSession running(store_, plan_.protocol, begun_);
    while (const std::optional<study::PlannedTrial> planned = running.next()) {
        if (!ending_) {
            note_trials();
            co_await frames_.until_end(before_next());
        }
        if (ending_) {
            co_return *ending_;
        }
        presented_.reset();
        const bool is_whole = co_await frames_.until_end(present(*planned));
        if (!is_whole) {
            session_.recording().stop();
            stops_.end_trial(false);
            note_practice();
            co_return *ending_;
        }
        if (const auto ending = running.add(*std::exchange(presented_, std::nullopt))) {
            co_return *ending;
        }
    }
    co_return co_await ask_after_last();
}

Resumable<> StudySession::whole() {
    const study::SessionEnding ending = co_await trials();
    store_.end(begun_.id, ending, study::utc_now());
    stored_ending_ = ending;
    const std::optional<study::SessionEnding> wished = std::exchange(ending_, std::nullopt);
    has_trials_left_ = false;
    session_.keep_released(true);
    end_noise();
    if (ending == study::SessionEnding::completed && !wished) {
        co_await frames_.until_end(say_goodbye());
    } else if (ending == study::SessionEnding::left || !wished ||
               ending == study::SessionEnding::safety_trip) {
        co_await frames_.until_end(let_go()); // by the participant's wish, or by a stopping rule
    }
}

/// How all that is shown ends now, if it does.
std::optional<study::SessionEnding> StudySession::ending_after_frame() const {
    const servo::SafetyStatus &safety = session_.latest().safety;
    if (state_.step == StudySessionStep::device_stopped && servo::is_final(safety.cause)) {
        return study::SessionEnding::failed;
    }
    if (stops_.count() > plan_.protocol.stopping.max_trips && has_trials_left_) {
        return study::SessionEnding::safety_trip;
    }
    return std::nullopt;
}

void StudySession::resume(StudySessionFrame frame) {
    stops_.watch();
    const ExperimenterOrders &orders = frame.orders;
    orders_.is_paused = orders.is_paused;
    orders_.repeats = orders_.repeats || orders.repeats;
    orders_.skips_to_break = orders_.skips_to_break || orders.skips_to_break;
    if (orders.resets_device && !orders.stops && !orders.participant_leaves) {
        stops_.let_go_on();
    }
    ending_ = orders.stops                ? study::SessionEnding::stopped
              : orders.participant_leaves ? study::SessionEnding::left
                                          : ending_after_frame();
    if (ending_) {
        frames_.end();
    } else {
        frames_.resume(std::move(frame));
    }
}

} // namespace springdrive::app::study_screen
