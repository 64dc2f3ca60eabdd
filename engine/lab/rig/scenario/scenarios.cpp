#include "engine/lab/rig/scenario/scenarios.h"

#include "base/assertions.h"
#include "base/cancellation.h"
#include "base/degrees.h"
#include "base/input_error.h"
#include "engine/contact/proxy/proxy.h"
#include "engine/lab/rig/scenario/test_surfaces.h"
#include "engine/scene/scripted_touch.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace springdrive::rig {

namespace {

/// A limit of the hand's force would be a corner of the plant, which costs an integrator its order.
constexpr double kNoLimit_N = 1e6;

/// A vice as a hand: 1 µm per newton, with a damping ratio of 1.1 and a slowest time constant of
/// 0.7 ms.
constexpr device::HandParameters kVice{.mass_kg = 0.2,
                                       .damping_Ns_per_m = 1000.0,
                                       .stiffness_N_per_m = 1e6,
                                       .max_force_N = kNoLimit_N,
                                       .max_speed_m_per_s = 10.0};

/// The setting's device at its configuration, in free space: what every scenario begins with.
Scenario base_scenario(const ScenarioSetting &setting) {
    Scenario scenario;
    scenario.device = setting.device;
    scenario.tuning = setting.tuning;
    scenario.simulation.servo_period_s = setting.period_s;
    scenario.simulation.delay_periods = setting.delay_periods;
    scenario.start_m = device::tip_position_m(setting.device.geometry, setting.q_rad);
    return scenario;
}

void touch_surface(Scenario &scenario, std::shared_ptr<const contact::HapticSurface> touched) {
    scenario.surface = std::move(touched);
    scenario.constraint = surface(*scenario.surface);
}

void follow_path(Scenario &scenario, simulated::HandPath path) {
    scenario.duration_s = path.points().back().time_s;
    scenario.simulation.path = std::move(path);
}

/// One triangle, 0.2 m across, so that there is neither edge nor seam near the tip.
/// @param level  unit, perpendicular to the normal
contact::TriangleSoup plate(const Vector3 &centre_m, const Vector3 &normal, const Vector3 &level) {
    constexpr double kRadius_m = 0.1;
    contact::TriangleSoup soup;
    for (int corner = 0; corner < 3; ++corner) {
        const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * corner / 3.0, normal);
        soup.vertices_m.emplace_back(centre_m + kRadius_m * (turn * level));
    }
    soup.triangles = {{0, 1, 2}};
    soup.material_of_triangle = {0};
    soup.materials = {{"plate", 0.0}};
    return soup;
}

/// A box that is touched from within, its lowest corner at `corner_m`.
contact::TriangleSoup room(const Vector3 &corner_m) {
    constexpr double kEdge_m = 0.05;
    contact::TriangleSoup soup = solid_box(corner_m, corner_m + Vector3::Constant(kEdge_m));
    for (auto &triangle : soup.triangles) {
        std::swap(triangle[1], triangle[2]);
    }
    return soup;
}

