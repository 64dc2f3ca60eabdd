// Subcommands on a study's file, without a session: `status`, `export`, `note` and `remove`.
#include "app/commands/command.h"
#include "app/commands/output_files.h"
#include "app/commands/study/observer_options.h"
#include "app/commands/study/opened_study.h"
#include "base/for_persons.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/table.h"
#include "base/text.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/export/trial_table.h"
#include "engine/study/protocol/session_plan.h"
#include "engine/study/store/study_store.h"

#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

std::string devices_text(const std::vector<study::DeviceKind> &devices) {
    std::string text;
    for (const study::DeviceKind device : devices) {
        text += (text.empty() ? "" : ", ") + std::string(study::name_of(device));
    }
    return text.empty() ? "-" : text;
}

/// "block 1 of 2 (\"right and left\"), trial 61; stopped"
std::string stand_of(const study::Protocol &protocol, const study::StudyContents &contents,
                     const study::Progress &progress) {
    std::string text;
    if (!progress.next) {
        const bool is_asked = is_person(contents, progress.participant).value_or(false);
        text = progress.has_open_questions && is_asked ? "through, but for questions" : "through";
    } else {
        const study::PlannedTrial &next = *progress.next;
        text = fmt::format("block {} of {} (\"{}\"), trial {}", next.place.block,
                           protocol.blocks.size(), protocol.blocks[progress.next_block].name,
                           next.place.position);
        if (progress.sessions == 0) {
            text = "not begun";
        } else if (!progress.last_ending) {
            text += "; running, or interrupted";
        } else if (*progress.last_ending != study::SessionEnding::completed) {
            text += "; " + std::string(study::name_of(*progress.last_ending));
        }
    }
    if (progress.blocks_unfinished > 0) {
        text += fmt::format("; {} block{} ended by too many marked trials",
                            progress.blocks_unfinished, progress.blocks_unfinished == 1 ? "" : "s");
    }
    return text;
}

/// "questions: 7 answers: hand 4, tiring 3; 4 sessions", of a protocol that asks some.
void write_answers(std::ostream &out, const OpenedStudy &study) {
    const std::vector<study::QuestionnaireItem> &items = study.protocol.questionnaire;
    if (items.empty() && study.contents.answers.empty()) {
        return;
    }
    print(out, "questions: {} answers", study.contents.answers.size());
    for (const study::QuestionnaireItem &item : items) {
        print(out, "{}{} {}", &item == &items.front() ? ": " : ", ", item.name,
              std::ranges::count(study.contents.answers, item.name,
                                 &study::QuestionnaireAnswer::item));
    }
    print(out, "; {} sessions\n", study.contents.sessions.size());
}

void write_records(std::ostream &out, const study::StudyContents &contents,
                   const std::vector<std::string> &wrong) {
    const auto linked = std::ranges::count_if(
        contents.trials, [](const study::Trial &trial) { return trial.record.has_value(); });
    if (linked == 0) {
        out << "servo records: none\n";
        return;
    }
    print(out, "servo records: {}, {}\n", linked,
          wrong.empty() ? std::string("all as they were linked")
                        : fmt::format("{} with a problem:", wrong.size()));
    for (const std::string &line : wrong) {
        out << "  " << line << '\n';
    }
}

/// One screen: the study, a line for each participant, records and what is wrong with them.
void write_study_status(std::ostream &out, const std::filesystem::path &file,
                        const OpenedStudy &study, const std::vector<study::Progress> &participants,
                        const std::vector<std::string> &wrong_records) {
    const study::StudyFacts &facts = study.contents.facts;
    print(out, "{}: {}\n", file.string(), one_line(facts.title));
    print(out, "begun {} with springdrive {}\n\n", study::utc_text(facts.created),
          one_line(facts.software));
    Table table = Table::with_columns("participant,device,sessions,trials,practice,marked,at");
    int trials = 0;
    int marked = 0;
    for (const study::Progress &one : participants) {
        table.rows.push_back({one.participant, devices_text(one.devices), one.sessions, one.trials,
                              one.practice, one.marked,
                              stand_of(study.protocol, study.contents, one)});
        trials += one.trials;
        marked += one.marked;
    }
    write_text(out, table);
    const auto through = std::ranges::count_if(
        participants, [](const study::Progress &one) { return !one.next.has_value(); });
    const study::SessionLength length = study::session_length(study.protocol);
    print(out, "\nthrough: {} of {} participants of the protocol{}\n", through,
          study.protocol.participants,
          facts.removed_participants > 0
              ? fmt::format("; {} removed on request", facts.removed_participants)
              : std::string());
    print(out, "trials: {}, {} marked; each participant has {} to {} without the marked ones\n",
          trials, marked, length.min_trials, length.max_trials);
    write_answers(out, study);
    write_records(out, study.contents, wrong_records);
    for (const study::Note &note : study.contents.notes) {
        print(out, "{}: {}{}: {}\n", one_line(note.kind), study::utc_text(note.at),
              note.participant ? " " + *note.participant : std::string(), one_line(note.text));
    }
}

} // namespace

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

