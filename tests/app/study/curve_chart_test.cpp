// Covers app/study/participant/curve_chart.cpp, and where participant_layout.cpp puts a curve.
#include "app/study/participant/curve_chart.h"

#include "app/study/participant/participant_layout.h"

#include <gtest/gtest.h>

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

bool is_within(const PixelBox &inner, const PixelBox &outer) {
    return inner.x >= outer.x && inner.y >= outer.y &&
           inner.x + inner.width <= outer.x + outer.width &&
           inner.y + inner.height <= outer.y + outer.height;
}

TEST(CurveChart, PutsLevelsOnALogarithmicAxisAndSharesOnALinearOne) {
    const Typeface typeface;
    const OwnCurve curve = sample_curve();
    const CurveChart chart = arranged(curve, {100, 50, 800, 400}, 20.0, typeface);
    // 10 is the geometric mean of 5 and 20, and of 2 and 50.
    const double x = chart.x_px(curve, 10.0);
    EXPECT_NEAR(x, 0.5 * (chart.x_px(curve, 5.0) + chart.x_px(curve, 20.0)), 1e-9);
    EXPECT_NEAR(x, 0.5 * (chart.x_px(curve, 2.0) + chart.x_px(curve, 50.0)), 1e-9);
    EXPECT_DOUBLE_EQ(chart.y_px(0.5), chart.plot.y + 0.5 * chart.plot.height);
    EXPECT_DOUBLE_EQ(chart.y_px(1.0), chart.plot.y);
    EXPECT_GT(chart.x_px(curve, 2.0), chart.plot.x);
    EXPECT_LT(chart.x_px(curve, 60.0), chart.plot.x + chart.plot.width);
}

TEST(CurveChart, AreaOfADotIsItsNumberOfAnswers) {
    EXPECT_NEAR(std::pow(dot_radius_px(8, 400.0) / dot_radius_px(2, 400.0), 2.0), 4.0, 1e-12);
    EXPECT_EQ(dot_radius_px(kFullTrials, 400.0), dot_radius_px(5 * kFullTrials, 400.0));
    EXPECT_GT(dot_radius_px(1, 374.0), 4.0) << "one answer on a small screen has to be seen";
}

TEST(CurveChart, KeepsAllOfItInItsBox) {
    const Typeface typeface;
    const OwnCurve curve = sample_curve();
    for (const auto &[box, text_px] : {std::pair{PixelBox{190, 144, 900, 374}, 21.0},
                                       std::pair{PixelBox{285, 216, 1350, 562}, 32.0}}) {
        const CurveChart chart = arranged(curve, box, text_px, typeface);
        EXPECT_TRUE(is_within(chart.plot, box));
        for (const PlacedText &text : chart.texts) {
            EXPECT_TRUE(is_within(text.box, box)) << text.box.x << ", " << text.box.y;
        }
        // Dots at 0 % and 100 % stand out of the plot by their radius, and touch no label.
        for (const Plate &plate : chart.plates) {
            EXPECT_GE(plate.corner_px.x, static_cast<float>(box.x));
            EXPECT_GE(plate.corner_px.y, static_cast<float>(box.y));
            EXPECT_LE(plate.corner_px.x + plate.size_px.x, static_cast<float>(box.x + box.width));
            EXPECT_LE(plate.corner_px.y + plate.size_px.y, static_cast<float>(box.y + box.height));
        }
        for (std::size_t i = 0; i < chart.texts.size(); ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                const PixelBox &a = chart.texts[i].box;
                const PixelBox &b = chart.texts[k].box;
                EXPECT_FALSE(a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
                             b.y < a.y + a.height)
                    << "labels " << k << " and " << i << " overlap";
            }
        }
    }
}

TEST(CurveChart, IsReadableWithTheWordsOfAVisitorsResult) {
    const Typeface typeface;
    ParticipantPicture picture;
    picture.heading = "The made-up visitor feels a force that is turned by 48 degrees (39 to 58).";
    picture.text = "In truth it was 25 degrees. Larger dots are more answers.\n"
                   "Nothing of this is kept: no answer, no name, no file.";
    picture.choices = {{"Next visitor", "↵"}};
    picture.curve = sample_curve();
    for (const auto &[width, height] : {std::pair{1280, 720}, std::pair{1920, 1080}}) {
        const ParticipantLayout layout = lay_out(picture, width, height, typeface);
        EXPECT_TRUE(layout.is_readable) << width;
        EXPECT_GT(layout.curve.plot.width, width / 2) << width;
        ASSERT_EQ(layout.choices.size(), 1U);
        EXPECT_LT(layout.text.box.y + layout.text.box.height, layout.curve.plot.y) << width;
    }
}

} // namespace
} // namespace springdrive::app::study_screen
