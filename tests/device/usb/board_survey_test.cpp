// Covers what device/usb/driver/board_survey.h says without libusb.
#include "device/usb/driver/board_survey.h"

#include "device/usb/emulator/emulated_board.h"

#include <gtest/gtest.h>

#include <array>

namespace springdrive::usb {
namespace {

TEST(BoardSurvey, NamesAPlaceAsSysfsDoes) {
    using Ports = std::vector<std::uint8_t>;
    EXPECT_EQ(sysfs_name_of(1, Ports{2}), "1-2");
    EXPECT_EQ(sysfs_name_of(3, Ports{1, 2, 14}), "3-1.2.14");
    EXPECT_EQ(sysfs_name_of(2, Ports{}), "usb2");
}

TEST(BoardSurvey, TakesFirmwareAndSerialFromTheBoardsAnswer) {
    Identity identity = emulator::emulated_identity("A7");
    identity.firmware = {1, 20, 300};
    SurveyedBoard board;
    take_identity(encode(identity), board);
    EXPECT_EQ(board.serial, "A7");
    EXPECT_EQ(board.firmware, "springdrive emulator 1.20.300");
    EXPECT_EQ(board.obstacle, BoardObstacle::none);
    EXPECT_EQ(board.problem, "");
}

TEST(BoardSurvey, AnotherVersionOfTheProtocolIsNamedOnBothSides) {
    Identity identity = emulator::emulated_identity("A7");
    for (const auto &[oldest, newest] : {std::pair{0, 0}, {2, 9}}) {
        identity.oldest_version = static_cast<std::uint8_t>(oldest);
        identity.newest_version = static_cast<std::uint8_t>(newest);
        SurveyedBoard board;
        take_identity(encode(identity), board);
        EXPECT_EQ(board.obstacle, BoardObstacle::wrong_version);
        EXPECT_NE(board.problem.find("this program has version 1"), std::string::npos);
        EXPECT_EQ(board.serial, "A7"); // still known
    }
    identity.oldest_version = 0;
    SurveyedBoard board;
    take_identity(encode(identity), board);
    EXPECT_EQ(board.obstacle, BoardObstacle::none);
}

TEST(BoardSurvey, WhatIsNoAnswerOfABoardSaysSo) {
    auto damaged = encode(emulator::emulated_identity("A7"));
    damaged[20] ^= 1U;
    SurveyedBoard board;
    take_identity(damaged, board);
    EXPECT_EQ(board.obstacle, BoardObstacle::no_interface);
    EXPECT_NE(board.problem.find("checksum"), std::string::npos) << board.problem;
    SurveyedBoard silent;
    take_identity({}, silent);
    EXPECT_NE(silent.problem.find("refuses"), std::string::npos) << silent.problem;
}

} // namespace
} // namespace springdrive::usb
