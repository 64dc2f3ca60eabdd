// Covers app/plots/axis.cpp.
#include "app/plots/axis.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

constexpr int kAxes = 2000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Axes as plots have them: of any magnitude, and up to a million times further from 0 than long.
class RandomAxes {
public:
    Axis linear() {
        const double length = std::pow(10.0, between(-9.0, 9.0));
        const double from = length * between(-1.0, 1.0) * std::pow(10.0, between(0.0, 6.0));
        return {from, from + length};
    }
    /// From a tenth of a decade to twelve decades.
    Axis logarithmic() {
        const double from = std::pow(10.0, between(-9.0, 6.0));
        return {from, from * std::pow(10.0, std::pow(10.0, between(-1.0, 1.08))), true};
    }
    Axis any() { return between(0.0, 1.0) < 0.5 ? linear() : logarithmic(); }

    double between(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    int whole_number(int from, int to) {
        return std::uniform_int_distribution<int>(from, to)(random_);
    }

private:
    std::mt19937_64 random_{20'240'501};
};

std::string text_of(const Axis &axis) {
    return fmt::format("{} to {}{}", axis.from, axis.to,
                       axis.is_logarithmic ? ", logarithmic" : "");
}

/// Of its share of the axis: doubles hold some 1e-16 of values that may be 1e6 axes away from 0.
constexpr double kShare = 1e-9;

void expect_same_in_share(const Axis &axis, const Axis &expected) {
    EXPECT_NEAR(expected.share(axis.from), 0.0, kShare) << text_of(expected);
    EXPECT_NEAR(expected.share(axis.to), 1.0, kShare) << text_of(expected);
}

std::vector<Tick> labelled(const std::vector<Tick> &ticks) {
    std::vector<Tick> some;
    std::ranges::copy_if(ticks, std::back_inserter(some),
                         [](const Tick &tick) { return !tick.label.empty(); });
    return some;
}

/// Whether a positive number is 1, 2 or 5 times a power of ten.
bool is_round(double number) {
    const double digit = number / std::pow(10.0, std::floor(std::log10(number) + 1e-9));
    return std::ranges::any_of(std::vector<double>{1.0, 2.0, 5.0}, [digit](double round) {
        return std::abs(digit - round) < 1e-6 * round;
    });
}

bool is_usable(const Axis &axis) {
    return std::isfinite(axis.from) && std::isfinite(axis.to) && axis.from < axis.to &&
           (!axis.is_logarithmic || axis.from > 0.0);
}

TEST(Axis, ShareAndValueAreInverses) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const Axis axis = axes.any();
        const double share = axes.between(-2.0, 3.0);
        ASSERT_NEAR(axis.share(axis.value(share)), share, kShare) << text_of(axis);
        expect_same_in_share(axis, axis);
        EXPECT_LT(axis.share(axis.value(share)), axis.share(axis.value(share + 0.01)));
    }
    EXPECT_DOUBLE_EQ((Axis{-2.0, 6.0}).value(0.5), 2.0);
    const Axis logarithmic{0.01, 100.0, true};
    EXPECT_DOUBLE_EQ(logarithmic.value(0.5), 1.0);
    for (const double value : {0.0, -3.0}) { // these have a place, too
        EXPECT_LT(logarithmic.share(value), -10.0);
        EXPECT_TRUE(std::isfinite(logarithmic.share(value)));
    }
}

TEST(Axis, ZoomKeepsThePointUnderTheMouseAndMovesGoThereAndBack) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const Axis axis = axes.any();
        const double share = axes.between(0.0, 1.0);
        const double factor = axes.between(0.5, 2.0);
        const Axis zoomed = axis.zoomed(share, factor);
        ASSERT_NEAR(zoomed.share(axis.value(share)), share, kShare) << text_of(axis);
        // A quarter of the new axis was `factor` quarters of the old one.
        EXPECT_NEAR(axis.share(zoomed.value(0.75)) - axis.share(zoomed.value(0.5)), 0.25 * factor,
                    kShare);
        expect_same_in_share(zoomed.zoomed(share, 1.0 / factor), axis);
        const double by = axes.between(-3.0, 3.0);
        const Axis moved = axis.moved(by);
        ASSERT_NEAR(axis.share(moved.value(0.4)), 0.4 + by, kShare) << text_of(axis);
        expect_same_in_share(moved.moved(-by), axis);
    }
}

