#include "app/stage/touch_by_click.h"

#include "app/view/pick.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app {

namespace {

// Of the hand's target. The hand itself follows at 0.4 m/s at most, smoothly round corners.
constexpr double kTravel_m_per_s = 0.25;
constexpr double kSlide_m_per_s = 0.15;
constexpr double kLeave_m_per_s = 0.10;
constexpr double kPress_m_per_s = 0.06;

constexpr double kAbove_m = 0.015;  // over the surface, before the press and after it
constexpr double kClear_m = 0.002;  // kept from what is passed
constexpr double kBeside_m = 0.010; // of the box, on the way round it
constexpr double kLow_m = 0.003;    // over the surface, where a slide is tried

constexpr double kMaxStep_s = 0.1; // after a pause, no jump

bool is_way_free(const TouchGround &ground, const Vector3 &from_m, const Vector3 &to_m,
                 double clear_m = kClear_m) {
    return !first_touchable(ground.surface, from_m, to_m, clear_m);
}

/// Over a place of the surface, or half-way to what is there.
Vector3 above(const TouchGround &ground, const SurfacePlace &place, double height_m) {
    const Vector3 from_m = place.point_m + 1e-5 * place.normal;
    const auto ceiling =
        first_touchable(ground.surface, from_m, place.point_m + 2.0 * height_m * place.normal);
    const double free_m = ceiling ? (ceiling->point_m - place.point_m).dot(place.normal) : INFINITY;
    return place.point_m + std::min(height_m, 0.5 * free_m) * place.normal;
}

SurfacePlace place_of(const contact::Contact &contact) { return {contact.x0_m, contact.normal}; }

} // namespace

std::vector<Vector3> way_round(const TouchGround &ground, const Vector3 &from_m,
                               const Vector3 &to_m) {
    if (is_way_free(ground, from_m, to_m)) {
        return {to_m};
    }
    struct Side {
        int axis;
        bool is_upper;
    };
    // From above first; then from the user's side, where one sees it; the back is the base's.
    constexpr std::array<Side, 6> kSides{
        {{1, true}, {2, true}, {0, true}, {0, false}, {1, false}, {2, false}}};
    const Vector3 half_m = 0.5 * ground.workspace.size_m;
    std::vector<Vector3> over_top;
    for (const Side &side : kSides) {
        const double beside_m = side.is_upper ? ground.upper_m[side.axis] + kBeside_m
                                              : ground.lower_m[side.axis] - kBeside_m;
        const double middle_m = ground.workspace.centre_m[side.axis];
        const double within_m =
            std::clamp(beside_m, middle_m - half_m[side.axis], middle_m + half_m[side.axis]);
        Vector3 out_m = from_m;
        Vector3 back_m = to_m;
        out_m[side.axis] = within_m;
        back_m[side.axis] = within_m;
        const std::vector<Vector3> way{out_m, back_m, to_m};
        if (is_way_free(ground, from_m, out_m) && is_way_free(ground, out_m, back_m) &&
            is_way_free(ground, back_m, to_m)) {
            return way;
        }
        over_top = over_top.empty() ? way : over_top;
    }
    return over_top;
}

void TouchByClick::press(const TouchGround &ground, const contact::Contact &now,
                         const Vector3 &hand_m, const SurfacePlace &where) {
    at_m_ = hand_m;
    depth_m_ = kGentle_m;
    aim_ = where;
    is_on_ = true;
    is_pressed_ = true;
    approach(ground, now);
}

/// From where the hand is.
void TouchByClick::approach(const TouchGround &ground, const contact::Contact &now) {
    way_.clear();
    Vector3 from_m = at_m_;
    if (now.touching) {
        from_m = above(ground, place_of(now), kAbove_m);
        way_.push_back({from_m, kLeave_m_per_s, false});
    }
    for (const Vector3 &point_m : way_round(ground, from_m, above(ground, aim_, kAbove_m))) {
        way_.push_back({point_m, kTravel_m_per_s, false});
    }
    way_.push_back({inside_m(aim_), kPress_m_per_s, true});
}

void TouchByClick::aim(const TouchGround &ground, const contact::Contact &now,
                       const SurfacePlace &where) {
    if (!is_pressed_ || (where.point_m == aim_.point_m && where.normal == aim_.normal)) {
        return;
    }
    const Vector3 last_m = above(ground, aim_, kLow_m);
    const Vector3 next_m = above(ground, where, kLow_m);
    aim_ = where;
    if (!is_down()) {
        approach(ground, now);
        return;
    }
    constexpr double kGrazing_m = 1e-4;
    const Vector3 here_m = now.touching ? above(ground, place_of(now), kLow_m) : last_m;
    if (is_way_free(ground, here_m, next_m, kGrazing_m)) {
        way_.clear(); // what the cursor passed on its way no longer counts
    } else if (!is_way_free(ground, last_m, next_m, kGrazing_m)) {
        approach(ground, now);
        return;
    }
    way_.push_back({inside_m(aim_), kSlide_m_per_s, true});
}

void TouchByClick::deepen(double by_m) {
    if (!is_pressed_) {
        return;
    }
    depth_m_ = std::clamp(depth_m_ + by_m, kMin_m, kDeepest_m);
    if (!way_.empty()) {
        way_.pop_back(); // into the surface by the former depth
    }
    way_.push_back({inside_m(aim_), kPress_m_per_s, true});
}

void TouchByClick::let_go(const TouchGround &ground, const contact::Contact &now) {
    const bool was_down = is_on_ && (is_down() || now.touching);
    stop();
    if (was_down) {
        const SurfacePlace place = now.touching ? place_of(now) : aim_;
        way_.push_back({above(ground, place, kAbove_m), kLeave_m_per_s, false});
        is_on_ = true;
    }
}

void TouchByClick::stop() {
    way_.clear();
    is_on_ = false;
    is_pressed_ = false;
}

Vector3 TouchByClick::next_m(double frame_s) {
    double left_s = std::clamp(frame_s, 0.0, kMaxStep_s);
    while (!way_.empty() && left_s > 0.0) {
        const Leg &leg = way_.front();
        const Vector3 gap_m = leg.to_m - at_m_;
        const double needs_s = gap_m.norm() / leg.speed_m_per_s;
        if (needs_s > left_s) {
            at_m_ += left_s / needs_s * gap_m;
            break;
        }
        at_m_ = leg.to_m;
        left_s -= needs_s;
        way_.pop_front();
    }
    is_on_ = is_pressed_ || !way_.empty();
    return at_m_;
}

void HandRetraction::update(session::Session &session, bool is_inside, double frame_s) {
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
