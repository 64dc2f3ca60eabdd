// Covers app/commands/{command_line,manual}.cpp: help, manual page and completion have what the
// command line has. And what every command refuses: each bound from its wrong side, files that
// cannot be used, and options that do not go together; from outside, by one line, before anything
// is done.
#include "app/commands/command_line.h"
#include "base/text.h"
#include "engine/lab/loops/stability_case.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

TEST(CommandLine, HelpAndVersionArePlainText) {
    struct Case {
        std::vector<std::string> words;
        std::vector<const char *> says;
    };
    for (const Case &one :
         {Case{{"--help"}, {"demo", "figures", "stiffness", "touch", "inspect", "--scene"}},
          Case{{"stiffness", "--help"}, {"--freq-from"}},
          Case{{"--lockstep", "--help"}, {"--lockstep"}},
          Case{{"--version"}, {SPRINGDRIVE_VERSION}}}) {
        const testing::Ending help = testing::run_program(one.words);
        EXPECT_EQ(help.exit_status, 0);
        for (const char *part : one.says) {
            EXPECT_NE(help.out.find(part), std::string::npos) << part << " in\n" << help.out;
        }
        for (const char c : help.out) {
            EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << help.out;
        }
    }
}

TEST(CommandLine, ErrorsAreUtf8WhateverIsTyped) {
    testing::expect_refused(testing::run_program({"inspect", "a\n b.glb"}), "b.glb: ");
    for (const std::vector<std::string> &words :
         {std::vector<std::string>{"inspect", "n\xff\xe2\x82.glb"},
          {"study", "check", "n\xff\xe2\x82.toml"},
          {"--n\xff\xe2\x82"},
          {"record", "x.rec", "--seconds", "n\xff\xe2\x82"}}) {
        const testing::Ending ending = testing::run_program(words);
        testing::expect_refused(ending, "n\\xff\\xe2\\x82");
        EXPECT_TRUE(is_utf8(ending.error)) << ending.error;
    }
}

std::string manual() {
    std::ostringstream out;
    write_manual(out, *command_tree());
    return out.str();
}

std::size_t count(const std::string &text, const std::string &part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++found;
    }
    return found;
}

TEST(Manual, NamesEveryCommandAndOption) {
    const std::string page = manual();
    const auto program = command_tree();
    std::size_t options = 0;
    for (const CLI::App *command : program->get_subcommands(nullptr)) {
        EXPECT_EQ(count(page, "\n.SS springdrive " + command->get_name() + "\n"), 1U);
        for (const CLI::Option *option : command->get_options()) {
            for (const std::string &name : option->get_lnames()) {
                std::string escaped = "\\-\\-";
                for (const char letter : name) {
                    escaped += letter == '-' ? "\\-" : std::string(1, letter);
                }
                EXPECT_NE(page.find(escaped), std::string::npos) << name;
                ++options;
            }
        }
    }
    EXPECT_GT(options, 100U);
    EXPECT_EQ(count(page, "\n.SS springdrive device emulate\n"), 1U);
    EXPECT_NE(page.find("\n.SH FILES\n"), std::string::npos);
    EXPECT_EQ(page.find("{false}"), std::string::npos) << "a name that cannot be typed";
}

TEST(Manual, HasNoLineThatTroffWouldTakeForARequestByMistake) {
    const std::set<std::string> requests{".TH", ".SH", ".SS", ".TP", ".PP",  ".B",
                                         ".nh", ".ad", ".nf", ".fi", ".\\\""};
    std::istringstream page(manual());
    for (std::string line; std::getline(page, line);) {
        ASSERT_FALSE(line.starts_with("'")) << line;
        EXPECT_TRUE(!line.starts_with(".") || requests.contains(line.substr(0, line.find(' '))))
            << line;
    }
}

