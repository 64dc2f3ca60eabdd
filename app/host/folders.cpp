#include "app/host/folders.h"

#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>
#include <unistd.h>

namespace springdrive::app {

std::filesystem::path asset_folder() {
    const char *chosen = std::getenv("SPRINGDRIVE_ASSETS"); // NOLINT(concurrency-mt-unsafe)
    if (chosen != nullptr) {
        return chosen;
    }
    std::error_code ignored; // without /proc the name is empty
    return assets_of(std::filesystem::read_symlink("/proc/self/exe", ignored));
}

std::filesystem::path assets_of(const std::filesystem::path &program) {
    const std::filesystem::path installed =
        (program.parent_path() / "../share/springdrive").lexically_normal();
    std::error_code ignored;
    return std::filesystem::is_directory(installed, ignored) ? installed : SPRINGDRIVE_ASSET_DIR;
}

std::filesystem::path folder_named_by(const char *variable) {
    const char *value = std::getenv(variable); // NOLINT(concurrency-mt-unsafe)
    return value != nullptr && *value == '/' ? value : "";
}

std::filesystem::path user_folder(const char *variable, const std::filesystem::path &in_home) {
    std::filesystem::path all = folder_named_by(variable);
    if (all.empty()) {
        const std::filesystem::path home = folder_named_by("HOME");
        all = home.empty() ? home : home / in_home;
    }
    return all.empty() ? all : all / "springdrive";
}

std::filesystem::path windings_folder() {
    const std::filesystem::path state = user_folder("XDG_STATE_HOME", ".local/state");
    return state.empty() ? state : state / "windings";
}

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
