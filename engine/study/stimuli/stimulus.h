// One stimulus: as the servo is to present it (protocols make them, engine/study/protocol), and as
// it is presented: what the servo is told, the steering of its force, what of it was delivered, and
// all of this on the servo's own thread.
#pragma once

#include "base/hand_over.h"
#include "base/vector.h"
#include "device/core/device_description.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_monitor.h"
#include "engine/servo/servo_inputs.h"
#include "engine/servo/servo_sample.h"
#include "engine/study/stimuli/warm_up.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace springdrive::study {

/// How a stimulus comes to the hand.
enum class StimulusForm : std::uint8_t {
    press,  ///< the hand presses on the spot with `press_N`
    blow,   ///< the hand strikes the spot with `speed_m_per_s`
    pulse,  ///< the hand rests on the spot with `press_N`; the device pushes once, by `pulse_N`
    stroke, ///< the hand moves to and fro in free space, `speed_m_per_s` at most
};

/// By their number, as in protocol files.
inline constexpr std::array<std::string_view, 4> kStimulusFormNames{"press", "blow", "pulse",
                                                                    "stroke"};

/// What holds the tip where it is presented a stimulus.
enum class Hold : std::uint8_t {
    surface, ///< the scene: without friction, so that the tip slides where it is not pressed square
    cup,     ///< a friction cup at the spot: x₀ stays where the tip first touches the scene
};

/// By their number, as in protocol files.
inline constexpr std::array<std::string_view, 2> kHoldNames{"surface", "cup"};

/// The axes in which a force's direction is told: right-handed about `turn_axis`, from the normal.
struct TurnFrame {
    Vector3 normal{Vector3::UnitY()};    ///< unit
    Vector3 turn_axis{Vector3::UnitX()}; ///< unit, square to it
};

/// How far a force leans [°]; of a force against the normal beyond 90.
struct ForceAngles {
    double turn_deg = 0.0;   ///< out of the normal, about the turn axis
    double across_deg = 0.0; ///< out of the plane of that turn, towards the axis
};
[[nodiscard]] ForceAngles force_angles(const TurnFrame &frame, const Vector3 &force);

/// One period of 1 − cos, `height_N` at its middle; 1/`frequency_hz` long.
struct Pulse {
    double height_N = 0.0; ///< as the force on a hand that does not move
    double frequency_hz = 30.0;

    [[nodiscard]] double length_s() const { return 1.0 / frequency_hz; }
    /// At a time from its beginning [N]; 0 before and after. RT-safe.
    [[nodiscard]] double force_N(double since_s) const noexcept;
    /// The force's derivative [N/s]. RT-safe.
    [[nodiscard]] double rate_N_per_s(double since_s) const noexcept;
};

/// From the end of a pulse until the currents have settled [s]: ten of their time constants L/dR at
/// 0.5 Ω, and a servo's delay at 1 kHz.
inline constexpr double kAfterPulse_s = 0.01;

struct Stimulus {
    StimulusForm form = StimulusForm::press;
    Hold hold = Hold::surface;
    control::Tuning contact;
    control::Tuning free_space;       ///< before and after; only dR and λ matter there
    Vector3 start_m{Vector3::Zero()}; ///< where the hand rests before
    TurnFrame frame;
    Vector3 direction{Vector3::UnitY()}; ///< unit: of the force, or of the pulse
    bool is_steered = false;             ///< the force is kept in that direction
    Pulse pulse;
    double rest_s = 0.5;           ///< the hand is at rest at the start for so long
    double approach_s = 2.0;       ///< at most, from there to contact
    double presentation_s = 1.0;   ///< from contact; of a stroke from the end of the rest
    double min_glide_back_s = 0.0; ///< see `glide_back_s`; one for all that are compared

    /// From contact to the beginning of the pulse: the middle, or so that it ends, and the currents
    /// have settled, in time.
    [[nodiscard]] double pulse_from_s() const;
};

/// So long the hand stays in contact after the presentation, until free space tells nothing of it:
/// ten of the time constants with which the servo glides if dR or λ have to, K_P and the rest do
/// not matter there; half of that if a steered force has to be taken back; else 0. But at least
/// `min_glide_back_s`, except of a stroke.
[[nodiscard]] double glide_back_s(const Stimulus &stimulus);

// What a stimulus is measured by: the same of what was intended and of what was delivered.

/// Nothing where it does not apply, or could not be measured.
struct StimulusMeasures {
    std::optional<double> turn_deg;          ///< of the force, or of a pulse; see `ForceAngles`
    std::optional<double> across_deg;        ///< the same
    std::optional<double> stiffness_N_per_m; ///< along the normal, at rest
    std::optional<double> press_N;           ///< of the hand along the normal, at rest
    std::optional<double> speed_m_per_s;     ///< of the hand: at touch, or at most in a stroke
    std::optional<double> pulse_N;           ///< height of a pulse, on a hand that does not move

    friend bool operator==(const StimulusMeasures &, const StimulusMeasures &) = default;
};

