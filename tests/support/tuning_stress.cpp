#include "tests/support/tuning_stress.h"

#include "engine/control/tuning.h"
#include "tests/support/devices.h"
#include "tests/support/surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <thread>

namespace springdrive::testing {

namespace {

constexpr double kChanges_hz = 10'000.0;
constexpr double kSceneShare = 0.0004; // of the changes: about four per second
constexpr std::uint32_t kSerials = 40;
constexpr std::uint64_t kMaxReported = 5;
/// The smallest value of a logarithmic parameter whose range begins at 0, as a share of its
/// maximum. Transitions follow the mean of the values, for K_P 500/ln(1e20) = 11 V/rad, which is
/// stable, so that the device is in contact with voltage on.
constexpr double kMin = 1e-20;
constexpr double kPress_s = 0.15; // down, and as long up: in a new scene around the tip the proxy
                                  // starts free
const Vector3 kFree_m(0.0, 0.02, 0.0);
const Vector3 kAbove_m(-0.005, 0.006, 0.0);
const Vector3 kPressing_m(0.005, -0.012, 0.0);

/// Encodes the serial number of a set in its limits and in α of AlphaMode::global.
double winding_C(std::uint32_t serial) { return 99.0 - 0.5 * serial; }
double beyond_stops_rad(std::uint32_t serial) { return 0.05 - 0.001 * serial; }
double global_alpha(std::uint32_t serial) { return 500.0 + 100.0 * serial; }
double surface_eta(std::uint32_t scene_id) { return 0.2 * (scene_id % 3U); }

simulated::SimulationOptions at_rate(double servo_hz) {
    simulated::SimulationOptions options;
    options.servo_period_s = 1.0 / servo_hz;
    return options;
}

contact::HapticSurface plate(std::uint32_t scene_id) {
    return contact::HapticSurface(box_soup(
        Vector3(-0.1, -0.04, -0.1), Vector3(0.1, 0.001 * scene_id, 0.1), surface_eta(scene_id)));
}

bool passes(const servo::ServoSample &sample) {
    return sample.safety.state == servo::SafetyState::starting ||
           sample.safety.state == servo::SafetyState::running;
}

} // namespace

std::string StressFigures::text() const {
    std::ostringstream out;
    out << published << " sets published, " << samples << " samples, " << felt
        << " of them in contact with voltage on, " << scenes << " scenes, greatest step "
        << max_step_V << " V, trips:";
    for (std::size_t cause = 1; cause < by_cause.size(); ++cause) {
        if (by_cause[cause] > 0) {
            out << ' ' << servo::kTripCauseNames[cause] << ' ' << by_cause[cause];
        }
    }
    return out.str();
}

TuningStress::TuningStress(double servo_hz)
    : device_(phantom_1_0(), at_rate(servo_hz), kFree_m), law_(device_.description()),
      supply_V_(Vector3::Constant(device_.description().motor[0].supply_V)),
      period_s_(1.0 / servo_hz), surfaces_{plate(0), plate(1), plate(2)},
      servo_(device_, servo_hz) {
    inputs_.surface = surfaces_.data();
}

/// All parameters are within their ranges; K_D and η are proportional to K_P and α, also during
/// transitions.
void TuningStress::publish() {
    const auto serial = std::uniform_int_distribution<std::uint32_t>(0, kSerials - 1)(random_);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    control::Tuning &tuning = inputs_.tuning;
    for (const control::Parameter &parameter : control::kParameters) {
        const double x = share(random_);
        const double minimum = std::max(parameter.minimum, kMin * parameter.maximum);
        tuning.*parameter.value =
            parameter.logarithmic ? std::clamp(minimum * std::pow(parameter.maximum / minimum, x),
                                               parameter.minimum, parameter.maximum)
                                  : parameter.minimum + x * (parameter.maximum - parameter.minimum);
    }
    tuning.K_D_Vs_per_rad = tuning.K_P_V_per_rad / 500.0;
    tuning.eta = tuning.alpha_rad2_per_m2 / 20'000.0;
    tuning.map = serial % 2 == 0 ? control::MotionMap::transpose : control::MotionMap::inverse;
    tuning.alpha_mode = static_cast<control::AlphaMode>(serial % 3);
    inputs_.limits.winding_C = winding_C(serial);
    inputs_.limits.beyond_stops_rad = beyond_stops_rad(serial);
    inputs_.global_alpha_rad2_per_m2 = global_alpha(serial);
    if (share(random_) < kSceneShare) {
        ++inputs_.scene_id;
        inputs_.surface = &surfaces_[inputs_.scene_id % 3U];
    }
    ++inputs_.heartbeat;
    servo_.publish(inputs_);
    ++figures_.published;
}

/// Up and down repeatedly; up after a trip, to rest as a start requires.
void TuningStress::lift_and_press(const servo::ServoSample &sample) {
    const auto ticks = static_cast<std::uint64_t>(kPress_s / period_s_);
    if (passes(sample)) {
        if (sample.tick % ticks == 0) {
            device_.set_hand_target(sample.tick / ticks % 2 == 0 ? kPressing_m : kAbove_m);
        }
    } else if (sample.safety.state == servo::SafetyState::tripped && sample.tick >= next_reset_) {
        ++figures_.trips;
        ++figures_.by_cause[static_cast<std::size_t>(sample.safety.cause)];
        device_.set_hand_target(kFree_m);
        ++inputs_.reset_count;
        next_reset_ = sample.tick + ticks;
    }
}

void TuningStress::expect(bool good, const servo::ServoSample &sample, const char *what) {
    if (!good && figures_.faults++ < kMaxReported) {
        ADD_FAILURE() << what << " in tick " << sample.tick;
    }
}

/// The active set is consistent, and within its ranges.
void TuningStress::check_set(const servo::ServoSample &sample) {
    const control::Tuning &tuning = sample.tuning;
    expect(control::is_valid(tuning), sample, "a parameter out of its range");
    const double serial_of_alpha = (sample.global_alpha_rad2_per_m2 - 500.0) / 100.0;
    const auto serial = static_cast<std::uint32_t>(std::lround(serial_of_alpha));
    expect(sample.global_alpha_rad2_per_m2 == global_alpha(serial) && serial < kSerials, sample,
           "an α of no set");
    expect(sample.limits.winding_C == winding_C(serial) &&
               sample.limits.beyond_stops_rad == beyond_stops_rad(serial),
           sample, "limits of another set");
    expect((tuning.map == control::MotionMap::transpose) == (serial % 2 == 0) &&
               static_cast<std::uint32_t>(tuning.alpha_mode) == serial % 3,
           sample, "a map of another set");
    // Related parameters move together, within the tolerance of the transition's end.
    expect(std::abs(tuning.K_D_Vs_per_rad - tuning.K_P_V_per_rad / 500.0) < 1e-5 &&
               std::abs(tuning.eta - tuning.alpha_rad2_per_m2 / 20'000.0) < 1e-5,
           sample, "K_D or η of another set");
    expect(!sample.contact.touching || sample.contact.eta == surface_eta(sample.scene_id), sample,
           "a surface of another scene");
}

/// The law's e_W for the state of one sample with the tuning of another, within the supply.
Vector3 TuningStress::requested_V(const servo::ServoSample &state, const servo::ServoSample &tuned,
                                  const control::Configuration &now) const {
    return law_(now, state.contact, tuned.tuning, {tuned.global_alpha_rad2_per_m2}, state.motor,
                state.lag_s)
        .command.e_W_V;
}

/// Checks the step of e_W due to this tick's changes alone: relative to e_W without them, or after
/// a change of scene to the last e_W, each within the supply, as no more reaches the windings.
/// R̂ i must change as little.
void TuningStress::check_step(const servo::ServoSample &sample) {
    const auto within_supply = [&](const Vector3 &e_W_V) -> Vector3 {
        return e_W_V.cwiseMax(-supply_V_).cwiseMin(supply_V_);
    };
    const auto configuration = [&](const servo::ServoSample &tuned) {
        control::VelocityFilter filter(before_.theta_rad, before_.theta_rate_rad_per_s);
        const double since_last_s = (1.0 + sample.missed_periods) * period_s_;
        const double pole =
            control::velocity_filter_pole(tuned.tuning.lambda_rad_per_s, since_last_s);
        return law_.configuration(sample.theta_rad,
                                  filter.update(sample.theta_rad, pole, since_last_s));
    };
    const control::Configuration now = configuration(sample);
    expect((now.theta_rate_rad_per_s - sample.theta_rate_rad_per_s).norm() < 1e-6, sample,
           "a velocity that is not the filter's");
    const Vector3 after_V =
        within_supply(requested_V(sample, sample, now) + sample.transfer_offset_V);
    Vector3 unchanged_V;
    if (sample.scene_id != before_.scene_id) {
        ++figures_.scenes;
        const control::Configuration then =
            law_.configuration(before_.theta_rad, before_.theta_rate_rad_per_s);
        unchanged_V =
            within_supply(requested_V(before_, before_, then) + before_.transfer_offset_V);
    } else {
        unchanged_V = within_supply(requested_V(sample, before_, configuration(before_)) +
                                    before_.transfer_offset_V);
    }
    const double step_V = (after_V - unchanged_V).cwiseAbs().maxCoeff();
    figures_.max_step_V = std::max(figures_.max_step_V, step_V);
    expect(step_V <= servo::kMaxChange_V_per_s * period_s_ + 1e-6, sample, "a step in e_W");
    const double peak_A = device_.description().motor[0].peak_current_A;
    expect(std::abs(sample.tuning.dR_Ohm - before_.tuning.dR_Ohm) * peak_A <=
               servo::kMaxChange_V_per_s * period_s_ + 1e-9,
           sample, "a step in R̂ i");
}

void TuningStress::check(const servo::ServoSample &sample) {
    expect(sample.tick == figures_.samples, sample, "a lost sample");
    ++figures_.samples;
    check_set(sample);
    if (has_previous_ && passes(before_)) {
        check_step(sample);
    }
    figures_.felt += passes(sample) && sample.contact.touching ? 1 : 0;
    lift_and_press(sample);
    before_ = sample;
    has_previous_ = true;
}

StressFigures TuningStress::run(double seconds) {
    using Clock = std::chrono::steady_clock;
    publish();
    servo_.start();
    const Clock::time_point begin = Clock::now();
    const auto since_s = [&] {
        return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    while (since_s() < seconds) {
        const auto due = static_cast<std::uint64_t>(kChanges_hz * since_s());
        while (figures_.published < due) {
            publish();
        }
        servo_.drain([&](const servo::ServoSample &sample) { check(sample); });
        std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    servo_.stop();
    servo_.drain([&](const servo::ServoSample &sample) { check(sample); });
    EXPECT_EQ(servo_.lost_samples(), 0U);
    return figures_;
}

} // namespace springdrive::testing
