#include "app/exhibit/guide.h"

namespace springdrive::app::exhibit {

void Guide::begin(const Stagecraft &stage) {
    performer_.emplace(stage.session);
    course_.emplace(kTour.size());
    performer_->show(stage, kTour.front());
    had_scene_ = false;
}

void Guide::end(const Stagecraft &stage) {
    if (is_on()) {
        performer_->leave(stage);
        performer_->restore_gains(stage);
        course_.reset();
    }
}

void Guide::update(const Stagecraft &stage, double time_s) {
    if (!is_on()) {
        return;
    }
    const bool has_scene = performer_->has_scene(stage.session);
    if (had_scene_ && !has_scene && !stage.session.scenes().is_loading()) {
        end(stage); // somebody wanted another one
        return;
    }
    had_scene_ = had_scene_ || has_scene;
    const std::size_t before = course_->scene();
    const CourseOrders orders = course_->update(performer_->now(stage.session, time_s));
    if (orders.scene && before + 1 == kTour.size()) {
        end(stage); // all were shown
        return;
    }
    had_scene_ = had_scene_ && !orders.scene;
    performer_->carry_out(orders, *course_, stage, time_s);
}

} // namespace springdrive::app::exhibit