/// What bash offers for the last of these words.
std::string completed(const std::filesystem::path &script, const std::vector<std::string> &words) {
    std::string command = "bash -c 'source " + script.string() + "; COMP_WORDS=(springdrive";
    for (const std::string &word : words) {
        command += " \"" + word + "\"";
    }
    command += "); COMP_CWORD=" + std::to_string(words.size()) +
               "; _springdrive; echo \"${COMPREPLY[*]}\"' 2>&1";
    FILE *const pipe = popen(command.c_str(), "r");
    std::string answer;
    for (int letter = std::fgetc(pipe); letter != EOF; letter = std::fgetc(pipe)) {
        answer += static_cast<char>(letter);
    }
    EXPECT_EQ(pclose(pipe), 0) << command;
    return answer.substr(0, answer.find('\n'));
}

TEST(Completion, OffersCommandsOptionsValuesAndFiles) {
    const std::filesystem::path folder = testing::fresh_folder("completion");
    const std::string file = folder / "my.gltf";
    std::ofstream(file) << "{}";
    const std::string begun = folder / "my";
    std::ofstream(folder / "script") << [] {
        std::ostringstream out;
        write_bash_completion(out, *command_tree());
        return out.str();
    }();
    struct Case {
        std::vector<std::string> words;
        std::string offered;
    };
    for (const Case &one : {
             Case{{"sti"}, "stiffness"},
             Case{{"nothing"}, ""},
             Case{{"demo", "--locks"}, "--lockstep"},
             Case{{"stiffness", "--locks"}, ""},
             Case{{"--locks"}, "--lockstep"}, // without a command, those of demo
             Case{{"demo", "--model", ""}, "full auto"},
             Case{{"demo", "--model", "=", "a"}, "auto"},
             Case{{"demo", "--model", "="}, "full auto"},
             Case{{"demo", "--without", "gravity,vis"}, "gravity,viscous_friction"},
             Case{{"demo", "--seconds", ""}, ""},
             Case{{"device", "emu"}, "emulate"},
             Case{{"device", "emulate", "--clock", "w"}, "wall"},
             Case{{"demo", "--scene", begun}, file},
             Case{{"demo", begun}, file},
             Case{{"inspect", begun}, file},
             Case{{"demo", "--servo-hz", begun}, ""},
             Case{{"stiffness", begun}, ""},
         }) {
        EXPECT_EQ(completed(folder / "script", one.words), one.offered) << one.words.back();
    }
    EXPECT_NE(completed(folder / "script", {""}).find("stability"), std::string::npos);
}

namespace fs = std::filesystem;

struct Refusal {
    const char *typed; ///< words between blanks, with a bar between alternatives, each of which is
                       ///< refused; @ is a folder, % that of the assets
    int status;        ///< 1 of a value or file that cannot be used, 2 of an invalid option
    const char *names;
};

const std::vector<Refusal> kOptionsOfTheDemo{
    {"--servo-hz 99|10001|nan", 1, "250"},
    {"--servo-hz fast", 2, "fast"},
    {"--dR 0", 1, "--dR"},
    {"--kp nan", 1, "K_P"},
    {"--map sideways", 2, "sideways"},
    {"--map 0", 2, "transpose"},
    {"--alpha-mode often", 2, "by_hand"},
    {"--delay -1", 1, "delay"},
    {"--device serial", 1, "serial"},
    {"--device usb --delay 1", 1, "--delay"},
    {"--device-file|--tuning-file|--path none.toml", 1, "none.toml"},
    {"--lockstep", 1, "--frames"},
    {"--frames -3", 1, "frames"},
    {"--lockstep --frames 2 --screenshot /no/such/folder/s.png", 1, "/no/such/folder/s.png"},
    {"--frames 1 --screenshot @/both --record @/./both", 1, "is named for two outputs"},
};

