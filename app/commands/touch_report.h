// The report of `springdrive touch`: each step as CSV, or a summary as JSON or text.
#pragma once

#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/lab/rig/scenario/touch_path.h"
#include "engine/lab/rig/touch_check.h"

#include <cstddef>
#include <optional>
#include <ostream>
#include <string>

namespace springdrive::app {

struct TouchReport {
    std::string surface; ///< file, or name of a test surface
    contact::MeshReport mesh;
    std::size_t shapes = 0;
    double preparation_s = 0.0;
    std::size_t bytes = 0;

    std::string path;                         ///< file, or name of a generated one
    std::optional<rig::TouchPathOptions> how; ///< of a generated one
    double servo_hz = 0.0;
    double radius_m = 0.0; ///< of the proxy

    double check_slack_m = 0.0; ///< of TouchCheckOptions

    rig::TouchRun run;
    rig::TouchFindings findings;
    std::optional<rig::Maximum> sphere_error_rad; ///< of a sphere, whose true normals are known
};

/// A header and a row for each step. SI units, but for the time of an update in nanoseconds.
void write_touch_csv(std::ostream &out, const TouchReport &report);

/// One object; quantities without a value are null.
void write_touch_json(std::ostream &out, const TouchReport &report);

void write_touch_table(std::ostream &out, const TouchReport &report);

} // namespace springdrive::app
