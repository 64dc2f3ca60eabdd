// Covers app/plots/plot_panel.cpp, plot_controls.cpp for polar plots, and how
// stiffness_curves.cpp draws; what is exported and the other mice are covered by the window's
// tests.
#include "app/plots/plot_panel.h"

#include "app/widgets/widgets.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"
#include "tests/support/imgui_frame.h"
#include "tests/support/plots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::channel;
using testing::MadeUpStore;

using Channels = std::vector<std::size_t>;

Channels all_channels() {
    Channels all(session::channels().size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = i;
    }
    return all;
}

// --- legend ---

TEST(LegendLayout, FillsRowsFromTheLeftAndCountsWhatHasNoRoom) {
    const LegendLayout layout =
        legend_layout({40.0F, 50.0F, 30.0F, 20.0F}, {{100.0F, 60.0F}, 20.0F, 35.0F});
    ASSERT_EQ(layout.places.size(), 4U);
    EXPECT_EQ(layout.hidden, 0U);
    EXPECT_EQ(layout.places[1].x, 40.0F);
    EXPECT_EQ(layout.places[2].x, 0.0F);
    EXPECT_EQ(layout.places[2].y, 20.0F);
    EXPECT_EQ(layout.places[3].x, 30.0F);
    EXPECT_EQ(layout.height, 40.0F);
    for (std::size_t count = 1; count <= 170; ++count) {
        for (const float height : {5.0F, 20.0F, 45.0F, 130.0F}) {
            const LegendRoom room{{100.0F, height}, 20.0F, 35.0F};
            const LegendLayout many = legend_layout(std::vector<float>(count, 30.0F), room);
            EXPECT_EQ(many.places.size() + many.hidden, count);
            EXPECT_LE(many.height, std::max(height, 20.0F));
            for (const ImVec2 &place : many.places) {
                EXPECT_LE(place.x + 30.0F, 100.0F);
                EXPECT_LE(place.y + 20.0F, many.height);
            }
            if (many.hidden > 0) {
                EXPECT_LE(many.more.x + 35.0F, 100.0F);
                EXPECT_LE(many.more.y + 20.0F, many.height);
                ASSERT_FALSE(many.places.empty());
                EXPECT_TRUE(many.more.y > many.places.back().y ||
                            many.more.x >= many.places.back().x + 30.0F);
            }
        }
    }
}

TEST(LegendLayout, HasOneRowHoweverWideAnEntryIsAndSaysHowManyAreHidden) {
    EXPECT_EQ(legend_layout({}, {{100.0F, 50.0F}, 20.0F, 35.0F}).height, 20.0F);
    const LegendLayout alone = legend_layout({500.0F}, {{100.0F, 10.0F}, 20.0F, 35.0F});
    EXPECT_EQ(alone.places.size(), 1U);
    EXPECT_EQ(alone.height, 20.0F);
    LegendLayout two = legend_layout({500.0F, 10.0F}, {{100.0F, 10.0F}, 20.0F, 35.0F});
    EXPECT_TRUE(two.places.empty());
    EXPECT_EQ(two.more.x, 0.0F);
    EXPECT_EQ(hidden_text(two), "2 channels");
    two.places.resize(2);
    EXPECT_EQ(hidden_text(two), "+2 more");
}

TEST(LegendText, SaysWhatTheFirstChannelIsFor) {
    PlotSettings settings;
    settings.channels = {channel("tip_x_m"), channel("tip_y_m")};
    EXPECT_EQ(legend_text(settings, channel("tip_x_m")), "tip_x");
    settings.kind = PlotKind::xy;
    EXPECT_EQ(legend_text(settings, channel("tip_x_m")), "to the right: tip_x");
    EXPECT_EQ(legend_text(settings, channel("tip_y_m")), "tip_y");
    settings.kind = PlotKind::polar;
    EXPECT_EQ(legend_text(settings, channel("tip_x_m")), "angle: tip_x");
}

TEST(ValuesUnderCursors, AreThoseOfTheTickBeforeAndNoneWhereNothingIsKept) {
    MadeUpStore made;
    made["tip_x_m"] = 0.25;
    for (int row = 0; row < 100; ++row) {
        made["force_N"] = row;
        made.add();
    }
    const std::size_t force = channel("force_N");
    EXPECT_EQ(values_under_cursors(force, {0.010, 0.0305}, made.store(), false),
              " A 10  B 30  Δ 20 N");
    EXPECT_EQ(values_under_cursors(channel("tip_x_m"), {0.01, 0.01}, made.store(), false),
              " A 250  B 250  Δ 0 mm");
    EXPECT_EQ(values_under_cursors(channel("tip_x_m"), {0.01, 0.01}, made.store(), true),
              " A 0.25  B 0.25  Δ 0 m");
    EXPECT_EQ(values_under_cursors(force, {0.0, 1.0}, MadeUpStore().store(), false),
              " A –  B –  Δ – N");
    // As if everything before 5 s had been dropped.
    record::ChannelStore store(session::channels().size(), std::size_t{1} << 20);
    const std::vector<double> row(session::channels().size(), 2.0);
    for (const double time_s : {5.0, 6.0, 7.0}) {
        store.add(time_s, row);
    }
    EXPECT_EQ(values_under_cursors(force, {4.99, 6.0}, store, false), " A –  B 2  Δ – N");
    EXPECT_EQ(values_under_cursors(force, {5.0, 7.1}, store, false), " A 2  B –  Δ – N");
}

