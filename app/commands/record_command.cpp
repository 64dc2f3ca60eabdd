#include "app/commands/commands.h"

#include "app/commands/output_files.h"
#include "app/commands/typed_session.h"
#include "app/host/ending_signal.h"
#include "app/stage/open_session.h"
#include "app/window/frame_pace.h"
#include "base/input_error.h"
#include "engine/session/session_report.h"

#include <iostream>
#include <memory>
#include <string>

namespace springdrive::app {

namespace {

constexpr double kMax_s = 24.0 * 3600.0;

struct TypedRecord {
    TypedSession session;
    double seconds = 10.0;
    std::string json;
    Existing existing = Existing::keep;
};

/// Until the time is over, termination is requested, or the record cannot continue.
void play(session::Session &session, bool lockstep, double seconds) {
    FramePace pace;
    for (int frame = 0; !asked_to_end() && session.recording().is_running(); ++frame) {
        const double elapsed_s = lockstep ? frame * kFrame_s : pace.elapsed_s();
        if (elapsed_s >= seconds - 1e-9) {
            return;
        }
        session.advance(kFrame_s);
        print_new_warnings(session);
        if (!lockstep) {
            pace.wait();
        }
    }
}

void run(const TypedRecord &typed) {
    check_range("--seconds", typed.seconds, 1e-3, kMax_s);
    session::SessionOptions options = typed.session.session();
    if (options.record == "-") {
        throw InputError("record: writes to a file only; springdrive export can write to -");
    }
    check_outputs(typed.session.files({typed.json}), typed.existing);
    options.plays_script = true;
    options.existing_record = typed.existing;
    session::Session session = open_session(options);
    note_ending_signals();
    session.start();
    print_new_warnings(session);
    play(session, options.lockstep, typed.seconds);
    session.stop();
    if (typed.json != "-") {
        session::write_session_report(std::cout, session);
    }
    if (!typed.json.empty()) {
        write_output(
            typed.json, [&](std::ostream &out) { session::write_session_json(out, session); },
            typed.existing);
    }
    const bool recorded = session::record_is_whole(session, std::cerr);
    if (session::was_stopped(session, std::cerr) || !recorded) {
        end_with_status(1);
    }
}

} // namespace

void add_record_command(Command &app) {
    Command record = app.add_subcommand(
        "record", "a session without a window, recording every servo tick to a file");
    const auto typed = std::make_shared<TypedRecord>();
    record.add_option("file", typed->session.options.record, "the record to write")
        .type_name("FILE")
        .required();
    record.add_option("--seconds", typed->seconds, "duration [10]").type_name("S");
    add_output_option(record, "--json", typed->json, "timing statistics of the servo");
    add_force_option(record, typed->existing);
    typed->session.add_to(record);
    record.footer(
        "The hand follows a scripted touch, or --path. See springdrive export and replay.");
    record.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
