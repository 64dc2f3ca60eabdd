// What a device's board does for its commissioning, beside being driven: test pulses on one winding
// after the other, what it says of itself, and a calibration that it keeps for its host.
//
// For one thread, while no servo runs. That thread goes on to read measurements and to write
// braking commands meanwhile, as a board that hears nothing ends its test.
#pragma once

#include "device/core/calibration.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::device {

/// A voltage of each sign on each winding, the others open.
struct PulseOrder {
    double voltage_V = 0.5;
    double duration_s = 8e-3; ///< of each sign
};

/// What a board measured and found on one channel.
struct ChannelPulse {
    double resistance_Ohm = std::numeric_limits<double>::quiet_NaN(); ///< as its sensor sees it
    double inductance_H = std::numeric_limits<double>::quiet_NaN();   ///< the same
    std::array<int, 3> moved_counts{}; ///< of each encoder, by a positive voltage
    bool is_open = false;              ///< hardly any current
    bool has_reversed_sensor = false;  ///< current against the voltage
    bool has_crossed_sensor = false;   ///< current in another channel
    bool has_no_motion = false;        ///< held, or no encoder
    bool has_reversed_encoder = false; ///< counts against the voltage
    bool has_crossed_encoder = false;  ///< another counts more
    bool is_at_limit = false;          ///< of the test, which ended it
};

enum class PulseState : std::uint8_t { never, running, completed, aborted };

struct PulseResult {
    PulseState state = PulseState::never;
    std::array<ChannelPulse, 3> channel;
};

/// A name and a value with its unit, for people.
struct Fact {
    std::string name;
    std::string value;
};

class Bench {
public:
    Bench() = default;
    Bench(const Bench &) = delete;
    Bench &operator=(const Bench &) = delete;
    virtual ~Bench() = default;

    /// The shortest pulse that the board can measure in [s].
    [[nodiscard]] virtual double shortest_pulse_s() const = 0;

    /// @throw InputError if the board refuses, or does not answer
    virtual void start_pulses(const PulseOrder &order) = 0;

    /// Of the pulses that were started last.
    /// @throw InputError if the board does not answer
    [[nodiscard]] virtual PulseResult pulses() = 0;

    /// All that the board says of itself.
    /// @throw InputError if it does not answer
    [[nodiscard]] virtual std::vector<Fact> facts() = 0;

    /// What `store` left there, if anything.
    /// @throw InputError if it does not answer, or if what it has stored is damaged
    [[nodiscard]] virtual std::optional<Calibration> stored_calibration() = 0;

    /// Keeps it without power, too; the numbers as singles.
    /// @throw InputError if the board refuses, as while it drives motors, or does not keep it
    virtual void store(const Calibration &calibration) = 0;
};

} // namespace springdrive::device
