#include "app/commands/study/study_commands.h"

#include "app/commands/output_files.h"
#include "app/commands/study/opened_study.h"
#include "base/input_error.h"
#include "engine/study/export/bids.h"
#include "engine/study/export/trial_table.h"
#include "engine/study/store/study_store.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <memory>

namespace springdrive::app {

namespace {

struct TypedStudyExport {
    std::filesystem::path study;
    std::string csv;
    std::filesystem::path bids;
    study::DeviceKind device = study::DeviceKind::usb;
    Existing existing = Existing::keep;
};

void export_study(const TypedStudyExport &typed) {
    if (typed.csv.empty() && typed.bids.empty()) {
        throw InputError("study export: what to? --csv FILE, --bids FOLDER, or both");
    }
    const study::StudyContents contents = study::read_study(typed.study);
    refuse_without_trials(contents, typed.device, typed.study);
    check_outputs({files_of_study(typed.study), {}, {typed.csv}}, typed.existing);
    if (!typed.bids.empty()) {
        study::write_bids(contents, typed.bids, {{typed.device}, SPRINGDRIVE_VERSION});
    }
    if (!typed.csv.empty()) {
        write_output(
            typed.csv,
            [&](std::ostream &out) { study::write_trials_csv(contents, {typed.device}, out); },
            typed.existing);
    }
    if (const std::string text = left_out_text(contents, typed.device, typed.study);
        !text.empty()) {
        std::cerr << text << '\n';
    }
}

} // namespace

void add_study_export_command(CLI::App &study) {
    CLI::App &command = *study.add_subcommand("export", "trials for other programs");
    const auto typed = std::make_shared<TypedStudyExport>();
    add_study_file_argument(command, typed->study);
    add_output_option(command, "--csv", typed->csv, "a row a trial, CSV");
    command
        .add_option("--bids", typed->bids,
                    "a new folder for a dataset of the Brain Imaging Data Structure, behaviour")
        ->type_name("DIR");
    add_device_kind_option(command, typed->device);
    add_force_option(command, typed->existing);
    command.callback([typed] { export_study(*typed); });
}

} // namespace springdrive::app
