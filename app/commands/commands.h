// Every subcommand: each adds itself and its options to the command line, and runs when it is
// selected.
#pragma once

#include "app/commands/command.h"

#include <iosfwd>

namespace springdrive::limits {
struct AutoTuned;
}

namespace springdrive::app {

/// `demo`: the window.
void add_demo_command(Command &app);
/// `device`: lists devices, or emulates one on USB.
void add_device_command(Command &app);
/// `doctor`: what this computer allows and lacks.
void add_doctor_command(Command &app);
/// `record`: a session without a window, recorded at full rate.
void add_record_command(Command &app);
/// `replay`: a record through the control law again.
void add_replay_command(Command &app);
/// `export`: a record for other programs.
void add_export_command(Command &app);
/// `figures`: the paper's figures, measured beside their predictions.
void add_figures_command(Command &app);
/// `chart`: cost and accuracy of every method, in one run.
void add_chart_command(Command &app);
/// `stiffness`: the coupling K_θ over frequency, or its decrease as the motors heat up.
void add_stiffness_command(Command &app);
/// `stability`: whether a loop is stable, and its limits along one or two parameters.
void add_stability_command(Command &app);
/// `tune`: the stiffest tuning that is stable with every hand, as a file.
void add_tune_command(Command &app);
/// Its result, with margins and warnings on them, one line each.
void write_tuned(std::ostream &out, const limits::AutoTuned &found);
/// `baseline`: the spring drive against a current drive, each at its stable best.
void add_baseline_command(Command &app);
/// `touch`: the proxy over a scene along a path, without window or device.
void add_touch_command(Command &app);
/// `inspect`: the content of a scene, what can be touched, and the model that it gets.
void add_inspect_command(Command &app);
/// `study`: pilot studies.
void add_study_command(Command &app);

} // namespace springdrive::app
