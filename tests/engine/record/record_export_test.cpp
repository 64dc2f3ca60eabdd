// Covers engine/record/record_export.cpp: which columns and rows.
#include "engine/record/record_export.h"

#include "tests/engine/record/record_bytes.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace springdrive::record {
namespace {

using testing::error_text_of;
using testing::fresh_folder;

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

} // namespace
} // namespace springdrive::record
