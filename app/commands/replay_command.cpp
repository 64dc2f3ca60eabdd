#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "base/input_error.h"
#include "base/one_line.h"
#include "base/print.h"
#include "base/sha256.h"
#include "device/core/device_file.h"
#include "engine/record/record_reader.h"
#include "engine/record/replay.h"
#include "engine/session/run_folder.h"

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
