#include "engine/record/replay.h"

#include "engine/control/velocity_filter.h"
#include "engine/servo/command_limiter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace springdrive::record {

namespace {

bool same_bits(const Vector3 &a, const Vector3 &b) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) {
            return false;
        }
    }
    return true;
}

servo::LimiterInputs limiter_inputs(const servo::ServoSample &sample, const ReplayedTick &tick) {
    servo::LimiterInputs inputs{tick.now,        sample.limits, sample.safety.ramp,
                                Vector3::Zero(), sample.motor,  tick.found.trim_V};
    for (std::size_t j = 0; j < sample.winding.size(); ++j) {
        inputs.R_hat_limit_Ohm[static_cast<Eigen::Index>(j)] = sample.winding[j].R_hat_limit_Ohm;
    }
    return inputs;
}

} // namespace

Replay::Replay(const device::DeviceDescription &device,
               const std::optional<control::Tuning> &tuning)
    : device_(device), tuning_(tuning), law_(device) {
    constexpr std::array<const char *, 9> kNames{
        "theta_rad", "theta_rate_rad_per_s", "tip_m", "eta",      "alpha_rad2_per_m2",
        "x_Sd_m",    "theta_Sd_rad",         "e_W_V", "R_hat_Ohm"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
        quantities_[i].name = kNames[i];
    }
}

std::optional<ReplayedTick> Replay::take(const servo::ServoSample &sample) {
    const Vector3 theta_rad = law_.theta_rad(sample.counts);
    const bool follows = before_ && before_->tick + 1 == sample.tick;
    control::VelocityFilter filter; // a servo starts at rest
    filter.reset(theta_rad);
    if (follows && has_measured_) {
        filter = control::VelocityFilter(before_->theta_rad, theta_rate_rad_per_s_);
    }
    has_measured_ = has_measured_ || sample.tick != 0 || sample.since_last_s > 0.0;
    before_ = sample;
    theta_rate_rad_per_s_ = sample.theta_rate_rad_per_s;
    const double alpha_before = std::exchange(
        alpha_before_, servo::alpha_in_contact(sample.contact, sample.alpha_rad2_per_m2));
    const device::DeviceCommand held = std::exchange(command_, sample.command);
    const servo::ActiveLimits active_limits = std::exchange(active_limits_, sample.active_limits);
    if (servo::is_final(sample.safety.cause)) {
        return std::nullopt;
    }
    if (!follows && sample.tick != 0) {
        ++skipped_;
        return std::nullopt;
    }
    ++replayed_;
    const control::Tuning &tuning = tuning_ ? *tuning_ : sample.tuning;
    const bool is_new = sample.since_last_s > 0.0;
    Vector3 theta_rate_rad_per_s = filter.velocity_rad_per_s();
    if (is_new) {
        const double pole =
            control::velocity_filter_pole(tuning.lambda_rad_per_s, sample.since_last_s);
        theta_rate_rad_per_s = filter.update(theta_rad, pole, sample.since_last_s);
    }
    ReplayedTick tick;
    if (tuning_) { // another λ acts over many ticks
        theta_rate_rad_per_s_ = theta_rate_rad_per_s;
    }
    tick.now = law_.configuration(theta_rad, theta_rate_rad_per_s);
    tick.found = law_(tick.now, sample.contact, tuning,
                      {sample.global_alpha_rad2_per_m2, alpha_before}, sample.motor, sample.lag_s);
    if (tuning_) {
        alpha_before_ = servo::alpha_in_contact(sample.contact, tick.found.alpha_rad2_per_m2);
    }
    if (!servo::lets_pass(sample.safety.state)) {
        tick.command = device::DeviceCommand::braking();
    } else if (is_new) {
        device::DeviceCommand requested = tick.found.command;
        requested.e_W_V += sample.transfer_offset_V;
        const servo::LimitedCommand passed =
            servo::limited(device_, requested, limiter_inputs(sample, tick));
        tick.command = passed.command;
        tick.active_limits = passed.active_limits;
    } else { // no new measurement: the last command is held
        tick.command = held;
        tick.active_limits = active_limits;
    }
    command_ = tick.command;
    active_limits_ = tick.active_limits;
    compare(sample, tick);
    return tick;
}

void Replay::compare(const servo::ServoSample &sample, const ReplayedTick &replayed) {
    const auto number = [](double value) { return Vector3(value, 0.0, 0.0); };
    compare(0, sample.tick, sample.theta_rad, replayed.now.theta_rad);
    compare(1, sample.tick, sample.theta_rate_rad_per_s, replayed.now.theta_rate_rad_per_s);
    compare(2, sample.tick, sample.tip_m, replayed.now.tip_m);
    compare(3, sample.tick, number(sample.eta), number(replayed.found.eta));
    compare(4, sample.tick, number(sample.alpha_rad2_per_m2),
            number(replayed.found.alpha_rad2_per_m2));
    compare(5, sample.tick, sample.x_Sd_m, replayed.found.x_Sd_m);
    compare(6, sample.tick, sample.theta_Sd_rad, replayed.found.used.theta_Sd_rad);
    compare(7, sample.tick, sample.command.e_W_V, replayed.command.e_W_V);
    compare(8, sample.tick, sample.command.cancelled_resistance_Ohm,
            replayed.command.cancelled_resistance_Ohm);
}

void Replay::compare(std::size_t quantity, std::uint64_t tick, const Vector3 &recorded,
                     const Vector3 &replayed) {
    if (same_bits(recorded, replayed)) {
        return;
    }
    ReplayedQuantity &found = quantities_[quantity];
    if (found.differing++ == 0) {
        found.first_tick = tick;
    }
    const double difference = (recorded - replayed).cwiseAbs().maxCoeff();
    found.maximum = std::isnan(difference) ? difference : std::max(found.maximum, difference);
}

bool Replay::is_identical() const {
    return std::all_of(quantities_.begin(), quantities_.end(),
                       [](const ReplayedQuantity &quantity) { return quantity.differing == 0; });
}

} // namespace springdrive::record
