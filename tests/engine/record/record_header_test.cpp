// Covers engine/record/record_header.cpp and record_header_json.cpp.
#include "engine/record/record_header.h"

#include "engine/record/record_format.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>

namespace springdrive::record {
namespace {

using nlohmann::json;
using testing::error_text_of;

RecordHeader full_header() {
    RecordHeader header = record_header(4000.0);
    header.software = "1.2.3";
    header.delay_periods = 2.25;
    header.device_name = "PHANTOM \"1.0\"";
    header.device_file = "assets/devices/phantom_1_0.toml";
    header.device_toml = "name = \"Ω\"\n[motor]\n";
    header.tuning.dR_Ohm = 0.1;
    header.tuning.map = control::MotionMap::inverse;
    header.tuning.alpha_mode = control::AlphaMode::global;
    header.scene_file = "sphere.gltf";
    header.scene_sha256 = std::string(64, 'a');
    header.scene_triangles = 5'000'000'000U;
    header.global_alpha_rad2_per_m2 = 1.0 / 3.0;
    return header;
}

TEST(RecordHeader, RoundTripsThroughJson) {
    const RecordHeader wrote = full_header();
    const RecordHeader read = from_json(to_json(wrote));
    EXPECT_EQ(to_json(read), to_json(wrote));
    EXPECT_EQ(read.columns, wrote.columns);
    EXPECT_EQ(read.enum_names, wrote.enum_names);
    EXPECT_EQ(read.row_bytes, wrote.row_bytes);
    EXPECT_EQ(read.chunk_rows, 80U);
    EXPECT_EQ(read.period_s, 0.00025);
    EXPECT_EQ(read.delay_periods, 2.25);
    EXPECT_EQ(read.device_toml, wrote.device_toml);
    EXPECT_EQ(read.tuning.dR_Ohm, 0.1);
    EXPECT_EQ(read.tuning.map, control::MotionMap::inverse);
    EXPECT_EQ(read.tuning.alpha_mode, control::AlphaMode::global);
    EXPECT_EQ(read.scene_triangles, 5'000'000'000U);
    EXPECT_EQ(read.global_alpha_rad2_per_m2, 1.0 / 3.0);
}

TEST(RecordHeader, HasTheKeysThatTheFormatNames) {
    const json document = json::parse(to_json(full_header()));
    EXPECT_EQ(document["format"], "springdrive record 1");
    EXPECT_EQ(document["software"], "1.2.3");
    EXPECT_EQ(document["servo_hz"], 4000.0);
    EXPECT_EQ(document["delay_periods"], 2.25);
    EXPECT_FALSE(document.contains("delay_samples"));
    EXPECT_EQ(document["columns"][0],
              json::parse(R"({"name": "tick", "unit": "1", "type": "<u8", "offset": 0})"));
    EXPECT_EQ(document["columns"][1]["type"], "<f8");
    EXPECT_EQ(document["enums"]["map"], json::parse(R"(["inverse", "transpose"])"));
    EXPECT_EQ(document["device"]["name"], "PHANTOM \"1.0\"");
    EXPECT_EQ(document["tuning"]["dR_Ohm"], 0.1);
    EXPECT_EQ(document["tuning"]["alpha_mode"], "global");
    EXPECT_EQ(document["scene"]["triangles"], 5'000'000'000U);
}

TEST(RecordHeader, HasThePresentTimeAndChunksOfTwentyMilliseconds) {
    std::string date = record_header(1000.0).started_utc;
    std::replace_if(
        date.begin(), date.end(), [](unsigned char c) { return std::isdigit(c) != 0; }, '0');
    EXPECT_EQ(date, "0000-00-00T00:00:00Z");
    EXPECT_EQ(record_header(10'000.0).chunk_rows, 200U);
    EXPECT_EQ(record_header(250.0).chunk_rows, 5U);
    EXPECT_EQ(record_header(1.0).chunk_rows, 1U);
    const RecordHeader fast = record_header(1e6);
    EXPECT_LE(std::uint64_t{fast.chunk_rows} * fast.row_bytes, kMaxPayloadBytes);
}

TEST(RecordHeader, RejectsAnInvalidRate) {
    for (const double rate : {0.0, -1.0, 1.1e6, std::nan(""), HUGE_VAL}) {
        EXPECT_NE(error_text_of([rate] { (void)record_header(rate); }), "") << rate;
    }
}

TEST(RecordHeader, WritesNonFiniteNumbersAndInvalidUtf8AsJson) {
    RecordHeader header = full_header();
    header.global_alpha_rad2_per_m2 = std::numeric_limits<double>::infinity();
    header.scene_file = "caf\xE9.gltf";
    const RecordHeader read = from_json(to_json(header));
    EXPECT_TRUE(std::isnan(read.global_alpha_rad2_per_m2));
    EXPECT_EQ(read.scene_file, "caf\xEF\xBF\xBD.gltf");
}

TEST(RecordHeader, ReadsHeadersOfOtherVersions) {
    const RecordHeader read = from_json(R"({"format": "springdrive record 1", "servo_hz": 500,
        "period_s": 0.002, "row_bytes": 3, "chunk_rows": 10, "of_tomorrow": [1, {}],
        "columns": [{"name": "a", "unit": "m", "type": "<u2", "offset": 0, "more": 1},
                    {"name": "b", "type": "|u1"}], "tuning": {"eta": 0.5}})");
    ASSERT_EQ(read.columns.size(), 2U);
    EXPECT_EQ(read.columns[1], (RecordColumn{"b", "", ColumnType::u8, 2}));
    EXPECT_EQ(read.tuning.eta, 0.5);
    EXPECT_TRUE(std::isnan(read.tuning.dR_Ohm));
}

TEST(RecordHeader, ReadsADelayInSamplesToo) {
    const auto delay_of = [](const std::string &members) {
        json document = json::parse(to_json(full_header()));
        document.erase("delay_periods");
        document.update(json::parse(members));
        return from_json(document.dump()).delay_periods;
    };
    EXPECT_EQ(delay_of(R"({"delay_samples": 3})"), 3.0);
    EXPECT_EQ(delay_of(R"({"delay_periods": 3})"), 3.0);
    EXPECT_EQ(delay_of(R"({"delay_periods": 0.125})"), 0.125);
    EXPECT_EQ(delay_of("{}"), 0.0);
    EXPECT_EQ(delay_of(R"({"delay_periods": -1})"), 0.0);
    EXPECT_EQ(delay_of(R"({"delay_periods": "1"})"), 0.0);
    EXPECT_NE(error_text_of([&] {
                  (void)delay_of(R"({"delay_samples": 1, "delay_periods": 1})");
              }).find("both delay_periods and delay_samples"),
              std::string::npos);
}

TEST(RecordHeader, RejectsInvalidRows) {
    const std::vector<std::function<void(json &)>> changes{
        [](json &d) { d["format"] = "springdrive record 2"; },
        [](json &d) { d.erase("format"); },
        [](json &d) { d["period_s"] = 0.0; },
        [](json &d) { d["period_s"] = "1"; },
        [](json &d) { d["row_bytes"] = d["row_bytes"].get<int>() + 1; },
        [](json &d) { d["row_bytes"] = -1; },
        [](json &d) { d["chunk_rows"] = 0; },
        [](json &d) { d["chunk_rows"] = 4'000'000'000U; },
        [](json &d) { d["columns"] = json::object(); },
        [](json &d) { d["columns"] = json::array(); },
        [](json &d) { d["columns"][0] = 1; },
        [](json &d) { d["columns"][3]["type"] = ">f8"; },
        [](json &d) { d["columns"][3].erase("type"); },
        [](json &d) { d["columns"][3]["name"] = "a,b"; },
        [](json &d) { d["columns"][3]["name"] = "1a"; },
        [](json &d) { d["columns"][3]["name"] = ""; },
        [](json &d) { d["columns"][3]["name"] = std::string(64, 'a'); },
        [](json &d) { d["columns"][3]["name"] = "tick"; },
        [](json &d) { d["columns"][3]["offset"] = 17; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        json document = json::parse(to_json(full_header()));
        changes[i](document);
        EXPECT_NE(error_text_of([&] { (void)from_json(document.dump()); }), "") << i;
    }
    for (const char *text : {"", "{", "[]", "null", "1", "{\"format\": \"\xFF\"}"}) {
        EXPECT_NE(error_text_of([&] { (void)from_json(text); }), "") << text;
    }
}

TEST(RecordHeader, GivesTypesTheCodesOfNumpy) {
    for (const char *code : {"|u1", "<u2", "<u4", "<u8", "<i4", "<f8"}) {
        const auto type = column_type_with_code(code);
        ASSERT_TRUE(type) << code;
        EXPECT_EQ(code_of(*type), code);
        EXPECT_EQ(bytes_of(*type), static_cast<std::uint32_t>(code[2] - '0'));
    }
    EXPECT_FALSE(column_type_with_code("<f4"));
}

} // namespace
} // namespace springdrive::record
