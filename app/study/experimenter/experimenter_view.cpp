#include "app/study/experimenter/experimenter_view.h"

#include "app/view/pick.h"
#include "device/core/phantom/kinematics.h"

namespace springdrive::app::study_screen {

ViewState experimenter_view(const servo::ServoSample &now, const device::DeviceDescription &device,
                            const contact::HapticSurface &surface,
                            const std::optional<Vector3> &hidden_at) {
    const Vector3 measured_rad = device::joint_from_motor(device.geometry, now.theta_rad);
    ViewState state;
    state.tip_m = now.tip_m;
    state.proxy_m = now.contact.x0_m;
    state.tip_force_N = now.tip_force_N;
    state.linkage = device::linkage_pose(device.geometry, measured_rad);
    if (hidden_at) {
        state.tip_force_N = Vector3::Zero();
    }
    if (hidden_at && now.contact.touching) {
        state.tip_m = *hidden_at;
        state.proxy_m = *hidden_at;
        state.linkage = device::linkage_pose(
            device.geometry,
            device::joint_angles_rad(device.geometry, *hidden_at).value_or(measured_rad));
    }
    state.touching = now.contact.touching;
    state.normal = now.contact.normal;
    state.hand_target_m = state.tip_m;
    state.tripped = now.safety.state == servo::SafetyState::tripped;
    state.workspace = device.workspace;
    state.floor_height_m = device.workspace.centre_m.y() - 0.5 * device.workspace.size_m.y();
    state.below =
        place_below(surface, state.touching ? state.proxy_m : state.tip_m, state.floor_height_m);
    return state;
}

} // namespace springdrive::app::study_screen
