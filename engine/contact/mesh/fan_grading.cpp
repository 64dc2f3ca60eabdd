#include "engine/contact/mesh/fan_grading.h"

#include "base/cancellation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

namespace springdrive::contact {

namespace {

/// A fan ends in this many triangles at its vertex, or a few more.
constexpr std::size_t kFewest = 12;

/// How high the rings' triangles are, at least [m]: about that. Not those of a core.
constexpr double kMinRing_m = 2.0 * kClearance_m;

/// With more triangles around than this, a ring is short at first, so that its triangles' boxes
/// overlap those of few others.
constexpr double kMaxAroundLongRing = 500.0;

/// Where more sectors than this are left, kCoarseGradingError_m applies: their edges are too blunt
/// to be felt, but a proxy that crosses hundreds in a tick takes too long.
constexpr std::size_t kManySectors = 500;

/// Radius of the core of a rough fan [m]: whatever replaces it is within its diameter.
constexpr double kCore_m = 0.5 * kCoarseGradingError_m;

/// By which part of their distance from the vertex the rings of a core follow each other. Where the
/// rim is jagged some triangles are folded over, which opens nothing: the surface has the same rim
/// as before.
constexpr double kCoreRing = 0.15;

/// Rings are longer where a fan would become more than this many triangles for each given one.
constexpr std::size_t kMaxGrowth = 8;

/// Every 2^level-th spoke, and the last.
class SpokesOfLevel {
public:
    SpokesOfLevel(std::size_t triangles, unsigned level) : last_(triangles), level_(level) {}

    [[nodiscard]] std::size_t sectors() const {
        return (last_ + (std::size_t{1} << level_) - 1) >> level_;
    }
    [[nodiscard]] std::size_t operator[](std::size_t i) const {
        return std::min(i << level_, last_);
    }

private:
    std::size_t last_;
    unsigned level_;
};

/// How far the rim is from the triangles that have only the spokes of a level [m], at most;
/// infinite where a sector turns back or turns by a right angle.
[[nodiscard]] double rim_error_m(const TriangleFan &fan, unsigned level) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const SpokesOfLevel spokes(fan.facets.size(), level);
    double error_m = 0.0;
    for (std::size_t i = 0; i < spokes.sectors(); ++i) {
        const Vector3 first_m = fan.spoke_m(spokes[i]);
        const Vector3 last_m = fan.spoke_m(spokes[i + 1]);
        const Vector3 area_m2 = first_m.cross(last_m);
        if (first_m.dot(last_m) <= 0.0 || area_m2.isZero(0.0)) {
            return kInfinity;
        }
        const Vector3 normal = area_m2.normalized();
        for (std::size_t spoke = spokes[i]; spoke < spokes[i + 1]; ++spoke) {
            const Vector3 own_m2 = fan.spoke_m(spoke).cross(fan.spoke_m(spoke + 1));
            if (own_m2.dot(normal) <= 0.5 * own_m2.norm()) {
                return kInfinity;
            }
            error_m = std::max(error_m, std::abs(fan.spoke_m(spoke).dot(normal)));
        }
    }
    return error_m;
}

/// How far out the triangles that have only the spokes of a level cross those halfway between, at
/// most: 1 is at the rim.
[[nodiscard]] double crossing_of_halfway_spokes(const TriangleFan &fan, unsigned level) {
    const SpokesOfLevel finer(fan.facets.size(), level - 1);
    double farthest = 0.0;
    for (std::size_t i = 0; i + 1 < finer.sectors(); i += 2) {
        const Vector3 first_m = fan.spoke_m(finer[i]);
        const Vector3 last_m = fan.spoke_m(finer[i + 2]);
        const Vector3 area_m2 = first_m.cross(last_m);
        farthest =
            std::max(farthest, area_m2.squaredNorm() /
                                   fan.spoke_m(finer[i + 1]).cross(last_m - first_m).dot(area_m2));
    }
    return farthest;
}

/// Grades one fan, from the rim towards its vertex.
class FanGrading {
public:
    FanGrading(const TriangleFan &fan, double max_around_long_ring)
        : fan_(fan), max_around_long_ring_(max_around_long_ring) {
        for (std::size_t i = 0; i < fan.facets.size(); ++i) {
            const Vector3 first_m = fan.spoke_m(i);
            const Vector3 last_m = fan.spoke_m(i + 1);
            shortest_m_ = std::min({shortest_m_, first_m.norm(), last_m.norm()});
            longest_m_ = std::max({longest_m_, first_m.norm(), last_m.norm()});
            turn_ += std::atan2(first_m.cross(last_m).norm(), first_m.dot(last_m));
        }
    }

    /// The triangles, if they are fewer at the vertex.
    [[nodiscard]] std::optional<std::vector<RingTriangle>> triangles() {
        const std::size_t most = kMaxGrowth * fan_.facets.size();
        double fraction = 1.0;
        while (sectors() > kFewest && triangles_.size() <= most) {
            stop_if_given_up();
            if (fraction <= core()) {
                is_coarse_ = true;
                const double next = (1.0 - kCoreRing) * fraction;
                add_halving_ring(fraction, next);
                ++level_;
                fraction = next;
                continue;
            }
            // Half as many sectors are near enough from here on.
            const double enough = std::max(enough_from(level_ + 1), core());
            const bool is_enough = fraction <= enough;
            const double next =
                std::min(is_enough ? halving_to(fraction) : std::max(enough, ring_to(fraction)),
                         fraction - kMinRing_m / shortest_m_);
            if (!has_room(fraction, next)) {
                if (sectors() < kMinGradedFan) {
                    break;
                }
                add_ring(fraction, core());
                fraction = core();
                continue;
            }
            if (is_enough) {
                is_coarse_ = is_coarse_ || fraction > kGradingError_m / error_m(level_ + 1);
                add_halving_ring(fraction, next);
                ++level_;
            } else {
                add_ring(fraction, next);
            }
            fraction = next;
        }
        if (level_ == 0 || triangles_.size() > most) {
            return std::nullopt;
        }
        add_centre(fraction);
        return std::move(triangles_);
    }

