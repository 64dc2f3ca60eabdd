// Covers app/plots/plot_export.cpp, except the contents of files, which the tests of the window
// read.
#include "app/plots/plot_menu.h"
#include "tests/support/channel_stores.h"
#include "tests/support/files.h"
#include "tests/support/imgui_frame.h"
#include "tests/support/xml_check.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

namespace springdrive::app {
namespace {

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

TEST_F(PlotExportTest, SeveralWithinASecondAreSeveralFiles) {
    testing::MadeUpStore made;
    made.add(100);
    const PlotSource source{made.store(), 1000.0, {0.0, 0.1}, 0.0};
    PlotPanelState state;
    const Rectangle where{{10.0F, 10.0F}, {500.0F, 200.0F}};
    for (std::size_t count = 1; count <= 3; ++count) {
        export_csv(state, source);
        EXPECT_TRUE(state.message.starts_with("saved as plots-")) << state.message;
        export_svg(state, source, where, 1.0F);
        EXPECT_TRUE(state.message.starts_with("saved as plots-")) << state.message;
        EXPECT_EQ(names().size(), 2 * count);
    }
}

TEST_F(PlotExportTest, APictureOfManyPlotsWithManyChannelsIsWellFormed) {
    testing::MadeUpStore made;
    made.add(100);
    const PlotSource source{made.store(), 1000.0, {0.0, 0.1}, 0.0};
    PlotPanelState state;
    state.plots = std::vector<Plot>(10);
    for (Plot &plot : state.plots) {
        for (std::size_t i = 0; i < session::channels().size(); ++i) {
            plot.settings.channels.push_back(i);
        }
    }
    export_svg(state, source, {{10.0F, 10.0F}, {300.0F, 150.0F}}, 1.0F);
    const std::string svg = testing::contents_of(*names().begin());
    EXPECT_EQ(testing::error_about_xml(svg), "");
    EXPECT_NE(svg.find(" channels</text>"), std::string::npos);
}

} // namespace
} // namespace springdrive::app
