#include "app/study/participant/participant_window.h"

#include "app/study/participant/answers.h"
#include "base/input_error.h"
#include "base/text.h"

#include <epoxy/gl.h>
// epoxy must come before GLFW, which would bring in another OpenGL header.
#include <GLFW/glfw3.h>
#include <imgui_internal.h> // ImTextCharToUtf8

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
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

std::string all_lines(std::span<const MonitorFacts> monitors) {
    std::string all;
    for (std::size_t i = 0; i < monitors.size(); ++i) {
        all += (i > 0 ? ", " : "") + monitor_line(i, monitors[i]);
    }
    return all.empty() ? "none" : all;
}

std::span<GLFWmonitor *const> glfw_monitors() {
    int count = 0;
    GLFWmonitor *const *const first = glfwGetMonitors(&count);
    return {first, static_cast<std::size_t>(count)};
}

/// Null if there is none of that name now.
GLFWmonitor *monitor_named(const std::string &name) {
    for (GLFWmonitor *const monitor : glfw_monitors()) {
        const char *const its_name = glfwGetMonitorName(monitor);
        if (its_name != nullptr && name == its_name) {
            return monitor;
        }
    }
    return nullptr;
}

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

std::string monitor_line(std::size_t index, const MonitorFacts &monitor) {
    return std::to_string(index + 1) + ": " + monitor.name + " " + std::to_string(monitor.width) +
           "×" + std::to_string(monitor.height);
}

std::size_t monitor_meant(std::string_view wish, std::span<const MonitorFacts> monitors) {
    const auto error = [&](const std::string &what) {
        return InputError("no monitor \"" + std::string(wish) + "\" for the participant: " + what +
                          "; there are " + all_lines(monitors));
    };
    if (const std::optional<std::size_t> number = number_in<std::size_t>(wish)) {
        if (*number < 1 || *number > monitors.size()) {
            throw error("numbers are from 1 to " + std::to_string(monitors.size()));
        }
        return *number - 1;
    }
    const std::string part = input_name(wish);
    std::optional<std::size_t> meant;
    for (std::size_t i = 0; i < monitors.size(); ++i) {
        const std::string name = input_name(monitors[i].name);
        if (name == part) {
            return i;
        }
        if (!part.empty() && name.find(part) != std::string::npos) {
            if (meant) {
                throw error("it is part of more than one name");
            }
            meant = i;
        }
    }
    if (!meant) {
        throw error("type its number or a part of its name");
    }
    return *meant;
}

std::vector<MonitorFacts> monitors_there() {
    std::vector<MonitorFacts> all;
    for (GLFWmonitor *const monitor : glfw_monitors()) {
        const GLFWvidmode *const mode = glfwGetVideoMode(monitor);
        const char *const name = glfwGetMonitorName(monitor);
        MonitorFacts facts{name != nullptr ? name : "", mode != nullptr ? mode->width : 0,
                           mode != nullptr ? mode->height : 0};
        glfwGetMonitorPhysicalSize(monitor, &facts.width_mm, &facts.height_mm);
        all.push_back(std::move(facts));
    }
    return all;
}

double steady_clock_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// This thread may be held up between readings of the two clocks: those closest to each other
/// count.
double servo_ahead_s(const session::ServoRun &servo) {
    constexpr int kReadings = 5;
    double shortest_s = std::numeric_limits<double>::infinity();
    double ahead_s = 0.0;
    for (int i = 0; i < kReadings; ++i) {
        const double before_s = steady_clock_s();
        const double now_s = servo.now_s();
        const double after_s = steady_clock_s();
        if (after_s - before_s < shortest_s) {
            shortest_s = after_s - before_s;
            ahead_s = now_s - 0.5 * (before_s + after_s);
        }
    }
    return ahead_s;
}

ParticipantWindow::ParticipantWindow(const Wish &wish)
    : GlWindow("springdrive", wish.size, true), size_(wish.size), monitor_(chosen_monitor(wish)) {
    glfwSetWindowUserPointer(glfw(), this);
    glfwSetKeyCallback(glfw(), on_key);
    glfwSetCharCallback(glfw(), on_letter);
    glfwSetMouseButtonCallback(glfw(), on_mouse_button);
    // The experimenter ends a session, not a participant.
    glfwSetWindowCloseCallback(
        glfw(), [](GLFWwindow *window) { glfwSetWindowShouldClose(window, GLFW_FALSE); });
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

void ParticipantWindow::note(InputSource source, std::string name, bool is_press,
                             std::size_t choice) {
    inputs_.push_back({source, std::move(name), choice, steady_clock_s(), is_press});
}

void ParticipantWindow::on_key(GLFWwindow *window, int key, int scancode, int action, int) {
    auto &self = *static_cast<ParticipantWindow *>(glfwGetWindowUserPointer(window));
    const bool takes_text = self.picture_.has_text_field;
    if (key == GLFW_KEY_F12 || key == GLFW_KEY_SPACE) { // never an answer
        const bool stops = key == GLFW_KEY_F12 || !takes_text;
        self.emergency_stop_ = self.emergency_stop_ || (action == GLFW_PRESS && stops);
        return;
    }
    std::string name = name_of_silent_key(key);
    if (name.empty() && !(takes_text && action != GLFW_RELEASE)) {
        name = name_of_letter_key(key, scancode);
    }
    const bool is_held_backspace = action == GLFW_REPEAT && takes_text && key == GLFW_KEY_BACKSPACE;
    if (!name.empty() && (action != GLFW_REPEAT || is_held_backspace)) {
        self.note(InputSource::key, std::move(name), action != GLFW_RELEASE);
    }
}

void ParticipantWindow::on_letter(GLFWwindow *window, unsigned code_point) {
    auto &self = *static_cast<ParticipantWindow *>(glfwGetWindowUserPointer(window));
    if (self.picture_.has_text_field) {
        std::array<char, 5> letter{};
        self.note(InputSource::letter, ImTextCharToUtf8(letter.data(), code_point), true);
    }
}

std::optional<std::size_t> ParticipantWindow::choice_under_cursor() const {
    double x = 0.0;
    double y = 0.0;
    glfwGetCursorPos(glfw(), &x, &y);
    const double scale = static_cast<double>(pixel_scale());
    return view_ ? view_->layout().choice_at(scale * x, scale * y) : std::nullopt;
}

void ParticipantWindow::on_mouse_button(GLFWwindow *window, int button, int action, int) {
    auto &self = *static_cast<ParticipantWindow *>(glfwGetWindowUserPointer(window));
    const bool is_press = action == GLFW_PRESS;
    if (self.picture_.choices_take_clicks && button == GLFW_MOUSE_BUTTON_LEFT) {
        const std::optional<std::size_t> choice = self.choice_under_cursor();
        if (choice && is_press) {
            self.note(InputSource::choice, self.picture_.choices.at(*choice).key, true, *choice);
        }
        return; // beside the plates it means nothing
    }
    if (button >= 0 && button < static_cast<int>(kMouseButtonNames.size())) {
        self.note(InputSource::mouse_button,
                  std::string(kMouseButtonNames[static_cast<std::size_t>(button)]), is_press);
    }
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
    const double ahead_s = servo_ahead_s(servo);
    for (ParticipantInput &input : inputs) {
        input.clock_s = servo.is_in_lockstep() ? servo.now_s() : input.clock_s + ahead_s;
    }
    return inputs;
}

void ParticipantWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot,
                                   const device::Workspace &workspace) {
    const CurrentContext current(glfw());
    view_->set_scene(scene, spot, workspace.centre_m.y() - 0.5 * workspace.size_m.y());
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
    picture_ = picture;
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
