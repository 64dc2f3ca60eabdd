#include "engine/lab/charts/contact_press.h"

#include "base/timing.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace springdrive::charts {

namespace {

constexpr double kFarAway_rad = 1000.0; ///< no motor turns so far

} // namespace

rig::Scenario press_of(const ChartSetting &setting, const rig::PressOptions &press) {
    return rig::press_scenario({setting.device, setting.tuning}, press);
}

rig::LawRig press_loop(const rig::Scenario &press, PressedPlant &plant) {
    rig::LawOptions options;
    options.device = press.device;
    options.tuning = press.tuning;
    options.period_s = press.simulation.servo_period_s;
    options.max_turn_rad = kFarAway_rad;
    return {plant, options, press.constraint, rig::FirstCommand::answers};
}

double PressRecord::max_force_N() const {
    double max_N = 0.0;
    for (const Vector3 &one : force_N) {
        max_N = std::max(max_N, one.norm());
    }
    return max_N;
}

PressRecord run_press(const rig::Scenario &press, const NewPlant &new_plant) {
    const std::unique_ptr<PressedPlant> plant = new_plant();
    rig::LawRig loop = press_loop(press, *plant);
    PressRecord record;
    for (int period = 0; period < periods_of(press); ++period) {
        record.commands.push_back(loop.command());
        loop.tick();
        record.force_N.push_back(plant->force_N());
    }
    return record;
}

Cost press_cost(const rig::Scenario &press, const PressRecord &record, const NewPlant &new_plant,
                int sub_steps, int repeats) {
    constexpr int kMinSubSteps = 5120; // below, the clock would be too coarse
    const int rounds = std::max(1, kMinSubSteps / (periods_of(press) * std::max(1, sub_steps)));
    std::vector<std::unique_ptr<PressedPlant>> plants; // one for each press
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
    return cost_of(repeats,
                   rounds * periods_of(press) * press.simulation.servo_period_s / kMillisecond_s,
                   work);
}

double force_error_N(const PressRecord &record, const PressRecord &reference) {
    constexpr double kAway = 10.0;
    const double away_N = kAway * reference.max_force_N();
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
