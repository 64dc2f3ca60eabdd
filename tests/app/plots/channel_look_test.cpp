// Covers app/plots/channels.cpp.
#include "app/plots/channels.h"

#include "app/plots/plot_panel.h"
#include "app/widgets/widgets.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"
#include "engine/session/telemetry_history.h"
#include "tests/support/plots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

using testing::channel;

/// 0 to √3.
double distance_of_colours(const ImVec4 &a, const ImVec4 &b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// A reader takes two curves for the same one if their dashes are equal and their colours nearly.
bool look_alike(const Stroke &a, const Stroke &b) {
    return a.dash == b.dash && distance_of_colours(a.colour, b.colour) < 0.2;
}

const Stroke &stroke_of(std::string_view name) { return look_of(channel(name)).stroke; }

TEST(ChannelLook, EveryChannelHasOneWithALabelOfItsOwnAndNoOtherQuantityLooksLikeAMap) {
    ASSERT_GT(session::channels().size(), 100U);
    const std::set<std::string_view> maps{"transpose_error_rad", "inverse_error_rad",
                                          "transpose_measured_rad", "inverse_measured_rad"};
    std::set<std::string> labels;
    for (std::size_t i = 0; i < session::channels().size(); ++i) {
        const std::string &name = session::channels()[i].name;
        SCOPED_TRACE(name);
        const ChannelLook &look = look_of(i);
        EXPECT_FALSE(look.label.empty());
        EXPECT_TRUE(labels.insert(look.label).second) << look.label;
        EXPECT_GE(look.stroke.width, 1.0F);
        EXPECT_LE(look.stroke.width, 3.0F);
        const ImVec4 &colour = look.stroke.colour;
        for (const float part : {colour.x, colour.y, colour.z}) {
            EXPECT_GE(part, 0.0F);
            EXPECT_LE(part, 1.0F);
        }
        // Visible on the dark ground of plots, in spite of its opacity.
        EXPECT_GT(colour.w * (0.3F * colour.x + 0.6F * colour.y + 0.1F * colour.z), 0.2F);
        EXPECT_EQ(&look_of(i), &look) << "another one the second time";
        for (const std::string_view map : maps) {
            EXPECT_TRUE(maps.contains(name) || !look_alike(look.stroke, stroke_of(map))) << map;
        }
    }
}

TEST(ChannelLook, LabelsDoNotRepeatTheUnitOfTheAxis) {
    EXPECT_EQ(look_of(channel("tip_x_m")).label, "tip_x");
    EXPECT_EQ(look_of(channel("current2_A")).label, "current2");
    EXPECT_EQ(look_of(channel("theta_rate3_rad_per_s")).label, "theta_rate3");
    EXPECT_EQ(look_of(channel("tick")).label, "tick");
}

TEST(ChannelLook, AMapHasOneColourAndSaysWhatIncludesThePlant) {
    for (const std::string map : {"transpose", "inverse"}) {
        const ChannelLook &ideal = look_of(channel(map + "_error_rad"));
        const ChannelLook &measured = look_of(channel(map + "_measured_rad"));
        EXPECT_EQ(distance_of_colours(ideal.stroke.colour, measured.stroke.colour), 0.0) << map;
        EXPECT_NE(ideal.stroke.dash, measured.stroke.dash) << map;
        EXPECT_NE(ideal.label.find(map), std::string::npos);
        EXPECT_NE(ideal.label.find("ideal"), std::string::npos);
        EXPECT_NE(measured.label.find(map), std::string::npos);
        EXPECT_NE(measured.label.find("measured"), std::string::npos);
    }
    EXPECT_FALSE(look_alike(stroke_of("transpose_error_rad"), stroke_of("inverse_error_rad")));
    EXPECT_FALSE(
        look_alike(stroke_of("transpose_measured_rad"), stroke_of("inverse_measured_rad")));
}

TEST(ChannelLook, ComponentsAndMotorsHaveTheSameThreeColoursInAllQuantities) {
    for (const auto &[first, second] : std::vector<std::pair<std::string_view, std::string_view>>{
             {"tip_x_m", "proxy_x_m"}, {"tip_x_m", "current1_A"}, {"e_W2_V", "force_y_N"}}) {
        EXPECT_EQ(distance_of_colours(stroke_of(first).colour, stroke_of(second).colour), 0.0)
            << first << ", " << second;
    }
    EXPECT_FALSE(look_alike(stroke_of("tip_x_m"), stroke_of("tip_y_m")));
    EXPECT_FALSE(look_alike(stroke_of("tip_y_m"), stroke_of("tip_z_m")));
    EXPECT_FALSE(look_alike(stroke_of("tip_z_m"), stroke_of("tip_x_m")));
}

TEST(ChannelLook, NoTwoChannelsOfADefaultPlotLookAlike) {
    PlotPanelState state;
    for (std::size_t set = 0; set < kPlotSetLabels.size(); ++set) {
        choose_plot_set(state, set);
        ASSERT_FALSE(state.plots.empty());
        for (const Plot &plot : state.plots) {
            for (const std::size_t a : plot.settings.channels) {
                for (const std::size_t b : plot.settings.channels) {
                    EXPECT_TRUE(a <= b || !look_alike(look_of(a).stroke, look_of(b).stroke))
                        << kPlotSetLabels[set] << ": " << session::channels()[a].name << " and "
                        << session::channels()[b].name;
                }
            }
        }
    }
}

TEST(ShownUnit, IsTheSiUnitOrOneOfPeople) {
    for (std::size_t i = 0; i < session::channels().size(); ++i) {
        const session::Channel &known = session::channels()[i];
        const ShownUnit si = shown_unit(i, true);
        EXPECT_EQ(si.per_si, 1.0) << known.name;
        EXPECT_EQ(si.name, known.unit == "1" ? "–" : known.unit) << known.name;
        const ShownUnit shown = shown_unit(i, false);
        EXPECT_FALSE(shown.name.empty()) << known.name;
        EXPECT_EQ(shown.per_si == 1.0, shown.name == si.name) << known.name;
    }
    EXPECT_NEAR(shown_unit(channel("theta1_rad"), false).per_si * std::numbers::pi, 180.0, 1e-12);
    EXPECT_EQ(shown_unit(channel("theta1_rad"), false).name, "°");
    EXPECT_EQ(shown_unit(channel("tip_x_m"), false).name, "mm");
    EXPECT_EQ(shown_unit(channel("compute_s"), false).name, "µs");
    EXPECT_EQ(shown_unit(channel("compute_s"), false).per_si, 1e6);
    EXPECT_EQ(shown_unit(channel("time_s"), false).name, "s");
}

TEST(PlotLevel, TheLimitOfPerceptionStandsInPlotsOfDirections) {
    int with_level = 0;
    for (std::size_t i = 0; i < session::channels().size(); ++i) {
        const std::optional<PlotLevel> level = level_of(i);
        with_level += level ? 1 : 0;
        if (level) {
            EXPECT_EQ(session::channels()[i].unit, "rad");
            const auto [level_rad, label] = *level;
            EXPECT_NEAR(level_rad * 180.0 / std::numbers::pi, 25.0, 1e-9);
            EXPECT_NE(label.find("25°"), std::string_view::npos);
            EXPECT_GT(greatest_of_interest(i), level_rad);
            EXPECT_LT(greatest_of_interest(i), 0.5 * std::numbers::pi);
        } else {
            EXPECT_TRUE(std::isinf(greatest_of_interest(i)));
        }
    }
    EXPECT_EQ(with_level, 5); // every tick, and both maps, ideal and measured
}

constexpr int kEquationsOfThePaper = 30;

/// The numbers of a text such as "(10), (12)"; fails the test for anything else.
std::set<int> numbers_in(const std::string &text) {
    EXPECT_TRUE(std::regex_match(text, std::regex(R"((\(\d+\)(, \(\d+\))*)?)"))) << text;
    std::set<int> numbers;
    const std::regex number(R"(\d+)");
    for (std::sregex_iterator it(text.begin(), text.end(), number), end; it != end; ++it) {
        numbers.insert(std::stoi(it->str()));
    }
    return numbers;
}

TEST(Symbols, AreListedOnceWithEquationsThatThePaperHas) {
    std::set<std::string> names;
    std::set<int> equations;
    for (const Symbol &symbol : symbols()) {
        EXPECT_TRUE(names.insert(std::string(symbol.name)).second) << symbol.name;
        for (const int number : numbers_in(std::string(symbol.equations))) {
            EXPECT_GE(number, 1) << symbol.name;
            EXPECT_LE(number, kEquationsOfThePaper) << symbol.name;
            equations.insert(number);
        }
        EXPECT_TRUE(symbol.paper.empty() || !symbol.equations.empty() ||
                    symbol.name == "normal_direction" || symbol.name == "period")
            << symbol.name << " has a name in the paper, and no equation";
    }
    EXPECT_GT(equations.size(), 15U);
}

TEST(Symbols, DescribeEveryParameterWithUnitRangeAndItsOwnEquation) {
    for (const control::Parameter &parameter : control::kParameters) {
        const std::string text = explanation_of(parameter.name);
        EXPECT_TRUE(text.starts_with(parameter.symbol)) << text;
        EXPECT_NE(text.find(parameter.help), std::string::npos) << text;
        EXPECT_NE(text.find("unit: " + std::string(parameter.unit)), std::string::npos) << text;
        EXPECT_NE(text.find(parameter.equation), std::string::npos) << text;
        EXPECT_NE(text.find("in the paper: "), std::string::npos) << text;
        EXPECT_NE(text.find("\nfrom "), std::string::npos) << text;
    }
}

TEST(Symbols, DescribeEveryChannelWithItsNameAndUnit) {
    std::set<std::string> used;
    for (const session::Channel &channel : session::channels()) {
        const std::string quantity = quantity_of(channel);
        ASSERT_NE(symbol_named(quantity), nullptr) << channel.name << ": " << quantity;
        used.insert(quantity);
        const std::string text = explanation_of(channel.name);
        // Parameters are channels, too: their own text names the symbol instead.
        const bool is_parameter =
            std::ranges::any_of(control::kParameters, [&](const control::Parameter &parameter) {
                return parameter.name == channel.name;
            });
        EXPECT_EQ(text.find(channel.name) != std::string::npos, !is_parameter) << text;
        const std::string unit = channel.unit == "1" ? "–" : channel.unit;
        EXPECT_NE(text.find("\nunit: " + unit), std::string::npos) << text;
        EXPECT_GT(text.find("\nunit: "), channel.name.size() + 10) << "no meaning: " << text;
        if (!channel.about.empty()) {
            EXPECT_NE(text.find(channel.about), std::string::npos) << text;
        }
    }
    EXPECT_GT(used.size(), 60U);
}

/// Of UTF-8: code points that the window's font has, see Window::choose_font.
void expect_letters_of_the_window(const std::string &text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const int more = byte < 0x80 ? 0 : byte < 0xe0 ? 1 : byte < 0xf0 ? 2 : 3;
        char32_t letter = more == 0 ? byte : byte & (0x3fU >> static_cast<unsigned>(more));
        for (int k = 0; k < more; ++k) {
            letter = letter << 6U | (static_cast<unsigned char>(text.at(++i)) & 0x3fU);
        }
        EXPECT_TRUE(
            letter == '\n' || (letter >= 0x20 && letter <= 0xff) ||
            (letter >= 0x370 && letter <= 0x3ff) || (letter >= 0x2010 && letter <= 0x2027) ||
            (letter >= 0x2070 && letter <= 0x209f) || (letter >= 0x2190 && letter <= 0x22ff))
            << std::hex << static_cast<unsigned>(letter) << ": " << text;
    }
}

