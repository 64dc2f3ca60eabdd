#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/study/opened_study.h"
#include "app/commands/study/study_turns.h"
#include "app/host/process.h"
#include "app/study/session/study_session.h"
#include "base/input_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <iostream>
#include <limits>
#include <map>
#include <memory>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxParticipants = 9999; ///< codes have four digits at most

void refuse_code(const std::string &code) {
    if (const std::string wrong = study::validate_code(code); !wrong.empty()) {
        throw InputError(wrong);
    }
}

void run_typed(const TypedRun &typed) {
    if (typed.is_simulated() && typed.participant.empty() && typed.participants == 0) {
        throw InputError("study run: who? --participant P01, or --participants 12 for a whole "
                         "study of simulated ones");
    }
    if (!typed.is_simulated() && typed.participants > 0) {
        throw InputError(
            "--participants: is for simulated ones, with --observer simulated; persons "
            "come one at a time");
    }
    if (!typed.is_simulated() && (typed.truth.is_typed() || typed.seed || typed.spread != 0.0)) {
        throw InputError("--threshold, --slope, --lapse, --spread, --seed and so on: are for "
                         "simulated ones, with --observer simulated");
    }
    check_range("--spread", typed.spread, 0.0, 10.0);
    check_range("--seed", typed.seed.value_or(0), 0, std::numeric_limits<int>::max());
    if (!typed.participant.empty()) {
        refuse_code(typed.participant);
    }
    note_ending_signals();
    const fs::path file =
        study_to_run(typed.file, typed.study, [&typed](const study::Protocol &protocol) {
            if (typed.is_simulated()) {
                static_cast<void>(observer_of(typed.truth, protocol));
                return;
            }
            const study::StudySetting setting =
                study::study_setting(protocol, folders_beside(typed.file));
            if (const std::string wrong =
                    study_screen::validate_for_participants(protocol, setting);
                !wrong.empty()) {
                throw InputError(typed.file.string() + ": " + wrong);
            }
        });
    StudyTurns turns(file, typed);
    if (!typed.is_simulated()) {
        turns.run_person(typed.participant.empty() ? turns.next_code() : typed.participant);
        return;
    }
    if (!typed.participant.empty()) {
        turns.run(typed.participant);
        return;
    }
    bool has_run = false;
    for (int i = 1; i <= typed.participants && !asked_to_end(); ++i) {
        const std::string code = StudyTurns::code_of(i);
        if (!turns.is_through(code)) {
            turns.run(code);
            has_run = true;
        }
    }
    if (!has_run && !asked_to_end()) {
        std::cout << fmt::format("{}: all {} participants are through already; a larger "
                                 "--participants adds some\n",
                                 file.string(), typed.participants);
    }
}

struct TypedResume {
    fs::path study;
    std::string participant; ///< empty: all who are not through
    TypedRun nothing_new;    ///< but the device and windows of a person
};

void resume_typed(const TypedResume &typed) {
    note_ending_signals();
    StudyTurns turns(typed.study, typed.nothing_new);
    const std::vector<study::Progress> all = turns.progress();
    if (!typed.participant.empty()) {
        if (std::ranges::count(all, typed.participant, &study::Progress::participant) == 0) {
            throw InputError(fmt::format("{}: there is no participant {}; springdrive study status "
                                         "lists them",
                                         typed.study.string(), typed.participant));
        }
        turns.run(typed.participant);
        return;
    }
    const auto is_begun = [&turns](const study::Progress &one) {
        return one.sessions > 0 &&
               (one.next || (one.has_open_questions && turns.is_person(one.participant)));
    };
    std::string persons;
    int count = 0;
    for (const study::Progress &one : all) {
        if (is_begun(one) && turns.is_person(one.participant)) {
            persons += (count++ > 0 ? ", " : "") + one.participant;
        }
    }
    if (count > 1) { // whoever sits down must not go on with another one's session
        throw InputError(fmt::format("{}: {} are in the midst of it; say with --participant who of "
                                     "them sits here",
                                     typed.study.string(), persons));
    }
    bool has_run = false;
    for (const study::Progress &one : all) {
        if (is_begun(one) && !asked_to_end()) {
            turns.run(one.participant);
            has_run = true;
        }
    }
    if (!has_run) {
        std::cout << typed.study.string()
                  << ": nobody is in the midst of it; springdrive study run begins with the next\n";
    }
}

void add_run(Command &study) {
    Command command = study.add_subcommand(
        "run", "a participant's session, trial by trial; begun and ended at any time");
    const auto typed = std::make_shared<TypedRun>();
    command
        .add_option("file", typed->file,
                    "a protocol, whose study is created if there is none; or a study")
        .type_name("FILE")
        .required();
    command
        .add_option("--study", typed->study,
                    "the study file of a protocol [that of the same name, ending in .study]")
        .type_name("FILE");
    Option one = command.add_option(
        "--participant", typed->participant,
        "code of the participant, such as P01: no name. A new one is added [the next "
        "new one, if it is a person]");
    one.type_name("CODE");
    command
        .add_option("--participants", typed->participants,
                    "a whole study of simulated participants, P01 and so on")
        .type_name("N")
        .in_range(1, kMaxParticipants, InHelp::unlisted)
        .excludes(one);
    command
        .add_option("--observer", typed->observer,
                    "a simulated observer sits there, without windows [a person]")
        .type_name("WHO:{simulated}")
        .one_of({"simulated"}, InHelp::unlisted);
    add_observer_options(command, typed->truth);
    command
        .add_option("--spread", typed->spread,
                    "standard deviation of simulated thresholds between participants: of the "
                    "logarithm where the protocol's function is on a logarithmic scale [0]")
        .type_name("NUMBER");
    command
        .add_option("--seed", typed->seed,
                    "of what simulated observers are and answer [the protocol's]")
        .type_name("N");
    command
        .add_choice("--felt", typed->felt,
                    {{"each", study::FeltStimuli::each_simulated},
                     {"once", study::FeltStimuli::measured_once}},
                    "what a simulated observer feels: each presentation simulated, or each "
                    "condition and level simulated once, which is much faster [each]")
        .type_name("HOW:{each,once}");
    typed->study_session.add_to(command);
    command.footer(
        "Each trial is on the disk before the next begins. Ctrl+C ends a person's session at once, "
        "and a simulated\nobserver's after the present trial; study resume goes on with the same "
        "sequence, also after a crash.");
    command.callback([typed] { run_typed(*typed); });
}

void add_resume(Command &study) {
    Command command = study.add_subcommand(
        "resume", "goes on with sessions that were left, with the sequence of undisturbed ones");
    const auto typed = std::make_shared<TypedResume>();
    add_study_file_argument(command, typed->study);
    command
        .add_option("--participant", typed->participant, "only this one [all who are not through]")
        .type_name("CODE");
    typed->nothing_new.study_session.add_to(command);
    command.callback([typed] { resume_typed(*typed); });
}

} // namespace

void add_study_run_commands(Command &study) {
    add_run(study);
    add_resume(study);
}

} // namespace springdrive::app