/// Of what is not for visitors.
const std::vector<Refusal> kKiosks{
    {"--scene a.gltf", 1, "--scene: not with --kiosk"},
    {"--gltf-scene a", 1, "--gltf-scene: not with --kiosk"},
    {"a.gltf", 1, "file: not with --kiosk"},
    {"--open a.rec", 1, "--open: not with --kiosk"},
    {"--at-zero", 1, "--at-zero: not with --kiosk"},
    {"--assistant", 1, "--assistant: not with --kiosk"},
    {"--path a.csv", 1, "--path: not with --kiosk"},
    {"--settings a", 1, "--settings: not with --kiosk"},
    {"--model auto", 1, "--model auto: not with --kiosk"},
    {"--log /nowhere/day.log", 1, "--log /nowhere/day.log: cannot be written"},
    {"--log /dev/full", 1, "--log /dev/full: cannot be written"},
};

const std::vector<Refusal> kSessions{
    {"--model auto --without gravity", 1, "give one or the other"},
    {"--plant-model full --with gravity", 1, "give one or the other"},
    {"--cpu 1023", 1, "--cpu 1023: this process may run on processors"},
    {"--late-limit-ms 0", 1, "--late-limit-ms"},
    {"--late-limit-ms 51", 1, "to 50"},
    {"--device-seed -3", 2, "--device-seed"},
    {"--plant-model fullest", 2, "--plant-model"},
    {"--step-us 0.5", 1, "--step-us is 0.5; it must be from 1 to 4000"},
    {"--step-us 4001", 1, "--step-us is 4001"},
    {"--contact-shape simplified_1", 1, "--contact-shape simplified_1"},
    {"--contact-shape primitives --scene %/scenes/stepped_block.gltf", 1,
     "cannot be touched as 'primitives'"},
    {"--fault stop", 1, "give --device emulated"},
    {"--true-device-file %/devices/phantom_1_0.toml", 1, "give --device emulated"},
    {"--device emulated --fault stopp", 1, "nearest name is 'stop'"},
    {"--device emulated --step-us 50", 1, "--step-us"},
    {"--device emulated --plant-model full", 1, "--plant-model"},
    {"--device emulated --delay 9", 1, "the delay is 9 periods"},
    {"--device emulated:4711", 1, "4711"},
    {"--device emulator", 1, "must be sim, usb, usb:SERIAL or emulated"},
};

