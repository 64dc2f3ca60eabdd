#include "app/study/session/trial_presenter.h"

#include "app/study/participant/answers.h"
#include "base/input_error.h"
#include "engine/servo/safety_monitor.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace springdrive::app::study_screen {

namespace {

constexpr double kAdjustingSteps = 60.0; ///< from one end of an adjustment to the other

bool has_scene(const study::Condition &condition) { return condition.scene != study::kNoScene; }

/// From the end of the rest on, which takes as long as it takes.
simulated::HandPath path_after_rest(const study::HandTrajectory &trajectory,
                                    const study::Stimulus &stimulus) {
    constexpr double kRoundOff_s = 1e-9;
    std::vector<simulated::HandPath::Point> points{{0.0, stimulus.start_m}};
    for (const simulated::HandPath::Point &point : trajectory.points) {
        const double time_s = point.time_s - study::kServoStart_s - stimulus.rest_s;
        if (time_s > kRoundOff_s) {
            points.push_back({time_s, point.position_m});
        }
    }
    return simulated::HandPath(std::move(points));
}

} // namespace

/// A movement that is an answer: from where the tip rested first, and to the side, since a hand
/// that leaves the surface goes on for a while. Not in the unnamed namespace, as coroutines hold
/// it.
class AnswerByGesture {
public:
    /// @param way_off  unit, or zero: what is moved along it tells nothing
    AnswerByGesture(double now_s, Vector3 way_off) : way_off_(std::move(way_off)), seen_s_(now_s) {}

    /// Each frame. Zero until it has rested.
    [[nodiscard]] Vector3 moved_m(const servo::ServoSample &sample, double now_s) {
        rest_.set_period(now_s - std::exchange(seen_s_, now_s));
        rest_.update(sample.tip_m, sample.contact.touching);
        if (!has_rested_) {
            has_rested_ = rest_.is_at_rest();
            from_m_ = sample.tip_m;
        }
        const Vector3 moved_m = sample.tip_m - from_m_;
        return moved_m - moved_m.dot(way_off_) * way_off_;
    }

private:
    Vector3 way_off_;
    servo::RestDetector rest_{0.0}; ///< its ticks are frames
    bool has_rested_ = false;
    Vector3 from_m_{Vector3::Zero()};
    double seen_s_;
};

TrialPresenter::~TrialPresenter() {
    it_.session.servo().follow(nullptr);
    // No thread of the servo may still use the last one.
    it_.session.servo().paused([] {});
}

bool TrialPresenter::is_device_lost() const {
    const servo::ServoSample &latest = it_.session.latest();
    return latest.health == device::DeviceHealth::lost ||
           (latest.safety.state == servo::SafetyState::tripped &&
            latest.safety.cause == servo::TripCause::device_lost);
}

ParticipantPicture TrialPresenter::picture(StudySessionStep step) const {
    it_.state.step = step;
    ParticipantPicture picture;
    picture.heading = it_.protocol.texts.question;
    picture.scene = shown_scene_.empty() ? SceneShown::nothing : SceneShown::scene;
    return picture;
}

Resumable<> TrialPresenter::wait(double seconds, const ParticipantPicture &shown) {
    const double until_s = it_.session.servo().now_s() + seconds;
    while (it_.session.servo().now_s() < until_s) {
        static_cast<void>(co_await it_.show(shown));
    }
}

Resumable<> TrialPresenter::load(const std::filesystem::path &scene) {
    session::Session &session = it_.session;
    if (session.scenes().now().scene.file == scene) {
        co_return;
    }
    session.request_scene(scene);
    while (session.scenes().now().scene.file != scene) {
        if (!session.scenes().error().empty()) {
            throw InputError(session.scenes().error());
        }
        static_cast<void>(co_await it_.show(picture(StudySessionStep::setting_up)));
    }
}

Resumable<> TrialPresenter::set_up(const study::PlannedTrial &planned) {
    trial_ = study::Trial(planned);
    intervals_ = study::intervals_of(it_.protocol, planned);
    co_await set_up(intervals_.front());
}

Resumable<> TrialPresenter::set_up(const study::Presented &presented) {
    const study::Condition &condition = presented.parameters;
    session::Session &session = it_.session;
    if (session.servo().rate_hz() != condition.servo_hz) {
        session.set_servo_rate(condition.servo_hz);
    }
    if (session.device().has_world() &&
        session.simulation().delay_periods != condition.delay_periods) {
        session.set_delay(condition.delay_periods);
    }
    const scene::TouchSpot &spot = it_.setting.conditions[presented.condition].spot;
    if (!has_scene(condition)) {
        shown_scene_.clear();
        session.servo().touch_nothing();
        session.tuning().replace(presented.free_space, session.plot_time_s(),
                                 "of an interval in free space");
        co_return;
    }
    if (shown_scene_ != condition.scene) {
        const std::filesystem::path file = study::scene_file_of(condition, it_.folders);
        co_await load(file);
        shown_scene_ = condition.scene;
        shown_spot_.reset();
    }
    if (!shown_spot_ || shown_spot_->point_m != spot.point_m ||
        shown_spot_->normal != spot.normal) {
        shown_spot_ = spot;
        it_.show_scene(session.scenes().now().scene, spot);
    }
    session.servo().touch(session.scenes().now().surface, session.scenes().id(),
                          presented.free_space);
}

