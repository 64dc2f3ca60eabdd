// Where a command writes what it found: to files that were named, or to standard output.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace springdrive::app {

using Writer = std::function<void(std::ostream &)>;

/// An option such as `--csv`, which writes `what` to a file or, with -, to standard output. `where`
/// stays empty unless it is typed.
CLI::Option *add_output_option(CLI::App &command, const std::string &option, std::string &where,
                               const std::string &what);

/// @throw InputError where `output`, which is about to be written, is the file `input` that it
///        comes from or goes beside; either may be empty or not exist.
void check_other_file(const std::filesystem::path &output, const std::filesystem::path &input);

/// Leaves `output` as it is, whether or not it exists. Empty and "-" are fine.
/// @throw InputError where it cannot be written, or its folder does not exist: better known before
///        a long run.
void check_writable(const std::filesystem::path &output);

/// Makes the folder that `--out` names, where it is missing.
/// @throw InputError where that cannot be, or nobody may write there.
void make_output_folder(const std::filesystem::path &folder);

/// Lets `write` fill the file, or standard output where `where` is "-".
/// @throw InputError where the file cannot be created, or not all of it could be written.
void write_output(const std::string &where, const Writer &write);

/// A report as a program reads it: CSV, say.
struct ReportFile {
    std::string where; ///< empty: not asked for
    Writer write;
};

/// Those of `files` that were asked for; if none was, the table for people on standard output.
/// @throw InputError as `write_output`.
void write_report(const Writer &table, const std::vector<ReportFile> &files);

} // namespace springdrive::app
