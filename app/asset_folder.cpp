#include "app/asset_folder.h"

#include <cstdlib>

namespace springdrive::app {

std::filesystem::path asset_folder() {
    const char *chosen = std::getenv("SPRINGDRIVE_ASSETS"); // NOLINT(concurrency-mt-unsafe)
    return chosen != nullptr ? chosen : SPRINGDRIVE_ASSET_DIR;
}

} // namespace springdrive::app