const std::vector<Refusal> kOthers{
    // Words, and files without an option.
    {"--frams 3", 2, "frams"},
    {"stifness", 2, "stifness is no command; did you mean stiffness? See springdrive --help"},
    {"--sceen x.gltf", 2, "--sceen is no option of demo; did you mean --scene?"},
    {"demo --sceen x.gltf", 2, "--sceen is no option of demo; did you mean --scene?"},
    {"--frames 3 --sceen=x", 2, "--sceen is no option of demo; did you mean --scene?"},
    {"stiffness --dr 1", 2, "did you mean --dR?"},
    {"--entirely-else", 2, "--entirely-else is no option of demo; see springdrive demo --help"},
    {"study run x.toml --particpant P01", 2, "--particpant"},
    {"record a.rec b.rec", 2, "b.rec was not expected by record"},
    {"stability --kp 6,5", 2, "--kp = 6,5"},
    {"stability --kp 1e", 2, "--kp = 1e"},
    {"demo --log day.log", 1, "add --kiosk"},
    {"demo @/none.rec", 1, "none.rec: not found; --open takes a record"},
    {"demo a.gltf --scene b.gltf", 2, "--scene"},
    {"demo a.gltf --open b.gltf", 2, "--open"},
    {"device info --device sim:sim-1", 1, "must be sim, usb, usb:SERIAL or emulated"},
    // Inputs that never end, and outputs that cannot be written.
    {"stiffness --device-file|--tuning-file /dev/zero", 1, "/dev/zero: is no ordinary file"},
    {"touch sphere:1280 --path /dev/zero", 1, "/dev/zero: is no ordinary file"},
    {"inspect /dev/zero", 1, "/dev/zero"},
    {"stiffness --csv /no/such/folder/k.csv", 1, "/no/such/folder/k.csv"},
    {"stiffness --csv /dev/full", 1, "/dev/full"},
    {"inspect sphere:1280 --no-model --json /dev/full", 1, "/dev/full"},
    {"touch sphere:1280 --steps 9 --json /dev/full", 1, "/dev/full"},
    {"baseline --csv @/none/x.csv", 1, "none/x.csv"},
    {"device calibrate --out @/none/mine.toml", 1, "none"},
    {"tune --out @|@/", 1, "is a folder"},
    {"tune --out @/none/t.toml", 1, "its folder does not exist"},
    {"tune --out /proc/x.toml", 1, "/proc/x.toml: cannot be written"}, // also by root
    {"chart|figures --out @/file/below", 1, "below"},
    {"record /no/such/folder/t.rec", 1, "/no/such"},
    {"record @/x.rec --json @/x.rec", 1, "x.rec"},
    {"record @/x.rec --json @/no/x.json", 1, "x.json"},
    {"record -", 1, "record"},
    // baseline
    {"baseline --servo-hz 100", 1, "250 to 10000"},
    {"baseline --delay 9", 1, "from 0 to 8"},
    {"baseline --dR 0", 1, "dR is 0"},
    {"baseline --margin 0.5", 1, "from 1 to 10"},
    // chart and figures
    {"chart|figures", 2, "--out"},
    {"chart --out @/a --only everything", 2, "servo_rate_stiffness"},
    {"chart --out @/a --repeats 0", 1, "--repeats is 0; it must be from 1 to"},
    {"chart --out @/a --repeats 101", 1, "to 100"},
    {"chart|figures --out @/a --tuning-file none.toml", 1, "none.toml"},
    {"figures --out @/a --q 0,20", 2, "--q"},
    {"figures --out @/a --q 0,20,nan", 1, "--q"},
    {"figures --out @/a --q 0,45,-25", 1, "joint_limits"},
    {"figures --out @/a --q 0,-45,45", 1, "q3 - q2 is 90"},
    {"figures --out @/a --q 0,20,215", 1, "q3 is 215"},
    {"figures --out @/a --device-seed 0", 2, "--device-seed"},
    // device
    {"device calibrate --air-C 77", 1, "--air-C"},
    {"device calibrate --dR 0", 1, "--dR"},
    {"device calibrate --motion-seconds 0", 1, "--motion-seconds"},
    {"device calibrate --device-file @/bad.toml", 1, "calibration.serial"},
    {"device sweep --tip-force nan|9", 1, "--tip-force is"},
    {"device sweep --motion 0.006", 1, "--motion is 0.006"},
    {"device sweep --freq-to 0|251", 1, "--freq-to is"},
    {"device sweep --freq-from 20 --freq-to 20", 1, "--freq-from must be below"},
    {"device sweep --points 201", 1, "--points is 201"},
    {"device sweep --tolerance nan", 1, "--tolerance is nan"},
    {"device sweep --servo-hz 249", 1, "servo rate is 249"},
    {"device sweep --dR nan", 1, "--dR"},
    {"device sweep --svg k.png", 1, "must be a file that ends in .svg"},
    {"device sweep --motors 4|2,2", 1, "--motors"},
    // doctor: a mistyped value is no finding, so its status is that of every mistyped option
    {"doctor --device bus|sim:1", 2, "--device"},
    {"doctor --servo-hz 0|nan|x", 2, "--servo-hz"},
    {"doctor --jsno", 2, "--jsno"},
    // export, record and replay
    {"record @/x.rec --seconds -1", 1, "--seconds"},
    {"replay @/none.rec", 1, "none.rec"},
    {"replay @/file", 1, "file"},
    {"export @/file --list", 1, "file"},
    // inspect
    {"inspect|touch", 2, "scene"},
    {"inspect|touch none.glb", 1, "none.glb"},
    {"inspect %/scenes", 1, "/scenes"},
    {"inspect bumpy:7", 1, "1310720"},
    {"inspect|touch %/scenes/plate.gltf --gltf-scene attic", 1, "plate.gltf: has no scene 'attic'"},
    {"inspect|touch sphere:1280 --gltf-scene attic", 1, "'attic'"},
    {"demo --scene %/scenes/plate.gltf --gltf-scene attic", 1, "'attic'"},
    {"record @/x.rec --scene %/scenes/plate.gltf --gltf-scene attic", 1, "'attic'"},
    {"inspect|touch sphere:1280 --device-file none.toml", 1, "none.toml"},
    // stability
    {"stability --kp -1|nan", 1, "kp"},
    {"stability --dR 0", 1, "not 0"},
    {"stability --servo-hz 0", 1, "from 1 to 100000"},
    {"stability --servo-hz nan", 1, "--servo-hz"},
    {"stability --delay -1|8.001", 1, "0 to 8"},
    {"stability --eta 1.1", 1, "0 to 1"},
    {"stability --eta", 2, "--eta: 1 required VALUE missing"},
    {"stability --hand-mass -0.1", 1, "0 to 100"},
    {"stability --hand-mass 0.1 --no-hand", 1, "--no-hand"},
    {"stability --inertia 0", 1, "inertia"},
    {"stability --inertia -1e-5", 1, "1e-12 to 1000"},
    {"stability --damping -1", 1, "0 to 1000"},
    {"stability --inertia 1e-5 --motors 3", 1, "--motors"},
    {"stability --motors 2", 2, "--motors"},
    {"stability --drive hydraulic", 2, "--drive"},
    {"stability --structure bolts|1.1|-0.1|nan", 1, "the cable's share, 0 to 1"},
    {"stability --structure cable --inertia 1e-5", 1, "omit --structure"},
    {"stability --q 0,20", 2, "--q"},
    {"stability --q 0,200,0", 1, "q"},
    {"stability --tuning-file none.toml", 1, "none.toml"},
    {"stability|tune --device-file none.toml", 1, "none.toml"},
    {"stability --vary gain", 1, "kp, kd, lambda"},
    {"stability --vary kp --from 1|10 --to 1", 1, "the first must be below"},
    {"stability --vary T --from 0", 1, "1e-06 to 1"},
    {"stability --vary kp --to 1e9", 1, "0 to 10000"},
    {"stability --vary kp --from nan", 1, "kp"},
    {"stability --vary d --to 8.5", 1, "0 to 8 periods"},
    {"stability --from 1", 2, "--vary"},
    {"stability --map kp,kp --out x.svg", 1, "twice"},
    {"stability --map kp --out x.svg", 2, "--map"},
    {"stability --map kp,gain --out x.svg", 1, "gain"},
    {"stability --map kp=5,kd|kp=1:2x,kd --out x.svg", 1, "NAME=FROM:TO"},
    {"stability --map kp=5:1,kd --out x.svg", 1, "below"},
    {"stability --map kp,kd", 2, "--out"},
    {"stability --map kp,kd --out x.png", 1, ".svg"},
    {"stability --map kp,kd --out /no/such/folder/x.svg", 1, "/no/such/folder"},
    {"stability --map kp,kd --out x.svg --steps 1|401", 1, "--steps"},
    // What means nothing to the loop, or to the table, whose rows have drives and servos of their
    // own.
    {"stability --motors 3 --vary inertia", 1, "--vary inertia"},
    {"stability --drive current --vary kp", 1, "spring drive"},
    {"stability --vary wall-stiffness", 1, "--drive current"},
    {"stability --kinematics inverse --vary alpha", 1, "transpose"},
    {"stability --no-hand --vary hand-mass", 1, "--no-hand"},
    {"stability --map kp,wall-damping --out none.svg", 1, "--map wall-damping"},
    {"stability --table --tuning-file x.toml", 2, "--tuning-file excludes --table"},
    {"stability --table --kinematics inverse", 2, "--kinematics excludes --table"},
    {"stability --table --drive current", 2, "--drive excludes --table"},
    {"stability --table --motors 3", 2, "--motors excludes --table"},
    {"stability --table --structure all", 2, "--structure excludes --table"},
    {"stability --table --hand-mass -0.1", 1, "0 to 100"}, // taken until values are checked
    {"stability --table --q nan,0,0", 1, "--q"},
    {"stability --table --no-hand --device-file none.toml", 1, "none.toml"},
    // stiffness
    {"stiffness --freq-from 50 --freq-to 20", 1, "--freq-from"},
    {"stiffness --freq-to 500.1|inf", 1, "500"},
    {"stiffness --servo-hz 2000 --freq-to 1000.1", 1, "1000"},
    {"stiffness --freq-from 0", 1, "from 0.01"},
    {"stiffness --freq-from nan", 1, "--freq-from"},
    {"stiffness --points 1", 1, "--points"},
    {"stiffness --points 2.5", 2, "--points"},
    {"stiffness|tune --servo-hz 249", 1, "250"},
    {"stiffness --delay 8.01", 1, "--delay"},
    {"stiffness --kp nan", 1, "K_P"},
    {"stiffness --dR 0", 1, "--dR"},
    {"stiffness --motor 2.18,-0.000238,0.0234", 1, "--motor: L"},
    {"stiffness --motor 0,0.000238,0.0234", 1, "--motor: R"},
    {"stiffness --motor 2.18,0.000238,nan", 1, "--motor: kT"},
    {"stiffness --motor 2.18,0.000238", 2, "--motor"},
    {"stiffness --motor 0.3,0.000238,0.0234", 1, "dR is 0.5"}, // of 0.3
    {"stiffness --eta 0.5", 2, "--eta"},                       // does not affect the coupling
    {"stiffness demo", 2, "demo"},
    {"stiffness --seconds 60", 2, "--hold"},
    {"stiffness --hold 1 --points 5", 1, "--points"},
    {"stiffness --hold nan", 1, "nan"},
    {"stiffness --hold -1", 1, "-1"},
    {"stiffness --hold 1 --seconds 0", 1, "0"},
    // touch
    {"touch sphere:1000", 1, "1310720"},
    {"touch sphere:1280 --path slid", 1, "slid"},
    {"touch sphere:1280 --path @/hand.csv --speed 1", 1, "--speed"},
    {"touch sphere:1280 --path @/bad.csv", 1, "bad.csv:3:"},
    {"touch sphere:1280 --path @/long.csv", 1, "1000000"},
    {"touch sphere:1280 --speed 0|101", 1, "--speed"},
    {"touch sphere:1280 --depth -1e-3|1.1", 1, "--depth"},
    {"touch sphere:1280 --radius -1e-3|0.11", 1, "--radius"},
    {"touch sphere:1280 --steps 0|1000001", 1, "--steps"},
    {"touch sphere:1280 --check -1|any|1000001", 1, "--check"},
    {"touch sphere:1280 --slack 1e-12|6e-9", 1, "--slack"},
    {"touch sphere:1280 --servo-hz 249", 1, "250"},
    {"touch sphere:1280 --seed -1", 1, "--seed"},
    {"touch sphere:1280 --csv - --json -", 1, "--json"},
    {"touch sphere:1280 more", 2, "more"},
    // tune
    {"tune --dR 0", 1, "0.02 to 2.18"},
    {"tune --delay 9", 1, "--delay"},
    {"tune --margin 0.9|11", 1, "1 to 10"},
    {"tune --kinematics forward", 2, "--kinematics"},
};

