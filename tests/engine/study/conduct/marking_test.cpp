// Covers engine/study/conduct/marking.cpp.
#include "engine/study/conduct/marking.h"

#include <gtest/gtest.h>

namespace springdrive::study {
namespace {

std::vector<std::string> marks(const char *name, std::optional<double> intended,
                               std::optional<double> delivered) {
    Presentation shown;
    shown.values = {{name, intended, delivered}};
    return marks_of(Marking{}, std::vector{shown});
}

TEST(StudyMarks, ABandHasTwoSides) {
    // The defaults: 2 %, 1°, 20 %, 5 ms. Values next to each end of a band, within a thousandth.
    const auto expect_band = [](const char *name, double intended, double low, double high) {
        const double step = 1e-3 * (high - low);
        EXPECT_TRUE(marks(name, intended, low + step).empty()) << name;
        EXPECT_TRUE(marks(name, intended, high - step).empty()) << name;
        EXPECT_EQ(marks(name, intended, low - step).size(), 1U) << name;
        EXPECT_EQ(marks(name, intended, high + step).size(), 1U) << name;
    };
    expect_band("stiffness_N_per_m", 1500.0, 1470.0, 1530.0);
    expect_band("direction_deg", 20.0, 19.0, 21.0);
    expect_band("direction_deg", 0.0, -1.0, 1.0);
    expect_band("press_N", 1.0, 0.8, 1.2);
    expect_band("pulse_N", 2.0, 1.6, 2.4);
    expect_band("speed_m_per_s", 0.3, 0.24, 0.36);
    EXPECT_TRUE(marks("lateness_s", 0.0, 0.0049).empty());
    EXPECT_EQ(marks("lateness_s", 0.0, 0.0051).size(), 1U);
}

TEST(StudyMarks, SayWhichValueAndByHowMuch) {
    Presentation good;
    good.values = {{"stiffness_N_per_m", 1000.0, 1000.0}};
    Presentation bad;
    bad.values = {{"stiffness_N_per_m", 1000.0, 1031.0}, {"direction_deg", 10.0, 12.5}};
    EXPECT_EQ(
        marks_of(Marking{}, std::vector{good, bad}),
        (std::vector<std::string>{"stiffness_N_per_m of presentation 2: 3.1 % off, more than 2 %",
                                  "direction_deg of presentation 2: 2.5° off, more than 1°"}));
}

TEST(StudyMarks, WhatWasIntendedMustBeMeasuredAndOtherNamesHaveNoBand) {
    EXPECT_EQ(marks("stiffness_N_per_m", 1000.0, std::nullopt),
              std::vector<std::string>{"stiffness_N_per_m of presentation 1: was not measured"});
    EXPECT_TRUE(marks("stiffness_N_per_m", std::nullopt, 1000.0).empty());
    EXPECT_TRUE(marks("peak_force_N", 1.0, 5.0).empty());
    // A NaN is no measurement that lies in a band.
    EXPECT_EQ(marks("stiffness_N_per_m", 1000.0, std::nan("")).size(), 1U);
}

} // namespace
} // namespace springdrive::study
