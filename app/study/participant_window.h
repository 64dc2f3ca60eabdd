// The participant's window: a second one beside the experimenter's, without ImGui, which shows what
// a ParticipantView has drawn and reports what the participant does.
//
// Pacing. A swap that waits for the display blocks the thread, and there is one thread for both
// windows: two swaps that wait would halve the rate, and on displays of different rates beat. So
// only the participant's swap waits (interval 1): what is seen there must not tear, and its frames
// mark the times of a trial. The experimenter's window swaps at once (interval 0) while this one
// exists, and gets its own interval 1 back afterwards. Where the participant's swap does not wait
// (no vertical synchronisation, a hidden window, a monitor that is away), `show` lasts a sixtieth
// of a second by the clock, so that the loop never spins.
#pragma once

#include "app/frame_pace.h"
#include "app/study/participant_input.h"
#include "app/study/participant_view.h"
#include "app/window.h"

#include <memory>
#include <string>
#include <vector>

struct GLFWmonitor;
struct GLFWwindow;

namespace springdrive::app::study_screen {

class ParticipantWindow {
public:
    struct Wish {
        /// Number from 1, or part of the name without regard to case. Empty: the second monitor if
        /// there are two or more, else a window of `size`.
        std::string monitor;
        bool is_window = false;       ///< not full screen, whatever monitors there are
        Window::Size size{1280, 720}; ///< of the window where it is not full screen
    };

    /// After the main window, which must outlive it. Its context stays current.
    /// @throw InputError if no monitor is meant, or more than one, naming those there are; or if
    /// there is no second window with OpenGL 3.3.
    ParticipantWindow(Window &main, const Wish &wish);
    ~ParticipantWindow();
    ParticipantWindow(const ParticipantWindow &) = delete;
    ParticipantWindow &operator=(const ParticipantWindow &) = delete;

    /// Those there are now, such as "2: HDMI-1 1920×1080". @pre there is a main window
    [[nodiscard]] static std::vector<std::string> monitors();

    /// Draws the picture in the window's size in pixels and shows it; once a frame, between the
    /// main window's `begin_frame`, which polls the events of both, and `end_frame`.
    void show(ParticipantView &view, const ParticipantPicture &picture);

    /// When the last picture was handed to the display: after the swap, of the steady clock [s].
    [[nodiscard]] double shown_clock_s() const { return shown_clock_s_; }

    /// Since the last call, in order. Letters only while the picture has a text field, and then no
    /// presses of the keys that typed them.
    [[nodiscard]] std::vector<ParticipantInput> take_inputs();

    /// True once for every press of F12, and of the space bar unless a free text is being typed.
    [[nodiscard]] bool take_emergency_stop();

    /// Whether keys arrive here. The experimenter's clicks take the focus to the other window.
    [[nodiscard]] bool has_focus() const;
    void take_focus();

    [[nodiscard]] Window::Size framebuffer() const;
    [[nodiscard]] bool is_full_screen() const;
    /// Whether it fills the wished monitor, or is a window by its wish; false while the monitor is
    /// away: it is then a window on another one, and returns by itself.
    [[nodiscard]] bool is_in_place() const;

private:
    class Events;
    class Presenter;

    void follow_monitor();

    Window &main_;
    Wish wish_;
    GLFWwindow *window_ = nullptr;
    std::string monitor_name_; ///< of the chosen one; empty for a window
    std::unique_ptr<Events> events_;
    std::unique_ptr<Presenter> presenter_;
    FramePace pace_;
    double shown_clock_s_ = 0.0;
};

} // namespace springdrive::app::study_screen