class Refusals : public ::testing::Test {
protected:
    Refusals() {
        write("file", "in the way");
        write("bad.toml", testing::contents_of(testing::assets() / "devices/phantom_1_0.toml") +
                              "\n[calibration]\nserial = 7\n");
        write("hand.csv", "0,0,0.06,0\n0.1,0,0.048,0\n");
        write("bad.csv", "t,x,y,z\n0,0,0.06,0\n1,0,oops,0\n");
        write("long.csv", "t,x,y,z\n0,0,0.06,0\n1,0,0,0\n5000,0,0,0\n");
    }

    void write(const char *name, const std::string &text) const {
        std::ofstream(folder_ / name) << text;
    }

    void expect(const std::string &before, const Refusal &refusal, const std::string &after) const {
        expect_each(before + refusal.typed + after, refusal);
    }

private:
    void expect_each(const std::string &typed, const Refusal &refusal) const {
        const std::size_t bar = typed.find('|');
        if (bar == std::string::npos) {
            expect_one(typed, refusal);
            return;
        }
        const std::size_t begin = typed.rfind(' ', bar) + 1; // 0 of the first word
        const std::size_t end = std::min(typed.find(' ', bar), typed.size());
        expect_each(typed.substr(0, bar) + typed.substr(end), refusal);
        expect_each(typed.substr(0, begin) + typed.substr(bar + 1), refusal);
    }

