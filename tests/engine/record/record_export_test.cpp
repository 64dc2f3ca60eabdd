// Covers engine/record/record_export.cpp: which columns and rows, and each
// format by a parser of its own: NPY also by NumPy if python3 has it, MAT also by the library's
// reader.
#include "engine/record/record_export.h"

#include "engine/record/record_format.h"
#include "tests/engine/record/samples.h"
#include "tests/support/csv.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>
#include <matio.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

namespace springdrive::record {
namespace {

using testing::contents_of;
using testing::fresh_folder;
using testing::number_at;

std::string names_of(const std::vector<std::string> &selection) {
    std::string names;
    for (const RecordColumn &column : selected_columns(record_header(1000.0), selection)) {
        names += column.name + " ";
    }
    return names;
}

TEST(SelectedColumns, AreAllWithoutASelection) {
    EXPECT_EQ(selected_columns(record_header(1000.0), {}), sample_columns());
    EXPECT_EQ(selected_columns(record_header(1000.0), {"*"}), sample_columns());
}

TEST(SelectedColumns, FollowTheRequestedOrderWithoutDuplicates) {
    EXPECT_EQ(names_of({"tip_y_m", "tick", "tip_*", "tick"}), "tip_y_m tick tip_x_m tip_z_m ");
    EXPECT_EQ(names_of({"theta1*"}), "theta1_rad ");
    EXPECT_EQ(names_of({"eta"}), "eta ");
}

TEST(SelectedColumns, SuggestTheClosestNamesForAMissingColumn) {
    const auto said = [](const std::string &name) {
        return error_text_of([&] { (void)names_of({"tick", name}); });
    };
    EXPECT_EQ(said("tip_x").find("the record has no column tip_x; the closest are tip_x_m"), 0U)
        << said("tip_x");
    EXPECT_NE(said("curent2_A").find("closest are current2_A, "), std::string::npos);
    EXPECT_NE(said("nothing*").find("no column of the record matches nothing*"), std::string::npos);
    EXPECT_NE(said(""), "");
    EXPECT_NE(said(std::string(100'000, 'x')), "");
}

/// The ticks in an export from `from_s` to `to_s`.
std::string ticks_of(const std::filesystem::path &file, double from_s, double to_s) {
    RecordReader reader(file);
    std::ostringstream out;
    const ExportSummary summary = export_csv(reader, {{"tick"}, from_s, to_s}, out);
    std::string text = out.str();
    EXPECT_EQ(static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')),
              summary.rows + 1);
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text.substr(5); // after "tick"
}

TEST(SelectedRows, IncludeBothEndsOfTheRange) {
    const auto file = fresh_folder("selected_rows") / "a.rec";
    testing::write_record(file, 250.0, testing::random_samples(12, 250.0, 1));
    EXPECT_EQ(ticks_of(file, -HUGE_VAL, HUGE_VAL), "0 1 2 3 4 5 6 7 8 9 10 11 ");
    EXPECT_EQ(ticks_of(file, 0.012, 0.024), "3 4 5 6 ");
    EXPECT_EQ(ticks_of(file, 0.012 + 1e-8, 0.024 - 1e-8), "4 5 ");
    EXPECT_EQ(ticks_of(file, 0.040, HUGE_VAL), "10 11 ");
    EXPECT_EQ(ticks_of(file, -HUGE_VAL, 0.0), "0 ");
    EXPECT_EQ(ticks_of(file, 1.0, 2.0), "");
}

TEST(SelectedRows, RejectARangeThatEndsBeforeItBegins) {
    const auto file = fresh_folder("selected_rows_refused") / "a.rec";
    testing::write_record(file, 250.0, {});
    EXPECT_EQ(ticks_of(file, 1.0, 1.0), "");
    for (const double to_s : {0.999, std::nan("")}) {
        EXPECT_NE(error_text_of([&] { (void)ticks_of(file, 1.0, to_s); }), "");
    }
}

/// Two rows of one column, f64 or u64, in a file of another version.
std::filesystem::path tiny_record(const std::string &name, const char *column, const char *type) {
    const auto file = fresh_folder("tiny_" + name) / "a.rec";
    testing::write_file(
        file, testing::header_bytes(std::string(R"({"format": "springdrive record 1",
            "period_s": 0.5, "row_bytes": 8, "chunk_rows": 9, "columns": [{"name": ")") +
                                    column + R"(", "type": ")" + type + R"("}]})") +
                  testing::chunk_bytes(
                      0, 0, 2, testing::bytes_of_number(4, 8) + testing::bytes_of_number(5, 8)));
    return file;
}

TEST(SelectedRows, UseTheTickIfThereIsNoTime) {
    const auto file = tiny_record("tick", "tick", "<u8");
    EXPECT_EQ(ticks_of(file, 2.0, 2.4), "4 ");
    EXPECT_EQ(ticks_of(file, 2.1, 2.5), "5 ");
}

TEST(SelectedRows, ReportIfThereIsNoTimeAtAll) {
    RecordReader reader(tiny_record("no_time", "a", "<u8"));
    std::ostringstream out;
    EXPECT_EQ(export_csv(reader, {}, out).rows, 2U);
    const std::string said = error_text_of([&] {
        (void)export_csv(reader, {{}, 0.0, HUGE_VAL}, out);
    });
    EXPECT_NE(said.find("neither time_s nor tick"), std::string::npos) << said;
}

/// Expects a cell to read back as the same number, by the C library.
void expect_cell(const std::string &cell, ColumnType type, const char *from) {
    const auto *const bytes = reinterpret_cast<const std::byte *>(from);
    if (type == ColumnType::f64) {
        const auto expected = load<double>(bytes);
        if (std::isnan(expected)) {
            EXPECT_EQ(cell, "");
        } else {
            EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(cell.c_str(), nullptr)),
                      std::bit_cast<std::uint64_t>(expected))
                << cell;
        }
    } else if (type == ColumnType::i32) {
        EXPECT_EQ(cell, std::to_string(load<std::int32_t>(bytes)));
    } else {
        std::uint64_t expected = 0;
        std::memcpy(&expected, from, bytes_of(type));
        EXPECT_EQ(cell, std::to_string(expected));
    }
}

TEST(ExportCsv, PreservesEveryNumber) {
    const auto file = fresh_folder("csv") / "a.rec";
    const auto samples = testing::random_samples(57, 1000.0, 5);
    testing::write_record(file, 1000.0, samples);
    RecordReader reader(file);
    std::ostringstream out;
    const ExportSummary summary = export_csv(reader, {}, out);
    EXPECT_EQ(summary.rows, samples.size());
    EXPECT_EQ(summary.columns, reader.header().columns.size());
    EXPECT_EQ(summary.ending.text(), "57 rows");
    const auto lines = testing::parsed_csv(out.str());
    ASSERT_EQ(lines.size(), samples.size() + 1);
    ASSERT_EQ(lines[0].size(), reader.header().columns.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
        const std::vector<std::string> &cells = lines[k + 1];
        ASSERT_EQ(cells.size(), lines[0].size());
        const std::string row = testing::row_of(samples[k]);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const RecordColumn &column = reader.header().columns[i];
            EXPECT_EQ(lines[0][i], column.name);
            expect_cell(cells[i], column.type, row.data() + column.offset);
        }
    }
}

TEST(ExportCsv, UsesTheFewestDigits) {
    const auto file = fresh_folder("csv_digits") / "a.rec";
    servo::ServoSample sample;
    sample.tick = 18'446'744'073'709'551'615U;
    sample.time_s = 0.1;
    sample.counts = {-7, 0, 0};
    sample.tip_m = {1e-5, std::nan(""), -HUGE_VAL};
    sample.contact.touching = true;
    testing::write_record(file, 1000.0, {sample});
    RecordReader reader(file);
    std::ostringstream out;
    (void)export_csv(reader, {{"tick", "time_s", "counts1", "tip_*", "touching"}}, out);
    EXPECT_EQ(out.str(), "tick,time_s,counts1,tip_x_m,tip_y_m,tip_z_m,touching\n"
                         "18446744073709551615,0.1,-7,1e-05,,-inf,1\n");
}

struct Npy {
    int version = 0;
    std::vector<std::pair<std::string, std::string>> fields; ///< name, type
    std::uint64_t rows = 0;
    std::string data;
};

/// By NumPy's description of the format.
Npy parse_npy(const std::string &bytes) {
    Npy npy;
    EXPECT_EQ(bytes.substr(0, 6), "\x93NUMPY");
    npy.version = static_cast<unsigned char>(bytes.at(6));
    EXPECT_EQ(bytes.at(7), 0);
    const std::size_t length_bytes = npy.version == 1 ? 2 : 4;
    const std::size_t begin = 8 + length_bytes;
    const std::string header = bytes.substr(begin, number_at(bytes, 8, length_bytes));
    EXPECT_EQ((begin + header.size()) % 64, 0U);
    EXPECT_EQ(header.back(), '\n');
    // ('name', 'type'), of letters, digits and _ only
    std::size_t at = header.find('[');
    while ((at = header.find("('", at)) < header.find(']')) {
        const std::size_t name_end = header.find("', '", at);
        const std::size_t type_end = header.find("')", name_end);
        npy.fields.emplace_back(header.substr(at + 2, name_end - at - 2),
                                header.substr(name_end + 4, type_end - name_end - 4));
        at = type_end;
    }
    const std::string shape = "'shape': (";
    EXPECT_NE(header.find(shape), std::string::npos);
    EXPECT_NE(header.find("'fortran_order': False"), std::string::npos);
    npy.rows = std::stoull(header.substr(header.find(shape) + shape.size()));
    npy.data = bytes.substr(begin + header.size());
    return npy;
}

std::string npy_of(const std::filesystem::path &file, const ExportSelection &selection) {
    RecordReader reader(file);
    std::ostringstream out;
    const ExportSummary summary = export_npy(reader, selection, out);
    EXPECT_EQ(summary.rows, parse_npy(out.str()).rows);
    return out.str();
}

TEST(ExportNpy, PreservesEveryBitOfAllColumns) {
    const auto file = fresh_folder("npy") / "a.rec";
    const auto samples = testing::random_samples(57, 1000.0, 7);
    testing::write_record(file, 1000.0, samples);
    const std::string bytes = npy_of(file, {});
    const Npy npy = parse_npy(bytes);
    EXPECT_EQ(npy.version, 1);
    EXPECT_EQ(npy.rows, 57U);
    EXPECT_LT(bytes.size() - npy.data.size(), 10'000U); // NumPy rejects a longer header by default
    const auto columns = sample_columns();
    ASSERT_EQ(npy.fields.size(), columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
        EXPECT_EQ(npy.fields[i].first, columns[i].name);
        EXPECT_EQ(npy.fields[i].second, code_of(columns[i].type));
    }
    std::string expected;
    for (const servo::ServoSample &sample : samples) {
        expected += testing::row_of(sample);
    }
    EXPECT_EQ(npy.data, expected);
}

TEST(ExportNpy, PacksASelection) {
    const auto file = fresh_folder("npy_selection") / "a.rec";
    const auto samples = testing::random_samples(30, 250.0, 8);
    testing::write_record(file, 250.0, samples);
    const Npy npy = parse_npy(npy_of(file, {{"touching", "counts2", "tick"}, 0.02, 0.1}));
    EXPECT_EQ(npy.rows, 21U);
    ASSERT_EQ(npy.data.size(), 21U * 13);
    for (std::size_t i = 0; i < 21; ++i) {
        const servo::ServoSample &sample = samples[i + 5];
        EXPECT_EQ(number_at(npy.data, 13 * i, 1), sample.contact.touching ? 1U : 0U);
        EXPECT_EQ(number_at(npy.data, 13 * i + 1, 4), static_cast<std::uint32_t>(sample.counts[1]));
        EXPECT_EQ(number_at(npy.data, 13 * i + 5, 8), sample.tick);
    }
}

/// A record of `count` columns of a byte, without rows.
std::filesystem::path wide_record(std::size_t count) {
    const auto file = fresh_folder("npy_wide") / "a.rec";
    std::string columns;
    for (std::size_t i = 0; i < count; ++i) {
        columns += (i == 0 ? "" : ",") + std::string(R"({"name": "column_)") + std::to_string(i) +
                   R"(", "type": "|u1"})";
    }
    testing::write_file(file, testing::header_bytes(
                                  R"({"format": "springdrive record 1", "period_s": 1,
            "row_bytes": )" + std::to_string(count) +
                                  R"(, "chunk_rows": 1, "columns": [)" + columns + "]}"));
    return file;
}

