// A window on the computer's screen in which OpenGL 3.3 draws.
#pragma once

#include <string>

struct GLFWwindow;

namespace springdrive::app {

/// Each has a context of its own. GLFW runs while there is any.
class GlWindow {
public:
    struct Size {
        int width = 0;
        int height = 0;

        friend bool operator==(const Size &, const Size &) = default;
    };

    /// Not shown yet, and its context not current.
    /// @param stays  a full screen does so also when another window is clicked
    /// @throw InputError if no window or no OpenGL 3.3 is available, with the remedy.
    GlWindow(const std::string &title, Size size, bool stays);
    ~GlWindow();
    GlWindow(const GlWindow &) = delete;
    GlWindow &operator=(const GlWindow &) = delete;

    /// Whether the processor does what a graphics card would do. @pre a context is current
    [[nodiscard]] static bool draws_in_software();

    [[nodiscard]] bool has_focus() const; ///< whether keys arrive here
    [[nodiscard]] bool is_full_screen() const;
    [[nodiscard]] Size framebuffer() const; ///< pixels to draw on
    [[nodiscard]] Size size() const;        ///< in the mouse's units
    /// Pixels in one of those units.
    [[nodiscard]] float pixel_scale() const;

protected:
    [[nodiscard]] GLFWwindow *glfw() const { return window_; }

private:
    inline static int count_ = 0; ///< of those there are

    GLFWwindow *window_ = nullptr;
};

} // namespace springdrive::app