TEST(Axis, AnyNumberOfNotchesAndMovesLeavesAUsableAxis) {
    RandomAxes axes;
    for (int i = 0; i < 20; ++i) {
        for (const double factor : {0.8, 1.25}) {
            for (const bool is_logarithmic : {false, true}) {
                Axis axis = is_logarithmic ? axes.logarithmic() : axes.linear();
                const std::string before = text_of(axis);
                const double share = axes.between(0.0, 1.0);
                for (int notch = 0; notch < 4000; ++notch) {
                    axis = axis.zoomed(share, factor);
                    ASSERT_TRUE(is_usable(axis)) << before << ", notch " << notch << ", by "
                                                 << factor << ": " << text_of(axis);
                }
                EXPECT_LT(ticks_of(axis, 8).size(), 6000U) << before;
                EXPECT_TRUE(is_usable(axis.zoomed(share, 1.0 / factor))) << before; // back again
            }
        }
    }
    for (const double by : {-1.0, 1.0}) {
        for (Axis axis : {Axis{1e-5, 1.0, true}, Axis{0.0, 1.0}}) {
            for (int i = 0; i < 200; ++i) {
                axis = axis.moved(by);
                ASSERT_TRUE(is_usable(axis)) << "move " << i << ": " << text_of(axis);
            }
            EXPECT_LT(ticks_of(axis, 8).size(), 6000U);
        }
    }
}

TEST(RoundUp, IsTheNextOfOneTwoAndFive) {
    EXPECT_DOUBLE_EQ(round_up(1.0), 1.0);
    EXPECT_DOUBLE_EQ(round_up(0.021), 0.05);
    EXPECT_DOUBLE_EQ(round_up(5.1), 10.0);
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const double value = std::pow(10.0, axes.between(-12.0, 12.0));
        const double round = round_up(value);
        ASSERT_TRUE(is_round(round)) << value << ": " << round;
        EXPECT_GE(round, value * (1.0 - 1e-8));
        EXPECT_LT(round, 2.5 * value * (1.0 + 1e-8));
        EXPECT_DOUBLE_EQ(round_up(round), round);
    }
}

TEST(RoundAxis, HoldsTheValuesAndNotMuchMore) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const Axis values = axes.linear();
        const Axis axis = round_axis(values.from, values.to);
        const double length = values.to - values.from;
        ASSERT_LE(axis.from, values.from + 1e-8 * length) << text_of(values);
        ASSERT_GE(axis.to, values.to - 1e-8 * length) << text_of(values);
        EXPECT_LT(axis.to - axis.from, 1.7 * length) << text_of(values);
        EXPECT_FALSE(axis.is_logarithmic);
    }
    EXPECT_EQ(round_axis(0.0, 4.0), (Axis{0.0, 4.0}));
    for (const double value : {0.0, 3.0, -3.0, 1e-9, 1e9, -2e-5}) { // it surrounds a single one
        const Axis axis = round_axis(value, value);
        EXPECT_LT(axis.from, value);
        EXPECT_GT(axis.to, value);
        EXPECT_FALSE(ticks_of(axis, 8).empty()) << value;
    }
    // As from the extremes of no numbers, which are NaN, or of an empty range.
    for (const auto &[least, greatest] : std::vector<std::pair<double, double>>{
             {kNaN, kNaN}, {kInfinity, -kInfinity}, {1.0, kInfinity}, {-kInfinity, 1.0}}) {
        EXPECT_EQ(round_axis(least, greatest), (Axis{0.0, 1.0}));
    }
}

/// Labels are distinct, and read back as the values; @return how many there are.
std::size_t expect_labels(const Axis &axis, const std::vector<Tick> &ticks) {
    std::set<std::string> labels;
    for (const Tick &tick : labelled(ticks)) {
        EXPECT_TRUE(labels.insert(tick.label).second) << text_of(axis) << ": twice " << tick.label;
        EXPECT_NEAR(axis.share(std::stod(tick.label)), axis.share(tick.value), 1e-6)
            << text_of(axis) << ": " << tick.label;
        EXPECT_FALSE(tick.value == 0.0 && tick.label.front() == '-') << tick.label;
    }
    return labels.size();
}

