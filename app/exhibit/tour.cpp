#include "app/exhibit/tour.h"

#include "app/host/folders.h"
#include "base/input_error.h"
#include "engine/scene/scripted_touch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::app::exhibit {

namespace {

constexpr double kOver_m = 0.012;  ///< from a surface to a tip that is free
constexpr double kDepth_m = 0.006; ///< of the hand's target: presses with 1 to 2 N
constexpr double kHold_s = 1.0;
constexpr double kCompare_s = 2.5; ///< with each map

/// A path as it is drawn: from point to point at a speed.
class Stylus {
public:
    explicit Stylus(const Vector3 &from_m) : points_{{0.0, from_m}} {}

    void go(const Vector3 &to_m, double speed_m_per_s) {
        const double way_m = (to_m - points_.back().position_m).norm();
        constexpr double kMin_m = 1e-6;
        if (way_m > kMin_m) {
            points_.push_back({now_s() + way_m / speed_m_per_s, to_m});
        }
    }
    void rest(double seconds) { points_.push_back({now_s() + seconds, points_.back().position_m}); }

    [[nodiscard]] double now_s() const { return points_.back().time_s; }
    [[nodiscard]] const Vector3 &at_m() const { return points_.back().position_m; }
    [[nodiscard]] const std::vector<simulated::HandPath::Point> &points() const { return points_; }

private:
    std::vector<simulated::HandPath::Point> points_;
};

class Hand {
public:
    Hand(const device::DeviceDescription &device, const scene::Scene &scene,
         const contact::HapticSurface &surface, const Vector3 &from_m)
        : device_(device), scene_(scene), probe_(surface, {scene.lower_m, scene.upper_m}, 0.0),
          above_m_(scene::start_above(device, scene.lower_m, scene.upper_m)), stylus_(from_m) {}

    /// Up, or past the side of what is above the tip, and to above the scene.
    void go_above() {
        const Vector3 from_m = stylus_.at_m();
        if (from_m.y() < above_m_.y()) {
            const Vector3 out_m = beside(from_m);
            stylus_.go(out_m, kTransit_m_per_s);
            stylus_.go(at_height(out_m, above_m_.y()), kTransit_m_per_s);
        }
        stylus_.go(above_m_, kTransit_m_per_s);
    }

    void show(Gesture gesture) {
        switch (gesture) {
        case Gesture::stroke:
            stroke();
            break;
        case Gesture::strike:
            strike();
            break;
        case Gesture::press_each:
            press_each();
            break;
        case Gesture::compare:
            compare();
            break;
        }
        stylus_.go(above_m_, kTransit_m_per_s);
    }

    [[nodiscard]] bool is_in_reach() const { // but for where it is already
        return std::all_of(stylus_.points().begin() + 1, stylus_.points().end(),
                           [this](const simulated::HandPath::Point &point) {
                               return device::can_reach(device_, point.position_m);
                           });
    }
    [[nodiscard]] simulated::HandPath path() const { return simulated::HandPath(stylus_.points()); }
    std::vector<double> switches_s;

private:
    [[nodiscard]] static Vector3 at_height(const Vector3 &point_m, double y_m) {
        return {point_m.x(), y_m, point_m.z()};
    }

    /// The same place if nothing is above it, else one beside the scene from where the way up is
    /// free.
    [[nodiscard]] Vector3 beside(const Vector3 &from_m) const {
        const auto is_free_above = [&](const Vector3 &point_m) {
            return !probe_.first_touch(point_m, at_height(point_m, above_m_.y()));
        };
        if (is_free_above(from_m)) {
            return from_m;
        }
        std::vector<Vector3> sides{{scene_.upper_m.x() + kOver_m, from_m.y(), from_m.z()},
                                   {scene_.lower_m.x() - kOver_m, from_m.y(), from_m.z()},
                                   {from_m.x(), from_m.y(), scene_.upper_m.z() + kOver_m},
                                   {from_m.x(), from_m.y(), scene_.lower_m.z() - kOver_m}};
        std::ranges::sort(sides, {}, [&](const Vector3 &side) { return (side - from_m).norm(); });
        for (const Vector3 &side : sides) {
            if (device::can_reach(device_, side) &&
                device::can_reach(device_, at_height(side, above_m_.y())) &&
                !probe_.first_touch(from_m, side) && is_free_above(side)) {
                return side;
            }
        }
        return from_m;
    }

    /// Straight below a place over the scene; its box's floor where nothing is.
    [[nodiscard]] Vector3 below(double x_m, double z_m) const {
        const Vector3 top_m(x_m, scene_.upper_m.y() + kOver_m, z_m);
        const Vector3 floor_m(x_m, scene_.lower_m.y(), z_m);
        return probe_.first_touch(top_m, floor_m).value_or(floor_m);
    }

