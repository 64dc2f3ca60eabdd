#include "app/commands/commands.h"

#include "app/commands/common_options.h"
#include "app/commands/output_files.h"
#include "base/input_error.h"
#include "base/print.h"
#include "engine/record/record_reader.h"
#include "engine/record/replay.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <memory>
#include <optional>
#include <string>

namespace springdrive::app {

namespace {

struct TypedReplay {
    std::filesystem::path record;
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

void write_row(std::ostream &out, const servo::ServoSample &sample,
               const record::ReplayedTick &replayed) {
    print(out, "{},{:.17g}", sample.tick, sample.time_s);
    for (const Vector3 &e_W_V : {sample.command.e_W_V, replayed.command.e_W_V}) {
        print(out, ",{:.17g},{:.17g},{:.17g}", e_W_V[0], e_W_V[1], e_W_V[2]);
    }
    out << '\n';
}

void replay_all(record::RecordReader &record, record::Replay &replay, std::ostream *csv) {
    if (csv != nullptr) {
        *csv << "tick,time_s,recorded_e_W1_V,recorded_e_W2_V,recorded_e_W3_V,replayed_e_W1_V,"
                "replayed_e_W2_V,replayed_e_W3_V\n";
    }
    while (record.next()) {
        for (std::uint32_t row = 0; row < record.rows(); ++row) {
            const servo::ServoSample sample = record.read_sample(row);
            const std::optional<record::ReplayedTick> replayed = replay.take(sample);
            if (replayed && csv != nullptr) {
                write_row(*csv, sample, *replayed);
            }
        }
    }
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

void run(const TypedReplay &typed) {
    record::RecordReader record(typed.record);
    check_outputs({{typed.record, typed.tuning.file}, {}, {typed.csv}}, typed.existing);
    const record::RecordHeader &header = record.header();
    const bool asks = asks_for_a_tuning(typed.tuning);
    record::Replay replay(
        device::read_device_text(header.device_toml, typed.record.string() + ", device"),
        asks ? std::optional(typed.tuning.tuning()) : std::nullopt);
    if (typed.csv.empty()) {
        replay_all(record, replay, nullptr);
    } else {
        write_output(
            typed.csv, [&](std::ostream &out) { replay_all(record, replay, &out); },
            typed.existing);
    }
    report(typed.csv == "-" ? std::cerr : std::cout, record, replay);
    if (replay.replayed() == 0) {
        throw InputError(typed.record.string() + ": has no two consecutive ticks to replay");
    }
    if (!asks && !replay.is_identical()) {
        throw CLI::RuntimeError(1);
    }
}

} // namespace

void add_replay_command(CLI::App &app) {
    CLI::App &command = *app.add_subcommand(
        "replay",
        "recompute a record with the control law, to check that the voltages are the same");
    const auto typed = std::make_shared<TypedReplay>();
    command.add_option("file", typed->record, "a record")->type_name("FILE")->required();
    add_output_option(command, "--csv", typed->csv, "recorded and replayed e_W");
    add_force_option(command, typed->existing);
    typed->tuning.add_to(command);
    command.footer("Exits with 1 if any bit differs. With a tuning, shows instead what it would "
                   "have\ncommanded for the same motion.");
    command.callback([typed] { run(*typed); });
}

} // namespace springdrive::app