TEST(ExportNpy, UsesVersionTwoForALongHeader) {
    for (const std::size_t count : {2000U, 2800U}) {
        const Npy npy = parse_npy(npy_of(wide_record(count), {}));
        EXPECT_EQ(npy.version, count == 2000 ? 1 : 2);
        EXPECT_EQ(npy.fields.size(), count);
        EXPECT_EQ(npy.rows, 0U);
        EXPECT_EQ(npy.data, "");
    }
}

bool succeeds(const std::string &command) {
    return std::system((command + " 2>&1").c_str()) == 0; // NOLINT(concurrency-mt-unsafe,cert-*)
}

/// Empty if there is none.
std::string python_with_numpy() {
    for (const std::string python : {"python3", "/usr/bin/python3"}) {
        if (succeeds(python + " -c 'import numpy' >/dev/null")) {
            return python;
        }
    }
    return "";
}

TEST(ExportNpy, IsReadByNumpy) {
    const std::string python = python_with_numpy();
    if (python.empty()) {
        GTEST_SKIP() << "python3 has no numpy";
    }
    const auto folder = fresh_folder("npy_numpy");
    testing::write_record(folder / "a.rec", 1000.0, testing::random_samples(57, 1000.0, 9));
    testing::write_file(folder / "a.npy", npy_of(folder / "a.rec", {}));
    testing::write_file(folder / "wide.npy", npy_of(wide_record(2800), {}));
    testing::write_file(folder / "check.py", R"(
import csv, math, sys
import numpy as np
a = np.load(sys.argv[1] + "/a.npy")
rows = list(csv.DictReader(open(sys.argv[1] + "/a.csv")))
assert a.shape == (57,) and a.shape[0] == len(rows)
assert list(a.dtype.names) == list(rows[0])
for got, row in zip(a, rows):
    for name, cell in row.items():
        value = got[name].item()
        assert math.isnan(value) if cell == "" else value == type(value)(cell), (name, cell, value)
wide = np.load(sys.argv[1] + "/wide.npy", max_header_size=100000)
assert wide.shape == (0,) and len(wide.dtype.names) == 2800
)");
    RecordReader reader(folder / "a.rec");
    std::ofstream csv(folder / "a.csv");
    (void)export_csv(reader, {}, csv);
    csv.close();
    EXPECT_TRUE(
        succeeds(python + " '" + (folder / "check.py").string() + "' '" + folder.string() + "'"));
}

