#include "device/factory/emulated_device.h"

#include <fmt/format.h>

#include <utility>

namespace springdrive::factory {

namespace {

emulator::EmulatedBoardOptions board_options(const device::DeviceDescription &truth,
                                             const EmulationOptions &options,
                                             const simulated::SimulationOptions &simulation) {
    emulator::EmulatedBoardOptions board;
    board.identity = emulator::emulated_identity(emulated_serial(simulation.device_seed));
    board.settings.counts_per_turn.fill(static_cast<std::uint32_t>(truth.encoder_counts_per_turn));
    board.simulation.effects = simulation.effects;
    board.simulation.hand = simulation.hand;
    board.simulation.device_seed = simulation.device_seed;
    board.start_tip_m = Vector3::Zero();
    board.clock = emulator::BoardClock::frame;
    board.delay_periods = options.delay_periods;
    board.faults = options.faults;
    return board;
}

} // namespace

std::string emulated_serial(std::uint64_t device_seed) {
    constexpr std::uint64_t kSevenDigits = 10'000'000;
    return device_seed == 0 ? kEmulatedSerial
                            : fmt::format("{}-{}", kEmulatedSerial, device_seed % kSevenDigits);
}

EmulatedDevice::EmulatedDevice(const device::DeviceDescription &description, double period_s,
                               const EmulationOptions &options,
                               const simulated::SimulationOptions &simulation)
    : board_(options.truth.value_or(description),
             board_options(options.truth.value_or(description), options, simulation)),
      period_s_(period_s) {
    auto port = std::make_unique<InProcessPort>(board_);
    port_ = port.get();
    device_ = std::make_unique<usb::UsbDevice>(std::move(port), description,
                                               emulated_serial(simulation.device_seed), period_s,
                                               usb::Pacing::reports);
}

void EmulatedDevice::note_cable() noexcept {
    port_->is_plugged = is_plugged_ && !board_.unplug_requested();
    if (!port_->is_plugged && port_->is_connected()) {
        port_->unplug();
    }
}

void EmulatedDevice::reconnect() {
    note_cable();
    device_->reconnect();
}

device::Measurement EmulatedDevice::read() noexcept {
    note_cable();
    if (!port_->is_connected()) {
        board_.pass(period_s_);
    }
    return device_->read();
}

device::DeviceIdentity EmulatedDevice::identity() const {
    device::DeviceIdentity identity = device_->identity();
    identity.kind = "emulated";
    return identity;
}

void EmulatedDevice::set_period(double period_s) {
    device_->set_period(period_s);
    period_s_ = period_s;
}

} // namespace springdrive::factory
