// A device's self-test, one tick after the other, so that a window and a command can both show it
// while it goes on:
//
//   rest ──► pulses on each winding, several times ──► motion by hand from stop to stop ──► report
//
// The device brakes all the time, except for the pulses, whose limits are the board's own.
#pragma once

#include "device/core/device_description.h"
#include "device/core/haptic_device.h"
#include "engine/commissioning/pulse_fit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace springdrive::commissioning {

// What is wrong with a device, by what its sensors say of test pulses and of motion by hand.
//
// Windings and current sensors, by test pulses on one winding after the other.
//
// A sensor's gain g shows R/g and L/g, and leaves L/R as it is. So one channel whose L differs from
// that of the two others has a sensor with another gain, or a motor with another L: data sheets
// give no tolerance for that, and motors of a kind are assumed to differ by less than
// kGainTolerance. Among two against one, the file's L decides which are named.
//
// Encoders, joints and the zero, while somebody turns each joint from stop to stop and all motors
// brake.
//
// A braking winding is a second witness of motion: by (1) with e_A = 0 and the voltage V_b of
// brushes and bridge,
//
//   −∫R i dt − V_b ∫tanh(i/i_b) dt = k_T Δθ + L Δi
//
// where R, i and i_b are all as the current sensor sees them, so that its gain drops out. What
// counts say is compared with it over windows, and over the distances between the joints' stops.
// Pulses do not tell i_b, so it is done with each that there may be: how well windows and counts
// agree tells it, where V_b is not small and the motion so fast that i passes i_b. Where it is not,
// V_b/i_b is a resistance that nobody knows: then only the distances tell that counts are lost.
//
// Zero and distances are checked at five stops that the tip reaches within its workspace: both of
// the base joint, both of the angle between the links, q₃ − q₂, and the lower one of q₃.

enum class Problem : std::uint8_t {
    board_fault,
    wrong_voltage, ///< of all channels
    open_winding,
    reversed_sensor,
    crossed_sensors,
    wrong_sensor_gain,
    wrong_resistance,
    wrong_inductance,
    seized_joint,
    dead_encoder,
    reversed_encoder,
    crossed_encoders,
    wrong_counts, ///< more or fewer than the rotor turns
    wrong_zero,
    stops_not_reached, ///< so that zero and counts could not be checked by them
    test_aborted,      ///< by a limit of the board's
};

struct Finding {
    Problem problem = Problem::board_fault;
    std::optional<std::size_t> channel; ///< of motor, winding, sensor and encoder, from 0
    std::string what;                   ///< with the figures that show it
    std::string remedy;                 ///< what to look at, or to do
};

/// By which L of one channel may differ from that of the two others, as a share of it; and by as
/// many deviations of what was measured.
inline constexpr double kGainTolerance = 0.05;
inline constexpr double kGainDeviations = 6.0;

/// By which L may differ from the file's, as a share of it: data sheets give no tolerance.
inline constexpr double kInductanceTolerance = 0.25;

/// Over the pulses that were completed, as the current sensors see them, and deviations of that.
struct WindingFigures {
    double resistance_Ohm = 0.0;
    double resistance_deviation_Ohm = 0.0;
    double inductance_H = 0.0;
    double inductance_deviation_H = 0.0;
    double brush_V = 0.0; ///< V_b
    double brush_deviation_V = 0.0;
    std::array<BrushCurve, kBrushCurves> curve;
    bool has_reversed_sensor = false;

    [[nodiscard]] bool is_measured() const { return resistance_Ohm > 0.0; } // not for NaN
};

/// Pulses of one voltage, on all windings.
struct PulseRound {
    device::PulseOrder order;
    device::PulseResult result;
};

struct WindingReport {
    std::array<WindingFigures, 3> motor;
    std::vector<Finding> findings;
};

/// Motors are taken to be as warm as the air.
/// @param rounds  at least one
[[nodiscard]] WindingReport check_windings(const device::DeviceDescription &device,
                                           std::span<const PulseRound> rounds);

/// By which counts may differ from what the windings say, as a share: 3 % of k_T's tolerance, 2 %
/// by which the commutator's ripple may make R of the pulses differ from its mean, 1 % of back-EMF
/// in that R in a relaxed hand, 1 % of noise and offset of the current. The distances between stops
/// are known better. Or as many deviations, of i_b that is not known.
inline constexpr double kCountsTolerance = 0.07;
inline constexpr double kCountsDeviations = 3.0;

