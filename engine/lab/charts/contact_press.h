// The experiment of the charts of integrators and of plant models: a tip at rest on the surface of
// a hard plate, which a hand then presses into it within a few milliseconds, with the control law
// of the paper, (30), (23) and (10), in the loop.
//
// The constraint is bilateral, so that nothing switches. Between two samples a hand's target moves
// uniformly and e_W is held: the plant is smooth there, except for Coulomb friction where a press
// has it.
#pragma once

#include "engine/lab/charts/chart.h"

#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <functional>
#include <memory>
#include <vector>

namespace springdrive::charts {

/// A scenario of `press_scenario` for a chart's device and tuning, at 1 kHz.
[[nodiscard]] rig::Scenario press_of(const ChartSetting &setting, const rig::PressOptions &press);

/// Servo periods from the start of a press to its end.
[[nodiscard]] inline int periods_of(const rig::Scenario &press) {
    return static_cast<int>(press.simulation.path->points().size()) - 1;
}

/// Commands and resulting forces, one for each period.
struct PressRecord {
    std::vector<simulated::PlantCommand> commands;
    std::vector<Vector3> force_N;

    [[nodiscard]] double max_force_N() const;
};

/// A plant advanced by one of the integrators. `advance` is what is timed.
class PressedPlant : public rig::Plant {
public:
    /// The force at the end of the last period, or its mean over the period, depending on the
    /// plant.
    [[nodiscard]] virtual Vector3 force_N() const = 0;
};

/// Makes a plant at rest at the start.
using NewPlant = std::function<std::unique_ptr<PressedPlant>()>;

/// The control law of a press. Its first command answers to the plant's initial angles.
[[nodiscard]] rig::LawRig press_loop(const rig::Scenario &press, PressedPlant &plant);

/// The whole press in closed loop.
[[nodiscard]] PressRecord run_press(const rig::Scenario &press, const NewPlant &new_plant);

/// The plant's time for a millisecond of the press [ns], with the commands of a run before: neither
/// the control law nor the construction of a plant is timed.
/// @param sub_steps  approximate number per period: a short press is timed repeatedly
[[nodiscard]] Cost press_cost(const rig::Scenario &press, const PressRecord &record,
                              const NewPlant &new_plant, int sub_steps, int repeats);

/// The root mean square over all periods of the norm of the force's error [N]. Infinite where the
/// run diverged: forces not finite, or ten times the largest of the reference.
[[nodiscard]] double force_error_N(const PressRecord &record, const PressRecord &reference);

} // namespace springdrive::charts
