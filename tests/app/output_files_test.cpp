// Covers app/commands/output_files.cpp and app/host/{output,output_dir,asset_folder}.cpp, and from
// outside that commands keep to them: which files are written, where, and which never.
#include "app/commands/output_files.h"

#include "app/host/folders.h"
#include "base/input_error.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <unistd.h>
#include <vector>

namespace springdrive::app {
namespace {

namespace fs = std::filesystem;
using testing::contents_of;

void write(const fs::path &file, const std::string &text) { std::ofstream(file) << text; }

/// A small scene whose buffer and image are files of their own.
void write_scene(const fs::path &folder) {
    write(folder / "s.gltf",
          R"({"asset":{"version":"2.0"},"buffers":[{"uri":"b%20in.bin","byteLength":36}],)"
          R"("images":[{"uri":"i.png"}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
          R"("min":[0,0,0],"max":[0.1,0.1,0]}],"meshes":[{"primitives":[{"attributes":)"
          R"({"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0})");
    const std::vector<float> corners{0, 0, 0, 0.1F, 0, 0, 0, 0.1F, 0};
    std::ofstream(folder / "b in.bin", std::ios::binary)
        .write(reinterpret_cast<const char *>(corners.data()), 36);
    write(folder / "i.png", "image");
}

std::string error(const RunFiles &files, Existing existing) {
    return error_text_of([&] { check_outputs(files, existing); });
}

TEST(OutputFiles, AreNeverInputs) {
    const fs::path folder = testing::fresh_folder("output_is_input");
    write(folder / "in", "in");
    fs::create_symlink("in", folder / "link");
    fs::create_hard_link(folder / "in", folder / "hard");
    for (const Existing existing : {Existing::keep, Existing::replace}) {
        for (const char *name : {"in", "link", "hard", "./in", "../output_is_input/in"}) {
            const fs::path output = folder / name;
            EXPECT_NE(error({{folder / "in"}, {}, {output}}, existing).find("is also read"),
                      std::string::npos)
                << name;
        }
    }
    EXPECT_EQ(contents_of(folder / "in"), "in");
}

TEST(OutputFiles, AreNoFilesThatAGltfNames) {
    const fs::path folder = testing::fresh_folder("output_is_buffer");
    write_scene(folder);
    for (const char *name : {"s.gltf", "b in.bin", "i.png"}) {
        EXPECT_NE(
            error({{}, folder / "s.gltf", {folder / name}}, Existing::replace).find("is also read"),
            std::string::npos)
            << name;
    }
    EXPECT_EQ(error({{}, folder / "s.gltf", {folder / "out"}}, Existing::replace), "");
}

TEST(OutputFiles, AreNotEachOther) {
    const fs::path folder = testing::fresh_folder("output_is_output");
    fs::create_symlink("new", folder / "dangling");
    for (const char *name : {"new", "./new", "dangling"}) {
        EXPECT_NE(error({{}, {}, {folder / "new", folder / name}}, Existing::replace)
                      .find("is named for two outputs"),
                  std::string::npos)
            << name;
    }
    EXPECT_EQ(error({{}, {}, {"/dev/null", "/dev/null", "", "", "-"}}, Existing::keep), "");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST(OutputFiles, ReplaceOnlyIfAsked) {
    const fs::path folder = testing::fresh_folder("output_exists");
    write(folder / "old", "old");
    fs::create_symlink("old", folder / "link");
    for (const char *name : {"old", "link"}) {
        const std::string file = folder / name;
        EXPECT_EQ(error({{}, {}, {file}}, Existing::keep),
                  file + ": exists; use --force to replace it");
        const auto written = fs::last_write_time(file);
        EXPECT_EQ(error({{}, {}, {file, folder / "new"}}, Existing::replace), "");
        EXPECT_EQ(fs::last_write_time(file), written); // looking leaves all as it is
        EXPECT_EQ(contents_of(file), "old");
        EXPECT_FALSE(fs::exists(folder / "new"));
    }
    EXPECT_NE(error({{}, {}, {folder}}, Existing::replace), "");
    const auto write_new = [](std::ostream &out) { out << "new"; };
    EXPECT_THROW(write_output(folder / "old", write_new, Existing::keep), InputError);
    EXPECT_EQ(contents_of(folder / "old"), "old");
    EXPECT_THROW(write_output(
                     folder / "old",
                     [](std::ostream &out) {
                         out << "half";
                         throw InputError("failed");
                     },
                     Existing::replace),
                 InputError);
    EXPECT_EQ(contents_of(folder / "old"), "old");
    write_output(folder / "link", write_new, Existing::replace);
    EXPECT_EQ(contents_of(folder / "old"), "new");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
}

/// Every option that writes a file, with inputs of the same run in `folder`.
struct WritingCommand {
    std::vector<std::string> words;
    std::vector<std::string> outputs; ///< names that the words mention, or that they imply
};

std::vector<WritingCommand> writing_commands(const fs::path &folder) {
    const std::string scene = folder / "s.gltf";
    const std::string device = folder / "d.toml";
    const auto file = [&](const char *name) { return (folder / name).string(); };
    return {
        {{"inspect", scene, "--no-model", "--device-file", device, "--json", file("o")}, {"o"}},
        {{"touch", scene, "--device-file", device, "--csv", file("o")}, {"o"}},
        {{"touch", scene, "--path", file("p.csv"), "--json", file("o")}, {"o"}},
        {{"record", file("o"), "--seconds", "0.1", "--lockstep", "--scene", scene}, {"o"}},
        {{"record", file("new.rec"), "--seconds", "0.1", "--lockstep", "--json", file("o")}, {"o"}},
        {{"replay", file("r.rec"), "--csv", file("o")}, {"o"}},
        {{"export", file("r.rec"), "--csv", file("o")}, {"o"}},
        {{"export", file("r.rec"), "--npy", file("o")}, {"o"}},
        {{"export", file("r.rec"), "--mat", file("o")}, {"o"}},
        {{"stiffness", "--device-file", device, "--csv", file("o")}, {"o"}},
        {{"baseline", "--device-file", device, "--csv", file("o")}, {"o"}},
        {{"stability", "--device-file", device, "--json", file("o")}, {"o"}},
        {{"stability", "--table", "--csv", file("o")}, {"o"}},
        {{"stability", "--map", "kp,dR", "--steps", "2", "--out", file("o.svg")},
         {"o.svg", "o.csv"}},
        {{"tune", "--device-file", device, "--out", file("o")}, {"o"}},
        {{"demo", "--frames", "1", "--screenshot", file("o")}, {"o"}},
        {{"demo", "--frames", "1", "--record", file("o")}, {"o"}},
        {{"figures", "--out", folder}, {"fig2_stiffness.csv", "fig6_direction_error.svg"}},
        {{"chart", "--only", "plant_models", "--out", folder}, {"plant_models.svg"}},
    };
}

/// A run of every command, with files that it would have to replace.
class EveryCommand : public ::testing::Test {
protected:
    EveryCommand() {
        write_scene(folder);
        fs::copy_file(SPRINGDRIVE_ASSET_DIR "/devices/phantom_1_0.toml", folder / "d.toml");
        write(folder / "p.csv", "t,x,y,z\n0,0,0.06,0\n0.01,0,0.05,0\n");
        EXPECT_EQ(
            testing::run_program({"record", folder / "r.rec", "--lockstep", "--seconds", "0.1"})
                .exit_status,
            0);
    }

    const fs::path folder = testing::fresh_folder("commands");
};

TEST_F(EveryCommand, KeepsFilesWithoutForce) {
    for (const WritingCommand &command : writing_commands(folder)) {
        for (const std::string &output : command.outputs) {
            write(folder / output, "mine");
            const auto before = std::distance(fs::directory_iterator(folder), {});
            testing::expect_refused(testing::run_program(command.words),
                                    (folder / output).string() +
                                        ": exists; use --force to replace it");
            EXPECT_EQ(contents_of(folder / output), "mine") << command.words[0];
            EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), before);
            fs::remove(folder / output);
        }
    }
}

