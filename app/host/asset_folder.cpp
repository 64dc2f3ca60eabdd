#include "app/host/asset_folder.h"

#include <cstdlib>
#include <system_error>

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

} // namespace springdrive::app
