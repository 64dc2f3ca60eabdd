#include "app/commands/study/study_commands.h"

#include "app/commands/output_files.h"
#include "app/commands/progress_line.h"
#include "app/commands/study/opened_study.h"
#include "app/commands/study/results_report.h"
#include "app/commands/study/study_pictures.h"
#include "engine/study/results/results_tables.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

struct TypedAnalysis {
    std::filesystem::path study;
    std::filesystem::path out; ///< empty: the table only
    study::DeviceKind device = study::DeviceKind::usb;
    Existing existing = Existing::keep;
};

RunFiles tables_of(const TypedAnalysis &typed) {
    RunFiles files{files_of_study(typed.study), {}, {}};
    for (const study::ResultsTable &table : study::kResultsTables) {
        files.written.push_back(typed.out / table.file);
    }
    return files;
}

/// What `write_files` will draw, if all of it can be written.
std::vector<Chart> checked_pictures(const TypedAnalysis &typed, const study::Protocol &protocol,
                                    const study::StudyResults &results) {
    std::vector<Chart> pictures = results_pictures(protocol, results, typed.out);
    RunFiles files = tables_of(typed);
    for (const Chart &picture : pictures) {
        files.written.push_back(typed.out / picture.svg);
    }
    check_outputs(files, typed.existing);
    return pictures;
}

/// The pictures are the last: all numbers are there even if nothing can be drawn.
void write_files(const TypedAnalysis &typed, const study::Protocol &protocol,
                 const study::StudyResults &results, const std::vector<Chart> &pictures) {
    for (const study::ResultsTable &table : study::kResultsTables) {
        write_output((typed.out / table.file).string(),
                     [&](std::ostream &out) { write_csv(out, table.make(protocol, results)); },
                     {typed.existing, Readers::owner});
    }
    ProgressLine line;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        line.show("pictures", static_cast<double>(i) / static_cast<double>(pictures.size()));
        draw(pictures[i], {typed.existing, Readers::owner});
    }
}

void analyse(const TypedAnalysis &typed) {
    const OpenedStudy opened = read_opened_study(typed.study);
    refuse_without_trials(opened.contents, typed.device, typed.study);
    if (!typed.out.empty()) {
        make_output_folder(typed.out);
        check_outputs(tables_of(typed), typed.existing); // before the fits, which take long
    }
    study::StudyResults results;
    {
        ProgressLine line;
        results = study::results_of(opened.protocol, opened.contents, typed.device,
                                    [&line](double share) { line.show("fits", share); });
    }
    std::vector<Chart> pictures;
    if (!typed.out.empty()) {
        pictures = checked_pictures(typed, opened.protocol, results);
    }
    write_results(std::cout, opened.protocol, results);
    if (!typed.out.empty()) {
        write_files(typed, opened.protocol, results, pictures);
        std::cerr << "written: tables and pictures in " << typed.out.string() << '\n';
    }
    if (const std::string text = left_out_text(opened.contents, typed.device, typed.study);
        !text.empty()) {
        std::cerr << text << '\n';
    }
}

} // namespace

void add_study_analyse_command(Command &study) {
    Command command = study.add_subcommand(
        "analyse", "thresholds, slopes, fits and groups, with pictures; also while a study runs");
    const auto typed = std::make_shared<TypedAnalysis>();
    add_study_file_argument(command, typed->study);
    command
        .add_option("--out", typed->out,
                    "folder for all tables as CSV and pictures as SVG; created if missing")
        .type_name("DIR");
    add_device_kind_option(command, typed->device);
    add_force_option(command, typed->existing);
    command.callback([typed] { analyse(*typed); });
}

} // namespace springdrive::app
