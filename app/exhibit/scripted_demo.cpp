#include "app/exhibit/scripted_demo.h"

#include "base/error_text.h"

#include <utility>

namespace springdrive::app::exhibit {

namespace {

constexpr double kWords_s = 8.0;      ///< for a scene that no hand shows
constexpr double kPathBegins_s = 0.2; ///< see Session::follow_path: from here to its first point

} // namespace

void ScriptedDemo::show(const ScriptContext &stage, const TourStop &stop) {
    restore_gains(stage);
    wanted_ = file_of(stop);
    if (stage.session.scenes().is_loading() || !has_scene(stage.session)) {
        stage.session.request_scene(wanted_);
    }
}

/// The lock is for changes by hand: back to the start one may always go.
void ScriptedDemo::restore_gains(const ScriptContext &stage) const {
    if (stage.session.tuning().now() == tuning_) {
        return;
    }
    const bool was_unlocked = std::exchange(stage.editor.is_unlocked, true);
    stage.editor.replace(tuning_, "of the start");
    stage.editor.is_unlocked = was_unlocked;
}

CourseNow ScriptedDemo::now(const session::Session &session, double time_s) const {
    const session::Scenes &scenes = session.scenes();
    CourseNow now;
    now.time_s = time_s;
    now.is_ready = !scenes.is_loading() && has_scene(session) &&
                   session.latest().scene_id == scenes.id() && !session.is_exchanging() &&
                   session.latest().safety.state == servo::SafetyState::running;
    now.is_shown = showing_ ? !session.hand().follows_path() : time_s >= words_until_s_;
    return now;
}

void ScriptedDemo::carry_out(const CourseOrders &orders, const Course &course,
                             const ScriptContext &stage, double time_s) {
    if (orders.leaves) {
        leave(stage);
    }
    if (orders.scene) {
        show(stage, kTour[*orders.scene]);
    }
    if (orders.performs) {
        perform(stage, kTour[course.scene()], time_s);
    }
    if (course.is_performing()) {
        switch_map_if_due(stage);
    }
}

void ScriptedDemo::perform(const ScriptContext &stage, const TourStop &stop, double time_s) {
    session::Session &session = stage.session;
    stage.lift.stop();
    showing_.reset();
    switched_ = 0;
    words_until_s_ = time_s + kWords_s;
    if (!session.hand().is_simulated()) {
        return;
    }
    const session::LoadedScene &scene = session.scenes().now();
    std::optional<Showing> showing = showing_of(session.description(), scene.scene, scene.surface,
                                                stop.gesture, session.hand().target_m());
    if (!showing) {
        error_ = std::string(stop.scene) + ": the scripted hand does not reach it";
        return;
    }
    error_ = error_text_of([&] {
        session.follow_path(showing->path);
        began_s_ = session.latest().time_s + kPathBegins_s;
        showing_ = std::move(showing);
    });
}

void ScriptedDemo::switch_map_if_due(const ScriptContext &stage) {
    if (!showing_ || switched_ >= showing_->switches_s.size()) {
        return;
    }
    if (stage.session.latest().time_s - began_s_ >= showing_->switches_s[switched_]) {
        ++switched_;
        stage.editor.toggle_map();
    }
}

void ScriptedDemo::leave(const ScriptContext &stage) {
    showing_.reset();
    if (stage.session.hand().follows_path()) {
        stage.session.leave_path();
    }
}

void Guide::begin(const ScriptContext &stage) {
    script_.emplace(stage.session);
    course_.emplace(kTour.size());
    script_->show(stage, kTour.front());
    had_scene_ = false;
}

void Guide::end(const ScriptContext &stage) {
    if (is_on()) {
        script_->leave(stage);
        script_->restore_gains(stage);
        course_.reset();
    }
}

void Guide::update(const ScriptContext &stage, double time_s) {
    if (!is_on()) {
        return;
    }
    const bool has_scene = script_->has_scene(stage.session);
    if (had_scene_ && !has_scene && !stage.session.scenes().is_loading()) {
        end(stage); // somebody wanted another one
        return;
    }
    had_scene_ = had_scene_ || has_scene;
    const std::size_t before = course_->scene();
    const CourseOrders orders = course_->update(script_->now(stage.session, time_s));
    if (orders.scene && before + 1 == kTour.size()) {
        end(stage); // all were shown
        return;
    }
    had_scene_ = had_scene_ && !orders.scene;
    script_->carry_out(orders, *course_, stage, time_s);
}

} // namespace springdrive::app::exhibit
