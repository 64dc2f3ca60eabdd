#include "app/commands/study/study_commands.h"

#include "app/commands/study/opened_study.h"
#include "base/input_error.h"
#include "engine/study/store/study_store.h"

#include <fmt/core.h>

#include <algorithm>
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
