// The commands below `study`: each adds itself and its options to that one.
#pragma once

namespace CLI {
class App;
}

namespace springdrive::app {

/// `new`: writes an included protocol.
void add_study_new_command(CLI::App &study);
/// `check`: all that can be said of a protocol before anybody sits down.
void add_study_check_command(CLI::App &study);
/// `plan`: how many trials a precision takes.
void add_study_plan_command(CLI::App &study);
/// `run` and `resume`: sessions of participants.
void add_study_run_commands(CLI::App &study);
/// `try`: a visitor's few minutes, of which nothing is stored.
void add_study_try_command(CLI::App &study);
/// `status`: where a study stands.
void add_study_status_command(CLI::App &study);
/// `export`: trials for other programs.
void add_study_export_command(CLI::App &study);
/// `analyse`: thresholds, fits, groups and their pictures.
void add_study_analyse_command(CLI::App &study);
/// `note` and `remove`: what is done to a study by hand.
void add_study_edit_commands(CLI::App &study);

} // namespace springdrive::app