/// How far what was delivered may be off.
enum class Band : std::uint8_t {
    direction, ///< difference from the intended angle, at most `Marking::direction_deg`
    stiffness, ///< share of the intended one, at most `Marking::stiffness_percent`
    force,     ///< share of the intended one, at most `Marking::force_percent`
};

struct StimulusMeasure {
    std::string_view name; ///< in stores and exports, with its unit
    std::optional<double> StimulusMeasures::*value = nullptr;
    Band band = Band::force;
};

/// The list of all, in the order in which they are stored.
inline constexpr std::array<StimulusMeasure, 6> kStimulusMeasures{{
    {"direction_deg", &StimulusMeasures::turn_deg, Band::direction},
    {"direction_across_deg", &StimulusMeasures::across_deg, Band::direction},
    {"stiffness_N_per_m", &StimulusMeasures::stiffness_N_per_m, Band::stiffness},
    {"press_N", &StimulusMeasures::press_N, Band::force},
    {"speed_m_per_s", &StimulusMeasures::speed_m_per_s, Band::force},
    {"pulse_N", &StimulusMeasures::pulse_N, Band::force},
}};

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
static_assert(kStimulusFailures.size() ==
              static_cast<std::size_t>(StimulusFailure::too_much_work) + 1);
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

// A stimulus on the servo's own thread: presented and measured there, watched from another.
//
//   servo's thread:  update() after each tick ──► StimulusRun, DeliveryMeter
//   any other:       phase(), ended_s(), and, once it is over, delivered() and failure()

class LiveStimulus final : public servo::InputSchedule {
public:
    LiveStimulus(const device::DeviceDescription &device, const Stimulus &stimulus,
                 double period_s);

    /// Thread of the servo only. What was added is still taken back after the end.
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override;

    /// The tuning in contact from the next tick on: of an adjustment. One thread, not the servo's.
    void set_contact(const control::Tuning &tuning) noexcept { contact_.publish(tuning); }
    /// Ends the presentation with the next tick.
    void finish() noexcept { is_finished_.store(true, std::memory_order_release); }

    /// Whether the servo has taken it up: then it uses none before it any more.
    [[nodiscard]] bool has_begun() const { return has_begun_.load(std::memory_order_acquire); }
    [[nodiscard]] StimulusPhase phase() const { return phase_.load(std::memory_order_acquire); }
    [[nodiscard]] bool is_over() const {
        return phase() == StimulusPhase::done || phase() == StimulusPhase::failed;
    }

    // @pre of all below: is_over()

    [[nodiscard]] StimulusFailure failure() const { return run_.failure(); }
    [[nodiscard]] DeliveredStimulus delivered() const { return meter_.delivered(); }
    /// Of the presentation, by `ServoSample::clock_s`; in lockstep by its `time_s`. NaN if it never
    /// began.
    [[nodiscard]] double began_s() const { return began_s_; }
    [[nodiscard]] double ended_s() const { return ended_s_; }
    /// What the monitor said when it tripped.
    [[nodiscard]] const servo::SafetyStatus &trip() const { return trip_; }
    /// When it was seen, by the same clock; NaN without a failure.
    [[nodiscard]] double failed_s() const { return failed_s_; }

private:
    StimulusRun run_;
    DeliveryMeter meter_;
    double began_s_;
    double ended_s_;
    double failed_s_;
    servo::SafetyStatus trip_;
    LatestValue<control::Tuning> contact_;
    std::atomic<bool> is_finished_{false};
    std::atomic<bool> has_begun_{false};
    std::atomic<StimulusPhase> phase_{StimulusPhase::waiting};
};

// A warm-up on the servo's own thread, watched from another.

class LiveWarmUp final : public servo::InputSchedule {
public:
    LiveWarmUp(const device::DeviceDescription &device, const WindingBand &band, double period_s)
        : warm_up_(device, band, period_s) {}

    /// Thread of the servo only.
    void update(const servo::ServoSample &last, servo::LawInputs &next) noexcept override {
        if (!warm_up_.is_over()) {
            warm_up_.update(last, next);
            off_band_K_.store(warm_up_.off_band_K(), std::memory_order_relaxed);
            phase_.store(warm_up_.phase(), std::memory_order_release);
        }
    }

    [[nodiscard]] WarmUpPhase phase() const { return phase_.load(std::memory_order_acquire); }
    [[nodiscard]] bool is_over() const {
        return phase() == WarmUpPhase::done || phase() == WarmUpPhase::failed;
    }
    /// See WarmUp.
    [[nodiscard]] double off_band_K() const { return off_band_K_.load(std::memory_order_relaxed); }
    /// @pre is_over()
    [[nodiscard]] WarmUpFailure failure() const { return warm_up_.failure(); }

private:
    WarmUp warm_up_;
    std::atomic<double> off_band_K_{0.0};
    std::atomic<WarmUpPhase> phase_{WarmUpPhase::waiting};
};

} // namespace springdrive::study
