// A whole servo in closed loop with a simulated device, ticked explicitly: command limiter and
// safety monitor included, and a device with faults on request. The control law alone in closed
// loop is law_rig.h.
#pragma once

#include "device/core/device_description.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/rig/faulty_device.h"
#include "engine/lab/rig/scenario/scenarios.h"
#include "engine/servo/servo_loop.h"

#include <memory>
#include <optional>

namespace springdrive::rig {

class ServoRig {
public:
    /// @param simulation  its period is the servo's
    /// @param surface     must outlive the rig; none for free space
    /// @throw InputError as `SimulatedPhantom` does
    ServoRig(const device::DeviceDescription &device,
             const simulated::SimulationOptions &simulation, const Vector3 &start_tip_m,
             const contact::HapticSurface *surface = nullptr);
    /// Global α stays to be set in `inputs`, if the tuning uses it.
    /// @throw InputError as `SimulatedPhantom` does
    explicit ServoRig(const Scenario &scenario);
    ServoRig(const ServoRig &) = delete;
    ServoRig &operator=(const ServoRig &) = delete;

    // RT-safe, as far as a simulated device is.
    const servo::ServoSample &tick(const servo::TickTiming &timing = {}) noexcept;
    /// `missed` periods without a tick, then a tick.
    const servo::ServoSample &late_tick(int missed) noexcept;
    /// The ticks of that time.
    void run(double seconds) noexcept;

    /// Removes the hand with its mass; position, rates and currents of the device continue.
    void let_go();

    [[nodiscard]] bool has_tripped() const {
        return last.safety.state == servo::SafetyState::tripped;
    }
    /// What the last tick read.
    [[nodiscard]] const device::Measurement &measured() const { return measured_; }
    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() const {
        return phantom_->truth();
    }
    [[nodiscard]] simulated::SimulatedPhantom &phantom() { return *phantom_; }
    [[nodiscard]] FaultyDevice &device() { return device_; }
    [[nodiscard]] const FaultyDevice &device() const { return device_; }
    [[nodiscard]] servo::ServoLoop &loop() { return loop_; }

    servo::ServoInputs inputs; ///< of the next tick
    servo::ServoSample last;

private:
    device::DeviceDescription description_; ///< as given: the phantom's own may count finer
    simulated::SimulationOptions simulation_;
    std::shared_ptr<const contact::HapticSurface> surface_; ///< of a scenario
    std::optional<simulated::SimulatedPhantom> phantom_; ///< always there; made anew in its place
    FaultyDevice device_;
    servo::ServoLoop loop_;
    device::Measurement measured_;
};

} // namespace springdrive::rig
