// A person at the mouse and keyboard of a virtual display.
#pragma once

#include "tests/support/virtual_display.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::testing {

/// Of the screen, from its top left, in pixels; the window begins there too.
struct Point {
    float x = 0.0F;
    float y = 0.0F;
};

/// Acts on the window through the X server, as input devices do. Every action returns only after
/// the program has seen it, even if it draws slowly: ImGui samples keys and buttons once per frame,
/// so a press and its release must not fall into the same one.
///
/// Buttons are X11's: 1 left, 2 middle, 3 right. Keys are called as in X11's keysymdef.h: "space",
/// "Return", "BackSpace", "F1", "z".
///
/// Every function throws std::runtime_error, with the reason, if it cannot act, or if the program
/// draws no frame for 10 s.
class Person {
public:
    /// @param display  must outlive this
    explicit Person(const VirtualDisplay &display);
    ~Person();
    Person(const Person &) = delete;
    Person &operator=(const Person &) = delete;

    /// Waits until a window is there and shows something, and gives it the keyboard focus. To be
    /// called before everything else, and again for the window of the next program.
    /// @param is_seen  whether it draws pictures
    void wait_for_window(std::chrono::duration<double> limit = std::chrono::seconds(30),
                         bool is_seen = true);

    /// Waits until the program has seen everything done so far and then drawn `frames` frames; at
    /// once if its window is gone.
    void wait_for_frames(int frames);

    /// What an action waits for at its end, instead of two frames, and between the press and the
    /// release of a key or button, instead of fewer; a drag for each of its steps. Called once the
    /// program can see what was done. It must be short: ImGui repeats keys held for
    /// 0.25 s, and the second click of a double click must begin within 0.3 s of the first. By
    /// default, neither fails above eight frames per second.
    void settle_by(std::function<void()> settle) { settle_ = std::move(settle); }

    void move_to(float x, float y);
    void press(int button = 1);
    void release(int button = 1);
    void click(float x, float y, int button = 1);
    void double_click(float x, float y);
    void drag(Point from, Point to, double duration_s, int button = 1);
    /// @param notches  positive away from the person
    void wheel(float x, float y, int notches);

    /// Only this key: the one of "Z" is that of "z".
    void press_key(const std::string &name);
    void release_key(const std::string &name);
    /// A key with those held for it, such as "ctrl+shift+z"; ctrl, shift, alt and super.
    void key(const std::string &chord);
    /// @param text  printable ASCII
    void type(const std::string &text);
    /// Of the text field that has been clicked.
    void clear_field();

    /// Drags files from a file manager onto the window.
    void drop_files(float x, float y, const std::vector<std::filesystem::path> &paths);

    /// As with the button of the title bar, which there is none of without a window manager.
    void close_window();

private:
    class Connection;

    void settle(int frames = 2);
    void jump_to(float x, float y);
    void click_here(int button, int frames);

    const VirtualDisplay &display_;
    std::unique_ptr<Connection> connection_;
    std::function<void()> settle_;
};

} // namespace springdrive::testing
