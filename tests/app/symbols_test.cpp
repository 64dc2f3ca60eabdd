// Covers app/plots/symbols.cpp: every parameter, limit and channel has its text, with equations
// that the paper has.
#include "app/plots/symbols.h"

#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

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
