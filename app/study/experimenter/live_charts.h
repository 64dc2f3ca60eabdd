// The trials so far in one condition: what is fitted to them beside the frames, and charts of them:
// levels by trial, and the fitted function.
#pragma once

#include "engine/study/results/study_results.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <future>
#include <optional>
#include <string>

namespace springdrive::app::study_screen {

/// What has been fitted so far to the present participant's trials in one condition.
class LiveFit {
public:
    explicit LiveFit(const study::Protocol &protocol) : protocol_(protocol) {}

    /// Begins a fit of that participant's condition, unless one runs: then afterwards.
    void request(const study::StudyContents &contents, const std::string &participant,
                 std::size_t condition, study::DeviceKind device);

    /// The newest that is ready; null before the first. Call once a frame.
    [[nodiscard]] const study::SeriesResult *latest();

private:
    void begin(study::Series series);

    study::Protocol protocol_;
    std::optional<study::Series> next_;
    std::future<study::SeriesResult> running_;
    std::optional<study::SeriesResult> latest_;
};

/// In the present panel, side by side, as high as it leaves room.
void draw_live_charts(const study::Protocol &protocol, const study::SeriesResult &result);

} // namespace springdrive::app::study_screen
