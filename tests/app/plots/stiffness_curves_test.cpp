// Covers how app/plots/stiffness_curves.cpp draws.
#include "app/plots/stiffness_curves.h"

#include "app/widgets/look.h"
#include "tests/support/devices.h"
#include "tests/support/imgui_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

using StiffnessCurvesTest = testing::ImGuiFrame;

/// Records the strokes of curves: grids have thinner ones.
class StrokeCanvas final : public Canvas {
public:
    void polyline(std::span<const ImVec2> /*points*/, const Stroke &stroke) override {
        if (stroke.width > 1.0F) {
            strokes.push_back(stroke);
        }
    }
    void fill(const Rectangle & /*where*/, const ImVec4 & /*colour*/) override {}
    void dot(ImVec2 /*middle*/, float /*radius*/, const ImVec4 & /*colour*/) override {}
    void text(ImVec2 /*corner*/, const ImVec4 & /*colour*/, std::string_view /*text*/) override {}
    void clip(const Rectangle & /*where*/) override {}
    void unclip() override {}

    std::vector<Stroke> strokes;
};

TEST_F(StiffnessCurvesTest, AreGreyAndDifferInDashAndLightness) {
    loops::SpringDrive drive;
    drive.motor = testing::phantom_motor();
    StiffnessCurves curves;
    curves.update(drive);
    StrokeCanvas canvas;
    PlotSettings settings;
    settings.kind = PlotKind::stiffness;
    static_cast<void>(curves.draw(canvas, {{0.0F, 0.0F}, {400.0F, 300.0F}}, settings));
    ASSERT_EQ(canvas.strokes.size(), 2U);
    EXPECT_NE(canvas.strokes[0].dash, canvas.strokes[1].dash);
    EXPECT_GT(std::abs(canvas.strokes[0].colour.x - canvas.strokes[1].colour.x), 0.1F);
    for (const Stroke &stroke : canvas.strokes) {
        // Unlike the colours of the maps and the force.
        const auto [least, greatest] =
            std::minmax({stroke.colour.x, stroke.colour.y, stroke.colour.z});
        EXPECT_LT(greatest - least, 0.12F);
    }
}

} // namespace
} // namespace springdrive::app
