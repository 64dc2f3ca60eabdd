#include "app/commands/command_line.h"

#include "app/commands/command.h"

#include "base/text.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstddef>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

constexpr int kUsageMistake = 2;

/// The arguments, with `demo` inserted if they have no subcommand.
std::vector<std::string> arguments(int argc, char **argv) {
    std::vector<std::string> typed(argv + std::min(1, argc), argv + argc);
    const auto asks_the_program = [](const std::string &first) {
        return first == "--help" || first == "-h" || first == "--version";
    };
    if (typed.empty() || (typed[0].substr(0, 1) == "-" && !asks_the_program(typed[0]))) {
        typed.insert(typed.begin(), "demo");
    }
    return typed;
}

/// The command that was typed: of "study run --x" that is run.
const CLI::App &chosen_command(const CLI::App &app) {
    const auto chosen = app.get_subcommands();
    return chosen.empty() ? app : chosen_command(*chosen.front());
}

/// Its words after the program's: "study run".
std::string words_of(const CLI::App &app) {
    const auto chosen = app.get_subcommands();
    if (chosen.empty()) {
        return {};
    }
    const std::string below = words_of(*chosen.front());
    return chosen.front()->get_name() + (below.empty() ? "" : " " + below);
}

/// The names that could have been typed in place of `typed`: options, or commands.
std::vector<std::string> possible_names(const CLI::App &app, const std::string &typed) {
    const CLI::App &command = chosen_command(app);
    std::vector<std::string> names;
    if (!typed.starts_with("-")) {
        for (const CLI::App *other : command.get_subcommands({})) {
            names.push_back(other->get_name());
        }
        return names;
    }
    for (const CLI::Option *option : command.get_options()) {
        for (const std::string &name : option->get_lnames()) {
            names.push_back("--" + name);
        }
    }
    return names;
}

/// "--sceen is no option of demo; did you mean --scene? See springdrive demo --help"
std::string unknown_argument_text(const CLI::App &app) {
    const std::vector<std::string> unknown = app.remaining(true);
    // CLI11 lists them from the last to the first; what follows an unknown option is its value.
    const auto option = std::ranges::find_if(
        unknown, [](const std::string &word) { return word.starts_with("-"); });
    const std::string &word = option != unknown.end() ? *option : unknown.front();
    const std::string typed = word.substr(0, word.find('='));
    const bool is_option = typed.starts_with("-");
    const std::string command = words_of(app);
    std::string text = typed + (is_option         ? " is no option of " + command
                                : command.empty() ? " is no command"
                                                  : " was not expected by " + command);
    std::vector<std::string> names = possible_names(app, typed);
    sort_by_similarity(names, typed,
                       [](const std::string &name) { return std::string_view(name); });
    constexpr std::size_t kMaxLetters = 3; // more is another word
    const bool is_near = !names.empty() && letters_between(typed, names.front()) <= kMaxLetters;
    text += is_near ? "; did you mean " + names.front() + "? See" : "; see";
    return text + " springdrive " + (command.empty() ? "" : command + " ") + "--help";
}

/// Counts characters, not bytes, so that units such as Ω do not shift the next column.
class LetterFormatter : public CLI::Formatter {
public:
    std::string make_option(const CLI::Option *option, bool is_positional) const override {
        const std::string name = make_option_name(option, is_positional) + make_option_opts(option);
        const auto letters = static_cast<std::size_t>(
            std::count_if(name.begin(), name.end(), [](char c) { return (c & 0xC0) != 0x80; }));
        constexpr std::size_t kIndent = 2;
        const bool fits = name.size() + kIndent < column_width_;
        std::ostringstream line;
        CLI::detail::format_help(line, name, make_option_desc(option),
                                 column_width_ + (fits ? name.size() - letters : 0));
        return line.str();
    }
};

} // namespace

std::unique_ptr<CLI::App> command_tree() {
    auto tree = std::make_unique<CLI::App>(
        "Touch glTF meshes with a PHANTOM, simulated or real, through spring-drive control.",
        "springdrive");
    CLI::App &app = *tree;
    app.formatter(std::make_shared<LetterFormatter>()); // before the subcommands, which inherit it
    app.set_version_flag("--version", SPRINGDRIVE_VERSION);
    app.require_subcommand(0, 1); // with 1, 1 the error would not name the invalid word
    app.footer("Options without a subcommand are those of demo: springdrive --scene FILE.\n"
               "For the options of a subcommand: springdrive stiffness --help.");
    Command program(tree.get());
    add_demo_command(program);
    add_device_command(program);
    add_doctor_command(program);
    add_record_command(program);
    add_replay_command(program);
    add_export_command(program);
    add_figures_command(program);
    add_chart_command(program);
    add_stiffness_command(program);
    add_stability_command(program);
    add_tune_command(program);
    add_baseline_command(program);
    add_touch_command(program);
    add_inspect_command(program);
    add_study_command(program);
    return tree;
}

int run_command_line(int argc, char **argv) {
    const std::unique_ptr<CLI::App> tree = command_tree();
    CLI::App &app = *tree;
    std::vector<std::string> reversed = arguments(argc, argv); // as CLI11 takes them
    if (std::find(reversed.begin(), reversed.end(), "") != reversed.end()) {
        std::cerr << "springdrive: an argument is empty; give its value, or omit its option\n";
        return kUsageMistake;
    }
    std::reverse(reversed.begin(), reversed.end());
    try {
        app.parse(reversed);
    } catch (const CLI::Success &request) {
        return app.exit(request); // prints what --help or --version asked for
    } catch (const CLI::RuntimeError &verdict) {
        return verdict.get_exit_code(); // of a command that completed with a negative verdict
    } catch (const CLI::ExtrasError &) {
        std::cerr << "springdrive: " << unknown_argument_text(app) << '\n';
        return kUsageMistake;
    } catch (const CLI::ParseError &error) {
        const std::string command = words_of(app);
        std::cerr << "springdrive: " << error.what() << "; see springdrive "
                  << (command.empty() ? "" : command + " ") << "--help\n";
        return kUsageMistake;
    }
    return 0;
}

} // namespace springdrive::app
