// What the stability tab remembers between frames, and what it works out beside them.
#pragma once

#include "app/panels/stability_field.h"
#include "base/background.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/session/session.h"

#include <optional>
#include <string>

namespace springdrive::app {

/// A limit of one parameter, all others as they are.
struct StabilityRoom {
    double now = 0.0;
    std::optional<double> limit; ///< the nearest, on the side where it fails or, failing, is mended
    std::string who;             ///< fails first beyond
};

/// How far the present tuning is from where it fails.
struct StabilityOutlook {
    loops::WorstMember worst;
    double period_s = 1e-3;
    StabilityRoom K_P;
    StabilityRoom K_D;
    StabilityRoom dR;
};

class StabilityTabState {
public:
    /// Takes in what was finished, and starts anew where tuning or configuration changed.
    void update(const session::Session &session);

    /// Looks for the stiffest tuning with the dR in force and the margin set.
    void start_tuning(const session::Session &session);
    void stop_tuning();
    [[nodiscard]] bool is_tuning() const { return search_.is_busy(); }
    [[nodiscard]] double tuning_share() const { return search_.share(); }

    /// Writes what was found as a tuning file into the folder where the program was started.
    void save();

    [[nodiscard]] const std::optional<StabilityOutlook> &outlook() const { return outlook_; }
    [[nodiscard]] const std::optional<limits::AutoTuned> &found() const { return found_; }
    [[nodiscard]] const StabilityField &field() const { return field_; }
    [[nodiscard]] const std::string &message() const { return message_; }
    /// What was in force before the tuning that was found.
    [[nodiscard]] const control::Tuning &before() const { return before_; }
    /// The tuning that was found, with the η that was in force.
    [[nodiscard]] const control::Tuning &found_tuning() const { return found_tuning_; }
    /// A tuning that is to be in force now; once.
    [[nodiscard]] std::optional<control::Tuning> take_new_tuning();

    double margin = limits::AutoTuneRequest{}.margin;

private:
    Background<StabilityOutlook> watch_;
    std::optional<StabilityOutlook> outlook_;
    std::optional<loops::StabilityCase> looked_at_;
    StabilityField field_;
    Background<limits::AutoTuned> search_;
    std::optional<limits::AutoTuned> found_;
    control::Tuning before_;
    control::Tuning found_tuning_;
    std::optional<control::Tuning> new_tuning_;
    std::string message_; ///< of the last search or save
};

/// The loop as it stands: at the hand's configuration, with the tuning that is asked for.
[[nodiscard]] loops::StabilityCase stability_case_of(const session::Session &session);

/// Whether every hand finds the tuning stable, how much room is left, and a button for the stiffest
/// tuning that leaves a margin.
void draw_stability_tab(session::Session &session, StabilityTabState &state);

} // namespace springdrive::app
