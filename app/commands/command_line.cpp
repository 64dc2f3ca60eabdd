#include "app/commands/command_line.h"

#include "app/commands/command.h"
#include "app/host/folders.h"
#include "base/print.h"
#include "base/text.h"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

namespace {

/// Text as troff prints it unchanged: hyphens that can be copied, and no line that is a request.
std::string troff(std::string_view text) {
    std::string escaped;
    bool begins_line = true;
    for (const char letter : text) {
        if (letter == '\\') {
            escaped += "\\e";
        } else if (letter == '-') {
            escaped += "\\-";
        } else {
            escaped += begins_line && (letter == '.' || letter == '\'') ? "\\&" : "";
            escaped += letter;
        }
        begins_line = letter == '\n';
    }
    return escaped;
}

bool takes_value(const CLI::Option &option) { return option.get_items_expected_max() > 0; }

/// "--scene", "-h": what can be typed for it.
std::vector<std::string> names_of(const CLI::Option &option) {
    std::vector<std::string> names;
    for (const std::string &name : option.get_snames()) {
        names.push_back("-" + name);
    }
    for (const std::string &name : option.get_lnames()) {
        names.push_back("--" + name);
    }
    return names;
}

/// The words of "springdrive device emulate" after the first.
std::string path_of(const CLI::App &command) {
    const CLI::App *const parent = command.get_parent();
    const std::string above = parent == nullptr ? "" : path_of(*parent);
    return parent == nullptr ? "" : above + (above.empty() ? "" : " ") + command.get_name();
}

/// The command and all below it, each before its own.
void add_all(const CLI::App &command, std::vector<const CLI::App *> &all) {
    all.push_back(&command);
    for (const CLI::App *each : command.get_subcommands(nullptr)) {
        add_all(*each, all);
    }
}

std::vector<const CLI::App *> all_commands(const CLI::App &program) {
    std::vector<const CLI::App *> all;
    for (const CLI::App *each : program.get_subcommands(nullptr)) {
        add_all(*each, all);
    }
    return all;
}

/// Lists of words have no blanks: a line can end after any comma.
std::string breakable(std::string text) {
    for (std::size_t at = text.find(','); at != std::string::npos; at = text.find(',', at + 3)) {
        text.insert(at + 1, "\\:");
    }
    return text;
}

void write_option(std::ostream &out, const CLI::Option &option) {
    const std::string name = option.get_positional()
                                 ? option.get_name(true)
                                 : fmt::format("{}", fmt::join(names_of(option), ", "));
    print(out, ".TP\n\\fB{}\\fR{}\n{}\n", troff(name),
          breakable(troff(CLI::Formatter().make_option_opts(&option))),
          troff(option.get_description()));
}

void write_command(std::ostream &out, const CLI::App &command) {
    print(out, ".SS springdrive {}\n{}\n", troff(path_of(command)),
          troff(command.get_description()));
    const CLI::Option *const help = command.get_help_ptr();
    for (const CLI::Option *option : command.get_options()) {
        if (option != help) {
            write_option(out, *option);
        }
    }
    if (!command.get_footer().empty()) {
        print(out, ".PP\n.nf\n{}\n.fi\n", troff(command.get_footer()));
    }
}

struct NamedText {
    std::string name;
    std::string text;
};

void write_section(std::ostream &out, std::string_view title, const std::vector<NamedText> &texts) {
    print(out, ".SH {}\n", title);
    for (const NamedText &each : texts) {
        print(out, ".TP\n.B {}\n{}\n", troff(each.name), troff(each.text));
    }
}

void write_surroundings(std::ostream &out) {
    const std::filesystem::path assets = asset_folder();
    const std::string documents = (assets.parent_path() / "doc/springdrive").string();
    write_section(out, "EXIT STATUS",
                  {{"0", "success"},
                   {"1", "a file or a value cannot be used, which one line on standard error says; "
                         "or the negative verdict of a command that gives one"},
                   {"2", "invalid options"}});
    write_section(
        out, "ENVIRONMENT",
        {{"SPRINGDRIVE_ASSETS", "the folder of devices, tunings, scenes, protocols and figures"},
         {"XDG_CACHE_HOME", "the folder of caches [~/.cache]"},
         {"XDG_STATE_HOME",
          "the folder of the assistant's progress, and of windings' temperatures [~/.local/state]"},
         {"XDG_CONFIG_HOME",
          "the folder of the window's settings, and of user-dirs.dirs, which names the documents "
          "[~/.config]"}});
    write_section(
        out, "FILES",
        {{assets.string(),
          "devices, tunings, scenes, protocols, and the scripts that draw the figures"},
         {"~/Documents/springdrive",
          "what is made in a window that was started from a menu; one that was started in a folder "
          "of its own uses that"},
         {"~/.config/springdrive/settings.toml",
          "what the window remembers; springdrive demo --reset-settings removes it"},
         {"~/.cache/springdrive", "measured models of scenes, which can be deleted at any time"},
         {"/etc/security/limits.d/springdrive.conf",
          "real-time priority and locked memory for the group springdrive"},
         {"70-springdrive.rules",
          "lets the person at the computer use a board on USB, once it is plugged in"},
         {documents, "how it works, and how to use it"}});
}

/// Words in bash's double quotes, in which none of ours needs an escape.
std::string words(const std::vector<std::string> &all) {
    return fmt::format("\"{}\"", fmt::join(all, " "));
}

/// A pattern of bash's `case`: COMMAND OPTION of each of the options.
std::string pattern(const CLI::App &command, const std::vector<std::string> &options) {
    std::string text;
    for (const std::string &option : options) {
        text += fmt::format("{}\"{} {}\"", text.empty() ? "" : " | ", path_of(command), option);
    }
    return text;
}

/// The words between the braces of a type such as "TEXT:{full,auto}"; else nothing.
std::vector<std::string> choices_of(const CLI::Option &option) {
    const std::string type = option.get_type_name();
    const std::size_t begin = type.find(":{");
    const std::size_t end = type.find('}', begin == std::string::npos ? 0 : begin);
    return begin == std::string::npos || end == std::string::npos
               ? std::vector<std::string>()
               : CLI::detail::split(type.substr(begin + 2, end - begin - 2), ',');
}

bool names_a_file(const CLI::Option &option) {
    const std::string type = option.get_type_name();
    return type.starts_with("FILE") || type.starts_with("PATH") || type.starts_with("DIR");
}

/// What can follow each option.
void write_values(std::ostream &out, const CLI::App &command) {
    std::vector<std::string> files;
    std::vector<std::string> others;
    for (const CLI::Option *option : command.get_options()) {
        if (!takes_value(*option) || option->get_positional()) {
            continue;
        }
        const std::vector<std::string> names = names_of(*option);
        const std::vector<std::string> choices = choices_of(*option);
        if (!choices.empty()) {
            print(out, "    {}) choices={} ;;\n", pattern(command, names), words(choices));
        } else {
            std::vector<std::string> &list = names_a_file(*option) ? files : others;
            list.insert(list.end(), names.begin(), names.end());
        }
    }
    if (!files.empty()) {
        print(out, "    {}) takes=files ;;\n", pattern(command, files));
    }
    if (!others.empty()) {
        print(out, "    {}) return ;;\n", pattern(command, others));
    }
}

/// What can follow where no option waits for its value.
void write_arguments(std::ostream &out, const CLI::App &command) {
    std::vector<std::string> options;
    std::vector<std::string> commands;
    bool takes_file = false;
    for (const CLI::Option *option : command.get_options()) {
        const std::vector<std::string> names = names_of(*option);
        options.insert(options.end(), names.begin(), names.end());
        takes_file = takes_file || (option->get_positional() && names_a_file(*option));
    }
    for (const CLI::App *each : command.get_subcommands(nullptr)) {
        commands.push_back(each->get_name());
    }
    print(out, "    \"{}\") options={} commands={}{} ;;\n", path_of(command), words(options),
          words(commands), takes_file ? " takes=files" : "");
}

/// Commands that have commands of their own.
std::vector<std::string> names_of_groups(const std::vector<const CLI::App *> &commands) {
    std::vector<std::string> names;
    for (const CLI::App *each : commands) {
        if (!each->get_subcommands(nullptr).empty()) {
            names.push_back(path_of(*each));
        }
    }
    return names;
}

} // namespace

