// The exception for unusable user input: a file, an option, a value.
#pragma once

#include <stdexcept>
#include <string>

namespace springdrive {

/// The message is one line that states what is wrong, where, and how to fix it.
/// `main` prints it after the program's name and exits with status 1; the window shows it and keeps
/// its previous state. Never thrown on the servo thread.
class InputError : public std::runtime_error {
public:
    explicit InputError(const std::string &message) : std::runtime_error(message) {}
};

} // namespace springdrive
