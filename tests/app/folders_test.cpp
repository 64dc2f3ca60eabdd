// Covers app/host/{asset_folder,output_dir}.cpp.
#include "app/host/asset_folder.h"
#include "app/host/output_dir.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/variable.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <unistd.h>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

using testing::Variable;

TEST(AssetFolder, IsWhatIsNamedElseBesideAnInstalledProgramElseThatOfTheSources) {
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

    EXPECT_EQ(asset_folder(), testing::assets());
    const Variable named("SPRINGDRIVE_ASSETS", "/some/where");
    EXPECT_EQ(asset_folder(), "/some/where");
    EXPECT_NE(testing::run_program({"demo", "--help"}).out.find("/some/where/tunings"),
              std::string::npos);
}

class OutputDir : public ::testing::Test {
protected:
    ~OutputDir() override { fs::current_path(started_in_); }

    /// Chosen by a program that is started there.
    [[nodiscard]] static fs::path chosen_in(const fs::path &folder) {
        fs::current_path(folder);
        return choose_output_dir();
    }
    void write_settings(const std::string &text) const {
        fs::create_directories(home / ".config");
        std::ofstream(home / ".config/user-dirs.dirs") << text;
    }

    fs::path home = testing::fresh_folder("own_folder_home");

private:
    fs::path started_in_ = fs::current_path();
    Variable home_variable_{"HOME", home};
    Variable config_variable_{"XDG_CONFIG_HOME", std::nullopt};
};

TEST_F(OutputDir, IsWhereTheProgramWasStartedIfThatWasChosen) {
    EXPECT_EQ(chosen_in(testing::fresh_folder("own_folder_chosen")), ".");
    fs::create_directories(home / "haptics");
    EXPECT_EQ(chosen_in(home / "haptics"), ".");
    const Variable nowhere("HOME", std::nullopt);
    EXPECT_EQ(chosen_in(home), ".");
    const Variable relative("HOME", ".");
    EXPECT_EQ(chosen_in(home), ".");
}

TEST_F(OutputDir, IsAmongTheDocumentsIfTheProgramWasStartedFromAMenu) {
    EXPECT_EQ(chosen_in(home), home / "springdrive");
    EXPECT_EQ(chosen_in("/"), home / "springdrive");
    write_settings("# made by xdg-user-dirs\nXDG_MUSIC_DIR=\"$HOME/Music\"\n"
                   "XDG_DOCUMENTS_DIR=\"$HOME/Dokumente\"\n");
    EXPECT_EQ(chosen_in(home), home / "springdrive"); // there is no such folder
    fs::create_directories(home / "Dokumente");
    EXPECT_EQ(chosen_in(home), home / "Dokumente/springdrive");
    EXPECT_FALSE(fs::exists(home / "Dokumente/springdrive"));

    const fs::path config = testing::fresh_folder("own_folder_config");
    const Variable variable("XDG_CONFIG_HOME", config);
    EXPECT_EQ(chosen_in(home), home / "springdrive");
    std::ofstream(config / "user-dirs.dirs") << "XDG_DOCUMENTS_DIR=\"" << config.string() << "\"\n";
    EXPECT_EQ(chosen_in(home), config / "springdrive");
}

TEST_F(OutputDir, IsAmongTheDocumentsIfTheCurrentFolderCannotBeWrittenTo) {
    if (geteuid() == 0) {
        GTEST_SKIP() << "root may write everywhere";
    }
    const fs::path folder = testing::fresh_folder("own_folder_locked");
    fs::permissions(folder, fs::perms(0555));
    EXPECT_EQ(chosen_in(folder), home / "springdrive");
    fs::permissions(folder, fs::perms(0755));
    EXPECT_EQ(chosen_in(folder), ".");
}

TEST_F(OutputDir, IsInTheHomeFolderIfTheSettingsAreOfNoUse) {
    const fs::path settings = home / ".config/user-dirs.dirs";
    for (const char *line : {"XDG_DOCUMENTS_DIR=", "XDG_DOCUMENTS_DIR=\"", "XDG_DOCUMENTS_DIR=\"\"",
                             "XDG_DOCUMENTS_DIR=\"relative\"", "XDG_DOCUMENTS_DIR=\"$HOME\"",
                             "XDG_DOCUMENTS_DIR=\"$HOME/\"", "#XDG_DOCUMENTS_DIR=\"/tmp\""}) {
        write_settings(line);
        const fs::path documents = documents_folder(settings, home);
        EXPECT_TRUE(fs::equivalent(documents, home)) << line << ": " << documents;
    }
    fs::remove(settings);
    fs::create_directories(settings);
    EXPECT_EQ(documents_folder(settings, home), home);
}

} // namespace
} // namespace springdrive::app
