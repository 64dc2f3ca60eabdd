#include "app/commands/study/study_commands.h"

#include "app/commands/study/opened_study.h"
#include "base/input_error.h"
#include "engine/study/results/progress.h"
#include "engine/study/store/study_store.h"

#include <CLI/CLI.hpp>

#include <fmt/core.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::app {

namespace {

struct TypedNote {
    std::filesystem::path study;
    std::string text;
    std::string participant; ///< empty: about the study
};

void append_note(const TypedNote &typed) {
    study::StudyStore store(typed.study);
    study::Note note{study::utc_now(), "note", typed.text, std::nullopt, std::nullopt};
    if (!typed.participant.empty()) {
        note.participant = study::participant_of(store.contents(), typed.participant).code;
    }
    store.append(note);
}

void add_note(CLI::App &study) {
    CLI::App &command = *study.add_subcommand("note", "adds a note to a study");
    const auto typed = std::make_shared<TypedNote>();
    add_study_file_argument(command, typed->study);
    command.add_option("text", typed->text, "the note, in quotes. It is stored as typed: no names")
        ->type_name("TEXT")
        ->required();
    command.add_option("--participant", typed->participant, "whom it is about [nobody: the study]")
        ->type_name("CODE");
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
        const std::string code = study::participant_of(contents, typed.participant).code;
        throw InputError(fmt::format("{}: participant {} has {} trials, which would be gone for "
                                     "good, with their records; add --yes to remove them",
                                     typed.study.string(), code,
                                     study::trials_of(contents, code).size()));
    }
    study::StudyStore store(typed.study);
    store.remove_participant(typed.participant);
    std::cerr << fmt::format(
        "removed: {} with all trials, answers and records; copies and exports of the "
        "study are not reached\n",
        typed.participant);
}

void add_remove(CLI::App &study) {
    CLI::App &command = *study.add_subcommand(
        "remove", "deletes a participant with all trials, answers and records, without a trace");
    const auto typed = std::make_shared<TypedRemove>();
    add_study_file_argument(command, typed->study);
    command.add_option("participant", typed->participant, "whom")->type_name("CODE")->required();
    command.add_flag("--yes", typed->is_sure, "without it, only says what would be deleted");
    command.callback([typed] { remove_typed(*typed); });
}

} // namespace

void add_study_edit_commands(CLI::App &study) {
    add_note(study);
    add_remove(study);
}

} // namespace springdrive::app
