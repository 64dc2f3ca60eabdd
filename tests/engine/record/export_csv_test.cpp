// Covers engine/record/export_csv.cpp.
#include "engine/record/record_export.h"

#include "engine/record/record_format.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace springdrive::record {
namespace {

using testing::fresh_folder;

std::vector<std::string> cells_of(const std::string &line) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
        if (c == ',') {
            cells.emplace_back();
        } else {
            cells.back() += c;
        }
    }
    return cells;
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
    std::istringstream lines(out.str());
    std::string line;
    std::getline(lines, line);
    const auto names = cells_of(line);
    ASSERT_EQ(names.size(), reader.header().columns.size());
    for (const servo::ServoSample &sample : samples) {
        ASSERT_TRUE(std::getline(lines, line));
        const auto cells = cells_of(line);
        ASSERT_EQ(cells.size(), names.size());
        const std::string row = testing::row_of(sample);
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const RecordColumn &column = reader.header().columns[i];
            EXPECT_EQ(names[i], column.name);
            expect_cell(cells[i], column.type, row.data() + column.offset);
        }
    }
    EXPECT_FALSE(std::getline(lines, line));
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

TEST(ExportCsv, ReportsAFullOutput) {
    const auto file = fresh_folder("csv_full") / "a.rec";
    testing::write_record(file, 1000.0, testing::random_samples(300, 1000.0, 6));
    RecordReader reader(file);
    std::ofstream out("/dev/full");
    const std::string said = testing::error_text_of([&] { (void)export_csv(reader, {}, out); });
    EXPECT_NE(said.find("cannot be written"), std::string::npos) << said;
}

} // namespace
} // namespace springdrive::record
