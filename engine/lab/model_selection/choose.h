// Selects on each of several axes the cheapest candidate that is accurate enough: the rule,
// independent of what is chosen and how it is measured, and its application to a scene.
#pragma once

#include "engine/session/model/model_selection.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace springdrive::model_selection {

/// For each axis the index of a candidate.
using Picks = std::vector<std::size_t>;

/// The axes with their choices, and the error of all of these together.
struct ChosenModel {
    std::vector<ModelAxis> axes;
    ModelError error;
};

/// Costs that differ by less count as equal: the scatter of repeated timings.
inline constexpr double kSameCost = 0.10;

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

/// The cheapest model of a scene that its tolerance allows, found by measuring on this machine.
/// Lets a hand explore the scene (`exploration_path`) with the fullest model and with each
/// candidate in turn, and chooses by the rule of `choose_model`. Takes seconds.
///
/// The fullest: the last of `kPlantModels` in sub-steps of 32 µs or less, the surface as the scene
/// specifies it, and the last of `kMotionControllers`.
[[nodiscard]] ModelSelection choose_scene_model(const ModelQuestion &question,
                                                const ModelProgress &progress = {});

} // namespace springdrive::model_selection
