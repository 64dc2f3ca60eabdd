#include "engine/lab/rig/faulty_device.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace springdrive::rig {

namespace {

/// The arrival of a measurement without news.
std::optional<device::Arrival> arrival_by(FaultKind kind) {
    switch (kind) {
    case FaultKind::lost:
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

} // namespace

device::Measurement FaultyDevice::read() noexcept {
    const device::Measurement truth = next_truth();
    past_counts_[periods_ % past_counts_.size()] = truth.counts;
    first_counts_ = periods_ <= from_ ? truth.counts : first_counts_;
    answer_ = as_reported(truth);
    is_void_ = is_void_ || answer_.faults.has(device::BoardFaults::kEncoder);
    answer_.zeroing = is_void_ ? std::uint8_t{0} : truth.zeroing;
    ++periods_;
    return answer_;
}

void FaultyDevice::write(const device::DeviceCommand &command) noexcept {
    last_command_ = command;
    is_void_ = is_void_ || command.voids_zero;
}

void FaultyDevice::zero(const Vector3 &theta_rad) {
    ForwardingDevice::zero(theta_rad);
    if (fault_.kind == FaultKind::count_step) {
        clear_fault();
    }
    is_void_ = false;
}

void FaultyDevice::pass_by(int periods) noexcept {
    for (int i = 0; i < periods; ++i) {
        static_cast<void>(next_truth());
    }
}

Vector3 FaultyDevice::sag_Ohm() const {
    return fault_.kind == FaultKind::sagging_winding ? fault_.size : Vector3::Zero();
}

FaultKind FaultyDevice::present() const {
    return periods_ >= from_ && periods_ - from_ < fault_.periods ? fault_.kind : FaultKind::none;
}

/// The device's own, a period later.
device::Measurement FaultyDevice::next_truth() noexcept {
    ForwardingDevice::write(reaching_the_motors(last_command_));
    device::Measurement truth = ForwardingDevice::read();
    truth.number += number_offset_;
    last_number_ = truth.number;
    return truth;
}

device::DeviceCommand FaultyDevice::reaching_the_motors(device::DeviceCommand command) const {
    if (present() == FaultKind::amplifier_gain) {
        command.e_W_V = command.e_W_V.cwiseProduct(fault_.size);
    } else if (present() == FaultKind::sagging_winding) {
        command.cancelled_resistance_Ohm += fault_.size; // R − δ − R̂ is R − (R̂ + δ)
    }
    return command;
}

device::Measurement FaultyDevice::as_reported(device::Measurement state) const {
    const FaultKind kind = present();
    if (const std::optional<device::Arrival> arrival = arrival_by(kind)) {
        const std::uint64_t number = state.number;
        state = answer_;
        state.number = kind == FaultKind::repeated ? answer_.number : number;
        state.arrival = *arrival;
        state.health =
            kind == FaultKind::lost ? device::DeviceHealth::lost : device::DeviceHealth::ok;
    }
    if (kind == FaultKind::late) {
        state.arrival = device::Arrival::late;
    }
    if (kind == FaultKind::board) {
        state.faults.bits = static_cast<std::uint16_t>(fault_.size[0]);
    }
    if (kind == FaultKind::late_counts) {
        const auto late = static_cast<std::uint64_t>(fault_.size[0]);
        state.counts = past_counts_[(periods_ - std::min(late, periods_)) % past_counts_.size()];
    }
    for (std::size_t motor = 0; motor < 3; ++motor) {
        const auto j = static_cast<Eigen::Index>(motor);
        const double size = fault_.size[j];
        if (kind == FaultKind::count_scale) {
            const std::int32_t first = first_counts_[motor];
            state.counts[motor] = first + static_cast<std::int32_t>(
                                              std::lround(size * (state.counts[motor] - first)));
        } else if (kind == FaultKind::count_stuck_bit) {
            state.counts[motor] &= ~static_cast<std::int32_t>(size);
        }
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
        } else if (kind == FaultKind::current_offset) {
            state.current_A[j] += size;
        } else if (kind == FaultKind::current_drift) {
            state.current_A[j] += size * static_cast<double>(periods_ - from_ + 1);
        } else if (kind == FaultKind::current_gain) {
            state.current_A[j] *= 1.0 + size;
        }
    }
    return state;
}

/// The factor by which a fault of the counts has grown.
double FaultyDevice::steps(FaultKind kind) const {
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

} // namespace springdrive::rig
