// Methods of rendering a contact, on meshes of 1,000 to 1,000,000 triangles of shapes with known
// formulas: the closest point of the mesh (a penalty method), the proxy, the proxy on a mesh curved
// by its normals, and the proxy on the shape itself.
//
// The error is relative to the shape's formula, at tips that were pushed in from a known point of
// it by a known depth. A cross is a method that lets the tip out on the other side.
#pragma once

#include "engine/lab/charts/chart.h"

namespace springdrive::charts {

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

} // namespace springdrive::charts
