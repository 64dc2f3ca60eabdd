// Selects on each of several axes the cheapest candidate that is accurate enough: the rule,
// independent of what is chosen and how it is measured.
#pragma once

#include "engine/lab/model_selection/model_run.h"
#include "engine/lab/rig/timing.h"
#include "engine/scene/model_tolerance.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace springdrive::model_selection {

/// One alternative for modelling one aspect of a scene.
struct Candidate {
    std::string name;
    rig::Cost cost;   ///< per servo tick, of the part that this axis decides
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

/// For each axis the index of a candidate.
using Picks = std::vector<std::size_t>;

/// The axes with their choices, and the error of all of these together.
struct ChosenModel {
    std::vector<ModelAxis> axes;
    ModelError error;
};

/// Costs that differ by less count as equal: the scatter of repeated timings.
inline constexpr double kSameCost = 0.10;

/// The larger of the two errors relative to its tolerance: 1 just meets. NaN counts as infinite.
[[nodiscard]] double share_of_tolerance(const ModelError &error,
                                        const scene::ModelTolerance &tolerance);

[[nodiscard]] inline bool meets(const ModelError &error, const scene::ModelTolerance &tolerance) {
    return share_of_tolerance(error, tolerance) <= 1.0;
}

/// The rule:
///
/// 1. On each axis alone: the cheapest of the candidates that meet the tolerance; among those of
///    the same cost the nearest to the fullest.
/// 2. These together, measured by `error_of`. While they miss, the axis with the largest error of
///    its own takes the cheapest candidate that is nearer to the fullest.
/// 3. On each axis the next cheaper candidate, and every cheaper one that meets on its own,
///    replaces the chosen one, all others unchanged, and is measured; if it meets it is taken, and
///    this step starts again. So in the end the whole meets, and with the next cheaper candidate of
///    any axis it does not.
///
/// @param axes  each with at least one candidate, costs and errors measured
[[nodiscard]] ChosenModel choose_model(std::vector<ModelAxis> axes,
                                       const scene::ModelTolerance &tolerance,
                                       const std::function<ModelError(const Picks &)> &error_of);

} // namespace springdrive::model_selection
