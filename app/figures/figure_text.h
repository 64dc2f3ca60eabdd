// The formats of numbers in the charts.
#pragma once

#include "app/figures/figure.h"
#include "base/degrees.h"

#include <string>

namespace springdrive::app {

/// "1.234e-05": `digits` significant digits, no more than needed; empty for a NaN.
[[nodiscard]] std::string number_text(double number, int digits);

/// dR, K_P, K_D and the servo, for a figure's second line: "dR 0.5 Ω, K_P 6 V/rad, …".
[[nodiscard]] std::string gains_text(const FigureSetting &setting);

/// The same with λ.
[[nodiscard]] std::string tuning_text(const FigureSetting &setting);

/// The joint angles: "q 0°, 20°, −15°".
[[nodiscard]] std::string angles_text(const FigureSetting &setting);

} // namespace springdrive::app
