// Computes what the scene shows of a touch, as far as it is switched on.
#pragma once

#include "app/plots/plot_panel.h"
#include "app/view/view_state.h"
#include "device/core/device_description.h"
#include "engine/record/channel_store.h"
#include "engine/servo/servo_sample.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

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
