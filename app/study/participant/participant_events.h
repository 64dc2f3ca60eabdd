// What GLFW reports for the participant's window, as inputs by name.
#pragma once

#include "app/study/participant/participant_input.h"
#include "app/study/participant/participant_layout.h"

#include <vector>

struct GLFWwindow;

namespace springdrive::app::study_screen {

/// Takes over the window's callbacks and its user pointer.
class ParticipantEvents {
public:
    explicit ParticipantEvents(GLFWwindow *window);
    ~ParticipantEvents() = default;
    ParticipantEvents(const ParticipantEvents &) = delete;
    ParticipantEvents &operator=(const ParticipantEvents &) = delete;

    /// What is seen from now on, and what a click and a letter therefore mean.
    /// @param layout  must stay until the next call
    void shows(const ParticipantPicture &picture, const ParticipantLayout &layout);

    [[nodiscard]] std::vector<ParticipantInput> take();
    [[nodiscard]] bool take_emergency_stop();

private:
    static void on_key(GLFWwindow *window, int key, int scancode, int action, int mods);
    static void on_letter(GLFWwindow *window, unsigned code_point);
    static void on_mouse_button(GLFWwindow *window, int button, int action, int mods);
    static void on_close(GLFWwindow *window);

    void note(InputSource source, std::string name, bool is_press, std::size_t choice = 0);
    [[nodiscard]] std::optional<std::size_t> choice_under_cursor() const;

    GLFWwindow *window_;
    const ParticipantLayout *layout_ = nullptr;
    std::vector<std::string> choice_keys_;
    bool takes_clicks_ = false;
    bool takes_text_ = false;
    bool emergency_stop_ = false;
    std::vector<ParticipantInput> inputs_;
};

} // namespace springdrive::app::study_screen
