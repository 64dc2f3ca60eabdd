// Covers what a person does with the plots: app/plots.
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/plots.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {
namespace {

using testing::Point;
using testing::Report;
using testing::ShownWindow;
using testing::WindowSize;

/// Drawn faster than a larger one.
constexpr WindowSize kWindow{900, 560, 1.0};

/// What a plot shows.
struct ShownPlot {
    std::string id;
    std::string channels;
    double x_from, x_to, y_from, y_to;
    double left, top, width, height; ///< of the area within its axes
    bool is_live;

    [[nodiscard]] double length() const { return x_to - x_from; }
    [[nodiscard]] Point point(double x_share, double y_share = 0.5) const {
        return {static_cast<float>(left + x_share * width),
                static_cast<float>(top + y_share * height)};
    }
    /// What stands at a place in the window.
    [[nodiscard]] double x_at(const Point &point) const {
        return x_from + (point.x - left) / width * length();
    }
};

/// JSON has no infinities and NaN.
double number_of(const nlohmann::json &value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

ShownPlot plot_of(const nlohmann::json &item) {
    const auto number = [&item](const char *name) {
        return number_of(item.at("numbers").at(name));
    };
    return {item.at("id"),        item.at("value"),      number("x_from"),        number("x_to"),
            number("y_from"),     number("y_to"),        number("area_x"),        number("area_y"),
            number("area_width"), number("area_height"), number("is_live") != 0.0};
}

std::vector<ShownPlot> plots_of(const Report &report) {
    std::vector<ShownPlot> plots;
    for (const auto &item : report.all().at("items")) {
        if (item.at("kind") == "plot") {
            plots.push_back(plot_of(item));
        }
    }
    return plots;
}

ShownPlot first_plot(ShownWindow &window) {
    const std::vector<ShownPlot> plots = plots_of(window.look());
    EXPECT_FALSE(plots.empty());
    return plots.empty() ? ShownPlot{} : plots.front();
}

void expect_same_x(const ShownPlot &a, const ShownPlot &b) {
    EXPECT_EQ(a.x_from, b.x_from);
    EXPECT_EQ(a.x_to, b.x_to);
}

void expect_it_stays(ShownWindow &window, const std::string &what) {
    const ShownPlot before = first_plot(window);
    EXPECT_FALSE(before.is_live) << what;
    window.let_pass(0.1);
    const ShownPlot after = first_plot(window);
    EXPECT_FALSE(after.is_live) << what;
    expect_same_x(before, after);
    EXPECT_EQ(before.y_from, after.y_from) << what;
    EXPECT_EQ(before.y_to, after.y_to) << what;
}

/// A folder with a hand that touches the plate from 1.8 s on, each two seconds for 0.7 s.
std::filesystem::path folder_with_touches(const std::string &name) {
    std::filesystem::path folder = testing::fresh_folder(name);
    std::ofstream path(folder / "touches.csv");
    path << "t,x,y,z\n0,0,0.03,0\n";
    for (int i = 1; i < 60; ++i) {
        path << 2 * i - 0.5 << ",0,0.03,0\n"
             << 2 * i - 0.2 << ",0,-0.01,0\n"
             << 2 * i + 0.5 << ",0,-0.01,0\n"
             << 2 * i + 0.8 << ",0,0.03,0\n";
    }
    return folder;
}

std::vector<std::string> touching(const std::filesystem::path &folder) {
    return {"--scene", testing::assets() / "scenes/plate.gltf", "--path", folder / "touches.csv"};
}

/// By a click beside it, where there is nothing to click on.
void close_menu(ShownWindow &window) {
    const Point title = window.point_in("Servo", 0.5F, 0.02F);
    window.person().click(title.x, title.y);
}

/// Chooses a channel in a plot's menu, and closes that.
void toggle_channel(ShownWindow &window, const std::string &plot, const std::string &channel) {
    window.click(plot + "/menu");
    window.click(plot + "/menu/search");
    window.person().clear_field();
    window.person().type(channel);
    window.click(plot + "/menu/" + channel);
    close_menu(window);
}

// --- files ---

using Columns = std::map<std::string, std::vector<double>>;

/// NaN for an empty cell.
Columns columns_of(const std::filesystem::path &csv) {
    const std::string text = testing::contents_of(csv);
    const std::vector<std::string> names = testing::parsed_csv(text).front();
    Columns columns;
    for (const std::vector<double> &row : testing::parsed_numbers(text)) {
        for (std::size_t i = 0; i < names.size(); ++i) {
            columns[names[i]].push_back(row.at(i));
        }
    }
    return columns;
}

/// Exports what is shown; the new file in that folder.
std::filesystem::path exported(ShownWindow &window, const std::filesystem::path &folder,
                               const std::string &entry, const std::string &ending) {
    std::set<std::filesystem::path> before;
    for (const auto &file : std::filesystem::directory_iterator(folder)) {
        before.insert(file.path());
    }
    window.choose("Plots/export", entry);
    std::filesystem::path found;
    window.wait_until(
        [&](const Report &) {
            for (const auto &file : std::filesystem::directory_iterator(folder)) {
                if (file.path().extension() == ending && !before.contains(file.path())) {
                    found = file.path();
                }
            }
            return !found.empty();
        },
        "a new file " + ending);
    return found;
}

Columns exported_csv(ShownWindow &window, const std::filesystem::path &folder) {
    return columns_of(exported(window, folder, "CSV, what is shown", ".csv"));
}

struct PngSize {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

/// 0 × 0 of what does not begin and end as such a file does.
PngSize png_size(const std::string &bytes) {
    constexpr std::string_view kBegin("\x89PNG\r\n\x1a\n\0\0\0\15IHDR", 16);
    const auto number = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (const char byte : bytes.substr(at, 4)) { // big endian
            value = value << 8U | static_cast<unsigned char>(byte);
        }
        return value;
    };
    return bytes.starts_with(kBegin) && bytes.ends_with("IEND\xae\x42\x60\x82")
               ? PngSize{number(16), number(20)}
               : PngSize{};
}

// --- view ---

TEST(PlotsInTheWindow, AreZoomedMovedMadeLargerAndClosed) {
    ShownWindow window({}, kWindow);
    window.wait_until_running();
    const ShownPlot live = first_plot(window);
    window.person().wheel(live.point(0.7).x, live.point(0.7).y, 2);
    const ShownPlot before = first_plot(window);
    EXPECT_NEAR(before.length(), 0.64 * live.length(), 1e-9);
    expect_it_stays(window, "held by the wheel");
    for (const int notches : {3, -4}) {
        const ShownPlot then = first_plot(window);
        const Point mouse = then.point(0.3);
        window.person().wheel(mouse.x, mouse.y, notches);
        const ShownPlot zoomed = first_plot(window);
        EXPECT_NEAR(zoomed.length(), std::pow(0.8, notches) * then.length(), 1e-6);
        const double pixel = std::max(then.length(), zoomed.length()) / then.width;
        EXPECT_NEAR(zoomed.x_at(mouse), then.x_at(mouse), 1.5 * pixel);
    }
    // What is grasped goes with the mouse, except for what ImGui takes for a click.
    const ShownPlot grasped = first_plot(window);
    window.person().drag(grasped.point(0.3), grasped.point(0.6), 0.2);
    const ShownPlot moved = first_plot(window);
    EXPECT_NEAR(moved.length(), grasped.length(), 1e-9);
    EXPECT_NEAR(moved.x_from, grasped.x_from - 0.3 * grasped.length(),
                10.0 * grasped.length() / grasped.width);
    expect_it_stays(window, "held by a drag");
    // Up and down with Ctrl.
    window.person().press_key("Control_L");
    window.person().wheel(moved.point(0.5).x, moved.point(0.5).y, 3);
    window.person().release_key("Control_L");
    const ShownPlot higher = first_plot(window);
    expect_same_x(higher, moved);
    EXPECT_NEAR((higher.y_to - higher.y_from) / (moved.y_to - moved.y_from), 0.512, 1e-6);
    expect_it_stays(window, "zoomed both ways");
    // A range drawn with the right button.
    window.person().drag(higher.point(0.2, 0.2), higher.point(0.7, 0.8), 0.2, 3);
    const ShownPlot boxed = first_plot(window);
    const double pixel = higher.length() / higher.width;
    EXPECT_NEAR(boxed.x_from, higher.x_from + 0.2 * higher.length(), 2.0 * pixel);
    EXPECT_NEAR(boxed.x_to, higher.x_from + 0.7 * higher.length(), 2.0 * pixel);
    EXPECT_LT(boxed.y_to - boxed.y_from, 0.65 * (higher.y_to - higher.y_from));
    const Point middle = boxed.point(0.5);
    window.person().double_click(middle.x, middle.y);
    const ShownPlot returned = first_plot(window);
    EXPECT_TRUE(returned.is_live);
    EXPECT_EQ(returned.x_to, 0.0);
    EXPECT_EQ(returned.y_from, live.y_from);
    EXPECT_EQ(returned.y_to, live.y_to);
    // Over frequency; far beyond each limit is covered by axis and view themselves.
    window.choose("Plots/sets", "spectrum of the force");
    for (const int notches : {4, -20}) {
        const ShownPlot then = first_plot(window);
        const Point mouse = then.point(0.9);
        window.person().wheel(mouse.x, mouse.y, notches);
        const ShownPlot zoomed = first_plot(window);
        EXPECT_TRUE(std::isfinite(zoomed.x_from) && std::isfinite(zoomed.x_to)) << notches;
        EXPECT_LT(zoomed.x_from, zoomed.x_to) << notches;
        const double ratio = zoomed.x_to / zoomed.x_from;
        const double ratio_before = then.x_to / then.x_from;
        if (notches > 0) {
            EXPECT_LT(ratio, ratio_before);
        } else {
            EXPECT_GT(ratio, ratio_before);
        }
    }
    // At the limit of zoom the view over time stays.
    const Point over_time = plots_of(window.look()).at(1).point(0.9);
    window.person().wheel(over_time.x, over_time.y, -40);
    const ShownPlot far = plots_of(window.look()).at(1);
    window.person().wheel(far.point(0.2).x, far.point(0.2).y, -5);
    expect_same_x(plots_of(window.look()).at(1), far);
    EXPECT_TRUE(window.look().shows("running"));
    // Larger ones cover the scene, and each can be closed.
    const auto height = [&] { return window.look().item("Plots").at("height").get<double>(); };
    const double low = height();
    window.click("Plots/large");
    EXPECT_GT(height(), 0.8 * kWindow.height);
    testing::expect_side_by_side(window.look(), "Plots", "larger");
    window.click("Plots/large");
    EXPECT_EQ(height(), low);
    const Point handle = window.point_in("Plots/handle");
    window.person().drag(handle, {handle.x, handle.y - 50.0F}, 0.1);
    EXPECT_NEAR(height(), low + 50.0, 3.0);
    for (const ShownPlot &plot : plots_of(window.look())) {
        const std::string id = plot.id.substr(0, plot.id.rfind('/'));
        window.click(id + "/menu");
        window.click(id + "/menu/close");
    }
    EXPECT_TRUE(plots_of(window.look()).empty());
    window.choose("Plots/sets", "add a plot");
    EXPECT_EQ(plots_of(window.look()).size(), 1U);
}

// --- channels ---

TEST(PlotsInTheWindow, ChannelsAreSearchedAddedRemovedAndDraggedToOtherPlots) {
    ShownWindow window({}, kWindow);
    window.wait_until_running();
    window.click("plot 2/menu");
    const Report all = window.look();
    ASSERT_GT(all.all().at("sample").size(), 100U);
    for (const auto &column : all.all().at("sample").items()) {
        EXPECT_NE(all.find("plot 2/menu/" + column.key()), nullptr) << column.key();
    }
    EXPECT_EQ(all.item("plot 2/menu/force_N").at("value"), true);
    window.click("plot 2/menu/search");
    window.person().type("Membrane"); // m, b and space would be orders if they were not typed
    EXPECT_EQ(window.look().column("map"), all.column("map"));
    window.person().clear_field();
    window.person().type("greatest WIND");
    std::vector<std::string> left;
    const Report narrowed = window.look();
    for (const auto &item : narrowed.all().at("items")) {
        const std::string id = item.at("id");
        if (item.at("kind") == "entry" && id.find("plot 2/menu/") != std::string::npos) {
            left.push_back(item.at("text"));
        }
    }
    EXPECT_EQ(left, (std::vector<std::string>{"winding_greatest1_C", "winding_greatest2_C",
                                              "winding_greatest3_C"}));
    window.click("plot 2/menu/winding_greatest2_C");
    EXPECT_EQ(plots_of(window.look()).at(1).channels, "force_N, winding_greatest2_C");
    EXPECT_EQ(window.look().item("plot 2/winding_greatest2_C").at("text"), "winding_greatest2");
    window.click("plot 2/menu/winding_greatest2_C");
    EXPECT_EQ(plots_of(window.look()).at(1).channels, "force_N");
    close_menu(window);
    window.click("plot 2/force_N"); // in the legend
    EXPECT_EQ(plots_of(window.look()).at(1).channels, "");
    EXPECT_FALSE(window.look().shows("STOPPED"));
    // A drag with Ctrl copies, one without moves.
    toggle_channel(window, "plot 2", "force_N");
    const std::string plain = first_plot(window).channels;
    window.person().press_key("Control_L");
    window.person().drag(window.point_in("plot 2/force_N"), first_plot(window).point(0.5), 0.3);
    window.person().release_key("Control_L");
    EXPECT_EQ(first_plot(window).channels, plain + ", force_N");
    EXPECT_EQ(plots_of(window.look()).at(1).channels, "force_N");
    window.click("plot 1/force_N");
    const std::string before = first_plot(window).channels;
    window.person().drag(window.point_in("plot 2/force_N"), first_plot(window).point(0.5), 0.1);
    EXPECT_EQ(first_plot(window).channels, before + ", force_N");
    EXPECT_EQ(plots_of(window.look()).at(1).channels, ""); // from where it was taken
    // Once more changes nothing, nor does a drag to where it is, which is no click either.
    toggle_channel(window, "plot 2", "force_N");
    window.person().drag(window.point_in("plot 2/force_N"), first_plot(window).point(0.5), 0.1);
    EXPECT_EQ(first_plot(window).channels, before + ", force_N");
    window.person().drag(window.point_in("plot 1/force_N"), first_plot(window).point(0.5), 0.1);
    EXPECT_EQ(first_plot(window).channels, before + ", force_N");
    // From the list of a menu, too.
    window.click("plot 2/menu");
    window.click("plot 2/menu/search");
    window.person().clear_field();
    window.person().type("tip_x_m");
    window.person().drag(window.point_in("plot 2/menu/tip_x_m"), first_plot(window).point(0.2),
                         0.1);
    EXPECT_EQ(first_plot(window).channels, before + ", force_N, tip_x_m");
}

// --- what is held and exported ---

TEST(PlotsInTheWindow, AHeldViewStaysAndExportsWhatTheRecordHoldsBitForBit) {
    const std::filesystem::path folder = folder_with_touches("plots_record");
    std::vector<std::string> arguments = touching(folder);
    arguments.insert(arguments.end(), {"--record", folder / "all.record"});
    ShownWindow window(arguments, kWindow, folder);
    window.wait_until_running();
    const ShownPlot live = first_plot(window);
    EXPECT_TRUE(live.is_live);
    EXPECT_DOUBLE_EQ(live.x_from, -5.0); // before now
    EXPECT_DOUBLE_EQ(live.x_to, 0.0);
    window.click("Plots/hold");
    EXPECT_EQ(window.look().item("Plots/hold").at("text"), "live");
    const ShownPlot held = first_plot(window);
    EXPECT_NEAR(held.length(), 5.0, 1e-9);
    EXPECT_GT(held.x_to, 0.0);
    expect_it_stays(window, "held by the button");
    const Columns first = exported_csv(window, folder);
    window.let_pass(1.0); // so that the files have different names
    EXPECT_EQ(exported_csv(window, folder).at("time_s"), first.at("time_s"));
    window.click("Plots/hold");
    EXPECT_TRUE(first_plot(window).is_live);
    window.let_pass(1.0);
    EXPECT_GT(exported_csv(window, folder).at("time_s").back(), first.at("time_s").back() + 1.0);
    // A new span keeps the end of a held view.
    window.click("Plots/hold");
    const ShownPlot before = first_plot(window);
    window.choose("Plots/span", "1 s");
    EXPECT_EQ(first_plot(window).x_to, before.x_to);
    EXPECT_NEAR(first_plot(window).length(), 1.0, 1e-9);
    window.choose("Plots/span", "5 s");
    window.click("Plots/hold");
    // A map keeps its name and its past when the other one is used.
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the tip touches");
    const auto legend = [&] {
        std::map<std::string, std::string> texts;
        const Report report = window.look();
        for (const auto &item : report.all().at("items")) {
            if (item.at("kind") == "legend") {
                texts[item.at("id")] = item.at("text");
            }
        }
        return texts;
    };
    const auto names = legend();
    EXPECT_EQ(names.at("Plots/plot 1/transpose_measured_rad"), "transpose, measured");
    EXPECT_EQ(names.at("Plots/plot 1/inverse_error_rad"), "inverse, ideal");
    window.let_pass(0.3);
    window.choose("Gains/map", "inverse (18)");
    window.wait_until(
        [](const Report &report) {
            return report.column("map") == 0.0 && report.column("touching") != 0.0;
        },
        "the tip touches with the inverse map");
    EXPECT_EQ(legend(), names);
    window.let_pass(0.3);
    const Columns maps = exported_csv(window, folder);
    int of_transpose = 0;
    int of_inverse = 0;
    for (std::size_t row = 0; row < maps.at("time_s").size(); ++row) {
        const bool has_transpose = !std::isnan(maps.at("transpose_measured_rad")[row]);
        const bool has_inverse = !std::isnan(maps.at("inverse_measured_rad")[row]);
        EXPECT_FALSE(has_transpose && has_inverse) << row;
        of_transpose += has_transpose ? 1 : 0;
        of_inverse += has_inverse ? 1 : 0;
    }
    EXPECT_GT(of_transpose, 100); // its past is still its own
    EXPECT_GT(of_inverse, 50);
    // Bit for bit.
    for (const char *channel : {"tick", "tip_x_m", "lateness_s", "touching", "scene_id"}) {
        toggle_channel(window, "plot 2", channel);
    }
    window.let_pass(1.0); // so that the files have different names
    window.click("Plots/hold");
    const Columns shown = exported_csv(window, folder);
    window.person().close_window();
    ASSERT_EQ(window.program().end(0).exit_status, 0) << window.program().error();
    std::string columns = "time_s";
    for (const auto &[name, values] : shown) {
        const bool is_derived = name == "force_N" || name.ends_with("_measured_rad");
        columns += name == "time_s" || is_derived ? "" : ',' + name;
    }
    const testing::Ending ending = testing::run_program(
        {"export", folder / "all.record", "--csv", folder / "record.csv", "--columns", columns});
    ASSERT_EQ(ending.exit_status, 0) << ending.error;
    const Columns recorded = columns_of(folder / "record.csv");
    ASSERT_EQ(recorded.size(), shown.size() - 3);
    const std::vector<double> &times_s = recorded.at("time_s");
    const auto first_row = static_cast<std::size_t>(
        std::ranges::find(times_s, shown.at("time_s").front()) - times_s.begin());
    ASSERT_LE(first_row + shown.at("time_s").size(), times_s.size());
    ASSERT_GT(shown.at("time_s").size(), 1000U);
    for (const auto &[name, values] : recorded) {
        for (std::size_t row = 0; row < shown.at(name).size(); ++row) {
            const double there = values[first_row + row];
            const double here = shown.at(name)[row];
            ASSERT_TRUE(std::bit_cast<std::uint64_t>(here) == std::bit_cast<std::uint64_t>(there) ||
                        (std::isnan(here) && std::isnan(there)))
                << name << ", row " << row << ": " << here << " and " << there;
        }
    }
}

// --- trigger, cursors and pictures ---

void arm_on_contact(ShownWindow &window) {
    window.click("Plots/trigger");
    window.choose("Plots/trigger/source", "contact");
    window.click("Plots/trigger/arm");
}

/// Whether the view stopped with a contact at 25 % of its span.
void expect_stop_at_contact(ShownWindow &window, const std::filesystem::path &folder) {
    window.wait_until([](const Report &report) { return !plots_of(report).front().is_live; },
                      "stopped at a contact", 30.0);
    const ShownPlot shown = first_plot(window);
    const Columns rows = exported_csv(window, folder);
    const std::vector<double> &time_s = rows.at("time_s");
    const std::vector<double> &touches = rows.at("touching");
    ASSERT_GT(time_s.size(), 900U);
    EXPECT_NEAR(shown.length(), 1.0, 1e-6);
    EXPECT_GE(time_s.front(), shown.x_from);
    EXPECT_LE(time_s.back(), shown.x_to);
    EXPECT_GT(time_s.back(), shown.x_to - 0.01);
    std::size_t first = 0;
    while (first < touches.size() && touches[first] == 0.0) {
        ++first;
    }
    ASSERT_LT(first, touches.size()) << "no contact is shown";
    EXPECT_NEAR((time_s[first] - shown.x_from) / shown.length(), 0.25, 1e-3);
}

/// "force A 1.2  B 3.4  Δ 2.2 N": the three numbers.
std::array<double, 3> numbers_of(const std::string &legend) {
    std::array<double, 3> numbers{};
    std::size_t at = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const std::string_view mark = std::array{" A ", "  B ", "  Δ "}[i];
        at = legend.find(mark, at);
        if (at == std::string::npos) {
            ADD_FAILURE() << legend;
            return numbers;
        }
        at += mark.size();
        numbers[i] = std::stod(legend.substr(at));
    }
    return numbers;
}

/// Where a text begins in an SVG file; nothing if it is not there.
std::optional<Point> place_of(const std::string &svg, const std::string &text) {
    const std::size_t end = svg.find('>' + text + "</text>");
    const std::size_t begin = svg.rfind("<text x=\"", end);
    if (end == std::string::npos || begin == std::string::npos) {
        return std::nullopt;
    }
    const std::string tag = svg.substr(begin, end - begin);
    return Point{std::stof(tag.substr(tag.find("x=\"") + 3)),
                 std::stof(tag.substr(tag.find("y=\"") + 3))};
}

TEST(PlotsInTheWindow, TheTriggerStopsCursorsReadAndPicturesAreFilesThatOthersRead) {
    const std::filesystem::path folder = folder_with_touches("plots_trigger");
    ShownWindow window(touching(folder), {1600, 720}, folder); // room for values and messages
    window.wait_until_running();
    toggle_channel(window, "plot 2", "touching");
    window.choose("Plots/span", "1 s");
    window.wait_until([](const Report &report) { return report.column("touching") == 0.0; },
                      "the tip is free");
    arm_on_contact(window);
    EXPECT_EQ(window.look().item("Plots/trigger").at("text"), "trigger: contact");
    expect_stop_at_contact(window, folder);
    const ShownPlot first = first_plot(window);
    expect_it_stays(window, "stopped by the trigger");
    window.let_pass(1.0);
    arm_on_contact(window);
    EXPECT_TRUE(first_plot(window).is_live);
    expect_stop_at_contact(window, folder);
    EXPECT_GT(first_plot(window).x_from, first.x_to);
    // What the last export said does not stand in the way of what the trigger waits for.
    window.click("Plots/trigger");
    window.choose("Plots/trigger/source", "trip");
    window.click("Plots/trigger/arm");
    window.wait_until([](const Report &report) { return report.shows("waiting"); },
                      "the window says that it waits");
    // Cursors show the values there and their difference.
    toggle_channel(window, "plot 2", "touching");
    window.wait_until([](const Report &report) { return report.column("touching") != 0.0; },
                      "the tip touches");
    window.let_pass(0.3);
    window.click("Plots/hold");
    window.choose("Plots/span", "1 s");
    window.click("Plots/cursors");
    const Columns rows = exported_csv(window, folder);
    const auto cursors_of = [](const Report &report) {
        const auto &numbers = report.item("plot 2/area").at("numbers");
        return std::array<double, 2>{numbers.at("cursor_a_s"), numbers.at("cursor_b_s")};
    };
    const auto expect_values = [&] {
        const Report report = window.look();
        const std::array<double, 2> cursors_s = cursors_of(report);
        std::array<double, 2> expected{};
        for (std::size_t i = 0; i < 2; ++i) {
            const auto after = std::ranges::upper_bound(rows.at("time_s"), cursors_s[i]);
            ASSERT_NE(after, rows.at("time_s").begin());
            expected[i] =
                rows.at("force_N")[static_cast<std::size_t>(after - rows.at("time_s").begin()) - 1];
        }
        const std::string text = report.item("plot 2/force_N").at("text");
        const std::array<double, 3> shown = numbers_of(text);
        // Four digits are shown.
        EXPECT_NEAR(shown[0], expected[0], 1e-3 * std::abs(expected[0])) << text;
        EXPECT_NEAR(shown[1], expected[1], 1e-3 * std::abs(expected[1])) << text;
        EXPECT_NEAR(shown[2], expected[1] - expected[0], 1e-3 * std::abs(expected[1] - expected[0]))
            << text;
        EXPECT_TRUE(text.ends_with(" N")) << text;
    };
    expect_values();
    const std::array<double, 2> placed_s = cursors_of(window.look());
    const ShownPlot plot = plots_of(window.look()).at(1);
    EXPECT_NEAR(placed_s[0], plot.x_from + plot.length() / 3.0, 1e-6);
    EXPECT_NEAR(placed_s[1], plot.x_to - plot.length() / 3.0, 1e-6);
    // A to the left, then B to the right, beyond the window's end.
    window.person().drag(plot.point(1.0 / 3.0), plot.point(0.1), 0.2);
    const double pixel = plot.length() / plot.width;
    EXPECT_NEAR(cursors_of(window.look())[0], plot.x_from + 0.1 * plot.length(), 2.0 * pixel);
    EXPECT_EQ(cursors_of(window.look())[1], placed_s[1]);
    expect_same_x(plots_of(window.look()).at(1), plot); // the view did not move
    expect_values();
    window.person().drag(plot.point(2.0 / 3.0), plot.point(0.9), 0.2);
    EXPECT_NEAR(cursors_of(window.look())[1], plot.x_from + 0.9 * plot.length(), 2.0 * pixel);
    expect_values();
    testing::expect_side_by_side(window.look(), "Plots", "with cursors");
    // Pictures, and what is said where they fail.
    window.click("Plots/cursors");
    for (const char *set : {"force and its direction", "figure 6, live"}) {
        window.choose("Plots/sets", set);
        window.let_pass(1.0); // so that the files have different names
        const std::string svg = testing::contents_of(exported(window, folder, "SVG", ".svg"));
        testing::XmlCheck check(svg);
        EXPECT_EQ(check.error(), "") << set;
        EXPECT_GT(check.elements(), 50) << set;
        EXPECT_TRUE(place_of(svg, "transpose, measured")) << set;
        if (const std::optional<Point> second = place_of(svg, "force")) {
            // The legend of the first plot ends where that of the second begins.
            for (const char *label : {"every tick", "transpose, measured", "transpose, ideal",
                                      "inverse, measured", "inverse, ideal"}) {
                const std::optional<Point> place = place_of(svg, label);
                ASSERT_TRUE(place) << label;
                EXPECT_LT(place->x, second->x - 60.0F) << label;
            }
        }
        const PngSize png = png_size(testing::contents_of(exported(window, folder, "PNG", ".png")));
        const nlohmann::json panel = window.look().item("Plots");
        // Without the row of buttons and the margins.
        EXPECT_GT(png.width, 0.9 * panel.at("width").get<double>()) << set;
        EXPECT_LE(png.width, panel.at("width").get<double>()) << set;
        EXPECT_GT(png.height, 0.6 * panel.at("height").get<double>()) << set;
        EXPECT_LE(png.height, panel.at("height").get<double>()) << set;
    }
    std::filesystem::remove_all(folder);
    for (const char *entry : {"CSV, what is shown", "SVG", "PNG"}) {
        window.choose("Plots/export", entry);
        const Report report = window.look(); // what is too long for its place is in a tooltip
        EXPECT_TRUE(report.shows("cannot be written") || report.shows("…")) << entry;
    }
    EXPECT_TRUE(window.look().shows("running"));
}

} // namespace
} // namespace springdrive::app
