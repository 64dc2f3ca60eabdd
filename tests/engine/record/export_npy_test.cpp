// Covers engine/record/export_npy.cpp, by an independent NPY parser, and by NumPy if python3 has
// it.
#include "engine/record/record_export.h"

#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace springdrive::record {
namespace {

using testing::fresh_folder;
using testing::number_at;

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
    const Npy npy = parse_npy(npy_of(file, {}));
    EXPECT_EQ(npy.version, 1);
    EXPECT_EQ(npy.rows, 57U);
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

// NumPy rejects a longer one by default.
TEST(ExportNpy, HasAHeaderBelowTenThousandCharacters) {
    const auto file = fresh_folder("npy_header") / "a.rec";
    testing::write_record(file, 1000.0, {});
    EXPECT_LT(npy_of(file, {}).size(), 10'000U);
}

TEST(ExportNpy, PacksASelection) {
    const auto file = fresh_folder("npy_selection") / "a.rec";
    auto samples = testing::random_samples(30, 250.0, 8);
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

TEST(ExportNpy, ReportsAFullOutput) {
    const auto file = fresh_folder("npy_full") / "a.rec";
    testing::write_record(file, 1000.0, testing::random_samples(300, 1000.0, 6));
    RecordReader reader(file);
    std::ofstream out("/dev/full", std::ios::binary);
    EXPECT_NE(testing::error_text_of([&] { (void)export_npy(reader, {}, out); }), "");
}

} // namespace
} // namespace springdrive::record
