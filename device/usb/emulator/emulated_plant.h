// The simulated PHANTOM behind a board's pins, as a chip of board/board.h.
//
//   apply(order) ──► e_W = duty ratio × supply, R̂ = 0 ──► SimulatedPhantom ──► sample()
//
// The board computes e_A itself, so the simulated amplifiers pass e_W on. Currents are sampled in
// the middle of a PWM period, and what is computed from them acts in the next one, half a period
// later: the plant's delay is the board's actuation lag less half a period.
//
// Differences from a real device: an open stage while others drive, and a broken winding, are
// driven with their back-EMF k_T θ̇, so that the winding's current decays with L/R and remains below
// some milliamperes; then all its torque is that current's. A stage can brake without supply.
#pragma once

#include "device/core/faults.h"
#include "device/simulated/simulated_phantom.h"
#include "device/usb/board/board.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace springdrive::emulator {

class EmulatedPlant {
public:
    /// Temperature of the power stages.
    static constexpr float kStage_C = 30.0F;

    /// @param simulation  its servo period and delay are set here
    /// @param start_us  board time at power-up
    /// @throw InputError for options that a board cannot have, or as SimulatedPhantom does
    EmulatedPlant(const device::DeviceDescription &description,
                  const board::BoardSettings &settings,
                  const simulated::SimulationOptions &simulation, const Vector3 &start_tip_m,
                  std::uint32_t start_us);

    // Of board::Hardware:

    /// Advances by one loop, with what was applied last.
    [[nodiscard]] board::Samples sample();
    void apply(const board::BridgeOrder &order);
    /// Of the last samples.
    [[nodiscard]] std::uint32_t now_us() const;
    void kick_watchdog() {}
    [[nodiscard]] bool load_block(std::uint16_t index, usb::CalibrationBlock &block) const;
    bool store_block(const usb::CalibrationBlock &block);

    /// Power returns: counters and time begin again; the calibration is kept.
    void restart();

    /// Updated by the board.
    [[nodiscard]] device::FaultInjector &faults() { return faults_; }
    [[nodiscard]] const device::FaultInjector &faults() const { return faults_; }

    /// Since the construction.
    [[nodiscard]] std::uint64_t loops() const { return loops_; }
    [[nodiscard]] simulated::SimulatedPhantom &phantom() { return phantom_; }
    [[nodiscard]] const simulated::SimulatedPhantom &phantom() const { return phantom_; }

private:
    [[nodiscard]] double supply_V() const;
    [[nodiscard]] double voltage_V(const board::BridgeOrder &order, std::size_t channel,
                                   Eigen::Index motor) const;
    void sample_encoders(const device::Measurement &measured, board::Samples &samples);
    void sample_currents(const device::Measurement &measured, board::Samples &samples) const;

    board::BoardSettings settings_;
    simulated::SimulatedPhantom phantom_;
    std::uint32_t start_us_;
    device::FaultInjector faults_; ///< between the board and the motors, by channel; and the link's
    device::DeviceCommand applied_ = device::DeviceCommand::braking();
    std::uint64_t loops_ = 0;
    std::uint64_t power_up_loop_ = 0;
    bool has_counters_ = false; ///< they begin with the first samples
    std::array<std::int32_t, 3> counts_at_power_up_{};
    std::array<std::uint16_t, 3> counter_{};
    std::array<std::int32_t, 3> turned_{}; ///< counts since power-up, had none been lost
    std::array<double, 3> lost_{};
    std::array<std::optional<usb::CalibrationBlock>, board::kCalibrationBlocks> stored_;
};
static_assert(board::Hardware<EmulatedPlant>);

} // namespace springdrive::emulator
