#include "app/commands/output_files.h"

#include "base/input_error.h"
#include "engine/scene/gltf_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

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
int error_of_writing(const fs::path &output) {
    std::error_code problem;
    const fs::file_type type = fs::status(output, problem).type();
    if (type == fs::file_type::none) { // for example, its name is too long
        return problem.value();
    }
    if (!appears_complete(output)) { // opening a pipe would end its reader
        return access(output.c_str(), W_OK) == 0 ? 0 : errno;
    }
    if (type == fs::file_type::regular) {
        if (const int error = error_of_closing(open(output.c_str(), O_WRONLY | O_CLOEXEC))) {
            return error;
        }
    }
    std::string beside = output.parent_path() / ".springdrive_XXXXXX";
    const int error = error_of_closing(mkstemp(beside.data()));
    if (error == 0) {
        unlink(beside.c_str());
    }
    return error;
}

void check_writable(const fs::path &output, const fs::path &resolved) {
    std::error_code problem;
    if (!fs::is_directory(resolved.parent_path(), problem)) {
        throw InputError(output.string() + ": its folder does not exist; create it first");
    }
    if (fs::is_directory(resolved, problem)) {
        throw InputError(output.string() + ": is a folder; name a file");
    }
    if (const int error = error_of_writing(resolved); error != 0) {
        throw InputError(output.string() + ": cannot be written: " +
                         std::generic_category().message(error) + "; name another file");
    }
}

/// Whether both names lead to one regular file, or would.
bool are_same_file(const fs::path &output, const fs::path &other) {
    std::error_code ignored;
    const fs::path resolved = resolved_name(output);
    if (!fs::exists(resolved, ignored)) {
        return resolved == resolved_name(other);
    }
    return fs::is_regular_file(resolved, ignored) && fs::equivalent(output, other, ignored);
}

} // namespace

Option add_output_option(Command &command, const std::string &option, std::string &where,
                         const std::string &what) {
    return command
        .add_option(option, where, "write " + what + " to a file, or to standard output with -")
        .type_name("FILE|-");
}

void add_force_option(Command &command, Existing &existing) {
    command.add_flag_callback(
        "--force", [&existing] { existing = Existing::replace; }, "replace existing files");
}

void check_outputs(const RunFiles &files, Existing existing) {
    std::vector<fs::path> read = files.read;
    read.push_back(files.scene);
    std::error_code ignored;
    if (std::ranges::any_of(files.written,
                            [&](const fs::path &file) { return fs::exists(file, ignored); })) {
        const std::vector<fs::path> named = scene::gltf::files_named_in(files.scene);
        read.insert(read.end(), named.begin(), named.end());
    }
    std::vector<fs::path> checked;
    for (const fs::path &output : files.written) {
        if (output.empty() || output == "-") {
            continue;
        }
        for (const fs::path &input : read) {
            if (!input.empty() && are_same_file(output, input)) {
                throw InputError(output.string() + ": is also read" +
                                 (input == output ? "" : ", as " + input.string()) +
                                 "; give another name");
            }
        }
        for (const fs::path &other : checked) {
            if (are_same_file(output, other)) {
                throw InputError(output.string() + ": is named for two outputs; give another name");
            }
        }
        const fs::path resolved = resolved_name(output);
        check_writable(output, resolved);
        if (existing == Existing::keep && appears_complete(resolved) &&
            fs::exists(resolved, ignored)) {
            throw InputError(exists_text(output));
        }
        checked.push_back(output);
    }
}

void add_chart_files(RunFiles &files, const fs::path &folder, std::string_view name) {
    for (const char *ending : {".csv", ".svg"}) {
        files.written.push_back(folder / (std::string(name) + ending));
    }
}

void make_output_folder(const std::filesystem::path &folder) {
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    if (problem) {
        throw InputError("--out " + folder.string() + ": cannot be created: " + problem.message() +
                         "; name another folder");
    }
    if (access(folder.c_str(), W_OK | X_OK) != 0) {
        throw InputError("--out " + folder.string() +
                         ": no permission to write; name another folder");
    }
}

void write_report(const Writer &table, const std::vector<ReportFile> &files, Existing existing) {
    if (std::ranges::all_of(files, [](const ReportFile &file) { return file.where.empty(); })) {
        write_output("-", table, existing);
    }
    for (const ReportFile &file : files) {
        if (!file.where.empty()) {
            write_output(file.where, file.write, existing);
        }
    }
}

} // namespace springdrive::app
