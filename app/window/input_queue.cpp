#include "app/window/input_queue.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cstddef>

namespace springdrive::app {

namespace {

bool is_modifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

/// Whether ImGui itself does something when this key goes down.
bool acts(const ImGuiIO &io, int key) {
    const auto *const begin = std::begin(io.KeyMap);
    return io.KeyCtrl || std::find(begin, begin + ImGuiKey_A, key) != begin + ImGuiKey_A;
}

void set_modifiers(ImGuiIO &io) {
    const auto is_down = [&io](int left, int right) {
        return io.KeysDown[left] || io.KeysDown[right];
    };
    io.KeyCtrl = is_down(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
    io.KeyShift = is_down(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
    io.KeyAlt = is_down(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT);
    io.KeySuper = is_down(GLFW_KEY_LEFT_SUPER, GLFW_KEY_RIGHT_SUPER);
}

/// What one frame was given so far.
struct Given {
    std::vector<int> keys;   ///< that changed
    bool has_acted = false;  ///< a key did, for ImGui
    bool has_typed = false;  ///< letters
    bool has_button = false; ///< that changed
};

bool must_wait_for_key(const Given &given, const ImGuiIO &io, const KeyDown &key, bool is_down) {
    // Of a key that only writes, ImGui takes the letters.
    const bool only_writes = given.has_typed && !acts(io, key.key) && !is_modifier(key.key);
    if (!only_writes && std::ranges::find(given.keys, key.key) != given.keys.end()) {
        return true;
    }
    if (is_modifier(key.key)) {
        return given.has_acted || given.has_typed || given.has_button;
    }
    return is_down &&
           (given.has_acted || given.has_button || (given.has_typed && acts(io, key.key)));
}

} // namespace

std::vector<KeyDown> InputQueue::feed(ImGuiIO &io) {
    std::vector<KeyDown> pressed;
    Given given;
    for (; !waiting_.empty(); waiting_.pop_front()) {
        const auto &[kind, what, is_down, place] = waiting_.front();
        if (kind == Kind::key) {
            if (must_wait_for_key(given, io, what, is_down)) {
                break;
            }
            given.has_acted = given.has_acted || (is_down && acts(io, what.key));
            if (!what.is_repeated) { // ImGui repeats keys by itself
                given.keys.push_back(what.key);
                io.KeysDown[what.key] = is_down;
                set_modifiers(io);
            }
            if (is_down) {
                pressed.push_back(what);
            }
        } else if (kind == Kind::letter) {
            if (given.has_acted || given.has_button) {
                break;
            }
            given.has_typed = true;
            io.AddInputCharacter(static_cast<unsigned>(what.key));
        } else {
            if (given.has_acted || given.has_typed || given.has_button) {
                break;
            }
            given.has_button = true;
            is_button_down_[static_cast<std::size_t>(what.key)] = is_down;
            io.MousePos = place;
        }
    }
    std::ranges::copy(is_button_down_, std::begin(io.MouseDown));
    return pressed;
}

} // namespace springdrive::app
