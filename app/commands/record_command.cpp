#include "app/commands/commands.h"

#include "app/commands/output_files.h"
#include "app/commands/typed_session.h"
#include "app/host/ending_signal.h"
#include "app/stage/frame_loop.h"
#include "app/stage/open_session.h"
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

/// Until termination is requested, or the record cannot continue.
class Recorded : public Activity {
public:
    explicit Recorded(const session::Session &session) : session_(session) {}
    [[nodiscard]] bool is_over() const override {
        return asked_to_end() || !session_.recording().is_running();
    }

private:
    const session::Session &session_;
};

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
    Recorded activity(session);
    run_frames(activity, session, {.seconds = typed.seconds, .is_paced = !options.lockstep});
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
