// Presents a planned trial to whoever holds the device, and takes the answer.
//
//   set up ──► interval ──► pause ──► interval ──► question ──► feedback
//                 │
//                 └ rest at the spot, approach, presentation, way back: StimulusRun
//
// A hand that is simulated is led by the trajectory of a simulated participant's; a person's is
// not.
#pragma once

#include "app/study/session/resumable.h"
#include "app/study/session/study_session_state.h"
#include "engine/scene/scene.h"
#include "engine/session/session.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace springdrive::app::study_screen {

/// Takes the scene of the pictures that show one, and the spot marked in it, from now on.
using ShowsScene = std::function<void(const scene::Scene &, const scene::TouchSpot &)>;

/// What the presenter sits in.
struct Presenting {
    const study::Protocol &protocol;
    const study::StudySetting &setting;
    study::ProtocolFolders folders;
    session::Session &session;
    StudySessionState &state;
    ShowsScene show_scene;
    /// To be awaited.
    std::function<Frames::Next(ParticipantPicture)> show;
};

class TrialPresenter {
public:
    /// @param presenting  what it refers to must outlive this object
    explicit TrialPresenter(Presenting presenting) : it_(std::move(presenting)) {}
    ~TrialPresenter();
    TrialPresenter(const TrialPresenter &) = delete;
    TrialPresenter &operator=(const TrialPresenter &) = delete;

    /// The trial that comes next. Scene, servo rate and delay of its first interval, so that the
    /// device can start.
    [[nodiscard]] Resumable<> set_up(const study::PlannedTrial &planned);

    /// The trial that was set up, filled to its response and time. Nothing if the device was lost
    /// in the midst of it. @pre the motors run
    [[nodiscard]] Resumable<std::optional<study::Trial>> present();

    /// The standard picture of an interval: scene, or nothing.
    [[nodiscard]] ParticipantPicture picture(StudySessionStep step) const;

    /// Shows the picture for that time.
    [[nodiscard]] Resumable<> wait(double seconds, const ParticipantPicture &shown);

    /// Leads a simulated hand to where the trial's intervals start.
    void lead_to_start();

private:
    [[nodiscard]] Resumable<> load(const std::filesystem::path &scene);
    [[nodiscard]] Resumable<> set_up(const study::Presented &presented);
    [[nodiscard]] Resumable<bool> feel(const study::Presented &presented);
    [[nodiscard]] ParticipantPicture interval_picture(const study::Presented &presented) const;
    [[nodiscard]] Vector3 way_off() const;
    [[nodiscard]] Resumable<bool> ask();
    void answer(std::size_t alternative, double time_s);
    void adjust(const std::vector<ParticipantInput> &inputs);
    [[nodiscard]] bool is_device_lost() const;

    Presenting it_;
    study::Trial trial_;                        ///< the present one, so far
    std::vector<study::Presented> intervals_;   ///< of it
    std::unique_ptr<study::LiveStimulus> live_; ///< the last one
    /// Those before, which the servo may use until it has taken the last one up.
    std::vector<std::unique_ptr<study::LiveStimulus>> retired_;
    std::string shown_scene_; ///< a condition's; empty: none
    std::optional<scene::TouchSpot> shown_spot_;
    double ended_s_ = 0.0;                ///< of the last presentation
    std::vector<ParticipantInput> early_; ///< since its end
    std::optional<double> adjusted_;      ///< level set so far
    bool is_adjusted_ = false;
};

} // namespace springdrive::app::study_screen
