// Records: made without a window, for other programs, and through the control law again.
#include "app/commands/command.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "app/host/process.h"
#include "app/stage/frame_loop.h"
#include "base/input_error.h"
#include "base/print.h"
#include "base/sha256.h"
#include "base/text.h"
#include "device/core/device_file.h"
#include "engine/record/record_export.h"
#include "engine/record/record_file.h"
#include "engine/record/replay.h"
#include "engine/session/run_folder.h"
#include "engine/session/session.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

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

namespace {

struct TypedExport {
    std::filesystem::path record;
    std::string csv;
    std::string npy;
    std::string mat;
    bool list = false;
    Existing existing = Existing::keep;
    record::ExportSelection selection;
};

/// Prints a record's header and columns.
void write_contents(std::ostream &out, record::RecordReader &record) {
    const record::RecordHeader &header = record.header();
    while (record.next()) {
    }
    const record::RecordEnding &ending = record.ending();
    print(out, "{}: {}, {:g} Hz, {}\n", record.path().string(), header.started_utc, header.servo_hz,
          ending.text());
    print(out, "device   {}, {}\n", header.device_name, header.device_file);
    print(out, "scene    {}, {} triangles, sha256 {}\n", header.scene_file, header.scene_triangles,
          header.scene_sha256);
    print(out, "software {}, row of {} bytes\n", header.software, header.row_bytes);
    for (const record::RecordColumn &column : header.columns) {
        print(out, "  {:<32} {}\n", column.name, column.unit);
    }
}

int formats(const TypedExport &typed) {
    return (typed.csv.empty() ? 0 : 1) + (typed.npy.empty() ? 0 : 1) + (typed.mat.empty() ? 0 : 1);
}

template <typename Export>
record::ExportSummary export_to(const std::string &where, record::RecordReader &record,
                                const TypedExport &typed, Export &&write) {
    record::ExportSummary summary;
    try {
        write_output(
            where, [&](std::ostream &out) { summary = write(record, typed.selection, out); },
            typed.existing);
    } catch (const InputError &error) {
        const std::string what = error.what();
        const std::string name = where == "-" ? "standard output" : where;
        throw InputError(what.find(name) == 0 ? what : name + ": " + what);
    }
    return summary;
}

void run(const TypedExport &typed) {
    record::RecordReader record(typed.record);
    if (typed.list) {
        write_contents(std::cout, record);
        return;
    }
    if (formats(typed) != 1) {
        throw InputError("export: give one of --csv, --npy or --mat, with the file to write; "
                         "--list shows the content of the record");
    }
    if (!(typed.selection.from_s <= typed.selection.to_s)) {
        throw InputError("--from must not be after --to; give the earlier time first");
    }
    if (typed.mat == "-") {
        throw InputError("--mat: writes to a file only; --csv and --npy can write to -");
    }
    check_outputs({{typed.record}, {}, {typed.csv, typed.npy, typed.mat}}, typed.existing);
    static_cast<void>(record::selected_columns(record.header(), typed.selection.columns));
    record::ExportSummary summary;
    if (!typed.csv.empty()) {
        summary = export_to(typed.csv, record, typed, record::export_csv);
    } else if (!typed.npy.empty()) {
        summary = export_to(typed.npy, record, typed, record::export_npy);
    } else {
        summary = record::export_mat(record, typed.selection, typed.mat, typed.existing);
    }
    print(std::cerr, "springdrive: {} rows of {} columns, from {}\n", summary.rows, summary.columns,
          summary.ending.text());
}

} // namespace

void add_export_command(Command &app) {
    Command command =
        app.add_subcommand("export", "a record as CSV, for Python (NPY) or MATLAB (MAT)");
    const auto typed = std::make_shared<TypedExport>();
    command.add_option("file", typed->record, "a record").type_name("FILE").required();
    command.add_option("--csv", typed->csv, "comma-separated text; - is standard output")
        .type_name("FILE|-");
    command.add_option("--npy", typed->npy, "one structured array: np.load(file)[\"tip_x_m\"]")
        .type_name("FILE|-");
    command.add_option("--mat", typed->mat, "a variable for each column, MATLAB and Octave")
        .type_name("FILE");
    add_force_option(command, typed->existing);
    command
        .add_option("--columns", typed->selection.columns,
                    "only these, in this order; tip_* stands for all with this prefix [all]")
        .type_name("NAME,...")
        .delimiter(',');
    command.add_option("--from", typed->selection.from_s, "start time [that of the record]")
        .type_name("S");
    command.add_option("--to", typed->selection.to_s, "end time [that of the record]")
        .type_name("S");
    command.add_flag("--list", typed->list, "show the content of the record, and export nothing");
    command.callback([typed] { run(*typed); });
}

