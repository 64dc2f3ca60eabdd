#include "app/host/output_dir.h"

#include "app/host/user_folder.h"

#include <fstream>
#include <string_view>
#include <system_error>
#include <unistd.h>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

/// Whether files are to be expected here: who starts the program from a menu did not choose it.
bool was_chosen(const fs::path &home) {
    std::error_code ignored;
    return access(".", W_OK | X_OK) == 0 && !fs::equivalent(".", "/", ignored) &&
           (home.empty() || !fs::equivalent(".", home, ignored));
}

} // namespace

const fs::path &output_dir() {
    static const fs::path folder = choose_output_dir();
    return folder;
}

fs::path choose_output_dir() {
    const fs::path home = folder_named_by("HOME");
    if (was_chosen(home) || home.empty()) {
        return ".";
    }
    const fs::path config = folder_named_by("XDG_CONFIG_HOME");
    return documents_folder((config.empty() ? home / ".config" : config) / "user-dirs.dirs", home) /
           "springdrive";
}

std::string output_dir_text() {
    const fs::path &folder = output_dir();
    return folder == "." ? "the folder where springdrive was started" : folder.string();
}

fs::path in_output_dir(const std::string &name) {
    const fs::path &folder = output_dir();
    if (folder == ".") {
        return name;
    }
    std::error_code ignored; // without the folder, writing the file fails and says why
    fs::create_directories(folder, ignored);
    return folder / name;
}

fs::path documents_folder(const fs::path &settings, const fs::path &home) {
    // Lines are XDG_NAME_DIR="$HOME/name" or XDG_NAME_DIR="/name", by the file's own specification.
    constexpr std::string_view kKey = "XDG_DOCUMENTS_DIR=\"";
    constexpr std::string_view kHome = "$HOME";
    fs::path documents;
    std::ifstream file(settings);
    for (std::string line; std::getline(file, line);) {
        if (!line.starts_with(kKey) || !line.ends_with('"') || line.size() <= kKey.size()) {
            continue;
        }
        const std::string value = line.substr(kKey.size(), line.size() - kKey.size() - 1);
        documents = value.starts_with(kHome) ? fs::path(home.string() + value.substr(kHome.size()))
                                             : fs::path(value);
    }
    std::error_code ignored;
    return documents.is_absolute() && fs::is_directory(documents, ignored) ? documents : home;
}

} // namespace springdrive::app
