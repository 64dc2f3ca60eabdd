// Speed-accuracy charts: the setting, points and CSV file of one, and the one list of all.
#pragma once

#include "base/table.h"
#include "base/timing.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::charts {

struct ChartSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    int repeats = 5; ///< how often each time is measured, at least once
};

/// One method at one setting.
struct ChartPoint {
    std::string method;  ///< the line that it belongs to
    std::string setting; ///< "100 µs", "1280 triangles"
    Cost cost;
    double error = 0.0; ///< against a reference that shares no code with the method
    bool stable = true; ///< false: it diverged, and `error` is meaningless
};

/// One picture.
struct SpeedAccuracyChart {
    std::string name; ///< of its files: "integrators"
    std::string title;
    std::string cost_label;  ///< without a unit: the axis adds ns, µs or ms
    std::string error_label; ///< with its unit and its reference
    std::vector<ChartPoint> points;
};

/// Receives the progress of a chart, from 0 to 1.
using ChartProgress = std::function<void(double share)>;

/// method, setting, the cost's minimum, median and maximum [ns], error, stable (1 or 0) and the
/// machine, a row for each point.
[[nodiscard]] inline Table chart_table(const SpeedAccuracyChart &chart,
                                       const std::string &machine) {
    Table table = Table::with_columns("method,setting,cost_least_ns:.6g,cost_median_ns:.6g,"
                                      "cost_greatest_ns:.6g,error,stable,machine");
    for (const ChartPoint &point : chart.points) {
        table.rows.push_back({point.method, point.setting, point.cost.min_ns, point.cost.median_ns,
                              point.cost.max_ns, point.error, point.stable, machine});
    }
    return table;
}

// @throw InputError for a setting without a result: a press out of the device's reach, a tuning
//        without static stiffness, or one under which the safety monitor stops the timed servo.

/// The plant's integrators in hard contact: the error of the force over a contact transient, and
/// the cost of a millisecond of it. A point for each step, a line for each method, a cross where it
/// diverged. A pen grip presses the tip onto the plate.
///
/// All methods integrate the same smooth plant (plant_equations.h). "Ours" is the simulated device
/// itself, which additionally checks for friction, stops and limits.
[[nodiscard]] SpeedAccuracyChart integrator_chart(const ChartSetting &setting,
                                                  const ChartProgress &progress);
/// A vice presses it, stiff enough for Euler's methods to diverge at the longest steps.
[[nodiscard]] SpeedAccuracyChart stiff_integrator_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);
/// The same where joints stick and slip: a tip is pressed onto a plate against Coulomb friction,
/// held and released. Explicit methods use friction τ_c sign(q̇). Methods that need a smooth f use
/// τ_c tanh(q̇/width), as narrow as they tolerate. The simulated device has true sticking, and so
/// has CVODE restarted at each transition between sticking and sliding, which at a tight tolerance
/// is also the reference.
[[nodiscard]] SpeedAccuracyChart friction_integrator_chart(const ChartSetting &setting,
                                                           const ChartProgress &progress);

/// How much of the device needs to be simulated: kPlantModels over a contact
/// transient with quantised encoders, in full and in the plane of the links. A point for each step,
/// a line for each model; the error is that of the force on the hand, against the full model at a
/// step of about a microsecond. The press lies in the links' plane, so that it suits the models
/// with a locked base.
[[nodiscard]] SpeedAccuracyChart plant_model_chart(const ChartSetting &setting,
                                                   const ChartProgress &progress);

// The maps from the tip's set-point to the motors': inverse (18), and transpose (23) with α at its
// bound (29) in each tick, at the minimum bound of the workspace, or set by hand. The cost is that
// of a tick's whole law, from θ to e_W, with only this map. Forces are those at rest, over the
// workspace and over surfaces of all orientations. A cross is an α at which the servo's loop is
// unstable somewhere in the workspace.

/// The angle from the normal to the force, for encoders from coarse to fine.
[[nodiscard]] SpeedAccuracyChart motion_direction_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);
/// The mean compliance of a wall. The transpose map with α by hand has a point for each α.
[[nodiscard]] SpeedAccuracyChart motion_stiffness_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);

// Methods of rendering a contact, on meshes of 1,000 to 1,000,000 triangles of shapes with known
// formulas: the closest point of the mesh (a penalty method), the proxy, the proxy on a mesh curved
// by its normals, and the proxy on the shape itself. The error is relative to the shape's formula,
// at tips that were pushed in from a known point of it by a known depth. A cross is a method that
// lets the tip out on the other side.

/// The error of the penetration's depth, which is that of the force, on a sphere.
[[nodiscard]] SpeedAccuracyChart sphere_depth_chart(const ChartSetting &setting,
                                                    const ChartProgress &progress);
/// The error of the force's direction on a sphere.
[[nodiscard]] SpeedAccuracyChart sphere_direction_chart(const ChartSetting &setting,
                                                        const ChartProgress &progress);
/// The error of the depth on the organic shape, which no primitive resembles.
[[nodiscard]] SpeedAccuracyChart organic_depth_chart(const ChartSetting &setting,
                                                     const ChartProgress &progress);
/// The error of the direction on the organic shape.
[[nodiscard]] SpeedAccuracyChart organic_direction_chart(const ChartSetting &setting,
                                                         const ChartProgress &progress);
/// The error of the depth on a plate of 2 mm, pressed in beyond its middle.
[[nodiscard]] SpeedAccuracyChart thin_plate_chart(const ChartSetting &setting,
                                                  const ChartProgress &progress);

// Servo rates from 250 Hz to 20 kHz. The cost is the measured time of a tick of the whole servo in
// contact, times the ticks in a millisecond. A cross is a rate at which the loop is unstable on one
// of the device's motors.

/// The stiffness against (12), measured by sine sweep on the simulated motor.
[[nodiscard]] SpeedAccuracyChart servo_rate_stiffness_chart(const ChartSetting &setting,
                                                            const ChartProgress &progress);
/// The direction of the transpose map's force while the tip moves, at one third, one and three
/// times the tuning's λ.
[[nodiscard]] SpeedAccuracyChart servo_rate_direction_chart(const ChartSetting &setting,
                                                            const ChartProgress &progress);

struct ChartMaker {
    std::string_view name; ///< of the chart that it makes
    SpeedAccuracyChart (*make)(const ChartSetting &, const ChartProgress &);
};

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
