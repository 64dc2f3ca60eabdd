// Covers the axes in app/plots/canvas.cpp.
#include "app/plots/canvas.h"

#include "tests/support/imgui_frame.h"
#include "tests/support/plots.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <imgui.h>

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

using testing::error_about_xml;
using testing::XmlCheck;

using CanvasTest = testing::ImGuiFrame;

const Rectangle kPicture{{100.0F, 50.0F}, {640.0F, 360.0F}};

// --- SVG ---

TEST_F(CanvasTest, SvgOfEverythingIsWellFormed) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<float> place(-1000.0F, 2000.0F);
    std::uniform_real_distribution<float> share(0.0F, 1.0F);
    SvgCanvas canvas(kPicture, 1.5F);
    for (int i = 0; i < 200; ++i) {
        const ImVec4 colour{share(random), share(random), share(random), share(random)};
        std::vector<ImVec2> line(static_cast<std::size_t>(i % 7));
        for (ImVec2 &point : line) {
            point = {place(random), place(random)};
        }
        canvas.clip({{place(random), place(random)}, {50.0F, 60.0F}});
        canvas.polyline(line, {colour, 2.0F, static_cast<Dash>(i % 3)});
        canvas.fill({{place(random), place(random)}, {3.0F, 4.0F}}, colour);
        canvas.dot({place(random), place(random)}, 2.0F, colour);
        canvas.text({place(random), place(random)}, colour, "K_θ < 25° & \"e_W\" > 'µs'");
        canvas.unclip();
    }
    const std::string svg = canvas.svg();
    XmlCheck check(svg);
    EXPECT_EQ(check.error(), "");
    EXPECT_GT(check.elements(), 1000);
    EXPECT_NE(svg.find("K_θ &lt; 25° &amp; \"e_W\" &gt; 'µs'"), std::string::npos);
    EXPECT_EQ(error_about_xml(SvgCanvas(kPicture, 1.0F).svg()), "");
    // Its size, and places from its corner on.
    SvgCanvas line(kPicture, 1.0F);
    line.line(kPicture.corner, kPicture.end(), {{1.0F, 0.0F, 0.0F, 0.5F}, 1.0F});
    for (const char *part :
         {"width=\"640\"", "height=\"360\"", "viewBox=\"0 0 640 360\"", "0.00,0.00 640.00,360.00",
          "stroke=\"rgb(255,0,0)\"", "stroke-opacity=\"0.50\""}) {
        EXPECT_NE(line.svg().find(part), std::string::npos) << part << " in " << line.svg();
    }
}

// --- the window ---

/// Draws without smoothing, so that the vertices are the corners of what is drawn, or with it.
class Drawing {
public:
    explicit Drawing(float scale, bool is_smooth = false)
        : list_(ImGui::GetDrawListSharedData()), canvas_(list_, scale) {
        list_._ResetForNewFrame();
        if (!is_smooth) {
            list_.Flags = ImDrawListFlags_None;
        }
        list_.Flags |= ImDrawListFlags_AllowVtxOffset; // as in the window
        list_.PushTextureID(ImGui::GetIO().Fonts->TexID);
        list_.PushClipRectFullScreen();
    }

    ScreenCanvas &canvas() { return canvas_; }
    [[nodiscard]] float top() const { return y_range().first; }
    [[nodiscard]] float bottom() const { return y_range().second; }
    [[nodiscard]] float height() const { return bottom() - top(); }
    /// Begins and ends of the pieces of a horizontal line.
    [[nodiscard]] std::vector<float> ends() const {
        std::vector<float> places;
        for (const ImDrawVert &vertex : list_.VtxBuffer) {
            places.push_back(vertex.pos.x);
        }
        std::ranges::sort(places);
        const auto same = [](float a, float b) { return std::abs(a - b) < 1e-3F; };
        places.erase(std::unique(places.begin(), places.end(), same), places.end());
        return places;
    }
    /// Each quad of four vertices is as long as its first edge.
    [[nodiscard]] double drawn_length() const {
        double length = 0.0;
        for (int i = 0; i + 3 < list_.VtxBuffer.Size; i += 4) {
            const ImVec2 a = list_.VtxBuffer[i].pos;
            const ImVec2 b = list_.VtxBuffer[i + 1].pos;
            length += std::hypot(b.x - a.x, b.y - a.y);
        }
        return length;
    }
    /// The longest side of a triangle, parallel to an axis.
    [[nodiscard]] float longest_side() const {
        float longest = 0.0F;
        for (const ImDrawCmd &command : list_.CmdBuffer) {
            const auto vertex = [&](unsigned i) {
                const auto index = list_.IdxBuffer[static_cast<int>(command.IdxOffset + i)];
                return list_.VtxBuffer[static_cast<int>(command.VtxOffset + index)].pos;
            };
            for (unsigned i = 0; i < command.ElemCount; i += 3) {
                for (const unsigned next : {i + 1, i + 2}) {
                    longest = std::max({longest, std::abs(vertex(next).x - vertex(i).x),
                                        std::abs(vertex(next).y - vertex(i).y)});
                }
            }
        }
        return longest;
    }
    [[nodiscard]] int vertices() const { return list_.VtxBuffer.Size; }

private:
    [[nodiscard]] std::pair<float, float> y_range() const {
        const auto [top, bottom] = std::ranges::minmax(
            list_.VtxBuffer, {}, [](const ImDrawVert &vertex) { return vertex.pos.y; });
        return {top.pos.y, bottom.pos.y};
    }

    ImDrawList list_;
    ScreenCanvas canvas_;
};

const ImVec4 kWhite{1.0F, 1.0F, 1.0F, 1.0F};

