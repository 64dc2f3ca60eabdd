// The experiment of the charts of integrators and of plant models: a tip at rest just on a hard
// plate, which a hand then presses into it within some milliseconds, with the control law of the
// paper, (30), (23) and (10), in the loop.
//
// The constraint holds both ways, so that nothing switches. What a hand's target does between two
// samples is steady; e_W is held: between samples the plant is smooth, but for Coulomb friction
// where a press has it.
#pragma once

#include "device/simulated/simulated_phantom.h"
#include "engine/lab/charts/chart_setting.h"
#include "engine/lab/rig/law_rig.h"
#include "engine/lab/rig/work_point.h"

#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace springdrive::charts {

struct ContactPress {
    device::DeviceDescription device;
    control::Tuning tuning;
    device::HandParameters hand;
    double period_s = 1e-3;
    int periods = 40;
    Vector3 start_m{Vector3::Zero()}; ///< on the plate
    Vector3 normal{Vector3::UnitY()}; ///< of the plate, out of it
    double press_m = 0.0;             ///< how far below the plate the hand then wants to be
    double press_s = 0.0;             ///< how long it takes to want so
    double release_s = std::numeric_limits<double>::infinity(); ///< when it goes back, as quickly
    bool coulomb_friction = false;                              ///< of the device's joints

    /// The hand's target, with a corner at every sample.
    [[nodiscard]] simulated::HandPath hand_path() const;

    /// Gravity and viscous friction are the plant's only effects, but for Coulomb friction where
    /// that is on.
    [[nodiscard]] simulated::SimulationOptions plant_options() const;
};

/// A pen grip that presses 10 mm deep within 10 ms, in a slanting direction of an unsymmetrical
/// configuration: all three motors take part.
[[nodiscard]] ContactPress pen_press(const ChartSetting &setting);

/// The same in the plane of the links, with the base joint in its middle: nothing pushes sideways.
[[nodiscard]] ContactPress planar_press(const ChartSetting &setting);

/// The vice of the paper's section VI in the hand's place: 1 µm per newton, and 1 mm deep.
[[nodiscard]] ContactPress vice_press(const ChartSetting &setting);

/// A pen grip that presses as deep as `pen_press` does against the joints' Coulomb friction, holds
/// still until they stick, and lets go.
[[nodiscard]] ContactPress sticking_press(const ChartSetting &setting);

/// What was commanded and what came of it, a row for each period.
struct PressRecord {
    std::vector<simulated::PlantCommand> commands;
    std::vector<Vector3> force_N;

    [[nodiscard]] double greatest_force_N() const;
};

/// A plant that somebody's integrator carries on. `advance` is what is timed.
class PressedPlant : public rig::Plant {
public:
    /// At the end of the last period, or its mean, as the plant gives it.
    [[nodiscard]] virtual Vector3 force_N() const = 0;
};

/// Makes one at rest at the start.
using NewPlant = std::function<std::unique_ptr<PressedPlant>()>;

/// The servo of a press, answering to where the plant stands.
[[nodiscard]] rig::LawRig press_loop(const ContactPress &press, PressedPlant &plant);

/// The whole press in closed loop.
[[nodiscard]] PressRecord run_press(const ContactPress &press, const NewPlant &new_plant);

/// What the plant takes for a millisecond of the press [ns], with the commands of a run before: the
/// control law is not timed, nor what it takes to make a plant.
/// @param sub_steps  about how many a period has: a short press is timed many times in a row
[[nodiscard]] rig::Cost press_cost(const ContactPress &press, const PressRecord &record,
                                   const NewPlant &new_plant, int sub_steps, int repeats);

/// The root mean square of the force's error over all periods [N], a vector's norm at each.
/// Infinite where forces are not finite, or ten times the largest of the reference: it ran away.
[[nodiscard]] double force_error_N(const PressRecord &record, const PressRecord &reference);

} // namespace springdrive::charts
