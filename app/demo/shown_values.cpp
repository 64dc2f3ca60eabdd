#include "app/demo/shown_values.h"

#include "device/core/phantom/kinematics.h"
#include "engine/contact/mesh/triangle_soup.h"
#include "engine/control/haptic_law.h"
#include "engine/lab/loops/both_maps.h"
#include "engine/session/telemetry_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace springdrive::app {

namespace {

/// How often more a ray along a coordinate axis leaves the triangles than it enters them: 1 for a
/// point in a solid that is wound as glTF asks.
/// @param axis  along which, in the direction of `sign`
int exits(const contact::TriangleSoup &soup, const Vector3 &from_m, int axis, double sign) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    int count = 0;
    for (const auto &triangle : soup.triangles) {
        const std::array<const Vector3 *, 3> corner{&soup.vertices_m[triangle[0]],
                                                    &soup.vertices_m[triangle[1]],
                                                    &soup.vertices_m[triangle[2]]};
        // Twice the areas that the ray's foot makes with the edges, seen along the axis.
        std::array<double, 3> area{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &a = *corner[i];
            const Vector3 &b = *corner[(i + 1) % 3];
            area[i] =
                (a[u] - from_m[u]) * (b[v] - from_m[v]) - (a[v] - from_m[v]) * (b[u] - from_m[u]);
        }
        const bool is_hit = (area[0] > 0.0 && area[1] > 0.0 && area[2] > 0.0) ||
                            (area[0] < 0.0 && area[1] < 0.0 && area[2] < 0.0);
        if (!is_hit) {
            continue;
        }
        // Each area weighs the corner opposite to its edge.
        const double whole = area[0] + area[1] + area[2];
        const double where = (area[1] * (*corner[0])[axis] + area[2] * (*corner[1])[axis] +
                              area[0] * (*corner[2])[axis]) /
                             whole;
        if (sign * (where - from_m[axis]) > 0.0) {
            count += sign * whole > 0.0 ? 1 : -1;
        }
    }
    return count;
}

bool lies_in_mesh(const contact::TriangleSoup &soup, const Vector3 &point_m) {
    // No ray runs along edges, which lie at round numbers in many scenes: less than the clearance
    // of the proxy beside them.
    const Vector3 beside_m = point_m + Vector3(1.3e-7, 2.9e-7, 1.9e-7);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            if (exits(soup, beside_m, axis, sign) < 1) {
                return false; // an open mesh is open in some direction
            }
        }
    }
    return true;
}

constexpr double kTraceLength_s = 5.0;
constexpr double kTraceStep_s = 0.010;
constexpr double kFieldSpacing_m = 0.014;

std::size_t channel_number(const char *name) { return session::channel_named(name).value(); }

} // namespace

bool lies_inside(const scene::Scene &scene, const Vector3 &point_m) {
    const bool is_in_shape =
        std::ranges::any_of(scene.shapes, [&](const contact::AnalyticShape &shape) {
            return shape.is_solid() && shape.nearest(point_m).distance_m < 0.0;
        });
    const bool may_be_in_mesh = (point_m.array() > scene.lower_m.array()).all() &&
                                (point_m.array() < scene.upper_m.array()).all();
    return is_in_shape || (may_be_in_mesh && lies_in_mesh(scene.surface, point_m));
}

bool TipInside::at(const scene::Scene &scene, std::uint32_t scene_id, const Vector3 &tip_m,
                   double time_s) {
    constexpr double kPause_s = 0.25;
    constexpr double kMoved_m = 1e-4; // a few encoder counts
    const bool is_due = scene_id != scene_id_ || !next_s_ ||
                        (time_s >= *next_s_ && !((tip_m - tip_m_).norm() < kMoved_m));
    if (is_due) {
        is_inside_ = tip_m.allFinite() && lies_inside(scene, tip_m);
        scene_id_ = scene_id;
        tip_m_ = tip_m;
        next_s_ = time_s + kPause_s;
    }
    return is_inside_;
}

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
    FieldOf requested{thing, device.name, device.workspace.size_m, tuning};
    requested.tuning.map = {}; // the colours are of one map each
    if (field_ && requested == field_of_) {
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
    field_of_ = requested;
}

} // namespace springdrive::app
