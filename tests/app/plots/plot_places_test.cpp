// Covers where app/plots/plot_panel.cpp places plots.
#include "app/plots/plot_panel.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace springdrive::app {
namespace {

using PlotPlacesTest = testing::ImGuiFrame;

bool have_common_area(const Rectangle &a, const Rectangle &b) {
    const auto common = [](float a_from, float a_size, float b_from, float b_size) {
        return std::min(a_from + a_size, b_from + b_size) - std::max(a_from, b_from);
    };
    constexpr float kRounding = 0.01F;
    return common(a.corner.x, a.size.x, b.corner.x, b.size.x) > kRounding &&
           common(a.corner.y, a.size.y, b.corner.y, b.size.y) > kRounding;
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
                EXPECT_LE(places[i].corner.x + places[i].size.x, where.corner.x + size.x + 0.1F);
                EXPECT_LE(places[i].corner.y + places[i].size.y, where.corner.y + size.y + 0.1F);
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
