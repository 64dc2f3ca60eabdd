#include "tests/support/exchange_judge.h"

#include "device/core/device_file.h"
#include "engine/control/velocity_filter.h"
#include "engine/record/record_file.h"
#include "engine/record/replay.h"
#include "engine/servo/bumpless_transfer.h"
#include "engine/servo/safety_monitor.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace springdrive::testing {

namespace {

/// Of the voltages.
constexpr double kRoundOff_V = 1e-9;

bool is_limited(const servo::ServoSample &sample) {
    return sample.active_limits.holds_force() || sample.active_limits.voltage ||
           sample.active_limits.at_edge;
}

class Judge {
public:
    explicit Judge(const device::DeviceDescription &device)
        : law_(device), supply_V_(device.motor.front().supply_V) {}

    void take(const servo::ServoSample &sample) {
        ++found.rows;
        expect(sample.safety.state != servo::SafetyState::tripped, sample,
               "tripped, " + servo::description(sample.safety));
        if (before_) {
            check_order(*before_, sample);
        }
        if (before_ && servo::lets_pass(before_->safety.state)) {
            check_step(*before_, sample);
            found.scenes += sample.scene_id != before_->scene_id ? 1 : 0;
            found.rates += std::abs(sample.since_last_s - before_->since_last_s) > 1e-9 ? 1 : 0;
        }
        found.felt += servo::lets_pass(sample.safety.state) && sample.contact.touching ? 1 : 0;
        found.max_transfer_offset_V =
            std::max(found.max_transfer_offset_V, sample.transfer_offset_V.cwiseAbs().maxCoeff());
        before_ = sample;
    }

    JudgedRecord found;

private:
    void expect(bool good, const servo::ServoSample &sample, const std::string &what) {
        if (!good && found.first_fault.empty()) {
            found.first_fault = what + " in tick " + std::to_string(sample.tick);
        }
    }

    void check_order(const servo::ServoSample &before, const servo::ServoSample &now) {
        expect(now.tick == before.tick + 1, now, "a tick is missing");
        expect(now.measurement_number == before.measurement_number + 1, now,
               "a measurement is missing");
        expect(std::abs(now.time_s - before.time_s - now.since_last_s) < 1e-9, now,
               "a time of another tick");
        expect(std::abs(now.measured_s - before.measured_s - now.since_last_s) < 1e-9, now,
               "a time of another measurement");
        expect(now.scene_id >= before.scene_id, now, "a scene of before");
        expect(now.arrival == device::Arrival::fresh && now.since_last_s > 0.0, now,
               "nothing was measured");
    }

    [[nodiscard]] Vector3 within_supply(const Vector3 &e_W_V) const {
        return e_W_V.cwiseMax(-supply_V_).cwiseMin(supply_V_);
    }

    /// The law's e_W for the motion and contact of `now` with the tuning of `tuned`.
    [[nodiscard]] Vector3 requested_V(const servo::ServoSample &before,
                                      const servo::ServoSample &now,
                                      const servo::ServoSample &tuned) const {
        control::VelocityFilter filter(before.theta_rad, before.theta_rate_rad_per_s);
        const double pole =
            control::velocity_filter_pole(tuned.tuning.lambda_rad_per_s, now.since_last_s);
        const control::Configuration state =
            law_.configuration(now.theta_rad, filter.update(now.theta_rad, pole, now.since_last_s));
        return law_(state, now.contact, tuned.tuning, {tuned.global_alpha_rad2_per_m2}, now.motor,
                    now.lag_s)
            .command.e_W_V;
    }

    /// The last e_W if the scene is new, as the old scene's contact is then unknown.
    [[nodiscard]] Vector3 unchanged_V(const servo::ServoSample &before,
                                      const servo::ServoSample &now) const {
        if (now.scene_id == before.scene_id) {
            return within_supply(requested_V(before, now, before) + before.transfer_offset_V);
        }
        const control::Configuration then =
            law_.configuration(before.theta_rad, before.theta_rate_rad_per_s);
        const control::LawOutcome last =
            law_(then, before.contact, before.tuning, {before.global_alpha_rad2_per_m2},
                 before.motor, before.lag_s);
        return within_supply(last.command.e_W_V + before.transfer_offset_V);
    }

    void check_step(const servo::ServoSample &before, const servo::ServoSample &now) {
        if (is_limited(before) || is_limited(now)) {
            return; // the limiter's reduction is not part of a change
        }
        const Vector3 unchanged = unchanged_V(before, now);
        const double step_V =
            (now.command.e_W_V - before.safety.ramp * unchanged).cwiseAbs().maxCoeff();
        const double ramp_V = (std::abs(now.safety.ramp - before.safety.ramp) + kRoundOff_V) *
                              (unchanged.cwiseAbs().maxCoeff() + now.transfer_offset_V.norm());
        expect(std::abs(now.safety.ramp - before.safety.ramp) <=
                   now.since_last_s / servo::kRampTime_s + 1e-12,
               now, "a step of the ramp");
        const double allowed_V =
            servo::kMaxChange_V_per_s * now.since_last_s + ramp_V + kRoundOff_V;
        found.max_step_V = std::max(found.max_step_V, step_V);
        found.max_share = std::max(found.max_share, step_V / allowed_V);
        expect(step_V <= allowed_V, now,
               "a step in e_W of " + std::to_string(step_V) + " V, allowed " +
                   std::to_string(allowed_V) + " V,");
    }

    control::HapticLaw law_;
    double supply_V_;
    std::optional<servo::ServoSample> before_;
};

} // namespace

JudgedRecord judge_record(const std::filesystem::path &file) {
    record::RecordReader reader(file);
    const device::DeviceDescription device =
        device::read_device_text(reader.header().device_toml, reader.header().device_file);
    Judge judge(device);
    record::Replay replay(device);
    reader.for_each([&](const servo::ServoSample &sample) {
        judge.take(sample);
        replay.take(sample);
    });
    JudgedRecord found = judge.found;
    found.replays = replay.is_identical() && replay.skipped() == 0 &&
                    replay.replayed() == found.rows && reader.ending().why.empty();
    return found;
}

} // namespace springdrive::testing
