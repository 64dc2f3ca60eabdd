// Measures what of a stimulus was delivered, from the servo's samples alone: positions by the
// encoders, forces by the windings' currents.
//
//   press    over the second half of the presentation: the direction of the mean force; the
//            stiffness Σ F_n δ/Σ δ² with δ = n·(x₀ − x), a line through the origin; the mean F_n
//   pulse    over the last third before it: stiffness and press; then the impulse ∫ F_p dt of the
//            pulse's own force, whose direction is the pulse's and whose size is ½ height/frequency
//   blow     the speed at which the tip comes, a mean over 10 ms; the direction of ∫ F dt
//   stroke   the largest speed, a mean over 10 ms
//
// F_p is what the currents say, less what the law alone would have driven through the windings:
// L di/dt = e_W − dR i − k_T θ̇ (11), with e_W as commanded less what was added to the law, and θ̇
// from angle to angle. So F_p is the force on a hand that does not move, whatever the hand does.
#pragma once

#include "device/core/device_description.h"
#include "engine/servo/servo_sample.h"
#include "engine/study/stimuli/stimulus.h"
#include "engine/study/stimuli/stimulus_run.h"

#include <cstdint>

namespace springdrive::study {

struct DeliveredStimulus {
    StimulusMeasures measures;
    double start_s = 0.0; ///< of the presentation, by the servo's clock
    double end_s = 0.0;
    double peak_force_N = 0.0; ///< rendered, at the tip
    double aside_m = 0.0;      ///< largest way of the tip along the surface, from where it touched
    double deepest_m = 0.0;    ///< below where it touched, along the normal
    double generated_J = 0.0;  ///< largest reading of the servo's energy observer
    double along_work_J = 0.0; ///< of a steered force on the hand
    double lateness_s = 0.0;   ///< longest row of missed deadlines
    std::uint64_t missed_deadlines = 0;
    bool is_limited = false;            ///< the servo reduced force or voltage
    Vector3 winding_C{Vector3::Zero()}; ///< at the end, by the monitor: the middle of its bounds
};

class DeliveryMeter {
public:
    DeliveryMeter(const device::DeviceDescription &device, const Stimulus &stimulus,
                  double period_s);

    /// A tick of the servo, after `run` has been updated with it. RT-safe.
    void take(const servo::ServoSample &sample, const StimulusRun &run) noexcept;

    /// Of all samples so far.
    [[nodiscard]] DeliveredStimulus delivered() const;

private:
    /// From a time since the touch to another.
    struct Window {
        double from_s = 0.0;
        double until_s = 0.0;

        [[nodiscard]] bool holds(double since_s) const {
            return since_s >= from_s && since_s < until_s;
        }
    };

    [[nodiscard]] static Window settled(const Stimulus &stimulus);
    [[nodiscard]] Vector3 law_force_N(const servo::ServoSample &sample, const Matrix3 &J) noexcept;
    void follow_speed(const servo::ServoSample &sample, bool is_approaching) noexcept;
    void take_presented(const servo::ServoSample &sample, double since_s) noexcept;
    void take_press(const servo::ServoSample &sample) noexcept;
    void take_pulse(const servo::ServoSample &sample, double since_s) noexcept;

    device::DeviceDescription device_;
    Stimulus stimulus_;
    double period_s_;
    Window settled_;
    Window pulse_; ///< with what follows until the currents have settled
    DeliveredStimulus so_far_;
    bool has_begun_ = false;

    Vector3 mean_velocity_m_per_s_{Vector3::Zero()}; ///< over 10 ms
    double speed_at_touch_m_per_s_ = 0.0;
    double largest_speed_m_per_s_ = 0.0;

    Vector3 touched_m_{Vector3::Zero()};
    Vector3 force_sum_N_{Vector3::Zero()}; ///< over the settled part
    double F_delta_sum_ = 0.0;
    double delta_squares_m2_ = 0.0;
    long settled_ticks_ = 0;
    Vector3 impulse_Ns_{Vector3::Zero()}; ///< of all forces since the touch

    bool has_last_ = false;
    Vector3 last_theta_rad_{Vector3::Zero()};
    Vector3 last_law_V_{Vector3::Zero()};
    Vector3 last_dR_Ohm_{Vector3::Ones()};
    Vector3 law_current_A_{Vector3::Zero()};
    Vector3 rest_sum_N_{Vector3::Zero()};  ///< F_p before the pulse: what the model is off
    Vector3 pulse_sum_N_{Vector3::Zero()}; ///< F_p in the pulse's window
    long rest_ticks_ = 0;
    long pulse_ticks_ = 0;
};

} // namespace springdrive::study