/// ImGui normalises with the processor's estimate of a reciprocal root: within 1.5 × 2⁻¹² of it,
/// and how near depends on the processor.
constexpr float kReciprocalRoot = 1.5F / 4096.0F;

TEST_F(CanvasTest, LineWidthsFollowTheScale) {
    for (const float scale : {1.0F, 1.5F, 2.0F, 4.0F}) {
        for (const float width : {1.0F, 1.6F, 2.0F}) {
            Drawing drawing(scale);
            drawing.canvas().line({10.0F, 100.0F}, {200.0F, 100.0F}, {kWhite, width});
            EXPECT_NEAR(drawing.height(), scale * width, kReciprocalRoot * scale * width);
        }
        Drawing dot(scale);
        dot.canvas().dot({100.0F, 100.0F}, 3.0F, kWhite);
        EXPECT_NEAR(dot.height(), 6.0F * scale, 0.5F * scale);
    }
}

TEST_F(CanvasTest, DashesAndDotsHaveTheLengthsOfTheSvg) {
    struct Case {
        float scale;
        float length;
        Stroke stroke;
        std::vector<float> ends;
    };
    // 6 widths drawn and 4 not; or 1.5 and 2.5.
    for (const Case &known :
         {Case{1.0F, 200.0F, {kWhite, 2.0F}, {0.0F, 200.0F}},
          Case{
              1.0F, 50.0F, {kWhite, 2.0F, Dash::dashed}, {0.0F, 12.0F, 20.0F, 32.0F, 40.0F, 50.0F}},
          Case{2.0F, 14.0F, {kWhite, 1.0F, Dash::dotted}, {0.0F, 3.0F, 8.0F, 11.0F}}}) {
        Drawing drawing(known.scale);
        drawing.canvas().line({0.0F, 9.0F}, {known.length, 9.0F}, known.stroke);
        const std::vector<float> ends = drawing.ends();
        ASSERT_EQ(ends.size(), known.ends.size());
        for (std::size_t i = 0; i < ends.size(); ++i) {
            EXPECT_NEAR(ends[i], known.ends[i], 1e-3F);
        }
    }
    SvgCanvas svg(kPicture, 1.0F);
    svg.line({0.0F, 9.0F}, {50.0F, 9.0F}, {kWhite, 2.0F, Dash::dashed});
    EXPECT_NE(svg.svg().find("stroke-dasharray=\"12.0 8.0\""), std::string::npos) << svg.svg();
}

TEST_F(CanvasTest, DashesGoOnAroundCorners) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<float> place(0.0F, 500.0F);
    for (int i = 0; i < 50; ++i) {
        std::vector<ImVec2> line(20);
        double length = 0.0;
        for (std::size_t j = 0; j < line.size(); ++j) {
            line[j] = {place(random), place(random)};
            length +=
                j == 0 ? 0.0 : std::hypot(line[j].x - line[j - 1].x, line[j].y - line[j - 1].y);
        }
        Drawing drawing(1.0F);
        drawing.canvas().polyline(line, {kWhite, 1.0F, Dash::dashed});
        // 6 of every 10, and what is left at the end.
        const double rest = std::fmod(length, 10.0);
        const double expected = 6.0 * std::floor(length / 10.0) + std::min(rest, 6.0);
        EXPECT_NEAR(drawing.drawn_length(), expected, 0.1) << "of " << length;
    }
}

TEST_F(CanvasTest, APeakIsNotDrawnHigherThanItIs) {
    for (const float width : {1.0F, 1.6F, 2.0F}) {
        for (const float scale : {1.0F, 2.0F}) {
            for (const float height : {2.0F, 10.0F, 30.0F, 100.0F}) {
                // Up and down from pixel to pixel, as a noisy channel is.
                std::vector<ImVec2> line(200);
                for (std::size_t i = 0; i < line.size(); ++i) {
                    line[i] = {10.0F + static_cast<float>(i),
                               100.0F - (i % 2 == 0 ? height : 0.0F)};
                }
                Drawing drawing(scale, true);
                drawing.canvas().polyline(line, {kWhite, width});
                const float margin = scale * width + 1.5F; // with the smooth edge
                EXPECT_GE(drawing.top(), 100.0F - height - margin) << width << " at " << scale;
                EXPECT_LE(drawing.bottom(), 100.0F + margin) << width << " at " << scale;
            }
        }
    }
}

TEST_F(CanvasTest, ALongLineIsNotConnectedWhereItIsNot) {
    // Around a circle, again and again, in steps of less than a pixel.
    std::vector<ImVec2> line(60'000);
    for (std::size_t i = 0; i < line.size(); ++i) {
        const float angle = 0.002F * static_cast<float>(i % 31'416);
        line[i] = {400.0F + 300.0F * std::cos(angle), 350.0F + 300.0F * std::sin(angle)};
    }
    for (const float width : {1.0F, 1.6F, 2.0F}) {
        Drawing drawing(1.0F, true);
        drawing.canvas().polyline(line, {kWhite, width});
        EXPECT_LT(drawing.longest_side(), 10.0F) << width;
    }
}

TEST_F(CanvasTest, ALineOfOnePointOrNoneIsNothing) {
    Drawing drawing(1.0F);
    const std::vector<ImVec2> point{{5.0F, 5.0F}};
    for (const Dash dash : {Dash::solid, Dash::dashed, Dash::dotted}) {
        drawing.canvas().polyline({}, {kWhite, 1.0F, dash});
        drawing.canvas().polyline(point, {kWhite, 1.0F, dash});
    }
    EXPECT_EQ(drawing.vertices(), 0);
}

} // namespace
} // namespace springdrive::app
