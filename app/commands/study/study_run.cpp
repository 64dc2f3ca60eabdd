#include "app/commands/study/study_commands.h"

#include "app/commands/common_options.h"
#include "app/commands/progress_line.h"
#include "app/commands/study/opened_study.h"
#include "app/commands/study/person_session.h"
#include "app/commands/study/simulated_session.h"
#include "app/ending_signal.h"
#include "base/input_error.h"
#include "engine/study/protocol/session_length.h"
#include "engine/study/results/progress.h"

#include <CLI/CLI.hpp>

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <map>
#include <memory>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

constexpr int kMostParticipants = 9999; ///< codes have four digits at most

struct TypedRun {
    fs::path file;  ///< a protocol or a study
    fs::path study; ///< with a protocol; empty: its name, with another ending
    std::string participant;
    int participants = 0; ///< 0: the one above
    std::string observer;
    TypedObserver truth;
    double spread = 0.0;
    std::optional<int> seed; ///< nothing: the protocol's
    study::FeltStimuli felt = study::FeltStimuli::each_simulated;
    TypedSitting sitting; ///< of a person

    [[nodiscard]] bool is_simulated() const { return !observer.empty(); }
};

const study::Progress *progress_named(const std::vector<study::Progress> &all,
                                      const std::string &code) {
    const auto found = std::ranges::find(all, code, &study::Progress::participant);
    return found == all.end() ? nullptr : &*found;
}

/// A study that is open, while its participants take their turns.
class Runs {
public:
    Runs(const fs::path &file, const TypedRun &typed)
        : typed_(typed), store_(file), protocol_(protocol_in(store_.contents(), file)),
          setting_(study::study_setting(protocol_, folders_beside(file))) {
        for (std::size_t i = 0; i < protocol_.conditions.size(); ++i) {
            if (const std::string &problem = setting_.conditions[i].problem; !problem.empty()) {
                throw InputError(fmt::format("{}: condition \"{}\": {}", file.string(),
                                             protocol_.conditions[i].name, problem));
            }
        }
    }

    [[nodiscard]] std::vector<study::Progress> progress() const {
        return study::progress_of(protocol_, store_.contents());
    }

    /// The participant's session; added to the study if they are new.
    void run(const std::string &code) {
        if (progress_named(progress(), code) == nullptr) {
            store_.add({code, study::next_participant_number(store_.contents()), study::utc_now()});
        }
        const study::Progress before = *progress_named(progress(), code);
        if (!before.next) {
            throw InputError(fmt::format("{}: participant {} has done all {} trials",
                                         store_.file().string(), code, before.trials));
        }
        if (is_person(before)) {
            run_person(code);
        } else {
            run_simulated(before);
        }
    }

    /// Who comes next if nobody is named: added already but not begun, or new.
    [[nodiscard]] std::string next_code() const {
        const std::vector<study::Progress> all = progress();
        const auto waiting = std::ranges::find(all, 0, &study::Progress::sessions);
        if (waiting != all.end()) {
            return waiting->participant;
        }
        int number = study::next_participant_number(store_.contents());
        while (progress_named(all, code_of(number)) != nullptr) {
            ++number;
        }
        return code_of(number);
    }

    /// "P07"
    static std::string code_of(int number) { return fmt::format("P{:02}", number); }

private:
    /// Sessions of one participant are all a person's, or all a simulated observer's.
    [[nodiscard]] bool is_person(const study::Progress &progress) const {
        const std::optional<study::Session> last = last_session(progress.participant);
        return last ? !observer_in(*last).has_value() : !typed_.is_simulated();
    }

    [[nodiscard]] std::optional<study::Session> last_session(const std::string &code) const {
        const study::StudyContents contents = store_.contents();
        const auto last = std::ranges::find(contents.sessions.rbegin(), contents.sessions.rend(),
                                            code, &study::Session::participant);
        return last == contents.sessions.rend() ? std::nullopt : std::optional(*last);
    }