/// 10 s³ − 15 s⁴ + 6 s⁵: from 0 to 1 at rest at both ends, with a continuous acceleration.
double smooth_step(double share) {
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

/// Sets the plant on which drives are compared: without the effects that are the same for both.
void set_drive_comparison(Scenario &scenario, device::AmplifierKind drive) {
    scenario.simulation.effects.gravity = false; // a balanced arm
    scenario.simulation.effects.coulomb_friction = false;
    scenario.simulation.effects.winding_heat = false;
    scenario.simulation.effects.commutation_ripple = false;
    scenario.simulation.amplifier = drive;
    scenario.simulation.longest_step_s = 50e-6;
}

/// Adds the vice's exercise, which begins once the servo has started: into the plate, to and fro
/// along it, and out again, all within `exercise_s`.
void add_exercise(const ViceOptions &options, const Vector3 &inside_m, const Vector3 &outside_m,
                  const Vector3 &along, std::vector<simulated::HandPath::Point> &points) {
    constexpr double kStep_s = 0.02;
    constexpr double kPress_s = 0.2;
    constexpr double kStroke_rad_per_s = std::numbers::pi; // half a stroke a second
    points.push_back({ViceOptions::kZeroFrom_s, outside_m});
    const long steps = std::lround(options.exercise_s / kStep_s);
    for (long i = 1; i < steps; ++i) {
        const double time_s = static_cast<double>(i) * kStep_s;
        const double pressed =
            std::clamp(std::min(time_s, options.exercise_s - time_s) / kPress_s, 0.0, 1.0);
        const double aside_m = 0.5 * ViceOptions::kStroke_m * std::sin(kStroke_rad_per_s * time_s);
        points.push_back({ViceOptions::kZeroFrom_s + time_s,
                          outside_m + pressed * (inside_m - outside_m + aside_m * along)});
    }
}

// The path of an exploration.

/// Time from one point to the next.
constexpr double kPoint_s = 0.005;

/// The path seen from above: a Lissajous figure of frequencies 2 : 3, which crosses the middle in
/// many directions.
class LissajousFigure {
public:
    LissajousFigure(const Vector3 &middle_m, const Vector3 &half_m)
        : middle_m_(middle_m), half_m_(half_m) {}

    [[nodiscard]] Vector3 at(double phase_rad) const {
        return middle_m_ + Vector3(half_m_.x() * std::sin(2.0 * phase_rad), 0.0,
                                   half_m_.z() * std::sin(3.0 * phase_rad));
    }

    /// The phase of the point that is `distance_m` farther along the path.
    [[nodiscard]] double advance(double phase_rad, double distance_m) const {
        // A bound for the step of the phase, where the path reverses and is slower.
        const double min_m_per_rad = std::max(0.2 * std::max(half_m_.x(), half_m_.z()), 1e-4);
        const double m_per_rad = std::hypot(2.0 * half_m_.x() * std::cos(2.0 * phase_rad),
                                            3.0 * half_m_.z() * std::cos(3.0 * phase_rad));
        return phase_rad + distance_m / std::max(m_per_rad, min_m_per_rad);
    }

private:
    Vector3 middle_m_;
    Vector3 half_m_;
};

/// The height of the surface at the point's x and z, as seen from above; that of the box's floor
/// where there is none.
double surface_height_m(const scene::SurfaceProbe &probe, const Vector3 &point_m) {
    const Eigen::AlignedBox3d &box = probe.box();
    constexpr double kAbove_m = 0.005;
    const Vector3 above_m(point_m.x(), box.max().y() + kAbove_m, point_m.z());
    const Vector3 below_m(point_m.x(), box.min().y(), point_m.z());
    const std::optional<Vector3> touched_m = probe.first_touch(above_m, below_m);
    return touched_m ? touched_m->y() : box.min().y();
}

/// The depth of the hand's target below the surface: between the least and the greatest, and the
/// mean of them at time 0.
double press_depth_m(const Exploration &how, double time_s) {
    const double middle_m = 0.5 * (how.min_depth_m + how.max_depth_m);
    const double half_m = 0.5 * (how.max_depth_m - how.min_depth_m);
    return middle_m + half_m * std::sin(2.0 * std::numbers::pi * how.press_hz * time_s);
}

/// The points after rest and approach.
std::vector<simulated::HandPath::Point> explored_points(const scene::SurfaceProbe &probe,
                                                        const LissajousFigure &figure,
                                                        const Exploration &how) {
    std::vector<simulated::HandPath::Point> points;
    double phase_rad = 0.0;
    double y_m = surface_height_m(probe, figure.at(0.0));
    const double begin_s = how.rest_s + how.approach_s;
    const long count = std::lround(std::ceil((how.duration_s - begin_s) / kPoint_s));
    for (long i = 0; i < count; ++i) {
        stop_if_given_up();
        const double since_s = static_cast<double>(i) * kPoint_s;
        Vector3 point_m = figure.at(phase_rad);
        const double max_m = how.climb_m_per_s * kPoint_s;
        y_m = std::clamp(surface_height_m(probe, point_m), y_m - max_m, y_m + max_m);
        point_m.y() = y_m - press_depth_m(how, since_s);
        points.push_back({begin_s + since_s, point_m});
        phase_rad = figure.advance(phase_rad, how.speed_m_per_s * kPoint_s);
    }
    return points;
}

bool reaches_all(const device::DeviceDescription &device,
                 const std::vector<simulated::HandPath::Point> &points) {
    return std::ranges::all_of(points, [&](const simulated::HandPath::Point &point) {
        return device::can_reach(device, point.position_m);
    });
}

} // namespace

