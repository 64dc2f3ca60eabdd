// Covers app/plots/plot.cpp, and how stiffness_curves.cpp draws, drawn into pictures.
#include "app/plots/plot.h"

#include "app/plots/channels.h"
#include "app/plots/plot_panel.h"
#include "app/plots/stiffness_curves.h"
#include "tests/support/devices.h"
#include "tests/support/imgui_frame.h"
#include "tests/support/plots.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::channel;
using testing::MadeUpStore;

using PlotTest = testing::ImGuiFrame;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kTooMuch = std::numeric_limits<double>::infinity();

const Rectangle kPlace{{100.0F, 50.0F}, {640.0F, 360.0F}};

PlotSettings plot_of(PlotKind kind, const std::vector<std::string_view> &names) {
    PlotSettings settings;
    settings.kind = kind;
    for (const std::string_view name : names) {
        settings.channels.push_back(channel(name));
    }
    return settings;
}

PlotSettings plot_of_all(PlotKind kind) {
    PlotSettings settings;
    settings.kind = kind;
    for (std::size_t i = 0; i < session::channels().size(); ++i) {
        settings.channels.push_back(i);
    }
    return settings;
}

/// Records lines; everything else is nothing.
class LineCanvas final : public Canvas {
public:
    void polyline(std::span<const ImVec2> points, const Stroke &stroke) override {
        lines.push_back({{points.begin(), points.end()}, stroke});
    }
    void fill(const Rectangle & /*where*/, const ImVec4 & /*colour*/) override {}
    void dot(ImVec2 /*middle*/, float /*radius*/, const ImVec4 & /*colour*/) override {}
    void text(ImVec2 /*corner*/, const ImVec4 & /*colour*/, std::string_view /*text*/) override {}
    void clip(const Rectangle & /*where*/) override {}
    void unclip() override {}

    struct Line {
        std::vector<ImVec2> points;
        Stroke stroke;
    };
    std::vector<Line> lines;
};

struct Drawn {
    PlotArea area;
    std::vector<LineCanvas::Line> lines;
    std::vector<ImVec2> curve; ///< of the only channel; grids have thinner lines

    [[nodiscard]] ImVec2 highest() const {
        return *std::ranges::min_element(curve, {}, &ImVec2::y);
    }
};

Drawn drawn(const PlotSettings &settings, const MadeUpStore &of, const signals::TimeWindow &window,
            double servo_hz = 1000.0) {
    LineCanvas canvas;
    PlotCache cache;
    Drawn result;
    result.area = draw_plot(canvas, kPlace, settings, {of.store(), servo_hz, window, 0.0}, cache);
    for (const LineCanvas::Line &line : canvas.lines) {
        if (line.stroke.width > 1.0F) {
            result.curve.insert(result.curve.end(), line.points.begin(), line.points.end());
        }
    }
    result.lines = std::move(canvas.lines);
    return result;
}

/// Rows in which a channel has that value.
void add(MadeUpStore &made, int rows, std::string_view name, auto &&value_of) {
    for (int row = 0; row < rows; ++row) {
        made[name] = value_of(row);
        made.add();
    }
}

// --- whatever channels hold ---

struct MadeUpCase {
    const char *what;
    MadeUpStore made;
};

/// Of each channel another sine, of very different sizes.
void make_waves(MadeUpStore &made, int row) {
    for (std::size_t i = 0; i < made.values().size(); ++i) {
        const auto phase = static_cast<double>(i);
        made.values()[i] = std::sin(0.01 * row + phase) * std::pow(10.0, std::fmod(phase, 13) - 6);
    }
}

std::vector<MadeUpCase> made_up_cases() {
    std::vector<MadeUpCase> cases;
    cases.push_back({"nothing", MadeUpStore()});
    for (const double value : {0.0, kNothing, kTooMuch, -kTooMuch, 1e30, 1e-30}) {
        cases.push_back({"constant", MadeUpStore()});
        cases.back().made.set_all(value);
        cases.back().made.add(3000);
    }
    cases.push_back({"one tick", MadeUpStore()});
    make_waves(cases.back().made, 0);
    cases.back().made.add();
    for (const bool has_gaps : {false, true}) {
        cases.push_back({has_gaps ? "waves with gaps and infinities" : "waves", MadeUpStore()});
        MadeUpStore &made = cases.back().made;
        for (int row = 0; row < 3000; ++row) {
            make_waves(made, row);
            if (has_gaps) {
                const auto at = static_cast<std::size_t>(row);
                const std::size_t count = made.values().size();
                made.values()[at % count] = kNothing;
                made.values()[(at + 7) % count] = kTooMuch;
                made.values()[(at + 9) % count] = -kTooMuch;
            }
            made.add();
        }
    }
    return cases;
}