/// By which an angle may differ from a stop's in the device file [rad]: 1° that a stop yields to a
/// hand, and 2° of a zero pose found by eye.
inline constexpr double kStopTolerance_rad = 0.0524;

/// How far each motor was turned in all, and how well counts and currents agree on it.
struct MotionFigures {
    double turned_by_counts_rad = 0.0;  ///< of the motor
    double turned_by_current_rad = 0.0; ///< the same
    double counts_per_turned = 0.0;     ///< counted angle by turned angle; 1 for a whole encoder
    double counts_deviation = 0.0;      ///< of that
    // By each i_b that the pulses allow.
    double turned_at_least_rad = 0.0;
    double turned_at_most_rad = 0.0;
};

/// The range of angles that was passed through, and the file's.
struct StopFigures {
    std::string name; ///< "joint 1"
    double lowest_rad = 0.0;
    double highest_rad = 0.0;
    double file_lowest_rad = 0.0;
    double file_highest_rad = 0.0;
    bool has_highest = true; ///< whether its upper stop can be reached
};

struct MotionReport {
    std::array<MotionFigures, 3> motor;
    std::array<StopFigures, 3> stops;
    std::vector<Finding> findings;
};

class MotionCheck {
public:
    explicit MotionCheck(const device::DeviceDescription &device);

    /// What the sensors read at rest, as the mean of a while without motion.
    void set_offsets(const Vector3 &offset_A) { offset_A_ = offset_A; }

    /// As measured by pulses, before any motion.
    void set_windings(const WindingReport &windings);

    /// One measurement after the other, of a device that brakes.
    void take(const device::Measurement &measured);

    /// The first stops that nobody has moved the device to yet, for people; empty if there are
    /// none.
    [[nodiscard]] std::string missing() const;

    /// Of the three motions to the stops, how many are over, as a share.
    [[nodiscard]] double share() const;

    /// @param is_zeroed  whether counts give angles: without it, zero is not checked
    [[nodiscard]] MotionReport report(bool is_zeroed) const;

private:
    /// A value of each motor, by each i_b.
    using Curves = Eigen::Array<double, 3, kBrushCurves>;

    struct Window {
        double duration_s = 0.0;
        Curves turned_rad{Curves::Zero()}; ///< by the currents
        double block_s = 0.0;
        Vector3 block_As{Vector3::Zero()}; ///< charge that is not in `turned_rad` yet
        std::array<std::int32_t, 3> first_counts{};
    };

    [[nodiscard]] bool is_window_over(const device::Measurement &measured) const;
    [[nodiscard]] double counted_rad(const device::Measurement &measured, std::size_t motor) const;
    void begin_window(const device::Measurement &measured);
    void close_block();
    void close_window(const device::Measurement &measured);
    [[nodiscard]] MotionFigures figures(std::size_t motor) const;
    [[nodiscard]] double agreement(std::size_t motor, std::size_t encoder) const;
    [[nodiscard]] Vector3 joints_rad(const device::Measurement &measured) const;
    [[nodiscard]] std::array<StopFigures, 3> stops() const;

    device::DeviceDescription device_;
    bool has_measurement_ = false;
    device::Measurement last_;
    Vector3 offset_A_{Vector3::Zero()};
    Window window_;
    WindingReport windings_;
    /// −1/k_T of motors, with the sign of their sensors.
    Vector3 turned_per_Vs_{Vector3::Zero()};
    Curves resistance_Ohm_{Curves::Zero()};
    Curves brush_V_{Curves::Zero()};
    Curves brush_A_{Curves::Ones()};
    Curves chi2_{Curves::Zero()};
    // Sums over windows, of angles x by counts and y by currents [rad]:
    std::array<Curves, 3> turned_with_counts_{Curves::Zero(), Curves::Zero(),
                                              Curves::Zero()}; ///< Σ y x, of each encoder's x
    Curves turned_squared_{Curves::Zero()};
    Curves turned_rad_{Curves::Zero()}; ///< Σ |y|
    Vector3 counts_squared_{Vector3::Zero()};
    Vector3 counted_rad_{Vector3::Zero()}; ///< Σ |x|
    std::array<int, 3> windows_{};         ///< in which it was counted
    Vector3 lowest_rad_{Vector3::Zero()};  ///< joints 1 and 3, and q₃ − q₂
    Vector3 highest_rad_{Vector3::Zero()};
};

