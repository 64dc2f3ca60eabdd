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

#include <cstdint>
#include <functional>
#include <span>
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

struct Figure {
    Table numbers;
    ChartMarks marks;
};

/// Receives the progress of a figure, from 0 to 1.
using FigureProgress = std::function<void(double)>;

struct FigureMaker {
    std::string_view name; ///< of its files, without ending
    Figure (*make)(const FigureSetting &, const FigureProgress &);
};

/// Figures 2, 3, 5 and 6 of the paper, and 7.
/// @throw InputError from `make` for a setting that gives no answer.
[[nodiscard]] std::span<const FigureMaker> figure_makers();

} // namespace springdrive::app
