// "Can you feel it?", one visitor after the other, unattended:
//
//   start ──► sitting ──► own curve ──► start
//     │         └ walked away ───────────► start
//     └► a visitor who is made up: three trials, the others reckoned, the curve ──► start
//
// A visit's trials are in a study in memory, which is gone when the next visitor begins: nothing of
// a visitor is in any file.
#pragma once

#include "app/study/sitting/sitting_port.h"
#include "app/visitors/visitor_port.h"
#include "engine/session/session.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/store/study_store.h"

#include <cstdint>
#include <optional>
#include <string>

namespace springdrive::app::visitors {

struct VisitsPlan {
    study::Protocol protocol; ///< a task for visitors, see curve_of_answers.h
    study::StudySetting setting;
    study::ProtocolFolders folders;
    study::PsychometricFunction made_up; ///< who answers where nobody feels anything
    bool has_device = false;             ///< that somebody holds: else nobody feels anything
    bool is_show = false;                ///< made-up visitors only, without anybody at the screen
};

/// Whose answers they are.
enum class Visitor : std::uint8_t {
    feels,   ///< a person at a device
    guesses, ///< a person, where there is nothing to feel
    made_up
};

class Visits {
public:
    static constexpr double kResult_s = 60.0;     ///< for which a curve stays without a press
    static constexpr double kShowResult_s = 15.0; ///< of a show

    /// @param session  started, with the protocol's device. All must outlive this
    Visits(VisitsPlan plan, session::Session &session, study_screen::SittingPort &window);

    /// Until the window asks to end.
    /// @throw InputError if the device has failed for good
    void run();

    /// Visits that were begun.
    [[nodiscard]] int begun() const { return begun_; }

private:
    [[nodiscard]] std::optional<Visitor> wait_for_visitor();
    [[nodiscard]] VisitEnd sit(study::StudyStore &store, Visitor visitor);
    [[nodiscard]] bool reckon_rest(study::StudyStore &store);
    void show_curve(const study::StudyContents &visit, Visitor visitor);
    [[nodiscard]] bool asks_to_end(const study_screen::ParticipantPicture &picture,
                                   study_screen::SittingStep step);
    [[nodiscard]] study::SimulatedParticipant made_up_visitor() const;

    VisitsPlan plan_;
    session::Session &session_;
    study_screen::SittingPort &window_;
    study_screen::SittingFrame last_; ///< what the last frame gave
    int begun_ = 0;
    bool is_over_ = false;
};

} // namespace springdrive::app::visitors
