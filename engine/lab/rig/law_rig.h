// A plant and the control law of the paper in closed loop, sample by sample, without command
// limiter and safety monitor: nothing masks the behaviour of law or plant. The whole servo in
// closed loop is servo_rig.h.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/haptic_law.h"
#include "engine/control/rendered_force.h"
#include "engine/control/velocity_filter.h"
#include "engine/lab/rig/scenario/scenarios.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace springdrive::rig {

/// What a law controls.
class Plant {
public:
    Plant() = default;
    Plant(const Plant &) = delete;
    Plant &operator=(const Plant &) = delete;
    virtual ~Plant() = default;

    /// Advances by one servo period under a command.
    virtual void advance(const simulated::PlantCommand &command) = 0;
    /// θ as the law reads it: at the end of the last period, or at the start.
    [[nodiscard]] virtual Vector3 theta_rad() const = 0;
};

/// A simulated device: exact angles at the start, its encoders' counts from then on.
class PhantomPlant final : public Plant {
public:
    /// @param has_counts  false: exact angles always, for near a limit even fine counts sustain a
    ///                    motion of about one of them
    explicit PhantomPlant(simulated::SimulatedPhantom &phantom, bool has_counts = true);

    void advance(const simulated::PlantCommand &command) override;
    [[nodiscard]] Vector3 theta_rad() const override { return theta_rad_; }

private:
    simulated::SimulatedPhantom &phantom_;
    bool has_counts_;
    Vector3 theta_rad_;
};

struct LawOptions {
    device::DeviceDescription device;
    control::Tuning tuning;
    double period_s = 1e-3;
    /// α where the tuning's mode is global; searched for in the workspace where it is not given.
    std::optional<double> global_alpha_rad2_per_m2;
    /// R − R̂ where windings differ from the assumption of (7); it may be negative.
    std::optional<double> net_resistance_Ohm;
    device::AmplifierKind drive = device::AmplifierKind::spring_drive;
    control::VirtualWall wall; ///< rendered by a current drive in place of (10)
    /// Initial angles of the velocity filter; else the plant's first angles.
    std::optional<Vector3> rests_at_rad;
    /// At larger angles the plant is braked: it has run away.
    double max_turn_rad = HUGE_VAL;
};

/// The command of the first period.
enum class FirstCommand : std::uint8_t {
    answers, ///< the law's answer to the plant's first angles
    brakes,
};

class LawRig {
public:
    /// @param plant  must outlive the loop
    LawRig(Plant &plant, const LawOptions &options, Constraint constraint, FirstCommand first);

    /// Advances the plant by a period under the last command; the law answers to the result.
    void tick();

    /// The law's last answer: applied from now on, or after the plant's delay.
    [[nodiscard]] const simulated::PlantCommand &command() const { return command_; }
    /// The input of the last answer.
    [[nodiscard]] const control::Configuration &configuration() const { return configuration_; }
    [[nodiscard]] const contact::Contact &contact() const { return contact_; }

private:
    void answer();
    [[nodiscard]] device::DeviceCommand spring_drive() const;
    [[nodiscard]] Vector3 current_A() const;

    Plant &plant_;
    LawOptions options_;
    Constraint constraint_;
    control::HapticLaw law_;
    double global_alpha_rad2_per_m2_ = 0.0;
    double pole_;
    control::VelocityFilter filter_;
    control::Configuration configuration_;
    contact::Contact contact_;
    simulated::PlantCommand command_{device::DeviceCommand::braking(), Vector3::Zero()};
};

} // namespace springdrive::rig
