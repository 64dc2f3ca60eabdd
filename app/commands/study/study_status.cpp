#include "app/commands/study/study_commands.h"

#include "app/commands/study/status_report.h"
#include "engine/study/store/study_store.h"

#include <iostream>
#include <memory>

namespace springdrive::app {

void add_study_status_command(Command &study) {
    Command command = study.add_subcommand(
        "status", "where a study stands: participants, trials, records; also while it runs");
    const auto file = std::make_shared<std::filesystem::path>();
    add_study_file_argument(command, *file);
    command.callback([file] {
        const OpenedStudy opened = read_opened_study(*file);
        write_study_status(std::cout, *file, opened,
                           study::progress_of(opened.protocol, opened.contents),
                           study::validate_records(*file, opened.contents));
    });
}

} // namespace springdrive::app
