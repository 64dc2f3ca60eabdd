#include "app/commands/commands.h"

#include "app/commands/study/study_commands.h"

namespace springdrive::app {

void add_study_command(Command &app) {
    Command study = app.add_subcommand("study", "pilot studies: from a protocol to its results");
    study.require_subcommand();
    add_study_new_command(study);
    add_study_check_command(study);
    add_study_plan_command(study);
    add_study_run_commands(study);
    add_study_try_command(study);
    add_study_status_command(study);
    add_study_export_command(study);
    add_study_analyse_command(study);
    add_study_edit_commands(study);
}

} // namespace springdrive::app