std::string error_about_picture(const PlotSettings &settings, const MadeUpStore &of,
                                const signals::TimeWindow &window,
                                const Rectangle &where = kPlace) {
    SvgCanvas canvas(where, 1.0F);
    PlotCache cache;
    static_cast<void>(draw_plot(canvas, where, settings, {of.store(), 1000.0, window, 0.0}, cache));
    return testing::error_about_xml(canvas.svg());
}

TEST_F(PlotTest, EveryPlotOfAnyDataAndAnyChannelsIsAWellFormedPicture) {
    PlotPanelState state;
    const std::vector<MadeUpCase> cases = made_up_cases();
    for (const MadeUpCase &known : cases) {
        for (std::size_t set = 0; set < kPlotSetLabels.size(); ++set) {
            choose_plot_set(state, set);
            for (const Plot &plot : state.plots) {
                for (const auto &window : std::vector<signals::TimeWindow>{
                         {-2.0, 3.0}, {1.0002, 1.0004}, {-10.0, -5.0}, {10.0, 15.0}}) {
                    EXPECT_EQ(error_about_picture(plot.settings, known.made, window), "")
                        << known.what << ", " << kPlotSetLabels[set] << ", " << window.from_s;
                }
            }
        }
    }
    for (const PlotKind kind :
         {PlotKind::time, PlotKind::spectrum, PlotKind::xy, PlotKind::polar, PlotKind::histogram}) {
        const MadeUpStore &made = cases.back().made;
        const Rectangle tiny{{0.0F, 0.0F}, {4.0F, 3.0F}};
        EXPECT_EQ(error_about_picture(plot_of(kind, {}), made, {0.0, 3.0}), "");
        EXPECT_EQ(error_about_picture(plot_of(kind, {}), made, {0.0, 3.0}, tiny), "");
        EXPECT_EQ(error_about_picture(plot_of_all(kind), made, {0.0, 3.0}), "");
    }
}

// --- over time ---

TEST_F(PlotTest, NoPeakIsLostHoweverNarrowThePlot) {
    MadeUpStore made;
    add(made, 20'000, "force_N", [](int row) {
        return row == 4321 ? -3.0 : row == 12'322 ? 7.0 : 1.0;
    });
    const Drawn plot = drawn(plot_of(PlotKind::time, {"force_N"}), made, {0.0, 20.0});
    ASSERT_FALSE(plot.curve.empty());
    const auto [top, bottom] = std::ranges::minmax(plot.curve, {}, &ImVec2::y);
    EXPECT_NEAR(plot.area.y_at(top.y), 7.0, 0.01);
    EXPECT_NEAR(plot.area.y_at(bottom.y), -3.0, 0.01);
    EXPECT_LT(plot.curve.size(), 3000U);
}

