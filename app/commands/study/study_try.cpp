#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/study/observer_options.h"
#include "app/commands/study/study_turns.h"
#include "app/host/folders.h"
#include "app/host/process.h"
#include "app/stage/frame_loop.h"
#include "app/study/session/resumable.h"
#include "app/visitors/visits.h"
#include "base/input_error.h"
#include "engine/study/protocol/protocol.h"

#include <fmt/core.h>

#include <iostream>
#include <memory>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

struct TypedTry {
    fs::path protocol; ///< empty: the included one
    TypedStudySession study_session;
    std::string observer; ///< empty: a visitor
    TypedObserver made_up;
    bool is_window = false;
};

void try_typed(const TypedTry &typed) {
    const fs::path file = typed.protocol.empty()
                              ? asset_folder() / "protocols" / "can_you_feel_it.toml"
                              : typed.protocol;
    const study::ProtocolFolders folders{file.parent_path(), asset_folder()};
    visitors::VisitsPlan plan;
    plan.protocol = study::read_protocol_file(file);
    if (const std::string wrong = visitors::validate_for_visitors(plan.protocol); !wrong.empty()) {
        throw InputError(file.string() + ": " + wrong);
    }
    plan.folders = folders;
    plan.setting = study::study_setting(plan.protocol, folders);
    if (const std::string &problem = plan.setting.conditions.front().problem; !problem.empty()) {
        throw InputError(fmt::format("{}: condition \"{}\": {}", file.string(),
                                     plan.protocol.conditions.front().name, problem));
    }
    plan.made_up = observer_of(typed.made_up, plan.protocol);
    plan.is_show = !typed.observer.empty();
    note_ending_signals();
    session::Session session =
        open_session(session_options_of(plan.protocol, folders, typed.study_session));
    plan.has_device = !session.hand().is_simulated();
    if (plan.is_show && plan.has_device) {
        throw InputError("--observer simulated: nobody is there to hold the device on USB; leave "
                         "out one of the two");
    }
    study_screen::ParticipantWindow::Wish wish = typed.study_session.window.participant;
    wish.is_window = typed.is_window;
    if (wish.monitor.empty()) {
        wish.monitor = "1";
    }
    visitors::VisitorWindow window(wish, session);
    session.start();
    print_new_warnings(session);
    visitors::Visits visits(std::move(plan), session,
                            [&window](const scene::Scene &scene, const scene::TouchSpot &spot) {
                                window.show_scene(scene, spot);
                            });
    study_screen::StudySessionActivity activity(visits, window);
    end_well_without_display([&session] { session.stop(); });
    run_frames(activity, session, {.reports = typed.study_session.reports});
    end_well_without_display({});
    session.stop();
    std::cerr << fmt::format("springdrive: {} visit{} begun; nothing of them was stored\n",
                             visits.begun(), visits.begun() == 1 ? "" : "s");
}

} // namespace

void add_study_try_command(Command &study) {
    Command command = study.add_subcommand(
        "try", "\"Can you feel it?\": visitors' five minutes with their own curve at the end, of "
               "which nothing is stored");
    const auto typed = std::make_shared<TypedTry>();
    command
        .add_option("protocol", typed->protocol,
                    "a protocol of one condition that varies turn_deg [the included "
                    "can_you_feel_it]")
        .type_name("FILE");
    TypedStudySession &study_session = typed->study_session;
    study_session.add_device_to(command);
    command
        .add_option("--observer", typed->observer,
                    "made-up visitors only, one after the other, for whoever looks [visitors]")
        .type_name("WHO:{simulated}")
        .one_of({"simulated"}, InHelp::unlisted);
    add_observer_options(command, typed->made_up);
    Option screen =
        command.add_option("--screen", study_session.window.participant.monitor,
                           "the visitors' monitor, by number or a part of its name [the first]");
    screen.type_name("MONITOR");
    command.add_flag("--window", typed->is_window, "a window, not the whole screen")
        .excludes(screen);
    command
        .add_option("--width", study_session.window.participant.size.width, "of that window [1280]")
        .type_name("PIXELS");
    command
        .add_option("--height", study_session.window.participant.size.height,
                    "of that window [720]")
        .type_name("PIXELS");
    command.add_flag("--lockstep", study_session.is_in_lockstep,
                     "run the servo by frame time instead of the clock, which is repeatable; not "
                     "on USB");
    command.add_flag("--report", study_session.reports,
                     "for each line \"report\" on standard input, write what the window shows as a "
                     "line of JSON");
    command.footer("A visitor who is gone for 40 s is followed by the next one. Ctrl+Alt+Q ends "
                   "it;\nCtrl+Alt+Z tells that a device on USB is held in its zero pose.");
    command.callback([typed] { try_typed(*typed); });
}

} // namespace springdrive::app
