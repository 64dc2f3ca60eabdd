// A device with a fault: passes everything on to a simulated PHANTOM and, from a given period on,
// commits one fault, until it is mended.
//
//   servo ── e_W, R̂ ──► [gain, sag] ──► SimulatedPhantom
//   servo ◄─ measurement ◄── [step, flicker, drift, lateness, reading, silence] ◄── truth
//
// It goes by the servo's clock, so that runs repeat, but does not wait for a servo that is late:
// numbers go on. What a hand does wrong comes by its path or target; what a window does wrong is
// no device's.
#pragma once

#include "device/simulated/simulated_phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace springdrive::testing {

enum class FaultKind : std::uint8_t {
    none,
    silent,          ///< it is lost: the last known state
    absent,          ///< it says nothing, and is not known to be lost
    corrupt,         ///< what it says cannot be trusted
    repeated,        ///< it says the last once more
    board,           ///< its board reports the faults of size[0], as bits
    not_a_number,    ///< in each current whose size is not zero
    infinite,        ///< the same, with the sign of the size
    count_step,      ///< counts off by the size [counts]
    count_flicker,   ///< the same, in every other period
    count_drift,     ///< counts that run away by the size in each period [counts]
    late_counts,     ///< counts of size[0] periods ago
    current_reading, ///< currents read as the size where it is not zero [A]
    sagging_winding, ///< R less by the size [Ω]
    amplifier_gain,  ///< e_W times the size; −1 is a swapped pair of wires
};

struct Fault {
    FaultKind kind = FaultKind::none;
    Vector3 size{Vector3::Zero()};
};

class FaultyDevice final : public device::HapticDevice {
public:
    FaultyDevice(const device::DeviceDescription &description,
                 const simulated::SimulationOptions &options, const Vector3 &start_tip_m)
        : device_(description, options, start_tip_m) {}

    [[nodiscard]] const device::DeviceDescription &description() const override {
        return device_.description();
    }
    [[nodiscard]] double delay_periods() const override { return device_.delay_periods(); }

    [[nodiscard]] device::DeviceClock clock() const override { return device::DeviceClock::servo; }
    [[nodiscard]] device::Measurement read() noexcept override {
        device_.write(reaching_the_motors(last_command_));
        const device::Measurement truth = device_.read();
        past_counts_[periods_ % past_counts_.size()] = truth.counts;
        answer_ = as_reported(truth);
        ++periods_;
        return answer_;
    }
    void write(const device::DeviceCommand &command) noexcept override { last_command_ = command; }
    [[nodiscard]] device::DeviceIdentity identity() const override { return device_.identity(); }
    void set_period(double period_s) override { device_.set_period(period_s); }
    void zero(const Vector3 &theta_rad) override { device_.zero(theta_rad); }
    void close() noexcept override { device_.close(); }
    void reconnect() override { device_.reconnect(); }

    /// From the period of that number on, counted from zero; in place of the fault before.
    void commit(const Fault &fault, std::uint64_t from_period) {
        fault_ = fault;
        from_ = from_period;
    }
    void mend() { fault_ = {}; }

    /// How much R is less than it should be.
    [[nodiscard]] Vector3 sag_Ohm() const {
        return fault_.kind == FaultKind::sagging_winding ? fault_.size : Vector3::Zero();
    }

    /// Periods in which the servo does not come: the amplifiers hold the last command.
    void pass_by(int periods) noexcept {
        for (int i = 0; i < periods; ++i) {
            static_cast<void>(device_.advance(reaching_the_motors(last_command_)));
        }
    }

    void set_hand_target(const Vector3 &target_m) noexcept { device_.set_hand_target(target_m); }

    [[nodiscard]] const simulated::SimulatedPhantom::Truth &truth() const {
        return device_.truth();
    }
    [[nodiscard]] const device::DeviceCommand &last_command() const { return last_command_; }
    [[nodiscard]] std::uint64_t periods() const { return periods_; }

private:
    [[nodiscard]] FaultKind present() const {
        return periods_ >= from_ ? fault_.kind : FaultKind::none;
    }

    [[nodiscard]] device::DeviceCommand reaching_the_motors(device::DeviceCommand command) const {
        if (present() == FaultKind::amplifier_gain) {
            command.e_W_V = command.e_W_V.cwiseProduct(fault_.size);
        } else if (present() == FaultKind::sagging_winding) {
            command.cancelled_resistance_Ohm += fault_.size; // R − δ − R̂ is R − (R̂ + δ)
        }
        return command;
    }

    [[nodiscard]] device::Measurement as_reported(device::Measurement state) const {
        const FaultKind kind = present();
        if (const std::optional<device::Arrival> arrival = arrival_by(kind)) {
            const std::uint64_t number = state.number;
            state = answer_;
            state.number = kind == FaultKind::repeated ? answer_.number : number;
            state.arrival = *arrival;
            state.health =
                kind == FaultKind::silent ? device::DeviceHealth::lost : device::DeviceHealth::ok;
        }
        if (kind == FaultKind::board) {
            state.faults.bits = static_cast<std::uint16_t>(fault_.size[0]);
        }
        if (kind == FaultKind::late_counts) {
            const auto late = static_cast<std::uint64_t>(fault_.size[0]);
            state.counts =
                past_counts_[(periods_ - std::min(late, periods_)) % past_counts_.size()];
        }
        for (std::size_t motor = 0; motor < 3; ++motor) {
            const auto j = static_cast<Eigen::Index>(motor);
            const double size = fault_.size[j];
            state.counts[motor] += static_cast<std::int32_t>(std::lround(size * steps(kind)));
            if (size == 0.0) {
                continue;
            }
            if (kind == FaultKind::not_a_number) {
                state.current_A[j] = std::numeric_limits<double>::quiet_NaN();
            } else if (kind == FaultKind::infinite) {
                state.current_A[j] = std::copysign(std::numeric_limits<double>::infinity(), size);
            } else if (kind == FaultKind::current_reading) {
                state.current_A[j] = size;
            }
        }
        return state;
    }

    /// How a measurement comes that tells nothing.
    [[nodiscard]] static std::optional<device::Arrival> arrival_by(FaultKind kind) {
        switch (kind) {
        case FaultKind::silent:
        case FaultKind::absent:
            return device::Arrival::absent;
        case FaultKind::corrupt:
            return device::Arrival::corrupt;
        case FaultKind::repeated:
            return device::Arrival::repeated;
        default:
            return std::nullopt;
        }
    }

    /// How many times its size a fault of the counts has grown to.
    [[nodiscard]] double steps(FaultKind kind) const {
        const std::uint64_t since = periods_ - from_;
        switch (kind) {
        case FaultKind::count_step:
            return 1.0;
        case FaultKind::count_flicker:
            return since % 2 == 0 ? 1.0 : 0.0;
        case FaultKind::count_drift:
            return static_cast<double>(since + 1);
        default:
            return 0.0;
        }
    }

    simulated::SimulatedPhantom device_;
    Fault fault_;
    std::uint64_t from_ = 0;
    std::uint64_t periods_ = 0;
    device::DeviceCommand last_command_;
    device::Measurement answer_;
    std::array<std::array<std::int32_t, 3>, 512> past_counts_{};
};

} // namespace springdrive::testing