void TrialPresenter::lead_to_start() {
    if (!it_.session.hand().is_simulated()) {
        return;
    }
    const Vector3 start_m =
        study::stimulus_of(it_.protocol, it_.setting, intervals_.front()).start_m;
    it_.session.follow_path(simulated::HandPath({{0.0, start_m}}));
}

/// The same for every condition and level: from the touch until the hand has left, the ball stays
/// at the spot, wherever the tip yields to. A stroke is in free space.
ParticipantPicture TrialPresenter::interval_picture(const study::Presented &presented) const {
    ParticipantPicture shown = picture(StudySessionStep::interval);
    const study::Texts &texts = it_.protocol.texts;
    if (it_.protocol.task.kind == study::TaskKind::forced_choice_by_interval) {
        shown.heading = it_.state.interval == 0   ? texts.first_interval
                        : it_.state.interval == 1 ? texts.second_interval
                                                  : fmt::format("{}", it_.state.interval + 1);
    } else if (!presented.level) {
        shown.heading = texts.show_standard;
    }
    const study::StimulusPhase phase = live_->phase();
    if (phase == study::StimulusPhase::waiting) {
        shown.text = texts.rest_at_spot;
    } else if (phase == study::StimulusPhase::leaving &&
               it_.protocol.stimulus != study::StimulusForm::stroke) {
        shown.text = texts.please_lift; // or nothing would say that it was enough
    }
    const bool is_in_contact =
        it_.protocol.stimulus != study::StimulusForm::stroke &&
        (phase == study::StimulusPhase::presenting || phase == study::StimulusPhase::gliding_back ||
         phase == study::StimulusPhase::leaving);
    if (shown.scene == SceneShown::scene) {
        const std::size_t condition = study::condition_of(it_.protocol, trial_);
        shown.tip_m = is_in_contact ? it_.setting.conditions[condition].spot.point_m
                                    : it_.session.latest().tip_m;
    }
    return shown;
}

/// Steps of an adjustment; its last key ends the presentation.
void TrialPresenter::adjust(const std::vector<ParticipantInput> &inputs) {
    const auto &method = std::get<study::Adjustment>(it_.protocol.method);
    const double least = study::on_scale(method.scale, method.minimum_level);
    const double most = study::on_scale(method.scale, method.maximum_level);
    for (const ParticipantInput &input : inputs) {
        const std::optional<std::size_t> key = alternative_of(it_.protocol.responses, input);
        if (!key || live_->phase() != study::StimulusPhase::presenting) {
            continue;
        }
        if (*key == 2) {
            is_adjusted_ = true;
            live_->finish();
            return;
        }
        const double step = (*key == 0 ? -1.0 : 1.0) * (most - least) / kAdjustingSteps;
        adjusted_ = study::level_from(
            method.scale,
            std::clamp(study::on_scale(method.scale, *adjusted_) + step, least, most));
        live_->set_contact(
            study::comparison_at(it_.protocol, trial_, *adjusted_).parameters.tuning);
    }
}

