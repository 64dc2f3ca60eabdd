// Covers engine/control/tuning.cpp and tuning_file.cpp, and what of base/strict_toml.cpp may be
// left out.
#include "engine/control/tuning.h"

#include "base/input_error.h"
#include "engine/control/tuning_file.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/tunings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::control {
namespace {

/// The error for a file of this text, in which the first `from` behind `begin` is replaced by `to`.
std::string error_in(std::string text, const std::string &begin, const std::string &from,
                     const std::string &to) {
    const std::size_t at = text.find(from, text.find(begin));
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto file = testing::fresh_folder("tuning_file") / "bad.toml";
    std::ofstream(file) << text;
    return error_text_of([&file] { static_cast<void>(read_whole_tuning_file(file)); });
}

std::string error(const std::string &from, const std::string &to) {
    return error_in(testing::contents_of(testing::assets() / "tunings/firm.toml"), "", from, to);
}

TEST(TuningFile, TheShippedTuningsAreValidAndGrowStiffer) {
    double before = 0.0;
    for (const char *name : {"soft", "firm", "stiffest_1kHz", "stiffest_4kHz"}) {
        const Tuning tuning = testing::tuning(name);
        EXPECT_EQ(validate(tuning), "");
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

TEST(TuningFile, RefusesUnknownKeysAndInvalidValues) {
    EXPECT_NE(error("dR_Ohm", "dr_Ohm").find("dR_Ohm is missing"), std::string::npos);
    EXPECT_NE(error("dR_Ohm = 0.5", "dR_Ohm = 0.0").find("0.02 to 2.18"), std::string::npos);
    EXPECT_NE(error("eta = 0.0", "eta = nan").find("eta"), std::string::npos);
    EXPECT_NE(error("transpose", "transposed").find("inverse or transpose"), std::string::npos);
    EXPECT_NE(error("on_the_fly", "auto").find("by_hand or at_touch"), std::string::npos);
    EXPECT_NE(error("eta =", "mass = 1\neta =").find("mass is not known"), std::string::npos);
    // The parser quotes the line end that it did not expect; keys and texts may contain some.
    EXPECT_EQ(error("\"transpose\"", R"("trans\npose")").find('\n'), std::string::npos);
    EXPECT_EQ(error("eta =", "\"a\\nb\" = 1\neta =").find('\n'), std::string::npos);
    EXPECT_EQ(error("eta = 0.0", "eta = i").find('\n'), std::string::npos);
}

TEST(Parameters, MapsAndSourcesOfAlphaHaveTheirNamesAndLabels) {
    EXPECT_EQ(name_of(MotionMap::inverse), "inverse");
    EXPECT_EQ(name_of(MotionMap::transpose), "transpose");
    EXPECT_EQ(name_of(AlphaMode::on_the_fly), "on_the_fly");
    EXPECT_EQ(name_of(AlphaMode::global), "global");
    EXPECT_EQ(name_of(AlphaMode::by_hand), "by_hand");
    EXPECT_EQ(name_of(AlphaMode::at_touch), "at_touch");
    for (const MotionMap map : {MotionMap::inverse, MotionMap::transpose}) {
        EXPECT_EQ(motion_map_named(name_of(map)), map);
    }
    for (const AlphaMode mode :
         {AlphaMode::on_the_fly, AlphaMode::global, AlphaMode::by_hand, AlphaMode::at_touch}) {
        EXPECT_EQ(alpha_mode_named(name_of(mode)), mode);
    }
    EXPECT_EQ(label_of(MotionMap::inverse), "inverse (18)");
    EXPECT_EQ(label_of(MotionMap::transpose), "transpose (23)");
    EXPECT_EQ(label_of(AlphaMode::on_the_fly), "α on the fly");
    EXPECT_EQ(label_of(AlphaMode::global), "global α");
    EXPECT_EQ(label_of(AlphaMode::by_hand), "α by hand");
    EXPECT_EQ(label_of(AlphaMode::at_touch), "α at touch");
    EXPECT_FALSE(motion_map_named("Inverse"));
    EXPECT_FALSE(alpha_mode_named(""));
}

TuningFile written_and_read(const TuningFile &file) {
    const auto path = testing::fresh_folder("tuning_file") / "written.toml";
    std::ofstream out(path);
    write_tuning_file(out, file);
    out.close();
    return read_whole_tuning_file(path);
}

TuningFile random_file(std::mt19937_64 &random) {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    TuningFile file;
    file.description = "a \"firm\" one \\ of dR 0.5 Ω";
    for (const Parameter &parameter : kParameters) {
        file.tuning.*parameter.value =
            parameter.minimum + share(random) * (parameter.maximum - parameter.minimum);
    }
    file.tuning.map = share(random) < 0.5 ? MotionMap::inverse : MotionMap::transpose;
    constexpr std::array kModes{AlphaMode::on_the_fly, AlphaMode::global, AlphaMode::by_hand,
                                AlphaMode::at_touch};
    file.tuning.alpha_mode = kModes[random() % kModes.size()];
    file.margins = TuningMargins{1.0 / (1e-4 + 1e-3 * share(random)),
                                 8.0 * share(random),
                                 1.0 + share(random),
                                 static_cast<int>(random() % 9),
                                 share(random),
                                 share(random) * 1e-7, // digits with an exponent
                                 "firmness 0.25",
                                 share(random)};
    return file;
}

TEST(TuningFile, IsReadAsItWasWrittenToTheLastBit) {
    std::mt19937_64 random(51);
    for (int i = 0; i < 100; ++i) {
        const TuningFile file = random_file(random);
        const TuningFile same = written_and_read(file);
        EXPECT_EQ(same.description, file.description);
        for (const Parameter &parameter : kParameters) {
            EXPECT_EQ(same.tuning.*parameter.value, file.tuning.*parameter.value);
        }
        EXPECT_EQ(same.tuning.map, file.tuning.map);
        EXPECT_EQ(same.tuning.alpha_mode, file.tuning.alpha_mode);
        ASSERT_TRUE(same.margins);
        EXPECT_EQ(same.margins->servo_hz, file.margins->servo_hz);
        EXPECT_EQ(same.margins->delay_periods, file.margins->delay_periods);
        EXPECT_EQ(same.margins->gain, file.margins->gain);
        EXPECT_EQ(same.margins->more_delay_periods, file.margins->more_delay_periods);
        EXPECT_EQ(same.margins->min_dR_Ohm, file.margins->min_dR_Ohm);
        EXPECT_EQ(same.margins->K_DC_Nm_per_rad, file.margins->K_DC_Nm_per_rad);
        EXPECT_EQ(same.margins->worst_hand, file.margins->worst_hand);
        EXPECT_EQ(same.margins->worst_eta, file.margins->worst_eta);
    }
}

TEST(TuningFile, NeedsNoMargins) {
    TuningFile file;
    EXPECT_FALSE(written_and_read(file).margins);
    for (const char *name : {"soft", "firm", "stiffest_1kHz", "stiffest_4kHz"}) {
        const TuningFile shipped = read_whole_tuning_file(testing::tuning_path(name));
        EXPECT_NE(shipped.description, "") << name;
    }
}

TEST(TuningFile, ADescriptionStaysOnItsLine) {
    TuningFile file;
    file.description = "two\nlines\tand a tab";
    EXPECT_EQ(written_and_read(file).description, "two lines and a tab");
}

/// Files from before d was a real number can still be read.
TEST(TuningFile, ReadsTheOldNamesOfDelays) {
    TuningFile file;
    file.margins = TuningMargins{1000.0, 3.0, 1.5, 2, 0.25, 0.5, "firm", 0.75};
    std::ostringstream out;
    write_tuning_file(out, file);
    std::string text = out.str();
    EXPECT_NE(text.find("\ndelay_periods = 3.0\n"), std::string::npos);
    EXPECT_NE(text.find("\nmore_delay_periods = 2\n"), std::string::npos);
    EXPECT_EQ(text.find("samples"), std::string::npos);
    const auto rename = [&text](const std::string &from, const std::string &to) {
        text.replace(text.find(from), from.size(), to);
    };
    rename("\ndelay_periods = 3.0\n", "\ndelay_samples = 3\n");
    rename("more_delay_periods", "more_delay_samples");
    const auto path = testing::fresh_folder("tuning_file") / "old_margins.toml";
    std::ofstream(path) << text;
    const TuningFile read = read_whole_tuning_file(path);
    ASSERT_TRUE(read.margins);
    EXPECT_EQ(read.margins->delay_periods, 3.0);
    EXPECT_EQ(read.margins->more_delay_periods, 2);
}

/// The error for a file with valid margins in which `from` is replaced by `to`.
std::string error_about_margins(const std::string &from, const std::string &to) {
    TuningFile file;
    file.margins = TuningMargins{1000.0, 1, 1.5, 2, 0.25, 0.5, "firm", 0.75};
    std::ostringstream out;
    write_tuning_file(out, file);
    return error_in(out.str(), "[margins]", from, to);
}

TEST(TuningFile, RefusesInvalidMarginsWithTheirLine) {
    struct Bad {
        std::string from;
        std::string to;
        std::string said;
    };
    // [margins] is line 12: a description, two names, six parameters, a gap and a warning before.
    const std::vector<Bad> all{
        {"servo_hz = 1000.0", "servo_hz = 0.0", ":13: margins.servo_hz is 0; it must be"},
        {"delay_periods = 1", "delay_periods = -1", ":14: margins.delay_periods"},
        {"delay_periods = 1.0", "delay_periods = 100.5", ":14: margins.delay_periods"},
        {"delay_periods = 1.0", "delay_periods = nan", ":14: margins.delay_periods"},
        {"delay_periods = 1.0", "", "margins.delay_periods is missing"},
        {"delay_periods = 1.0", "delay_samples = -1", ":14: margins.delay_samples"},
        {"delay_periods = 1.0", "delay_periods = 1.0\ndelay_samples = 1",
         ":15: margins.delay_samples is the old name of delay_periods"},
        {"more_delay_periods = 2", "more_delay_periods = 2\nmore_delay_samples = 2",
         ":17: margins.more_delay_samples is the old name of more_delay_periods"},
        {"more_delay_periods = 2", "more_delay_periods = 1.5", "whole"},
        {"gain = 1.5", "gain = 0.9", ":15: margins.gain"},
        {"gain = 1.5", "gain = nan", ":15: margins.gain"},
        {"more_delay_periods = 2", "more_delay_periods = 1000", ":16: margins.more_delay_periods"},
        {"least_dR_Ohm = 0.25", "least_dR_Ohm = -0.1", ":17: margins.least_dR_Ohm"},
        {"K_DC_Nm_per_rad = 0.5", "K_DC_Nm_per_rad = inf", ":18: margins.K_DC_Nm_per_rad"},
        {"worst_hand = \"firm\"", "worst_hand = 3", ":19: margins.worst_hand"},
        {"worst_eta = 0.75", "worst_eta = 1.01", ":20: margins.worst_eta"},
        {"worst_eta = 0.75", "", "margins.worst_eta is missing"},
        {"gain = 1.5", "gain = 1.5\nphase = 3", "phase"},
    };
    for (const Bad &bad : all) {
        const std::string said = error_about_margins(bad.from, bad.to);
        EXPECT_NE(said.find(bad.said), std::string::npos) << bad.to << ": " << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
    EXPECT_EQ(error_about_margins("gain = 1.5", "gain = 1.5"), "");
    EXPECT_EQ(error_about_margins("delay_periods = 1.0", "delay_periods = 1.5"), "");
    EXPECT_EQ(error_about_margins("delay_periods = 1.0", "delay_periods = 1"), "");
    EXPECT_NE(error_about_margins("[margins]", "margins = 3\n[more]"), "");
}

TEST(Parameters, BothSidesOfEveryRange) {
    for (const Parameter &parameter : kParameters) {
        for (const double good : {parameter.minimum, parameter.maximum}) {
            Tuning tuning;
            tuning.*parameter.value = good;
            EXPECT_TRUE(is_valid(tuning)) << parameter.name << " " << good;
        }
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double bad :
             {std::nextafter(parameter.minimum, -infinity),
              std::nextafter(parameter.maximum, infinity), std::nan(""), infinity, -infinity}) {
            Tuning tuning;
            tuning.*parameter.value = bad;
            EXPECT_FALSE(is_valid(tuning)) << parameter.name << " " << bad;
            EXPECT_NE(validate(tuning).find(parameter.name), std::string::npos);
        }
    }
}

std::string difference(const Tuning &before, const Tuning &after) {
    return text_of(changes_between(before, after));
}

/// The change of K_P from one value to another, as "before → after".
std::string change_of_K_P(double before_V_per_rad, double after_V_per_rad) {
    const std::vector<TuningChange> changes =
        changes_between({.K_P_V_per_rad = before_V_per_rad}, {.K_P_V_per_rad = after_V_per_rad});
    return changes.size() == 1 ? changes[0].before + " → " + changes[0].after : "not one change";
}

TEST(TuningDifference, IsOneLine) {
    const Tuning before{.map = MotionMap::inverse};
    const Tuning after{.dR_Ohm = 0.3, .K_P_V_per_rad = 8.0};
    EXPECT_EQ(difference(before, after),
              "dR 0.5 → 0.3 Ω, K_P 6 → 8 V/rad, map inverse (18) → transpose (23)");
    EXPECT_EQ(difference({}, {.eta = 0.25, .alpha_mode = AlphaMode::global}),
              "η 0 → 0.25, source α on the fly → global α");
    EXPECT_EQ(difference(after, after), "no difference");
}

TEST(TuningDifference, NamesEveryParameterAsItsRowDoes) {
    for (const Parameter &parameter : kParameters) {
        Tuning before{.alpha_mode = AlphaMode::by_hand};
        Tuning after = before;
        before.*parameter.value = parameter.minimum;
        after.*parameter.value = parameter.maximum;
        const std::vector<TuningChange> changes = changes_between(before, after);
        ASSERT_EQ(changes.size(), 1U) << parameter.name;
        EXPECT_EQ(changes[0].name, parameter.name);
        EXPECT_EQ(changes[0].symbol, parameter.symbol);
        EXPECT_EQ(changes[0].unit.empty(), parameter.value == &Tuning::eta);
        EXPECT_EQ(std::stod(changes[0].before), parameter.minimum);
        EXPECT_EQ(std::stod(changes[0].after), parameter.maximum);
    }
}

TEST(TuningDifference, NamesAlphaOnlyWhereItActs) {
    const Tuning on_the_fly{.alpha_rad2_per_m2 = 1000.0};
    const Tuning global{.alpha_rad2_per_m2 = 2000.0, .alpha_mode = AlphaMode::global};
    const Tuning by_hand{.alpha_rad2_per_m2 = 3000.0, .alpha_mode = AlphaMode::by_hand};
    EXPECT_EQ(difference(on_the_fly, global), "source α on the fly → global α");
    EXPECT_EQ(difference(on_the_fly, by_hand),
              "α 1000 → 3000 rad²/m², source α on the fly → α by hand");
    EXPECT_EQ(difference(by_hand, global), "α 3000 → 2000 rad²/m², source α by hand → global α");
    EXPECT_EQ(difference(on_the_fly, {.alpha_rad2_per_m2 = 1500.0}), "no difference");
}

TEST(TuningDifference, HasAsManyDigitsAsTellTheValuesApart) {
    EXPECT_EQ(change_of_K_P(6.0, 13.445854187011719), "6 → 13.4");
    EXPECT_EQ(change_of_K_P(13.445854187011719, 13.4500001), "13.4 → 13.5");
    EXPECT_EQ(change_of_K_P(13.445854187011719, 13.4459), "13.44585 → 13.4459");
    EXPECT_EQ(change_of_K_P(0.1 + 0.2, 0.3), "0.30000000000000004 → 0.3");
    EXPECT_EQ(change_of_K_P(1234.5678, 20'000.4), "1235 → 20000");
    EXPECT_EQ(change_of_K_P(999.96, 1e-5), "1000 → 1e-05");
    EXPECT_EQ(change_of_K_P(0.0, std::numeric_limits<double>::denorm_min()), "0 → 5e-324");
    EXPECT_EQ(change_of_K_P(0.0, -0.0), "not one change");
}

TEST(TuningDifference, NeverShowsDifferentNumbersAsTheSame) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> exponent(-6.0, 6.0);
    std::uniform_real_distribution<double> closeness(-17.0, 0.0);
    int changed = 0;
    for (int i = 0; i < 20'000; ++i) {
        const double before = std::pow(10.0, exponent(random));
        const double after = before * (1.0 + std::pow(10.0, closeness(random)));
        const std::vector<TuningChange> changes =
            changes_between({.K_P_V_per_rad = before}, {.K_P_V_per_rad = after});
        ASSERT_EQ(changes.size(), before == after ? 0U : 1U);
        if (!changes.empty()) {
            ++changed;
            EXPECT_NE(changes[0].before, changes[0].after);
            // Half a unit of the third digit.
            EXPECT_NEAR(std::stod(changes[0].before) / before, 1.0, 5.001e-3);
            EXPECT_NEAR(std::stod(changes[0].after) / after, 1.0, 5.001e-3);
        }
    }
    EXPECT_GT(changed, 10'000);
}

TEST(TuningDifference, APresetSetsTheGainsAndNothingElse) {
    const Tuning active{.alpha_rad2_per_m2 = 1000.0,
                        .eta = 0.2,
                        .map = MotionMap::inverse,
                        .alpha_mode = AlphaMode::by_hand};
    const Tuning preset{.dR_Ohm = 0.2,
                        .K_P_V_per_rad = 13.0,
                        .K_D_Vs_per_rad = 0.02,
                        .lambda_rad_per_s = 5000.0,
                        .alpha_rad2_per_m2 = 4000.0};
    const Tuning result = with_gains_of(active, preset);
    EXPECT_EQ(difference(active, result), "dR 0.5 → 0.2 Ω, K_P 6 → 13 V/rad, K_D 0.01 → 0.02 "
                                          "V·s/rad, λ 1000 → 5000 rad/s");
    EXPECT_EQ(with_gains_of(result, preset), result);
    EXPECT_EQ(with_gains_of(preset, active),
              (Tuning{.alpha_rad2_per_m2 = preset.alpha_rad2_per_m2}));
}

/// A new parameter is set by presets or is kept, on purpose.
TEST(TuningDifference, EveryParameterIsAGainOfPresetsOrKept) {
    const std::vector<double Tuning::*> kept{&Tuning::alpha_rad2_per_m2, &Tuning::eta};
    for (const Parameter &parameter : kParameters) {
        EXPECT_EQ(std::ranges::count(kGainsOfPresets, parameter.value) +
                      std::ranges::count(kept, parameter.value),
                  1)
            << parameter.name;
    }
}

} // namespace
} // namespace springdrive::control
