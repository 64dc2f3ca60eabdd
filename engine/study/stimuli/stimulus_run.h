// One stimulus as it is presented: what the servo is told, and the steering of its force.
#pragma once

#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/servo/rest_detector.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"
#include "engine/study/stimuli/stimulus.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::study {

// Keeps a contact's force in a direction that is not that of its spring.
//
// The spring of a contact pulls the tip towards x₀. A force that is turned is that of a spring
// whose x₀ moves: by s along the surface it adds K s, whatever the tip does. If s were a function
// of the tip's position, s = δ tan φ with δ the indentation, the stiffness would be turned, and a
// turned stiffness is no spring: its curl, K tan φ, is work for whoever moves the tip round in a
// circle. So s is a function of time. It follows the direction wanted as an integral does,
//
//   df/dt = (F_n t_s/t_n − F_s)/τ        f = K s, along the surface
//
// with F_n and F_s the rendered force along the normal and the surface, as the currents tell it,
// and t the direction. At rest F is in the direction t whatever the hand's stiffness is, whatever
// the tip has yielded along the surface, and whatever dR really is. A hand of stiffness k yields
// along the surface until F_s = k y, so f is there with the time constant τ (K + k)/k: 53 ms for a
// relaxed grip of 300 N/m at 1700 N/m. To a hand that moves faster it is a spring with a constant
// force; slower, the surface yields like one without friction, square to t.
//
// What slow circles can still earn is bounded: the work that the force along the surface does on
// the hand is counted, and beyond `max_work_J` the steering gives up: it then keeps the force
// along the normal.
//
// A blow is over before that. There f is F_n t_s/t_n at once, with the integral of what is left:
// the turned stiffness itself, under the same bound.

class ForceSteering {
public:
    static constexpr double kTime_s = 0.008; ///< τ

    enum class Pace : std::uint8_t { slow, prompt };

    /// @param normal     unit
    /// @param direction  unit; less than 90° from the normal
    ForceSteering(const Vector3 &normal, const Vector3 &direction, Pace pace, double max_work_J,
                  double max_force_N, double period_s);

    /// Advances by one tick; the force that is to be added, along the surface [N]. RT-safe.
    /// @param force_N  the rendered one
    /// @param share    of the turn's tangent, 0 to 1: 0 is a force along the normal
    Vector3 update(const Vector3 &tip_m, const Vector3 &force_N, double share) noexcept;

    /// Work of the rendered force along the surface on the hand so far [J].
    [[nodiscard]] double work_J() const { return work_J_; }
    [[nodiscard]] bool has_given_up() const { return has_given_up_; }

private:
    void count(const Vector3 &tip_m, const Vector3 &force_N) noexcept;

    Vector3 normal_;
    Vector3 slope_; ///< t_s/t_n
    bool is_prompt_;
    double max_work_J_;
    double max_force_N_;
    double gap_share_; ///< that is closed in a tick
    Vector3 integral_N_{Vector3::Zero()};
    Vector3 last_tip_m_{Vector3::Zero()};
    Vector3 last_force_N_{Vector3::Zero()};
    bool has_last_ = false;
    bool has_given_up_ = false;
    double work_J_ = 0.0;
};

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
// its force, and so is the steering: x₀ of (30), moved by s without its rate,
// adds dR i of the force K s and nothing else. With its rate, (10) would add k_T + K_D for each
// K_P, the coupling's lead, and the force would be no longer what was asked for.

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

/// By the number of the failure.
inline constexpr std::array<std::string_view, 5> kStimulusFailures{
    "", "the safety monitor tripped", "the tip did not touch the spot in time",
    "the tip left the spot before the end", "the hand gave way to the turned force"};
[[nodiscard]] constexpr std::string_view description(StimulusFailure failure) {
    return kStimulusFailures[static_cast<std::size_t>(failure)];
}

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
