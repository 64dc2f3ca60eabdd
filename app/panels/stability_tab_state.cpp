#include "app/host/output.h"
#include "app/host/output_dir.h"
#include "app/panels/stability_tab.h"
#include "base/file_names.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/stability_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <utility>

namespace springdrive::app {

namespace {

constexpr double kMoved_rad = 0.03; // below that, limits stay as they are

/// The value up to which the parameter may change, or must return, given the direction of
/// instability: upwards or not.
StabilityHeadroom headroom_of(const loops::StabilityCase &which, bool is_stable, const char *name,
                              bool upwards) {
    const loops::StabilityParameter &parameter = *loops::stability_parameter_named(name);
    stop_if_given_up();
    StabilityHeadroom headroom;
    headroom.now = parameter.get(which);
    const bool looks_up = upwards == is_stable;
    for (const limits::StabilityLimit &limit :
         limits::predicted_limits(which, parameter, {parameter.from, parameter.to})) {
        const bool is_ahead =
            looks_up ? limit.predicted >= headroom.now : limit.predicted <= headroom.now;
        const bool is_nearer = !headroom.limit || (looks_up ? limit.predicted < *headroom.limit
                                                            : limit.predicted > *headroom.limit);
        if (limit.stable_below == upwards && is_ahead && is_nearer) {
            headroom.limit = limit.predicted;
            headroom.who = "motor " + std::to_string(limit.worst.motor + 1) + ", " +
                           loops::hand_text(limit.worst.hand.name);
        }
    }
    return headroom;
}

StabilityPrediction prediction_of(const loops::StabilityCase &which) {
    const loops::WorstMember worst = loops::worst_member(which);
    const bool is_stable = worst.is_stable();
    return {worst, which.period_s, headroom_of(which, is_stable, "kp", true),
            headroom_of(which, is_stable, "kd", true), headroom_of(which, is_stable, "dR", false)};
}

/// Device, rate and tuning can all be exchanged.
bool is_another(const loops::StabilityCase &before, const loops::StabilityCase &now) {
    return (now.q_rad - before.q_rad).cwiseAbs().maxCoeff() > kMoved_rad ||
           before.tuning != now.tuning || before.period_s != now.period_s ||
           before.delay_periods != now.delay_periods || before.device.name != now.device.name;
}

} // namespace

void StabilityTabState::update(const session::Session &session) {
    try {
        if (std::optional<StabilityPrediction> prediction = watch_.take()) {
            prediction_ = std::move(prediction);
        }
    } catch (const std::exception &error) {
        message_ = error.what();
    }
    const loops::StabilityCase now = stability_case_of(session, session.tuning().now());
    field_.update(now);
    if (!watch_.is_busy() && (!looked_at_ || is_another(*looked_at_, now))) {
        looked_at_ = now;
        watch_.start([now](BackgroundTalk &) { return prediction_of(now); });
    }
}

void StabilityTabState::finish_search(session::Session &session, TuningEditor &editor) {
    try {
        std::optional<limits::AutoTuned> found = search_.take();
        if (!found) {
            return;
        }
        found_tuning_ = found->tuning;
        found_tuning_.eta = session.tuning().now().eta; // stable with any η
        found_ = std::move(found);
        const loops::StabilityCase now = stability_case_of(session, session.tuning().now());
        if (session.tuning().slots().active() == searched_slot_ &&
            now.period_s == searched_.period_s && now.delay_periods == searched_.delay_periods &&
            now.device.name == searched_.device.name) {
            message_.clear();
            editor.replace(found_tuning_, "found in the window");
        } else {
            message_ = "found for another slot, device or servo than now: not activated";
        }
    } catch (const std::exception &error) {
        message_ = error.what();
    }
}

void StabilityTabState::start_tuning(const session::Session &session) {
    found_.reset();
    message_.clear();
    searched_ = stability_case_of(session, session.tuning().now());
    searched_slot_ = session.tuning().slots().active();
    search_.start([request = limits::AutoTuneRequest{searched_, margin}](BackgroundTalk &talk) {
        return limits::auto_tune(request, [&talk](double share) {
            talk.share = share;
            return talk.is_wanted();
        });
    });
}

void StabilityTabState::stop_tuning() {
    search_.give_up();
    message_ = "cancelled: the tuning is unchanged";
}

void StabilityTabState::save() {
    if (!found_) {
        return;
    }
    message_ = save_as(in_output_dir(dated_name("tuned") + ".toml"), [this](std::ostream &out) {
        control::write_tuning_file(out, {found_tuning_, "found in the window", found_->margins});
    });
}

} // namespace springdrive::app
