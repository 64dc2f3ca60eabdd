// A command's options, over CLI11, whose headers take seconds in every file that includes them:
// only command.cpp and command_line.cpp do.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI
namespace springdrive::limits {
struct AutoTuned;
}

namespace springdrive::app {

/// Whether the help of an option lists the values that are accepted.
enum class InHelp : std::uint8_t { listed, unlisted };

/// An option of a command, which must outlive this. Each function returns the same option.
class Option {
public:
    explicit Option(CLI::Option *option) : option_(option) {}

    Option type_name(const std::string &name);
    Option required();
    Option delimiter(char letter);
    Option expected(int values);
    Option capture_default_str(); ///< in the help
    Option needs(const Option &other);
    Option excludes(const Option &other);
    Option one_of(const std::vector<std::string> &values, InHelp help = InHelp::listed);
    Option one_of_numbers(const std::vector<int> &values);
    Option in_range(int minimum, int maximum, InHelp help = InHelp::listed);
    /// @param error  of a typed value; empty: none
    Option check(const std::function<std::string(const std::string &)> &error);

    [[nodiscard]] bool is_given() const;
    [[nodiscard]] std::string name() const;

private:
    CLI::Option *option_;
};

/// A command of the program, which must outlive this.
class Command {
public:
    explicit Command(CLI::App *app) : app_(app) {}

    /// `value` is set by the parse. For the types that command.cpp lists.
    template <typename Value>
    Option add_option(const std::string &name, Value &value, const std::string &help);
    /// An option whose values have names, which its help does not list.
    template <typename Value>
    Option add_choice(const std::string &name, Value &value,
                      const std::map<std::string, Value> &names, const std::string &help);
    Option add_flag(const std::string &name, bool &flag, const std::string &help);
    Option add_flag_callback(const std::string &name, const std::function<void()> &call,
                             const std::string &help);
    Command add_subcommand(const std::string &name, const std::string &help);
    void require_subcommand();
    void allow_extras();
    void footer(const std::string &text);
    void callback(const std::function<void()> &call);

    [[nodiscard]] Option get_option(const std::string &name) const;
    [[nodiscard]] bool has_been_given(const std::string &option) const;

private:
    CLI::App *app_;
};

/// From a command's callback: ends the program with this status.
[[noreturn]] void end_with_status(int status);

// Every subcommand: each adds itself and its options to the command line, and runs when it is
// selected.

/// `demo`: the window.
void add_demo_command(Command &app);
/// `device`: lists devices, or emulates one on USB.
void add_device_command(Command &app);
/// `doctor`: what this computer allows and lacks.
void add_doctor_command(Command &app);
/// `record`: a session without a window, recorded at full rate.
void add_record_command(Command &app);
/// `replay`: a record through the control law again.
void add_replay_command(Command &app);
/// `export`: a record for other programs.
void add_export_command(Command &app);
/// `figures`: the paper's figures, measured beside their predictions.
void add_figures_command(Command &app);
/// `chart`: cost and accuracy of every method, in one run.
void add_chart_command(Command &app);
/// `stiffness`: the coupling K_θ over frequency, or its decrease as the motors heat up.
void add_stiffness_command(Command &app);
/// `stability`: whether a loop is stable, and its limits along one or two parameters.
void add_stability_command(Command &app);
/// `tune`: the stiffest tuning that is stable with every hand, as a file.
void add_tune_command(Command &app);
/// Its result, with margins and warnings on them, one line each.
void write_tuned(std::ostream &out, const limits::AutoTuned &found);
/// `baseline`: the spring drive against a current drive, each at its stable best.
void add_baseline_command(Command &app);
/// `touch`: the proxy over a scene along a path, without window or device.
void add_touch_command(Command &app);
/// `inspect`: the content of a scene, what can be touched, and the model that it gets.
void add_inspect_command(Command &app);
/// `study`: pilot studies.
void add_study_command(Command &app);

// The commands below `study`: each adds itself and its options to that one.

/// `new`: writes an included protocol.
void add_study_new_command(Command &study);
/// `check`: all that can be said of a protocol before anybody sits down.
void add_study_check_command(Command &study);
/// `plan`: how many trials a precision takes.
void add_study_plan_command(Command &study);
/// `run` and `resume`: sessions of participants.
void add_study_run_commands(Command &study);
/// `try`: a visitor's few minutes, of which nothing is stored.
void add_study_try_command(Command &study);
/// `status`: where a study stands.
void add_study_status_command(Command &study);
/// `export`: trials for other programs.
void add_study_export_command(Command &study);
/// `analyse`: thresholds, fits, groups and their pictures.
void add_study_analyse_command(Command &study);
/// `note` and `remove`: what is done to a study by hand.
void add_study_edit_commands(Command &study);

} // namespace springdrive::app
