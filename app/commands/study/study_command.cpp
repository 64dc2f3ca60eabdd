// The command `study`, and its subcommands before a study begins: `new` and `check`.
#include "app/commands/command.h"
#include "app/commands/output_files.h"
#include "app/commands/study/opened_study.h"
#include "app/host/folders.h"
#include "app/study/session/study_session.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/table.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/protocol_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

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

namespace {

namespace fs = std::filesystem;

fs::path protocol_folder() { return asset_folder() / "protocols"; }

/// Of the protocols that are included, in the order of the alphabet.
std::vector<std::string> included_protocols() {
    std::vector<std::string> names;
    for (const fs::directory_entry &entry : fs::directory_iterator(protocol_folder())) {
        if (entry.path().extension() == ".toml") {
            names.push_back(entry.path().stem().string());
        }
    }
    std::ranges::sort(names);
    return names;
}

struct TypedNewProtocol {
    std::string name;
    std::string out; ///< empty: NAME.toml
    bool lists = false;
};

void list_protocols() {
    for (const std::string &name : included_protocols()) {
        const study::Protocol protocol =
            study::read_protocol_file(protocol_folder() / (name + ".toml"));
        std::cout << fmt::format("{:<12} {}\n", name, protocol.title);
    }
}

void write_new(const TypedNewProtocol &typed) {
    if (typed.lists) {
        list_protocols();
        return;
    }
    const std::vector<std::string> names = included_protocols();
    if (std::ranges::count(names, typed.name) == 0) {
        std::string all;
        for (const std::string &name : names) {
            all += (all.empty() ? "" : ", ") + name;
        }
        throw InputError("study new " + typed.name + ": no such protocol; there are " + all);
    }
    const fs::path out = typed.out.empty() ? fs::path(typed.name + ".toml") : fs::path(typed.out);
    if (typed.out != "-" && fs::exists(out)) {
        throw InputError(out.string() + ": exists; name another file with --out");
    }
    std::ifstream source(protocol_folder() / (typed.name + ".toml"), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(source), {}};
    write_output(
        out.string(), [&text](std::ostream &stream) { stream << text; }, Existing::keep);
    if (typed.out != "-") {
        std::cerr << "written: " << out.string() << "\nedit it, then: springdrive study check "
                  << out.string() << '\n';
    }
}

} // namespace

void add_study_new_command(Command &study) {
    Command command =
        study.add_subcommand("new", "writes an included protocol, to be edited and run");
    const auto typed = std::make_shared<TypedNewProtocol>();
    Option name = command.add_option("name", typed->name, "which protocol, see --list");
    name.type_name("NAME");
    command
        .add_option("--out", typed->out,
                    "where to [NAME.toml]; - for standard output. An existing file is kept")
        .type_name("FILE");
    Option list = command.add_flag("--list", typed->lists, "the included protocols");
    list.excludes(name);
    command.callback([typed] {
        if (!typed->lists && typed->name.empty()) {
            throw InputError("study new: which protocol? springdrive study new --list tells them");
        }
        write_new(*typed);
    });
}

namespace {

Cell range(int fewest, int most) { return Cell::like_number(fmt::format("{}-{}", fewest, most)); }

Cell minutes(double min_s, double max_s) {
    return Cell::like_number(fmt::format("{:.1f}-{:.1f}", min_s / 60.0, max_s / 60.0));
}

void write_length(std::ostream &out, const study::Protocol &protocol,
                  const study::SessionLength &length) {
    Table table = Table::with_columns("block,trials,min");
    for (std::size_t i = 0; i < length.blocks.size(); ++i) {
        const study::BlockLength &block = length.blocks[i];
        table.rows.push_back({protocol.blocks[i].name, range(block.min_trials, block.max_trials),
                              minutes(block.min_s, block.max_s)});
    }
    if (!protocol.questionnaire.empty()) {
        table.rows.push_back(
            {"questions", "", minutes(length.min_questions_s, length.max_questions_s)});
    }
    table.rows.push_back({"session, with breaks", range(length.min_trials, length.max_trials),
                          minutes(length.min_s, length.max_s)});
    out << '\n';
    write_text(out, table);
}

void write_trials(std::ostream &out, const std::vector<study::StimulusTrial> &trials) {
    if (trials.empty()) {
        return;
    }
    Table table = Table::with_columns("simulated:,force N,slid mm,deep mm,given mJ", ".2f");
    for (const study::StimulusTrial &trial : trials) {
        const study::DeliveredStimulus &delivered = trial.delivered;
        table.rows.push_back({trial.name, delivered.peak_force_N, 1e3 * delivered.aside_m,
                              1e3 * delivered.deepest_m, 1e3 * delivered.generated_J});
    }
    out << '\n';
    write_text(out, table);
}

/// Findings, errors first; the session's length; the largest of what was simulated.
void write_study_check(std::ostream &out, const study::Protocol &protocol,
                       const study::CheckedProtocol &checked) {
    for (const study::ProtocolFinding &finding : checked.findings) {
        print(out, "{}\n", study::text_of(finding));
    }
    write_length(out, protocol, checked.length);
    print(out, "\nhottest winding of a session: {:.0f} °C\n", checked.hottest_winding_C);
    write_trials(out, checked.trials);
}

struct TypedProtocolCheck {
    std::filesystem::path protocol;
    bool simulates = true;
};

void check_typed(const TypedProtocolCheck &typed) {
    const study::Protocol protocol = typed_protocol(typed.protocol);
    study::CheckOptions options;
    options.simulates = typed.simulates;
    study::CheckedProtocol checked =
        study::check_protocol(protocol, folders_beside(typed.protocol), options);
    const study::StudySetting setting =
        study::study_setting(protocol, folders_beside(typed.protocol));
    std::ranges::move(study_screen::check_for_persons(protocol, setting),
                      std::back_inserter(checked.findings));
    std::ranges::stable_sort(checked.findings, {}, &study::ProtocolFinding::severity);
    write_study_check(std::cout, protocol, checked);
    const auto errors = std::ranges::count(checked.findings, study::Severity::error,
                                           &study::ProtocolFinding::severity);
    if (errors > 0) {
        std::cerr << fmt::format("springdrive: {}: {} error{}, see above; nobody should sit down "
                                 "before {} mended\n",
                                 typed.protocol.string(), errors, errors == 1 ? "" : "s",
                                 errors == 1 ? "it is" : "they are");
        end_with_status(EXIT_FAILURE);
    }
}

} // namespace

void add_study_check_command(Command &study) {
    Command command = study.add_subcommand(
        "check", "everything that can be said of a protocol before anybody sits down");
    const auto typed = std::make_shared<TypedProtocolCheck>();
    command.add_option("protocol", typed->protocol, "a protocol file").type_name("FILE").required();
    command.add_flag_callback(
        "--no-simulation", [typed] { typed->simulates = false; },
        "leave out the simulation of each condition");
    command.footer("Exit status: 0 no errors, 1 errors, or a file that is no protocol.");
    command.callback([typed] { check_typed(*typed); });
}

} // namespace springdrive::app
