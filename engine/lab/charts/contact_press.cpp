#include "engine/lab/charts/contact_press.h"

#include "engine/lab/rig/timing.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace springdrive::charts {

namespace {

constexpr double kNoLimit_N = 1e6;      ///< a limit has a corner
constexpr double kFarAway_rad = 1000.0; ///< no motor turns so far

/// From 0 to 1 with rests at both ends and no leap of the acceleration.
double smooth_step(double share) {
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

ContactPress press(const ChartSetting &setting) {
    ContactPress made;
    made.device = setting.device;
    made.tuning = setting.tuning;
    made.start_m = setting.device.workspace.centre_m +
                   setting.device.workspace.size_m.cwiseProduct(Vector3(0.15, -0.1, 0.1));
    made.normal = Vector3(0.36, 0.8, 0.48);
    made.press_s = 10e-3;
    return made;
}

} // namespace

simulated::HandPath ContactPress::hand_path() const {
    std::vector<simulated::HandPath::Point> points;
    for (int k = 0; k <= periods; ++k) {
        const double time_s = k * period_s;
        const double share =
            smooth_step(time_s / press_s) - smooth_step((time_s - release_s) / press_s);
        points.push_back({time_s, start_m - press_m * share * normal});
    }
    return simulated::HandPath(std::move(points));
}

simulated::SimulationOptions ContactPress::plant_options() const {
    simulated::SimulationOptions options;
    options.servo_period_s = period_s;
    options.hand = hand;
    options.path = hand_path();
    options.effects = simulated::PlantEffects::none();
    options.effects.gravity = true;
    options.effects.viscous_friction = true;
    options.effects.coulomb_friction = coulomb_friction;
    return options;
}

ContactPress pen_press(const ChartSetting &setting) {
    ContactPress made = press(setting);
    made.hand.greatest_force_N = kNoLimit_N;
    made.press_m = 10e-3;
    return made;
}

ContactPress planar_press(const ChartSetting &setting) {
    ContactPress made = pen_press(setting);
    made.start_m.x() = 0.0;
    made.normal = Vector3(0.0, 0.8, 0.6);
    return made;
}

ContactPress vice_press(const ChartSetting &setting) {
    ContactPress made = press(setting);
    made.hand = {0.2, 1000.0, 1e6, kNoLimit_N, 10.0};
    made.press_m = 1e-3;
    return made;
}

ContactPress sticking_press(const ChartSetting &setting) {
    ContactPress made = pen_press(setting);
    made.coulomb_friction = true;
    made.release_s = 0.2;
    made.periods = 400;
    return made;
}

rig::LawRig press_loop(const ContactPress &press, PressedPlant &plant) {
    rig::LawOptions options;
    options.device = press.device;
    options.tuning = press.tuning;
    options.period_s = press.period_s;
    options.greatest_turn_rad = kFarAway_rad;
    return {plant, options, rig::plane(press.start_m, press.normal, rig::Sides::both),
            rig::FirstCommand::answers};
}

double PressRecord::greatest_force_N() const {
    double greatest_N = 0.0;
    for (const Vector3 &one : force_N) {
        greatest_N = std::max(greatest_N, one.norm());
    }
    return greatest_N;
}

PressRecord run_press(const ContactPress &press, const NewPlant &new_plant) {
    const std::unique_ptr<PressedPlant> plant = new_plant();
    rig::LawRig loop = press_loop(press, *plant);
    PressRecord record;
    for (int period = 0; period < press.periods; ++period) {
        record.commands.push_back(loop.command());
        loop.tick();
        record.force_N.push_back(plant->force_N());
    }
    return record;
}

rig::Cost press_cost(const ContactPress &press, const PressRecord &record,
                     const NewPlant &new_plant, int sub_steps, int repeats) {
    constexpr int kLeastSubSteps = 5120; // below, the clock would be too coarse
    const int rounds = std::max(1, kLeastSubSteps / (press.periods * std::max(1, sub_steps)));
    std::vector<std::unique_ptr<PressedPlant>> plants; // one for each press to come
    const int presses = rounds * (repeats + 1);
    plants.reserve(static_cast<std::size_t>(presses));
    for (int i = 0; i < presses; ++i) {
        plants.push_back(new_plant());
    }
    auto next = plants.begin();
    const auto work = [&] {
        for (int round = 0; round < rounds; ++round, ++next) {
            for (const simulated::PlantCommand &command : record.commands) {
                (*next)->advance(command);
            }
        }
    };
    constexpr double kMillisecond_s = 1e-3;
    return rig::cost_of(repeats, rounds * press.periods * press.period_s / kMillisecond_s, work);
}

double force_error_N(const PressRecord &record, const PressRecord &reference) {
    constexpr double kAway = 10.0;
    const double away_N = kAway * reference.greatest_force_N();
    double sum = 0.0;
    for (std::size_t k = 0; k < reference.force_N.size(); ++k) {
        const Vector3 &force_N = record.force_N[k];
        if (!force_N.allFinite() || force_N.norm() > away_N) {
            return std::numeric_limits<double>::infinity();
        }
        sum += (force_N - reference.force_N[k]).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(reference.force_N.size()));
}

} // namespace springdrive::charts