struct MatVariable {
    matio_classes of_array = MAT_C_EMPTY;
    std::size_t rows = 0;
    std::size_t columns = 0;
    std::string data;
};

std::map<std::string, MatVariable> read_mat(const std::filesystem::path &file) {
    std::map<std::string, MatVariable> variables;
    mat_t *const mat = Mat_Open(file.c_str(), MAT_ACC_RDONLY);
    EXPECT_NE(mat, nullptr);
    while (matvar_t *const v = mat == nullptr ? nullptr : Mat_VarReadNext(mat)) {
        EXPECT_EQ(v->rank, 2);
        const std::size_t bytes = v->dims[0] * v->dims[1] * Mat_SizeOfClass(v->class_type);
        variables[v->name] = {v->class_type, v->dims[0], v->dims[1],
                              std::string(static_cast<const char *>(v->data), bytes)};
        Mat_VarFree(v);
    }
    Mat_Close(mat);
    return variables;
}

TEST(ExportMat, PreservesEveryBitOfAllColumns) {
    const auto folder = fresh_folder("mat");
    const std::map<ColumnType, matio_classes> classes{
        {ColumnType::u8, MAT_C_UINT8},   {ColumnType::u16, MAT_C_UINT16},
        {ColumnType::u32, MAT_C_UINT32}, {ColumnType::u64, MAT_C_UINT64},
        {ColumnType::i32, MAT_C_INT32},  {ColumnType::f64, MAT_C_DOUBLE}};
    // 1 to 4 rows of a byte are stored differently from 5.
    for (const std::size_t rows : {1U, 2U, 4U, 5U, 57U}) {
        const auto samples = testing::random_samples(rows, 1000.0, rows);
        const auto file = folder / (std::to_string(rows) + ".rec");
        testing::write_record(file, 1000.0, samples);
        RecordReader reader(file);
        EXPECT_EQ(export_mat(reader, {}, folder / "a.mat", Existing::replace).rows, rows);
        EXPECT_NE(error_text_of([&] { (void)export_mat(reader, {}, folder / "a.mat"); }), "");
        const auto variables = read_mat(folder / "a.mat");
        EXPECT_EQ(variables.size(), reader.header().columns.size());
        for (const RecordColumn &column : reader.header().columns) {
            const MatVariable &variable = variables.at(column.name);
            std::string expected;
            for (const servo::ServoSample &sample : samples) {
                expected += testing::row_of(sample).substr(column.offset, bytes_of(column.type));
            }
            EXPECT_EQ(variable.of_array, classes.at(column.type)) << column.name;
            EXPECT_EQ(variable.rows, rows) << column.name;
            EXPECT_EQ(variable.columns, 1U) << column.name;
            EXPECT_EQ(variable.data, expected) << column.name;
        }
    }
}

