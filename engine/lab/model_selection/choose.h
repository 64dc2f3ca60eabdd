// Which of several candidates on several axes is the cheapest that is good enough: the rule, apart
// from what is chosen and how it is measured.
#pragma once

#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/work_point.h"
#include "engine/scene/model_tolerance.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::model_selection {

/// One way to model one aspect of a scene.
struct Candidate {
    std::string name;
    rig::Cost cost;   ///< of what this axis decides, a servo tick
    ModelError error; ///< with all other axes at their fullest
};

/// A cheaper candidate that was tried instead of the chosen one, all other axes as chosen, and
/// missed.
struct CheaperTrial {
    std::size_t candidate = 0;
    ModelError error;
};

/// An aspect that can be modelled in several ways.
struct ModelAxis {
    std::string name;
    std::vector<Candidate> candidates; ///< the last is the fullest
    std::size_t chosen = 0;
    std::vector<CheaperTrial> cheaper; ///< the next cheaper one, and each that meets by itself
};

/// For each axis the index of a candidate.
using Picks = std::vector<std::size_t>;

/// The axes with their choices, and how far all of these together are off.
struct ChosenModel {
    std::vector<ModelAxis> axes;
    ModelError error;
};

/// Costs that differ by less count as the same: what repeated timings scatter by.
inline constexpr double kSameCost = 0.10;

/// Of the larger of both, in tolerances: 1 just meets. Not a number counts as infinite.
[[nodiscard]] double share_of_tolerance(const ModelError &error,
                                        const scene::ModelTolerance &tolerance);

[[nodiscard]] inline bool meets(const ModelError &error, const scene::ModelTolerance &tolerance) {
    return share_of_tolerance(error, tolerance) <= 1.0;
}

/// The rule:
///
/// 1. On each axis by itself, of the candidates that meet the tolerance the cheapest; among those
///    of the same cost the nearest to the fullest.
/// 2. These together, measured by `error_of`. While they miss, the axis that is farthest off by
///    itself takes its next dearer candidate that is nearer to the fullest.
/// 3. On each axis the next cheaper candidate, and every cheaper one that meets by itself, is put
/// in
///    place of the chosen, all others as they stand, and measured; where it meets it is taken, and
///    this step begun again. So in the end the whole meets, and with the next cheaper of any axis
///    it does not.
///
/// @param axes  each with at least one candidate, costs and errors measured
[[nodiscard]] ChosenModel choose_model(std::vector<ModelAxis> axes,
                                       const scene::ModelTolerance &tolerance,
                                       const std::function<ModelError(const Picks &)> &error_of);

} // namespace springdrive::model_selection
