#include "app/commands/command.h"

#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/store/study_contents.h"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <optional>

namespace springdrive::app {

namespace {

/// Its list of values is part of an option's help, unless it is removed.
CLI::Validator described(CLI::Validator validator, InHelp help) {
    return help == InHelp::listed ? validator : validator.description("");
}

} // namespace

Option Option::type_name(const std::string &name) { return Option(option_->type_name(name)); }

Option Option::required() { return Option(option_->required()); }

Option Option::delimiter(char letter) { return Option(option_->delimiter(letter)); }

Option Option::expected(int values) { return Option(option_->expected(values)); }

Option Option::capture_default_str() { return Option(option_->capture_default_str()); }

Option Option::needs(const Option &other) { return Option(option_->needs(other.option_)); }

Option Option::excludes(const Option &other) { return Option(option_->excludes(other.option_)); }

Option Option::one_of(const std::vector<std::string> &values, InHelp help) {
    return Option(option_->check(described(CLI::IsMember(values), help)));
}

Option Option::one_of_numbers(const std::vector<int> &values) {
    return Option(option_->check(CLI::IsMember(values)));
}

Option Option::in_range(int minimum, int maximum, InHelp help) {
    return Option(option_->check(described(CLI::Range(minimum, maximum), help)));
}

Option Option::check(const std::function<std::string(const std::string &)> &error) {
    return Option(option_->check(error));
}

bool Option::is_given() const { return option_->count() > 0; }

std::string Option::name() const { return option_->get_name(); }

template <typename Value>
Option Command::add_option(const std::string &name, Value &value, const std::string &help) {
    return Option(app_->add_option(name, value, help));
}

template Option Command::add_option(const std::string &, std::string &, const std::string &);
template Option Command::add_option(const std::string &, std::filesystem::path &,
                                    const std::string &);
template Option Command::add_option(const std::string &, int &, const std::string &);
template Option Command::add_option(const std::string &, std::uint64_t &, const std::string &);
template Option Command::add_option(const std::string &, double &, const std::string &);
template Option Command::add_option(const std::string &, std::optional<int> &, const std::string &);
template Option Command::add_option(const std::string &, std::optional<double> &,
                                    const std::string &);
template Option Command::add_option(const std::string &, std::vector<int> &, const std::string &);
template Option Command::add_option(const std::string &, std::vector<double> &,
                                    const std::string &);
template Option Command::add_option(const std::string &, std::vector<std::string> &,
                                    const std::string &);

template <typename Value>
Option Command::add_choice(const std::string &name, Value &value,
                           const std::map<std::string, Value> &names, const std::string &help) {
    return Option(app_->add_option(name, value, help)
                      ->transform(CLI::CheckedTransformer(names).description("")));
}

template Option Command::add_choice(const std::string &, study::DeviceKind &,
                                    const std::map<std::string, study::DeviceKind> &,
                                    const std::string &);
template Option Command::add_choice(const std::string &, study::FeltStimuli &,
                                    const std::map<std::string, study::FeltStimuli> &,
                                    const std::string &);

Option Command::add_flag(const std::string &name, bool &flag, const std::string &help) {
    return Option(app_->add_flag(name, flag, help));
}

Option Command::add_flag_callback(const std::string &name, const std::function<void()> &call,
                                  const std::string &help) {
    return Option(app_->add_flag_callback(name, call, help));
}

Command Command::add_subcommand(const std::string &name, const std::string &help) {
    return Command(app_->add_subcommand(name, help));
}

void Command::require_subcommand() { app_->require_subcommand(1); }

void Command::allow_extras() { app_->allow_extras(); }

void Command::footer(const std::string &text) { app_->footer(text); }

void Command::callback(const std::function<void()> &call) { app_->callback(call); }

Option Command::get_option(const std::string &name) const { return Option(app_->get_option(name)); }

bool Command::has_been_given(const std::string &option) const { return app_->count(option) > 0; }

void end_with_status(int status) { throw CLI::RuntimeError(status); }

} // namespace springdrive::app
