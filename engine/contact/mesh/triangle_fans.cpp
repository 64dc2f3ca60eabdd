#include "engine/contact/mesh/fan_grading.h"

#include "base/cancellation.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>

namespace springdrive::contact {

namespace {

/// Links the triangles at one vertex to those that follow them, across edges that no other triangle
/// uses: such an edge must stay, or there would be a gap below the other.
class FanChains {
public:
    FanChains(std::vector<FanTriangle> triangles, const std::vector<FacetSource> &facets)
        : triangles_(std::move(triangles)), facets_(facets), next_(triangles_.size(), kNone),
          has_previous_(triangles_.size()) {
        std::unordered_map<std::uint32_t, Neighbours> at_rim;
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            stop_if_given_up(i);
            at_rim[triangles_[i].from].begins.note(i);
            at_rim[triangles_[i].to].ends.note(i);
        }
        for (const auto &[vertex, neighbours] : at_rim) {
            if (neighbours.begins.is_one() && neighbours.ends.is_one() &&
                belong_together(neighbours.begins.triangle, neighbours.ends.triangle)) {
                next_[neighbours.ends.triangle] = neighbours.begins.triangle;
                has_previous_[neighbours.begins.triangle] = true;
            }
        }
    }

    [[nodiscard]] std::vector<TriangleFan> take_fans() {
        std::vector<TriangleFan> fans;
        for (const bool is_open : {true, false}) {
            for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
                if (triangles_[i].is_own && next_[i] != kTaken && (!is_open || !has_previous_[i])) {
                    fans.push_back(take(i));
                }
            }
        }
        return fans;
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    static constexpr std::uint32_t kTaken = kNone - 1;

    /// The triangles on one side of a spoke.
    struct OneSide {
        std::uint32_t triangle = 0;
        std::uint32_t count = 0;

        void note(std::uint32_t i) {
            triangle = i;
            ++count;
        }
        [[nodiscard]] bool is_one() const { return count == 1; }
    };
    struct Neighbours {
        OneSide begins;
        OneSide ends;
    };

    [[nodiscard]] bool belong_together(std::uint32_t a, std::uint32_t b) const {
        const FacetSource &one = facets_[triangles_[a].facet];
        const FacetSource &other = facets_[triangles_[b].facet];
        return triangles_[a].is_own && triangles_[b].is_own && one.material == other.material &&
               one.sides == other.sides;
    }

    [[nodiscard]] TriangleFan take(std::uint32_t i) {
        TriangleFan fan;
        const auto corner_m = [&](std::uint32_t after_apex) -> const Vector3 & {
            const FanTriangle &triangle = triangles_[i];
            return facets_[triangle.facet].corners_m[(triangle.apex + after_apex) % 3];
        };
        fan.apex_m = corner_m(0);
        fan.rim_m.push_back(corner_m(1));
        while (i != kNone && next_[i] != kTaken) {
            fan.rim_m.push_back(corner_m(2));
            fan.facets.push_back(triangles_[i].facet);
            i = std::exchange(next_[i], kTaken);
        }
        return fan;
    }

    std::vector<FanTriangle> triangles_;
    const std::vector<FacetSource> &facets_;
    std::vector<std::uint32_t> next_; ///< which follows, or kNone or kTaken
    std::vector<bool> has_previous_;
};

/// By vertex.
[[nodiscard]] std::map<std::uint32_t, std::vector<FanTriangle>>
find_by_vertex(const std::vector<MeshTriangle> &triangles,
               const std::vector<std::uint32_t> &left_out, std::size_t vertices,
               std::size_t min_size) {
    std::vector<std::uint32_t> uses(vertices);
    for (const MeshTriangle &triangle : triangles) {
        for (const std::uint32_t vertex : triangle.vertices) {
            ++uses[vertex];
        }
    }
    std::map<std::uint32_t, std::vector<FanTriangle>> fans;
    if (std::ranges::none_of(uses, [&](std::uint32_t count) { return count >= min_size; })) {
        return fans;
    }
    auto next_left_out = left_out.begin();
    std::uint32_t facet = 0;
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        stop_if_given_up(i);
        if (next_left_out != left_out.end() && *next_left_out == i) {
            ++next_left_out;
            continue;
        }
        const VertexTriple &vertices_of = triangles[i].vertices;
        std::uint32_t apex = 0;
        for (std::uint32_t corner = 1; corner < 3; ++corner) {
            if (uses[vertices_of[corner]] > uses[vertices_of[apex]]) {
                apex = corner;
            }
        }
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
            if (uses[vertices_of[corner]] >= min_size) {
                fans[vertices_of[corner]].push_back({vertices_of[(corner + 1) % 3],
                                                     vertices_of[(corner + 2) % 3], corner, facet,
                                                     corner == apex});
            }
        }
        ++facet;
    }
    return fans;
}

[[nodiscard]] std::vector<std::vector<FanTriangle>>
largest_first(std::map<std::uint32_t, std::vector<FanTriangle>> &fans) {
    std::vector<std::vector<FanTriangle>> sorted;
    sorted.reserve(fans.size());
    for (auto &[apex, members] : fans) {
        sorted.push_back(std::move(members));
    }
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto &a, const auto &b) { return a.size() > b.size(); });
    return sorted;
}

} // namespace

std::vector<std::vector<FanTriangle>> find_fan_triangles(const std::vector<MeshTriangle> &triangles,
                                                         const std::vector<std::uint32_t> &left_out,
                                                         std::size_t vertices,
                                                         std::size_t min_size) {
    std::map<std::uint32_t, std::vector<FanTriangle>> fans =
        find_by_vertex(triangles, left_out, vertices, min_size);
    return largest_first(fans);
}

std::vector<TriangleFan> fans_of(std::vector<FanTriangle> triangles,
                                 const std::vector<FacetSource> &facets) {
    return FanChains(std::move(triangles), facets).take_fans();
}

std::vector<TriangleFan> divided_by_length(const TriangleFan &fan) {
    constexpr double kAboutAsLong = 8.0;
    std::vector<TriangleFan> parts;
    double min_m = 0.0;
    double max_m = 0.0;
    for (std::size_t i = 0; i < fan.facets.size(); ++i) {
        const double first_m = fan.spoke_m(i).norm();
        const double last_m = fan.spoke_m(i + 1).norm();
        min_m = std::min({min_m, first_m, last_m});
        max_m = std::max({max_m, first_m, last_m});
        if (parts.empty() || max_m > kAboutAsLong * min_m) {
            parts.push_back({fan.apex_m, {fan.rim_m[i]}, {}});
            min_m = std::min(first_m, last_m);
            max_m = std::max(first_m, last_m);
        }
        parts.back().rim_m.push_back(fan.rim_m[i + 1]);
        parts.back().facets.push_back(fan.facets[i]);
    }
    return parts;
}

} // namespace springdrive::contact
