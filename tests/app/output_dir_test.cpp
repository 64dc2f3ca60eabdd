// Covers app/host/output_dir.cpp.
#include "app/host/output_dir.h"

#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <unistd.h>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;

/// A variable of the environment, which afterwards is what it was.
class Variable {
public:
    Variable(const char *name, const std::optional<std::string> &value) : name_(name) {
        if (const char *before = std::getenv(name); before != nullptr) {
            before_ = before;
        }
        set(value);
    }
    ~Variable() { set(before_); }
    Variable(const Variable &) = delete;
    Variable &operator=(const Variable &) = delete;

    void set(const std::optional<std::string> &value) const {
        if (value) {
            setenv(name_, value->c_str(), 1);
        } else {
            unsetenv(name_);
        }
    }

private:
    const char *name_;
    std::optional<std::string> before_;
};

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
    for (const char *line : {"XDG_DOCUMENTS_DIR=", "XDG_DOCUMENTS_DIR=\"", "XDG_DOCUMENTS_DIR=\"\"",
                             "XDG_DOCUMENTS_DIR=\"relative\"", "XDG_DOCUMENTS_DIR=\"$HOME\"",
                             "XDG_DOCUMENTS_DIR=\"$HOME/\"", "#XDG_DOCUMENTS_DIR=\"/tmp\""}) {
        write_settings(line);
        const fs::path documents = documents_folder(home / ".config/user-dirs.dirs", home);
        EXPECT_TRUE(fs::equivalent(documents, home)) << line << ": " << documents;
    }
    fs::remove(home / ".config/user-dirs.dirs");
    fs::create_directories(home / ".config/user-dirs.dirs");
    EXPECT_EQ(documents_folder(home / ".config/user-dirs.dirs", home), home);
}

} // namespace
} // namespace springdrive::app
