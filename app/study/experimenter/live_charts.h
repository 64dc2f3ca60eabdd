// Charts of the trials so far in one condition: levels by trial, and the fitted function.
#pragma once

#include "engine/study/results/study_results.h"

namespace springdrive::app::study_screen {

/// In the present panel, side by side, as high as it leaves room.
void draw_live_charts(const study::Protocol &protocol, const study::SeriesResult &result);

} // namespace springdrive::app::study_screen
