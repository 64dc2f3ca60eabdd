#include "app/host/user_folder.h"

#include <cstdlib>

namespace springdrive::app {

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

} // namespace springdrive::app
