// Covers app/plots/canvas.cpp.
#include "app/plots/canvas.h"

#include "tests/support/imgui_frame.h"
#include "tests/support/xml_check.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace springdrive::app {
namespace {

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
