// The present participant's trials in one condition and what has been fitted to them so far,
// computed beside the frames.
#pragma once

#include "engine/study/results/study_results.h"
#include "engine/study/store/study_contents.h"

#include <cstddef>
#include <future>
#include <optional>
#include <string>

namespace springdrive::app::study_screen {

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

} // namespace springdrive::app::study_screen
