#include "engine/session/telemetry_history.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/rendered_force.h"
#include "engine/record/telemetry_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

namespace springdrive::session {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// In the order in which `derive` appends them.
const std::vector<Channel> &derived_channels() {
    static const std::vector<Channel> derived{
        {"force_N", "N", "magnitude of the rendered force, as measured by the currents"},
        {"force_outward_N", "N", "its part in the links' plane, level and away from the base"},
        {"force_up_N", "N", "its part upwards"},
        {"tip_speed_m_per_s", "m/s", "of the tip, from the filtered rates of the motors"},
        {"penetration_m", "m", "distance from the tip to the proxy while touching"},
        {"normal_direction_rad", "rad",
         "direction of the surface's normal in the links' plane: 0 outwards, 90° up"},
        {"transpose_measured_rad", "rad",
         "angle from the normal to the measured force below 30 Hz, while the transpose map is "
         "used"},
        {"inverse_measured_rad", "rad",
         "angle from the normal to the measured force below 30 Hz, while the inverse map is used"}};
    return derived;
}

std::vector<Channel> all_channels() {
    std::vector<Channel> all;
    const servo::ServoSample any;
    record::for_each_column(any,
                            [&all](std::string_view name, std::string_view unit, const auto &) {
                                all.push_back({std::string(name), std::string(unit), {}});
                            });
    all.insert(all.end(), derived_channels().begin(), derived_channels().end());
    return all;
}

} // namespace

const std::vector<Channel> &channels() {
    static const std::vector<Channel> all = all_channels();
    return all;
}

std::optional<std::size_t> channel_named(std::string_view name) {
    const auto found = std::ranges::find(channels(), name, &Channel::name);
    if (found == channels().end()) {
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - channels().begin());
}

TelemetryHistory::TelemetryHistory(const device::PhantomGeometry &geometry, double servo_hz,
                                   std::size_t max_bytes)
    : geometry_(geometry), servo_hz_(servo_hz), store_(channels().size(), max_bytes) {
    row_.reserve(channels().size());
}

void TelemetryHistory::set_device(const device::PhantomGeometry &geometry) {
    geometry_ = geometry;
    felt_force_N_.setZero();
    if (!store_.is_empty()) {
        start_s_ = store_.time_s(store_.end() - 1) + 1.0 / servo_hz_;
    }
}

void TelemetryHistory::follow_rate(const servo::ServoSample &next) {
    constexpr double kRoundOff = 1e-6; // of a difference of times, after days
    if (!last_tick_ || next.tick <= *last_tick_) {
        return;
    }
    const double servo_hz = static_cast<double>(next.tick - *last_tick_) / (next.time_s - last_s_);
    if (std::isfinite(servo_hz) && std::abs(servo_hz - servo_hz_) > kRoundOff * servo_hz) {
        servo_hz_ = std::round(servo_hz * 1e3) / 1e3;
    }
}

std::span<const double> TelemetryHistory::row_of(const servo::ServoSample &sample) {
    last_tick_ = sample.tick;
    last_s_ = sample.time_s;
    row_.clear();
    record::for_each_column(sample, [this](std::string_view, std::string_view, const auto &value) {
        row_.push_back(static_cast<double>(value));
    });
    derive(sample);
    return row_;
}

void TelemetryHistory::derive(const servo::ServoSample &sample) {
    const contact::Contact &contact = sample.contact;
    const Vector3 &force_N = sample.tip_force_N;
    const Vector3 q_rad = device::joint_from_motor(geometry_, sample.theta_rad);
    const Vector3 outward(std::sin(q_rad.x()), 0.0, std::cos(q_rad.x()));
    if (contact.touching) {
        const double pole = std::exp(-2.0 * std::numbers::pi * control::kPerceived_Hz / servo_hz_);
        felt_force_N_ = pole * felt_force_N_ + (1.0 - pole) * force_N;
    } else {
        felt_force_N_.setZero();
    }
    const double felt_rad = std::isnan(sample.rendered_error_rad)
                                ? kNone
                                : control::direction_error_rad(felt_force_N_, contact.normal);
    const bool transposes = sample.tuning.map == control::MotionMap::transpose;
    row_.insert(
        row_.end(),
        {force_N.norm(), force_N.dot(outward), force_N.y(),
         (device::motor_jacobian(geometry_, q_rad) * sample.theta_rate_rad_per_s).norm(),
         contact.touching ? (contact.x0_m - sample.tip_m).norm() : kNone,
         contact.touching ? std::atan2(contact.normal.y(), contact.normal.dot(outward)) : kNone,
         transposes ? felt_rad : kNone, transposes ? kNone : felt_rad});
}

servo::ServoSample sample_at(const record::ChannelStore &store, std::uint64_t row) {
    servo::ServoSample sample;
    std::size_t channel = 0;
    record::for_each_column(sample, [&](std::string_view, std::string_view, auto &value) {
        using Value = std::remove_reference_t<decltype(value)>;
        value = static_cast<Value>(store.value(channel++, row));
    });
    return sample;
}

} // namespace springdrive::session
