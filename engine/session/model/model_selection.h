// The result for a scene: every candidate with its cost and error, and which are chosen.
#pragma once

#include "base/timing.h"
#include "engine/scene/model_tolerance.h"
#include "engine/session/model/model.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace springdrive::model_selection {

/// The difference between the rendered and the reference force.
struct ModelError {
    double force_N = 0.0;       ///< rms of the difference over the whole path
    double direction_rad = 0.0; ///< rms of the angle, while both touch with 0.2 N or more
};

/// One alternative for modelling one aspect of a scene.
struct Candidate {
    std::string name;
    Cost cost;        ///< per servo tick, of the part that this axis decides
    ModelError error; ///< with all other axes at their fullest
};

/// A cheaper candidate that was tried instead of the chosen one, all other axes as chosen, and
/// missed the tolerance.
struct CheaperTrial {
    std::size_t candidate = 0;
    ModelError error;
};

/// An aspect that can be modelled in several ways.
struct ModelAxis {
    std::string name;
    std::vector<Candidate> candidates; ///< the last is the fullest
    std::size_t chosen = 0;
    std::vector<CheaperTrial> cheaper; ///< the next cheaper one, and each that meets on its own
};

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
    std::vector<std::string> warnings;

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

/// The larger of the two errors relative to its tolerance: 1 just meets. NaN counts as infinite.
[[nodiscard]] double share_of_tolerance(const ModelError &error,
                                        const scene::ModelTolerance &tolerance);

[[nodiscard]] inline bool meets(const ModelError &error, const scene::ModelTolerance &tolerance) {
    return share_of_tolerance(error, tolerance) <= 1.0;
}

/// Why a candidate with that error is accepted or not: "meets", "force 0.21 N > 0.05 N", "runs
/// away".
[[nodiscard]] std::string verdict(const ModelError &error, const scene::ModelTolerance &tolerance);

} // namespace springdrive::model_selection