    void run_person(const std::string &code) {
        if (typed_.is_simulated()) {
            throw InputError(fmt::format("{}: participant {} is a person, whose sessions cannot "
                                         "go on with a simulated observer",
                                         store_.file().string(), code));
        }
        const study_screen::EndedSitting ended = run_person_session(
            store_, protocol_, setting_, folders_beside(store_.file()), code, typed_.sitting);
        tell(code, ended.session, ended.trials, ended.marked, ended.ending);
    }

    void run_simulated(const study::Progress &before) {
        const std::string &code = before.participant;
        const SimulatedObserver observer = observer_of_participant(before);
        EndedSession ended;
        {
            ProgressLine line;
            const int most = study::session_length(protocol_).most_trials;
            int trials = before.trials;
            ended = run_simulated_session(
                store_, {protocol_, setting_, code, observer, [&line, &code, &trials, most] {
                             line.show(code, std::min(1.0, 1.0 * trials++ / most));
                         }});
        }
        tell(code, ended.id, ended.trials, ended.marked, ended.ending);
    }

    template <typename Count>
    void tell(const std::string &code, study::SessionId session, Count trials, Count marked,
              study::SessionEnding ending) const {
        std::cout << fmt::format("{}: session {}, {} trials, {} marked: {}\n", code, session,
                                 trials, marked, study::name_of(ending))
                  << std::flush;
        judge(code, ending);
    }

    /// The one who answered before; else the one that was typed.
    SimulatedObserver observer_of_participant(const study::Progress &progress) const {
        const std::optional<study::Session> last = last_session(progress.participant);
        if (!last) {
            SimulatedObserver drawn = participant_of_group(
                observer_of(typed_.truth, protocol_), typed_.spread,
                static_cast<std::uint64_t>(typed_.seed.value_or(protocol_.seed)), progress.number);
            drawn.felt = typed_.felt;
            return drawn;
        }
        if (typed_.truth.is_typed() || typed_.seed) {
            std::cerr << fmt::format(
                "springdrive: {} keeps the observer of the first session; what "
                "is typed is for new participants\n",
                progress.participant);
        }
        return observer_in(*last).value(); // see is_person
    }

    /// What is no success is told, and ends the command.
    void judge(const std::string &code, study::SessionEnding ending) const {
        if (ending == study::SessionEnding::completed) {
            return;
        }
        std::cerr << fmt::format("springdrive: {} is not through; to go on: springdrive study "
                                 "resume {}\n",
                                 code, store_.file().string());
        if (ending != study::SessionEnding::stopped && ending != study::SessionEnding::left) {
            throw CLI::RuntimeError(EXIT_FAILURE);
        }
    }

    const TypedRun &typed_;
    study::StudyStore store_;
    study::Protocol protocol_;
    study::StudySetting setting_;
};

