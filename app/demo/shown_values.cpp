#include "app/demo/shown_values.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/haptic_law.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace springdrive::app {

namespace {

constexpr double kTraceLength_s = 5.0;
constexpr double kTraceStep_s = 0.010;
constexpr double kFieldSpacing_m = 0.014;

std::size_t channel_number(const char *name) { return session::channel_named(name).value(); }

} // namespace

std::vector<PlacedValue> recent_trace(const record::ChannelStore &store,
                                      std::optional<double> until_s) {
    if (store.end() < store.begin() + 2) {
        return {};
    }
    static const std::array<std::size_t, 4> kChannels{
        channel_number("tip_x_m"), channel_number("tip_y_m"), channel_number("tip_z_m"),
        channel_number("force_N")};
    const std::uint64_t last =
        until_s ? std::min(store.end() - 1, store.row_at(*until_s)) : store.end() - 1;
    const double last_s = store.time_s(last);
    const std::uint64_t first = std::min(last, store.row_at(last_s - kTraceLength_s));
    // Rows whose numbers are multiples of the step: the same ones in every frame.
    const double period_s = (last_s - store.time_s(first)) / static_cast<double>(last - first + 1);
    const auto step =
        static_cast<std::uint64_t>(std::max(1.0, kTraceStep_s / std::max(period_s, 1e-6) + 0.5));
    std::vector<PlacedValue> trace;
    const auto add = [&](std::uint64_t row) {
        const auto value = [&](std::size_t i) { return store.value(kChannels[i], row); };
        const Vector3 at_m(value(0), value(1), value(2));
        if (at_m.allFinite()) {
            trace.push_back({at_m, value(3)});
        }
    };
    for (std::uint64_t row = (first + step - 1) / step * step; row < last; row += step) {
        add(row);
    }
    add(last);
    return trace;
}

const TouchValues &ShownValues::at(const ShownThings &shown,
                                   const device::DeviceDescription &device,
                                   const servo::ServoSample &now, const PlotSubject &subject) {
    TouchValues values;
    const bool touches = now.contact.touching && now.x_Sd_m.allFinite();
    const control::Configuration configuration =
        control::HapticLaw(device).configuration(now.theta_rad, now.theta_rate_rad_per_s);
    if (touches && shown.shows(Thing::set_point)) {
        values.set_point_m = now.x_Sd_m;
    }
    if (touches && shown.shows(Thing::both_forces)) {
        const loops::MapForces forces = loops::map_forces(device, configuration, now.contact,
                                                          now.tuning, now.global_alpha_rad2_per_m2);
        values.inverse_force_N = forces.inverse_N;
        values.transpose_force_N = forces.transpose_N;
    }
    if (shown.shows(Thing::stiffness)) {
        const Vector3 q_rad = device::joint_from_motor(device.geometry, now.theta_rad);
        if (const auto K = loops::map_stiffness(device, now.tuning, q_rad, now.alpha_rad2_per_m2)) {
            values.inverse_stiffness_N_per_m = K->inverse_N_per_m;
            values.transpose_stiffness_N_per_m = K->transpose_N_per_m;
        }
    }
    if (shown.shows(Thing::trace)) {
        values.trace_N = recent_trace(subject.store, subject.position_s);
    }
    for (const Thing thing : {Thing::direction_errors, Thing::stiffnesses}) {
        if (shown.shows(thing)) {
            renew_field(thing, device, now.tuning);
            values.workspace = field_;
        }
    }
    last_ = std::move(values);
    return last_;
}

void ShownValues::renew_field(Thing thing, const device::DeviceDescription &device,
                              const control::Tuning &tuning) {
    FieldOf wanted{thing, device.name, device.workspace.size_m, tuning};
    wanted.tuning.map = {}; // the colours are of one map each
    if (field_ && wanted == field_of_) {
        return;
    }
    WorkspaceField field;
    for (const loops::WorkspaceValue &found :
         thing == Thing::direction_errors
             ? loops::errors_in_workspace_rad(device, tuning, kFieldSpacing_m)
             : loops::stiffnesses_in_workspace_N_per_m(device, tuning, kFieldSpacing_m)) {
        field.places.push_back({found.tip_m, found.value});
        field.largest = std::max(field.largest, found.value);
    }
    field_ = std::make_shared<const WorkspaceField>(std::move(field));
    field_of_ = wanted;
}

} // namespace springdrive::app
