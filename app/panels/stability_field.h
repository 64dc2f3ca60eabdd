// A small picture in the stability tab: where over K_P and dR the loop is predicted to be stable.
#pragma once

#include "base/background.h"
#include "engine/lab/loops/stability_case.h"

#include <optional>
#include <vector>

namespace springdrive::app {

/// Largest eigenvalues over a grid, even in the logarithms of K_P and dR.
struct StabilityGrid {
    static constexpr int kColumns = 36;
    static constexpr int kRows = 18;
    static constexpr double kLeast_K_P_V_per_rad = 0.5;
    static constexpr double kGreatest_K_P_V_per_rad = 200.0;
    static constexpr double kLeast_dR_Ohm = 0.02;
    static constexpr double kGreatest_dR_Ohm = 2.0;

    double period_s = 1e-3;
    std::vector<double> eigenvalue; ///< row by row, the lowest dR first, of the worst hand

    /// In the middle of a cell.
    [[nodiscard]] static double K_P_V_per_rad(int column);
    [[nodiscard]] static double dR_Ohm(int row);
    [[nodiscard]] double at(int column, int row) const;
};

/// All but K_P and dR as the case has them. @param talk  told how far it is; ends where not wanted
[[nodiscard]] StabilityGrid stability_grid(const loops::StabilityCase &which, BackgroundTalk &talk);

class StabilityField {
public:
    /// Starts anew, in the background, where what the field depends on changed.
    void update(const loops::StabilityCase &now);

    /// As wide as there is room, with a cross where the tuning is.
    void draw(const control::Tuning &now) const;

private:
    Background<StabilityGrid> work_;
    std::optional<StabilityGrid> grid_;
    std::optional<loops::StabilityCase> of_;
};

} // namespace springdrive::app
