// A command's options, over CLI11, whose headers take seconds in every file that includes them:
// only command.cpp, command_line.cpp and manual.cpp do.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
} // namespace CLI

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

} // namespace springdrive::app