TEST_F(EveryCommand, NeverReplacesAnInput) {
    int inputs = 0;
    for (const WritingCommand &command : writing_commands(folder)) {
        for (const std::string &input : command.words) {
            const std::string name = fs::path(input).filename();
            if ((name != "s.gltf" && name != "d.toml" && name != "p.csv" && name != "r.rec") ||
                !fs::exists(input)) {
                continue;
            }
            const std::string before = contents_of(input);
            const fs::path output = folder / command.outputs.front();
            fs::create_hard_link(input, output);
            std::vector<std::string> words = command.words;
            words.emplace_back("--force");
            testing::expect_refused(testing::run_program(words), "is also read");
            EXPECT_EQ(contents_of(input), before) << words[0];
            fs::remove(output);
            ++inputs;
        }
    }
    EXPECT_GT(inputs, 12);
}

/// As ulimit -f makes it: with a signal that by default kills.
TEST_F(EveryCommand, TakesALimitOfFilesForAFullDisk) {
    const auto files = [&] {
        std::set<fs::path> names;
        for (const auto &file : fs::directory_iterator(folder)) {
            names.insert(file.path().filename());
        }
        return names;
    };
    const std::set<fs::path> before = files();
    for (const WritingCommand &command : writing_commands(folder)) {
        if (command.words[0] == "demo" || command.words[0] == "baseline" ||
            command.words[0] == "chart" || command.words[0] == "tune" ||
            command.words[1] == "--table") {
            continue; // the drivers of a display need files of their own; the others are slow
        }
        testing::Ending ending;
        {
            const testing::FullDisk disk(100); // of what they say, too
            ending = testing::run_program(command.words);
        }
        EXPECT_EQ(ending.exit_status, 1) << command.words[0] << ": " << ending.error;
        EXPECT_EQ(ending.error.rfind("springdrive: ", 0), 0U) << command.words[0] << ending.error;
        EXPECT_EQ(files(), before) << command.words[0];
    }
}

TEST_F(EveryCommand, ReplacesWithForce) {
    for (WritingCommand command : writing_commands(folder)) {
        if (command.words[0] == "figures" || command.words[0] == "baseline" ||
            command.words[0] == "chart" || command.words[0] == "tune" ||
            command.words[1] == "--table") {
            continue; // the same code, but slow
        }
        write(folder / command.outputs.front(), "mine");
        command.words.emplace_back("--force");
        const testing::Ending ending = testing::run_program(command.words);
        EXPECT_EQ(ending.exit_status, 0) << command.words[0] << ending.error;
        EXPECT_NE(contents_of(folder / command.outputs.front()), "mine") << command.words[0];
        for (const std::string &output : command.outputs) {
            fs::remove(folder / output);
        }
        fs::remove(folder / "new.rec");
    }
    // A scene that cannot be loaded costs no record.
    testing::expect_refused(testing::run_program({"record", folder / "r.rec", "--force", "--scene",
                                                  folder / "none.glb"}),
                            "none.glb");
    EXPECT_EQ(testing::run_program({"replay", folder / "r.rec"}).exit_status, 0);
}

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
