// What the doctor finds out about a computer: a list of checks, each a value.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app::doctor {

enum class Verdict : std::uint8_t {
    ok,
    warning,        ///< springdrive runs, but worse than it could
    failure,        ///< what it is to be used for does not work
    not_applicable, ///< not needed, or not to be seen on this computer
};
inline constexpr std::array<std::string_view, 4> kVerdictNames{"ok", "warning", "failure",
                                                               "not applicable"};

[[nodiscard]] inline std::string_view name_of(Verdict verdict) {
    return kVerdictNames.at(static_cast<std::size_t>(verdict));
}

struct Finding {
    Verdict verdict = Verdict::ok;
    std::string found; ///< with numbers and units
    std::string fix{}; ///< the one line, for a shell or a person; empty if nothing is to be done
};

struct Check : Finding {
    std::string id; ///< for scripts; several boards have checks of the same ids
    std::string title;
    std::string matters; ///< why, in a few words
};

/// What springdrive is to be used for, by which the same finding is judged.
struct Purpose {
    double servo_hz = 1000.0;
    bool uses_usb = false;
    std::string serial; ///< of a board; empty: the only one
    bool has_window = true;
    std::filesystem::path folder = "."; ///< of records

    /// Of what merely makes the simulated device pause, but stops a real one in a person's hand.
    [[nodiscard]] Verdict worse_with_usb() const {
        return uses_usb ? Verdict::failure : Verdict::warning;
    }
};

[[nodiscard]] inline std::size_t count_of(const std::vector<Check> &checks, Verdict verdict) {
    return static_cast<std::size_t>(std::ranges::count(checks, verdict, &Check::verdict));
}

} // namespace springdrive::app::doctor
