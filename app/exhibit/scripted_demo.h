// Shows the tour's scenes one at a time, each by its scripted hand.
//
//   show ──► scene loaded, gains of the start ──► is_ready ──► perform ──► is_shown
#pragma once

#include "app/exhibit/course.h"
#include "app/exhibit/tour.h"
#include "app/panels/tuning_editor.h"
#include "app/stage/touch_by_click.h"
#include "engine/session/session.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::app::exhibit {

/// What it acts on; of the screen.
struct ScriptContext {
    session::Session &session;
    TuningEditor &editor;
    HandLift &lift;
};

class ScriptedDemo {
public:
    /// The present scene and gains are those of the start.
    explicit ScriptedDemo(const session::Session &session)
        : tuning_(session.tuning().now()), wanted_(session.scenes().now().scene.file) {}

    /// Requests the scene, with the gains of the start.
    void show(const ScriptContext &stage, const TourStop &stop);

    [[nodiscard]] bool has_scene(const session::Session &session) const {
        return session.scenes().now().scene.file == wanted_;
    }

    /// What the course depends on, of scene, motors and scripted hand.
    [[nodiscard]] CourseNow now(const session::Session &session, double time_s) const;
    /// Once a frame: the orders about scene and scripted hand. With a real hand nothing moves for
    /// some seconds.
    void carry_out(const CourseOrders &orders, const Course &course, const ScriptContext &stage,
                   double time_s);
    /// The scripted hand stops where it is.
    void leave(const ScriptContext &stage);

    void restore_gains(const ScriptContext &stage) const;

    /// Why the hand did not act; else empty.
    [[nodiscard]] std::string take_error() { return std::exchange(error_, {}); }

private:
    void perform(const ScriptContext &stage, const TourStop &stop, double time_s);
    void switch_map_if_due(const ScriptContext &stage);

    control::Tuning tuning_; ///< of the start
    std::filesystem::path wanted_;
    std::optional<Showing> showing_;
    double began_s_ = 0.0;       ///< by the session's time
    double words_until_s_ = 0.0; ///< without a scripted hand
    std::size_t switched_ = 0;   ///< maps, in this showing
    std::string error_;
};

/// The tour in the ordinary window: the scripted hand goes through all scenes once, until Escape.
class Guide {
public:
    void begin(const ScriptContext &stage);
    void end(const ScriptContext &stage);
    [[nodiscard]] bool is_on() const { return course_.has_value(); }

    /// Once a frame. @param time_s  by any clock of the window
    void update(const ScriptContext &stage, double time_s);

private:
    std::optional<Course> course_;
    std::optional<ScriptedDemo> script_;
    bool had_scene_ = false; ///< that it shows
};

} // namespace springdrive::app::exhibit
