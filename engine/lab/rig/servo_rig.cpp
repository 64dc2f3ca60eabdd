#include "engine/lab/rig/servo_rig.h"

#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace springdrive::rig {

using device::Arrival;
using device::Fault;
using device::FaultKind;

device::Measurement FaultyDevice::read() noexcept {
    faults_.update(periods_);
    device::Measurement state = next_truth();
    const std::uint8_t zeroing = state.zeroing;
    past_counts_[periods_ % past_counts_.size()] = state.counts;
    for (const Fault &fault : faults_.active()) {
        if (static_cast<double>(periods_) <= fault.begin_s) {
            first_counts_ = state.counts;
        }
        distort(state, fault);
    }
    answer_ = state;
    is_void_ = is_void_ || answer_.faults.has(device::BoardFaults::kEncoder);
    answer_.zeroing = is_void_ ? std::uint8_t{0} : zeroing;
    ++periods_;
    return answer_;
}

void FaultyDevice::write(const device::DeviceCommand &command) noexcept {
    last_command_ = command;
    is_void_ = is_void_ || command.voids_zero;
}

void FaultyDevice::zero(const Vector3 &theta_rad) {
    ForwardingDevice::zero(theta_rad);
    if (faults_.find(FaultKind::count_step)) {
        clear_fault();
    }
    is_void_ = false;
}

void FaultyDevice::commit(Fault fault) {
    fault.begin_s += static_cast<double>(periods_);
    fault.end_s += static_cast<double>(periods_);
    faults_.clear();
    faults_.add(fault);
    faults_.update(periods_);
}

void FaultyDevice::clear_fault() {
    faults_.clear();
    faults_.update(periods_);
}

void FaultyDevice::pass_by(int periods) noexcept {
    faults_.update(periods_);
    for (int i = 0; i < periods; ++i) {
        static_cast<void>(next_truth());
    }
}

Vector3 FaultyDevice::sag_Ohm() const {
    const Fault *sag = faults_.find(FaultKind::sagging_winding);
    return sag ? sag->size : Vector3::Zero();
}

/// The device's own, a period later.
device::Measurement FaultyDevice::next_truth() noexcept {
    device::DeviceCommand command = last_command_;
    if (const Fault *gain = faults_.find(FaultKind::amplifier_gain)) {
        command.e_W_V = command.e_W_V.cwiseProduct(gain->size);
    }
    command.cancelled_resistance_Ohm += sag_Ohm(); // R − δ − R̂ is R − (R̂ + δ)
    ForwardingDevice::write(command);
    device::Measurement truth = ForwardingDevice::read();
    truth.number += number_offset_;
    last_number_ = truth.number;
    return truth;
}

void FaultyDevice::distort(device::Measurement &state, const Fault &fault) const {
    const auto show_last_again = [&](Arrival arrival) {
        const std::uint64_t number = arrival == Arrival::repeated ? answer_.number : state.number;
        state = answer_;
        state.number = number;
        state.arrival = arrival;
        state.health =
            fault.kind == FaultKind::unplug ? device::DeviceHealth::lost : device::DeviceHealth::ok;
    };
    const auto rounded = [](double number) {
        return static_cast<std::int32_t>(std::lround(number));
    };
    const std::uint64_t since = periods_ - static_cast<std::uint64_t>(fault.begin_s);
    const auto grown = static_cast<double>(since + 1);
    switch (fault.kind) {
    case FaultKind::drop:
    case FaultKind::unplug:
        return show_last_again(Arrival::absent);
    case FaultKind::corrupt:
        return show_last_again(Arrival::corrupt);
    case FaultKind::repeat:
        return show_last_again(Arrival::repeated);
    case FaultKind::delay:
        state.arrival = Arrival::late;
        return;
    case FaultKind::board:
        state.faults.bits = static_cast<std::uint16_t>(fault.size[0]);
        return;
    case FaultKind::late_counts: {
        const auto late = static_cast<std::uint64_t>(fault.size[0]);
        state.counts = past_counts_[(periods_ - std::min(late, periods_)) % past_counts_.size()];
        return;
    }
    default: // of each motor, or of the command
        break;
    }
    for (std::size_t motor = 0; motor < 3; ++motor) {
        const double size = fault.size[static_cast<Eigen::Index>(motor)];
        std::int32_t &counts = state.counts[motor];
        double &current_A = state.current_A[static_cast<Eigen::Index>(motor)];
        switch (fault.kind) {
        case FaultKind::count_scale:
            counts = first_counts_[motor] + rounded(size * (counts - first_counts_[motor]));
            break;
        case FaultKind::count_stuck_bit:
            counts &= ~static_cast<std::int32_t>(size);
            break;
        case FaultKind::count_step:
            counts += rounded(size);
            break;
        case FaultKind::count_flicker:
            counts += since % 2 == 0 ? rounded(size) : 0;
            break;
        case FaultKind::count_drift:
            counts += rounded(size * grown);
            break;
        case FaultKind::current_reading:
            current_A = size != 0.0 ? size : current_A;
            break;
        case FaultKind::current_offset:
            current_A += size;
            break;
        case FaultKind::current_drift:
            current_A += size * grown;
            break;
        case FaultKind::current_gain:
            current_A *= 1.0 + size;
            break;
        default:
            break;
        }
    }
}

ServoRig::ServoRig(const device::DeviceDescription &device,
                   const simulated::SimulationOptions &simulation, const Vector3 &start_tip_m,
                   const contact::HapticSurface *surface)
    : description_(device), simulation_(simulation),
      phantom_(std::in_place, device, simulation, start_tip_m), device_(*phantom_),
      loop_(device_, simulation.servo_period_s) {
    inputs.surface = surface;
    inputs.has_inductance = simulation.dynamics == simulated::PlantDynamics::electromechanical;
}

ServoRig::ServoRig(const Scenario &scenario)
    : ServoRig(scenario.device, scenario.simulation, scenario.start_m, scenario.surface.get()) {
    surface_ = scenario.surface;
    inputs.tuning = scenario.tuning;
}

const servo::ServoSample &ServoRig::tick(const servo::TickTiming &timing) noexcept {
    measured_ = loop_.read();
    last = loop_.update(measured_, inputs, timing);
    loop_.write();
    return last;
}

const servo::ServoSample &ServoRig::late_tick(int missed) noexcept {
    device_.pass_by(missed);
    return tick();
}

void ServoRig::run(double seconds) noexcept {
    for (long i = std::lround(seconds / loop_.period_s()); i > 0; --i) {
        tick();
    }
}

void ServoRig::let_go() {
    const simulated::SimulatedPhantom::Truth before = phantom_->truth();
    simulation_.hand = {0.0, 0.0, 0.0, 0.0, 1.0};
    phantom_.emplace(description_, simulation_, before.tip_m);
    phantom_->set_in_motion(
        device::joint_from_motor(description_.geometry, before.theta_rate_rad_per_s),
        before.current_A);
    device_.continue_numbering();
}

} // namespace springdrive::rig
