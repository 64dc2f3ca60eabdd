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

#include "app/study/participant/answers.h"
#include "app/study/participant/participant_view.h"
#include "app/window/window.h"
#include "engine/session/servo_run.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app::study_screen {

/// A monitor of the computer.
struct MonitorFacts {
    std::string name; ///< of the connector, such as "HDMI-1"
    int width = 0;    ///< in pixels, as it is set now
    int height = 0;
    int width_mm = 0; ///< as it says itself; 0: not known
    int height_mm = 0;

    friend bool operator==(const MonitorFacts &, const MonitorFacts &) = default;
};

/// Such as "2: HDMI-1 1920×1080".
[[nodiscard]] std::string monitor_line(std::size_t index, const MonitorFacts &monitor);

/// Index of the monitor that is meant by a number from 1, or a name, or a part of one without
/// regard to the case of ASCII letters.
/// @throw InputError if none is meant, or more than one, naming those there are
[[nodiscard]] std::size_t monitor_meant(std::string_view wish,
                                        std::span<const MonitorFacts> monitors);

/// @pre GLFW is initialised
[[nodiscard]] std::vector<MonitorFacts> monitors_there();

/// Of std::chrono::steady_clock, since its epoch.
[[nodiscard]] double steady_clock_s();

/// Of the servo's clock, before the steady one.
[[nodiscard]] double servo_ahead_s(const session::ServoRun &servo);

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
    [[nodiscard]] std::vector<ParticipantInput> take_inputs() { return std::exchange(inputs_, {}); }
    /// The same, with times by the servo's clock; in lockstep, which has frames only, with its time
    /// now.
    [[nodiscard]] std::vector<ParticipantInput> take_inputs(const session::ServoRun &servo);

    /// True once for every press of F12, and of the space bar unless a free text is being typed.
    [[nodiscard]] bool take_emergency_stop() { return std::exchange(emergency_stop_, false); }

    void take_focus();

    /// "HDMI-1", of the monitor it is meant for; empty for a window. While that monitor is away, it
    /// is a window elsewhere, and returns by itself.
    [[nodiscard]] const std::string &monitor() const { return monitor_; }
    /// From one picture to the next, by the monitor's rate.
    [[nodiscard]] double frame_s() const { return frame_s_; }

private:
    static void on_key(GLFWwindow *window, int key, int scancode, int action, int mods);
    static void on_letter(GLFWwindow *window, unsigned code_point);
    static void on_mouse_button(GLFWwindow *window, int button, int action, int mods);

    void note(InputSource source, std::string name, bool is_press, std::size_t choice = 0);
    [[nodiscard]] std::optional<std::size_t> choice_under_cursor() const;
    void follow_monitor();
    [[nodiscard]] Size size_to_draw(Size pixels);

    Size size_; ///< where it is not full screen
    std::string monitor_;
    ParticipantPicture picture_; ///< that is seen, and what a click and a letter therefore mean
    std::vector<ParticipantInput> inputs_; ///< since they were taken
    bool emergency_stop_ = false;
    std::optional<ParticipantView> view_; ///< until the end
    double frame_s_ = 0.0;                ///< of the monitor
    Size pixels_;                         ///< in the last frame
    Size drawn_;                          ///< the picture's size
    double resized_clock_s_ = 0.0;        ///< since when the window has its size
    double paced_clock_s_ = 0.0;          ///< end of the last frame
    double next_look_s_ = 0.0;            ///< at the monitors
};

} // namespace springdrive::app::study_screen
