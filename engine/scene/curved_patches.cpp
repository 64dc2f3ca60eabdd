#include "engine/scene/curved_patches.h"

#include "base/assertions.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

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

namespace {

using Triangle = std::array<std::uint32_t, 3>;
using GridPoint = std::array<std::size_t, 3>;

/// Where in the order of `for_each_grid_point` the vertex i steps towards the second corner and j
/// towards the third stands: the rows before it have cuts + 1, cuts, ... vertices.
std::uint32_t grid_index(std::size_t cuts, std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(i * (2 * cuts + 3 - i) / 2 + j);
}

/// A facet that points the way its patch does.
Triangle upright(std::size_t cuts, std::size_t i, std::size_t j) {
    return {grid_index(cuts, i, j), grid_index(cuts, i + 1, j), grid_index(cuts, i, j + 1)};
}

/// The one across from `upright(cuts, i, j)`, seen from the first corner. @pre i + j + 2 <= cuts
Triangle turned(std::size_t cuts, std::size_t i, std::size_t j) {
    SPRINGDRIVE_ASSERT(i + j + 2 <= cuts);
    return {grid_index(cuts, i + 1, j), grid_index(cuts, i + 1, j + 1), grid_index(cuts, i, j + 1)};
}

template <typename Visit> void for_each_facet(std::size_t cuts, Visit &&visit) {
    for (std::size_t i = 0; i < cuts; ++i) {
        for (std::size_t j = 0; i + j < cuts; ++j) {
            visit(upright(cuts, i, j));
            if (i + j + 2 <= cuts) {
                visit(turned(cuts, i, j));
            }
        }
    }
}

double angle_between(const Vector3 &a, const Vector3 &b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// The normal half-way along an edge: that of both ends, mirrored at the plane square to the edge
/// in its middle. So the normals swing over an edge that is bent like an S (section 3.3).
Vector3 middle_normal(const SmoothMesh &mesh, std::uint32_t from, std::uint32_t to) {
    const Vector3 way = mesh.positions[to] - mesh.positions[from];
    const Vector3 sum = mesh.normals[from] + mesh.normals[to];
    const double length2 = way.squaredNorm();
    const Vector3 mirrored =
        length2 > 0.0 ? Vector3(sum - 2.0 * way.dot(sum) / length2 * way) : sum;
    return mirrored.stableNormalized();
}

} // namespace

/// One patch, its corners numbered 0, 1, 2; edge e runs from corner e to the next.
struct CurvedPatches::Patch {
    std::array<const EdgeCurve *, 3> edges;
    std::array<bool, 3> backwards;
    Vector3 centre; ///< the control point that all corners share, b₁₁₁
    std::array<Vector3, 3> corner_normals;
    std::array<Vector3, 3> middle_normals; ///< of the edges

    /// The control point of edge e next to its start (0) or its end (1).
    [[nodiscard]] const Vector3 &beside(std::size_t e, std::size_t end) const {
        return edges[e]->control[backwards[e] ? 2 - end : 1 + end];
    }

    [[nodiscard]] const Vector3 &corner(std::size_t e) const {
        return edges[e]->control[backwards[e] ? 3 : 0];
    }

    /// Unit, square to the edge where it is half-way.
    [[nodiscard]] Vector3 normal_in_middle(std::size_t e) const {
        const Vector3 along = corner((e + 1) % 3) + beside(e, 1) - beside(e, 0) - corner(e);
        const double length2 = along.squaredNorm();
        const Vector3 &normal = middle_normals[e];
        return length2 > 0.0
                   ? Vector3(normal - normal.dot(along) / length2 * along).stableNormalized()
                   : normal;
    }

    /// On an edge exactly what the patch across it gives, bit by bit.
    [[nodiscard]] Vector3 position(const GridPoint &weights, std::size_t cuts) const {
        for (std::size_t e = 0; e < 3; ++e) {
            if (weights[(e + 2) % 3] == 0) {
                return edges[e]->at(weights[backwards[e] ? e : (e + 1) % 3], cuts);
            }
        }
        std::array<double, 3> w{};
        std::ranges::transform(weights, w.begin(), [&](std::size_t weight) {
            return static_cast<double>(weight) / static_cast<double>(cuts);
        });
        Vector3 sum = 6.0 * w[0] * w[1] * w[2] * centre;
        for (std::size_t e = 0; e < 3; ++e) {
            const double a = w[e];
            const double b = w[(e + 1) % 3];
            sum += a * a * a * corner(e) + 3.0 * a * b * (a * beside(e, 0) + b * beside(e, 1));
        }
        return sum;
    }