namespace {

struct TypedReplay {
    std::filesystem::path file; ///< a record, or the folder of a run
    TuningOptions tuning;
    std::string csv;
    Existing existing = Existing::keep;
};

bool asks_for_a_tuning(const TuningOptions &typed) {
    bool asks = !typed.file.empty() || !typed.map.empty() || !typed.alpha_mode.empty();
    for (const std::optional<double> &value : typed.value) {
        asks = asks || value.has_value();
    }
    return asks;
}

/// The tuning that replaces the recorded ones, if one was typed.
std::optional<control::Tuning> replayed_tuning(const TypedReplay &typed) {
    return asks_for_a_tuning(typed.tuning) ? std::optional(typed.tuning.tuning()) : std::nullopt;
}

device::DeviceDescription recorded_device(const record::RecordReader &record) {
    return device::read_device_text(record.header().device_toml,
                                    record.path().string() + ", device");
}

void write_row(std::ostream &out, const servo::ServoSample &sample,
               const record::ReplayedTick &replayed) {
    print(out, "{},{:.17g}", sample.tick, sample.time_s);
    for (const Vector3 &e_W_V : {sample.command.e_W_V, replayed.command.e_W_V}) {
        print(out, ",{:.17g},{:.17g},{:.17g}", e_W_V[0], e_W_V[1], e_W_V[2]);
    }
    out << '\n';
}

void write_replay_csv(std::ostream &out, record::RecordReader &record, record::Replay &replay) {
    out << "tick,time_s,recorded_e_W1_V,recorded_e_W2_V,recorded_e_W3_V,replayed_e_W1_V,"
           "replayed_e_W2_V,replayed_e_W3_V\n";
    record.for_each([&](const servo::ServoSample &sample) {
        if (const std::optional<record::ReplayedTick> replayed = replay.take(sample)) {
            write_row(out, sample, *replayed);
        }
    });
}

void report(std::ostream &out, const record::RecordReader &record, const record::Replay &replay) {
    print(out, "{}: {}\n", record.path().string(), record.ending().text());
    print(out, "replayed {} ticks, {} more only to initialise the filter\n", replay.replayed(),
          replay.skipped());
    for (const record::ReplayedQuantity &quantity : replay.quantities()) {
        if (quantity.differing == 0) {
            print(out, "  {:<22} equal to the last bit\n", quantity.name);
        } else {
            print(out, "  {:<22} differs in {} ticks, first in {}, by at most {:.3g}\n",
                  quantity.name, quantity.differing, quantity.first_tick, quantity.maximum);
        }
    }
}

void replay_record(const TypedReplay &typed) {
    record::RecordReader record(typed.file);
    check_outputs({{typed.file, typed.tuning.file}, {}, {typed.csv}}, typed.existing);
    const std::optional<control::Tuning> tuning = replayed_tuning(typed);
    record::Replay replay(recorded_device(record), tuning);
    if (typed.csv.empty()) {
        record.for_each([&](const servo::ServoSample &sample) { replay.take(sample); });
    } else {
        write_output(
            typed.csv, [&](std::ostream &out) { write_replay_csv(out, record, replay); },
            typed.existing);
    }
    report(typed.csv == "-" ? std::cerr : std::cout, record, replay);
    if (replay.replayed() == 0) {
        throw InputError(typed.file.string() + ": has no two consecutive ticks to replay");
    }
    if (!tuning && !replay.is_identical()) {
        end_with_status(1);
    }
}

/// The replay of a kept session: all its records, against its device files.
class RunReplay {
public:
    RunReplay(std::filesystem::path folder, const std::optional<control::Tuning> &tuning)
        : folder_(std::move(folder)), run_(session::read_run(folder_)), tuning_(tuning) {
        note_scene(run_.scene.file, run_.scene.sha256);
    }

    /// Prints a report of each record, and of the scenes.
    void run(std::ostream &out) {
        for (const session::RunRecord &part : run_.records) {
            try {
                fine_ += replay_part(out, part) ? 1U : 0U;
            } catch (const InputError &error) { // it is as bad as a difference
                print(out, "{}\n", error.what());
            }
        }
        for (const session::RunScene &scene : scenes_) {
            print(out, "scene {}: {}\n", in_quotes(scene.file), state_of(scene));
        }
        print_gaps(out);
        print(out, "{}: {} ticks replayed; {} of {} records {}\n", folder_.string(), ticks_, fine_,
              run_.records.size(), tuning_ ? "belong to this run" : "are as they must be");
    }

