// The list of scenarios: what a device in closed loop is tried on. Window, figures, charts, limits,
// model selection, benchmarks and tests run these.
#pragma once

#include "device/core/device_description.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/hand.h"
#include "device/simulated/simulation_options.h"
#include "engine/contact/contact.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/tuning.h"
#include "engine/scene/scripted_touch.h"

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string_view>

namespace springdrive::rig {

// What holds the tip, as motion control sees it: a point, a plane, a surface, or nothing.

/// The contact of a tip. It may depend on earlier tips, as a proxy does.
using Constraint = std::function<contact::Contact(const Vector3 &tip_m)>;

[[nodiscard]] Constraint free_space();

/// Holds the tip at a point in all directions, with η = 0.
[[nodiscard]] Constraint tied_to(const Vector3 &point_m);

/// Whether a plane also holds a tip outside it.
enum class Sides : std::uint8_t { one, both };

/// A plane through a point, with η = 0.
/// @param normal  unit, out of the plane
[[nodiscard]] Constraint plane(const Vector3 &point_m, const Vector3 &normal, Sides sides);

/// A surface touched by a proxy that starts at the first tip.
/// @param surface  must outlive the constraint
[[nodiscard]] Constraint surface(const contact::HapticSurface &surface);

/// A surface in the workspace, and the box that it lies in.
struct PlacedSurface {
    std::shared_ptr<const contact::HapticSurface> surface;
    Vector3 lower_m{Vector3::Zero()};
    Vector3 upper_m{Vector3::Zero()};
};

/// The sphere of the test surfaces, about the origin.
[[nodiscard]] PlacedSurface placed_sphere();

/// A surface owned by the caller, which must outlive every scenario made of it.
[[nodiscard]] PlacedSurface placed(const contact::HapticSurface &surface, const Vector3 &lower_m,
                                   const Vector3 &upper_m);

/// What a scenario is made for.
struct ScenarioSetting {
    device::DeviceDescription device;
    control::Tuning tuning;
    Vector3 q_rad = device::default_pose_rad(); ///< for contacts without a place of their own
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// Whether a device can be held at given joint angles, to be measured there.
/// @throw InputError naming the angle, its value and its range in degrees, where the joint limits
///        do not allow `q_rad`, or where inverse kinematics would give other angles for that tip.
void check_configuration(const device::DeviceDescription &device, const Vector3 &q_rad);

/// A device, a tuning, a contact and a hand on its path: what a `ServoRig` or a `LawRig` runs.
struct Scenario {
    device::DeviceDescription device;
    control::Tuning tuning;
    simulated::SimulationOptions simulation; ///< with the hand, its path, period and delay
    Vector3 start_m{Vector3::Zero()};
    /// What a servo's proxy touches. None in free space and for an ideal contact.
    std::shared_ptr<const contact::HapticSurface> surface;
    /// The contact for a law alone. It refers to `surface`, which must outlive it.
    Constraint constraint = free_space();
    /// Of the contact's plane, where it has one: its normal, unit, and a point.
    Vector3 normal{Vector3::Zero()};
    Vector3 contact_m{Vector3::Zero()};
    double duration_s = 0.0; ///< until the end of the measurement
};

/// Over a surface, down into it, and in circles under it.
[[nodiscard]] Scenario scripted_touch_scenario(const ScenarioSetting &setting,
                                               const PlacedSurface &place,
                                               const scene::ScriptedTouch &how = {});

/// A hand that explores a scene from above, pressing and letting go: what models of it are compared
/// on.
struct Exploration {
    double rest_s = 0.05;        ///< at the start
    double approach_s = 0.25;    ///< from the start into the surface
    double duration_s = 2.0;     ///< in all
    double speed_m_per_s = 0.08; ///< along the path seen from above
    double min_depth_m = -0.001; ///< below the surface, straight down: it leaves contact,
    double max_depth_m = 0.007;  ///< returns and presses in, repeatedly,
    double press_hz = 3.0;       ///< at this frequency
    double climb_m_per_s = 0.15; ///< maximum vertical speed: it runs into a wall before it rises
                                 ///< over it
    bool planar = false;         ///< stays in the plane of its start, x = const
};

/// Its path over what `box` holds, begun at `start_m`: a Lissajous figure seen from above over the
/// middle 70 % of the box, or over as much of that as the device reaches. Where nothing lies below,
/// it keeps to the height of the box's floor; where the device reaches nothing, it stays.
[[nodiscard]] simulated::HandPath exploration_path(const device::DeviceDescription &device,
                                                   const contact::HapticSurface &surface,
                                                   const Eigen::AlignedBox3d &box,
                                                   const Vector3 &start_m,
                                                   const Exploration &how = {});

/// A hand that presses and lets go all over a surface.
[[nodiscard]] Scenario exploration_scenario(const ScenarioSetting &setting,
                                            const PlacedSurface &place,
                                            const Exploration &how = {});

/// The experiment of the paper's section VI: a vice holds the tip 1 mm outside a large flat plate
/// until the servo runs, then moves it along the normal to where it is `penetration_m` inside.
struct ViceOptions {
    /// When its sensor is set to zero, so that weight does not count, and when it is read.
    static constexpr double kZeroFrom_s = 1.15;
    static constexpr double kPressFrom_s = 1.20;
    static constexpr double kMeasureFrom_s = 1.45;
    static constexpr double kMeasureUntil_s = 1.50;