TEST(Symbols, AreWrittenInLettersThatTheWindowHas) {
    for (const Symbol &symbol : symbols()) {
        expect_letters_of_the_window(explanation_of(symbol.name));
    }
    for (const session::Channel &channel : session::channels()) {
        expect_letters_of_the_window(explanation_of(channel.name));
    }
}

TEST(Symbols, OfOneQuantityShareTheirText) {
    for (const auto &[channel, quantity] : {std::pair("theta_Sd2_rad", "theta_Sd"),
                                            {"x_Sd_z_m", "x_Sd"},
                                            {"R_mean3_deviation_Ohm", "R_mean_deviation"},
                                            {"normal_y", "normal"},
                                            {"alpha_rad2_per_m2", "alpha"},
                                            {"allowed_motion_zx", "allowed_motion"},
                                            {"limit_winding_C", "limit"}}) {
        EXPECT_EQ(quantity_of(session::channels()[session::channel_named(channel).value()]),
                  quantity);
    }
}

TEST(Symbols, DescribeEveryLimitAndWhatPanelsShow) {
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        const std::string text = explanation_of(std::string("limit_") + limit.name);
        EXPECT_NE(text.find(limit.what), std::string::npos) << text;
    }
    for (const char *name : {"K_L = K_HF", "K_DC", "B_dR", "lag τ", "added", "at the tip",
                             "tip stiffness", "active α", "observe R"}) {
        const std::string text = explanation_of(name, "N·m"); // the given unit
        ASSERT_NE(symbol_named(name), nullptr) << name;
        EXPECT_NE(text.find(symbol_named(name)->meaning), std::string::npos) << text;
        EXPECT_NE(text.find("\nunit: N·m"), std::string::npos) << text;
    }
    EXPECT_EQ(explanation_of("no such symbol"), "no such symbol");
}

} // namespace
} // namespace springdrive::app
