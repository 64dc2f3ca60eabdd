// How its user wants the window: size of text, panels or none, full screen, pictures, recent files;
// remembered from one run to the next.
//
//   keys, menu ──► WindowHabits ──► Window, layout; Settings ──► file, in TOML:
//
//   text_size = 1.25
//   width = 1600
//   height = 900
//   hides_panels = true
//   dismissed_start = true
//   opens_legend = true
//   drawn = ["tip", "proxy", "force", "trace"]
//   recent = ["/home/ann/bone.glb"]
#pragma once

#include "app/view/view_state.h"
#include "app/window/window.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

struct Settings {
    static constexpr std::size_t kMaxRecent = 8;

    double text_size = 1.0; ///< of text and panels, times the display's scale
    int width = 0;          ///< of the window in pixels; 0: by the display
    int height = 0;
    bool hides_panels = false;                 ///< scene and read-outs only
    bool dismissed_start = false;              ///< the plate of the first minute
    bool opens_legend = false;                 ///< what is drawn in the scene, by name
    ShownThings shown;                         ///< what is
    std::vector<std::filesystem::path> recent; ///< scenes, records, sessions; the newest first

    friend bool operator==(const Settings &, const Settings &) = default;
};

/// The range of `Settings::text_size`, and its steps by key.
inline constexpr double kMinTextSize = 0.5;
inline constexpr double kMaxTextSize = 3.0;

/// The next size of text in that direction, in steps that are seen; the same at the end.
[[nodiscard]] double next_text_size(double now, bool larger);

/// $XDG_CONFIG_HOME/springdrive/settings.toml, or ~/.config/springdrive/settings.toml; empty where
/// neither is known.
[[nodiscard]] std::filesystem::path settings_file();

/// The defaults if there is no such file. @throw InputError with file, line and what is wrong
[[nodiscard]] Settings read_settings(const std::filesystem::path &file);

/// Makes the folder, too. A file that cannot be written completely stays as it was.
/// @throw InputError if it cannot be written
void write_settings(const std::filesystem::path &file, const Settings &settings);

/// Puts a file at the head of the list of recent ones, once, by its absolute name. A name that
/// is no UTF-8 is not remembered.
void note_recent(Settings &settings, const std::filesystem::path &file);

/// The settings of a run: read at its start, saved when they change. What cannot be read or written
/// is said once and never ends the run.
class SettingsKeeper {
public:
    /// @param file  empty: nothing is remembered
    explicit SettingsKeeper(std::filesystem::path file);

    [[nodiscard]] bool remembers() const { return !file_.empty(); }
    Settings now;

    /// Writes the file if anything has changed. One that could not be read is renamed first.
    void save();
    /// All as in a first run; the file is removed.
    void reset();

    /// Why they could not be read or written, once; else empty.
    [[nodiscard]] std::string take_error();

private:
    void set_damaged_aside();

    std::filesystem::path file_;
    Settings saved_;
    bool is_damaged_ = false; ///< the file is not ours to replace
    std::string error_;
};

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
    [[nodiscard]] Settings &settings() { return keeper_.now; }
    [[nodiscard]] bool remembers() const { return keeper_.remembers(); }

    void obey(WindowOrder order, Window &window);

    /// Whether the plate of the first minute is wanted.
    [[nodiscard]] bool wants_start() const { return remembers() && !settings().dismissed_start; }

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
