#include "engine/contact/mesh/mesh_preparation.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/parallel.h"
#include "engine/contact/mesh/fan_grading.h"
#include "engine/contact/mesh/mesh_repair.h"
#include "engine/contact/mesh/mesh_stitching.h"
#include "engine/contact/mesh/mesh_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace springdrive::contact {

namespace {

[[nodiscard]] std::array<Vector3, 3> corners_m(const MeshTriangle &triangle,
                                               const std::vector<Vector3> &vertices_m) {
    const auto &[a, b, c] = triangle.vertices;
    return {vertices_m[a], vertices_m[b], vertices_m[c]};
}

struct Sliver {
    std::uint32_t index = 0;
    bool has_normal = true;
};

[[nodiscard]] std::vector<Sliver> find_slivers(const std::vector<MeshTriangle> &triangles,
                                               const std::vector<Vector3> &vertices_m,
                                               unsigned threads) {
    std::vector<std::vector<Sliver>> slivers_of_chunk(threads);
    in_chunks(triangles.size(), threads, [&](unsigned chunk, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            // True for a height that is not finite too.
            const double height_m = min_height_m(corners_m(triangles[i], vertices_m));
            if (!(height_m >= kMinHeight_m)) {
                slivers_of_chunk[chunk].push_back(
                    {static_cast<std::uint32_t>(i), height_m >= kMinNormalHeight_m});
            }
        }
    });
    std::vector<Sliver> slivers;
    for (const std::vector<Sliver> &some : slivers_of_chunk) {
        slivers.insert(slivers.end(), some.begin(), some.end());
    }
    return slivers;
}

[[nodiscard]] FacetSides sides_of(const MeshTriangle &triangle, const MeshComponent &component,
                                  TouchSides requested) {
    const bool is_one_sided =
        requested == TouchSides::one || (requested == TouchSides::automatic && component.is_closed);
    return is_one_sided && !triangle.has_both_windings ? FacetSides::one : FacetSides::two;
}

} // namespace

std::vector<std::uint32_t> slivers_to_leave_out(const std::vector<MeshTriangle> &triangles,
                                                const EdgeTable &edges,
                                                const std::vector<Vector3> &vertices_m,
                                                unsigned threads) {
    const std::vector<Sliver> slivers = find_slivers(triangles, vertices_m, threads);
    // By edge, so that many slivers at one edge do not look at each other.
    std::vector<bool> has_gap(slivers.empty() ? 0 : edges.uses());
    const auto leave_gap = [&](const VertexTriple &vertices) {
        for (std::size_t side = 0; side < 3; ++side) {
            has_gap[edges.first_use_of(vertices[side], vertices[(side + 1) % 3])] = true;
        }
    };
    const auto has_gap_beside = [&](const VertexTriple &vertices) {
        for (std::size_t side = 0; side < 3; ++side) {
            if (has_gap[edges.first_use_of(vertices[side], vertices[(side + 1) % 3])]) {
                return true;
            }
        }
        return false;
    };
    for (const Sliver &sliver : slivers) {
        if (!sliver.has_normal) {
            leave_gap(triangles[sliver.index].vertices);
        }
    }
    std::vector<std::uint32_t> left_out;
    for (const Sliver &sliver : slivers) {
        const VertexTriple &vertices = triangles[sliver.index].vertices;
        if (!sliver.has_normal || !has_gap_beside(vertices)) {
            leave_gap(vertices);
            left_out.push_back(sliver.index);
        }
    }
    return left_out;
}

std::vector<FacetSource> make_facets(const std::vector<MeshTriangle> &triangles,
                                     const std::vector<std::uint32_t> &left_out,
                                     const MeshTopology &topology, const TriangleSoup &soup,
                                     unsigned threads) {
    std::vector<FacetSource> facets(triangles.size() - left_out.size());
    in_chunks(triangles.size(), threads, [&](unsigned, std::size_t first, std::size_t last) {
        auto next_left_out = std::ranges::lower_bound(left_out, first);
        auto facet = facets.begin() + static_cast<std::ptrdiff_t>(first) -
                     (next_left_out - left_out.begin());
        for (std::size_t i = first; i < last; ++i) {
            stop_if_given_up(i);
            if (next_left_out != left_out.end() && *next_left_out == i) {
                ++next_left_out;
                continue;
            }
            const MeshTriangle &triangle = triangles[i];
            const MeshComponent &component = topology.components[topology.component_of_triangle[i]];
            const std::uint16_t material = soup.material_of_triangle[triangle.triangle];
            *facet++ = {corners_m(triangle, soup.vertices_m),
                        sides_of(triangle, component, soup.materials[material].sides),
                        triangle.triangle, material};
        }
    });
    return facets;
}

