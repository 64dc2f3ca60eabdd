#include "engine/contact/mesh/fan_grading.h"

#include "base/cancellation.h"
#include "engine/contact/mesh/fan_rings.h"
#include "engine/contact/mesh/triangle_fans.h"

#include <algorithm>
#include <array>
#include <utility>

namespace springdrive::contact {

namespace {

/// Whether it comes from a ring that reaches far in.
[[nodiscard]] bool is_long(const RingTriangle &triangle) {
    const auto [inner, outer] = std::ranges::minmax(triangle, {}, &RingPoint::fraction);
    return inner.fraction < 0.5 * outer.fraction && inner.fraction > 0.0;
}

[[nodiscard]] FacetSource facet_of(const RingTriangle &triangle, const TriangleFan &fan,
                                   const std::vector<FacetSource> &given) {
    std::array<Vector3, 3> corners_m;
    std::size_t first = fan.facets.size();
    std::size_t last = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto &[spoke, fraction] = triangle[i];
        // A rim's vertex exactly, so that what is beside it fits.
        corners_m[i] = fraction == 1.0 ? Vector3(fan.rim_m[spoke])
                                       : fan.apex_m + fraction * fan.spoke_m(spoke);
        first = std::min(first, spoke);
        last = std::max(last, spoke);
    }
    FacetSource facet = given[fan.facets[(first + last) / 2]];
    facet.corners_m = corners_m;
    facet.is_crowded = is_long(triangle);
    return facet;
}

} // namespace

GradedFans grade_fans(std::vector<FacetSource> &facets, const std::vector<MeshTriangle> &triangles,
                      const std::vector<std::uint32_t> &left_out, std::size_t vertices) {
    std::vector<std::vector<FanTriangle>> by_vertex =
        find_fan_triangles(triangles, left_out, vertices, kMinGradedFan);
    std::vector<FacetSource> graded;
    std::vector<bool> is_replaced(by_vertex.empty() ? 0 : facets.size());
    GradedFans count;
    const auto grade = [&](const TriangleFan &whole) {
        bool is_graded = false;
        bool is_coarse = false;
        for (const TriangleFan &fan : divided_by_length(whole)) {
            stop_if_given_up();
            const FanRings rings = rings_of(fan);
            if (rings.triangles.empty()) {
                continue;
            }
            is_graded = true;
            is_coarse = is_coarse || rings.is_coarse;
            for (const std::uint32_t facet : fan.facets) {
                is_replaced[facet] = true;
            }
            for (const RingTriangle &triangle : rings.triangles) {
                stop_if_given_up(graded.size());
                graded.push_back(facet_of(triangle, fan, facets));
            }
        }
        count.all += is_graded ? 1 : 0;
        count.coarse += is_coarse ? 1 : 0;
    };
    for (std::vector<FanTriangle> &members : by_vertex) {
        for (const FanTriangle &member : members) {
            facets[member.facet].is_crowded = true;
        }
        if (graded.size() < kMaxGradedFacets) {
            std::ranges::for_each(fans_of(std::move(members), facets), grade);
        }
    }
    if (count.all > 0) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < facets.size(); ++i) {
            if (!is_replaced[i]) {
                facets[kept++] = facets[i];
            }
        }
        facets.resize(kept);
        facets.insert(facets.end(), graded.begin(), graded.end());
    }
    return count;
}

} // namespace springdrive::contact
