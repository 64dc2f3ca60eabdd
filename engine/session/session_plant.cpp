// The part of `Session` that changes the simulated device: its delay and effects; and the simulated
// hand, which an emulated device has, too.
#include "base/bisection.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "engine/scene/scripted_touch.h"
#include "engine/session/session_parts.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <utility>
#include <vector>

namespace springdrive::session {

namespace {

/// The names of the effects that are on.
std::vector<std::string> names_of(const simulated::PlantEffects &effects) {
    std::vector<std::string> names;
    for (const simulated::PlantEffect &effect : simulated::kPlantEffects) {
        if (effects.*effect.on) {
            names.emplace_back(effect.name);
        }
    }
    return names;
}

/// Whether a drawn device reports the same of itself with these effects.
bool reports_alike(const simulated::PlantEffects &a, const simulated::PlantEffects &b) {
    return a.motor_tolerances == b.motor_tolerances && a.current_sensing == b.current_sensing;
}

/// @throw InputError if a point, or one in between, is out of reach
void check_reach(const device::DeviceDescription &device, const simulated::HandPath &path) {
    constexpr double kStep_m = 5e-3;
    const std::vector<simulated::HandPath::Point> &points = path.points();
    Vector3 before_m = points.front().position_m;
    for (const simulated::HandPath::Point &point : points) {
        const Vector3 way_m = point.position_m - before_m;
        const int steps = 1 + static_cast<int>(way_m.norm() / kStep_m);
        for (int step = 1; step <= steps; ++step) {
            const Vector3 at_m = before_m + way_m * step / steps;
            if (!device::joint_angles_rad(device.geometry, at_m)) {
                throw InputError(fmt::format(
                    "hand path: ({:.4g}, {:.4g}, {:.4g}) m, on the way to the point at {:.4g} s, "
                    "is out of the device's reach",
                    at_m.x(), at_m.y(), at_m.z(), point.time_s));
            }
        }
        before_m = point.position_m;
    }
}

/// The path, after an even motion to its start.
simulated::HandPath from_here(const Vector3 &here_m, const simulated::HandPath &path) {
    constexpr double kApproach_m_per_s = 0.05;
    constexpr double kMinApproach_s = 0.2;
    const simulated::HandPath::Point &first = path.points().front();
    const double approach_s =
        kMinApproach_s + (first.position_m - here_m).norm() / kApproach_m_per_s;
    std::vector<simulated::HandPath::Point> points{{0.0, here_m}};
    for (simulated::HandPath::Point point : path.points()) {
        point.time_s += approach_s - first.time_s;
        points.push_back(point);
    }
    return simulated::HandPath(std::move(points));
}

/// The last reachable point on the line from the workspace's centre to `requested_m`.
Vector3 nearest_in_reach(const device::PhantomGeometry &geometry, const Vector3 &centre_m,
                         const Vector3 &requested_m) {
    if (device::joint_angles_rad(geometry, requested_m)) {
        return requested_m;
    }
    const Vector3 offset_m = requested_m - centre_m;
    const auto is_in_reach = [&](double share) {
        return device::joint_angles_rad(geometry, centre_m + share * offset_m).has_value();
    };
    return centre_m + bisect({0.0, 1.0}, 20, is_in_reach).holds_at * offset_m;
}

} // namespace

simulated::HandControl &Session::hand_control() {
    if (device_->hand() == nullptr) {
        throw InputError(description().name + " is held by a real hand, which cannot be moved");
    }
    return *device_->hand();
}

simulated::SimulatedWorld &Session::world() {
    if (!device_->has_world()) {
        throw InputError(description().name + " is no simulated device: its plant cannot be set");
    }
    return *device_->world();
}

void Session::simulate_as(const simulated::SimulationOptions &simulation) {
    world().simulate_as(simulation);
    simulation_ = simulation;
}

/// A device that is being started begins as the present one is now.
void Session::renew_exchange() {
    if (next_device_) {
        prepare_again();
    }
}

void Session::set_delay(double delay_periods) {
    require_no_exclusive_use();
    simulated::SimulationOptions simulation = simulation_;
    simulation.delay_periods = delay_periods;
    servo_->paused([&] {
        simulate_as(simulation);
        options_.delay_periods = delay_periods;
        const std::uint64_t from_tick = servo_->set_rate(servo_->rate_hz()); // the loop's delay
        note(dump({{"delay_periods", delay_periods}, {"from_tick", from_tick}}));
    });
    renew_exchange();
    measure_anew();
}

void Session::set_effects(const simulated::PlantEffects &effects) {
    static_cast<void>(world());
    if (models_->is_automatic()) {
        throw InputError("the scene's model chooses the effects with --model auto; they can be set "
                         "when it is started without");
    }
    if (simulation_.device_seed != 0 && !reports_alike(simulation_.effects, effects)) {
        start_again_with(effects); // the present device stays as it is
        return;
    }
    simulated::SimulationOptions simulation = simulation_;
    simulation.effects = effects;
    simulate_as(simulation);
    options_.effects = effects;
    models_->set_effects(effects);
    renew_exchange();
    note(dump({{"effects", names_of(effects)}, {"after_tick", latest().tick}}));
}

void Session::start_again_with(const simulated::PlantEffects &effects) {
    if (latest().safety.state == servo::SafetyState::tripped) {
        throw InputError("the device is stopped, and these effects let it start again: reset it "
                         "first");
    }
    const simulated::PlantEffects before = std::exchange(options_.effects, effects);
    models_->set_effects(effects);
    try {
        exchange_device(next_device_ ? next_device_->choice : options_.device);
    } catch (const InputError &) {
        options_.effects = before;
        models_->set_effects(before);
        throw;
    }
}

void Session::set_hand(const device::HandParameters &hand) {
    hand_control().hold_with(hand);
    simulation_.hand = hand;
    renew_exchange();
    note(dump({{"hand",
                {{"mass_kg", hand.mass_kg},
                 {"damping_Ns_per_m", hand.damping_Ns_per_m},
                 {"stiffness_N_per_m", hand.stiffness_N_per_m},
                 {"max_force_N", hand.max_force_N},
                 {"max_speed_m_per_s", hand.max_speed_m_per_s}}},
               {"after_tick", latest().tick}}));
}

void Session::follow_path(const simulated::HandPath &path) {
    static_cast<void>(hand_control());
    check_reach(description(), path);
    begin_path(path, "follows a path");
}

void Session::leave_path() {
    if (hand_.is_simulated()) {
        begin_path(simulated::HandPath({{0.0, hand_.target_m()}}), "leaves its path");
    }
}

void Session::begin_path(const simulated::HandPath &path, const char *what) {
    require_no_exclusive_use();
    servo_->paused([&] {
        const simulated::HandPath whole = from_here(hand_control().hand_m(), path);
        hand_control().follow(whole);
        hand_.follow(whole, latest().time_s);
        note(dump({{"hand", what}, {"after_tick", latest().tick}}));
    });
}

/// The path of an emulated device, which starts in its zero pose.
void Session::move_emulated() {
    if (device_->emulated() == nullptr) {
        return;
    }
    if (!options_.path.empty()) {
        follow_path(simulated::HandPath::read_csv(options_.path));
    } else if (options_.plays_script) {
        follow_script();
    }
}

void Session::follow_script() {
    static_cast<void>(hand_control());
    const LoadedScene &shown = scenes_->now();
    follow_path(simulated::HandPath(scene::scripted_touch(
        description(), shown.surface, shown.scene.lower_m, shown.scene.upper_m)));
}

void SimulatedHand::take_hold(simulated::HandControl *hand, const device::DeviceDescription &device,
                              const std::optional<simulated::HandPath> &path,
                              const Vector3 &target_m) {
    hand_ = hand;
    geometry_ = device.geometry;
    workspace_ = device.workspace;
    path_ = path;
    path_began_s_ = 0.0;
    target_m_ = target_m;
}

void SimulatedHand::move_to(const Vector3 &target_m) {
    const Vector3 lower_m = workspace_.centre_m - 0.5 * workspace_.size_m;
    const Vector3 upper_m = workspace_.centre_m + 0.5 * workspace_.size_m;
    target_m_ = nearest_in_reach(geometry_, workspace_.centre_m,
                                 target_m.cwiseMax(lower_m).cwiseMin(upper_m));
    if (hand_ != nullptr) {
        hand_->set_hand_target(target_m_);
    }
}

void SimulatedHand::play(simulated::HandStimulus stimulus) {
    stimulus.number = ++stimuli_;
    if (hand_ != nullptr) {
        hand_->play(stimulus);
    }
}

void SimulatedHand::follow(const simulated::HandPath &path, double began_s) {
    path_ = path;
    path_began_s_ = began_s;
}

void SimulatedHand::advance(double time_s) {
    if (path_) {
        target_m_ = path_->at(time_s - path_began_s_).position_m;
        if (time_s - path_began_s_ > path_->end_s()) {
            path_.reset();
        }
    }
}

} // namespace springdrive::session
