#include "app/study/participant/participant_window.h"

#include "app/study/participant/input_times.h"
#include "app/study/participant/monitors.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would bring in another OpenGL header.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kUsualRate_Hz = 60.0;
/// A display that waits is left to itself: 60 Hz displays are often at 59.94 Hz or 60.05 Hz.
constexpr double kWaitingShare = 0.9; ///< of a frame
/// A swap that waits may begin so much before the display takes the picture.
constexpr double kBeforeSwap_s = 0.003;
constexpr double kBetweenLooks_s = 0.5;
constexpr double kResizing_s = 0.25; ///< without a change: the window is not being dragged any more

/// Makes a context current, and again the former one at the end.
class CurrentContext {
public:
    explicit CurrentContext(GLFWwindow *window) : before_(glfwGetCurrentContext()) {
        glfwMakeContextCurrent(window);
    }
    ~CurrentContext() { glfwMakeContextCurrent(before_); }
    CurrentContext(const CurrentContext &) = delete;
    CurrentContext &operator=(const CurrentContext &) = delete;

private:
    GLFWwindow *before_;
};

void fill(GLFWwindow *window, GLFWmonitor *monitor) {
    if (const GLFWvidmode *const mode = glfwGetVideoMode(monitor); mode != nullptr) {
        glfwSetWindowMonitor(window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    }
}

/// Whether it fills the monitor as that is set now.
bool fills(GLFWwindow *window, GLFWmonitor *monitor) {
    const GLFWvidmode *const mode = glfwGetVideoMode(monitor);
    int width = 0;
    int height = 0;
    glfwGetWindowSize(window, &width, &height);
    return glfwGetWindowMonitor(window) == monitor &&
           (mode == nullptr || (width == mode->width && height == mode->height));
}

/// Of the monitor; of the first one for a window. 60 Hz where it is not known.
double frame_s_on(GLFWmonitor *monitor) {
    GLFWmonitor *const shown_on = monitor != nullptr ? monitor : glfwGetPrimaryMonitor();
    const GLFWvidmode *const mode = shown_on != nullptr ? glfwGetVideoMode(shown_on) : nullptr;
    const int rate_Hz = mode != nullptr ? mode->refreshRate : 0;
    return 1.0 / (rate_Hz >= 50 && rate_Hz <= 240 ? rate_Hz : kUsualRate_Hz);
}

/// Each event is noted as it arrives: in all windows, also in the midst of the wait.
void take_events_until(double until_s) {
    do {
        glfwWaitEventsTimeout(std::max(0.0, until_s - steady_clock_s()));
    } while (steady_clock_s() < until_s);
}

/// Empty for a window.
std::string chosen_monitor(const ParticipantWindow::Wish &wish) {
    const std::vector<MonitorFacts> there = monitors_there();
    if (wish.is_window || (wish.monitor.empty() && there.size() < 2)) {
        return {};
    }
    return there.at(wish.monitor.empty() ? 1 : monitor_meant(wish.monitor, there)).name;
}

} // namespace

ParticipantWindow::ParticipantWindow(const Wish &wish)
    : GlWindow("springdrive", wish.size, true), size_(wish.size), monitor_(chosen_monitor(wish)),
      events_(glfw()) {
    glfwSetInputMode(glfw(), GLFW_CURSOR, GLFW_CURSOR_HIDDEN);
    if (GLFWmonitor *const monitor = monitor_named(monitor_); monitor != nullptr) {
        fill(glfw(), monitor);
    }
    frame_s_ = frame_s_on(glfwGetWindowMonitor(glfw()));
    glfwShowWindow(glfw());
    const CurrentContext current(glfw());
    glfwSwapInterval(1);
    view_.emplace(draws_in_software() ? 0 : 4);
}

ParticipantWindow::~ParticipantWindow() {
    const CurrentContext current(glfw());
    view_.reset();
}

/// It may be switched off, replaced or set to another size at any time.
void ParticipantWindow::follow_monitor() {
    if (monitor_.empty() || steady_clock_s() < next_look_s_) {
        return;
    }
    next_look_s_ = steady_clock_s() + kBetweenLooks_s;
    GLFWmonitor *const monitor = monitor_named(monitor_);
    if (monitor != nullptr && !fills(glfw(), monitor)) {
        fill(glfw(), monitor);
        frame_s_ = frame_s_on(monitor);
    } else if (monitor == nullptr && is_full_screen()) {
        glfwSetWindowMonitor(glfw(), nullptr, 0, 0, size_.width, size_.height, GLFW_DONT_CARE);
    }
}

std::vector<ParticipantInput> ParticipantWindow::take_inputs(const session::ServoRun &servo) {
    std::vector<ParticipantInput> inputs = take_inputs();
    tell_by_servo(inputs, servo);
    return inputs;
}

void ParticipantWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot,
                                   const device::Workspace &workspace) {
    const CurrentContext current(glfw());
    view_->set_scene(scene, {spot.point_m, spot.normal},
                     workspace.centre_m.y() - 0.5 * workspace.size_m.y());
}

/// While a window's edge is dragged the last picture is stretched: letters are made for one size.
GlWindow::Size ParticipantWindow::size_to_draw(Size pixels) {
    if (std::exchange(pixels_, pixels) != pixels) {
        resized_clock_s_ = steady_clock_s();
    }
    const bool is_resizing = steady_clock_s() - resized_clock_s_ < kResizing_s;
    return is_resizing && !is_full_screen() && drawn_.width > 0 ? drawn_ : pixels;
}

void ParticipantWindow::show(const ParticipantPicture &picture) {
    const CurrentContext current(glfw());
    follow_monitor();
    const Size pixels = framebuffer();
    const bool has_pixels = pixels.width > 0 && pixels.height > 0; // not without a screen
    if (has_pixels) {
        drawn_ = size_to_draw(pixels);
        view_->draw(picture, drawn_.width, drawn_.height);
    }
    events_.shows(picture, view_->layout());
    glfwSetInputMode(glfw(), GLFW_CURSOR,
                     picture.choices_take_clicks ? GLFW_CURSOR_NORMAL : GLFW_CURSOR_HIDDEN);
    glFlush(); // it is drawn in the meantime
    take_events_until(paced_clock_s_ + frame_s_ - kBeforeSwap_s);
    if (has_pixels) {
        view_->copy_to_window(pixels.width, pixels.height);
    }
    glfwSwapBuffers(glfw());
    if (steady_clock_s() < paced_clock_s_ + kWaitingShare * frame_s_) { // the swap has not waited
        take_events_until(paced_clock_s_ + frame_s_);
    }
    paced_clock_s_ = steady_clock_s();
}

void ParticipantWindow::take_focus() { glfwFocusWindow(glfw()); }

} // namespace springdrive::app::study_screen