TEST_F(PlotTest, ARampIsDrawnInOrderAndPassesBetweenTicksOutsideOfTheWindow) {
    MadeUpStore made;
    add(made, 20'000, "tip_x_m", [](int row) { return 1e-6 * row; });
    for (const bool in_si : {true, false}) {
        PlotSettings settings = plot_of(PlotKind::time, {"tip_x_m"});
        settings.in_si = in_si;
        const Drawn plot = drawn(settings, made, {0.0, 19.999});
        ASSERT_GT(plot.curve.size(), 100U);
        for (std::size_t i = 1; i < plot.curve.size(); ++i) {
            ASSERT_LE(plot.curve[i].y, plot.curve[i - 1].y + 1e-3F)
                << "point " << i << ", " << in_si;
        }
        // A span of a tenth of a tick, and one that begins and ends within a tick.
        for (const double to_s : {1.0005, 1.0205}) {
            const Drawn part = drawn(settings, made, {1.0004, to_s});
            ASSERT_GE(part.curve.size(), 2U) << to_s;
            const auto [left, right] = std::ranges::minmax(part.curve, {}, &ImVec2::x);
            EXPECT_LE(left.x, part.area.where.corner.x) << to_s;
            EXPECT_GE(right.x, part.area.where.end().x) << to_s;
        }
    }
}

/// The axis, in degrees, of an angle that alternates between two values.
Axis axis_of_angles(double min_rad, double greatest_rad) {
    MadeUpStore made;
    add(made, 1000, "transpose_measured_rad",
        [&](int row) { return row % 2 == 0 ? min_rad : greatest_rad; });
    return drawn(plot_of(PlotKind::time, {"transpose_measured_rad"}), made, {0.0, 1.0}).area.y;
}

TEST_F(PlotTest, AnglesBeyondWhatIsOfInterestDoNotTakeTheAxisFromTheRest) {
    EXPECT_EQ(axis_of_angles(0.0, 0.5).from, 0.0);
    EXPECT_GE(axis_of_angles(0.0, 0.5).to, 28.0);
    EXPECT_GE(axis_of_angles(0.0, 3.0).to, 60.0);
    EXPECT_LE(axis_of_angles(0.0, 3.0).to, 70.0);
    // All of it beyond: still an axis of angles like these.
    EXPECT_GE(axis_of_angles(2.0, 3.0).to, 60.0);
}

TEST_F(PlotTest, EveryUnitStandsAtTheAxis) {
    PlotSettings settings = plot_of(PlotKind::time, {"k_T1_Nm_per_A", "current1_A", "period_s",
                                                     "theta_rate1_rad_per_s", "current2_A"});
    settings.in_si = true;
    EXPECT_EQ(unit_title(settings), "N·m/A, A, s, rad/s");
    settings.in_si = false;
    EXPECT_EQ(unit_title(settings), "N·m/A, mA, µs, °/s");
}

// --- other kinds, and what is visible of them when zoomed ---

TEST_F(PlotTest, PairedPlotsHaveABoundedNumberOfPointsAndMarks) {
    for (const int rows : {15'000, 39'000}) {
        MadeUpStore made(std::size_t{256} << 20);
        add(made, rows, "force_outward_N", [&](int row) {
            made["force_up_N"] = std::sin(0.001 * row);
            made["normal_direction_rad"] = std::sin(1.7 * row);
            made["transpose_error_rad"] = std::cos(2.9 * row);
            return std::cos(0.001 * row);
        });
        const std::size_t points =
            drawn(plot_of(PlotKind::xy, {"force_outward_N", "force_up_N"}), made, {0.0, 50.0})
                .curve.size();
        EXPECT_GT(points, 7'000U) << rows;
        EXPECT_LE(points, 20'000U) << rows;
        EXPECT_LT(drawn(plot_of(PlotKind::xy, {"normal_direction_rad", "transpose_error_rad"}),
                        made, {0.0, 20.0})
                      .lines.size(),
                  2000U);
    }
    MadeUpStore waves;
    for (int row = 0; row < 6000; ++row) {
        make_waves(waves, row);
        waves.add();
    }
    for (const PlotKind kind : {PlotKind::xy, PlotKind::polar}) {
        std::size_t points = 0;
        for (const LineCanvas::Line &line : drawn(plot_of_all(kind), waves, {0.0, 6.0}).lines) {
            points += line.points.size();
        }
        EXPECT_LT(points, 120'000U); // marks of five points included
    }
}

TEST_F(PlotTest, ASineIsAPeakAtItsFrequencyAndAmplitudeWhateverTheServosRateIsNow) {
    MadeUpStore made; // at 1 kHz; in the middle of a bin of a segment of 1024 ticks
    add(made, 8192, "force_N",
        [](int row) { return 1.5 * std::sin(2.0 * std::numbers::pi * 62.5e-3 * row); });
    for (const double servo_hz : {1000.0, 2000.0}) {
        const Drawn plot =
            drawn(plot_of(PlotKind::spectrum, {"force_N"}), made, {0.0, 9.0}, servo_hz);
        EXPECT_NEAR(plot.area.x_at(plot.highest().x) / 62.5, 1.0, 0.01);
        EXPECT_NEAR(plot.area.y_at(plot.highest().y) / 1.5, 1.0, 0.05);
        EXPECT_TRUE(plot.area.x.is_logarithmic);
        EXPECT_TRUE(plot.area.y.is_logarithmic);
    }
}

TEST_F(PlotTest, ASpectrumZoomedToTheRightIsFittedToWhatIsThere) {
    MadeUpStore made;
    add(made, 8192, "force_N", [](int row) {
        return 10.0 * std::sin(2.0 * std::numbers::pi * 31.25e-3 * row) +
               0.02 * std::sin(2.0 * std::numbers::pi * 250e-3 * row);
    });
    PlotSettings settings = plot_of(PlotKind::spectrum, {"force_N"});
    const auto y = [&] { return drawn(settings, made, {0.0, 9.0}).area.y; };
    EXPECT_EQ(y().to, 10.0);
    settings.x = Axis{200.0, 300.0, true};
    EXPECT_EQ(y().to, 0.02);
    settings.y = Axis{1e-3, 1.0, true};
    EXPECT_EQ(y(), *settings.y);
    // Beyond all values, and between two bins.
    settings.y.reset();
    for (const Axis &x : {Axis{1e4, 1e5, true}, Axis{250.1, 250.2, true}}) {
        settings.x = x;
        EXPECT_GT(y().from, 0.0);
        EXPECT_GT(y().to, y().from);
    }
    EXPECT_LT(y().to, 0.1);
}

TEST_F(PlotTest, AnXyPlotZoomedToTheRightIsFittedToWhatIsThere) {
    MadeUpStore made;
    add(made, 1000, "force_outward_N", [&](int row) {
        made["force_up_N"] = row < 500 ? 0.01 * row : 100.0; // to 5 N, then far above
        return 0.01 * row;                                   // 0 to 10 N
    });
    PlotSettings settings = plot_of(PlotKind::xy, {"force_outward_N", "force_up_N"});
    const auto y = [&] { return drawn(settings, made, {0.0, 1.0}).area.y; };
    EXPECT_GE(y().to, 100.0);
    settings.x = Axis{1.0, 4.0};
    EXPECT_LE(y().from, 1.0);
    EXPECT_GE(y().to, 4.0);
    EXPECT_LE(y().to, 5.0);
    // Between two ticks: their values.
    settings.x = Axis{3.0001, 3.0002};
    EXPECT_LE(y().from, 3.0);
    EXPECT_GE(y().to, 3.01);
    EXPECT_LE(y().to, 6.0);
}

TEST_F(PlotTest, AHistogramCountsTheTicksOfTheWindowAndFitsWhatIsThere) {
    MadeUpStore made;
    add(made, 10'000, "period_s", [](int row) { return row % 20 == 0 ? 1.2e-3 : 1e-3; });
    PlotSettings settings = plot_of(PlotKind::histogram, {"period_s"});
    const Drawn part = drawn(settings, made, {1.0, 1.9995});
    EXPECT_NEAR(part.area.y_at(part.highest().y), 950.0, 10.0);
    EXPECT_LE(part.area.x.from, 1000.0); // µs
    EXPECT_GE(part.area.x.to, 1200.0);
    EXPECT_EQ(drawn(settings, made, {0.0, 9.9995}).area.y.to, 10'000.0);
    settings.x = Axis{1100.0, 1300.0};
    EXPECT_EQ(drawn(settings, made, {0.0, 9.9995}).area.y.to, 500.0);
}

TEST_F(PlotTest, APolarPlotShowsTheRangeThatItIsZoomedTo) {
    MadeUpStore made;
    made["normal_direction_rad"] = 0.5;
    made["force_N"] = 3.0;
    made.add(100);
    PlotSettings settings = plot_of(PlotKind::polar, {"normal_direction_rad", "force_N"});
    const Axis chosen = drawn(settings, made, {0.0, 1.0}).area.y;
    EXPECT_GE(chosen.to, 3.0);
    EXPECT_DOUBLE_EQ(chosen.from, -chosen.to);
    settings.y = Axis{-0.7, 0.7};
    const PlotArea zoomed = drawn(settings, made, {0.0, 1.0}).area;
    EXPECT_EQ(zoomed.y, *settings.y);
    EXPECT_EQ(zoomed.x, *settings.y);
    EXPECT_EQ(zoomed.where.size.x, zoomed.where.size.y);
}

// --- looks that need no dashes ---

/// What is drawn in the colour of a channel, apart from its colour: widths of lines, their dashes,
/// and their numbers of points.
std::set<std::string> looks(const std::vector<LineCanvas::Line> &lines, std::size_t of) {
    const ImVec4 &requested = look_of(of).stroke.colour;
    std::set<std::string> found;
    for (const auto &[points, stroke] : lines) {
        const ImVec4 &colour = stroke.colour;
        if (colour.x == requested.x && colour.y == requested.y && colour.z == requested.z) {
            found.insert(fmt::format("{:.1f} {} {}", stroke.width, static_cast<int>(stroke.dash),
                                     std::min<std::size_t>(points.size(), 6)));
        }
    }
    return found;
}

TEST_F(PlotTest, AnXyPlotTellsIdealFromMeasuredAsItsLegendDoes) {
    MadeUpStore made;
    add(made, 1000, "normal_direction_rad", [&](int row) {
        made["transpose_error_rad"] = made["transpose_measured_rad"] = std::cos(0.02 * row);
        return std::sin(0.01 * row);
    });
    for (const bool is_ideal : {true, false}) {
        const std::string_view name = is_ideal ? "transpose_error_rad" : "transpose_measured_rad";
        const auto in_plot = looks(
            drawn(plot_of(PlotKind::xy, {"normal_direction_rad", name}), made, {0.0, 1.0}).lines,
            channel(name));
        LineCanvas legend;
        draw_sample(legend, {{0.0F, 0.0F}, 30.0F}, look_of(channel(name)).stroke, PlotKind::xy);
        // Crosses: lines of two points.
        EXPECT_EQ(in_plot.contains("1.0 0 2"), is_ideal);
        EXPECT_EQ(looks(legend.lines, channel(name)).contains("1.0 0 2"), is_ideal);
    }
}

TEST_F(PlotTest, CurvesOfStiffnessAreGreyAndDifferInDashAndLightness) {
    loops::SpringDrive drive;
    drive.motor = testing::phantom_motor();
    StiffnessCurves curves;
    curves.update(drive);
    LineCanvas canvas;
    static_cast<void>(curves.draw(canvas, kPlace, plot_of(PlotKind::stiffness, {})));
    std::erase_if(canvas.lines, [](const LineCanvas::Line &line) { // grids
        return line.stroke.width <= 1.0F;
    });
    ASSERT_EQ(canvas.lines.size(), 2U);
    const Stroke &first = canvas.lines[0].stroke;
    const Stroke &second = canvas.lines[1].stroke;
    EXPECT_NE(first.dash, second.dash);
    EXPECT_GT(std::abs(first.colour.x - second.colour.x), 0.1F);
    for (const ImVec4 &colour : {first.colour, second.colour}) {
        // Unlike the colours of the maps and the force.
        const auto [least, greatest] = std::minmax({colour.x, colour.y, colour.z});
        EXPECT_LT(greatest - least, 0.12F);
    }
}

// --- room ---

TEST_F(PlotTest, AxesKeepToTheirPlaceHoweverSmallItIs) {
    for (int i = 0; i < 13; ++i) {
        for (int j = 0; j < 13; ++j) {
            const Rectangle place{
                {100.0F, 50.0F},
                {static_cast<float>(std::pow(1.69, i)), static_cast<float>(std::pow(1.69, j))}};
            LineCanvas canvas;
            const PlotArea area = draw_axes(canvas, place, {-1e-4, 1e-4}, {0.0, 1e6}, "s", "N");
            EXPECT_GE(area.where.corner.x, place.corner.x);
            EXPECT_GE(area.where.corner.y, place.corner.y);
            EXPECT_GE(area.where.size.x, 1.0F);
            EXPECT_GE(area.where.size.y, 1.0F);
            EXPECT_LE(area.where.end().x, place.end().x + 0.01F);
            EXPECT_LE(area.where.end().y, place.end().y + 0.01F);
            for (const LineCanvas::Line &line : canvas.lines) {
                for (const ImVec2 &point : line.points) {
                    EXPECT_LE(point.x, place.end().x + 0.01F);
                    EXPECT_LE(point.y, place.end().y + 0.01F);
                }
            }
        }
    }
}

} // namespace
} // namespace springdrive::app
