// Output of commands: to files that the user names, or to standard output.
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

/// @throw InputError if the file `output`, about to be written, is the file `input`; either may be
///        empty or not exist.
void check_other_file(const std::filesystem::path &output, const std::filesystem::path &input);

/// Leaves `output` as it is, whether or not it exists. Empty and "-" are fine.
/// @throw InputError if it cannot be written, or its folder does not exist, to detect this before
///        a long run.
void check_writable(const std::filesystem::path &output);

/// Creates the folder that `--out` names, if it does not exist.
/// @throw InputError if it cannot be created or written to.
void make_output_folder(const std::filesystem::path &folder);

/// Lets `write` fill the file, or standard output where `where` is "-".
/// @throw InputError if the file cannot be created or written completely.
void write_output(const std::string &where, const Writer &write);

/// A report in a format for programs, such as CSV.
struct ReportFile {
    std::string where; ///< empty: not requested
    Writer write;
};

/// Writes the requested `files`; if there are none, the table for people to standard output.
/// @throw InputError as `write_output`.
void write_report(const Writer &table, const std::vector<ReportFile> &files);

} // namespace springdrive::app