    [[nodiscard]] bool is_fine() const { return fine_ == run_.records.size(); }
    [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

private:
    /// The session's times of a record's first and last tick.
    struct Covered {
        double from_s = std::numeric_limits<double>::infinity();
        double to_s = -std::numeric_limits<double>::infinity();

        void take(double time_s) {
            from_s = std::min(from_s, time_s);
            to_s = std::max(to_s, time_s);
        }
    };

    /// From the first tick that is recorded to the last one of the session.
    void print_gaps(std::ostream &out) {
        constexpr double kMin_s = 0.1; // an exchange of the device takes some ticks
        std::ranges::sort(covered_, {}, &Covered::from_s);
        covered_.push_back({run_.until_s, run_.until_s});
        double to_s = covered_.front().to_s;
        for (const Covered &part : covered_) {
            if (part.from_s > to_s + kMin_s) {
                print(out, "not recorded: {:.3f} to {:.3f} s\n", to_s, part.from_s);
            }
            to_s = std::max(to_s, part.to_s);
        }
    }

    bool replay_part(std::ostream &out, const session::RunRecord &part) {
        const std::filesystem::path file = folder_ / part.file; // which may be absolute
        std::error_code ignored;
        if (!std::filesystem::exists(file, ignored)) {
            throw InputError(file.string() + ": is missing");
        }
        record::RecordReader record(file);
        note_scene(record.header().scene_file, record.header().scene_sha256);
        record::Replay replay(recorded_device(record), tuning_);
        Covered covered;
        record.for_each([&](const servo::ServoSample &sample) {
            covered.take(part.start_s + sample.time_s);
            replay.take(sample);
        });
        covered_.push_back(covered);
        ticks_ += replay.replayed();
        report(out, record, replay);
        const bool same_device = record.header().device_toml == run_.devices[part.device].toml;
        print(out, "  {:<22} {} the device file of the run\n", "device",
              same_device ? "as in" : "differs from");
        return same_device && record.ending().why.empty() && (tuning_ || replay.is_identical());
    }

    /// A scene of the same contents is the same scene.
    void note_scene(const std::string &file, const std::string &sha256) {
        if (!file.empty() &&
            std::ranges::find(scenes_, sha256, &session::RunScene::sha256) == scenes_.end()) {
            scenes_.push_back({file, sha256, 0});
        }
    }

    /// A warning only: a replay takes the contact from the record.
    [[nodiscard]] std::string state_of(const session::RunScene &scene) const {
        std::error_code ignored;
        // The program was started in the folder above.
        const std::filesystem::path file =
            std::filesystem::canonical(folder_, ignored).parent_path() / scene.file;
        if (!std::filesystem::is_regular_file(file, ignored)) {
            return "not found, and not needed";
        }
        try {
            return sha256_of_file(file) == scene.sha256 ? "as it was"
                                                        : "has changed since, but is not needed";
        } catch (const InputError &) {
            return "cannot be read, and is not needed";
        }
    }

    std::filesystem::path folder_;
    session::RunFacts run_;
    std::optional<control::Tuning> tuning_;
    std::vector<session::RunScene> scenes_;
    std::vector<Covered> covered_; ///< by each record that could be read
    std::size_t fine_ = 0;
    std::uint64_t ticks_ = 0;
};

void replay_folder(const TypedReplay &typed) {
    if (!typed.csv.empty()) {
        throw InputError("--csv " + typed.csv + ": needs one record, but " + typed.file.string() +
                         " is a folder; name one of its records");
    }
    RunReplay replay(typed.file, replayed_tuning(typed));
    replay.run(std::cout);
    if (replay.ticks() == 0) {
        throw InputError(typed.file.string() + ": has no two consecutive ticks to replay");
    }
    if (!replay.is_fine()) {
        end_with_status(1);
    }
}

void run(const TypedReplay &typed) {
    std::error_code ignored;
    if (std::filesystem::is_directory(typed.file, ignored)) {
        replay_folder(typed);
    } else {
        replay_record(typed);
    }
}

} // namespace

void add_replay_command(Command &app) {
    Command command = app.add_subcommand(
        "replay",
        "recompute a record with the control law, to check that the voltages are the same");
    const auto typed = std::make_shared<TypedReplay>();
    command.add_option("file", typed->file, "a record, or the folder of a kept session")
        .type_name("FILE|FOLDER")
        .required();
    add_output_option(command, "--csv", typed->csv, "recorded and replayed e_W");
    add_force_option(command, typed->existing);
    typed->tuning.add_to(command);
    command.footer(
        "Exits with 1 if any bit differs. With a tuning, shows instead what it would "
        "have\ncommanded for the same motion. Of a folder, all records are replayed, and "
        "compared\nwith its device file.");
    command.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