/// What moves a device where a person is asked to, such as a simulated hand: called once, when the
/// motion begins. Empty: a person moves it.
/// @param longest_s  that the motion may last
/// @return how long it lasts [s]
using Mover = std::function<double(double longest_s)>;

struct SelfTestOptions {
    /// The highest voltage: levels rise to it in steps, until a winding takes kLastLevel_A or more.
    device::PulseOrder pulse{1.8, 8e-3};
    int repeats = 3; ///< of the levels
    double rest_s = 0.5;
    bool has_motion = true; ///< otherwise it ends with the pulses
    /// Whoever begins it lets the board go on after a stop that it has latched already.
    bool lets_go_on = false;
    double longest_motion_s = 90.0;
};

/// Levels of the pulses' voltages, as shares of the highest: a motor whose brushes take 0.5 V shall
/// have two above i_b, one without brushes currents that differ by a factor of three.
inline constexpr std::array<double, 5> kPulseLevels{0.28, 0.5, 0.67, 0.83, 1.0};
/// The next level takes at most 0.17 A more, at 2.18 Ω, and a back-EMF's 0.1 A: the board ends its
/// pulses at 1 A, 2.2 N at the tip of a PHANTOM 1.0.
inline constexpr double kLastLevel_A = 0.6;

enum class SelfTestStage : std::uint8_t { rest, pulses, motion, done };

struct SelfTestReport {
    bool is_complete = false; ///< went through all stages that were asked for
    bool has_motion = false;  ///< `motion` is valid
    WindingReport windings;   ///< if there are `pulses`
    std::vector<PulseRound> pulses;
    MotionReport motion;
    std::vector<Finding> findings; ///< all

    [[nodiscard]] bool has_passed() const { return is_complete && findings.empty(); }
};

class SelfTest {
public:
    /// @param device  has a bench, and is read and written by nobody else; outlives this
    /// @param mover   in place of a person
    explicit SelfTest(device::HapticDevice &device, const SelfTestOptions &options = {},
                      Mover mover = {});

    /// One tick: reads a measurement, answers by braking. The first ones reset what the board has
    /// latched before, as BoardReset permits. @return whether there is more to do
    /// @throw InputError if the board does not answer any more, or refuses the pulses
    bool step();

    [[nodiscard]] SelfTestStage stage() const { return stage_; }
    /// What the person shall do now.
    [[nodiscard]] std::string instruction() const;
    /// Whether the device has been everywhere.
    [[nodiscard]] bool has_reached_all() const { return motion_.missing().empty(); }
    [[nodiscard]] double share() const; ///< of the present stage

    /// The person has moved the device as far as it goes. Ignored in any other stage.
    void finish_motion();

    /// The rotors' angles of the last tick, for display.
    [[nodiscard]] Vector3 theta_rad() const;

    [[nodiscard]] SelfTestReport report() const;

private:
    void require_news(const device::Measurement &measured);
    void rest(const device::Measurement &measured);
    [[nodiscard]] device::PulseOrder order() const;
    void start_pulses();
    void pulse();
    void move(const device::Measurement &measured);

    device::HapticDevice &device_;
    device::Bench &bench_;
    SelfTestOptions options_;
    Mover mover_;
    std::array<std::int32_t, 3> counts_{}; ///< of the last tick
    SelfTestStage stage_ = SelfTestStage::rest;
    double stage_began_s_ = -1.0; ///< by the device's time; before the first measurement
    double now_s_ = 0.0;
    int ticks_ = 0;
    device::BoardReset reset_;
    std::vector<PulseRound> pulses_;
    std::size_t level_ = 0;
    int repeat_ = 0;
    MotionCheck motion_;
    bool is_complete_ = false;
    int silent_reads_ = 0; ///< one after the other
    std::array<std::int32_t, 3> rest_counts_{};
    Vector3 rest_sum_A_{Vector3::Zero()};
    int rest_ticks_ = 0;
    std::vector<Finding> faults_;         ///< of the board
    std::optional<Finding> disagreement_; ///< of a winding with its encoder, by the board
};

} // namespace springdrive::commissioning
