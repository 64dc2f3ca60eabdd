#include "app/study/sitting/sitting.h"

#include "app/study/participant/answers.h"
#include "app/study/sitting/person_checks.h"
#include "base/input_error.h"
#include "base/machine_name.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/conduct/marking.h"
#include "engine/study/conduct/sequence.h"
#include "engine/study/protocol/session_length.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace springdrive::app::study_screen {

namespace {

constexpr double kFeedback_s = 1.2;

study::DeviceKind kind_of(factory::DeviceKind kind) {
    switch (kind) {
    case factory::DeviceKind::usb:
        return study::DeviceKind::usb;
    case factory::DeviceKind::emulated:
        return study::DeviceKind::emulated;
    case factory::DeviceKind::simulated:
        break;
    }
    return study::DeviceKind::simulated;
}

} // namespace

Sitting::Sitting(study::StudyStore &store, SittingPlan plan, session::Session &session,
                 SittingPort &port)
    : store_(store), plan_(std::move(plan)), session_(session), port_(port),
      presenter_({plan_.protocol, plan_.setting, plan_.folders, session_, port_, state_,
                  [this](ParticipantPicture picture) { return show(std::move(picture)); }}),
      stops_(session_, plan_.is_attended || !session_.device().device().can_reach_a_hand(),
             [this](const std::string &what) { note("safety", what); }) {
    if (const std::string wrong = what_keeps_persons_out(plan_.protocol, plan_.setting);
        !wrong.empty()) {
        throw InputError(wrong);
    }
    require_device_of_before();
}