// --- dragged channels ---

TEST(DroppedChannel, IsMovedOrCopiedFromAnotherPlotAndAddedFromAList) {
    struct Case {
        DraggedChannel dragged;
        std::size_t onto;
        bool copies;
        Channels first;
        Channels second;
    };
    const std::size_t force = channel("force_N");
    const std::size_t x = channel("tip_x_m");
    const std::size_t y = channel("tip_y_m");
    const std::size_t tick = channel("tick");
    for (const Case &known : {Case{{force, 4}, 1, false, {x}, {y, force}},
                              Case{{force, 4}, 1, true, {force, x}, {y, force}},
                              Case{{y, 7}, 0, false, {force, x, y}, {}},
                              Case{{force, 0}, 1, false, {force, x}, {y, force}},
                              Case{{force, 4}, 0, false, {force, x}, {y}}, // its own
                              // Of a plot that was closed meanwhile.
                              Case{{tick, 99}, 0, false, {force, x, tick}, {y}}}) {
        std::vector<Plot> plots(2);
        plots[0].id = 4;
        plots[0].settings.channels = {force, x};
        plots[1].id = 7;
        plots[1].settings.channels = {y};
        drop_channel(plots, plots[known.onto], known.dragged, known.copies);
        EXPECT_EQ(plots[0].settings.channels, known.first);
        EXPECT_EQ(plots[1].settings.channels, known.second);
        drop_channel(plots, plots[known.onto], known.dragged, known.copies); // there it is already
        EXPECT_EQ(plots[0].settings.channels, known.first);
        EXPECT_EQ(plots[1].settings.channels, known.second);
    }
}

// --- widgets ---

/// What is drawn between construction and `items` stands in a window of ImGui.
class PlotMenuTest : public testing::ImGuiFrame {
protected:
    PlotMenuTest() {
        ui::report().begin(true);
        ImGui::SetNextWindowSize({600.0F, 500.0F});
        ImGui::Begin("window");
    }
    ~PlotMenuTest() override {
        ImGui::End();
        ui::report().begin(false);
    }
    static std::vector<ShownItem> items(std::string_view kind) {
        std::vector<ShownItem> found;
        std::ranges::copy_if(ui::report().items(), std::back_inserter(found),
                             [&](const ShownItem &item) { return item.kind == kind; });
        return found;
    }
};

TEST_F(PlotMenuTest, ALegendKeepsToItsRoom) {
    MadeUpStore made;
    made.add(10);
    const PlotPanelState state;
    const PlotSource source{made.store(), 1000.0, {0.0, 0.01}, 0.0};
    Plot plot;
    plot.settings.channels = {channel("winding_greatest1_C")};
    const float right = ImGui::GetCursorScreenPos().x + 80.0F;
    static_cast<void>(draw_legend(plot, state, source, {80.0F, 100.0F}));
    ASSERT_EQ(items("legend").size(), 1U);
    EXPECT_LE(items("legend").front().place.end().x, right);

    ui::report().begin(true);
    plot.settings.channels = all_channels();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room{300.0F, 100.0F};
    EXPECT_LE(draw_legend(plot, state, source, room), room.y);
    const std::vector<ShownItem> entries = items("legend");
    const std::vector<ShownItem> texts = items("text");
    ASSERT_EQ(texts.size(), 1U);
    EXPECT_EQ(texts.front().text,
              "+" + std::to_string(session::channels().size() - entries.size()) + " more");
    EXPECT_GT(entries.size(), 3U);
    for (const ShownItem &item : ui::report().items()) {
        EXPECT_LE(item.place.end().x, corner.x + room.x + 1.0F) << item.id;
        EXPECT_LE(item.place.end().y, corner.y + room.y + 1.0F) << item.id;
    }
}

/// The menu of a trigger at a level, whose list of channels can be opened.
class TriggerMenuTest : public PlotMenuTest {
protected:
    TriggerMenuTest() {
        state.plots.push_back(state.plots.front()); // channels that are shown twice
        state.typed_trigger.source = TriggerSource::level;
        state.typed_trigger.channel = channel("force_N");
    }

