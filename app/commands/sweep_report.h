// The results of `springdrive device sweep`: a table, CSV, and a chart.
#pragma once

#include "base/new_file.h"
#include "base/table.h"
#include "device/core/device_description.h"
#include "engine/commissioning/sweep.h"

#include <filesystem>
#include <ostream>
#include <string>

namespace springdrive::app {

/// For people.
void write_sweep_table(std::ostream &out, const device::DeviceDescription &device,
                       const commissioning::SweepOptions &options,
                       const commissioning::SweepReport &report);

/// For programs: a row a motor and frequency.
[[nodiscard]] Table sweep_table(const commissioning::SweepReport &report);

/// The chart's numbers, written beside it.
[[nodiscard]] std::filesystem::path numbers_of_sweep(std::filesystem::path svg);

/// @throw InputError as `draw` and `write_output` do
void draw_sweep(const std::filesystem::path &svg, const std::string &device_text,
                const commissioning::SweepOptions &options,
                const commissioning::SweepReport &report, Existing existing);

} // namespace springdrive::app
