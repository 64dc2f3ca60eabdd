// Covers app/plots/plot_menu.cpp.
#include "app/plots/plot_menu.h"

#include "app/widgets/widgets.h"
#include "tests/support/channel_stores.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using testing::channel;
using testing::MadeUpStore;

using Channels = std::vector<std::size_t>;

// --- legend ---

TEST(LegendLayout, FillsRowsFromTheLeft) {
    const LegendLayout layout =
        legend_layout({40.0F, 50.0F, 30.0F, 20.0F}, {{100.0F, 60.0F}, 20.0F, 35.0F});
    ASSERT_EQ(layout.places.size(), 4U);
    EXPECT_EQ(layout.hidden, 0U);
    EXPECT_EQ(layout.places[1].x, 40.0F);
    EXPECT_EQ(layout.places[1].y, 0.0F);
    EXPECT_EQ(layout.places[2].x, 0.0F);
    EXPECT_EQ(layout.places[2].y, 20.0F);
    EXPECT_EQ(layout.places[3].x, 30.0F);
    EXPECT_EQ(layout.height, 40.0F);
}

TEST(LegendLayout, CountsWhatHasNoRoom) {
    for (std::size_t count = 1; count <= 170; ++count) {
        for (const float height : {5.0F, 20.0F, 45.0F, 130.0F}) {
            const LegendRoom room{{100.0F, height}, 20.0F, 35.0F};
            const LegendLayout layout = legend_layout(std::vector<float>(count, 30.0F), room);
            EXPECT_EQ(layout.places.size() + layout.hidden, count);
            EXPECT_LE(layout.height, std::max(height, 20.0F));
            for (const ImVec2 &place : layout.places) {
                EXPECT_LE(place.x + 30.0F, 100.0F);
                EXPECT_LE(place.y + 20.0F, layout.height);
            }
            if (layout.hidden > 0) {
                EXPECT_LE(layout.more.x + 35.0F, 100.0F);
                EXPECT_LE(layout.more.y + 20.0F, layout.height);
                ASSERT_FALSE(layout.places.empty());
                EXPECT_TRUE(layout.more.y > layout.places.back().y ||
                            layout.more.x >= layout.places.back().x + 30.0F);
            }
        }
    }
}

TEST(LegendLayout, HasOneRowHoweverWideAnEntryIs) {
    EXPECT_EQ(legend_layout({}, {{100.0F, 50.0F}, 20.0F, 35.0F}).height, 20.0F);
    const LegendLayout alone = legend_layout({500.0F}, {{100.0F, 10.0F}, 20.0F, 35.0F});
    EXPECT_EQ(alone.places.size(), 1U);
    EXPECT_EQ(alone.height, 20.0F);
    const LegendLayout two = legend_layout({500.0F, 10.0F}, {{100.0F, 10.0F}, 20.0F, 35.0F});
    EXPECT_TRUE(two.places.empty());
    EXPECT_EQ(two.hidden, 2U);
    EXPECT_EQ(two.more.x, 0.0F);
}