    /// That nothing was made, either.
    void expect_one(const std::string &typed, const Refusal &refusal) const {
        SCOPED_TRACE(typed);
        std::vector<std::string> words;
        std::istringstream all(typed);
        for (std::string word; all >> word;) {
            for (const auto &[letter, path] : {std::pair('@', folder_), {'%', testing::assets()}}) {
                if (const std::size_t at = word.find(letter); at != std::string::npos) {
                    word.replace(at, 1, path.string());
                }
            }
            words.push_back(word);
        }
        const testing::Ending ending = testing::run_program(words);
        testing::expect_refused(ending, refusal.names);
        EXPECT_EQ(ending.exit_status, refusal.status);
        fs::remove_all(folder_ / "a"); // the folder of figures, which is made first
        EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 5);
        EXPECT_TRUE(fs::is_empty(cache_));
    }

    fs::path folder_ = testing::fresh_folder("refusals");
    fs::path cache_ = testing::fresh_folder("refusals_cache"); ///< of models, which stays empty
    testing::Variable cache_variable_{"XDG_CACHE_HOME", cache_};
};

TEST_F(Refusals, OfTheDemo) {
    for (const Refusal &refusal :
         kOptionsOfTheDemo) { // a scene that loads without lines of progress
        expect("", refusal, " --scene %/scenes/plate.gltf");
    }
}