// MATLAB's "Level 5 MAT-File Format": a variable of two ticks, element by element.
TEST(ExportMat, FollowsTheFormatDescription) {
    const auto folder = fresh_folder("mat_by_hand");
    auto samples = testing::random_samples(2, 1000.0, 1);
    samples[0].tick = 0x0102030405060708U;
    samples[1].tick = 9;
    testing::write_record(folder / "a.rec", 1000.0, samples);
    RecordReader reader(folder / "a.rec");
    (void)export_mat(reader, {{"tick"}}, folder / "a.mat");
    const std::string bytes = contents_of(folder / "a.mat");
    const auto number = [&](std::size_t at) { return testing::number_at(bytes, at, 4); };
    EXPECT_EQ(bytes.substr(0, 10), "MATLAB 5.0");
    EXPECT_EQ(bytes.substr(124, 4), std::string("\0\1IM", 4));
    EXPECT_EQ(number(128), 14U); // miMATRIX
    EXPECT_EQ(number(132), bytes.size() - 136);
    EXPECT_EQ(number(136), 6U); // flags, miUINT32
    EXPECT_EQ(number(140), 8U);
    EXPECT_EQ(number(144) & 0xFFU, 15U); // mxUINT64_CLASS
    EXPECT_EQ(number(152), 5U);          // dimensions, miINT32
    EXPECT_EQ(number(156), 8U);
    EXPECT_EQ(number(160), 2U);
    EXPECT_EQ(number(164), 1U);
    EXPECT_EQ(number(168), 0x00040001U); // name, miINT8, 4 bytes, in its tag
    EXPECT_EQ(bytes.substr(172, 4), "tick");
    EXPECT_EQ(number(176), 13U); // miUINT64
    EXPECT_EQ(number(180), 16U);
    EXPECT_EQ(testing::number_at(bytes, 184, 8), 0x0102030405060708U);
    EXPECT_EQ(testing::number_at(bytes, 192, 8), 9U);
    EXPECT_EQ(bytes.size(), 200U);
}

