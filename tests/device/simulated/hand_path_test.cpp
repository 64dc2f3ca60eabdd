// Covers device/simulated/hand.cpp.
#include "device/simulated/hand.h"

#include "base/input_error.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace springdrive::simulated {
namespace {

std::filesystem::path written(const std::string &name, const std::string &text) {
    const std::filesystem::path file = testing::fresh_folder("hand_path") / name;
    std::ofstream(file) << text;
    return file;
}

std::string error(const std::string &text) {
    try {
        static_cast<void>(HandPath::read_csv(written("hand_path_test.csv", text)));
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

TEST(HandPath, IsLinearBetweenPointsAndAtRestOutside) {
    HandPath path({{1.0, Vector3(0, 0, 0)}, {2.0, Vector3(2, 0, -4)}, {4.0, Vector3(2, 1, -4)}});
    EXPECT_EQ(path.at(0.0).position_m, Vector3(0, 0, 0));
    EXPECT_EQ(path.at(0.0).velocity_m_per_s, Vector3::Zero());
    EXPECT_EQ(path.at(1.5).position_m, Vector3(1, 0, -2));
    EXPECT_EQ(path.at(1.5).velocity_m_per_s, Vector3(2, 0, -4));
    EXPECT_EQ(path.at(3.0).position_m, Vector3(2, 0.5, -4));
    EXPECT_EQ(path.at(9.0).position_m, Vector3(2, 1, -4));
    EXPECT_EQ(path.at(9.0).velocity_m_per_s, Vector3::Zero());
}

TEST(HandPath, ReadsCsvWithBlanksAndWindowsLineEnds) {
    const HandPath path = HandPath::read_csv(
        written("hand_path_good.csv", "t,x,y,z\r\n0, 0.1 ,0,-1e-2\r\n\r\n2.5,0.2,0,0\r\n"));
    ASSERT_EQ(path.points().size(), 2U);
    EXPECT_EQ(path.points()[0].position_m, Vector3(0.1, 0, -1e-2));
    EXPECT_EQ(path.points()[1].time_s, 2.5);
}

TEST(HandPath, ReadsCsvWithoutAHeaderWhereThatIsAllowed) {
    using Header = HandPath::Header;
    for (const char *text : {"0,0.1,0,0\n1,0.2,0,0\n", "t,x,y,z\n0,0.1,0,0\n1,0.2,0,0\n"}) {
        const HandPath path =
            HandPath::read_csv(written("hand_path_header.csv", text), Header::optional);
        ASSERT_EQ(path.points().size(), 2U);
        EXPECT_EQ(path.points()[0].position_m, Vector3(0.1, 0, 0));
    }
    EXPECT_THROW(static_cast<void>(HandPath::read_csv(
                     written("hand_path_header.csv", "time,x,y,z\n0,0,0,0\n"), Header::optional)),
                 InputError);
}

TEST(HandPath, SaysWhichLineIsWrong) {
    EXPECT_NE(error("0,0,0,0\n").find(":1:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0\n").find(":2:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0,0\n").find(":2:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,nan,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,2mm,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n1,0,0,0\n1,0,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,0,5.1,0\n").find(":3:"), std::string::npos);
    EXPECT_EQ(error("\xEF\xBB\xBFt,x,y,z\n0,0,0,0\n1,0,4.9,0\n"), "");
    EXPECT_NE(error("t,x,y,z\n").find("no point"), std::string::npos);
    EXPECT_NE(error("").find("no point"), std::string::npos);
    EXPECT_THROW(static_cast<void>(HandPath::read_csv("no such file.csv")), InputError);
}

} // namespace
} // namespace springdrive::simulated
