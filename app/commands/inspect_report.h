// The report of `springdrive inspect` on a scene, as JSON or text.
#pragma once

#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace springdrive::app {

/// What can be touched of one node.
struct NodeFacets {
    std::size_t triangles = 0; ///< as the file gives them
    std::size_t one_sided = 0; ///< prepared
    std::size_t two_sided = 0;
};

struct InspectReport {
    std::string name;
    std::uintmax_t file_bytes = 0; ///< 0: generated, not read
    const scene::Scene *scene = nullptr;
    const contact::HapticSurface *surface = nullptr;
    double load_s = 0.0;
    double preparation_s = 0.0;
    const model_selection::ModelSelection *model =
        nullptr; ///< that the scene would get; null: not requested
};

/// In the order of the scene's materials.
[[nodiscard]] std::vector<NodeFacets> facets_of_nodes(const scene::Scene &scene,
                                                      const contact::HapticSurface &surface);

/// @pre scene and surface are set
void write_inspect_json(std::ostream &out, const InspectReport &report);
void write_inspect_table(std::ostream &out, const InspectReport &report);

} // namespace springdrive::app
