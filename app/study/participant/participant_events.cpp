#include "app/study/participant/participant_events.h"

#include "app/study/participant/input_times.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

struct NamedKey {
    int key;
    std::string_view name;
};

/// By what is printed on them, whatever the keyboard's layout: also digits, which some layouts have
/// only with the shift key. Both keys of a pair have one name, as have number pad and others.
constexpr std::array kNamedKeys{
    NamedKey{GLFW_KEY_LEFT, "left"},
    NamedKey{GLFW_KEY_RIGHT, "right"},
    NamedKey{GLFW_KEY_UP, "up"},
    NamedKey{GLFW_KEY_DOWN, "down"},
    NamedKey{GLFW_KEY_ENTER, "enter"},
    NamedKey{GLFW_KEY_KP_ENTER, "enter"},
    NamedKey{GLFW_KEY_BACKSPACE, "backspace"},
    NamedKey{GLFW_KEY_TAB, "tab"},
    NamedKey{GLFW_KEY_INSERT, "insert"},
    NamedKey{GLFW_KEY_DELETE, "delete"},
    NamedKey{GLFW_KEY_HOME, "home"},
    NamedKey{GLFW_KEY_END, "end"},
    NamedKey{GLFW_KEY_PAGE_UP, "page_up"},
    NamedKey{GLFW_KEY_PAGE_DOWN, "page_down"},
    NamedKey{GLFW_KEY_ESCAPE, "escape"},
    NamedKey{GLFW_KEY_MENU, "menu"},
    NamedKey{GLFW_KEY_PRINT_SCREEN, "print"},
    NamedKey{GLFW_KEY_LEFT_SHIFT, "shift"},
    NamedKey{GLFW_KEY_RIGHT_SHIFT, "shift"},
    NamedKey{GLFW_KEY_LEFT_CONTROL, "ctrl"},
    NamedKey{GLFW_KEY_RIGHT_CONTROL, "ctrl"},
    NamedKey{GLFW_KEY_LEFT_ALT, "alt"},
    NamedKey{GLFW_KEY_RIGHT_ALT, "alt"},
    NamedKey{GLFW_KEY_LEFT_SUPER, "super"},
    NamedKey{GLFW_KEY_RIGHT_SUPER, "super"},
};

constexpr std::array kPadKeys{
    NamedKey{GLFW_KEY_KP_DECIMAL, "."},  NamedKey{GLFW_KEY_KP_DIVIDE, "/"},
    NamedKey{GLFW_KEY_KP_MULTIPLY, "*"}, NamedKey{GLFW_KEY_KP_SUBTRACT, "-"},
    NamedKey{GLFW_KEY_KP_ADD, "+"},      NamedKey{GLFW_KEY_KP_EQUAL, "="},
};

/// Empty if it is none of them.
template <typename Keys> std::string_view name_in(const Keys &keys, int key) {
    const auto found = std::ranges::find(keys, key, &NamedKey::key);
    return found == keys.end() ? std::string_view() : found->name;
}

/// Of a key that types nothing.
std::string name_of_silent_key(int key) {
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F11) {
        return "f" + std::to_string(key - GLFW_KEY_F1 + 1);
    }
    return std::string(name_in(kNamedKeys, key));
}

std::string name_of_letter_key(int key, int scancode) {
    for (const int zero : {GLFW_KEY_0, GLFW_KEY_KP_0}) {
        if (key >= zero && key <= zero + 9) {
            return std::to_string(key - zero);
        }
    }
    if (const std::string_view pad = name_in(kPadKeys, key); !pad.empty()) {
        return std::string(pad);
    }
    // By the keyboard's layout: GLFW's own codes are those of a US keyboard.
    const char *const name = glfwGetKeyName(key, scancode);
    return name != nullptr ? input_name(name) : std::string();
}

std::string utf8_of(unsigned code_point) {
    const auto byte = [](unsigned bits) { return static_cast<char>(bits); };
    if (code_point < 0x80U) {
        return {byte(code_point)};
    }
    if (code_point < 0x800U) {
        return {byte(0xC0U | code_point >> 6U), byte(0x80U | (code_point & 0x3FU))};
    }
    if (code_point < 0x10000U) {
        return {byte(0xE0U | code_point >> 12U), byte(0x80U | (code_point >> 6U & 0x3FU)),
                byte(0x80U | (code_point & 0x3FU))};
    }
    return {byte(0xF0U | code_point >> 18U), byte(0x80U | (code_point >> 12U & 0x3FU)),
            byte(0x80U | (code_point >> 6U & 0x3FU)), byte(0x80U | (code_point & 0x3FU))};
}

} // namespace

