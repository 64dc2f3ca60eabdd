#include "app/commands/study/study_turns.h"

#include "app/commands/command.h"
#include "app/commands/output_files.h"
#include "app/commands/study/opened_study.h"
#include "app/host/folders.h"
#include "app/host/process.h"
#include "app/stage/frame_loop.h"
#include "app/study/session/resumable.h"
#include "app/study/session/study_session.h"
#include "base/input_error.h"
#include "base/timing.h"
#include "engine/session/session.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/protocol/session_plan.h"
#include "engine/study/protocol/study_setting.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iostream>

namespace springdrive::app {

namespace {

/// The scene of the first condition that has one; else one in which nothing is touched.
std::filesystem::path first_scene(const study::Protocol &protocol,
                                  const study::ProtocolFolders &folders) {
    const auto found =
        std::ranges::find_if(protocol.conditions, [](const study::Condition &condition) {
            return condition.scene != study::kNoScene;
        });
    return found != protocol.conditions.end() ? study::scene_file_of(*found, folders)
                                              : asset_folder() / "scenes" / "plate.gltf";
}

void say_what_it_is(const session::Session &session) {
    if (session.device_choice().kind != factory::DeviceKind::usb) {
        std::cerr << "springdrive: this is a rehearsal: no person holds the "
                  << (session.device_choice().kind == factory::DeviceKind::emulated ? "emulated"
                                                                                    : "simulated")
                  << " device, its hand is led by the program; the trials are stored as such\n";
    }
}

} // namespace

void TypedStudySession::add_device_to(Command &command) {
    add_device_option(command, device);
    command.add_flag("--at-zero", starts_at_zero,
                     "the device on USB is held in its zero pose at the start: upper arm level, "
                     "forearm hanging, tip at the origin");
    emulation.add_to(command, "emulated board");
    command.add_option("--cpu", cpu, "the processor to which the servo thread is bound")
        .type_name("N");
}

void TypedStudySession::add_to(Command &command) {
    add_device_to(command);
    command
        .add_option("--participant-screen", window.participant.monitor,
                    "the participant's monitor, by number or a part of its name [the second; a "
                    "window if there is one only]")
        .type_name("MONITOR");
    command.add_flag("--participant-window", window.participant.is_window,
                     "the participant's screen is a window, not a whole monitor");
    command
        .add_option("--participant-width", window.participant.size.width, "of that window [1280]")
        .type_name("PIXELS");
    command
        .add_option("--participant-height", window.participant.size.height, "of that window [720]")
        .type_name("PIXELS");
    command.add_option("--width", window.size.width, "of the experimenter's window [1280]")
        .type_name("PIXELS");
    command.add_option("--height", window.size.height, "of the experimenter's window [720]")
        .type_name("PIXELS");
    command.add_option("--scale", window.scale, "of its text and panels [the display's scale]")
        .type_name("FACTOR");
    command.add_flag_callback(
        "--without-records", [this] { keeps_records = false; },
        "keep no servo record of each trial, which takes about 1 MB a second");
    command.add_flag_callback(
        "--without-noise", [this] { plays_noise = false; },
        "do not play the protocol's masking noise, as in a rehearsal");
    command.add_flag("--lockstep", is_in_lockstep,
                     "run the servo by frame time instead of the clock, which is repeatable; not "
                     "on USB");
    command.add_flag("--report", reports,
                     "for each line \"report\" on standard input, write what the experimenter's "
                     "window shows as a line of JSON");
}

session::SessionOptions session_options_of(const study::Protocol &protocol,
                                           const study::ProtocolFolders &folders,
                                           const TypedStudySession &typed) {
    const study::Condition &first = protocol.conditions.front();
    const NamedDevice named = device_named(typed.device);
    if (named.kind != factory::DeviceKind::emulated && !typed.emulation.is_empty()) {
        throw InputError("--true-device-file and --fault: are for the emulated board; remove them, "
                         "or give --device emulated");
    }
    session::SessionOptions options;
    options.scene = first_scene(protocol, folders);
    options.device.file = study::device_file_of(protocol, folders);
    options.device.kind = named.kind;
    options.device.serial = named.serial;
    options.tuning = study::free_space_tuning(protocol, first).value_or(first.tuning);
    options.servo_hz = first.servo_hz;
    options.delay_periods = first.delay_periods;
    options.starts_at_zero = typed.starts_at_zero || named.kind == factory::DeviceKind::emulated;
    options.lockstep = typed.is_in_lockstep;
    options.cpu = typed.cpu;
    options.program_version = SPRINGDRIVE_VERSION;
    options.windings_folder = windings_folder();
    if (named.kind == factory::DeviceKind::emulated) {
        options.emulation.truth = typed.emulation.truth();
        options.emulation.faults = typed.emulation.parsed_faults();
    }
    return options;
}

void run_person_session(study::StudyStore &store, const study::Protocol &protocol,
                        const study::StudySetting &setting, const study::ProtocolFolders &folders,
                        const std::string &code, const TypedStudySession &typed) {
    if (const std::string wrong = study_screen::validate_for_participants(protocol, setting);
        !wrong.empty()) {
        throw InputError(store.file().string() + ": " + wrong);
    }
    session::Session session = open_session(session_options_of(protocol, folders, typed));
    say_what_it_is(session);
    study_screen::StudyWindow window(typed.window, session, store, protocol);
    session.start();
    print_new_warnings(session);
    study_screen::StudySession study_session(
        store,
        {protocol, setting, folders, code, typed.keeps_records, typed.plays_noise, window.facts()},
        session, [&window](const scene::Scene &scene, const scene::TouchSpot &spot) {
            window.show_scene(scene, spot);
        });
    study_screen::StudySessionActivity activity(study_session, window);
    end_well_without_display([&] {
        session.stop();
        study_session.fail();
    });
    run_frames(activity, session, {.reports = typed.reports});
    end_well_without_display({});
    session.stop();
}

namespace {

const study::Progress *progress_named(const std::vector<study::Progress> &all,
                                      const std::string &code) {
    const auto found = std::ranges::find(all, code, &study::Progress::participant);
    return found == all.end() ? nullptr : &*found;
}

} // namespace

StudyTurns::StudyTurns(const std::filesystem::path &file, const TypedRun &typed)
    : typed_(typed), store_(file), protocol_(protocol_in(store_.contents(), file)),
      setting_(study::study_setting(protocol_, folders_beside(file))) {
    const study::StudyContents contents = store_.contents();
    if (!contents.unfinished_removals.empty()) { // whose code a new participant could be given
        throw InputError(unfinished_removal_text(contents, file));
    }
    warn_of_study(contents, file);
    for (std::size_t i = 0; i < protocol_.conditions.size(); ++i) {
        if (const std::string &problem = setting_.conditions[i].problem; !problem.empty()) {
            throw InputError(fmt::format("{}: condition \"{}\": {}", file.string(),
                                         protocol_.conditions[i].name, problem));
        }
    }
}

std::vector<study::Progress> StudyTurns::progress() const {
    return study::progress_of(protocol_, store_.contents());
}

bool StudyTurns::is_through(const std::string &code) const {
    const std::vector<study::Progress> all = progress();
    const study::Progress *const one = progress_named(all, code);
    return one != nullptr && !one->next;
}

std::string StudyTurns::next_code() const {
    const std::vector<study::Progress> all = progress();
    const auto waiting = std::ranges::find(all, 0, &study::Progress::sessions);
    if (waiting != all.end()) {
        return waiting->participant;
    }
    // Lists on paper and older exports may have the code of somebody who was removed: of those that
    // were given here, none is given again.
    const study::StudyContents contents = store_.contents();
    const int ever =
        static_cast<int>(contents.participants.size()) + contents.facts.removed_participants;
    int number = std::max(study::next_participant_number(contents), ever + 1);
    const auto is_taken = [](const std::string &code, const study::Progress &one) {
        return one.participant == code || study::is_mistaken_for(code, one.participant);
    };
    while (std::ranges::any_of(
        all, [&](const study::Progress &one) { return is_taken(code_of(number), one); })) {
        ++number;
    }
    return code_of(number);
}

std::string StudyTurns::code_of(int number) { return fmt::format("P{:02}", number); }

void StudyTurns::run(const std::string &code) {
    if (progress_named(progress(), code) == nullptr) {
        store_.add({code, study::next_participant_number(store_.contents()), study::utc_now()});
    }
    const study::Progress before = *progress_named(progress(), code);
    if (!before.next && !(before.has_open_questions && is_person(code))) {
        throw InputError(fmt::format("{}: participant {} has done all {} trials",
                                     store_.file().string(), code, before.trials));
    }
    if (!is_person(code)) {
        run_simulated(before);
    } else if (typed_.is_simulated()) {
        throw InputError(fmt::format("{}: participant {} is a person, whose sessions cannot go on "
                                     "with a simulated observer",
                                     store_.file().string(), code));
    } else {
        run_person_session(store_, protocol_, setting_, folders_beside(store_.file()), code,
                           typed_.study_session);
    }
    tell(code);
}

void StudyTurns::run_person(const std::string &code) {
    if (!is_person(code)) {
        throw InputError(fmt::format("{}: participant {} is a simulated observer, with which "
                                     "springdrive study resume goes on; name another one",
                                     store_.file().string(), code));
    }
    run(code);
}

std::optional<study::Session> StudyTurns::last_session(const std::string &code) const {
    const study::StudyContents contents = store_.contents();
    const auto last = std::ranges::find(contents.sessions.rbegin(), contents.sessions.rend(), code,
                                        &study::Session::participant);
    return last == contents.sessions.rend() ? std::nullopt : std::optional(*last);
}

bool StudyTurns::is_person(const std::string &code) const {
    return app::is_person(store_.contents(), code).value_or(!typed_.is_simulated());
}

void StudyTurns::run_simulated(const study::Progress &before) {
    const SimulatedObserver observer = observer_of_participant(before);
    study::SimulatedParticipant participant;
    participant.function = observer.function;
    participant.seed = observer.seed;
    study::SimulatedStudySession study_session(protocol_, setting_, participant, observer.felt);
    study::Session session;
    session.participant = before.participant;
    session.started = study::utc_now();
    session.device = study::DeviceKind::simulated;
    session.device_name = setting_.device.name;
    session.software = SPRINGDRIVE_VERSION;
    session.host = machine_name();
    session.facts = facts_of(observer);
    session.id = store_.begin(session);
    ProgressLine line;
    const int most = study::session_length(protocol_).max_trials;
    int trials = before.trials;
    study::Conduct how;
    how.present = [&](const study::PlannedTrial &planned) {
        return study_session.present(planned);
    };
    how.ends = [&] {
        line.show(before.participant, std::min(1.0, 1.0 * trials++ / most));
        return asked_to_end() ? std::optional(study::SessionEnding::stopped) : std::nullopt;
    };
    study::conduct(store_, protocol_, session, how);
}

/// The one who answered before; else the one that was typed.
SimulatedObserver StudyTurns::observer_of_participant(const study::Progress &progress) const {
    const std::optional<study::Session> last = last_session(progress.participant);
    if (!last) {
        SimulatedObserver drawn = participant_of_group(
            observer_of(typed_.truth, protocol_), typed_.spread,
            static_cast<std::uint64_t>(typed_.seed.value_or(protocol_.seed)), progress.number);
        drawn.felt = typed_.felt;
        return drawn;
    }
    if (typed_.truth.is_typed() || typed_.seed) {
        std::cerr << fmt::format("springdrive: {} keeps the observer of the first session; what is "
                                 "typed is for new participants\n",
                                 progress.participant);
    }
    return observer_in(*last).value(); // see is_person
}

/// Of the last session; one that is no success ends the command.
void StudyTurns::tell(const std::string &code) const {
    const study::Session session = last_session(code).value();
    const study::SessionEnding ending = session.ending.value();
    int trials = 0;
    int marked = 0;
    for (const study::Trial &trial : store_.contents().trials) {
        if (trial.session == session.id) {
            ++trials;
            marked += trial.marks.empty() ? 0 : 1;
        }
    }
    std::cout << fmt::format("{}: session {}, {} trials, {} marked: {}\n", code, session.id, trials,
                             marked, study::name_of(ending))
              << std::flush;
    if (ending == study::SessionEnding::completed) {
        return;
    }
    std::cerr << fmt::format("springdrive: {0} is not through; to go on: springdrive study resume "
                             "{1} --participant {0}\n",
                             code, store_.file().string());
    if (ending != study::SessionEnding::stopped && ending != study::SessionEnding::left) {
        end_with_status(EXIT_FAILURE);
    }
}

} // namespace springdrive::app
