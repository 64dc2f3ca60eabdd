// The participant's window, beside the experimenter's or by itself: it shows what a ParticipantView
// has drawn and reports what the participant does.
//
// Pacing. A swap that waits for the display blocks the thread, and one thread draws both windows:
// two swaps that wait would halve the rate, and beat where the displays' rates differ. So only the
// participant's swap waits (interval 1): what is seen there must not tear, and its frames mark the
// times of a trial. The experimenter's window swaps at once (interval 0). Where the participant's
// swap does not wait (no vertical synchronisation, a hidden window, a monitor that is away), `show`
// itself keeps to the monitor's rate by the clock, so that the loop never spins.
//
// Events. A response time is as good as the time at which its event is noted. So what is left of a
// frame is spent waiting for events, up to 3 ms before the display takes the picture, not in the
// swap: an event is late only by what keeps the thread busy when it arrives.
#pragma once

#include "app/study/participant/participant_events.h"
#include "app/study/participant/participant_view.h"
#include "app/window/gl_window.h"
#include "engine/session/servo_run.h"

#include <optional>
#include <string>
#include <vector>

namespace springdrive::app::study_screen {

/// Its context is current within its functions only; afterwards that of before is.
class ParticipantWindow : public GlWindow {
public:
    struct Wish {
        /// As for `monitor_meant`. Empty: the second monitor, or a window if there is only one.
        std::string monitor;
        bool is_window = false; ///< not full screen, whatever monitors there are
        /// Of the window where it is not full screen.
        Size size{1280, 720};
    };

    /// @throw InputError if no monitor is meant, or more than one, naming those there are; or if
    /// there is no window with OpenGL 3.3.
    explicit ParticipantWindow(const Wish &wish);
    ~ParticipantWindow();
    ParticipantWindow(const ParticipantWindow &) = delete;
    ParticipantWindow &operator=(const ParticipantWindow &) = delete;

    /// The scene of the pictures that show one, and the spot marked in it, from now on.
    void show_scene(const scene::Scene &scene, const scene::TouchSpot &spot,
                    const device::Workspace &workspace);

    /// Draws the picture in the window's pixels and shows it: once a frame, after another window's
    /// `end_frame`. Waits for the display, and meanwhile takes the events of all windows: ImGui
    /// would lose letters that arrive within a frame of its own.
    void show(const ParticipantPicture &picture);
    /// Of the last picture.
    [[nodiscard]] const ParticipantLayout &layout() const { return view_->layout(); }

    /// Since the last call, in order. Letters only while the picture has a text field, and then no
    /// presses of keys that type one.
    [[nodiscard]] std::vector<ParticipantInput> take_inputs() { return events_.take(); }
    /// The same, with times by the servo's clock.
    [[nodiscard]] std::vector<ParticipantInput> take_inputs(const session::ServoRun &servo);

    /// True once for every press of F12, and of the space bar unless a free text is being typed.
    [[nodiscard]] bool take_emergency_stop() { return events_.take_emergency_stop(); }

    void take_focus();

    /// "HDMI-1", of the monitor it is meant for; empty for a window. While that monitor is away, it
    /// is a window elsewhere, and returns by itself.
    [[nodiscard]] const std::string &monitor() const { return monitor_; }
    /// From one picture to the next, by the monitor's rate.
    [[nodiscard]] double frame_s() const { return frame_s_; }

private:
    void follow_monitor();
    [[nodiscard]] Size size_to_draw(Size pixels);

    Size size_; ///< where it is not full screen
    std::string monitor_;
    ParticipantEvents events_;
    std::optional<ParticipantView> view_; ///< until the end
    double frame_s_ = 0.0;                ///< of the monitor
    Size pixels_;                         ///< in the last frame
    Size drawn_;                          ///< the picture's size
    double resized_clock_s_ = 0.0;        ///< since when the window has its size
    double paced_clock_s_ = 0.0;          ///< end of the last frame
    double next_look_s_ = 0.0;            ///< at the monitors
};

} // namespace springdrive::app::study_screen
