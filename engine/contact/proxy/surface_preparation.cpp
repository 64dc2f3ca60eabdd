// What happens once to a surface, before it is queried.
#include "engine/contact/proxy/haptic_surface.h"

#include "base/cancellation.h"
#include "base/parallel.h"
#include "engine/contact/mesh/facet_boxes.h"
#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <stdexcept>
#include <utility>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::uint64_t next_serial() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

} // namespace

HapticSurface::HapticSurface(TriangleSoup soup, std::vector<AnalyticShape> shapes)
    : shapes_(std::move(shapes)), serial_(next_serial()) {
    if (shapes_.size() > kMaxShapes) {
        throw std::invalid_argument("HapticSurface: too many shapes");
    }
    if (!std::ranges::all_of(shapes_, [&](const AnalyticShape &shape) {
            return shape.material() < soup.materials.size();
        })) {
        throw std::invalid_argument("HapticSurface: a shape lacks its material");
    }
    PreparedMesh prepared = prepare_mesh(soup);
    report_ = std::move(prepared.report);
    materials_ = std::move(soup.materials);
    const FacetBoxes boxes = boxes_of(prepared.facets);
    tree_ = BoxTree(boxes.boxes_m, all_processors());
    facets_.reserve(prepared.facets.size());
    const bool has_cut = boxes.boxes_m.size() > prepared.facets.size();
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> index_of(has_cut ? prepared.facets.size() : 0, kNone);
    facet_of_item_.reserve(has_cut ? boxes.boxes_m.size() : 0);
    for (const std::uint32_t box : tree_.take_order()) {
        stop_if_given_up(facets_.size());
        const std::uint32_t source = boxes.facet_of_box[box];
        if (has_cut) {
            const bool is_new = index_of[source] == kNone;
            index_of[source] =
                is_new ? static_cast<std::uint32_t>(facets_.size()) : index_of[source];
            facet_of_item_.push_back(index_of[source]);
            if (!is_new) {
                continue;
            }
        }
        facets_.emplace_back(prepared.facets[source]);
        has_two_sided_ = has_two_sided_ || facets_.back().sides() == FacetSides::two;
    }
}

} // namespace springdrive::contact