    Vector3 normal{Vector3::UnitY()}; ///< unit, in the plane of the links; else the program ends
    double penetration_m = 1e-3;
    /// All of the plant's effects except the stops, and without a `device_seed` the ripple of R.
    bool effects = true;
    std::uint64_t device_seed = 0; ///< with effects: which device of its kind
    /// Before all that, the vice presses the tip as deep into the plate and moves it to and fro by
    /// kStroke_m for this time, so that the windings' resistances can be observed. All times above
    /// are later by it.
    double exercise_s = 0.0;
    static constexpr double kStroke_m = 0.012;
};
[[nodiscard]] Scenario vice_scenario(const ScenarioSetting &setting,
                                     const ViceOptions &options = {});

/// A corner of three walls, at the setting's configuration, with the tip free a little off it. The
/// plant has viscous friction and the amplifier's limits only, and exact encoders.
[[nodiscard]] Scenario corner_scenario(const ScenarioSetting &setting,
                                       const device::HandParameters &hand = {});

/// A press into a plane that holds from both sides and starts at the tip.
struct PressOptions {
    device::HandParameters hand;
    /// From the middle of the workspace to where it is, in shares of the workspace's size.
    Vector3 place{0.15, -0.1, 0.1};
    Vector3 normal{0.36, 0.8, 0.48};
    double press_m = 10e-3; ///< depth of the hand's target below the plane
    double press_s = 10e-3; ///< time in which the target gets there
    double release_s =
        std::numeric_limits<double>::infinity(); ///< when it returns, in the same time
    double duration_s = 40e-3;
    bool coulomb_friction = false; ///< of the joints; beside gravity and viscous friction
};
[[nodiscard]] Scenario press_scenario(const ScenarioSetting &setting, const PressOptions &options);

/// A pen grip that presses 10 mm deep within 10 ms, in a slanting direction of an unsymmetrical
/// configuration: all three motors take part.
[[nodiscard]] PressOptions pen_press();
/// The same in the plane of the links, with the base joint in its middle: no force sideways.
[[nodiscard]] PressOptions planar_press();
/// The vice of the paper's section VI in the hand's place: 1 µm per newton, and 1 mm deep.
[[nodiscard]] PressOptions vice_press();
/// The pen grip against Coulomb friction; it holds until the joints stick, and lets go at 0.2 s.
[[nodiscard]] PressOptions sticking_press();

/// A hand that moves straight down at constant speed onto a level wall.
struct ImpactOptions {
    static constexpr double kApproach_s = 0.1; ///< by then hand and tip move together
    static constexpr double kMax_s = 1.0;

    device::HandParameters hand;
    double speed_m_per_s = 0.1;
    double lower_m = 0.0; ///< of the wall, below where the tip is after the approach
    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
};
[[nodiscard]] Scenario impact_scenario(const ScenarioSetting &setting,
                                       const ImpactOptions &options = {});

/// A firm hand without mass that moves the tip up and down in free space along a sine.
struct StrokeOptions {
    static constexpr double kFrequency_Hz = 5.0;
    static constexpr double kAmplitude_m = 0.01;
    static constexpr int kPeriods = 6;
    static constexpr int kPeriodsBefore = 2; ///< the measurement

    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
};
[[nodiscard]] Scenario stroke_scenario(const ScenarioSetting &setting,
                                       const StrokeOptions &options = {});

/// The tip is tied to a point beside its start, in a direction that is orthogonal to no mode. The
/// plant has viscous friction and the given effects; the amplifier cancels without a limit.
struct TiedOptions {
    device::HandParameters hand;
    double aside_m = 1e-3;
    bool quantisation = true;
    bool coulomb_friction = false;
    bool amplifier_limits = false;
    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
};
[[nodiscard]] Scenario tied_scenario(const ScenarioSetting &setting,
                                     const TiedOptions &options = {});

/// An entry of the list.
struct ListedScenario {
    std::string_view name;
    std::string_view what;     ///< contact and hand
    std::string_view measured; ///< and where it is used
    Scenario (*make)(const ScenarioSetting &);
};

/// All scenarios with their default options, and the test sphere in place of a scene.
extern const std::array<ListedScenario, 11> kScenarios;

} // namespace springdrive::rig
