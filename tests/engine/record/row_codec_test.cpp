// Covers engine/record/row_codec.cpp.
#include "engine/record/row_codec.h"

#include "engine/record/record_format.h"
#include "tests/engine/record/samples.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace springdrive::record {
namespace {

using testing::error_text_of;
using testing::random_sample;
using testing::row_of;

std::span<const std::byte> bytes_of_text(const std::string &text) {
    return {reinterpret_cast<const std::byte *>(text.data()), text.size()};
}

TEST(RowCodec, PacksColumnsInSequence) {
    std::uint32_t offset = 0;
    for (const RecordColumn &column : sample_columns()) {
        EXPECT_EQ(column.offset, offset) << column.name;
        offset += bytes_of(column.type);
    }
    EXPECT_EQ(record_header(1000.0).row_bytes, offset);
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

TEST(RowCodec, RoundTripsEveryBit) {
    std::mt19937_64 random(1);
    const RowDecoder decoder(record_header(1000.0));
    for (int i = 0; i < 300; ++i) {
        const std::string row = row_of(random_sample(random, random()));
        EXPECT_EQ(row_of(decoder.decode(bytes_of_text(row))), row);
    }
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
    for (std::size_t i = 0; i < names.at("map").size(); ++i) {
        EXPECT_EQ(control::motion_map_named(names.at("map")[i]),
                  static_cast<control::MotionMap>(i));
    }
    for (std::size_t i = 0; i < names.at("alpha_mode").size(); ++i) {
        EXPECT_EQ(control::alpha_mode_named(names.at("alpha_mode")[i]),
                  static_cast<control::AlphaMode>(i));
    }
    EXPECT_EQ(names.at("map").size(), 2U);
    EXPECT_EQ(names.at("alpha_mode").size(), 3U);
    EXPECT_EQ(names.at("trip_cause").at(static_cast<std::size_t>(servo::TripCause::voltage)),
              "voltage");
    EXPECT_EQ(names.at("safety_state").at(static_cast<std::size_t>(servo::SafetyState::tripped)),
              "tripped");
    EXPECT_EQ(names.at("health").at(static_cast<std::size_t>(device::DeviceHealth::lost)), "lost");
}

} // namespace
} // namespace springdrive::record
