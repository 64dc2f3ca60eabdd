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

/// The message of the InputError that `step` throws; empty if it throws none. Other exceptions
/// pass.
template <typename Step> [[nodiscard]] std::string error_text_of(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        return error.what();
    }
    return {};
}

} // namespace springdrive
