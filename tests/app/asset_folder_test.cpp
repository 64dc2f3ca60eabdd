// Covers app/host/asset_folder.cpp.
#include "app/host/asset_folder.h"

#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

TEST(AssetFolder, IsBesideAnInstalledProgramAndElseThatOfTheSources) {
    const fs::path prefix = testing::fresh_folder("asset_folder");
    fs::create_directories(prefix / "bin");
    const fs::path program = prefix / "bin/springdrive";
    EXPECT_EQ(assets_of(program), testing::assets());
    fs::create_directories(prefix / "share/springdrive");
    EXPECT_EQ(assets_of(program), prefix / "share/springdrive");
    fs::remove(prefix / "share/springdrive");
    std::ofstream(prefix / "share/springdrive") << "a file";
    EXPECT_EQ(assets_of(program), testing::assets());
    EXPECT_EQ(assets_of(""), testing::assets()); // without /proc
}

TEST(AssetFolder, IsWhatTheEnvironmentNames) {
    EXPECT_EQ(asset_folder(), testing::assets());
    setenv("SPRINGDRIVE_ASSETS", "/some/where", 1);
    EXPECT_EQ(asset_folder(), "/some/where");
    EXPECT_NE(testing::run_program({"demo", "--help"}).out.find("/some/where/tunings"),
              std::string::npos);
    unsetenv("SPRINGDRIVE_ASSETS");
}

} // namespace
} // namespace springdrive::app
