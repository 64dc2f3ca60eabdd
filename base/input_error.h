// The one exception for what a user gave us and we cannot use: a file, an option, a value.
#pragma once

#include <stdexcept>
#include <string>

namespace springdrive {

/// Its message is one line that says what is wrong, where, and what to do about it.
/// `main` prints it behind the program's name and exits with status 1; the window shows it and
/// keeps what it had. Never thrown on the servo thread.
class InputError : public std::runtime_error {
public:
    explicit InputError(const std::string &message) : std::runtime_error(message) {}
};

} // namespace springdrive
