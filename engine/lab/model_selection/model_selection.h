// The result for a scene: every candidate with its cost and error, and which are chosen.
#pragma once

#include "engine/lab/model_selection/choose.h"
#include "engine/lab/model_selection/model.h"
#include "engine/scene/model_tolerance.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::model_selection {

/// The axes, in this order.
enum class ModelAspect : std::uint8_t { plant, steps, joints, surface, controller };
inline constexpr std::size_t kModelAspects = 5;

/// The result. Names as in `kPlantModels`, `name_of(ContactShape)` and `kMotionControllers`; steps
/// and joints are numbers.
struct ModelSelection {
    scene::ModelTolerance tolerance;
    std::vector<ModelAxis> axes; ///< one for each `ModelAspect`
    ModelError error;            ///< of the chosen model as a whole
    double cost_ns = 0.0;        ///< of that model per servo tick: plant, proxy and map
    double fullest_cost_ns = 0.0;
    std::vector<std::string> remarks;

    [[nodiscard]] const ModelAxis &axis(ModelAspect aspect) const {
        return axes[static_cast<std::size_t>(aspect)];
    }
    [[nodiscard]] const std::string &chosen(ModelAspect aspect) const {
        return axis(aspect).candidates[axis(aspect).chosen].name;
    }
};

/// The model that a choice names.
/// @throw InputError for names and numbers that this program does not know, as from an old file.
[[nodiscard]] Model model_of(const ModelSelection &choice);

/// Why a candidate with that error is accepted or not: "meets", "force 0.21 N > 0.05 N", "runs
/// away".
[[nodiscard]] std::string verdict(const ModelError &error, const scene::ModelTolerance &tolerance);

} // namespace springdrive::model_selection
