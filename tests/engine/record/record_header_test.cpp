// Covers engine/record/record_format.cpp.
#include "engine/record/record_format.h"

#include "engine/record/telemetry_columns.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <type_traits>

namespace springdrive::record {
namespace {

using testing::random_sample;
using testing::row_of;

using nlohmann::json;

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
    EXPECT_EQ(read.device_toml, wrote.device_toml);
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

std::span<const std::byte> bytes_of_text(const std::string &text) {
    return {reinterpret_cast<const std::byte *>(text.data()), text.size()};
}

TEST(RowCodec, WritesNumbersAtTheColumnsOffsets) {
    servo::ServoSample sample;
    sample.tick = 0x1122334455667788U;
    sample.counts = {0, 0, -5};
    sample.contact.material = 0xABCD;
    sample.contact.sticking = true;
    sample.safety.state = servo::SafetyState::tripped;
    sample.tip_force_N = {0.0, -2.5, 0.0};
    const std::string row = row_of(sample);
    const RecordHeader header = record_header(1000.0);
    const auto at = [&](const char *name) {
        return reinterpret_cast<const std::byte *>(row.data()) + header.column(name)->offset;
    };
    EXPECT_EQ(load<std::uint64_t>(at("tick")), 0x1122334455667788U);
    EXPECT_EQ(load<std::int32_t>(at("counts3")), -5);
    EXPECT_EQ(load<std::uint16_t>(at("material")), 0xABCD);
    EXPECT_EQ(load<std::uint8_t>(at("sticking")), 1);
    EXPECT_EQ(load<std::uint8_t>(at("safety_state")), 3);
    EXPECT_EQ(load<double>(at("force_y_N")), -2.5);
}

TEST(RowCodec, FindsColumnsInAnotherOrderAmongOthers) {
    RecordHeader header = record_header(1000.0);
    std::mt19937_64 random(2);
    std::shuffle(header.columns.begin(), header.columns.end(), random);
    header.columns.insert(header.columns.begin() + 7, {"of_tomorrow", "1", ColumnType::u16, 0});
    const servo::ServoSample sample = random_sample(random, 99);
    const std::string row = row_of(sample);
    const RecordHeader plain = record_header(1000.0);
    std::string other;
    for (RecordColumn &column : header.columns) {
        column.offset = static_cast<std::uint32_t>(other.size());
        const RecordColumn *const from = plain.column(column.name);
        other += from == nullptr ? "??" : row.substr(from->offset, bytes_of(from->type));
    }
    EXPECT_EQ(row_of(RowDecoder(header).decode(bytes_of_text(other))), row);
}

TEST(RowCodec, NamesAColumnThatIsMissingOrOfAnotherType) {
    RecordHeader header = record_header(1000.0);
    header.columns.erase(header.columns.begin() + 20);
    const std::string missing = sample_columns()[20].name;
    std::string said = error_text_of([&] { RowDecoder{header}; });
    EXPECT_NE(said.find("no column " + missing + ","), std::string::npos) << said;
    header = record_header(1000.0);
    header.columns[0].type = ColumnType::f64;
    said = error_text_of([&] { RowDecoder{header}; });
    EXPECT_NE(said.find("tick is of type <f8, not <u8"), std::string::npos) << said;
}

/// A row as it was before that column: the same bytes without it.
TEST(RowCodec, ReadsOlderRecordsThatHoldNoRequestedStop) {
    RecordHeader header = record_header(1000.0);
    std::mt19937_64 random(3);
    servo::ServoSample sample = random_sample(random, 99);
    std::string row = row_of(sample);
    const auto column =
        std::ranges::find(header.columns, std::string("held_stop"), &RecordColumn::name);
    ASSERT_NE(column, header.columns.end());
    row.erase(column->offset, 4);
    for (auto later = column + 1; later != header.columns.end(); ++later) {
        later->offset -= 4;
    }
    header.columns.erase(column);
    sample.safety.held_stop = 0;
    EXPECT_EQ(row_of(RowDecoder(header).decode(bytes_of_text(row))), row_of(sample));
}

TEST(RowCodec, RejectsAnUnknownEnumValue) {
    const RecordHeader header = record_header(1000.0);
    const RowDecoder decoder(header);
    for (const auto &[column, names] : header.enum_names) {
        ASSERT_NE(header.column(column), nullptr) << column;
        std::string row = row_of({});
        char &number = row[header.column(column)->offset];
        number = static_cast<char>(names.size() - 1);
        EXPECT_NO_THROW((void)decoder.decode(bytes_of_text(row))) << column;
        number = static_cast<char>(names.size());
        const std::string said = error_text_of([&] { (void)decoder.decode(bytes_of_text(row)); });
        EXPECT_NE(said.find("column " + column + " holds"), std::string::npos) << said;
    }
    EXPECT_EQ(header.enum_names.size(), 8U);
}

TEST(RowCodec, NamesEnumsAsTuningFilesDo) {
    const auto names = sample_enum_names();
    const std::vector<std::string> maps = names.at("map");
    const std::vector<std::string> modes = names.at("alpha_mode");
    EXPECT_TRUE(std::ranges::equal(maps, control::kMotionMapNames));
    EXPECT_TRUE(std::ranges::equal(modes, control::kAlphaModeNames));
    EXPECT_EQ(names.at("trip_cause").at(static_cast<std::size_t>(servo::TripCause::voltage)),
              "voltage");
    EXPECT_EQ(names.at("safety_state").at(static_cast<std::size_t>(servo::SafetyState::tripped)),
              "tripped");
    EXPECT_EQ(names.at("health").at(static_cast<std::size_t>(device::DeviceHealth::lost)), "lost");
}

/// Addresses and sizes of the sample's members that are in the list.
std::map<const char *, std::size_t> places(const servo::ServoSample &sample) {
    std::map<const char *, std::size_t> found;
    for_each_column(sample, [&](std::string_view name, std::string_view, const auto &value) {
        const auto *const address = reinterpret_cast<const char *>(&value);
        EXPECT_TRUE(found.emplace(address, sizeof value).second) << name << " is listed twice";
    });
    return found;
}

TEST(TelemetryColumns, CoverEveryByteOfASampleExceptPaddingAndDocumentedExceptions) {
    // The command's number equals the measurement's; its reset and that it voids the zero concern
    // the device alone, a housing's temperature the next start. A failed assertion is a note.
    const servo::ServoSample sample;
    auto found = places(sample);
    const auto *const begin = reinterpret_cast<const char *>(&sample);
    found.emplace(reinterpret_cast<const char *>(&sample.command.number), sizeof(std::uint64_t));
    found.emplace(reinterpret_cast<const char *>(&sample.command.resets_faults), sizeof(bool));
    found.emplace(reinterpret_cast<const char *>(&sample.command.voids_zero), sizeof(bool));
    for (const servo::WindingStatus &winding : sample.winding) {
        found.emplace(reinterpret_cast<const char *>(&winding.max_housing_C), sizeof(double));
    }
    found.emplace(reinterpret_cast<const char *>(&sample.safety.failure), sizeof(AssertionFailure));
    found.emplace(begin + sizeof sample, 0);
    const char *at = begin;
    for (const auto &[address, bytes] : found) {
        EXPECT_GE(address, at) << "overlap";
        EXPECT_LT(address - at, 8) << "bytes " << at - begin << " to " << address - begin;
        at = address + bytes;
    }
}

// A small member could be hidden in padding. These bindings do not compile if one is added or
// removed: update the list first, then these.
TEST(TelemetryColumns, KnowEveryMember) {
    const servo::ServoSample sample;
    [[maybe_unused]] const auto &[tick, time, number, measured_at, arrival, health, faults, supply,
                                  since_last, counts, theta, rate, tip, contact, scene, tuning, eta,
                                  global_alpha, alpha, bound, x_Sd, theta_Sd, inverse_possible,
                                  carried, motor, lag, driven_dR, share, command, current, force,
                                  rendered, inverse, transpose, safety, active_limits, limits,
                                  energy, winding, missed, in_a_row, missed_periods, clock,
                                  lateness, period, read, compute, write] = sample;
    [[maybe_unused]] const auto &[touching, x0, motion, normal, surface_eta, constraints, sticking,
                                  settled, surface, barycentric, triangle, material] = contact;
    [[maybe_unused]] const auto &[dR, K_P, K_D, lambda, by_hand, softness, map, mode] = tuning;
    [[maybe_unused]] const auto &[state, cause, measured, limit, ramp, failure, held_stop] = safety;
    [[maybe_unused]] const auto &[held_force, held_voltage, at_edge] = active_limits;
    [[maybe_unused]] const auto &[e_W, R_hat, command_mode, command_number, resets_faults,
                                  voids_zero] = command;
    [[maybe_unused]] const auto &[minimum, maximum, R_hat_limit, is_limited, is_contradicted,
                                  generates, housing] = winding[0];
    [[maybe_unused]] const auto &[here, mean, k_T, offset, is_observed, is_trusted, brush,
                                  brush_deviation, held_R_hat, trim, load] = motor[0];
    [[maybe_unused]] const auto &[R, deviation] = here;
    EXPECT_EQ(sizeof limits, servo::kSafetyLimits.size() * sizeof(double));
}

/// The required ending of a name.
std::string ending_for(std::string_view unit) {
    const std::map<std::string_view, std::string> spelled{{"1", ""},
                                                          {"SI", ""},
                                                          {"s", "_s"},
                                                          {"rad", "_rad"},
                                                          {"rad/s", "_rad_per_s"},
                                                          {"m", "_m"},
                                                          {"m/s", "_m_per_s"},
                                                          {"V", "_V"},
                                                          {"A", "_A"},
                                                          {"N", "_N"},
                                                          {"J", "_J"},
                                                          {"Ω", "_Ohm"},
                                                          {"°C", "_C"},
                                                          {"N·m/A", "_Nm_per_A"},
                                                          {"V/rad", "_V_per_rad"},
                                                          {"V·s/rad", "_Vs_per_rad"},
                                                          {"rad²/m²", "_rad2_per_m2"}};
    const auto found = spelled.find(unit);
    return found == spelled.end() ? "unknown unit " + std::string(unit) : found->second;
}

TEST(TelemetryColumns, HaveValidNamesAndUnits) {
    std::set<std::string_view> names;
    const servo::ServoSample sample;
    for_each_column(sample, [&](std::string_view name, std::string_view unit, const auto &) {
        EXPECT_TRUE(names.insert(name).second) << name << " twice";
        EXPECT_TRUE(name.ends_with(ending_for(unit))) << name << " [" << unit << "]";
        EXPECT_LE(name.size(), 63U) << name;
        EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                         "0123456789_"),
                  std::string_view::npos)
            << name;
    });
    EXPECT_EQ(names.count("limit_beyond_stops_rad"), 1U);
}

