// The simulated hand that holds a device, a simulated one or that behind an emulated board: where
// it pulls to over time, its test signals, and how it is controlled.
#pragma once

#include "base/vector.h"
#include "device/core/hand_parameters.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace springdrive::simulated {

struct HandTarget {
    Vector3 position_m{Vector3::Zero()};
    Vector3 velocity_m_per_s{Vector3::Zero()};
};

/// Target path over time: linear between its points; at rest before the first and after the last.
class HandPath {
public:
    using Point = device::PathPoint;

    /// @throw InputError unless there is a point, all are finite and their times increase.
    explicit HandPath(std::vector<Point> points);

    enum class Header : std::uint8_t { required, optional };

    /// Reads a CSV file with the header `t,x,y,z` [s, m].
    /// @throw InputError naming the file, the line and what is wrong with it.
    [[nodiscard]] static HandPath read_csv(const std::filesystem::path &file,
                                           Header header = Header::required);

    /// RT-safe. `time_s` must not decrease between calls.
    [[nodiscard]] HandTarget at(double time_s) noexcept;

    [[nodiscard]] const std::vector<Point> &points() const { return points_; }

    /// Time of the last point.
    [[nodiscard]] double end_s() const { return points_.back().time_s; }

private:
    std::vector<Point> points_;
    std::size_t next_ = 0; ///< the first point after the last requested time
};

enum class StimulusKind : std::uint8_t {
    none,
    step,  ///< out within 5 ms, and back within 5 ms after half of the time
    hold,  ///< out within a fifth of the time, and back within the last fifth
    chirp, ///< a sine whose frequency rises exponentially, fading in and out over a tenth each
};

inline constexpr std::array<const char *, 4> kStimulusLabels{"none", "step", "press and hold",
                                                             "chirp"};

/// A test signal of the hand: its target moves along a line, beside where it is held.
struct HandStimulus {
    StimulusKind kind = StimulusKind::none;
    Vector3 direction{Vector3::UnitY()}; ///< unit vector
    double amplitude_m = 0.0;
    double duration_s = 1.0;
    double from_Hz = 1.0; ///< of a chirp
    double to_Hz = 20.0;
    std::uint32_t number = 0; ///< a change starts the signal
};

/// Beside the hand's own target, at a time since the start; zero before it and after its end.
/// RT-safe.
[[nodiscard]] HandTarget offset_of(const HandStimulus &stimulus, double time_s) noexcept;

class HandControl {
public:
    HandControl() = default;
    HandControl(const HandControl &) = delete;
    HandControl &operator=(const HandControl &) = delete;
    virtual ~HandControl() = default;

    /// Sets the hand's target from now on [m]; the hand moves there smoothly. One thread at a time,
    /// any thread; takes effect once the hand's path, if it has one, has ended.
    virtual void set_hand_target(const Vector3 &target_m) noexcept = 0;

    /// Starts a test signal of the hand, if its number is another one than before. One thread at a
    /// time, any thread.
    virtual void play(const HandStimulus &stimulus) noexcept = 0;

    /// From the next period on, how firm the hand is. One thread at a time, any thread.
    /// @throw InputError for parameters that are out of range
    virtual void hold_with(const device::HandParameters &hand) = 0;

    // While no other thread uses the device:

    /// The hand follows this path from now on: its time 0 is now.
    virtual void follow(HandPath path) = 0;

    /// Where the hand's spring pulls to now, without a test signal [m].
    [[nodiscard]] virtual Vector3 hand_m() const = 0;
};

} // namespace springdrive::simulated
