// Keys and buttons pressed on a virtual display, by XTest.
#pragma once

#include <memory>
#include <set>
#include <string>

namespace springdrive::testing {

class PressedKeys {
public:
    /// @throw std::runtime_error  there is no such display
    explicit PressedKeys(const std::string &display);
    ~PressedKeys();
    PressedKeys(const PressedKeys &) = delete;
    PressedKeys &operator=(const PressedKeys &) = delete;

    // They return when the server has them; keys are called as in X11's keysymdef.h.
    void tap(const std::string &key);
    void click(int x, int y, int button = 1);
    void move_to(int x, int y);
    void button(int button, bool is_down);

    // What a window manager does, which there is none of:

    /// @return whether there is a window of that title, which is seen
    [[nodiscard]] bool move_window(const std::string &title, int x, int y);
    // Nothing where there is no such window:
    void resize_window(const std::string &title, int width, int height);
    void focus(const std::string &title);
    /// Of all windows that are seen.
    [[nodiscard]] std::set<std::string> window_titles() const;

private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

} // namespace springdrive::testing
