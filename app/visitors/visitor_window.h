// The one window of the visitors' task: the participant's, on whatever screen visitors have.
#pragma once

#include "app/stage/frame_loop.h"
#include "app/study/participant/participant_window.h"
#include "app/study/sitting/sitting_state.h"
#include "engine/session/session.h"

#include <set>
#include <string>
#include <vector>

namespace springdrive::app::visitors {

/// Ctrl+Alt+Q, a signal and the end of the display ask to end; Ctrl+Alt+Z says that the device is
/// held in its zero pose.
class VisitorWindow {
public:
    /// @param session  must outlive it. @throw InputError if no window can be opened
    VisitorWindow(const study_screen::ParticipantWindow::Wish &wish, session::Session &session)
        : session_(session), window_(wish) {}

    /// Shows this for a frame.
    study_screen::SittingFrame show(const study_screen::ParticipantPicture &picture,
                                    const study_screen::SittingState &state);
    [[nodiscard]] ReportedWindow reported() const { return {window_.framebuffer()}; }
    /// See ShowsScene.
    void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot);

private:
    void obey_staff(const std::vector<study_screen::ParticipantInput> &inputs);
    void report(const study_screen::ParticipantPicture &picture,
                const study_screen::SittingState &state) const;

    session::Session &session_;
    study_screen::ParticipantWindow window_;
    std::set<std::string> held_keys_; ///< ctrl and alt
    bool is_asked_to_end_ = false;
};

} // namespace springdrive::app::visitors
