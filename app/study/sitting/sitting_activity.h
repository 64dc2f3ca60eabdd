// A sitting, or visits, frame by frame in the windows in which they take place.
#pragma once

#include "app/stage/frame_loop.h"
#include "app/study/sitting/sitting_state.h"

#include <utility>

namespace springdrive::app::study_screen {

/// @tparam Resumed  a Sitting, or what is resumed like one
/// @tparam Windows  such as StudyWindow
template <typename Resumed, typename Windows> class SittingActivity : public Activity {
public:
    /// Starts it. Both must outlive this.
    SittingActivity(Resumed &resumed, Windows &windows) : resumed_(resumed), windows_(windows) {
        resumed.start();
    }

    [[nodiscard]] bool is_over() const override { return resumed_.is_over(); }
    void draw() override { frame_ = windows_.show(resumed_.picture(), resumed_.state()); }
    void update() override { resumed_.resume(std::move(frame_)); }
    [[nodiscard]] ReportedWindow reported() const override { return windows_.reported(); }

private:
    Resumed &resumed_;
    Windows &windows_;
    SittingFrame frame_;
};

} // namespace springdrive::app::study_screen