TEST(Ticks, OfALinearAxisAreOnItRoundAndEvenlySpaced) {
    RandomAxes axes;
    int zeros = 0;
    for (int i = 0; i < kAxes; ++i) {
        Axis axis = axes.linear();
        if (i % 2 == 0) { // around 0
            axis = {-axes.between(0.0, 1.0) * (axis.to - axis.from), axis.to - axis.from};
        }
        const int most = axes.whole_number(2, 20);
        const std::vector<Tick> ticks = ticks_of(axis, most);
        ASSERT_LE(ticks.size(), static_cast<std::size_t>(most) + 1) << text_of(axis);
        if (most >= 5) {
            ASSERT_GE(ticks.size(), 2U) << text_of(axis) << ", " << most;
        }
        EXPECT_EQ(expect_labels(axis, ticks), ticks.size());
        for (std::size_t j = 0; j < ticks.size(); ++j) {
            ASSERT_GE(axis.share(ticks[j].value), -kShare) << text_of(axis);
            ASSERT_LE(axis.share(ticks[j].value), 1.0 + kShare) << text_of(axis);
            EXPECT_FALSE(ticks[j].is_minor);
            zeros += ticks[j].value == 0.0 ? 1 : 0;
            if (j == 0) {
                continue;
            }
            const double step = ticks[1].value - ticks[0].value;
            ASSERT_GT(step, 0.0);
            EXPECT_TRUE(is_round(step)) << text_of(axis) << ": " << step;
            EXPECT_NEAR((ticks[j].value - ticks[j - 1].value) / step, 1.0, 1e-6);
            const double multiple = ticks[j].value / step;
            EXPECT_NEAR(multiple, std::round(multiple), 1e-6 + 1e-9 * std::abs(multiple));
        }
    }
    EXPECT_GT(zeros, kAxes / 4);
    for (const Axis &axis : {Axis{1.0, 1.0}, Axis{1.0, 0.0}, Axis{kNaN, 1.0}}) {
        EXPECT_TRUE(ticks_of(axis, 8).empty());
    }
}

TEST(Ticks, OfALogarithmicAxisAreDigitsOfPowersOfTenAndSomeAreLabelled) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const Axis axis = axes.logarithmic();
        const int most = axes.whole_number(5, 20);
        const std::vector<Tick> ticks = ticks_of(axis, most);
        double before = 0.0;
        for (const Tick &tick : ticks) {
            ASSERT_GE(axis.share(tick.value), -1e-6) << text_of(axis);
            ASSERT_LE(axis.share(tick.value), 1.0 + 1e-6) << text_of(axis);
            ASSERT_GT(tick.value, before);
            before = tick.value;
            if (axis.to > 10.0 * axis.from) { // else round values of any step
                const double power = std::pow(10.0, std::floor(std::log10(tick.value) + 1e-9));
                EXPECT_NEAR(tick.value / power, std::round(tick.value / power), 1e-6);
                EXPECT_EQ(tick.is_minor, std::lround(tick.value / power) != 1);
            }
        }
        const std::size_t labels = expect_labels(axis, ticks);
        EXPECT_LE(labels, static_cast<std::size_t>(most) + 1) << text_of(axis);
        EXPECT_GE(labels, 1U) << text_of(axis);
    }
    // Zoomed into a part of a decade.
    for (const Axis &axis : {Axis{2.1, 4.9, true}, Axis{5.5, 9.5, true}, Axis{1.05, 1.9, true}}) {
        EXPECT_FALSE(labelled(ticks_of(axis, 8)).empty()) << text_of(axis);
    }
}

TEST(NumberAtStep, TellsNeighboursApartWithNoMoreDigits) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const double step = round_up(std::pow(10.0, axes.between(-12.0, 9.0)));
        const int multiple = axes.whole_number(-100'000, 100'000);
        const double value = multiple * step;
        const std::string text = number_at_step(value, step);
        EXPECT_NE(text, number_at_step((multiple + 1) * step, step)) << value << ", " << step;
        EXPECT_NEAR(std::stod(text), value, 1e-3 * step) << text;
    }
    EXPECT_EQ(number_at_step(0.25, 0.05), "0.25");
    EXPECT_EQ(number_at_step(3.0, 0.5), "3.0");
    EXPECT_EQ(number_at_step(120.0, 20.0), "120");
    EXPECT_EQ(number_at_step(-0.0, 0.1), "0.0");
    EXPECT_EQ(number_at_step(2e7, 1e7), "2e+07");
    EXPECT_EQ(number_at_step(2.5e-5, 5e-6), "2.5e-05");
}

TEST(PlotArea, PlacesAndValuesAreInversesAndUpIsUp) {
    RandomAxes axes;
    for (int i = 0; i < kAxes; ++i) {
        const PlotArea area{{{30.0F, 40.0F}, {500.0F, 200.0F}}, axes.any(), axes.any()};
        const auto x = static_cast<float>(axes.between(30.0, 530.0));
        const auto y = static_cast<float>(axes.between(40.0, 240.0));
        EXPECT_NEAR(area.place_x(area.x_at(x)), x, 1e-3F);
        EXPECT_NEAR(area.place_y(area.y_at(y)), y, 1e-3F);
        EXPECT_LT(area.place_y(area.y.to), area.place_y(area.y.from));
        EXPECT_LT(area.place_x(area.x.from), area.place_x(area.x.to));
    }
}

} // namespace
} // namespace springdrive::app
