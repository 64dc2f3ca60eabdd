// Encoders, joints and the zero, while somebody turns each joint from stop to stop and all motors
// brake.
//
// A braking winding is a second witness of motion: by (1) with e_A = 0,
//
//   −∫R i dt = k_T Δθ + L Δi
//
// where R and i are both as the current sensor sees them, so that its gain drops out. What counts
// say is compared with it over windows, and over the distances between the joints' stops.
//
// Zero and distances are checked at five stops that the tip reaches within its workspace: both of
// the base joint, both of the angle between the links, q₃ − q₂, and the lower one of q₃.
#pragma once

#include "device/core/haptic_device.h"
#include "engine/commissioning/finding.h"
#include "engine/commissioning/winding_check.h"

#include <array>
#include <string>
#include <vector>

namespace springdrive::commissioning {

/// By which counts may differ from what the windings say, as a share: 3 % of k_T's tolerance, 2 %
/// by which the commutator's ripple may make R of the pulses differ from its mean, 1 % of back-EMF
/// in that R in a relaxed hand, 1 % of noise and offset of the current. The distances between stops
/// are known better.
inline constexpr double kCountsTolerance = 0.07;

/// By which an angle may differ from a stop's in the device file [rad]: 1° that a stop yields to a
/// hand, and 2° of a zero pose found by eye.
inline constexpr double kStopTolerance_rad = 0.0524;

/// How far each motor was turned in all, and how well counts and currents agree on it.
struct MotionFigures {
    double turned_by_counts_rad = 0.0;  ///< of the motor
    double turned_by_current_rad = 0.0; ///< the same
    double counts_per_turned = 0.0;     ///< counted angle by turned angle; 1 for a whole encoder
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

    /// One measurement after the other, of a device that brakes.
    void take(const device::Measurement &measured);

    /// The first stops that nobody has moved the device to yet, for people; empty if there are
    /// none.
    [[nodiscard]] std::string missing() const;

    /// Of the three motions to the stops, how many are over, as a share.
    [[nodiscard]] double share() const;

    /// @param windings   as measured by pulses before
    /// @param is_zeroed  whether counts give angles: without it, zero is not checked
    [[nodiscard]] MotionReport report(const WindingReport &windings, bool is_zeroed) const;

private:
    struct Window {
        double duration_s = 0.0;
        Vector3 charge_As{Vector3::Zero()};
        std::array<std::int32_t, 3> first_counts{};
    };

    [[nodiscard]] bool is_window_over(const device::Measurement &measured) const;
    [[nodiscard]] double counted_rad(const device::Measurement &measured, std::size_t motor) const;
    void close_window(const device::Measurement &measured);
    [[nodiscard]] Vector3 joints_rad(const device::Measurement &measured) const;
    [[nodiscard]] std::array<StopFigures, 3> stops() const;

    device::DeviceDescription device_;
    bool has_measurement_ = false;
    device::Measurement last_;
    Vector3 offset_A_{Vector3::Zero()};
    Window window_;
    // Sums over windows, of counted angles x [rad] and charges c [A·s]:
    Matrix3 charges_with_counts_{Matrix3::Zero()}; ///< Σ c x, rows by charge
    Vector3 charges_squared_{Vector3::Zero()};
    Vector3 counts_squared_{Vector3::Zero()};
    Vector3 counted_rad_{Vector3::Zero()}; ///< Σ |x|
    Vector3 charged_As_{Vector3::Zero()};  ///< Σ |c|
    Vector3 lowest_rad_{Vector3::Zero()};  ///< joints 1 and 3, and q₃ − q₂
    Vector3 highest_rad_{Vector3::Zero()};
};

} // namespace springdrive::commissioning