namespace {

struct TypedStudyExport {
    std::filesystem::path study;
    std::string csv;
    std::string answers;
    std::filesystem::path bids;
    std::vector<std::string> authors; ///< of the dataset
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
    if (!typed.authors.empty() && typed.bids.empty()) {
        throw InputError("--author: is for --bids; add it, or omit --author");
    }
    for (const std::string &author : typed.authors) {
        if (one_line(author).empty() || !is_utf8(author)) {
            throw InputError("--author " + in_quotes(author) + ": is no name");
        }
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
                          {{typed.device}, SPRINGDRIVE_VERSION, questionnaire, typed.authors});
        if (typed.authors.empty()) {
            std::cerr << typed.bids.string()
                      << "/dataset_description.json: names no authors, "
                         "which whoever publishes it needs; --author adds "
                         "one\n";
        }
    }
    const auto write = [&typed](const std::string &where, const Table &table) {
        write_output(where,
                     [&](std::ostream &out) {
                         (where == "-" ? write_csv : write_csv_for_persons)(out, table);
                     },
                     {typed.existing, Readers::owner});
    };
    if (!typed.answers.empty()) {
        write(typed.answers, study::answer_table(contents, questionnaire, {typed.device}));
    }
    if (!typed.csv.empty()) {
        write(typed.csv, study::table_of(study::trial_columns(contents),
                                         study::trials_in_study(contents, {typed.device})));
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
    command
        .add_option("--author", typed->authors,
                    "with --bids, of the dataset, as in \"Ada Lovelace\"; may be repeated")
        .type_name("NAME");
    add_device_kind_option(command, typed->device);
    add_force_option(command, typed->existing);
    command.callback([typed] { export_study(*typed); });
}

namespace {

struct TypedNote {
    std::filesystem::path study;
    std::string text;
    std::string participant; ///< empty: about the study
};

void append_note(const TypedNote &typed) {
    study::StudyStore store(typed.study);
    warn_of_study(store.contents(), typed.study);
    const auto about = typed.participant.empty() ? std::nullopt : std::optional(typed.participant);
    store.append({study::utc_now(), "note", typed.text, about, std::nullopt});
}

void add_note(Command &study) {
    Command command = study.add_subcommand("note", "adds a note to a study");
    const auto typed = std::make_shared<TypedNote>();
    add_study_file_argument(command, typed->study);
    command.add_option("text", typed->text, "the note, in quotes. It is stored as typed: no names")
        .type_name("TEXT")
        .required();
    command.add_option("--participant", typed->participant, "whom it is about [nobody: the study]")
        .type_name("CODE");
    command.callback([typed] { append_note(*typed); });
}

struct TypedRemove {
    std::filesystem::path study;
    std::string participant;
    bool is_sure = false;
};

void remove_typed(const TypedRemove &typed) {
    if (!typed.is_sure) {
        const study::StudyContents contents = study::read_study(typed.study);
        const std::string &code = typed.participant;
        if (std::ranges::count(contents.unfinished_removals, code) > 0) {
            throw InputError(unfinished_removal_text(contents, typed.study));
        }
        if (std::ranges::count(contents.participants, code, &study::Participant::code) == 0) {
            throw InputError(typed.study.string() + ": " + study::no_participant_text(code));
        }
        throw InputError(fmt::format("{}: participant {} has {} trials, which would be gone for "
                                     "good, with all that is in {}/{}; add --yes to remove them",
                                     typed.study.string(), code,
                                     study::trials_of(contents, code).size(),
                                     contents.facts.records_folder, code));
    }
    study::StudyStore store(typed.study);
    const study::Removed removed = store.remove_participant(typed.participant);
    std::cerr << fmt::format("removed: {} with all trials, answers and records", typed.participant);
    if (removed.redacted > 0) {
        std::cerr << fmt::format("; the code was replaced in {} text{} of others or of the study",
                                 removed.redacted, removed.redacted == 1 ? "" : "s");
    }
    std::cerr << "; copies and exports of the study are not reached\n";
    if (removed.is_in_study) {
        std::cerr << fmt::format("springdrive: {}: its title, protocol or name has the code {}, "
                                 "too, and stays as it was; begin later studies without\n",
                                 typed.study.string(), typed.participant);
    }
}

void add_remove(Command &study) {
    Command command = study.add_subcommand(
        "remove", "deletes a participant with all trials, answers and records, without a trace");
    const auto typed = std::make_shared<TypedRemove>();
    add_study_file_argument(command, typed->study);
    command.add_option("participant", typed->participant, "whom").type_name("CODE").required();
    command.add_flag("--yes", typed->is_sure, "without it, only says what would be deleted");
    command.callback([typed] { remove_typed(*typed); });
}

} // namespace

void add_study_edit_commands(Command &study) {
    add_note(study);
    add_remove(study);
}

} // namespace springdrive::app
