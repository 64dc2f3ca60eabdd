// How its user wants the window: size of text, panels or none, full screen, pictures, recent files;
// remembered from one run to the next.
//
//   keys, menu ──► WindowHabits ──► Window, layout; Settings ──► file
#pragma once

#include "app/panels/settings.h"
#include "app/window/window.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace springdrive::app {

/// What keys and the menu ask of the window.
enum class WindowOrder : std::uint8_t {
    none,
    larger_text,
    smaller_text,
    usual_text,
    toggle_panels,
    toggle_full_screen,
    take_picture,
    reset,
    toggle_keys, ///< the overlay that lists them, which is the screen's
    tour,        ///< through all scenes, which is the screen's, too
};

/// What a key asks for; `none` for all keys that concern something else.
[[nodiscard]] WindowOrder window_order_of(const KeyPress &key);

/// A line over the scene for some seconds.
struct Notice {
    std::string text;
    bool is_bad = false; ///< something failed
    double until_s = 0.0;
};

class WindowHabits {
public:
    /// @param settings  file of the settings; empty: nothing is remembered
    explicit WindowHabits(std::filesystem::path settings);

    /// The settings that are remembered, and those that change during the run.
    [[nodiscard]] const Settings &settings() const { return keeper_.now; }
    [[nodiscard]] bool remembers() const { return keeper_.remembers(); }

    void obey(WindowOrder order, Window &window);

    /// Whether the plate of the first minute is wanted.
    [[nodiscard]] bool wants_start() const { return remembers() && !settings().dismissed_start; }
    void dismiss_start() { keeper_.now.dismissed_start = true; }

    /// What is drawn in the scene, and whether its legend is open; to be changed there.
    [[nodiscard]] ShownThings &shown() { return keeper_.now.shown; }
    [[nodiscard]] bool &opens_legend() { return keeper_.now.opens_legend; }

    /// A scene, record or session that was opened by its name.
    void note_opened(const std::filesystem::path &file) { note_recent(keeper_.now, file); }

    /// Once a frame: says what there is to say, and saves what has changed.
    void update(Window &window);
    /// At the end: the size of the window, too.
    void finish(const Window &window);

    /// Of the window, to be written once the frame is complete; then `note_picture`.
    [[nodiscard]] std::optional<std::filesystem::path> take_picture();
    /// @param error  why it was not written; else empty
    void note_picture(const std::filesystem::path &file, const std::string &error);

    void say(std::string text, bool is_bad = false);
    /// Null when there is nothing to be said.
    [[nodiscard]] const Notice *notice() const;

private:
    void set_text_size(double text_size, Window &window);

    SettingsKeeper keeper_;
    std::optional<std::filesystem::path> picture_;
    Notice notice_;
};

} // namespace springdrive::app
