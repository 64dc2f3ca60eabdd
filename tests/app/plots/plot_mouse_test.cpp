// Covers app/plots/plot_mouse.cpp for polar plots; the tests of the window cover the others.
#include "app/plots/plot_mouse.h"

#include "app/plots/plot_panel.h"
#include "app/widgets/widgets.h"
#include "tests/support/channel_stores.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace springdrive::app {
namespace {

using testing::channel;

const Rectangle kPolarPlace{{50.0F, 40.0F}, {400.0F, 300.0F}};

/// A polar plot of a force of 3 N in all directions.
class PolarMouseTest : public testing::ImGuiFrame {
protected:
    PolarMouseTest() {
        for (int row = 0; row < 1000; ++row) {
            made_["normal_direction_rad"] = 0.01 * row;
            made_["force_N"] = 3.0;
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
    testing::MadeUpStore made_;
    PlotPanelState state_;
    Plot plot_;
};

TEST_F(PolarMouseTest, ThePointerReadsAngleAndRadius) {
    EXPECT_EQ(polar_text(plot().area, place(30.0, 2.0), plot().settings), "30.0°, 2 N");
    EXPECT_EQ(polar_text(plot().area, place(-90.0, 1.5), plot().settings), "-90.0°, 1.5 N");
    const ImVec2 at = place(135.0, 2.5);
    const ImVec2 pixel{std::floor(at.x), std::floor(at.y)};
    EXPECT_EQ(draw_frame(pixel), polar_text(plot().area, pixel, plot().settings));
    EXPECT_EQ(draw_frame({20.0F, 20.0F}), ""); // beside it
}

TEST_F(PolarMouseTest, TheWheelZoomsTheRadiusAndADoubleClickResetsIt) {
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
    for (const bool is_down : {true, false, true, false}) {
        draw_frame(mouse, 0.0F, is_down);
    }
    draw_frame(mouse);
    EXPECT_EQ(plot().area.y, before);
    EXPECT_EQ(plot().area.x, before);
}

} // namespace
} // namespace springdrive::app