    [[nodiscard]] Vector3 middle() const {
        const Vector3 middle_m = 0.5 * (scene_.lower_m + scene_.upper_m);
        return below(middle_m.x(), middle_m.z());
    }

    void go_over(const Vector3 &spot_m, const Vector3 &normal) {
        const Vector3 over_m = spot_m + kOver_m * normal;
        stylus_.go(at_height(over_m, std::max(over_m.y(), above_m_.y())), kTransit_m_per_s);
        stylus_.go(over_m, kTransit_m_per_s);
    }

    void press(const Vector3 &spot_m, const Vector3 &normal) {
        go_over(spot_m, normal);
        stylus_.go(spot_m - kDepth_m * normal, kPress_m_per_s);
    }

    void lift(const Vector3 &normal) {
        stylus_.go(stylus_.at_m() + (kOver_m + kDepth_m) * normal, kTransit_m_per_s);
    }

    /// Along the longer side of the scene, under its surface as seen from above.
    void stroke() {
        const Vector3 spot_m = middle();
        press(spot_m, Vector3::UnitY());
        stylus_.rest(kHold_s);
        const Vector3 size_m = scene_.upper_m - scene_.lower_m;
        const bool goes_deep = size_m.z() > size_m.x();
        const Vector3 along = goes_deep ? Vector3::UnitZ() : Vector3::UnitX();
        constexpr double kMax_m = 0.03;
        const double half_m = std::min(kMax_m, 0.3 * (goes_deep ? size_m.z() : size_m.x()));
        constexpr double kStep_m = 0.002;
        const long steps = std::lround(half_m / kStep_m);
        const auto go_to = [&](long step) {
            const Vector3 place_m = spot_m + static_cast<double>(step) * kStep_m * along;
            Vector3 target_m = below(place_m.x(), place_m.z()) - kDepth_m * Vector3::UnitY();
            // Not down a cliff: it would fall on what is below.
            target_m.y() = std::max(target_m.y(), stylus_.at_m().y() - 2.0 * kStep_m);
            // Up a wall before over it, instead of through it.
            if (target_m.y() > stylus_.at_m().y()) {
                stylus_.go(at_height(stylus_.at_m(), target_m.y()), kStroke_m_per_s);
            }
            stylus_.go(target_m, kStroke_m_per_s);
        };
        long step = 0;
        for (const long end : {steps, -steps, 0L}) {
            while (step != end) {
                step += step < end ? 1 : -1;
                go_to(step);
            }
        }
        lift(Vector3::UnitY());
    }

    void strike() {
        constexpr int kBlows = 3;
        const Vector3 spot_m = middle();
        go_over(spot_m, Vector3::UnitY());
        for (int blow = 0; blow < kBlows; ++blow) {
            stylus_.go(spot_m + 2.0 * kOver_m * Vector3::UnitY(), kTransit_m_per_s);
            stylus_.go(spot_m - kDepth_m * Vector3::UnitY(), kStrike_m_per_s);
            stylus_.rest(0.5 * kHold_s);
        }
        lift(Vector3::UnitY());
    }

    void press_each() {
        for (const scene::Caption &caption : scene_.captions) {
            press(caption.at_m, Vector3::UnitY());
            stylus_.rest(kHold_s);
            lift(Vector3::UnitY());
        }
    }

    void compare() {
        const scene::TouchSpot spot =
            scene_.lesson.spot.value_or(scene::TouchSpot{middle(), Vector3::UnitY()});
        press(spot.point_m, spot.normal);
        stylus_.rest(kCompare_s);
        switches_s.push_back(stylus_.now_s());
        stylus_.rest(kCompare_s);
        switches_s.push_back(stylus_.now_s());
        stylus_.rest(kCompare_s);
        lift(spot.normal);
    }

    const device::DeviceDescription &device_;
    const scene::Scene &scene_;
    scene::SurfaceProbe probe_;
    Vector3 above_m_;
    Stylus stylus_;
};

constexpr double kWords_s = 8.0;      ///< for a scene that no hand shows
constexpr double kPathBegins_s = 0.2; ///< see Session::follow_path: from here to its first point

} // namespace

std::filesystem::path file_of(const TourStop &stop) {
    return asset_folder() / "scenes" / (std::string(stop.scene) + ".gltf");
}

std::string sentence_of(const TourStop &stop, const scene::Scene &scene) {
    return stop.sentence.empty() ? scene.lesson.feel : std::string(stop.sentence);
}

