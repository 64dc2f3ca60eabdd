// The one list of speed-accuracy charts.
#pragma once

#include "engine/lab/charts/chart.h"
#include "engine/lab/charts/friction_integrator_chart.h"
#include "engine/lab/charts/integrator_chart.h"
#include "engine/lab/charts/motion_control_chart.h"
#include "engine/lab/charts/plant_model_chart.h"
#include "engine/lab/charts/proxy_chart.h"
#include "engine/lab/charts/servo_rate_chart.h"

#include <array>
#include <string_view>

namespace springdrive::charts {

struct ChartMaker {
    std::string_view name; ///< of the chart that it makes
    SpeedAccuracyChart (*make)(const ChartSetting &, const ChartProgress &);
};

/// @throw InputError from `make` for a setting without a result.
inline constexpr std::array kCharts{
    ChartMaker{"integrators", integrator_chart},
    ChartMaker{"integrators_vice", stiff_integrator_chart},
    ChartMaker{"integrators_friction", friction_integrator_chart},
    ChartMaker{"plant_models", plant_model_chart},
    ChartMaker{"motion_direction", motion_direction_chart},
    ChartMaker{"motion_stiffness", motion_stiffness_chart},
    ChartMaker{"proxies_sphere_depth", sphere_depth_chart},
    ChartMaker{"proxies_sphere_direction", sphere_direction_chart},
    ChartMaker{"proxies_organic_depth", organic_depth_chart},
    ChartMaker{"proxies_organic_direction", organic_direction_chart},
    ChartMaker{"proxies_thin_plate", thin_plate_chart},
    ChartMaker{"servo_rate_stiffness", servo_rate_stiffness_chart},
    ChartMaker{"servo_rate_direction", servo_rate_direction_chart},
};

} // namespace springdrive::charts