    /// The quadratic through the normals of corners and middles, for the eye. (The paper weighs
    /// the middle ones less: on a sphere of 80 triangles that errs by 2.5° instead of 0.08°.)
    [[nodiscard]] Vector3 normal(const GridPoint &weights) const {
        const auto whole = static_cast<double>(weights[0] + weights[1] + weights[2]);
        Vector3 sum = Vector3::Zero();
        for (std::size_t e = 0; e < 3; ++e) {
            const auto a = static_cast<double>(weights[e]);
            const auto b = static_cast<double>(weights[(e + 1) % 3]);
            sum += a * (2.0 * a - whole) * corner_normals[e] + 4.0 * a * b * middle_normals[e];
        }
        return sum.stableNormalized();
    }
};

CurvedPatches::CurvedPatches(SmoothMesh mesh) : mesh_(std::move(mesh)), edges_(mesh_) {}

/// How far the centre must move for the patch to leave each edge's middle square to the normal
/// there. The patch across the edge does the same, so both lie in one plane there, as they do at
/// the corners. Facets across the edges of a sphere of 80 triangles, finely cut, then differ by
/// 0.51° where they differ by 2.9° with the paper's centre and tangents.
Vector3 CurvedPatches::towards_even_joints(const Patch &patch) {
    // N · b₁₁₁ = N · (2 C(½) − ½ (b₂₀₁ + b₀₂₁)) for the edge that runs along C from b₃₀₀ to b₀₃₀
    Matrix3 normals;
    Vector3 off;
    for (std::size_t e = 0; e < 3; ++e) {
        const Vector3 requested =
            2.0 * patch.edges[e]->at(1, 2) -
            0.5 * (patch.beside((e + 2) % 3, 1) + patch.beside((e + 1) % 3, 0));
        const Vector3 normal = patch.normal_in_middle(e);
        const auto row = static_cast<Eigen::Index>(e);
        normals.row(row) = normal;
        off[row] = normal.dot(requested - patch.centre);
    }
    // Where the three normals hardly differ, small contradictions must not carry the centre off.
    constexpr double kDamping = 0.01;
    const Matrix3 damped = normals * normals.transpose() + kDamping * Matrix3::Identity();
    return normals.transpose() * damped.inverse() * off;
}

CurvedPatches::Patch CurvedPatches::patch(std::size_t triangle) const {
    const Triangle &corners = mesh_.triangles[triangle];
    Patch patch{};
    Vector3 beside_sum = Vector3::Zero();
    Vector3 corner_sum = Vector3::Zero();
    for (std::size_t e = 0; e < 3; ++e) {
        const PatchEdges::Side side = edges_.side(triangle, e);
        patch.edges[e] = &edges_.curve(side);
        patch.backwards[e] = side.backwards;
        patch.corner_normals[e] = mesh_.normals[corners[e]];
        patch.middle_normals[e] = middle_normal(mesh_, corners[e], corners[(e + 1) % 3]);
        beside_sum += patch.beside(e, 0) + patch.beside(e, 1);
        corner_sum += patch.corner(e);
    }
    // So that the patch is a quadratic one wherever its edges allow that.
    patch.centre = beside_sum / 4.0 - corner_sum / 6.0;
    patch.centre += towards_even_joints(patch);
    return patch;
}

SmoothMesh CurvedPatches::cut(std::size_t cuts, std::size_t first, std::size_t last) const {
    SmoothMesh result;
    const std::size_t vertices_each = (cuts + 1) * (cuts + 2) / 2;
    result.positions.reserve((last - first) * vertices_each);
    result.normals.reserve((last - first) * vertices_each);
    result.triangles.reserve((last - first) * cuts * cuts);
    for (std::size_t triangle = first; triangle < last; ++triangle) {
        const Patch bent = patch(triangle);
        const auto start = static_cast<std::uint32_t>(result.positions.size());
        for_each_grid_point(cuts, [&](const GridPoint &weights) {
            result.positions.push_back(bent.position(weights, cuts));
            result.normals.push_back(bent.normal(weights));
        });
        for_each_facet(cuts, [&](const Triangle &facet) {
            result.triangles.push_back({start + facet[0], start + facet[1], start + facet[2]});
        });
    }
    return result;
}

double CurvedPatches::turn_rad(std::size_t triangle, std::size_t cuts) const {
    const SmoothMesh facets = cut(cuts, triangle, triangle + 1);
    const auto normal = [&](const Triangle &facet) -> Vector3 {
        const Vector3 &corner = facets.positions[facet[0]];
        return (facets.positions[facet[1]] - corner).cross(facets.positions[facet[2]] - corner);
    };
    double max_rad = 0.0;
    for (std::size_t i = 0; i + 2 <= cuts; ++i) {
        for (std::size_t j = 0; i + j + 2 <= cuts; ++j) {
            const Vector3 middle = normal(turned(cuts, i, j));
            for (const Triangle &neighbour :
                 {upright(cuts, i, j), upright(cuts, i + 1, j), upright(cuts, i, j + 1)}) {
                max_rad = std::max(max_rad, angle_between(middle, normal(neighbour)));
            }
        }
    }
    return max_rad;
}

std::size_t CurvedPatches::cuts_for(double angle_rad, std::size_t maximum) const {
    std::size_t cuts = 1;
    for (std::size_t triangle = 0; triangle < mesh_.triangles.size(); ++triangle) {
        // A single facet has no neighbour in its patch; halved, it tells how much it bends.
        double turn = cuts == 1 ? 2.0 * turn_rad(triangle, 2) : turn_rad(triangle, cuts);
        while (cuts < maximum && turn > angle_rad) {
            const double requested = std::ceil(static_cast<double>(cuts) * turn / angle_rad);
            cuts = std::clamp(static_cast<std::size_t>(requested), cuts + 1, maximum);
            turn = turn_rad(triangle, cuts);
        }
    }
    return cuts;
}

double CurvedPatches::max_turn_rad(std::size_t cuts) const {
    double max_rad = 0.0;
    for (std::size_t triangle = 0; triangle < mesh_.triangles.size(); ++triangle) {
        max_rad = std::max(max_rad, turn_rad(triangle, cuts));
    }
    return max_rad;
}

void for_each_grid_point(std::size_t cuts, const std::function<void(const GridPoint &)> &visit) {
    for (std::size_t i = 0; i <= cuts; ++i) {
        for (std::size_t j = 0; i + j <= cuts; ++j) {
            visit({cuts - i - j, i, j});
        }
    }
}

} // namespace springdrive::scene
