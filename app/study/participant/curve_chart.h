// An OwnCurve in a box of the participant's screen.
#pragma once

#include "app/study/participant/letters.h"
#include "app/study/participant/own_curve.h"

#include <vector>

namespace springdrive::app::study_screen {

struct CurveChart {
    Rectangle plot; ///< within the axes
    std::vector<TextLines> labels;
    float line_px = 1.0F; ///< thickness of lines

    [[nodiscard]] float x_px(const OwnCurve &curve, double level) const;
    [[nodiscard]] float y_px(double right_share) const;
};

/// Radius of a dot: its area is proportional to the trials, and one of `kFullTrials` has the
/// largest radius; more are not drawn larger. @param height_px  of the plot
[[nodiscard]] float dot_radius_px(int trials, float height_px);
inline constexpr int kFullTrials = 16;

/// Everything is within the box. @param text_px  of all labels
/// @pre the box is not empty, 0 < lowest_level < highest_level
[[nodiscard]] CurveChart arranged(const OwnCurve &curve, const Rectangle &box, const ImFont &font,
                                  float text_px);

/// Without the labels.
void draw_curve(const CurveChart &chart, const OwnCurve &curve, ImDrawList &list);

} // namespace springdrive::app::study_screen
