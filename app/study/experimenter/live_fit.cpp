#include "app/study/experimenter/live_fit.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace springdrive::app::study_screen {

void LiveFit::begin(study::Series series) {
    running_ = std::async(std::launch::async,
                          [protocol = protocol_, series = std::move(series)]() mutable {
                              return study::result_of(protocol, std::move(series));
                          });
}

void LiveFit::request(const study::StudyContents &contents, const std::string &participant,
                      std::size_t condition, study::DeviceKind device) {
    for (study::Series &series : study::series_of(protocol_, contents, device)) {
        if (series.participant != participant || series.condition != condition) {
            continue;
        }
        if (running_.valid()) {
            next_ = std::move(series);
        } else {
            begin(std::move(series));
        }
        return;
    }
    latest_.reset(); // none yet in this condition
}

const study::SeriesResult *LiveFit::latest() {
    if (running_.valid() &&
        running_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        latest_ = running_.get();
        if (next_) {
            begin(*std::exchange(next_, std::nullopt));
        }
    }
    return latest_ ? &*latest_ : nullptr;
}

} // namespace springdrive::app::study_screen
