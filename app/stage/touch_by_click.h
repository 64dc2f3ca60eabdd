// Touch where one clicks: the simulated hand's way to a point of the surface, the press there, the
// slide after the cursor, and the way off.
//
//   press ──► leave what is touched ──► round what is in the way ──► above the point ──► into it
//   aim   ──► along the surface; or off it and round, where something is in between
//   let_go ─► off the surface
//
// It asks for places of the hand only, at bounded speeds: what moves there is the hand, whose force
// is limited, and the servo treats it as any other.
#pragma once

#include "app/view/view_state.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/session/session.h"

#include <deque>
#include <optional>
#include <vector>

namespace springdrive::app {

/// Where the hand moves.
struct TouchGround {
    const contact::HapticSurface &surface;
    Vector3 lower_m; ///< of a box that contains the surface
    Vector3 upper_m;
    device::Workspace workspace;
};

/// Points through which the hand gets from one place to another, the last of which is `to_m`:
/// straight if nothing is in the way; else past a side of the scene's box, if one of them will do;
/// else over its top, whatever is there.
[[nodiscard]] std::vector<Vector3> way_round(const TouchGround &ground, const Vector3 &from_m,
                                             const Vector3 &to_m);

class TouchByClick {
public:
    /// How far the hand's target is pressed below the surface at first: with a relaxed hand of
    /// 300 N/m some 1.5 N, far from its 5 N and the limits of the device.
    static constexpr double kGentle_m = 0.006;
    static constexpr double kMin_m = 0.001;
    static constexpr double kDeepest_m = 0.020;

    /// Goes there and presses. @param hand_m  the hand's target now
    void press(const TouchGround &ground, const contact::Contact &now, const Vector3 &hand_m,
               const SurfacePlace &where);
    /// While pressed: there instead.
    void aim(const TouchGround &ground, const contact::Contact &now, const SurfacePlace &where);
    /// While pressed: by that much more, within limits.
    void deepen(double by_m);
    /// Lifts the hand off, if it is down; else leaves it where it is.
    void let_go(const TouchGround &ground, const contact::Contact &now);
    void stop();

    [[nodiscard]] bool is_on() const { return is_on_; }
    [[nodiscard]] bool is_pressed() const { return is_pressed_; }

    /// Where the hand is to be next, after that time. @pre is_on()
    [[nodiscard]] Vector3 next_m(double frame_s);

private:
    struct Leg {
        Vector3 to_m{Vector3::Zero()};
        double speed_m_per_s = 0.0;
        bool is_down = false; ///< in contact, or about to be
    };

    [[nodiscard]] Vector3 inside_m(const SurfacePlace &place) const {
        return place.point_m - depth_m_ * place.normal;
    }
    [[nodiscard]] bool is_down() const { return way_.empty() || way_.front().is_down; }
    void approach(const TouchGround &ground, const contact::Contact &now);

    std::deque<Leg> way_;
    SurfacePlace aim_;
    Vector3 at_m_{Vector3::Zero()}; ///< of the hand's target
    double depth_m_ = kGentle_m;
    bool is_on_ = false;
    bool is_pressed_ = false;
};

class HandRetraction {
public:
    void start() { left_m_ = kClear_m; }
    void stop() { left_m_ = 0.0; }
    [[nodiscard]] bool is_on() const { return left_m_ > 0.0; }

    /// Once a frame: along the normal while the tip touches, else upwards, until the tip is clear
    /// of the surface by some distance, or the hand cannot get further.
    /// @param is_inside  whether the tip lies in a solid
    void update(session::Session &session, bool is_inside, double frame_s);

private:
    static constexpr double kSpeed_m_per_s = 0.06;
    static constexpr double kClear_m = 0.01;

    double left_m_ = 0.0; ///< to go in free space; 0: it is off
};

} // namespace springdrive::app
