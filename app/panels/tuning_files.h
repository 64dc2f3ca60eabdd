// The tunings that the window offers: those in assets/tunings that have a button in the tuning
// panel, all files of the project, and those in the own folder.
#pragma once

#include "engine/control/tuning_file.h"

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

struct Preset {
    std::string_view label; ///< of its button; several may share one
    std::string_view file;  ///< in assets/tunings, without ending
    /// The lowest servo rate, without delay, at which it is meant to be used; 0: any servo.
    double min_servo_hz = 0.0;
};

/// Those of one label by rising servo rate.
inline constexpr std::array<Preset, 4> kPresets{{
    {"soft", "soft"},
    {"firm", "firm"},
    {"stiffest", "stiffest_1kHz", 1000.0},
    {"stiffest", "stiffest_4kHz", 4000.0},
}};

/// Their labels, one button each.
inline constexpr std::array<const char *, 3> kPresetLabels{"soft", "firm", "stiffest"};

/// The file of a button: of the highest rate that is not above the servo's. Empty where there is
/// none for this servo.
[[nodiscard]] std::string preset_file(std::string_view label, double servo_hz,
                                      double delay_periods);

class TuningFiles {
public:
    TuningFiles() { refresh(); }

    /// Looks again for files; those that are no tunings are left out.
    void refresh();

    struct Entry {
        std::filesystem::path file;
        std::string name; ///< without ending; those of the project in brackets
        control::TuningFile contents;
        bool is_own = false; ///< of the user, in the own folder
    };
    [[nodiscard]] const std::vector<Entry> &entries() const { return entries_; }

    /// Writes NAME.toml to the own folder. @return what happened, for people
    std::string save(const std::string &name, const control::Tuning &tuning);

    /// Renames a file of the user. @return what happened, for people
    std::string rename(Entry entry, const std::string &name);

private:
    std::vector<Entry> entries_;
};

} // namespace springdrive::app
