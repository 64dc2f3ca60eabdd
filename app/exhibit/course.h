// The course of an exhibit, as pure logic: which scene is shown, by whom, and when the next visitor
// begins.
//
//   attract ──touched──► showing ──shown, or hand taken──► your turn ──next scene──► showing
//      ▲                                                       │
//      └──────── nobody is there any more; or a gap in time ◄──┘
//
// In `attract` the scripted hand goes from scene to scene. Time is by a clock that also runs while
// the computer sleeps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace springdrive::app::exhibit {

enum class Stage : std::uint8_t { attract, showing, your_turn };

/// What the course depends on, of one frame.
struct CourseNow {
    double time_s = 0.0;
    bool is_touched = false;   ///< the visitor did anything
    bool takes_hand = false;   ///< the visitor takes the hand, or asks for it
    bool next_scene = false;   ///< asked for
    bool next_visitor = false; ///< asked for
    bool is_ready = false;     ///< the scene is there, and the motors run
    bool is_shown = false;     ///< the scripted hand, begun by `performs`, is at its end
};

/// What is to be done in this frame.
struct CourseOrders {
    std::optional<std::size_t> scene; ///< to be shown from now on
    bool resets = false;              ///< hand, view and gains
    bool performs = false;            ///< the scripted hand begins
    bool leaves = false;              ///< the scripted hand ends where it is
    bool visit_begins = false;
    double gap_s = 0.0; ///< for which time passed without a frame; 0: it did not
};

class Course {
public:
    static constexpr double kIdle_s = 45.0;        ///< until it is asked whether somebody is there
    static constexpr double kIdlePrompt_s = 10.0;  ///< for which that is asked
    static constexpr double kLoadTimeout_s = 20.0; ///< with a scene that does not get ready
    static constexpr double kBetween_s = 2.0;      ///< scenes, in `attract`
    static constexpr double kGap_s = 15.0;         ///< between frames: the computer slept

    /// @param scenes  their number, at least 1; the first is shown
    explicit Course(std::size_t scenes) : scenes_(scenes) {}

    CourseOrders update(const CourseNow &now);

    [[nodiscard]] Stage stage() const { return stage_; }
    [[nodiscard]] std::size_t scene() const { return scene_; }
    [[nodiscard]] std::size_t visitors() const { return visitors_; } ///< so far
    [[nodiscard]] bool is_performing() const { return is_performing_; }
    /// Until the visit ends unless something is touched, while that is asked.
    [[nodiscard]] std::optional<double> leaves_in_s() const { return leaves_in_s_; }

private:
    void enter(Stage stage, double time_s);
    void show(std::size_t scene, CourseOrders &orders, double time_s);
    void begin_visit(CourseOrders &orders, double time_s);
    void end_visit(CourseOrders &orders, double time_s);
    void stop_performing(CourseOrders &orders);
    void attract(const CourseNow &now, CourseOrders &orders);
    void show_scene(const CourseNow &now, CourseOrders &orders);
    void let_visitor(const CourseNow &now, CourseOrders &orders);
    void perform(const CourseNow &now, CourseOrders &orders);
    [[nodiscard]] bool never_begins(const CourseNow &now) const;

    std::size_t scenes_;
    std::size_t scene_ = 0;
    std::size_t visitors_ = 0;
    Stage stage_ = Stage::attract;
    bool is_performing_ = false;
    double since_s_ = 0.0; ///< of the stage, or of the scene in it
    double touched_s_ = 0.0;
    std::optional<double> shown_s_;  ///< in `attract`: when the scripted hand came to its end
    std::optional<double> before_s_; ///< time of the last frame
    std::optional<double> leaves_in_s_;
};

} // namespace springdrive::app::exhibit
