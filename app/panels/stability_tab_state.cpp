#include "app/panels/stability_tab.h"
#include "device/phantom/kinematics.h"
#include "engine/analysis/stability/stability_limits.h"
#include "engine/control/parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <utility>

namespace springdrive {

namespace {

constexpr double kMoved_rad = 0.03; // below that, limits stay as they are

bool are_alike(const Tuning &a, const Tuning &b) {
    return a.map == b.map && a.alpha_mode == b.alpha_mode &&
           std::all_of(kParameters.begin(), kParameters.end(),
                       [&](const Parameter &p) { return a.*p.value == b.*p.value; });
}

/// The nearest limit on one side of where the parameter stands, if it stands well.
std::optional<double> limit_of(const StabilityCase &which, const char *name, bool upwards) {
    const StabilityParameter &parameter = *stability_parameter_named(name);
    const double now = parameter.get(which);
    std::optional<double> nearest;
    for (const StabilityLimit &limit :
         predicted_limits(which, parameter, {parameter.from, parameter.to})) {
        if (limit.stable_below == upwards &&
            (upwards ? limit.predicted >= now : limit.predicted <= now)) {
            nearest = nearest ? (upwards ? std::min(*nearest, limit.predicted)
                                         : std::max(*nearest, limit.predicted))
                              : limit.predicted;
        }
    }
    return nearest;
}

StabilityOutlook outlook_of(const StabilityCase &which) {
    return {worst_member(which), which.period_s, limit_of(which, "kp", true),
            limit_of(which, "kd", true), limit_of(which, "dR", false)};
}

/// "tuned-20240531-123456.toml".
std::string name_of_new_tuning() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    std::array<char, 64> text{};
    std::strftime(text.data(), text.size(), "tuned-%Y%m%d-%H%M%S.toml", &parts);
    return text.data();
}

} // namespace

StabilityCase stability_case_of(const Session &session) {
    StabilityCase which;
    which.device = session.device();
    which.tuning = session.tuning();
    which.period_s = 1.0 / session.servo_hz();
    which.delay_samples = session.delay_samples();
    which.q_rad = joint_from_motor(which.device.geometry, session.latest().theta_rad);
    return which;
}

void StabilityTabState::update(const Session &session) {
    if (std::optional<StabilityOutlook> outlook = watch_.take()) {
        outlook_ = std::move(outlook);
    }
    try {
        if (std::optional<AutoTuned> found = search_.take()) {
            before_ = session.tuning();
            new_tuning_ = found->tuning;
            found_ = std::move(found);
            message_.clear();
        }
    } catch (const std::exception &error) {
        message_ = error.what();
    }
    const StabilityCase now = stability_case_of(session);
    const bool moved = (now.q_rad - looked_at_q_rad_).cwiseAbs().maxCoeff() > kMoved_rad;
    if (!watch_.is_busy() && (!looked_at_ || moved || !are_alike(*looked_at_, now.tuning))) {
        looked_at_ = now.tuning;
        looked_at_q_rad_ = now.q_rad;
        watch_.start([now](BackgroundTalk &) { return outlook_of(now); });
    }
}

void StabilityTabState::start_tuning(const Session &session) {
    found_.reset();
    message_.clear();
    search_.start(
        [request = AutoTuneRequest{stability_case_of(session), margin}](BackgroundTalk &talk) {
            return auto_tune(request, [&talk](double share) {
                talk.share = share;
                return talk.is_wanted.load();
            });
        });
}

void StabilityTabState::save() {
    if (!found_) {
        return;
    }
    const std::string name = name_of_new_tuning();
    std::ofstream file(name, std::ios::binary);
    write_tuning_file(file, {found_->tuning, "found in the window", found_->margins});
    message_ = file.flush() ? "saved as " + name
                            : name + ": cannot be written; is the folder yours, the disk full?";
}

std::optional<Tuning> StabilityTabState::take_back() { return std::exchange(before_, {}); }

std::optional<Tuning> StabilityTabState::take_new_tuning() {
    return std::exchange(new_tuning_, {});
}

} // namespace springdrive
