// The paper's figures, each as numbers: a CSV file, and the marks of its chart.
//
// A chart is drawn by assets/figures/NAME.gnuplot from NAME.csv and those marks; its appearance is
// defined there.
#pragma once

#include "app/figures/gnuplot.h"
#include "base/table.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/locked_device.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace springdrive::app {

/// The subject of the figures.
struct FigureSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    Vector3 q_rad{Vector3::Zero()}; ///< base locked in figures 3 and 5 to 7
    double servo_period_s = 1e-3;
    std::uint64_t device_seed = 1; ///< of the device measured in figures 3, 5 and 6
};

/// Of the figures' numbers, in the files.
inline constexpr const char *kFigureFormat = ".9g";

struct Figure {
    Table numbers;
    ChartMarks marks;
};

/// Receives the progress of a figure, from 0 to 1.
using FigureProgress = std::function<void(double)>;

/// Fig. 2: K_θ over frequency, by (12), sampled, measured, and of the unmodified motor.
[[nodiscard]] Figure stiffness_figure(const FigureSetting &setting, const FigureProgress &progress);

/// Fig. 3: the tip's stiffness under both maps, by (21) and (27), and measured.
[[nodiscard]] Figure ellipses_figure(const FigureSetting &setting, const FigureProgress &progress);

/// Fig. 5: the forces of both maps against a wall above the device.
[[nodiscard]] Figure forces_figure(const FigureSetting &setting, const FigureProgress &progress);

/// Fig. 6: the direction error of both maps against surfaces in all directions.
[[nodiscard]] Figure direction_error_figure(const FigureSetting &setting,
                                            const FigureProgress &progress);

/// Fig. 7, beyond the paper: the direction error of both maps over frequency, computed.
[[nodiscard]] Figure direction_over_frequency_figure(const FigureSetting &setting,
                                                     const FigureProgress &progress);

struct FigureMaker {
    std::string_view name; ///< of its files, without ending
    Figure (*make)(const FigureSetting &, const FigureProgress &);
};

/// @throw InputError from `make` for a setting that gives no answer.
inline constexpr std::array<FigureMaker, 5> kFigures{{
    {"fig2_stiffness", stiffness_figure},
    {"fig3_ellipses", ellipses_figure},
    {"fig5_forces", forces_figure},
    {"fig6_direction_error", direction_error_figure},
    {"fig7_direction_over_frequency", direction_over_frequency_figure},
}};

} // namespace springdrive::app