    void click(const ShownItem &item) {
        const ImVec2 middle{item.place.corner.x + 0.5F * item.place.size.x,
                            item.place.corner.y + 0.5F * item.place.size.y};
        for (const bool is_down : {false, true, false, false}) {
            draw_frame(middle, is_down);
        }
    }
    void open_list() {
        draw_frame({}, false);
        for (const ShownItem &item : items("choice")) {
            if (item.id.ends_with("channel")) {
                click(item);
                return;
            }
        }
        ADD_FAILURE() << "no list of channels";
    }

    PlotPanelState state;

private:
    void draw_frame(ImVec2 mouse, bool is_down) {
        ImGui::End();
        ImGui::EndFrame();
        ImGui::GetIO().MousePos = mouse;
        ImGui::GetIO().MouseDown[0] = is_down;
        ImGui::NewFrame();
        ui::report().begin(true);
        ImGui::Begin("window");
        draw_trigger_menu(state, made_.store());
    }

    MadeUpStore made_;
};

TEST_F(TriggerMenuTest, ListsEveryChannelOnceAndTheSearchNarrowsItUntilAClickChooses) {
    open_list();
    std::set<std::string> names;
    for (const ShownItem &entry : items("entry")) {
        EXPECT_TRUE(names.insert(entry.text).second) << entry.text;
        EXPECT_EQ(std::get<bool>(entry.value), entry.text == "force_N") << entry.text;
    }
    EXPECT_EQ(names.size(), session::channels().size());
    click(items("entry").front()); // closes it
    state.trigger.searched = "greatest WIND";
    open_list();
    ASSERT_EQ(items("entry").size(), 3U);
    click(items("entry")[1]);
    EXPECT_EQ(state.typed_trigger.channel, channel("winding_greatest2_C"));
    EXPECT_TRUE(items("entry").empty());
}

// --- the mouse on a polar plot ---

const Rectangle kPolarPlace{{50.0F, 40.0F}, {400.0F, 300.0F}};

/// Of a force of 3 N in all directions.
class PolarMouseTest : public testing::ImGuiFrame {
protected:
    PolarMouseTest() {
        made_["force_N"] = 3.0;
        for (int row = 0; row < 1000; ++row) {
            made_["normal_direction_rad"] = 0.01 * row;
            made_.add();
        }
        plot_.settings.kind = PlotKind::polar;
        plot_.settings.channels = {channel("normal_direction_rad"), channel("force_N")};
        draw_frame(); // in which ImGui learns of the window
    }

    [[nodiscard]] const Plot &plot() const { return plot_; }

    /// A place by its angle and its radius.
    [[nodiscard]] ImVec2 place(double angle_deg, double radius) const {
        const double angle = angle_deg * std::acos(-1.0) / 180.0;
        return plot_.area.place(radius * std::cos(angle), radius * std::sin(angle));
    }

    /// @return the tooltip
    std::string draw_frame(ImVec2 mouse = {}, float wheel = 0.0F, bool is_down = false) {
        ImGui::EndFrame();
        ImGuiIO &io = ImGui::GetIO();
        io.MousePos = mouse;
        io.MouseWheel = wheel;
        io.MouseDown[0] = is_down;
        ImGui::NewFrame();
        ui::report().begin(true);
        ImGui::SetNextWindowPos({0.0F, 0.0F});
        ImGui::SetNextWindowSize({800.0F, 600.0F});
        ImGui::Begin("window", nullptr, ImGuiWindowFlags_NoScrollWithMouse);
        ScreenCanvas canvas(*ImGui::GetWindowDrawList(), 1.0F);
        const PlotSource source{made_.store(), 1000.0, {0.0, 1.0}, 0.0};
        plot_.area = draw_contents(canvas, kPolarPlace, plot_, state_, source);
        ImGui::SetCursorScreenPos(kPolarPlace.corner);
        ImGui::InvisibleButton("area", kPolarPlace.size);
        use_mouse_on_plot(plot_, state_, source, made_.store());
        ImGui::End();
        std::string tooltip;
        for (const ShownItem &item : ui::report().items()) {
            tooltip += item.kind == "tooltip" ? item.text : "";
        }
        ui::report().begin(false);
        return tooltip;
    }

private:
    MadeUpStore made_;
    PlotPanelState state_;
    Plot plot_;
};

