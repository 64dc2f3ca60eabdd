#include "engine/scene/patch_edges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>

namespace springdrive::scene {

namespace {

constexpr double kSharp_rad = 5.0 / 180.0 * std::numbers::pi;

/// Less than half of the way to the other end along the tangent: the normals do not describe this
/// edge.
constexpr double kSteepest = 0.5;

/// For each vertex a number that all vertices at its place have in common.
std::vector<std::uint32_t> places_of(const std::vector<Vector3> &positions) {
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t i) {
        const Vector3 &p = positions[i];
        return std::make_tuple(p.x(), p.y(), p.z());
    };
    std::ranges::sort(order, {}, key);
    std::vector<std::uint32_t> places(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool is_new = i == 0 || positions[order[i]] != positions[order[i - 1]];
        places[order[i]] = is_new ? order[i] : places[order[i - 1]];
    }
    return places;
}

/// One triangle's use of an edge; `low` and `high` are places.
struct Use {
    std::uint32_t low;
    std::uint32_t high;
    std::size_t side;                      ///< 3 triangle + edge
    std::array<std::uint32_t, 2> vertices; ///< at `low`, at `high`
    bool backwards;

    [[nodiscard]] bool same_edge(const Use &other) const {
        return low == other.low && high == other.high;
    }
};

std::vector<Use> uses_by_edge(const SmoothMesh &mesh) {
    const std::vector<std::uint32_t> places = places_of(mesh.positions);
    std::vector<Use> uses;
    uses.reserve(3 * mesh.triangles.size());
    for (const auto &triangle : mesh.triangles) {
        for (std::size_t edge = 0; edge < 3; ++edge) {
            std::array<std::uint32_t, 2> ends{triangle[edge], triangle[(edge + 1) % 3]};
            const bool backwards = places[ends[0]] > places[ends[1]];
            if (backwards) {
                std::swap(ends[0], ends[1]);
            }
            uses.push_back({places[ends[0]], places[ends[1]], uses.size(), ends, backwards});
        }
    }
    std::ranges::sort(uses, {},
                      [](const Use &use) { return std::make_tuple(use.low, use.high, use.side); });
    return uses;
}

/// What of `way` lies within the tangent planes at its start.
Vector3 within_tangent_planes(const Vector3 &way, std::span<const Vector3> normals) {
    const Vector3 &first = normals.front();
    Vector3 sum = Vector3::Zero();
    Vector3 odd_one = first; // the one that differs most from the first
    for (const Vector3 &normal : normals) {
        sum += normal;
        odd_one = normal.dot(first) < odd_one.dot(first) ? normal : odd_one;
    }
    const Vector3 meeting_line = first.cross(odd_one);
    if (std::atan2(meeting_line.norm(), first.dot(odd_one)) <= kSharp_rad) {
        const Vector3 normal = sum.normalized();
        return way - normal * normal.dot(way);
    }
    const Vector3 along = meeting_line.normalized();
    const bool describes =
        normals.size() == 2 && std::abs(along.dot(way)) >= kSteepest * way.norm();
    return describes ? Vector3(along * along.dot(way)) : way;
}

/// From the start of a curve to its next control point. Its length makes a circular arc of what
/// can be one: with the angle φ between tangent and chord, (4/3) r tan(φ/2) = (2/3) chord/(1 + cos
/// φ).
Vector3 first_leg(const Vector3 &way, std::span<const Vector3> normals) {
    const Vector3 along = within_tangent_planes(way, normals);
    const double chord = way.norm();
    const double cos_phi_chord = along.norm();
    return cos_phi_chord > 0.0 ? Vector3(along / cos_phi_chord * (2.0 / 3.0) * chord * chord /
                                         (chord + cos_phi_chord))
                               : Vector3(Vector3::Zero());
}

EdgeCurve curve_of(std::span<const Use> uses, const SmoothMesh &mesh) {
    std::array<std::vector<Vector3>, 2> normals;
    for (const Use &use : uses) {
        normals[0].push_back(mesh.normals[use.vertices[0]]);
        normals[1].push_back(mesh.normals[use.vertices[1]]);
    }
    const Vector3 &start = mesh.positions[uses.front().low];
    const Vector3 &end = mesh.positions[uses.front().high];
    return {{start, start + first_leg(end - start, normals[0]),
             end + first_leg(start - end, normals[1]), end}};
}

} // namespace

Vector3 EdgeCurve::at(std::size_t step, std::size_t steps) const {
    const double t = static_cast<double>(step) / static_cast<double>(steps);
    const double s = static_cast<double>(steps - step) / static_cast<double>(steps);
    return s * s * s * control[0] + 3.0 * s * s * t * control[1] + 3.0 * s * t * t * control[2] +
           t * t * t * control[3];
}

PatchEdges::PatchEdges(const SmoothMesh &mesh) : sides_(3 * mesh.triangles.size()) {
    const std::vector<Use> uses = uses_by_edge(mesh);
    for (auto first = uses.begin(); first != uses.end();) {
        const auto last = std::find_if_not(first, uses.end(),
                                           [&](const Use &use) { return use.same_edge(*first); });
        for (auto use = first; use != last; ++use) {
            sides_[use->side] = {static_cast<std::uint32_t>(curves_.size()), use->backwards};
        }
        curves_.push_back(curve_of({first, last}, mesh));
        first = last;
    }
}

} // namespace springdrive::scene
