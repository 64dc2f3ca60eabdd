// The tour of an exhibit: its scenes in their order, how a scripted hand shows each, and the
// showing of one after the other.
//
//   show ──► scene loaded, gains of the start ──► is_ready ──► perform ──► is_shown
#pragma once

#include "app/exhibit/course.h"
#include "app/panels/tuning_editor.h"
#include "app/stage/touch_by_click.h"
#include "device/core/device_description.h"
#include "device/simulated/hand.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"
#include "engine/session/session.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::app::exhibit {

enum class Gesture : std::uint8_t {
    stroke,     ///< presses, and strokes to and fro
    strike,     ///< blows from above
    press_each, ///< presses on each part that has a caption
    compare,    ///< presses on the lesson's spot, with one map and with the other
};

struct TourStop {
    std::string_view scene; ///< name of the file in assets/scenes, without its ending
    Gesture gesture = Gesture::stroke;
    std::string_view
        sentence{}; ///< in place of the scene's own, if that speaks of panels or symbols
};

/// All scenes that are included.
inline constexpr std::array<TourStop, 11> kTour{{
    {"plate", Gesture::stroke},
    {"wrong_direction", Gesture::compare,
     "Press on the orange square, then switch the map: one pushes square to the surface, the other "
     "far to the side."},
    {"slope", Gesture::stroke},
    {"compliance", Gesture::press_each},
    {"organic", Gesture::stroke},
    {"stepped_block", Gesture::stroke},
    {"thin_plate", Gesture::stroke},
    {"spheres", Gesture::press_each},
    {"profile", Gesture::stroke},
    {"sphere", Gesture::stroke},
    {"blow", Gesture::strike},
}};

[[nodiscard]] std::filesystem::path file_of(const TourStop &stop);

/// The stop's sentence, or else the scene's.
[[nodiscard]] std::string sentence_of(const TourStop &stop, const scene::Scene &scene);

/// What the scripted hand does.
struct Showing {
    simulated::HandPath path;
    std::vector<double> switches_s; ///< times of the path at which the map is switched
};

// Speeds of the scripted hand's target.
inline constexpr double kTransit_m_per_s = 0.08;
inline constexpr double kPress_m_per_s = 0.03;
inline constexpr double kStroke_m_per_s = 0.04;
inline constexpr double kStrike_m_per_s = 0.20;

/// From where the hand is, out of anything it is below, to the scene, and back to above it.
/// @return nothing where the device does not reach all of it
[[nodiscard]] std::optional<Showing> showing_of(const device::DeviceDescription &device,
                                                const scene::Scene &scene,
                                                const contact::HapticSurface &surface,
                                                Gesture gesture, const Vector3 &from_m);

/// What it acts on; of the screen.
struct ScriptContext {
    session::Session &session;
    TuningEditor &editor;
    HandRetraction &lift;
};

/// Shows the tour's scenes one at a time, each by its scripted hand.
class ScriptedDemo {
public:
    /// The present scene and gains are those of the start.
    explicit ScriptedDemo(const session::Session &session)
        : tuning_(session.tuning().now()), requested_(session.scenes().now().scene.file) {}

    /// Requests the scene, with the gains of the start.
    void show(const ScriptContext &stage, const TourStop &stop);

    [[nodiscard]] bool has_scene(const session::Session &session) const {
        return session.scenes().now().scene.file == requested_;
    }

    /// What the course depends on, of scene, motors and scripted hand.
    [[nodiscard]] CourseNow now(const session::Session &session, double time_s) const;
    /// Once a frame: the orders about scene and scripted hand. With a real hand nothing moves for
    /// some seconds.
    void carry_out(const CourseOrders &orders, const Course &course, const ScriptContext &stage,
                   double time_s);
    /// The scripted hand stops where it is.
    void leave(const ScriptContext &stage);

    void restore_gains(const ScriptContext &stage) const;

    /// Why the hand did not act; else empty.
    [[nodiscard]] std::string take_error() { return std::exchange(error_, {}); }

private:
    void perform(const ScriptContext &stage, const TourStop &stop, double time_s);
    void switch_map_if_due(const ScriptContext &stage);

    control::Tuning tuning_; ///< of the start
    std::filesystem::path requested_;
    std::optional<Showing> showing_;
    double began_s_ = 0.0;       ///< by the session's time
    double words_until_s_ = 0.0; ///< without a scripted hand
    std::size_t switched_ = 0;   ///< maps, in this showing
    std::string error_;
};

/// The tour in the ordinary window: the scripted hand goes through all scenes once, until Escape.
class Guide {
public:
    void begin(const ScriptContext &stage);
    void end(const ScriptContext &stage);
    [[nodiscard]] bool is_on() const { return course_.has_value(); }

    /// Once a frame. @param time_s  by any clock of the window
    void update(const ScriptContext &stage, double time_s);

private:
    std::optional<Course> course_;
    std::optional<ScriptedDemo> script_;
    bool had_scene_ = false; ///< that it shows
};

} // namespace springdrive::app::exhibit
