// State of the stability tab between frames, and its computations in the background.
#pragma once

#include "app/panels/stability_field.h"
#include "app/panels/tuning_editor.h"
#include "base/background.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/session/session.h"

#include <optional>
#include <string>

namespace springdrive::app {

/// A limit of one parameter, with all others unchanged.
struct StabilityHeadroom {
    double now = 0.0;
    std::optional<double> limit; ///< the nearest stability limit in the relevant direction
    std::string who;             ///< which becomes unstable first beyond
};

/// The distance of the current tuning from its stability limits.
struct StabilityPrediction {
    loops::WorstMember worst;
    double period_s = 1e-3;
    StabilityHeadroom K_P;
    StabilityHeadroom K_D;
    StabilityHeadroom dR;
};

class StabilityTabState {
public:
    /// Takes finished results, and restarts the computation if tuning or configuration changed.
    void update(const session::Session &session);

    /// Takes the result of a search and activates it, if slot, device and servo are still those
    /// that it is for; otherwise it is offered.
    void finish_search(session::Session &session, TuningEditor &editor);

    /// Searches for the stiffest tuning with the active dR and the selected margin.
    void start_tuning(const session::Session &session);
    void stop_tuning();
    [[nodiscard]] bool is_tuning() const { return search_.is_busy(); }
    [[nodiscard]] double tuning_share() const { return search_.share(); }

    /// Writes the result as a tuning file to the current directory.
    void save();

    [[nodiscard]] const std::optional<StabilityPrediction> &prediction() const {
        return prediction_;
    }
    [[nodiscard]] const std::optional<limits::AutoTuned> &found() const { return found_; }
    [[nodiscard]] StabilityField &field() { return field_; }
    [[nodiscard]] const std::string &message() const { return message_; }
    /// The result of the search, with the η that was active.
    [[nodiscard]] const control::Tuning &found_tuning() const { return found_tuning_; }

    double margin = limits::AutoTuneRequest{}.margin;

private:
    Background<StabilityPrediction> watch_;
    std::optional<StabilityPrediction> prediction_;
    std::optional<loops::StabilityCase> looked_at_;
    StabilityField field_;
    Background<limits::AutoTuned> search_;
    std::optional<limits::AutoTuned> found_;
    control::Tuning found_tuning_;
    loops::StabilityCase searched_; ///< what the search is for
    session::TuningSlot searched_slot_ = session::TuningSlot::a;
    std::string message_; ///< of the last search or save
};

/// Shows whether the tuning is stable with every hand, the distance to its limits, and a button to
/// search for the stiffest tuning with a margin.
void draw_stability_tab(session::Session &session, TuningEditor &editor, StabilityTabState &state);

} // namespace springdrive::app