void refuse_code(const std::string &code) {
    if (const std::string wrong = study::what_is_wrong_with_code(code); !wrong.empty()) {
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
    check_range("--spread", typed.spread, 0.0, 10.0);
    check_range("--seed", typed.seed.value_or(0), 0, std::numeric_limits<int>::max());
    if (!typed.participant.empty()) {
        refuse_code(typed.participant);
    }
    note_ending_signals();
    const fs::path file =
        study_to_run(typed.file, typed.study, [&typed](const study::Protocol &protocol) {
            static_cast<void>(observer_of(typed.truth, protocol));
        });
    Runs runs(file, typed);
    if (!typed.participant.empty() || !typed.is_simulated()) {
        runs.run(typed.participant.empty() ? runs.next_code() : typed.participant);
        return;
    }
    for (int i = 1; i <= typed.participants && !asked_to_end(); ++i) {
        const std::string code = Runs::code_of(i);
        const std::vector<study::Progress> progress = runs.progress();
        const study::Progress *before = progress_named(progress, code);
        if (before == nullptr || before->next) {
            runs.run(code);
        }
    }
}

struct TypedResume {
    fs::path study;
    std::string participant; ///< empty: all who are not through
    TypedRun nothing_new;    ///< but the device and windows of a person
};

void resume_typed(const TypedResume &typed) {
    note_ending_signals();
    Runs runs(typed.study, typed.nothing_new);
    const std::vector<study::Progress> all = runs.progress();
    if (!typed.participant.empty()) {
        if (progress_named(all, typed.participant) == nullptr) {
            throw InputError(fmt::format("{}: there is no participant {}", typed.study.string(),
                                         typed.participant));
        }
        runs.run(typed.participant);
        return;
    }
    bool has_run = false;
    for (const study::Progress &one : all) {
        if (one.next && one.sessions > 0 && !asked_to_end()) {
            runs.run(one.participant);
            has_run = true;
        }
    }
    if (!has_run) {
        std::cout << typed.study.string()
                  << ": nobody is in the midst of it; springdrive study run begins with the next\n";
    }
}

void add_run(CLI::App &study) {
    CLI::App &command = *study.add_subcommand(
        "run", "a participant's session, trial by trial; begun and ended at any time");
    const auto typed = std::make_shared<TypedRun>();
    command
        .add_option("file", typed->file,
                    "a protocol, whose study is created if there is none; or a study")
        ->type_name("FILE")
        ->required();
    command
        .add_option("--study", typed->study,
                    "the study file of a protocol [that of the same name, ending in .study]")
        ->type_name("FILE");
    CLI::Option *one = command.add_option(
        "--participant", typed->participant,
        "code of the participant, such as P01: no name. A new one is added [the next "
        "new one, if it is a person]");
    one->type_name("CODE");
    command
        .add_option("--participants", typed->participants,
                    "a whole study of simulated participants, P01 and so on")
        ->type_name("N")
        ->check(CLI::Range(1, kMostParticipants).description(""))
        ->excludes(one);
    command
        .add_option("--observer", typed->observer,
                    "a simulated observer sits there, without windows [a person]")
        ->type_name("WHO:{simulated}")
        ->check(CLI::IsMember({"simulated"}).description(""));
    add_observer_options(command, typed->truth);
    command
        .add_option("--spread", typed->spread,
                    "standard deviation of simulated thresholds between participants: of the "
                    "logarithm where the protocol's function is on a logarithmic scale [0]")
        ->type_name("NUMBER");
    command
        .add_option("--seed", typed->seed,
                    "of what simulated observers are and answer [the protocol's]")
        ->type_name("N");
    command
        .add_option("--felt", typed->felt,
                    "what a simulated observer feels: each presentation simulated, or each "
                    "condition and level simulated once, which is much faster [each]")
        ->type_name("HOW:{each,once}")
        ->transform(CLI::CheckedTransformer(std::map<std::string, study::FeltStimuli>{
                                                {"each", study::FeltStimuli::each_simulated},
                                                {"once", study::FeltStimuli::measured_once}})
                        .description(""));
    typed->sitting.add_to(command);
    command.footer(
        "Each trial is on the disk before the next begins. Ctrl+C ends the session after "
        "the present one;\nstudy resume goes on with the same sequence, also after a "
        "crash.");
    command.callback([typed] { run_typed(*typed); });
}

void add_resume(CLI::App &study) {
    CLI::App &command = *study.add_subcommand(
        "resume", "goes on with sessions that were left, with the sequence of undisturbed ones");
    const auto typed = std::make_shared<TypedResume>();
    add_study_file_argument(command, typed->study);
    command
        .add_option("--participant", typed->participant, "only this one [all who are not through]")
        ->type_name("CODE");
    typed->nothing_new.sitting.add_to(command);
    command.callback([typed] { resume_typed(*typed); });
}

} // namespace

void add_study_run_commands(CLI::App &study) {
    add_run(study);
    add_resume(study);
}

} // namespace springdrive::app
