// Input events on their way to ImGui 1.86, which sees what is down at the time of a frame, and
// takes all of a frame's letters before its keys. Of what happens within one slow frame it would
// lose some: a key that is released again, letters typed after a key, or before a click.
//
//   window system ──► key, letter, button ──► deque ──► feed: what one frame can tell apart ──►
//   ImGui
#pragma once

#include <imgui.h>

#include <array>
#include <deque>
#include <vector>

namespace springdrive::app {

/// A key that went down, or is held down, as the window system names it.
struct KeyDown {
    int key = 0;
    int scancode = 0;
    int modifiers = 0;
    bool is_repeated = false;
};

class InputQueue {
public:
    void press(const KeyDown &key) { waiting_.push_back({Kind::key, key, true}); }
    void release(int key) { waiting_.push_back({Kind::key, {key, 0, 0, false}, false}); }
    void letter(unsigned letter) { waiting_.push_back({Kind::letter, {static_cast<int>(letter)}}); }
    /// @param place  of the mouse
    void button(int button, bool is_down, ImVec2 place) {
        waiting_.push_back({Kind::button, {button}, is_down, place});
    }

    /// Before a frame of ImGui: gives it the oldest events, up to the first that it could not tell
    /// from those. The keys among them that went down.
    std::vector<KeyDown> feed(ImGuiIO &io);

    /// Whether events wait for a later frame.
    [[nodiscard]] bool is_waiting() const { return !waiting_.empty(); }

private:
    enum class Kind : unsigned char { key, letter, button };

    struct Event {
        Kind kind = Kind::key;
        KeyDown what; ///< a letter or button in place of the key
        bool is_down = false;
        ImVec2 place{};
    };

    std::deque<Event> waiting_;
    std::array<bool, 5> is_button_down_{}; ///< ImGui's backend has another opinion
};

} // namespace springdrive::app