TEST_F(PolarMouseTest, ReadsAngleAndRadiusAndZoomsByTheWheelUntilADoubleClick) {
    EXPECT_EQ(polar_text(plot().area, place(30.0, 2.0), plot().settings), "30.0°, 2 N");
    EXPECT_EQ(polar_text(plot().area, place(-90.0, 1.5), plot().settings), "-90.0°, 1.5 N");
    const ImVec2 at = place(135.0, 2.5);
    const ImVec2 pixel{std::floor(at.x), std::floor(at.y)};
    EXPECT_EQ(draw_frame(pixel), polar_text(plot().area, pixel, plot().settings));
    EXPECT_EQ(draw_frame({20.0F, 20.0F}), ""); // beside it

    const Axis before = plot().area.y;
    EXPECT_NEAR(before.to, 1.08 * 5.0, 1e-9);
    const ImVec2 mouse = place(45.0, 1.0);
    draw_frame(mouse, 2.0F);
    draw_frame(mouse);
    EXPECT_NEAR(plot().area.y.to, 0.64 * before.to, 1e-9);
    EXPECT_NEAR(plot().area.y.from, 0.64 * before.from, 1e-9);
    EXPECT_EQ(plot().area.x, plot().area.y);
    draw_frame(mouse, -5.0F);
    draw_frame(mouse);
    EXPECT_NEAR(plot().area.y.to, std::pow(0.8, -3.0) * before.to, 1e-9);
    for (const bool is_down : {true, false, true, false, false}) {
        draw_frame(mouse, 0.0F, is_down);
    }
    EXPECT_EQ(plot().area.y, before);
    EXPECT_EQ(plot().area.x, before);
}

// --- files ---

/// Exports into a folder of its own.
class PlotExportTest : public testing::ImGuiFrame {
protected:
    explicit PlotExportTest() : before_(std::filesystem::current_path()) {
        std::filesystem::current_path(folder_);
    }
    ~PlotExportTest() override { std::filesystem::current_path(before_); }

    [[nodiscard]] std::set<std::string> names() const {
        std::set<std::string> names;
        for (const auto &file : std::filesystem::directory_iterator(folder_)) {
            names.insert(file.path().filename());
        }
        return names;
    }

private:
    std::filesystem::path before_;
    std::filesystem::path folder_ = testing::fresh_folder("plot_export");
};

TEST_F(PlotExportTest, EachExportIsAFileAlsoOfManyPlotsWithAllChannels) {
    MadeUpStore made;
    made.add(100);
    const PlotSource source{made.store(), 1000.0, {0.0, 0.1}, 0.0};
    PlotPanelState state;
    state.plots = std::vector<Plot>(10);
    for (Plot &plot : state.plots) {
        plot.settings.channels = all_channels();
    }
    export_svg(state, source, {{10.0F, 10.0F}, {300.0F, 150.0F}}, 1.0F);
    const std::string svg = testing::contents_of(*names().begin());
    EXPECT_EQ(testing::error_about_xml(svg), "");
    EXPECT_NE(svg.find(" channels</text>"), std::string::npos);
    for (std::size_t count = 1; count <= 3; ++count) { // within a second
        export_csv(state, source);
        EXPECT_TRUE(state.message.starts_with("saved as plots-")) << state.message;
        EXPECT_EQ(names().size(), 1 + count);
    }
}

// --- places ---

class PlotPlacesTest : public testing::ImGuiFrame {};

bool have_common_area(const Rectangle &a, const Rectangle &b) {
    constexpr float kRounding = 0.01F;
    return std::min(a.end().x, b.end().x) - std::max(a.corner.x, b.corner.x) > kRounding &&
           std::min(a.end().y, b.end().y) - std::max(a.corner.y, b.corner.y) > kRounding;
}

TEST_F(PlotPlacesTest, AnyNumberOfPlotsStandsSideBySide) {
    for (const ImVec2 size : {ImVec2{270.0F, 120.0F}, ImVec2{900.0F, 200.0F},
                              ImVec2{300.0F, 900.0F}, ImVec2{2000.0F, 1100.0F}}) {
        const Rectangle where{{20.0F, 500.0F}, size};
        std::vector<Plot> plots;
        for (int count = 1; count <= 20; ++count) {
            plots.emplace_back();
            plots.back().settings.channels.resize(count % 3 == 0 ? 6 : 1);
            const std::vector<Rectangle> places = plot_places(where, plots);
            ASSERT_EQ(places.size(), plots.size());
            for (std::size_t i = 0; i < places.size(); ++i) {
                EXPECT_GE(places[i].size.x, 1.0F);
                EXPECT_GE(places[i].size.y, 1.0F);
                EXPECT_GE(places[i].corner.x, where.corner.x);
                EXPECT_GE(places[i].corner.y, where.corner.y);
                EXPECT_LE(places[i].end().x, where.end().x + 0.1F);
                EXPECT_LE(places[i].end().y, where.end().y + 0.1F);
                for (std::size_t j = 0; j < i; ++j) {
                    EXPECT_FALSE(have_common_area(places[i], places[j]))
                        << i << " and " << j << " of " << count;
                }
            }
        }
    }
}

} // namespace
} // namespace springdrive::app