Constraint free_space() {
    return [](const Vector3 &tip_m) {
        contact::Contact contact;
        contact.x0_m = tip_m;
        return contact;
    };
}

Constraint tied_to(const Vector3 &point_m) {
    contact::Contact contact;
    contact.touching = true;
    contact.x0_m = point_m;
    contact.tangent_projector.setZero();
    contact.eta = 0.0;
    return [contact](const Vector3 &) { return contact; };
}

Constraint plane(const Vector3 &point_m, const Vector3 &normal, Sides sides) {
    return [point_m, normal, sides](const Vector3 &tip_m) {
        contact::Contact contact;
        const double outside_m = normal.dot(tip_m - point_m);
        if (sides == Sides::one && outside_m >= 0.0) {
            contact.x0_m = tip_m;
            return contact;
        }
        contact.touching = true;
        contact.x0_m = tip_m - outside_m * normal;
        contact.tangent_projector = Matrix3::Identity() - normal * normal.transpose();
        contact.normal = normal;
        contact.eta = 0.0;
        contact.active_constraints = 1;
        return contact;
    };
}

Constraint surface(const contact::HapticSurface &surface) {
    return [&surface, proxy = contact::Proxy(), is_first = true](const Vector3 &tip_m) mutable {
        if (is_first) {
            proxy.reset(tip_m);
            is_first = false;
        }
        return proxy.update(surface, tip_m);
    };
}

PlacedSurface placed_sphere() {
    constexpr int kDivisions = 5;
    const Vector3 corner_m = Vector3::Constant(kTestSphereRadius_m);
    return {std::make_shared<contact::HapticSurface>(icosphere(kDivisions, kTestSphereRadius_m)),
            -corner_m, corner_m};
}

PlacedSurface placed(const contact::HapticSurface &surface, const Vector3 &lower_m,
                     const Vector3 &upper_m) {
    return {std::shared_ptr<const contact::HapticSurface>(std::shared_ptr<void>(), &surface),
            lower_m, upper_m};
}

void check_configuration(const device::DeviceDescription &device, const Vector3 &q_rad) {
    struct LimitedAngle {
        const char *name;
        double rad;
        double min_rad;
        double max_rad;
    };
    const device::JointLimits &limits = device.joint_limits;
    const std::array<LimitedAngle, 4> angles{
        {{"q1", q_rad[0], limits.min_rad[0], limits.max_rad[0]},
         {"q2", q_rad[1], limits.min_rad[1], limits.max_rad[1]},
         {"q3", q_rad[2], limits.min_rad[2], limits.max_rad[2]},
         {"q3 - q2", q_rad[2] - q_rad[1], limits.min_q3_minus_q2_rad, limits.max_q3_minus_q2_rad}}};
    for (const LimitedAngle &angle : angles) {
        if (!(angle.rad >= angle.min_rad && angle.rad <= angle.max_rad)) { // a NaN too
            throw InputError(fmt::format(
                "{} is {:g}°; {} allows {:g}° to {:g}° (joint_limits of its device file)",
                angle.name, kDegreesPerRadian * angle.rad, device.name,
                kDegreesPerRadian * angle.min_rad, kDegreesPerRadian * angle.max_rad));
        }
    }
    constexpr double kSameAngle_rad = 1e-6;
    const std::optional<Vector3> found =
        device::joint_angles_rad(device.geometry, device::tip_position_m(device.geometry, q_rad));
    if (!found || !(*found - q_rad).isZero(kSameAngle_rad)) {
        throw InputError("at these joint angles the tip is behind the base axis, where inverse "
                         "kinematics take other angles; choose q2 and q3 with the tip in front");
    }
}

