#include "app/commands/output_files.h"

#include "base/input_error.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <iostream>
#include <system_error>
#include <unistd.h>

namespace springdrive::app {

namespace {

/// 0 on success.
int error_of_closing(int descriptor) {
    const int error = descriptor < 0 ? errno : 0;
    if (descriptor >= 0) {
        close(descriptor);
    }
    return error;
}

/// The error of writing to `output`; 0 for none. It is tried if that leaves no trace, as
/// permissions alone do not suffice.
int error_of_writing(const std::filesystem::path &output, const std::filesystem::path &folder) {
    std::error_code problem;
    const std::filesystem::file_type type = std::filesystem::status(output, problem).type();
    if (type == std::filesystem::file_type::none) { // for example, its name is too long
        return problem.value();
    }
    if (type == std::filesystem::file_type::regular) {
        return error_of_closing(open(output.c_str(), O_WRONLY | O_CLOEXEC));
    }
    if (type != std::filesystem::file_type::not_found) { // opening a pipe would end its reader
        return access(output.c_str(), W_OK) == 0 ? 0 : errno;
    }
    std::string beside = folder / ".springdrive_XXXXXX";
    const int error = error_of_closing(mkstemp(beside.data()));
    if (error == 0) {
        unlink(beside.c_str());
    }
    return error;
}

} // namespace

CLI::Option *add_output_option(CLI::App &command, const std::string &option, std::string &where,
                               const std::string &what) {
    return command
        .add_option(option, where, "write " + what + " to a file, or to standard output with -")
        ->type_name("FILE|-");
}

void check_other_file(const std::filesystem::path &output, const std::filesystem::path &input) {
    if (output.empty() || input.empty()) {
        return;
    }
    std::error_code ignored;
    if (std::filesystem::equivalent(output, input, ignored) ||
        std::filesystem::weakly_canonical(output, ignored) ==
            std::filesystem::weakly_canonical(input, ignored)) {
        throw InputError(output.string() + ": is the record itself; give another name");
    }
}

void check_writable(const std::filesystem::path &output) {
    if (output.empty() || output == "-") {
        return;
    }
    const std::filesystem::path folder = output.has_parent_path() ? output.parent_path() : ".";
    std::error_code problem;
    if (!std::filesystem::is_directory(folder, problem)) {
        throw InputError(output.string() + ": its folder does not exist; create it first");
    }
    if (std::filesystem::is_directory(output, problem)) {
        throw InputError(output.string() + ": is a folder; name a file");
    }
    if (const int error = error_of_writing(output, folder); error != 0) {
        throw InputError(output.string() + ": cannot be written: " +
                         std::generic_category().message(error) + "; name another file");
    }
}

void make_output_folder(const std::filesystem::path &folder) {
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    if (problem) {
        throw InputError("--out " + folder.string() + ": cannot be created: " + problem.message());
    }
    if (access(folder.c_str(), W_OK | X_OK) != 0) {
        throw InputError("--out " + folder.string() +
                         ": no permission to write; name another folder");
    }
}

void write_output(const std::string &where, const Writer &write) {
    if (where == "-") {
        write(std::cout);
        if (!std::cout.flush()) {
            throw InputError("standard output: cannot be written; is its disk full or its reader "
                             "closed?");
        }
        return;
    }
    std::ofstream file(where, std::ios::binary);
    if (!file) {
        throw InputError(where + ": cannot be created; check that its folder exists and its "
                                 "permissions");
    }
    write(file);
    if (!file.flush()) {
        throw InputError(where + ": cannot be written completely; is the disk full?");
    }
}

void write_report(const Writer &table, const std::vector<ReportFile> &files) {
    if (std::ranges::all_of(files, [](const ReportFile &file) { return file.where.empty(); })) {
        write_output("-", table);
    }
    for (const ReportFile &file : files) {
        if (!file.where.empty()) {
            write_output(file.where, file.write);
        }
    }
}

} // namespace springdrive::app