    /// Whether they are farther than kGradingError_m from the given ones.
    [[nodiscard]] bool is_coarse() const { return is_coarse_; }

private:
    [[nodiscard]] std::size_t sectors() const {
        return SpokesOfLevel(fan_.facets.size(), level_).sectors();
    }

    /// The angle of a sector [rad].
    [[nodiscard]] double sector() const { return turn_ / static_cast<double>(sectors()); }

    /// How far what has the spokes of a level is from the rim [m].
    [[nodiscard]] double error_m(unsigned level) {
        while (errors_m_.size() <= level) {
            errors_m_.push_back(2.0 * rim_error_m(fan_, static_cast<unsigned>(errors_m_.size())));
        }
        return errors_m_[level];
    }

    /// The fraction of the spokes up to which those of a level are near enough.
    [[nodiscard]] double enough_from(unsigned level) {
        const bool are_many = SpokesOfLevel(fan_.facets.size(), level).sectors() > kManySectors;
        return (are_many ? kCoarseGradingError_m : kGradingError_m) / error_m(level);
    }

    /// The fraction of the spokes up to which anything is near enough.
    [[nodiscard]] double core() const { return kCore_m / longest_m_; }

    /// How far the next ring may be.
    [[nodiscard]] double ring_to(double fraction) const {
        const double share = max_around_long_ring_ / static_cast<double>(sectors());
        return fraction * (1.0 - std::clamp(share, 0.25, 1.0));
    }

    /// Where a ring ends whose triangles are about as high as wide; a long one where they are few.
    [[nodiscard]] double halving_to(double fraction) {
        const double square = fraction * (1.0 - std::min(2.0 * sector(), 0.5));
        const double longest = std::max(ring_to(fraction), 0.01 * fraction);
        // Where the rim is jagged, a longer side must not cut off a shorter spoke.
        const double within = fraction * (1.0 - std::min(sector(), 0.25)) /
                              crossing_of_halfway_spokes(fan_, level_ + 1);
        return std::min({square, within, std::max(longest, enough_from(level_ + 2))});
    }

    /// Whether the triangles within a ring would not be too thin.
    [[nodiscard]] bool has_room(double fraction, double next) const {
        return next > 0.0 && fraction > next && 2.0 * next * shortest_m_ * sector() >= kMinRing_m;
    }

    void add_ring(double outer, double inner) {
        const SpokesOfLevel spokes(fan_.facets.size(), level_);
        for (std::size_t i = 0; i < spokes.sectors(); ++i) {
            add_quad(spokes[i], spokes[i + 1], outer, inner);
        }
    }

    void add_quad(std::size_t first, std::size_t last, double outer, double inner) {
        triangles_.push_back({{{first, inner}, {first, outer}, {last, outer}}});
        triangles_.push_back({{{first, inner}, {last, outer}, {last, inner}}});
    }

    /// Sectors of this level outside, pairs of them inside.
    void add_halving_ring(double outer, double inner) {
        const SpokesOfLevel spokes(fan_.facets.size(), level_);
        const std::size_t sectors = spokes.sectors();
        std::size_t i = 0;
        for (; i + 1 < sectors; i += 2) {
            const std::size_t first = spokes[i];
            const std::size_t middle = spokes[i + 1];
            const std::size_t last = spokes[i + 2];
            triangles_.push_back({{{first, inner}, {first, outer}, {middle, outer}}});
            triangles_.push_back({{{first, inner}, {middle, outer}, {last, inner}}});
            triangles_.push_back({{{last, inner}, {middle, outer}, {last, outer}}});
        }
        if (i < sectors) {
            add_quad(spokes[i], spokes[i + 1], outer, inner);
        }
    }

    void add_centre(double fraction) {
        const SpokesOfLevel spokes(fan_.facets.size(), level_);
        for (std::size_t i = 0; i < spokes.sectors(); ++i) {
            triangles_.push_back(
                {{{spokes[i], 0.0}, {spokes[i], fraction}, {spokes[i + 1], fraction}}});
        }
    }

    const TriangleFan &fan_;
    double max_around_long_ring_;
    double shortest_m_ = std::numeric_limits<double>::infinity();
    double longest_m_ = 0.0;
    double turn_ = 0.0;            ///< of all sectors [rad]
    std::vector<double> errors_m_; ///< by level
    bool is_coarse_ = false;
    unsigned level_ = 0;
    std::vector<RingTriangle> triangles_;
};

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

FanRings rings_of(const TriangleFan &fan) {
    if (fan.facets.size() < kMinGradedFan) {
        return {};
    }
    const auto count = static_cast<double>(fan.facets.size());
    for (double around = kMaxAroundLongRing;; around *= 2.0) {
        FanGrading grading(fan, around);
        std::optional<std::vector<RingTriangle>> triangles = grading.triangles();
        if (triangles) {
            return {std::move(*triangles), grading.is_coarse()};
        }
        if (around > count) {
            return {};
        }
    }
}

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