Scenario scripted_touch_scenario(const ScenarioSetting &setting, const PlacedSurface &place,
                                 const scene::ScriptedTouch &how) {
    Scenario scenario = base_scenario(setting);
    scenario.start_m = scene::start_above(setting.device, place.lower_m, place.upper_m);
    touch_surface(scenario, place.surface);
    follow_path(scenario, simulated::HandPath(scene::scripted_touch(
                              setting.device, *place.surface, place.lower_m, place.upper_m, how)));
    return scenario;
}

simulated::HandPath exploration_path(const device::DeviceDescription &device,
                                     const contact::HapticSurface &surface,
                                     const Eigen::AlignedBox3d &box, const Vector3 &start_m,
                                     const Exploration &how) {
    const scene::SurfaceProbe probe(surface, box, 0.0);
    Vector3 middle_m = box.center();
    Vector3 half_m = 0.35 * box.sizes(); // of the middle 70 %
    if (how.planar) {
        middle_m.x() = start_m.x();
        half_m.x() = 0.0;
    }
    std::vector<simulated::HandPath::Point> path{{0.0, start_m}, {how.rest_s, start_m}};
    constexpr int kHalvings = 4;
    for (int halving = 0; halving <= kHalvings; ++halving) {
        const std::vector<simulated::HandPath::Point> points =
            explored_points(probe, LissajousFigure(middle_m, half_m), how);
        if (reaches_all(device, points)) {
            path.insert(path.end(), points.begin(), points.end());
            break;
        }
        half_m *= 0.5;
    }
    return simulated::HandPath(std::move(path));
}

Scenario exploration_scenario(const ScenarioSetting &setting, const PlacedSurface &place,
                              const Exploration &how) {
    Scenario scenario = base_scenario(setting);
    scenario.start_m = scene::start_above(setting.device, place.lower_m, place.upper_m);
    touch_surface(scenario, place.surface);
    follow_path(scenario, exploration_path(setting.device, *place.surface,
                                           Eigen::AlignedBox3d(place.lower_m, place.upper_m),
                                           scenario.start_m, how));
    return scenario;
}

Scenario vice_scenario(const ScenarioSetting &setting, const ViceOptions &options) {
    constexpr double kOutside_m = 1e-3;
    constexpr double kPress_s = 0.05;
    Scenario scenario = base_scenario(setting);
    scenario.device.edge = {}; // the soft wall near a stop is not part of the map
    const Vector3 inside_m = scenario.start_m;
    const Vector3 surface_m = inside_m + options.penetration_m * options.normal;
    const Vector3 outside_m = surface_m + kOutside_m * options.normal;
    scenario.start_m = outside_m;
    scenario.normal = options.normal;
    scenario.contact_m = surface_m;
    const Vector3 level(-std::cos(setting.q_rad[0]), 0.0, std::sin(setting.q_rad[0]));
    SPRINGDRIVE_ASSERT(std::abs(level.dot(options.normal)) < 1e-9); // in the plane of the links
    touch_surface(scenario, std::make_shared<contact::HapticSurface>(
                                plate(surface_m, options.normal, level)));
    simulated::SimulationOptions &simulation = scenario.simulation;
    simulation.hand = kVice;
    std::vector<simulated::HandPath::Point> points;
    if (options.exercise_s > 0.0) {
        add_exercise(options, inside_m, outside_m, options.normal.cross(level), points);
    }
    const double press_s = ViceOptions::kPressFrom_s + options.exercise_s;
    points.push_back({press_s, outside_m});
    points.push_back({press_s + kPress_s, inside_m});
    follow_path(scenario, simulated::HandPath(std::move(points)));
    scenario.duration_s = ViceOptions::kMeasureUntil_s + options.exercise_s;
    simulation.quantised_encoders = options.effects;
    if (options.effects) {
        simulation.device_seed = options.device_seed;
        simulation.effects.commutation_ripple = options.device_seed != 0;
        simulation.effects.joint_limits = false; // the vice holds it, near a stop too
    } else {
        simulation.effects = simulated::PlantEffects::none();
    }
    return scenario;
}

