#include "device/usb/emulator/emulated_plant.h"

#include "base/input_error.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace springdrive::emulator {

namespace {

using board::Stage;
using device::FaultKind;

simulated::SimulationOptions plant_options(const device::DeviceDescription &description,
                                           const board::BoardSettings &settings,
                                           const simulated::SimulationOptions &simulation) {
    const bool has_board = simulation.dynamics == simulated::PlantDynamics::electromechanical &&
                           simulation.amplifier == device::AmplifierKind::spring_drive &&
                           simulation.quantised_encoders;
    if (!has_board) {
        throw InputError("emulated board: a board drives windings with inductance by voltage, and "
                         "counts its encoders' lines; choose electromechanical dynamics, the "
                         "spring drive and quantised encoders");
    }
    for (const std::uint32_t counts : settings.counts_per_turn) {
        if (counts != static_cast<std::uint32_t>(description.encoder_counts_per_turn)) {
            throw InputError(fmt::format(
                "emulated board: its settings have {} counts a turn, the device file {}; set them "
                "alike",
                counts, description.encoder_counts_per_turn));
        }
    }
    simulated::SimulationOptions options = simulation;
    options.servo_period_s = 1.0 / settings.loop_rate_hz;
    options.delay_periods = static_cast<double>(settings.actuation_lag_periods) - 0.5;
    return options;
}

} // namespace

EmulatedPlant::EmulatedPlant(const device::DeviceDescription &description,
                             const board::BoardSettings &settings,
                             const simulated::SimulationOptions &simulation,
                             const Vector3 &start_tip_m, std::uint32_t start_us)
    : settings_(settings),
      phantom_(description, plant_options(description, settings, simulation), start_tip_m),
      start_us_(start_us), faults_(settings.loop_rate_hz) {}

double EmulatedPlant::supply_V() const {
    const device::Fault *brown_out = faults_.find(FaultKind::brown_out);
    return brown_out ? brown_out->size[0] : static_cast<double>(settings_.nominal_supply_V);
}

std::uint32_t EmulatedPlant::now_us() const {
    constexpr std::uint64_t kPerSecond = 1'000'000;
    return start_us_ + static_cast<std::uint32_t>((loops_ - power_up_loop_) * kPerSecond /
                                                  settings_.loop_rate_hz);
}

board::Samples EmulatedPlant::sample() {
    const device::Measurement measured = phantom_.advance(applied_);
    ++loops_;
    board::Samples samples;
    samples.time_us = now_us();
    sample_encoders(measured, samples);
    sample_currents(measured, samples);
    samples.supply_V = static_cast<float>(supply_V());
    const device::Fault *hot_stage = faults_.find(FaultKind::hot_stage);
    samples.temperature_C[usb::kPowerStages] =
        hot_stage ? static_cast<float>(hot_stage->size[0]) : kStage_C;
    for (std::size_t i = 0; i < 3; ++i) {
        samples.temperature_C[usb::kFirstMotor + i] =
            static_cast<float>(phantom_.truth().housing_C[static_cast<Eigen::Index>(i)]);
    }
    samples.is_stopped = faults_.find(FaultKind::stop) != nullptr;
    samples.is_enabled = faults_.find(FaultKind::disable) == nullptr;
    samples.stage_failed = faults_.find(FaultKind::failed_stage) != nullptr;
    return samples;
}

void EmulatedPlant::sample_encoders(const device::Measurement &measured, board::Samples &samples) {
    if (!has_counters_) {
        counts_at_power_up_ = measured.counts;
        counter_ = {};
        turned_ = {};
        lost_ = {};
        has_counters_ = true;
    }
    const std::array<std::size_t, 3> motor = faults_.crossed(FaultKind::crossed_encoders);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::int32_t turned = measured.counts[motor[i]] - counts_at_power_up_[motor[i]];
        const device::Fault *lost_counts = faults_.find(FaultKind::lost_counts, i);
        lost_[i] += (lost_counts ? lost_counts->share : 0.0) * (turned - turned_[i]);
        turned_[i] = turned;
        const auto counted = turned - static_cast<std::int32_t>(std::lround(lost_[i]));
        if (!faults_.find(FaultKind::stuck_encoder, i)) {
            counter_[i] = static_cast<std::uint16_t>(
                faults_.find(FaultKind::reversed_encoder, i) ? -counted : counted);
        }
    }
    samples.encoder = counter_;
}

void EmulatedPlant::sample_currents(const device::Measurement &measured,
                                    board::Samples &samples) const {
    const std::array<std::size_t, 3> bridge = faults_.crossed(FaultKind::crossed_sensors);
    const std::array<std::size_t, 3> motor = faults_.crossed(FaultKind::crossed_motors);
    for (std::size_t i = 0; i < 3; ++i) {
        const device::Fault *gain = faults_.find(FaultKind::sensor_gain, i);
        const double measured_A = (gain ? gain->size[0] : 1.0) *
                                  measured.current_A[static_cast<Eigen::Index>(motor[bridge[i]])];
        samples.current_A[i] =
            faults_.find(FaultKind::failed_sensor, i)
                ? usb::kNotMeasured
                : static_cast<float>(faults_.find(FaultKind::reversed_sensor, i) ? -measured_A
                                                                                 : measured_A);
    }
}

/// Of a driven, braked or open stage.
double EmulatedPlant::voltage_V(const board::BridgeOrder &order, std::size_t channel,
                                Eigen::Index motor) const {
    if (order.stage[channel] == Stage::open || faults_.find(FaultKind::open_winding, channel)) {
        const simulated::SimulatedPhantom::Truth &truth = phantom_.truth();
        return truth.torque_constant_Nm_per_A[motor] * truth.theta_rate_rad_per_s[motor];
    }
    return order.stage[channel] == Stage::drive
               ? supply_V() * static_cast<double>(order.duty_ratio[channel])
               : 0.0;
}

void EmulatedPlant::apply(const board::BridgeOrder &order) {
    applied_ = device::DeviceCommand();
    const bool opens_all =
        std::ranges::all_of(order.stage, [](Stage stage) { return stage == Stage::open; });
    if (opens_all) {
        applied_.mode = device::CommandMode::open;
        return;
    }
    const std::array<std::size_t, 3> motor = faults_.crossed(FaultKind::crossed_motors);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto j = static_cast<Eigen::Index>(motor[i]);
        applied_.e_W_V[j] = voltage_V(order, i, j);
    }
}

void EmulatedPlant::restart() {
    power_up_loop_ = loops_;
    has_counters_ = false;
}

bool EmulatedPlant::load_block(std::uint16_t index, usb::CalibrationBlock &block) const {
    if (index >= stored_.size() || !stored_[index]) {
        return false;
    }
    block = *stored_[index];
    return true;
}

bool EmulatedPlant::store_block(const usb::CalibrationBlock &block) {
    if (block.index >= stored_.size() || faults_.find(FaultKind::failed_store)) {
        return false;
    }
    stored_[block.index] = block;
    return true;
}

} // namespace springdrive::emulator