/// Presents one interval. @return false if the device was lost in the midst of it
Resumable<bool> TrialPresenter::feel(const study::Presented &presented) {
    co_await set_up(presented);
    session::Session &session = it_.session;
    const study::Stimulus stimulus = study::stimulus_of(it_.protocol, it_.setting, presented);
    retired_.push_back(std::move(live_));
    live_ = std::make_unique<study::LiveStimulus>(session.description(), stimulus,
                                                  session.servo().period_s());
    early_.clear();
    std::optional<simulated::HandPath> path;
    if (session.hand().is_simulated()) {
        session.follow_path(simulated::HandPath({{0.0, stimulus.start_m}}));
        path = path_after_rest(
            study::hand_trajectory(it_.setting, presented, stimulus, study::HandDeviation{}),
            stimulus);
    }
    session.servo().follow(live_.get());
    const bool adjusts =
        it_.protocol.task.kind == study::TaskKind::adjustment && presented.level.has_value();
    while (!live_->is_over()) {
        it_.state.phase = live_->phase();
        if (path && it_.state.phase != study::StimulusPhase::waiting) {
            session.follow_path(*std::exchange(path, std::nullopt));
        }
        const StudySessionFrame frame = co_await it_.show(interval_picture(presented));
        if (adjusts) {
            adjust(frame.inputs);
        }
        // An answer may be given before the hand has left.
        early_.insert(early_.end(), frame.inputs.begin(), frame.inputs.end());
        if (is_device_lost()) {
            co_return false;
        }
    }
    retired_.clear(); // the servo has taken up the last one
    study::DeliveredStimulus delivered = live_->delivered();
    if (session.device().device().clock() == device::DeviceClock::servo) {
        delivered.lateness_s = 0.0; // it waits for the servo: the stimulus is none the later
    }
    study::Presentation presentation = study::presentation_of(
        study::intended_measures(it_.protocol, it_.setting, presented), delivered);
    if (adjusts) { // the level changed while it was felt: only to be in time is intended
        for (study::StimulusValue &value : presentation.values) {
            if (value.name != "lateness_s") {
                value.intended.reset();
            }
        }
    }
    presentation.start_s = live_->began_s();
    presentation.end_s = live_->ended_s();
    ended_s_ = live_->ended_s();
    if (live_->failure() == study::StimulusFailure::tripped) {
        trial_.safety_events.push_back({live_->failed_s(), servo::description(live_->trip())});
    } else if (live_->failure() != study::StimulusFailure::none) {
        trial_.marks.emplace_back(study::description(live_->failure()));
    }
    trial_.missed_deadlines += delivered.missed_deadlines;
    trial_.windings_degC = {delivered.winding_C[0], delivered.winding_C[1], delivered.winding_C[2]};
    if (presented.level) {
        trial_.tuning = study::settings_of(presented.parameters);
    }
    trial_.presentations.push_back(std::move(presentation));
    co_return true;
}

/// The way off the surface that was touched last; zero in free space.
Vector3 TrialPresenter::way_off() const {
    if (it_.protocol.stimulus == study::StimulusForm::stroke) {
        return Vector3::Zero();
    }
    return it_.setting.conditions[intervals_.back().condition].spot.normal;
}

void TrialPresenter::answer(std::size_t alternative, double time_s) {
    trial_.response = response_of(it_.protocol.task, alternative);
    trial_.response_time_s = time_s;
}

/// A stop is stored with the trial, unanswered. @return false if the device was lost meanwhile
Resumable<bool> TrialPresenter::ask() {
    ParticipantPicture shown = picture(StudySessionStep::response);
    shown.text = it_.protocol.texts.respond;
    shown.choices = choices_of(it_.protocol);
    std::vector<ParticipantInput> inputs = std::exchange(early_, {});
    AnswerByGesture gesture(it_.session.servo().now_s(), way_off());
    // Whoever holds on after the end is asked later, and has as long to answer.
    const double until_s =
        std::max(ended_s_, it_.session.servo().now_s()) + it_.protocol.timing.response_s;
    while (true) {
        const double now_s = it_.session.servo().now_s();
        if (is_device_lost()) {
            co_return false;
        }
        if (const servo::SafetyStatus &safety = it_.session.latest().safety;
            safety.state == servo::SafetyState::tripped) {
            trial_.safety_events.push_back({now_s, servo::description(safety)});
            co_return true;
        }
        for (const ParticipantInput &input : inputs) {
            const std::optional<std::size_t> given = alternative_of(it_.protocol.responses, input);
            const double after_s = input.clock_s - ended_s_;
            if (given && after_s >= 0.0 && input.clock_s <= until_s) {
                answer(*given, after_s);
                co_return true;
            }
        }
        if (now_s > until_s) {
            co_return true;
        }
        const Vector3 moved_m = gesture.moved_m(it_.session.latest(), now_s);
        if (const auto moved = alternative_of(it_.protocol.responses, moved_m)) {
            answer(*moved, now_s - ended_s_);
            co_return true;
        }
        inputs = (co_await it_.show(shown)).inputs;
    }
}

Resumable<std::optional<study::Trial>> TrialPresenter::present() {
    it_.state.trial = trial_;
    it_.state.intervals = intervals_.size();
    it_.state.marks.clear();
    is_adjusted_ = false;
    adjusted_ = trial_.level;
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
        it_.state.interval = i;
        if (i > 0) {
            const ParticipantPicture shown = picture(StudySessionStep::between_intervals);
            co_await wait(it_.protocol.timing.pause_s, shown);
        }
        const bool is_felt = co_await feel(intervals_[i]);
        if (!is_felt) {
            co_return std::nullopt;
        }
        if (!trial_.safety_events.empty() || !trial_.marks.empty()) {
            co_return trial_; // there is nothing to answer to
        }
    }
    if (it_.protocol.task.kind == study::TaskKind::adjustment) {
        if (is_adjusted_) {
            trial_.response = study::Adjusted{*adjusted_};
            trial_.tuning = study::settings_of(
                study::comparison_at(it_.protocol, trial_, *adjusted_).parameters);
        }
        co_return trial_;
    }
    const bool is_asked = co_await ask();
    co_return is_asked ? std::optional(trial_) : std::nullopt;
}

} // namespace springdrive::app::study_screen