Scenario corner_scenario(const ScenarioSetting &setting, const device::HandParameters &hand) {
    constexpr double kFromWalls_m = 3e-3; // distance of the tip from each wall at the start
    constexpr double kStartUp_s = 1.2;    // time in which the servo starts
    Scenario scenario = base_scenario(setting);
    touch_surface(scenario, std::make_shared<contact::HapticSurface>(room(scenario.start_m)));
    scenario.start_m += Vector3::Constant(kFromWalls_m);
    scenario.duration_s = kStartUp_s;
    scenario.simulation.quantised_encoders = false;
    scenario.simulation.hand = hand;
    scenario.simulation.effects = simulated::PlantEffects::none();
    scenario.simulation.effects.viscous_friction = true;
    scenario.simulation.effects.amplifier_limits = true;
    return scenario;
}

Scenario press_scenario(const ScenarioSetting &setting, const PressOptions &options) {
    Scenario scenario = base_scenario(setting);
    scenario.start_m = setting.device.workspace.centre_m +
                       setting.device.workspace.size_m.cwiseProduct(options.place);
    scenario.normal = options.normal;
    scenario.contact_m = scenario.start_m;
    scenario.constraint = plane(scenario.contact_m, scenario.normal, Sides::both);
    scenario.simulation.hand = options.hand;
    scenario.simulation.effects = simulated::PlantEffects::none();
    scenario.simulation.effects.gravity = true;
    scenario.simulation.effects.viscous_friction = true;
    scenario.simulation.effects.coulomb_friction = options.coulomb_friction;
    // A corner at every sample, so that between two of them the hand's target moves uniformly.
    std::vector<simulated::HandPath::Point> points;
    const long periods = std::lround(options.duration_s / setting.period_s);
    for (long k = 0; k <= periods; ++k) {
        const double time_s = static_cast<double>(k) * setting.period_s;
        const double share = smooth_step(time_s / options.press_s) -
                             smooth_step((time_s - options.release_s) / options.press_s);
        points.push_back({time_s, scenario.start_m - options.press_m * share * scenario.normal});
    }
    follow_path(scenario, simulated::HandPath(std::move(points)));
    return scenario;
}

PressOptions pen_press() {
    PressOptions press;
    press.hand.max_force_N = kNoLimit_N;
    return press;
}

PressOptions planar_press() {
    PressOptions press = pen_press();
    press.place.x() = 0.0;
    press.normal = Vector3(0.0, 0.8, 0.6);
    return press;
}

PressOptions vice_press() {
    PressOptions press;
    press.hand = kVice;
    press.press_m = 1e-3;
    return press;
}

PressOptions sticking_press() {
    PressOptions press = pen_press();
    press.coulomb_friction = true;
    press.release_s = 0.2;
    press.duration_s = 0.4;
    return press;
}

Scenario impact_scenario(const ScenarioSetting &setting, const ImpactOptions &options) {
    Scenario scenario = base_scenario(setting);
    set_drive_comparison(scenario, options.drive);
    scenario.simulation.hand = options.hand;
    const Vector3 end_m =
        scenario.start_m - options.speed_m_per_s * ImpactOptions::kMax_s * Vector3::UnitY();
    const double height_m =
        scenario.start_m.y() - options.speed_m_per_s * ImpactOptions::kApproach_s - options.lower_m;
    scenario.normal = Vector3::UnitY();
    scenario.contact_m = Vector3(scenario.start_m.x(), height_m, scenario.start_m.z());
    scenario.constraint = plane(scenario.contact_m, scenario.normal, Sides::one);
    follow_path(scenario,
                simulated::HandPath({{0.0, scenario.start_m}, {ImpactOptions::kMax_s, end_m}}));
    return scenario;
}

