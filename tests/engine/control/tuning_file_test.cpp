// Covers engine/control/tuning_file.cpp and parameters.cpp.
#include "engine/control/tuning_file.h"

#include "base/input_error.h"
#include "engine/control/parameters.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

namespace springdrive {
namespace {

std::string complaint(const std::string &from, const std::string &to) {
    std::ifstream good(testing::assets() / "tunings/firm.toml");
    std::string text{std::istreambuf_iterator<char>(good), {}};
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto file = std::filesystem::path(::testing::TempDir()) / "tuning_file_test.toml";
    std::ofstream(file) << text;
    try {
        static_cast<void>(read_tuning_file(file));
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

TEST(TuningFile, TheThreeTuningsAreValidAndGrowStiffer) {
    double before = 0.0;
    for (const char *name : {"soft", "firm", "stiffest"}) {
        const Tuning tuning =
            read_tuning_file(testing::assets() / "tunings" / (std::string(name) + ".toml"));
        EXPECT_EQ(what_is_wrong_with(tuning), "");
        const double stiffness = tuning.K_P_V_per_rad / tuning.dR_Ohm;
        EXPECT_GT(stiffness, before);
        before = stiffness;
    }
}

TEST(TuningFile, FirmIsTheDefault) {
    const Tuning firm = read_tuning_file(testing::assets() / "tunings/firm.toml");
    for (const Parameter &parameter : kParameters) {
        EXPECT_EQ(firm.*parameter.value, parameter.default_value()) << parameter.name;
    }
}

TEST(TuningFile, RefusesWhatItDoesNotKnowOrCannotBe) {
    EXPECT_NE(complaint("dR_Ohm", "dr_Ohm").find("dR_Ohm is missing"), std::string::npos);
    EXPECT_NE(complaint("dR_Ohm = 0.5", "dR_Ohm = 0.0").find("0.02 to 2.18"), std::string::npos);
    EXPECT_NE(complaint("eta = 0.0", "eta = nan").find("eta"), std::string::npos);
    EXPECT_NE(complaint("transpose", "transposed").find("inverse or transpose"), std::string::npos);
    EXPECT_NE(complaint("on_the_fly", "auto").find("by_hand"), std::string::npos);
    EXPECT_NE(complaint("eta =", "mass = 1\neta =").find("mass is not known"), std::string::npos);
}

TEST(Parameters, BothSidesOfEveryRange) {
    for (const Parameter &parameter : kParameters) {
        for (const double good : {parameter.lowest, parameter.highest}) {
            Tuning tuning;
            tuning.*parameter.value = good;
            EXPECT_TRUE(is_valid(tuning)) << parameter.name << " " << good;
        }
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double bad :
             {std::nextafter(parameter.lowest, -infinity),
              std::nextafter(parameter.highest, infinity), std::nan(""), infinity, -infinity}) {
            Tuning tuning;
            tuning.*parameter.value = bad;
            EXPECT_FALSE(is_valid(tuning)) << parameter.name << " " << bad;
            EXPECT_NE(what_is_wrong_with(tuning).find(parameter.name), std::string::npos);
        }
    }
}

} // namespace
} // namespace springdrive
