// Computes what the scene shows of a touch, as far as it is switched on; and whether the tip lies
// in a solid, where it feels nothing: surfaces that bound a volume stop it from outside only.
#pragma once

#include "app/plots/plot_panel.h"
#include "app/view/view_state.h"
#include "device/core/device_description.h"
#include "engine/record/channel_store.h"
#include "engine/scene/scene.h"
#include "engine/servo/servo_sample.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// In a closed mesh or a solid shape of the scene. Open meshes and sheets have no inside.
[[nodiscard]] bool lies_inside(const scene::Scene &scene, const Vector3 &point_m);

/// The same, asked in every frame: computed anew only for another scene or place, and at most four
/// times a second, as it looks at all triangles.
class TipInside {
public:
    /// @param scene_id  its number
    /// @param time_s    by any clock of the window
    [[nodiscard]] bool at(const scene::Scene &scene, std::uint32_t scene_id, const Vector3 &tip_m,
                          double time_s);

private:
    std::uint32_t scene_id_ = 0;
    Vector3 tip_m_{Vector3::Zero()};
    std::optional<double> next_s_;
    bool is_inside_ = false;
};

/// Where the tip was in the last 5 s until `until_s`, and the rendered force [N], every 10 ms.
/// @param until_s  empty: until the last row
[[nodiscard]] std::vector<PlacedValue> recent_trace(const record::ChannelStore &store,
                                                    std::optional<double> until_s);

class ShownValues {
public:
    /// @param now  the sample that is shown, of that device
    /// @param subject  with the ticks before it
    [[nodiscard]] const TouchValues &at(const ShownThings &shown,
                                        const device::DeviceDescription &device,
                                        const servo::ServoSample &now, const PlotSubject &subject);

    /// Those of the last call.
    [[nodiscard]] const TouchValues &last() const { return last_; }

private:
    /// What the workspace's colours were computed for.
    struct FieldOf {
        Thing thing{};
        std::string device;
        Vector3 workspace_m{Vector3::Zero()}; ///< its size
        control::Tuning tuning;

        friend bool operator==(const FieldOf &, const FieldOf &) = default;
    };

    void renew_field(Thing thing, const device::DeviceDescription &device,
                     const control::Tuning &tuning);

    TouchValues last_;
    FieldOf field_of_;
    std::shared_ptr<const WorkspaceField> field_;
};

} // namespace springdrive::app