TEST(ExportMat, ExportsATimeRangeEvenAnEmptyOne) {
    const auto folder = fresh_folder("mat_range");
    testing::write_record(folder / "a.rec", 250.0, testing::random_samples(30, 250.0, 2));
    RecordReader reader(folder / "a.rec");
    EXPECT_EQ(export_mat(reader, {{"time_s"}, 0.02, 0.1}, folder / "a.mat").rows, 21U);
    EXPECT_EQ(read_mat(folder / "a.mat").at("time_s").rows, 21U);
    EXPECT_EQ(export_mat(reader, {{"time_s", "map"}, 7.0, 8.0}, folder / "b.mat").rows, 0U);
    const auto empty = read_mat(folder / "b.mat");
    EXPECT_EQ(empty.size(), 2U);
    EXPECT_EQ(empty.at("time_s").rows, 0U);
}

TEST(RecordExport, SaysSoIfItsOutputCannotBeWrittenAndLeavesNoFile) {
    const auto folder = fresh_folder("export_full");
    testing::write_record(folder / "a.rec", 1000.0, testing::random_samples(300, 1000.0, 6));
    RecordReader reader(folder / "a.rec");
    std::ofstream full("/dev/full", std::ios::binary);
    EXPECT_NE(error_text_of([&] { (void)export_csv(reader, {}, full); }).find("cannot be written"),
              std::string::npos);
    full.clear();
    EXPECT_NE(error_text_of([&] { (void)export_npy(reader, {}, full); }).find("cannot be written"),
              std::string::npos);
    const testing::FullDisk disk(256 * 1024);
    for (const auto &file : {folder / "none" / "a.mat", folder / "a.mat"}) {
        const std::string said = error_text_of([&] { (void)export_mat(reader, {}, file); });
        EXPECT_EQ(said.find(file.string() + ": cannot be written"), 0U) << said;
        EXPECT_FALSE(std::filesystem::exists(file));
    }
}

} // namespace
} // namespace springdrive::record
