// Runs the springdrive program as a user would, in an environment, and captures its output.
#pragma once

#include "tests/support/files.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::testing {

struct Ending {
    int exit_status = -1; ///< −1 if a signal ended it
    std::string out;
    std::string error;
    std::chrono::duration<double> after_signal{0.0};
};

/// @param signal   sent as soon as the program has written something to `started`; 0 for none
/// The program is killed after two minutes, which ends as exit status −1.
[[nodiscard]] Ending run_program(const std::vector<std::string> &arguments, int signal = 0,
                                 const std::filesystem::path &started = {});

/// Expects that it ended with `status` and one line that contains `names`.
void expect_one_line(const Ending &ending, int status, const std::string &names);

/// Expects an error: one line that contains `names`, nothing on standard output.
void expect_refused(const Ending &ending, const std::string &names);

/// A variable of the environment, which afterwards is what it was.
class Variable {
public:
    /// @param value  none: it is not set
    Variable(const char *name, const std::optional<std::string> &value) : name_(name) {
        if (const char *before = std::getenv(name);
            before != nullptr) { // NOLINT(concurrency-mt-unsafe)
            before_ = before;
        }
        set(value);
    }
    ~Variable() { set(before_); }
    Variable(const Variable &) = delete;
    Variable &operator=(const Variable &) = delete;

private:
    void set(const std::optional<std::string> &value) const {
        if (value) {
            setenv(name_, value->c_str(), 1); // NOLINT(concurrency-mt-unsafe)
        } else {
            unsetenv(name_); // NOLINT(concurrency-mt-unsafe)
        }
    }

    const char *name_;
    std::optional<std::string> before_;
};

} // namespace springdrive::testing
