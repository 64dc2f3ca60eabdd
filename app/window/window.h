// Windows on the computer's screen in which OpenGL 3.3 draws: with nothing else, and with Dear
// ImGui.
#pragma once

#include "app/widgets/rectangle.h"

#include <imgui.h>

#include <array>
#include <deque>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

struct GLFWwindow;
struct ImFont;

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

// Input events on their way to ImGui 1.86, which sees what is down at the time of a frame, and
// takes all of a frame's letters before its keys. Of what happens within one slow frame it would
// lose some: a key that is released again, letters typed after a key, or before a click.
//
//   window system ──► key, letter, button ──► deque ──► feed: what one frame can tell apart ──►
//   ImGui

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

/// A key with those held for it.
struct KeyPress {
    std::string name; ///< the letter on the keyboard, lower case; or "Home", "Escape", "F1", "F6",
                      ///< "F9", "F10", "F11", "PageUp", "PageDown"
    bool with_ctrl = false;
    bool with_shift = false;
    bool with_alt = false;
    bool is_repeated = false; ///< held down
};

/// Its context is current while there is no other one's.
class Window : public GlWindow {
public:
    /// What is wanted of a new window.
    struct Wish {
        Size size;              ///< in pixels; 0 × 0 for 1280 × 720 times the scale
        Size remembered;        ///< the same, of an earlier run; used without `size`, if not 0 × 0
        double scale = 0.0;     ///< of text and panels; 0 for the display's scale
        double text_size = 1.0; ///< see `set_text_size`
        double frame_s = 0.0;   ///< between two frames, for Dear ImGui; 0: by the clock
        /// Fills the screen for good, cannot be closed, and has text by the screen's size.
        bool is_kiosk = false;
        /// Does not wait for the display: another window does, in the same frame.
        bool swaps_at_once = false;
        /// Shown, but nobody looks: frames that are not kept are computed, but not drawn.
        bool is_unseen = false;
    };

    /// Fonts beside the usual one.
    struct LargeText {
        ImFont *medium = nullptr; ///< 40 of the 720 lines of the picture
        ImFont *large = nullptr;  ///< 78 of them
    };

    /// @throw InputError if no window or no OpenGL 3.3 is available, with the remedy.
    Window(const std::string &title, const Wish &wish);
    ~Window();
    Window(const Window &) = delete;
    Window &operator=(const Window &) = delete;

    [[nodiscard]] bool is_closing() const; ///< never of a kiosk

    /// Polls events and begins an ImGui frame.
    void begin_frame();

    /// Whether the frame is drawn, once it is known whether it is kept.
    [[nodiscard]] bool is_drawn() const { return !is_unseen_ || keep_last_frame_; }

    /// Draws the ImGui frame over the caller's drawing, and swaps buffers.
    void end_frame();

    /// Fills the screen, or returns to the former size.
    void toggle_full_screen();

    /// Of the present one: that of a first run. Not while it fills the screen.
    void return_to_default_size();

    /// Of text and panels, times the scale of the start; from the next frame on.
    void set_text_size(double text_size) { text_size_ = static_cast<float>(text_size); }
    /// Whether the window is too small for text of the size that is set.
    [[nodiscard]] bool limits_text() const { return usable_scale_ < scale_; }

    /// The size below which text gets smaller, times the scale.
    void set_room(Size room) { room_ = room; }
    static constexpr Size kRoomForPanels{1000, 640};
    static constexpr Size kRoomForScene{480, 300}; ///< without panels

    /// Clears the whole framebuffer, before the caller's drawing.
    void clear();

    /// Of text and panels; smaller than requested if the window is too small for that.
    [[nodiscard]] float scale() const { return usable_scale_; }
    [[nodiscard]] const LargeText &large_text() const { return large_text_; }

    /// True once for every press of F12, however short, wherever the focus is; and of the space
    /// bar, unless a text is being typed.
    [[nodiscard]] bool take_emergency_stop();

    /// Letters pressed since the last call, or repeated because they are held down, except those
    /// typed as text; and keys that are no letters.
    [[nodiscard]] std::vector<KeyPress> take_keys();

    /// Whether keys or clicks wait for a later frame.
    [[nodiscard]] bool has_waiting_input() const { return input_.is_waiting(); }

    /// Files dropped on the window since the last call.
    [[nodiscard]] std::vector<std::filesystem::path> take_dropped_files();

    /// Writes the last frame that `end_frame` showed, as PNG. @throw InputError if there is none.
    /// @param part  of the window, in its units; empty: all of it
    void write_screenshot(std::ostream &out, const Rectangle &part = {}) const;

    /// Why text may be missing letters; empty when the font was found.
    [[nodiscard]] const std::string &font_warning() const { return font_warning_; }

private:
    static void on_key(GLFWwindow *window, int key, int scancode, int action, int mods);
    static void on_letter(GLFWwindow *window, unsigned letter);
    static void on_mouse_button(GLFWwindow *window, int button, int action, int mods);
    static void on_drop(GLFWwindow *window, int count, const char **paths);
    void choose_font();
    static void use_keyboard();
    void listen();
    void note_key(const KeyDown &key);
    void renew_text();
    void keep_as_kiosk();
    void resize_within_screen(int width, int height);
    void fit_scale_to_window();

    double frame_s_ = 0.0;
    bool is_unseen_ = false;
    bool is_kiosk_ = false;
    double next_fill_s_ = 0.0; ///< when a kiosk may try to fill the screen again
    LargeText large_text_;
    float start_scale_ = 1.0F; ///< as typed, or the display's
    float text_size_ = 1.0F;   ///< times that
    float scale_ = 1.0F;       ///< of the font: their product
    Size room_ = kRoomForPanels;
    std::array<int, 4> before_full_screen_{0, 0, 1280, 720}; ///< x, y, width, height
    float usable_scale_ = 1.0F;
    bool emergency_stop_ = false;
    InputQueue input_;
    std::vector<KeyPress> keys_; ///< for take_keys
    std::vector<std::filesystem::path> dropped_;
    std::vector<unsigned char> last_frame_; ///< RGB, bottom row first
    Size last_frame_size_;
    bool keep_last_frame_ = false;
    std::string font_warning_;

public:
    /// Keeps every frame from now on for `write_screenshot`; costs a read-back per frame.
    void keep_frames(bool keep) { keep_last_frame_ = keep; }
};

} // namespace springdrive::app