TEST(LegendLayout, SaysHowManyAreHidden) {
    LegendLayout layout;
    layout.hidden = 3;
    EXPECT_EQ(hidden_text(layout), "3 channels");
    layout.places.resize(2);
    EXPECT_EQ(hidden_text(layout), "+3 more");
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

// --- cursors ---

TEST(ValuesUnderCursors, AreThoseOfTheTickBeforeAndTheirDifference) {
    MadeUpStore made;
    for (int row = 0; row < 100; ++row) {
        made["force_N"] = row;
        made.add();
    }
    EXPECT_EQ(values_under_cursors(channel("force_N"), {0.010, 0.0305}, made.store(), false),
              " A 10  B 30  Δ 20 N");
    made["tip_x_m"] = 0.25;
    made.add();
    EXPECT_EQ(values_under_cursors(channel("tip_x_m"), {0.1, 0.1}, made.store(), false),
              " A 250  B 250  Δ 0 mm");
    EXPECT_EQ(values_under_cursors(channel("tip_x_m"), {0.1, 0.1}, made.store(), true),
              " A 0.25  B 0.25  Δ 0 m");
}

TEST(ValuesUnderCursors, AreNoneWhereNothingIsKept) {
    const std::size_t force = channel("force_N");
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

std::vector<Plot> two_plots() {
    std::vector<Plot> plots(2);
    plots[0].id = 4;
    plots[0].settings.channels = {channel("force_N"), channel("tip_x_m")};
    plots[1].id = 7;
    plots[1].settings.channels = {channel("tip_y_m")};
    return plots;
}

TEST(DroppedChannel, IsMovedFromAnotherPlotOrCopied) {
    for (const bool copies : {false, true}) {
        std::vector<Plot> plots = two_plots();
        drop_channel(plots, plots[1], {channel("force_N"), 4}, copies);
        EXPECT_EQ(plots[1].settings.channels, (Channels{channel("tip_y_m"), channel("force_N")}));
        const Channels left = copies ? Channels{channel("force_N"), channel("tip_x_m")}
                                     : Channels{channel("tip_x_m")};
        EXPECT_EQ(plots[0].settings.channels, left);
        // There it is already.
        plots[0].settings.channels = {channel("force_N")};
        drop_channel(plots, plots[1], {channel("force_N"), 4}, copies);
        EXPECT_EQ(plots[1].settings.channels.size(), 2U);
        EXPECT_EQ(plots[0].settings.channels.size(), copies ? 1U : 0U);
    }
}

TEST(DroppedChannel, OfAListIsAddedAndOfTheSamePlotStays) {
    std::vector<Plot> plots = two_plots();
    drop_channel(plots, plots[1], {channel("force_N"), 0}, false);
    EXPECT_EQ(plots[1].settings.channels.size(), 2U);
    EXPECT_EQ(plots[0].settings.channels.size(), 2U);
    const Channels before = plots[0].settings.channels;
    drop_channel(plots, plots[0], {channel("force_N"), 4}, false);
    EXPECT_EQ(plots[0].settings.channels, before);
    drop_channel(plots, plots[0], {channel("tick"), 99}, false); // its plot was closed meanwhile
    EXPECT_EQ(plots[0].settings.channels.size(), 3U);
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

TEST_F(PlotMenuTest, ALegendOfAllChannelsKeepsToItsRoom) {
    MadeUpStore made;
    made.add(10);
    const PlotPanelState state;
    const PlotSource source{made.store(), 1000.0, {0.0, 0.01}, 0.0};
    Plot plot;
    for (std::size_t i = 0; i < session::channels().size(); ++i) {
        plot.settings.channels.push_back(i);
    }
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
        EXPECT_LE(item.place.corner.x + item.place.size.x, corner.x + room.x + 1.0F) << item.id;
        EXPECT_LE(item.place.corner.y + item.place.size.y, corner.y + room.y + 1.0F) << item.id;
    }
}

TEST_F(PlotMenuTest, ALegendIsNotWiderThanItsRoom) {
    MadeUpStore made;
    const PlotPanelState state;
    const PlotSource source{made.store(), 1000.0, {0.0, 1.0}, 0.0};
    Plot plot;
    plot.settings.channels = {channel("winding_greatest1_C")};
    const float right = ImGui::GetCursorScreenPos().x + 80.0F;
    static_cast<void>(draw_legend(plot, state, source, {80.0F, 100.0F}));
    ASSERT_EQ(items("legend").size(), 1U);
    const Rectangle place = items("legend").front().place;
    EXPECT_LE(place.corner.x + place.size.x, right);
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
        for (const bool is_down : {false, true, false}) {
            draw_frame(middle, is_down);
        }
        draw_frame(middle, false);
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

TEST_F(TriggerMenuTest, ListsEveryChannelOnceAndTheSearchNarrowsIt) {
    open_list();
    std::set<std::string> names;
    for (const ShownItem &entry : items("entry")) {
        EXPECT_TRUE(names.insert(entry.text).second) << entry.text;
        EXPECT_EQ(std::get<bool>(entry.value), entry.text == "force_N") << entry.text;
    }
    EXPECT_EQ(names.size(), session::channels().size());
}

TEST_F(TriggerMenuTest, AClickChoosesAChannelAndClosesTheList) {
    state.trigger.searched = "greatest WIND";
    open_list();
    ASSERT_EQ(items("entry").size(), 3U);
    click(items("entry")[1]);
    EXPECT_EQ(state.typed_trigger.channel, channel("winding_greatest2_C"));
    EXPECT_TRUE(items("entry").empty());
}

} // namespace
} // namespace springdrive::app
