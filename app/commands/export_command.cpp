#include "app/commands/commands.h"

#include "app/commands/output_files.h"
#include "base/input_error.h"
#include "base/print.h"
#include "engine/record/record_export.h"
#include "engine/record/record_reader.h"

#include <iostream>
#include <memory>
#include <string>

namespace springdrive::app {

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

} // namespace springdrive::app