void write_manual(std::ostream &out, const CLI::App &program) {
    print(out,
          ".\\\" Written from the program's command line: do not edit.\n"
          ".TH SPRINGDRIVE 1 \"\" \"springdrive {}\" \"User Commands\"\n"
          ".nh\n.ad l\n" // names of values are long, and must not be hyphenated
          ".SH NAME\nspringdrive \\- touch 3-D models with a haptic device, real or simulated\n"
          ".SH SYNOPSIS\n.B springdrive\n[\\fICOMMAND\\fR] [\\fIOPTION\\fR]...\n"
          ".SH DESCRIPTION\n{}\n.PP\n"
          "Without a command it opens the window. Its key F1 lists all keys.\n"
          ".SH OPTIONS\n",
          troff(program.version()), troff(program.get_description()));
    for (const CLI::Option *option : program.get_options()) {
        write_option(out, *option);
    }
    print(out, ".SH COMMANDS\n");
    for (const CLI::App *command : all_commands(program)) {
        write_command(out, *command);
    }
    write_surroundings(out);
}

void write_bash_completion(std::ostream &out, const CLI::App &program) {
    const std::vector<const CLI::App *> commands = all_commands(program);
    print(out, R"(# shellcheck shell=bash
# Completion of springdrive's commands, options and values: written from the program's command line.
_springdrive() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
    local command=${{COMP_WORDS[1]}} options="" commands="" choices="" takes="" before
    COMPREPLY=()
    # --option=value is three words to bash.
    if [[ $word == = ]]; then
        word=""
    elif [[ $previous == = ]]; then
        previous=${{COMP_WORDS[COMP_CWORD - 2]}}
    fi
    if ((COMP_CWORD == 1)) && [[ $word != -* ]]; then
        command=""
    elif [[ $command == -* ]]; then
        command=demo
    elif ((COMP_CWORD > 2)) && [[ " {} " == *" $command "* ]]; then
        command+=" ${{COMP_WORDS[2]}}"
    fi
    case "$command $previous" in
)",
          fmt::join(names_of_groups(commands), " "));
    for (const CLI::App *command : commands) {
        write_values(out, *command);
    }
    print(out, R"(    *)
        case $command in
)");
    write_arguments(out, program);
    for (const CLI::App *command : commands) {
        write_arguments(out, *command);
    }
    print(out, R"(        esac
        choices=$commands
        if [[ $word == -* ]]; then
            choices=$options
            takes=""
        fi
        ;;
    esac
    if [[ $takes == files ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    else
        # Lists are separated by commas: only the last word is completed.
        before=${{word%"${{word##*,}}"}}
        mapfile -t COMPREPLY < <(compgen -P "$before" -W "$choices" -- "${{word##*,}}")
    fi
}}
complete -F _springdrive springdrive
)");
}

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
    const std::string command = path_of(chosen_command(app));
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
        std::cerr << "springdrive: " << as_utf8(unknown_argument_text(app)) << '\n';
        return kUsageMistake;
    } catch (const CLI::ParseError &error) {
        const std::string command = path_of(chosen_command(app));
        std::cerr << "springdrive: " << as_utf8(error.what()) << "; see springdrive "
                  << (command.empty() ? "" : command + " ") << "--help\n";
        return kUsageMistake;
    }
    return 0;
}

} // namespace springdrive::app
