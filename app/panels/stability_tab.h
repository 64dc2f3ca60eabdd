// The stability tab: its computations in the background, and a small map of the predicted stability
// over K_P and dR.
#pragma once

#include "app/panels/tuning_editor.h"
#include "base/background.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/loops/passivity.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/session/session.h"

#include <optional>
#include <string>
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

    /// In the available room, with a cross at the tuning.
    /// @return the tuning with K_P and dR that were clicked, if they were
    [[nodiscard]] std::optional<control::Tuning> draw(const control::Tuning &now);

private:
    Background<StabilityGrid> work_;
    std::optional<StabilityGrid> grid_;
    std::optional<loops::StabilityCase> of_;
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
    loops::LeastAtPort passive;
    loops::LeastAtPort linear_hands;
    StabilityHeadroom K_P;
    StabilityHeadroom K_D;
    StabilityHeadroom dR;
};

/// Shows whether the tuning is stable with every hand, the distance to its limits, and a button to
/// search for the stiffest tuning with a margin.
class StabilityTab {
public:
    void draw(session::Session &session, TuningEditor &editor);

    /// Takes the result of a search and activates it, if slot, device and servo are still those
    /// that it is for; otherwise it is offered.
    void finish_search(session::Session &session, TuningEditor &editor);

private:
    void update(const session::Session &session);
    void draw_search(const session::Session &session);
    void draw_found(session::Session &session, TuningEditor &editor);
    void start_search(const session::Session &session);
    void save();

    double margin_ = limits::AutoTuneRequest{}.margin;
    bool is_passive_ = true; ///< the tuning that is searched for
    Background<StabilityPrediction> watch_;
    std::optional<StabilityPrediction> prediction_;
    std::optional<loops::StabilityCase> looked_at_;
    StabilityField field_;
    Background<limits::AutoTuned> search_;
    std::optional<limits::AutoTuned> found_;
    control::Tuning found_tuning_;  ///< with the η that was active
    loops::StabilityCase searched_; ///< what the search is for
    session::TuningSlot searched_slot_ = session::TuningSlot::a;
    std::string message_; ///< of the last search or save
};

} // namespace springdrive::app
