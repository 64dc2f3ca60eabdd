// A visitor's sitting is a participant's in which nobody looks after the visitor. This is what is
// done between the sitting and the window in place of an experimenter:
//
//   sitting ──picture──► buttons, "Still there?" ──► window
//   sitting ◄──inputs── answers of a visitor who is made up ◄── window
#pragma once

#include "app/study/participant/participant_picture.h"
#include "app/study/sitting/sitting_frame.h"
#include "app/study/sitting/sitting_state.h"
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
    gone,       ///< nobody was there any more
    left,       ///< by Escape
    seen_enough ///< of a visitor who is made up
};

class UnattendedVisit {
public:
    /// A visitor who is made up is shown for so many trials.
    static constexpr std::size_t kShownTrials = 3;

    /// @param session  and the protocol: must outlive this
    /// @param made_up  answers in the visitor's place; nothing: a visitor does
    UnattendedVisit(session::Session &session, const study::Protocol &protocol,
                    std::optional<study::SimulatedParticipant> made_up);

    /// What is shown of a sitting's picture. With a mouse all can be done by its left button.
    [[nodiscard]] study_screen::ParticipantPicture
    for_visitors(study_screen::ParticipantPicture picture, study_screen::SittingStep step);

    /// What a sitting gets of the frame in which that was shown.
    [[nodiscard]] study_screen::SittingFrame for_sitting(study_screen::SittingFrame frame,
                                                         const study_screen::SittingState &state);

    [[nodiscard]] VisitEnd end() const { return end_; }

private:
    /// Whether a visitor who may have gone is asked so.
    [[nodiscard]] bool is_asking() const;
    void act_made_up(const study_screen::SittingState &state, study_screen::SittingFrame &frame);
    void watch(study_screen::SittingFrame &frame);
    void stop(study_screen::SittingFrame &frame, VisitEnd why);

    session::Session &session_;
    const study::Protocol &protocol_;
    std::optional<study::SimulatedParticipant> made_up_;
    Presence presence_;
    std::uint32_t stop_;        ///< the last one requested here
    double step_since_s_ = 0.0; ///< since when the present step is shown
    study_screen::SittingStep step_ = study_screen::SittingStep::instructions;
    bool was_asked_ = false; ///< in the present frame, whether somebody is still there
    VisitEnd end_ = VisitEnd::none;
};

/// Someone did something: any press.
[[nodiscard]] bool has_acted(const std::vector<study_screen::ParticipantInput> &inputs);
/// A press of that key, or a click on the plate that shows it.
[[nodiscard]] bool is_pressed(const std::vector<study_screen::ParticipantInput> &inputs,
                              std::string_view key, std::size_t choice);

} // namespace springdrive::app::visitors
