// A visitor's sitting is a participant's in which nobody looks after the visitor. This stands
// between the sitting and the window, and does what an experimenter would:
//
//   sitting ──picture──► buttons, "Still there?" ──► window
//   sitting ◄──inputs── answers of a visitor who is made up ◄── window
#pragma once

#include "app/study/sitting/sitting_port.h"
#include "base/vector.h"
#include "engine/session/session.h"
#include "engine/study/observers/simulated_sitting.h"
#include "engine/study/protocol/protocol.h"

#include <cstdint>
#include <optional>

namespace springdrive::app::visitors {

inline constexpr double kAskedAfter_s = 30.0; ///< without a sign of anybody: "Still there?"
inline constexpr double kGoneAfter_s = 40.0;

/// Whether a visitor is still there: somebody who acts, or moves the tip of a real device.
class Presence {
public:
    explicit Presence(double now_s = 0.0) : seen_s_(now_s) {}

    /// Once a frame. @param tip_m  of a real device; nothing of one whose hand is simulated
    void update(double now_s, bool has_acted, const std::optional<Vector3> &tip_m) {
        const bool has_moved = tip_m && (!tip_m_ || (*tip_m - *tip_m_).norm() > kMove_m);
        if (has_moved) {
            tip_m_ = tip_m;
        }
        if (has_acted || has_moved) {
            seen_s_ = now_s;
        }
    }
    [[nodiscard]] double away_s(double now_s) const { return now_s - seen_s_; }

private:
    static constexpr double kMove_m = 0.003; ///< more than a device that lies still drifts

    double seen_s_;
    std::optional<Vector3> tip_m_; ///< where it was when it was moved last
};

/// Why a sitting was ended from here.
enum class VisitEnd : std::uint8_t {
    none,
    asked,      ///< the window was closed, or the program is to end
    gone,       ///< nobody was there any more
    left,       ///< by Escape
    seen_enough ///< of a visitor who is made up
};

class VisitorPort final : public study_screen::SittingPort {
public:
    /// A visitor who is made up is shown for so many trials.
    static constexpr std::size_t kShownTrials = 3;

    /// @param window  and the others: must outlive this
    /// @param made_up  answers in the visitor's place; nothing: a visitor does
    VisitorPort(study_screen::SittingPort &window, session::Session &session,
                const study::Protocol &protocol,
                std::optional<study::SimulatedParticipant> made_up);

    study_screen::SittingFrame show(const study_screen::ParticipantPicture &picture,
                                    const study_screen::SittingState &state) override;
    void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot) override {
        window_.show_scene(scene, spot);
    }

    [[nodiscard]] VisitEnd end() const { return end_; }

private:
    [[nodiscard]] study_screen::ParticipantPicture
    for_visitors(study_screen::ParticipantPicture picture, study_screen::SittingStep step) const;
    /// Whether a visitor who may have gone is asked so.
    [[nodiscard]] bool is_asking() const;
    void act_made_up(const study_screen::SittingState &state, study_screen::SittingFrame &frame);
    void watch(study_screen::SittingFrame &frame);
    void stop(study_screen::SittingFrame &frame, VisitEnd why);

    study_screen::SittingPort &window_;
    session::Session &session_;
    const study::Protocol &protocol_;
    std::optional<study::SimulatedParticipant> made_up_;
    Presence presence_;
    std::uint32_t stop_;        ///< the last one requested here
    double step_since_s_ = 0.0; ///< since when the present step is shown
    study_screen::SittingStep step_ = study_screen::SittingStep::instructions;
    VisitEnd end_ = VisitEnd::none;
};

/// Someone did something: any press.
[[nodiscard]] bool has_acted(const std::vector<study_screen::ParticipantInput> &inputs);
/// A press of that key, or a click on the plate that shows it.
[[nodiscard]] bool is_pressed(const std::vector<study_screen::ParticipantInput> &inputs,
                              std::string_view key, std::size_t choice);

} // namespace springdrive::app::visitors
