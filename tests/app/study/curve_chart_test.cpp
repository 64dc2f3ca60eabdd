// Covers app/study/participant/curve_chart.cpp, and where participant_layout.cpp puts a curve.
#include "app/study/participant/curve_chart.h"

#include "tests/app/study/sound_layout.h"

#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <cmath>

namespace springdrive::app::study_screen {
namespace {

OwnCurve sample_curve() {
    OwnCurve curve;
    curve.lowest_level = 2.0;
    curve.highest_level = 60.0;
    curve.ticks = {2.0, 5.0, 10.0, 20.0, 30.0, 60.0};
    curve.level_label = "how far the force was turned (degrees)";
    curve.share_label = "right answers";
    for (double level = 2.0; level <= 60.0; level *= 1.1) {
        const double share = 1.0 - 0.5 * std::exp(-std::pow(level / 15.0, 2.0));
        curve.course.push_back({level, share, share - 0.1, std::min(1.0, share + 0.1)});
    }
    curve.dots = {{2.0, 0.0, 1}, {11.0, 0.5, 4}, {20.0, 0.75, 16}, {60.0, 1.0, 3}};
    curve.threshold = {15.0, 9.0, 24.0};
    return curve;
}

CurveChart chart_in(const Rectangle &box, float text_px) {
    Letters &letters = letters_of(kScreenSizes[0]);
    letters.prepare(kScreenSizes[0].height, {});
    return arranged(sample_curve(), box, letters.font(text_px), text_px);
}

constexpr double kRoundOff_px = 1e-4; ///< three of a float below 1024, of 3e-5 each

TEST(CurveChart, PutsLevelsOnALogarithmicAxisAndSharesOnALinearOne) {
    const OwnCurve curve = sample_curve();
    const CurveChart chart = chart_in({{100, 50}, {800, 400}}, 20.0F);
    const Rectangle &plot = chart.plot;
    // 10 is the geometric mean of 5 and 20, and of 2 and 50.
    const float x = chart.x_px(curve, 10.0);
    EXPECT_NEAR(x, 0.5F * (chart.x_px(curve, 5.0) + chart.x_px(curve, 20.0)), kRoundOff_px);
    EXPECT_NEAR(x, 0.5F * (chart.x_px(curve, 2.0) + chart.x_px(curve, 50.0)), kRoundOff_px);
    EXPECT_FLOAT_EQ(chart.y_px(0.5), plot.corner.y + 0.5F * plot.size.y);
    EXPECT_FLOAT_EQ(chart.y_px(1.0), plot.corner.y);
    EXPECT_GT(chart.x_px(curve, 2.0), plot.corner.x);
    EXPECT_LT(chart.x_px(curve, 60.0), plot.corner.x + plot.size.x);
}

TEST(CurveChart, AreaOfADotIsItsNumberOfAnswers) {
    EXPECT_NEAR(std::pow(dot_radius_px(8, 400.0F) / dot_radius_px(2, 400.0F), 2.0), 4.0,
                1e-6); // four roundings of a float, of 6e-8 each, of 4
    EXPECT_EQ(dot_radius_px(kFullTrials, 400.0F), dot_radius_px(5 * kFullTrials, 400.0F));
    EXPECT_GT(dot_radius_px(1, 374.0F), 4.0F) << "one answer on a small screen has to be seen";
}

TEST(CurveChart, KeepsAllOfItInItsBox) {
    for (const auto &[box, text_px] : {std::pair{Rectangle{{190, 144}, {900, 374}}, 20.0F},
                                       std::pair{Rectangle{{285, 216}, {1350, 562}}, 29.0F}}) {
        const CurveChart chart = chart_in(box, text_px);
        EXPECT_TRUE(is_within(chart.plot, box));
        for (std::size_t i = 0; i < chart.labels.size(); ++i) {
            EXPECT_TRUE(is_within(chart.labels[i].box, box)) << i;
            for (std::size_t k = 0; k < i; ++k) {
                EXPECT_FALSE(overlap(chart.labels[i].box, chart.labels[k].box)) << k << ", " << i;
            }
        }
        ImDrawListSharedData shared;
        shared.SetCircleTessellationMaxError(0.3F);
        ImDrawList list(&shared);
        list._ResetForNewFrame();
        list.PushClipRect({0, 0}, {2000, 1000});
        draw_curve(chart, sample_curve(), list);
        ASSERT_GT(list.VtxBuffer.Size, 900);
        // Dots at 0 % and 100 % stand out of the plot by their radius.
        for (const ImDrawVert &vertex : list.VtxBuffer) {
            EXPECT_TRUE(box.contains(vertex.pos)) << vertex.pos.x << ", " << vertex.pos.y;
        }
    }
}

TEST(CurveChart, IsReadableWithTheWordsOfAVisitorsResult) {
    ParticipantPicture picture;
    picture.heading = "The made-up visitor feels a force that is turned by 48 degrees (39 to 58).";
    picture.text = "In truth it was 25 degrees. Larger dots are more answers.\n"
                   "Nothing of this is kept: no answer, no name, no file.";
    picture.choices = {{"Next visitor", "↵"}};
    picture.curve = sample_curve();
    for (const ScreenSize &size : {kScreenSizes[0], kScreenSizes[1]}) {
        const ParticipantLayout layout = laid_out(picture, size);
        const Rectangle &plot = layout.curve.plot;
        EXPECT_TRUE(layout.is_readable) << size.width;
        EXPECT_GT(plot.size.x, 0.5F * static_cast<float>(size.width));
        ASSERT_EQ(layout.choices.size(), 1U);
        EXPECT_LT(layout.text.box.corner.y + layout.text.box.size.y, plot.corner.y);
    }
}

} // namespace
} // namespace springdrive::app::study_screen
