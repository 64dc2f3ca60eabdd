// The commands below `study`: each adds itself and its options to that one.
#pragma once

#include "app/commands/command.h"

namespace springdrive::app {

/// `new`: writes an included protocol.
void add_study_new_command(Command &study);
/// `check`: all that can be said of a protocol before anybody sits down.
void add_study_check_command(Command &study);
/// `plan`: how many trials a precision takes.
void add_study_plan_command(Command &study);
/// `run` and `resume`: sessions of participants.
void add_study_run_commands(Command &study);
/// `try`: a visitor's few minutes, of which nothing is stored.
void add_study_try_command(Command &study);
/// `status`: where a study stands.
void add_study_status_command(Command &study);
/// `export`: trials for other programs.
void add_study_export_command(Command &study);
/// `analyse`: thresholds, fits, groups and their pictures.
void add_study_analyse_command(Command &study);
/// `note` and `remove`: what is done to a study by hand.
void add_study_edit_commands(Command &study);

} // namespace springdrive::app
