#include "app/exhibit/course.h"

namespace springdrive::app::exhibit {

CourseOrders Course::update(const CourseNow &now) {
    CourseOrders orders;
    if (!before_s_) {
        since_s_ = now.time_s;
    }
    const double before_s = before_s_.value_or(now.time_s);
    before_s_ = now.time_s;
    leaves_in_s_.reset();
    if (now.time_s - before_s > kGap_s) {
        orders.gap_s = now.time_s - before_s;
        end_visit(orders, now.time_s);
        return orders; // what was touched was touched before it
    }
    if (now.is_touched) {
        touched_s_ = now.time_s;
    }
    if (now.next_visitor) {
        begin_visit(orders, now.time_s);
        return orders;
    }
    switch (stage_) {
    case Stage::attract:
        attract(now, orders);
        break;
    case Stage::showing:
        show_scene(now, orders);
        break;
    case Stage::your_turn:
        let_visitor(now, orders);
        break;
    }
    return orders;
}

void Course::enter(Stage stage, double time_s) {
    stage_ = stage;
    since_s_ = time_s;
    shown_s_.reset();
}

void Course::stop_performing(CourseOrders &orders) {
    orders.leaves = orders.leaves || is_performing_;
    is_performing_ = false;
}

void Course::show(std::size_t scene, CourseOrders &orders, double time_s) {
    stop_performing(orders);
    scene_ = scene;
    orders.scene = scene;
    since_s_ = time_s;
    shown_s_.reset();
}

void Course::begin_visit(CourseOrders &orders, double time_s) {
    ++visitors_;
    enter(Stage::showing, time_s);
    show(0, orders, time_s);
    orders.resets = true;
    orders.visit_begins = true;
    touched_s_ = time_s;
}

void Course::end_visit(CourseOrders &orders, double time_s) {
    enter(Stage::attract, time_s);
    show(0, orders, time_s);
    orders.resets = true;
}

bool Course::never_begins(const CourseNow &now) const {
    return !is_performing_ && now.time_s - since_s_ >= kLoadTimeout_s;
}

/// Begins once the scene is ready, and anew after a stop.
void Course::perform(const CourseNow &now, CourseOrders &orders) {
    if (is_performing_) {
        since_s_ = now.time_s; // the patience begins anew with a stop
    }
    if (is_performing_ && !now.is_ready) {
        stop_performing(orders);
    } else if (!is_performing_ && now.is_ready) {
        is_performing_ = true;
        orders.performs = true;
    }
}

void Course::attract(const CourseNow &now, CourseOrders &orders) {
    if (now.is_touched) {
        begin_visit(orders, now.time_s);
        return;
    }
    if (shown_s_) {
        if (now.time_s - *shown_s_ >= kBetween_s) {
            show((scene_ + 1) % scenes_, orders, now.time_s);
        }
        return;
    }
    if (is_performing_ && now.is_shown) {
        is_performing_ = false;
        shown_s_ = now.time_s;
        return;
    }
    if (never_begins(now)) { // its file may be damaged
        show((scene_ + 1) % scenes_, orders, now.time_s);
        return;
    }
    perform(now, orders);
}

void Course::show_scene(const CourseNow &now, CourseOrders &orders) {
    if (now.next_scene) {
        show((scene_ + 1) % scenes_, orders, now.time_s);
        return;
    }
    const bool is_over = is_performing_ && now.is_shown;
    if (is_over || never_begins(now) || now.takes_hand) {
        is_performing_ = is_performing_ && !is_over;
        stop_performing(orders);
        enter(Stage::your_turn, now.time_s);
        touched_s_ = now.time_s; // nothing was to be done until now
        return;
    }
    perform(now, orders);
}

void Course::let_visitor(const CourseNow &now, CourseOrders &orders) {
    if (now.next_scene) {
        enter(Stage::showing, now.time_s);
        show((scene_ + 1) % scenes_, orders, now.time_s);
        return;
    }
    const double idle_s = now.time_s - touched_s_;
    if (idle_s >= kIdle_s + kIdlePrompt_s) {
        end_visit(orders, now.time_s);
    } else if (idle_s >= kIdle_s) {
        leaves_in_s_ = kIdle_s + kIdlePrompt_s - idle_s;
    }
}

} // namespace springdrive::app::exhibit
