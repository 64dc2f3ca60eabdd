// Output of commands: to files that the user names, or to standard output; and their progress.
// Nothing is overwritten unasked: an input never, another file only with --force.
#pragma once

#include "app/commands/command.h"
#include "app/host/output.h"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace springdrive::app {

/// An option such as `--csv`, which writes `what` to a file or, with -, to standard output. `where`
/// stays empty unless it is typed.
Option add_output_option(Command &command, const std::string &option, std::string &where,
                         const std::string &what);

/// `--force`, without which existing files are kept.
void add_force_option(Command &command, Existing &existing);

/// The files of a run, to be checked before it: names may be empty, and those of outputs "-".
struct RunFiles {
    std::vector<std::filesystem::path> read;
    std::filesystem::path scene; ///< read with the files that it names
    std::vector<std::filesystem::path> written;
};

/// Leaves all files as they are. Standard output, pipes and devices are fine as outputs; two names
/// are the same file if links or spellings lead to one.
/// @throw InputError for an output that is also an input or another output; that exists and is to
///        be kept; that cannot be written, or whose folder does not exist.
void check_outputs(const RunFiles &files, Existing existing);

/// Adds NAME.csv and NAME.svg in `folder` to what is written.
void add_chart_files(RunFiles &files, const std::filesystem::path &folder, std::string_view name);

/// Creates the folder that `--out` names, if it does not exist.
/// @throw InputError if it cannot be created or written to.
void make_output_folder(const std::filesystem::path &folder);

/// A report in a format for programs, such as CSV.
struct ReportFile {
    std::string where; ///< empty: not requested
    Writer write;
};

/// Writes the requested `files`; if there are none, the table for people to standard output.
/// @throw InputError as `write_output`.
void write_report(const Writer &table, const std::vector<ReportFile> &files, Existing existing);

/// One line on standard error, rewritten in place; only on a terminal.
class ProgressLine {
public:
    ~ProgressLine() {
        if (watched_ && begun_) {
            std::cerr << "\r\x1b[K" << std::flush;
        }
    }
    ProgressLine() = default;
    ProgressLine(const ProgressLine &) = delete;
    ProgressLine &operator=(const ProgressLine &) = delete;

    void show(std::string_view what, double share) {
        const long percent = std::lround(100.0 * share);
        if (watched_ && (!begun_ || percent != percent_)) {
            begun_ = true;
            percent_ = percent;
            std::cerr << "\r\x1b[K" << what << ' ' << percent << " %" << std::flush;
        }
    }

private:
    bool watched_ = isatty(STDERR_FILENO) != 0;
    bool begun_ = false;
    long percent_ = 0;
};

} // namespace springdrive::app