std::optional<Showing> showing_of(const device::DeviceDescription &device,
                                  const scene::Scene &scene, const contact::HapticSurface &surface,
                                  Gesture gesture, const Vector3 &from_m) {
    Hand hand(device, scene, surface, from_m);
    hand.go_above();
    hand.show(gesture);
    if (!hand.is_in_reach()) {
        return std::nullopt;
    }
    return Showing{hand.path(), hand.switches_s};
}

void ScriptedDemo::show(const ScriptContext &stage, const TourStop &stop) {
    restore_gains(stage);
    requested_ = file_of(stop);
    if (stage.session.scenes().is_loading() || !has_scene(stage.session)) {
        stage.session.request_scene(requested_);
    }
}

/// The lock is for changes by hand: back to the start one may always go.
void ScriptedDemo::restore_gains(const ScriptContext &stage) const {
    if (stage.session.tuning().now() == tuning_) {
        return;
    }
    const bool was_unlocked = std::exchange(stage.editor.is_unlocked, true);
    stage.editor.replace(tuning_, "of the start");
    stage.editor.is_unlocked = was_unlocked;
}

CourseNow ScriptedDemo::now(const session::Session &session, double time_s) const {
    const session::Scenes &scenes = session.scenes();
    CourseNow now;
    now.time_s = time_s;
    now.is_ready = !scenes.is_loading() && has_scene(session) &&
                   session.latest().scene_id == scenes.id() && !session.is_exchanging() &&
                   session.latest().safety.state == servo::SafetyState::running;
    now.is_shown = showing_ ? !session.hand().follows_path() : time_s >= words_until_s_;
    return now;
}

void ScriptedDemo::carry_out(const CourseOrders &orders, const Course &course,
                             const ScriptContext &stage, double time_s) {
    if (orders.leaves) {
        leave(stage);
    }
    if (orders.scene) {
        show(stage, kTour[*orders.scene]);
    }
    if (orders.performs) {
        perform(stage, kTour[course.scene()], time_s);
    }
    if (course.is_performing()) {
        switch_map_if_due(stage);
    }
}

void ScriptedDemo::perform(const ScriptContext &stage, const TourStop &stop, double time_s) {
    session::Session &session = stage.session;
    stage.lift.stop();
    showing_.reset();
    switched_ = 0;
    words_until_s_ = time_s + kWords_s;
    if (!session.hand().is_simulated()) {
        return;
    }
    const session::LoadedScene &scene = session.scenes().now();
    std::optional<Showing> showing = showing_of(session.description(), scene.scene, scene.surface,
                                                stop.gesture, session.hand().target_m());
    if (!showing) {
        error_ = std::string(stop.scene) + ": the scripted hand does not reach it";
        return;
    }
    error_ = error_text_of([&] {
        session.follow_path(showing->path);
        began_s_ = session.latest().time_s + kPathBegins_s;
        showing_ = std::move(showing);
    });
}

void ScriptedDemo::switch_map_if_due(const ScriptContext &stage) {
    if (!showing_ || switched_ >= showing_->switches_s.size()) {
        return;
    }
    if (stage.session.latest().time_s - began_s_ >= showing_->switches_s[switched_]) {
        ++switched_;
        stage.editor.toggle_map();
    }
}

void ScriptedDemo::leave(const ScriptContext &stage) {
    showing_.reset();
    if (stage.session.hand().follows_path()) {
        stage.session.leave_path();
    }
}

void Guide::begin(const ScriptContext &stage) {
    script_.emplace(stage.session);
    course_.emplace(kTour.size());
    script_->show(stage, kTour.front());
    had_scene_ = false;
}

void Guide::end(const ScriptContext &stage) {
    if (is_on()) {
        script_->leave(stage);
        script_->restore_gains(stage);
        course_.reset();
    }
}

void Guide::update(const ScriptContext &stage, double time_s) {
    if (!is_on()) {
        return;
    }
    const bool has_scene = script_->has_scene(stage.session);
    if (had_scene_ && !has_scene && !stage.session.scenes().is_loading()) {
        end(stage); // somebody wanted another one
        return;
    }
    had_scene_ = had_scene_ || has_scene;
    const std::size_t before = course_->scene();
    const CourseOrders orders = course_->update(script_->now(stage.session, time_s));
    if (orders.scene && before + 1 == kTour.size()) {
        end(stage); // all were shown
        return;
    }
    had_scene_ = had_scene_ && !orders.scene;
    script_->carry_out(orders, *course_, stage, time_s);
}

} // namespace springdrive::app::exhibit
