// The tuning files that the window offers: those of the project, and those in the own folder.
#pragma once

#include "engine/control/tuning_file.h"

#include <filesystem>
#include <string>
#include <vector>

namespace springdrive::app {

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
