// Keeps a kiosk running: the program runs itself as a child, and starts it again when it has died,
// whatever of: a crash, a display that went away, a stop that only a new start clears.
#pragma once

#include <filesystem>
#include <optional>

namespace springdrive::app::exhibit {

/// The exit status of a kiosk that is to be started again.
inline constexpr int kStartAgain = 3;

/// How a child ended.
struct ChildEnd {
    int status = 0;       ///< of exit; or 128 and the number of the signal that ended it
    double lived_s = 0.0; ///< from its start
};

/// After which pause it is started again.
class RestartPolicy {
public:
    static constexpr double kProven_s = 10.0; ///< what lived so long had been started rightly
    static constexpr double kFirst_s = 1.0;
    static constexpr double kLongest_s = 60.0;

    /// Nothing if it is not started again: it ended as it was asked to, or it was started wrongly.
    [[nodiscard]] std::optional<double> pause_s(const ChildEnd &end);

private:
    bool is_proven_ = false; ///< a child has lived long enough
    double next_s_ = kFirst_s;
};

/// Runs this program with its own arguments and `--unsupervised` until it ends as it was asked to.
/// SIGTERM and SIGINT are passed on.
/// @param log  of the day, where each new start is noted; empty: none
/// @return the exit status of the last child
/// @throw InputError if there can be no child
[[nodiscard]] int supervise(const std::filesystem::path &log);

} // namespace springdrive::app::exhibit