ParticipantEvents::ParticipantEvents(GLFWwindow *window) : window_(window) {
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, on_key);
    glfwSetCharCallback(window, on_letter);
    glfwSetMouseButtonCallback(window, on_mouse_button);
    glfwSetWindowCloseCallback(window, on_close);
}

void ParticipantEvents::shows(const ParticipantPicture &picture, const ParticipantLayout &layout) {
    layout_ = &layout;
    takes_text_ = picture.has_text_field;
    takes_clicks_ = picture.choices_take_clicks;
    choice_keys_.clear();
    for (const AnswerChoice &choice : picture.choices) {
        choice_keys_.push_back(choice.key);
    }
}

std::vector<ParticipantInput> ParticipantEvents::take() { return std::exchange(inputs_, {}); }

bool ParticipantEvents::take_emergency_stop() { return std::exchange(emergency_stop_, false); }

void ParticipantEvents::note(InputSource source, std::string name, bool is_press,
                             std::size_t choice) {
    inputs_.push_back({source, std::move(name), choice, steady_clock_s(), is_press});
}

void ParticipantEvents::on_key(GLFWwindow *window, int key, int scancode, int action, int) {
    auto &self = *static_cast<ParticipantEvents *>(glfwGetWindowUserPointer(window));
    if (key == GLFW_KEY_F12 || key == GLFW_KEY_SPACE) { // never an answer
        const bool stops = key == GLFW_KEY_F12 || !self.takes_text_;
        self.emergency_stop_ = self.emergency_stop_ || (action == GLFW_PRESS && stops);
        return;
    }
    std::string name = name_of_silent_key(key);
    if (name.empty() && !(self.takes_text_ && action != GLFW_RELEASE)) {
        name = name_of_letter_key(key, scancode);
    }
    const bool is_held_backspace =
        action == GLFW_REPEAT && self.takes_text_ && key == GLFW_KEY_BACKSPACE;
    if (!name.empty() && (action != GLFW_REPEAT || is_held_backspace)) {
        self.note(InputSource::key, std::move(name), action != GLFW_RELEASE);
    }
}

void ParticipantEvents::on_letter(GLFWwindow *window, unsigned code_point) {
    auto &self = *static_cast<ParticipantEvents *>(glfwGetWindowUserPointer(window));
    if (self.takes_text_) {
        self.note(InputSource::letter, utf8_of(code_point), true);
    }
}

std::optional<std::size_t> ParticipantEvents::choice_under_cursor() const {
    double x = 0.0;
    double y = 0.0;
    int window_width = 0;
    int framebuffer_width = 0;
    glfwGetCursorPos(window_, &x, &y);
    glfwGetWindowSize(window_, &window_width, nullptr);
    glfwGetFramebufferSize(window_, &framebuffer_width, nullptr);
    if (layout_ == nullptr || window_width <= 0) {
        return std::nullopt;
    }
    const double pixel_scale = static_cast<double>(framebuffer_width) / window_width;
    return layout_->choice_at(pixel_scale * x, pixel_scale * y);
}

void ParticipantEvents::on_mouse_button(GLFWwindow *window, int button, int action, int) {
    auto &self = *static_cast<ParticipantEvents *>(glfwGetWindowUserPointer(window));
    const bool is_press = action == GLFW_PRESS;
    if (self.takes_clicks_ && button == GLFW_MOUSE_BUTTON_LEFT) {
        const std::optional<std::size_t> choice = self.choice_under_cursor();
        if (choice && is_press) {
            self.note(InputSource::choice, self.choice_keys_.at(*choice), true, *choice);
        }
        return; // beside the plates it means nothing
    }
    if (button >= 0 && button < static_cast<int>(kMouseButtonNames.size())) {
        self.note(InputSource::mouse_button,
                  std::string(kMouseButtonNames[static_cast<std::size_t>(button)]), is_press);
    }
}

/// The experimenter ends a session, not a participant.
void ParticipantEvents::on_close(GLFWwindow *window) {
    glfwSetWindowShouldClose(window, GLFW_FALSE);
}

} // namespace springdrive::app::study_screen