TEST_F(Refusals, OfKiosks) {
    for (const Refusal &refusal : kKiosks) {
        expect("demo --kiosk ", refusal, "");
    }
}

TEST_F(Refusals, OfSessions) {
    for (const Refusal &refusal : kSessions) {
        expect("record @/x.rec --lockstep --seconds 0.01 ", refusal, "");
    }
}

TEST_F(Refusals, OfTheOtherCommands) {
    for (const Refusal &refusal : kOthers) {
        expect("", refusal, "");
    }
}

TEST_F(Refusals, OfParametersThatMeanNothingToTheTable) {
    for (const loops::StabilityParameter &parameter : loops::stability_parameters()) {
        const std::string name(parameter.name);
        if (!name.starts_with("hand")) {
            const std::string option = name == "d"   ? "--delay"
                                       : name == "T" ? "--servo-hz"
                                                     : "--" + name;
            const std::string says = option + " excludes --table";
            expect("stability --table " + option, {" 1", 2, says.c_str()}, "");
        }
    }
}

TEST_F(Refusals, OfEmptyArgumentsAndNames) {
    for (const std::vector<std::string> &words :
         {std::vector<std::string>{"stiffness", "--dR", ""}, {""}, {"--scene", ""}}) {
        testing::expect_one_line(testing::run_program(words), 2, "empty");
    }
    testing::expect_one_line(testing::run_program({"stability", "--kp", "6 5"}), 2, "--kp = 6 5");
    testing::expect_one_line(testing::run_program({"stability", "--eta="}), 2, "--eta: 1 required");
    testing::expect_one_line(testing::run_program({"--device", "usb:none such", "--scene",
                                                   testing::assets() / "scenes/plate.gltf"}),
                             1, "USB");
    testing::expect_one_line(
        testing::run_program({"tune", "--out", "/tmp/" + std::string(300, 'x')}), 1,
        "cannot be written");
}

} // namespace
} // namespace springdrive::app
