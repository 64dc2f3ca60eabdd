#include "app/stage/hand_lift.h"

#include <algorithm>

namespace springdrive::app {

void HandLift::update(session::Session &session, bool is_inside, double frame_s) {
    if (!is_on()) {
        return;
    }
    constexpr double kMaxFrame_s = 0.1; // after a pause, no jump
    const double step_m = kSpeed_m_per_s * std::min(frame_s, kMaxFrame_s);
    const contact::Contact &contact = session.latest().contact;
    const Vector3 before_m = session.hand().target_m();
    session.hand().move_to(before_m +
                           step_m * (contact.touching ? contact.normal : Vector3::UnitY()));
    const bool has_moved = session.hand().target_m() != before_m;
    if (!has_moved || session.hand().follows_path()) {
        stop();
    } else if (!contact.touching && !is_inside) {
        left_m_ = std::max(0.0, left_m_ - step_m);
    }
}

} // namespace springdrive::app
