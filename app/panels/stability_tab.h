// The stability tab: its computations in the background, and a small map of the predicted stability
// over K_P and dR.
#pragma once

#include "app/panels/tuning_editor.h"
#include "base/background.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/session/session.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

/// Largest eigenvalues over a grid, uniform in the logarithms of K_P and dR.
struct StabilityGrid {
    static constexpr int kColumns = 36;
    static constexpr int kRows = 18;
    static constexpr double kMin_K_P_V_per_rad = 0.5;
    static constexpr double kMax_K_P_V_per_rad =
        control::parameter_of(&control::Tuning::K_P_V_per_rad).maximum;
    static constexpr double kMin_dR_Ohm = 0.02;
    static constexpr double kMax_dR_Ohm = 2.0;

    double period_s = 1e-3;
    std::vector<double> eigenvalue; ///< row by row from the lowest dR, of the worst hand

    /// At the centre of a cell.
    [[nodiscard]] static double K_P_V_per_rad(int column);
    [[nodiscard]] static double dR_Ohm(int row);
    [[nodiscard]] double at(int column, int row) const;
};

/// With all parameters except K_P and dR from the case. @param talk  receives the progress, and can
/// cancel
[[nodiscard]] StabilityGrid stability_grid(const loops::StabilityCase &which, BackgroundTalk &talk);

class StabilityField {
public:
    /// Restarts the computation in the background if its inputs have changed.
    void update(const loops::StabilityCase &now);

    /// In the available room, with a cross at the tuning. A click chooses K_P and dR.
    void draw(const control::Tuning &now);

    /// The tuning that was clicked, once.
    [[nodiscard]] std::optional<control::Tuning> take_clicked() {
        return std::exchange(clicked_, std::nullopt);
    }

private:
    Background<StabilityGrid> work_;
    std::optional<StabilityGrid> grid_;
    std::optional<loops::StabilityCase> of_;
    std::optional<control::Tuning> clicked_;
};

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