namespace {

/// Vertices closer than this are merged [m].
constexpr double kWeldTolerance_m = 1e-7;

/// Threads take time to start, and memory for every vertex.
constexpr std::size_t kMinTrianglesPerThread = 4000;
constexpr unsigned kMaxThreads = 8;

[[nodiscard]] unsigned useful_threads(unsigned allowed, std::size_t triangles) {
    const std::size_t busy = triangles / kMinTrianglesPerThread;
    return std::max(1U, static_cast<unsigned>(
                            std::min({busy, std::size_t{allowed}, std::size_t{kMaxThreads}})));
}

void require_consistent(const TriangleSoup &soup) {
    const auto is_in_range = [&](const std::array<std::uint32_t, 3> &triangle) {
        return std::ranges::all_of(
            triangle, [&](std::uint32_t vertex) { return vertex < soup.vertices_m.size(); });
    };
    const auto has_material = [&](std::uint16_t material) {
        return material < soup.materials.size();
    };
    if (!std::ranges::all_of(soup.triangles, is_in_range)) {
        throw std::invalid_argument("prepare_mesh: a vertex index is out of range");
    }
    if (soup.material_of_triangle.size() != soup.triangles.size() ||
        !std::ranges::all_of(soup.material_of_triangle, has_material)) {
        throw std::invalid_argument("prepare_mesh: a triangle lacks its material");
    }
}

/// A proxy far away would never touch, and never say why.
void require_near(const TriangleSoup &soup) {
    for (const Vector3 &vertex_m : soup.vertices_m) {
        if (vertex_m.allFinite() && vertex_m.cwiseAbs().maxCoeff() >= kFarthest_m) {
            const auto index = &vertex_m - soup.vertices_m.data();
            throw InputError("vertex " + std::to_string(index) + " has a coordinate of " +
                             std::to_string(std::lround(kFarthest_m)) +
                             " m or more, where nothing can be touched; move or scale the surface");
        }
    }
}

void require_few(std::size_t triangles) {
    if (triangles > kMaxTriangles) {
        throw std::length_error("prepare_mesh: more triangles than can be prepared");
    }
}

/// What became of a triangle of the soup. If it was divided, the best outcome of its pieces.
enum class TriangleOutcome : std::uint8_t { degenerate, duplicate, merged, kept };

/// A mesh during the steps of preparation, with its current edges.
class Preparation {
public:
    Preparation(const TriangleSoup &soup, unsigned threads)
        : soup_(soup), threads_(threads), allowance_(soup.triangles.size()),
          outcomes_(soup.triangles.size(), TriangleOutcome::degenerate),
          triangles_(welded_triangles()), edges_(triangles_, soup.vertices_m.size(), threads) {
        report_.triangles_given = soup.triangles.size();
    }

    void drop_repeated() {
        const RepeatedTriangles repeated =
            drop_repeated_triangles(triangles_, edges_, soup_.material_of_triangle, threads_);
        for (const std::uint32_t triangle : repeated.same_winding) {
            improve_outcome(triangle, TriangleOutcome::duplicate);
        }
        for (const std::uint32_t triangle : repeated.merged) {
            improve_outcome(triangle, TriangleOutcome::merged);
        }
        if (!repeated.same_winding.empty() || !repeated.merged.empty()) {
            renew_edges();
        }
    }

    void close_open_edges() {
        report_.open_edges_given = count_open(edges_);
        if (report_.open_edges_given == 0) {
            return;
        }
        const ClosedCracks closed = close_cracks(triangles_, edges_, soup_.vertices_m,
                                                 kCrackTolerance_m, allowance_, threads_);
        if (closed.moved_vertices > 0) {
            for (MeshTriangle &triangle : triangles_) {
                for (std::uint32_t &vertex : triangle.vertices) {
                    vertex = closed.stands_for[vertex];
                }
            }
            renew_edges();
        }
        const SplitEdges split = split_edges(triangles_, edges_, soup_.vertices_m,
                                             kCrackTolerance_m, allowance_, threads_);
        if (split.split_triangles > 0) {
            require_few(triangles_.size());
            renew_edges();
        }
        report_.closed_cracks = closed.moved_vertices;
        report_.split_triangles = split.split_triangles;
        report_.largest_move_m = std::max(closed.largest_move_m, split.largest_move_m);
        if (closed.moved_vertices + split.split_triangles > 0) {
            drop_repeated(); // one sheet may now coincide with another
        }
    }

    void orient() {
        const TurnedTriangles turned = orient_triangles(triangles_, edges_, soup_.vertices_m);
        report_.flipped_triangles = turned.of_one_winding;
        if (turned.of_one_winding + turned.of_both > 0) {
            renew_edges();
        }
    }

