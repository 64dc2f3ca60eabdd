#include "app/study/participant/participant_window.h"

#include "app/study/participant/embedded_shaders.h"
#include "app/study/participant/input_times.h"
#include "app/study/participant/monitors.h"
#include "base/input_error.h"

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

/// What one context has been told to do, for the other to wait for. Does not block.
class Fence {
public:
    Fence() : sync_(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)) { glFlush(); }
    ~Fence() { glDeleteSync(sync_); }
    Fence(const Fence &) = delete;
    Fence &operator=(const Fence &) = delete;

    void wait() const { glWaitSync(sync_, 0, GL_TIMEOUT_IGNORED); }

private:
    GLsync sync_;
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

/// Each event is noted as it arrives: in both windows, also in the midst of the wait.
void take_events_until(double until_s) {
    while (steady_clock_s() < until_s) {
        glfwWaitEventsTimeout(std::max(0.0, until_s - steady_clock_s()));
    }
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

/// Objects of the window's context, which it does not share.
struct ParticipantWindow::Presenter {
    Program program{"picture", shaders::fullscreen_vert, shaders::picture_frag};
    VertexArray no_vertices;
};

ParticipantWindow::ParticipantWindow(Window &main, const Wish &wish)
    : main_(main), view_(Window::draws_in_software() ? 0 : 4), size_(wish.size),
      monitor_(chosen_monitor(wish)) {
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE); // it stays when the experimenter clicks
    window_ = glfwCreateWindow(size_.width, size_.height, "springdrive", nullptr, main.glfw());
    if (window_ == nullptr) {
        const char *why = nullptr;
        glfwGetError(&why);
        throw InputError("no window for the participant: " + std::string(why ? why : "") +
                         "; install the graphics driver, or libgl1-mesa-dri for software OpenGL");
    }
    events_ = std::make_unique<ParticipantEvents>(window_);
    glfwSetInputMode(window_, GLFW_CURSOR, GLFW_CURSOR_HIDDEN);
    if (GLFWmonitor *const monitor = monitor_named(monitor_); monitor != nullptr) {
        fill(window_, monitor);
    }
    frame_s_ = frame_s_on(glfwGetWindowMonitor(window_));
    glfwShowWindow(window_);
    {
        const CurrentContext current(window_);
        glfwSwapInterval(1);
        presenter_ = std::make_unique<Presenter>();
        check_gl("setting up the participant's window");
    }
    glfwSwapInterval(0); // of the main window
}

ParticipantWindow::~ParticipantWindow() {
    {
        const CurrentContext current(window_);
        presenter_.reset();
    }
    events_.reset();
    glfwDestroyWindow(window_);
    glfwSwapInterval(1);
}

std::vector<std::string> ParticipantWindow::monitors() {
    const std::vector<MonitorFacts> there = monitors_there();
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < there.size(); ++i) {
        lines.push_back(monitor_line(i, there[i]));
    }
    return lines;
}

/// It may be switched off, replaced or set to another size at any time.
void ParticipantWindow::follow_monitor() {
    if (monitor_.empty() || steady_clock_s() < next_look_s_) {
        return;
    }
    next_look_s_ = steady_clock_s() + kBetweenLooks_s;
    GLFWmonitor *const monitor = monitor_named(monitor_);
    if (monitor != nullptr && !fills(window_, monitor)) {
        fill(window_, monitor);
        frame_s_ = frame_s_on(monitor);
    } else if (monitor == nullptr && is_full_screen()) {
        glfwSetWindowMonitor(window_, nullptr, 0, 0, size_.width, size_.height, GLFW_DONT_CARE);
    }
}

std::vector<ParticipantInput> ParticipantWindow::take_inputs(const session::ServoRun &servo) {
    std::vector<ParticipantInput> inputs = take_inputs();
    tell_by_servo(inputs, servo);
    return inputs;
}

void ParticipantWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot,
                                   const device::Workspace &workspace) {
    view_.set_scene(scene, {spot.point_m, spot.normal},
                    workspace.centre_m.y() - 0.5 * workspace.size_m.y());
}

void ParticipantWindow::show(const ParticipantPicture &picture) {
    follow_monitor();
    const Window::Size pixels = framebuffer();
    if (pixels.width > 0 && pixels.height > 0) { // not of a window without a screen
        view_.draw(picture, pixels.width, pixels.height);
    }
    events_->shows(picture, view_.layout());
    glfwSetInputMode(window_, GLFW_CURSOR,
                     picture.choices_take_clicks ? GLFW_CURSOR_NORMAL : GLFW_CURSOR_HIDDEN);
    const Fence drawn;
    const auto present = [&]() {
        const CurrentContext current(window_);
        drawn.wait();
        glViewport(0, 0, pixels.width, pixels.height);
        presenter_->program.use();
        presenter_->program.set("picture", 0);
        glActiveTexture(GL_TEXTURE0);
        glBindTexture(GL_TEXTURE_2D, view_.texture());
        glBindVertexArray(presenter_->no_vertices.name());
        draw_arrays(GL_TRIANGLES, 3);
        auto taken = std::make_unique<Fence>();
        glfwSwapBuffers(window_);
        return taken;
    };
    take_events_until(paced_clock_s_ + frame_s_ - kBeforeSwap_s);
    // The next picture must not be drawn into this one while it is being shown.
    present()->wait();
    if (steady_clock_s() < paced_clock_s_ + kWaitingShare * frame_s_) { // the swap has not waited
        take_events_until(paced_clock_s_ + frame_s_);
    }
    paced_clock_s_ = steady_clock_s();
}

bool ParticipantWindow::has_focus() const {
    return glfwGetWindowAttrib(window_, GLFW_FOCUSED) != GLFW_FALSE;
}

void ParticipantWindow::take_focus() { glfwFocusWindow(window_); }

Window::Size ParticipantWindow::framebuffer() const {
    Window::Size pixels;
    glfwGetFramebufferSize(window_, &pixels.width, &pixels.height);
    return pixels;
}

bool ParticipantWindow::is_full_screen() const { return glfwGetWindowMonitor(window_) != nullptr; }

bool ParticipantWindow::has_lost_monitor() const { return !monitor_.empty() && !is_full_screen(); }

} // namespace springdrive::app::study_screen
