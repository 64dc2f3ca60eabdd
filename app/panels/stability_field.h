// A small map in the stability tab: the predicted stability over K_P and dR.
#pragma once

#include "base/background.h"
#include "engine/lab/loops/stability_case.h"

#include <optional>
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

} // namespace springdrive::app