    [[nodiscard]] PreparedMesh finish() {
        const MeshTopology topology = find_topology(triangles_, edges_);
        // Slivers count in the topology, or a surface with a sliver in it would count as open.
        const std::vector<std::uint32_t> slivers =
            slivers_to_leave_out(triangles_, edges_, soup_.vertices_m, threads_);
        PreparedMesh mesh;
        mesh.facets = make_facets(triangles_, slivers, topology, soup_, threads_);
        report_.graded_fans = grade_fans(mesh.facets, triangles_, slivers, soup_.vertices_m.size());
        note_kept(slivers);
        report_outcomes();
        report_on(topology);
        mesh.report = std::move(report_);
        return mesh;
    }

private:
    /// Triangles of three different finite vertices, welded.
    [[nodiscard]] std::vector<MeshTriangle> welded_triangles() {
        const std::vector<std::uint32_t> stands_for =
            weld_vertices(soup_.vertices_m, kWeldTolerance_m, allowance_, threads_);
        for (std::uint32_t vertex = 0; vertex < stands_for.size(); ++vertex) {
            report_.welded_vertices += stands_for[vertex] == vertex ? 0 : 1;
        }
        std::vector<MeshTriangle> welded;
        welded.reserve(soup_.triangles.size());
        for (std::uint32_t i = 0; i < soup_.triangles.size(); ++i) {
            stop_if_given_up(i);
            const auto &[a, b, c] = soup_.triangles[i];
            const VertexTriple vertices = {stands_for[a], stands_for[b], stands_for[c]};
            const bool is_collapsed = vertices[0] == vertices[1] || vertices[1] == vertices[2] ||
                                      vertices[2] == vertices[0];
            if (!is_collapsed && is_finite(vertices)) {
                welded.push_back({vertices, i});
            }
        }
        return welded;
    }

    [[nodiscard]] bool is_finite(const VertexTriple &vertices) const {
        return std::ranges::all_of(
            vertices, [&](std::uint32_t vertex) { return soup_.vertices_m[vertex].allFinite(); });
    }

    void renew_edges() { edges_ = EdgeTable(triangles_, soup_.vertices_m.size(), threads_); }

    void improve_outcome(std::uint32_t triangle, TriangleOutcome outcome) {
        outcomes_[triangle] = std::max(outcomes_[triangle], outcome);
    }

    /// @param slivers in ascending order
    void note_kept(const std::vector<std::uint32_t> &slivers) {
        auto sliver = slivers.begin();
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            if (sliver != slivers.end() && *sliver == i) {
                ++sliver;
            } else {
                outcomes_[triangles_[i].triangle] = TriangleOutcome::kept;
            }
        }
    }

    void report_outcomes() {
        std::array<std::size_t, 4> counts{};
        report_.left_out_of_material.assign(soup_.materials.size(), 0);
        for (std::size_t i = 0; i < outcomes_.size(); ++i) {
            ++counts[static_cast<std::size_t>(outcomes_[i])];
            if (outcomes_[i] < TriangleOutcome::merged) {
                ++report_.left_out_of_material[soup_.material_of_triangle[i]];
            }
        }
        report_.degenerate_triangles =
            counts[static_cast<std::size_t>(TriangleOutcome::degenerate)];
        report_.duplicate_triangles = counts[static_cast<std::size_t>(TriangleOutcome::duplicate)];
        report_.merged_triangles = counts[static_cast<std::size_t>(TriangleOutcome::merged)];
        report_.triangles_kept = counts[static_cast<std::size_t>(TriangleOutcome::kept)];
    }

    void report_on(const MeshTopology &topology) {
        report_.open_edges = topology.open_edges;
        report_.non_manifold_edges = topology.non_manifold_edges;
        report_.components = topology.components.size();
        report_.closed_components = static_cast<std::size_t>(
            std::ranges::count(topology.components, true, &MeshComponent::is_closed));
        report_.unorientable_components = static_cast<std::size_t>(
            std::ranges::count(topology.components, false, &MeshComponent::is_orientable));
        const std::vector<double> volumes =
            enclosed_volumes_m3(triangles_, topology, soup_.vertices_m);
        report_.inward_components = static_cast<std::size_t>(
            std::ranges::count_if(volumes, [](double volume) { return volume < 0.0; }));
    }

    const TriangleSoup &soup_;
    unsigned threads_;
    PreparationAllowance allowance_;
    MeshReport report_;
    std::vector<TriangleOutcome> outcomes_;
    std::vector<MeshTriangle> triangles_;
    EdgeTable edges_;
};

} // namespace

PreparedMesh prepare_mesh(const TriangleSoup &soup, unsigned threads) {
    require_consistent(soup);
    require_near(soup);
    require_few(soup.triangles.size());
    Preparation preparation(soup, useful_threads(threads, soup.triangles.size()));
    preparation.drop_repeated();
    preparation.close_open_edges();
    preparation.orient();
    return preparation.finish();
}

} // namespace springdrive::contact