/// Trials choose the levels of those after them: a person's must not go on with a rehearsal's.
void Sitting::require_device_of_before() const {
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

/// Every frame of a sitting.
SittingFrame Sitting::show(ParticipantPicture picture) {
    if (!picture.has_text_field) { // where the space bar writes
        picture.footer = plan_.protocol.texts.stop_key;
    }
    picture.progress = state_.progress;
    SittingFrame frame = port_.show(picture, state_);
    stops_.watch();
    if (frame.orders.stops) {
        throw Ends{study::SessionEnding::stopped};
    }
    if (frame.orders.participant_leaves) {
        throw Ends{study::SessionEnding::left};
    }
    orders_.is_paused = frame.orders.is_paused;
    orders_.repeats = orders_.repeats || frame.orders.repeats;
    orders_.skips_to_break = orders_.skips_to_break || frame.orders.skips_to_break;
    if (frame.orders.resets_device) {
        stops_.let_go_on();
    }
    if (stops_.count() > plan_.protocol.stopping.most_trips && has_trials_left_) {
        throw Ends{study::SessionEnding::safety_trip};
    }
    return frame;
}

void Sitting::show_for(double seconds, const ParticipantPicture &picture) {
    const double until_s = session_.servo().now_s() + seconds;
    while (session_.servo().now_s() < until_s) {
        static_cast<void>(show(picture));
    }
}

bool Sitting::is_answer_key(const std::vector<ParticipantInput> &inputs) const {
    return std::ranges::any_of(inputs, [this](const ParticipantInput &input) {
        const bool is_gesture = plan_.protocol.responses.device == study::ResponseDevice::gesture;
        return input.is_press &&
               (alternative_of(plan_.protocol.responses, input) || input.name == "enter" ||
                (is_gesture && input.source == InputSource::key));
    });
}

void Sitting::show_until_key(SittingStep step, const ParticipantPicture &picture) {
    state_.step = step;
    while (!is_answer_key(show(picture).inputs)) {
    }
}

void Sitting::note(const std::string &kind, const std::string &text) {
    store_.append(study::Note{study::utc_now(), kind, text, plan_.participant, state_.session});
}

/// Until the motors run.
void Sitting::make_ready(const study::PlannedTrial &planned) {
    presenter_.set_up(planned);
    presenter_.lead_to_start();
    stops_.begin_calm();
    bool is_lead_lost = false;
    while (true) {
        wait_while_paused();
        stops_.watch();
        const servo::ServoSample &latest = session_.latest();
        const bool is_there = latest.health != device::DeviceHealth::lost && session_.is_zeroed();
        if (is_there && latest.safety.state == servo::SafetyState::running) {
            if (!warm_up()) {
                return;
            }
            continue; // it took a while, in which anything may have happened
        }
        ParticipantPicture picture;
        if (!is_there) {
            state_.step = SittingStep::device_lost;
            picture.text = plan_.protocol.texts.device_lost;
            picture.is_calm_stop = true;
            stops_.begin_calm();
            is_lead_lost = true;
        } else if (latest.safety.state == servo::SafetyState::tripped) {
            state_.step = SittingStep::device_stopped;
            picture.text = plan_.protocol.texts.device_stopped;
            picture.is_calm_stop = true;
            if (servo::is_final(latest.safety.cause)) {
                throw Ends{study::SessionEnding::failed};
            }
            stops_.reset_when_calm();
        } else {
            if (std::exchange(is_lead_lost, false)) {
                presenter_.lead_to_start(); // of a hand that is simulated anew
            }
            picture = presenter_.picture(SittingStep::setting_up);
            picture.text = latest.contact.touching ? plan_.protocol.texts.please_lift
                                                   : plan_.protocol.texts.rest_at_spot;
            picture.tip_m = latest.tip_m;
        }
        static_cast<void>(show(picture));
    }
}

/// Feedback, which in the practice tells right from wrong. What is not stored does not come again.
void Sitting::tell_of(const study::Trial &trial, bool is_stored) {
    const study::Texts &texts = plan_.protocol.texts;
    const std::optional<bool> is_right = study::is_correct(plan_.protocol.task, trial);
    state_.marks = trial.marks;
    for (const std::string &mark : study::marks_of(plan_.protocol.marking, trial.presentations)) {
        state_.marks.push_back(mark);
    }
    ParticipantPicture picture;
    if (!trial.safety_events.empty()) {
        return; // make_ready tells of it
    }
    const bool is_silent = std::holds_alternative<study::NoResponse>(trial.response);
    const bool comes_again =
        study::comes_again(plan_.protocol.marking, state_.marks, trial.response);
    if (comes_again || is_silent) {
        if (!is_stored) {
            return;
        }
        picture.text = comes_again ? texts.repeated : texts.too_slow;
    } else if (trial.is_practice && is_right) {
        picture.heading = *is_right ? texts.correct : texts.wrong;
    } else {
        return;
    }
    state_.step = SittingStep::after_response;
    show_for(kFeedback_s, picture);
}

/// A stop in it is stored with it, or noted if it is not.
std::optional<study::Trial> Sitting::present_watched() {
    stops_.begin_trial();
    try {
        std::optional<study::Trial> trial = presenter_.present();
        stops_.end_trial(trial && !trial->safety_events.empty());
        return trial;
    } catch (const Ends &) {
        stops_.end_trial(false);
        throw;
    }
}

std::optional<study::Trial> Sitting::present(const study::PlannedTrial &planned) {
    try {
        introduce(planned);
        while (true) {
            make_ready(planned);
            keep_noise();
            if (plan_.keeps_records) {
                session_.start_recording(store_.new_record_file(plan_.participant, planned.place),
                                         {Existing::replace, Readers::owner});
            }
            orders_.repeats = false;
            std::optional<study::Trial> trial = present_watched();
            session_.recording().stop();
            if (!trial) {
                continue; // the device was lost: the trial begins anew when it is back
            }
            try {
                tell_of(*trial, true);
            } catch (const Ends &ends) { // what was answered is stored all the same
                ending_ = ends.how;
            }
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
            return trial;
        }
    } catch (const Ends &ends) {
        session_.recording().stop();
        ending_ = ends.how;
        return std::nullopt;
    }
}

/// A record that a slow disk has left incomplete is linked all the same.
void Sitting::note_gaps_of_record() {
    const record::RecorderStatus record = session_.recording().status();
    if (record.error.empty() && record.lost == 0) {
        return;
    }
    const std::string what =
        record.error.empty() ? fmt::format("{} ticks are missing", record.lost) : record.error;
    note("record", session_.recording().file().filename().string() + ": " + what);
}

study::Session Sitting::begun() const {
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
void Sitting::keep_noise() {
    if (noise_ && !noise_->is_playing()) {
        note("noise", "the masking noise had stopped, and was begun again");
        noise_gaps_ += noise_->underruns();
        noise_.reset();
        noise_.emplace(plan_.protocol.noise->level_dBFS);
    }
}

/// It fades out. Gaps in it may have been heard.
void Sitting::end_noise() {
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

void Sitting::note_trials() {
    state_.trials = study::trials_of(store_.contents(), plan_.participant);
    const double most = std::max(1, study::session_length(plan_.protocol).most_trials);
    state_.progress = std::min(1.0, static_cast<double>(state_.trials.size()) / most);
}

/// For `Conduct::ends`: what is shown before the first trial, and between two.
std::optional<study::SessionEnding> Sitting::ending_before_next() {
    if (ending_) {
        return ending_;
    }
    note_trials();
    try {
        if (!std::exchange(has_begun_, true)) {
            begin();
        } else if (has_presented_) {
            state_.step = SittingStep::after_response;
            show_for(plan_.protocol.timing.between_trials_s, {});
        }
    } catch (const Ends &ends) {
        ending_ = ends.how;
    }
    return ending_;
}

/// Who was stopped after the practice is asked then whether it was understood.
void Sitting::recall_practice() {
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

study::SessionEnding Sitting::run() {
    recall_practice();
    if (plan_.protocol.noise && plan_.plays_noise && has_trials_left_) {
        noise_.emplace(plan_.protocol.noise->level_dBFS); // or there is no session
    }
    study::Session session = begun();
    session.id = store_.begin(session);
    state_.participant = plan_.participant;
    state_.session = session.id;
    study::Conduct how;
    how.present = [this](const study::PlannedTrial &planned) { return present(planned); };
    how.ends = [this] { return ending_before_next(); };
    how.after_last = [this] { return ask_after_last(); };
    const study::SessionEnding ending = study::conduct(store_, plan_.protocol, session, how);
    has_trials_left_ = false;
    session_.keep_released(true);
    end_noise();
    if (ending == study::SessionEnding::completed && !ending_) {
        say_goodbye();
    } else if (ending == study::SessionEnding::left || !ending_ ||
               ending == study::SessionEnding::safety_trip) {
        let_go(); // by the participant's wish, or by a stopping rule
    }
    return ending;
}

} // namespace springdrive::app::study_screen