double value_of(const servo::ServoSample &sample, std::string_view requested) {
    double found = -1e9;
    for_each_column(sample, [&](std::string_view name, std::string_view, const auto &value) {
        if (name == requested) {
            found = static_cast<double>(value);
        }
    });
    return found;
}

/// Above all those that could be swapped unnoticed: adjacent, of the same type and unit.
TEST(TelemetryColumns, MapToTheMemberOfTheirName) {
    servo::ServoSample sample;
    const std::map<std::string, double *> members{
        {"time_s", &sample.time_s},
        {"measured_s", &sample.measured_s},
        {"since_last_s", &sample.since_last_s},
        {"clock_s", &sample.clock_s},
        {"lateness_s", &sample.lateness_s},
        {"period_s", &sample.period_s},
        {"read_s", &sample.read_s},
        {"compute_s", &sample.compute_s},
        {"write_s", &sample.write_s},
        {"rendered_error_rad", &sample.rendered_error_rad},
        {"inverse_error_rad", &sample.inverse_error_rad},
        {"transpose_error_rad", &sample.transpose_error_rad},
        {"global_alpha_rad2_per_m2", &sample.global_alpha_rad2_per_m2},
        {"alpha_in_force_rad2_per_m2", &sample.alpha_rad2_per_m2},
        {"alpha_bound_rad2_per_m2", &sample.alpha_bound_rad2_per_m2},
        {"trip_measured", &sample.safety.measured},
        {"trip_limit", &sample.safety.limit},
        {"winding_least2_C", &sample.winding[1].min_C},
        {"winding_greatest2_C", &sample.winding[1].max_C},
        {"theta2_rad", &sample.theta_rad[1]},
        {"tip_y_m", &sample.tip_m[1]},
        {"proxy_z_m", &sample.contact.x0_m[2]},
        {"allowed_motion_xz", &sample.contact.tangent_projector(0, 2)},
        {"allowed_motion_zx", &sample.contact.tangent_projector(2, 0)},
        {"eta", &sample.tuning.eta},
        {"surface_eta", &sample.contact.eta},
        {"eta_in_force", &sample.eta},
        {"alpha_rad2_per_m2", &sample.tuning.alpha_rad2_per_m2},
        {"limit_window_silence_s", &sample.limits.window_silence_s},
        {"theta_Sd2_rad", &sample.theta_Sd_rad[1]},
        {"R2_Ohm", &sample.motor[1].here.resistance_Ohm},
        {"R2_deviation_Ohm", &sample.motor[1].here.deviation_Ohm},
        {"R_mean2_Ohm", &sample.motor[1].mean.resistance_Ohm},
        {"R_mean2_deviation_Ohm", &sample.motor[1].mean.deviation_Ohm},
        {"k_T2_Nm_per_A", &sample.motor[1].torque_constant_Nm_per_A},
        {"offset2_A", &sample.motor[1].offset_A},
        {"carried2_V", &sample.transfer_offset_V[1]},
        {"e_W2_V", &sample.command.e_W_V[1]},
    };
    double value = 0.0;
    for (const auto &[name, member] : members) {
        *member = ++value;
    }
    sample.counts = {-1, -2, -3};
    sample.winding[2].is_limited = true;
    sample.safety.cause = servo::TripCause::voltage;
    sample.missed_deadlines = 101;
    sample.missed_in_a_row = 102;
    sample.missed_periods = 103;
    for (const auto &[name, member] : members) {
        EXPECT_EQ(value_of(sample, name), *member) << name;
    }
    EXPECT_EQ(value_of(sample, "counts3"), -3.0);
    EXPECT_EQ(value_of(sample, "R_hat_limited3"), 1.0);
    EXPECT_EQ(value_of(sample, "R_hat_limited1"), 0.0);
    EXPECT_EQ(value_of(sample, "trip_cause"), static_cast<double>(servo::TripCause::voltage));
    EXPECT_EQ(value_of(sample, "missed_deadlines"), 101.0);
    EXPECT_EQ(value_of(sample, "missed_in_a_row"), 102.0);
    EXPECT_EQ(value_of(sample, "missed_periods"), 103.0);
}

} // namespace
} // namespace springdrive::record
