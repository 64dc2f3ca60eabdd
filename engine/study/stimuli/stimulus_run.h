// Presents one stimulus: what the servo is told, tick by tick.
//
//   waiting ──hand at rest at the start──► approaching ──touch──► presenting ──► gliding back
//                                                                                    │
//                            failed ◄── from all but done          done ◄── leaving ◄┘
//
// Until the tip touches, the tuning is that of free space; in contact it is the condition's own, to
// which the servo glides. After the presentation it glides back while the hand is still in contact,
// so that free space tells nothing of the condition, and a steered force turns back to the normal;
// only then the hand is to leave. A stroke is presented in free space, with that tuning throughout.
//
// What the steering adds is held against the spring of the cup, several newtons of which may be in
// balance with it. Where the cup lets go, the servo takes its spring back at kMaxChange_V_per_s;
// what was added is taken back at the same rate, so that the two stay in balance.
//
// α on the fly varies with the pose, by some percent over the way that a hand yields to a turned
// force. In a cup it therefore stays what it was at the touch.
//
// A pulse is a voltage that is added to the law's, dR i + L di/dt of the currents that push with
// its force, and so is the steering of force_steering.h: x₀ of (30), moved by s without its rate,
// adds dR i of the force K s and nothing else. With its rate, (10) would add k_T + K_D for each
// K_P, the coupling's lead, and the force would be no longer what was asked for.
#pragma once

#include "device/core/device_description.h"
#include "engine/servo/rest_detector.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"
#include "engine/study/stimuli/force_steering.h"
#include "engine/study/stimuli/stimulus.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::study {

enum class StimulusPhase : std::uint8_t {
    waiting,      ///< until the hand rests at the start and the servo runs
    approaching,  ///< until it touches
    presenting,   ///< the hand presses, strikes, rests or strokes
    gliding_back, ///< it stays in contact
    leaving,      ///< it goes back to where it came from
    done,
    failed,
};

enum class StimulusFailure : std::uint8_t {
    none,
    tripped,       ///< the safety monitor
    never_touched, ///< in the time for the approach
    left_early,    ///< the surface or the cup, before the hand was to leave
    too_much_work, ///< the hand gave way to a steered force, or led it round
};

/// "the tip left the spot before the end"; empty for none.
[[nodiscard]] std::string_view description(StimulusFailure failure);

class StimulusRun {
public:
    /// Near the start the hand's rest counts [m].
    static constexpr double kNearStart_m = 0.006;
    /// A tip may lose the surface for so long when the hand is to press or rest.
    static constexpr double kBounce_s = 0.1;
    /// A tip so far above x₀ has left the cup.
    static constexpr double kOutOfCup_m = 0.002;
    /// A steered force may do so much of the limit of generated energy as work along the surface.
    static constexpr double kWorkShare = 0.5;
    /// Times the limit of force: what a steering adds against the spring of a cup at the most.
    /// Where the tip has yielded by y the spring takes K y of it.
    static constexpr double kMaxAdded = 4.0;

    StimulusRun(const device::DeviceDescription &device, const Stimulus &stimulus, double period_s);

    /// After a tick: sets tuning, x₀ and excitation of the next one. RT-safe.
    void update(const servo::ServoSample &last, servo::LawInputs &inputs) noexcept;

    /// Another tuning in contact, to which the servo glides.
    void set_contact(const control::Tuning &tuning) noexcept { stimulus_.contact = tuning; }
    /// The presentation is over with the next tick.
    void finish() noexcept { stimulus_.presentation_s = std::max(0.0, presented_s_); }

    [[nodiscard]] StimulusPhase phase() const { return phase_; }
    [[nodiscard]] StimulusFailure failure() const { return failure_; }
    [[nodiscard]] bool is_over() const {
        return phase_ == StimulusPhase::done || phase_ == StimulusPhase::failed;
    }
    /// Since the presentation began, which is at the first touch [s]; below 0 before.
    [[nodiscard]] double presented_s() const { return presented_s_; }
    [[nodiscard]] const ForceSteering &steering() const { return steering_; }
    [[nodiscard]] const Stimulus &stimulus() const { return stimulus_; }

private:
    void enter(StimulusPhase phase) noexcept;
    void fail(StimulusFailure failure) noexcept;
    void wait(const servo::ServoSample &last) noexcept;
    void approach(const servo::ServoSample &last) noexcept;
    void present(const servo::ServoSample &last) noexcept;
    void glide_back() noexcept;
    void leave(const servo::ServoSample &last) noexcept;
    void watch_contact(const servo::ServoSample &last) noexcept;
    [[nodiscard]] control::Tuning tuning(const servo::ServoSample &last) const noexcept;
    [[nodiscard]] double turn_share() const noexcept;
    [[nodiscard]] Vector3 voltage_V(const servo::ServoSample &last) noexcept;

    device::DeviceDescription device_;
    Stimulus stimulus_;
    double period_s_;
    servo::RestDetector rest_;
    ForceSteering steering_;
    StimulusPhase phase_ = StimulusPhase::waiting;
    StimulusFailure failure_ = StimulusFailure::none;
    double in_phase_s_ = 0.0;
    double rested_s_ = 0.0;
    double presented_s_ = -1.0;
    double lost_s_ = 0.0;                     ///< since the tip lost contact
    std::optional<Vector3> cup_m_;            ///< x₀ while the cup holds the tip
    double alpha_at_touch_rad2_per_m2_ = 0.0; ///< the bound (29)
    Vector3 added_V_{Vector3::Zero()};        ///< last
};

} // namespace springdrive::study
