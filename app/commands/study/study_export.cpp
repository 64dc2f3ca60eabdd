#include "app/commands/study/study_commands.h"

#include "app/commands/output_files.h"
#include "app/commands/study/opened_study.h"
#include "base/input_error.h"
#include "engine/study/export/trial_table.h"
#include "engine/study/store/study_store.h"

#include <fmt/core.h>

#include <iostream>
#include <memory>

namespace springdrive::app {

namespace {

struct TypedStudyExport {
    std::filesystem::path study;
    std::string csv;
    std::string answers;
    std::filesystem::path bids;
    study::DeviceKind device = study::DeviceKind::usb;
    Existing existing = Existing::keep;
};

/// @throw InputError if there are no answers of sessions on that kind of device
void refuse_without_answers(const study::StudyContents &contents, study::DeviceKind device,
                            const std::filesystem::path &file) {
    if (study::answers_on(contents, device).empty()) {
        throw InputError(fmt::format(
            "{}: has no answers of sessions on {} devices{}", file.string(), study::name_of(device),
            contents.answers.empty() ? "; they come from a protocol's [[questions]]"
                                     : "; --device takes those on others"));
    }
}

void export_study(const TypedStudyExport &typed) {
    if (typed.csv.empty() && typed.answers.empty() && typed.bids.empty()) {
        throw InputError("study export: what to? --csv FILE, --answers FILE, --bids FOLDER, or "
                         "more than one");
    }
    const OpenedStudy opened = read_opened_study(typed.study);
    const study::StudyContents &contents = opened.contents;
    const std::vector<study::QuestionnaireItem> &questionnaire = opened.protocol.questionnaire;
    if (!typed.csv.empty() || !typed.bids.empty()) {
        refuse_without_trials(contents, typed.device, typed.study);
    }
    if (!typed.answers.empty()) {
        refuse_without_answers(contents, typed.device, typed.study);
    }
    check_outputs({files_of_study(typed.study), {}, {typed.csv, typed.answers}}, typed.existing);
    if (!typed.bids.empty()) {
        study::write_bids(contents, typed.bids,
                          {{typed.device}, SPRINGDRIVE_VERSION, questionnaire});
    }
    if (!typed.answers.empty()) {
        write_output(typed.answers,
                     [&](std::ostream &out) {
                         write_csv(out,
                                   study::answer_table(contents, questionnaire, {typed.device}));
                     },
                     {typed.existing, Readers::owner});
    }
    if (!typed.csv.empty()) {
        write_output(
            typed.csv,
            [&](std::ostream &out) {
                write_csv(out, study::table_of(study::trial_columns(contents),
                                               study::trials_in_study(contents, {typed.device})));
            },
            {typed.existing, Readers::owner});
    }
    if (const std::string text = left_out_text(contents, typed.device, typed.study);
        !text.empty()) {
        std::cerr << text << '\n';
    }
}

} // namespace

void add_study_export_command(Command &study) {
    Command command = study.add_subcommand("export", "trials and answers for other programs");
    const auto typed = std::make_shared<TypedStudyExport>();
    add_study_file_argument(command, typed->study);
    add_output_option(command, "--csv", typed->csv, "a row a trial, CSV");
    add_output_option(command, "--answers", typed->answers,
                      "a row an answer to the protocol's questions, CSV");
    command
        .add_option("--bids", typed->bids,
                    "a new folder for a dataset of the Brain Imaging Data Structure, behaviour")
        .type_name("DIR");
    add_device_kind_option(command, typed->device);
    add_force_option(command, typed->existing);
    command.callback([typed] { export_study(*typed); });
}

} // namespace springdrive::app
