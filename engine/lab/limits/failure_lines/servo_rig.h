// A servo loop on a simulated device, ticked by hand: in a corner of three walls, which holds the
// tip at a point, or in free space.
#pragma once

#include "device/simulated/simulated_phantom.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/lab/loops/stability_case.h"
#include "engine/servo/servo_loop.h"

#include <optional>

namespace springdrive::limits {

/// Passes everything on to a simulated device, until it is told to fail.
class FailingDevice final : public device::HapticDevice {
public:
    FailingDevice(const device::DeviceDescription &device,
                  const simulated::SimulationOptions &options, const Vector3 &start_tip_m)
        : device_(device), options_(options), plant_(std::in_place, device, options, start_tip_m) {}

    [[nodiscard]] const device::DeviceDescription &description() const override {
        return plant_->description();
    }
    [[nodiscard]] double delay_periods() const override { return plant_->delay_periods(); }
    /// It does not wait for a servo that is late: numbers go on.
    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::servo; }
    [[nodiscard]] device::Measurement read() noexcept override;
    void write(const device::DeviceCommand &command) noexcept override {
        heard_ = command;
        plant_->write(command);
    }
    [[nodiscard]] device::DeviceIdentity identity() const override { return plant_->identity(); }
    void set_period(double period_s) override { plant_->set_period(period_s); }
    void zero(const Vector3 &theta_rad) override { plant_->zero(theta_rad); }
    void close() noexcept override { plant_->close(); }
    void reconnect() override { plant_->reconnect(); }

    /// A period in which the servo does not come: the amplifiers hold what they have.
    void pass_by() noexcept { static_cast<void>(plant_->read()); }
    /// Lost for so many reads.
    void stay_lost(int reads) { lost_ = reads; }
    /// Nothing arrives in so many reads.
    void stay_silent(int reads) { silent_ = reads; }
    /// The hand is gone with its mass, wherever the tip is and whatever the currents are.
    void let_go();

    void set_hand_target(const Vector3 &target_m) noexcept { plant_->set_hand_target(target_m); }
    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() const {
        return plant_->truth();
    }
    /// What the device last heard.
    [[nodiscard]] const device::DeviceCommand &heard() const { return heard_; }

private:
    device::DeviceDescription device_;
    simulated::SimulationOptions options_;
    std::optional<simulated::SimulatedPhantom> plant_;
    device::DeviceCommand heard_;
    device::Measurement answer_;
    int silent_ = 0;
    int lost_ = 0;
    std::uint64_t numbers_before_ = 0; ///< of plants before this one
};

/// What the servo is to hold, and who the device.
struct ServoRigOptions {
    loops::StabilityCase which; ///< device, tuning, period, delay and configuration; hands[0] holds
    double hand_force_N = 20.0; ///< the most that it presses with
};

class ServoRig {
public:
    /// The servo runs, and the tip is at rest in free space a little off the corner.
    explicit ServoRig(const ServoRigOptions &options);

    /// @param missed  deadlines before it
    servo::ServoSample tick(int missed = 0);

    /// Until the tip rests in the corner, pressed against all three walls.
    /// @param force_N  by which the hand's spring is stretched
    void press(double force_N);
    /// The hand wants to be a little elsewhere, from the next tick on.
    void nudge();

    [[nodiscard]] bool has_tripped() const {
        return last.safety.state == servo::SafetyState::tripped;
    }

    FailingDevice device;
    servo::ServoInputs inputs;
    servo::ServoSample last;

private:
    void run(double seconds);

    double hand_N_per_m_;
    Vector3 corner_m_;
    Vector3 target_m_;
    contact::HapticSurface walls_;
    servo::ServoLoop loop_;
};

} // namespace springdrive::limits
