// Who chooses the model of a scene: handed in by the caller of a session, so that a session needs
// no laboratory.
#pragma once

#include "device/core/device_description.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace springdrive::model_selection {

/// The input of a choice.
struct ModelQuestion {
    const scene::Scene *scene = nullptr;
    device::DeviceDescription device;
    control::Tuning tuning;
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// Receives what is being measured and the overall progress, from 0 to 1.
using ModelProgress = std::function<void(const std::string &what, double share)>;

/// The key of a stored choice, in addition to its question.
struct ModelMemory {
    std::string device_text; ///< text of the device file
    std::string program_version;
};

/// For any thread.
class ModelChooser {
public:
    virtual ~ModelChooser() = default;

    /// The stored choice for exactly this question on this machine and program version, if any.
    [[nodiscard]] virtual std::optional<ModelSelection> stored(const ModelQuestion &question,
                                                               const ModelMemory &memory) const = 0;

    /// Measures now, even if a choice is stored, and stores the result.
    [[nodiscard]] virtual ModelSelection measured(const ModelQuestion &question,
                                                  const ModelMemory &memory,
                                                  const ModelProgress &progress) const = 0;

    /// The stored choice, or else a measured one.
    [[nodiscard]] ModelSelection known(const ModelQuestion &question, const ModelMemory &memory,
                                       const ModelProgress &progress) const {
        std::optional<ModelSelection> choice = stored(question, memory);
        return choice ? *std::move(choice) : measured(question, memory, progress);
    }

    /// The scene's surface in that form, prepared for touch.
    /// @throw InputError for a shape that the scene cannot be touched as
    [[nodiscard]] virtual contact::HapticSurface surface_of(const scene::Scene &scene,
                                                            const ContactShape &shape) const = 0;
};

} // namespace springdrive::model_selection
