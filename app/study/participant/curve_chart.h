// How an OwnCurve is arranged in a box: everything in it is a plate or a text. Without OpenGL.
#pragma once

#include "app/study/participant/choice_plates.h"
#include "app/study/participant/own_curve.h"
#include "app/study/participant/pixel_box.h"
#include "app/view/plate_painter.h"

#include <vector>

namespace springdrive::app::study_screen {

struct CurveChart {
    std::vector<Plate> plates;     ///< one over the other
    std::vector<PlacedText> texts; ///< over them all
    PixelBox plot;                 ///< within the axes

    [[nodiscard]] double x_px(const OwnCurve &curve, double level) const;
    [[nodiscard]] double y_px(double right_share) const;
};

/// Radius of a dot: its area is proportional to the trials, and one of `kFullTrials` has the
/// largest radius; more are not drawn larger. @param height_px  of the plot
[[nodiscard]] double dot_radius_px(int trials, double height_px);
inline constexpr int kFullTrials = 16;

/// @param text_px  of all labels. @pre the box is not empty, 0 < lowest_level < highest_level
[[nodiscard]] CurveChart arranged(const OwnCurve &curve, const PixelBox &box, double text_px,
                                  const Typeface &typeface);

} // namespace springdrive::app::study_screen
