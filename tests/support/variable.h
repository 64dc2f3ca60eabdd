// Variables of the environment in tests.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace springdrive::testing {

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