Scenario stroke_scenario(const ScenarioSetting &setting, const StrokeOptions &options) {
    constexpr int kPoints = 1200; // a millisecond apart
    Scenario scenario = base_scenario(setting);
    set_drive_comparison(scenario, options.drive);
    scenario.simulation.hand = {.mass_kg = 0.0,
                                .damping_Ns_per_m = 30.0,
                                .stiffness_N_per_m = 3000.0,
                                .max_force_N = HUGE_VAL,
                                .max_speed_m_per_s = 1.0};
    const double omega = 2.0 * std::numbers::pi * StrokeOptions::kFrequency_Hz;
    std::vector<simulated::HandPath::Point> path;
    path.reserve(kPoints + 1);
    for (int i = 0; i <= kPoints; ++i) {
        const double t = StrokeOptions::kPeriods / StrokeOptions::kFrequency_Hz * i / kPoints;
        path.push_back({t, scenario.start_m + StrokeOptions::kAmplitude_m * std::sin(omega * t) *
                                                  Vector3::UnitY()});
    }
    follow_path(scenario, simulated::HandPath(std::move(path)));
    return scenario;
}

Scenario tied_scenario(const ScenarioSetting &setting, const TiedOptions &options) {
    constexpr double kDuration_s = 3.0;
    Scenario scenario = base_scenario(setting);
    scenario.device.amplifier.max_cancelled_Ohm = HUGE_VAL;
    scenario.constraint = tied_to(scenario.start_m + options.aside_m * Vector3(0.6, 0.64, 0.48));
    scenario.duration_s = kDuration_s;
    scenario.simulation.quantised_encoders = options.quantisation;
    scenario.simulation.hand = options.hand;
    scenario.simulation.effects = simulated::PlantEffects::none();
    scenario.simulation.effects.viscous_friction = true;
    scenario.simulation.effects.coulomb_friction = options.coulomb_friction;
    scenario.simulation.effects.amplifier_limits = options.amplifier_limits;
    scenario.simulation.amplifier = options.drive;
    return scenario;
}

const std::array<ListedScenario, 11> kScenarios{{
    {"scripted touch", "a hand over a surface, down into it and in circles under it",
     "records, cost of a tick; unattended window, servo-rate chart, servo_benchmark",
     [](const ScenarioSetting &setting) {
         return scripted_touch_scenario(setting, placed_sphere());
     }},
    {"exploration", "a hand that presses and lets go all over a surface",
     "force and direction between models; model selection",
     [](const ScenarioSetting &setting) { return exploration_scenario(setting, placed_sphere()); }},
    {"vice", "a vice that presses the tip into a plate (section VI)",
     "force at rest and its direction; figures 5 and 6",
     [](const ScenarioSetting &setting) { return vice_scenario(setting); }},
    {"corner", "a hand that holds the tip in a corner of three walls",
     "trips and what is rendered when ticks, answers or the hand are lost; limits of the servo",
     [](const ScenarioSetting &setting) { return corner_scenario(setting); }},
    {"pen press", "a pen grip that presses into a plane within 10 ms",
     "force against a reference; integrators' chart",
     [](const ScenarioSetting &setting) { return press_scenario(setting, pen_press()); }},
    {"planar press", "the same in the plane of the links",
     "force against the full model; chart of plant models",
     [](const ScenarioSetting &setting) { return press_scenario(setting, planar_press()); }},
    {"vice press", "a vice that presses into a plane within 10 ms",
     "force against a reference; integrators' chart in a vice",
     [](const ScenarioSetting &setting) { return press_scenario(setting, vice_press()); }},
    {"sticking press", "a pen grip that presses until the joints stick, and lets go",
     "force against a reference; integrators' chart under friction",
     [](const ScenarioSetting &setting) { return press_scenario(setting, sticking_press()); }},
    {"impact", "a hand that runs onto a level wall at 0.1 m/s",
     "rate-hardness and maximum force; comparison of drives",
     [](const ScenarioSetting &setting) { return impact_scenario(setting); }},
    {"stroke", "a firm hand that moves up and down in free space at 5 Hz",
     "apparent mass; comparison of drives",
     [](const ScenarioSetting &setting) { return stroke_scenario(setting); }},
    {"tied", "a tip that is let go 1 mm beside the point that it is tied to",
     "decay or growth of the motion; simulated stability",
     [](const ScenarioSetting &setting) { return tied_scenario(setting); }},
}};

} // namespace springdrive::rig
