// Joins what was meant to be one, but differs by rounding, computation or conversion. In this
// order:
//
//   - vertices at the same place: exporters repeat a vertex for every normal and texture coordinate
//     it carries, and only positions matter to contact
//   - vertices along open edges across a narrow crack
//   - T-junctions, where one triangle's side runs along several sides of others, whose vertices lie
//     on it only up to round-off
#pragma once

#include "base/vector.h"
#include "engine/contact/mesh/mesh_topology.h"
#include "engine/contact/mesh/triangle_soup.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace springdrive::contact {

// Bounds the work of preparing a mesh. A few thousand triangles that lie nearly on one line touch
// each other everywhere: closing their cracks would take hours, and all memory there is.

/// Steps are what preparation does more of the more a mesh touches itself: a step takes 2 to 5 ns,
/// more where memory is slow, and compares two vertices. What is proportional to the number of
/// triangles is not counted.
///
/// A pair of vertices that nearly coincide is stored (20 bytes) and sorted.
inline constexpr std::uint64_t kStepsPerPair = 32;
/// A vertex in the tree that is compared with an edge.
inline constexpr std::uint64_t kStepsPerNode = 6;
/// A piece of a divided triangle is a triangle from there on, of some 300 bytes at the peak and
/// 1.5 µs of all later work.
inline constexpr std::uint64_t kStepsPerPiece = 500;

/// One allowance for all stages, as for 4 million pieces and for each triangle four more: a mesh of
/// which nothing fits together, each vertex 20 µm off, takes less than half of it. At most as for
/// 20 million pieces, so that memory is bounded too.
inline constexpr std::uint64_t kAllowedSteps = 2'000'000'000;
inline constexpr std::uint64_t kAllowedStepsPerTriangle = 2000;
inline constexpr std::uint64_t kMaxAllowedSteps = 10'000'000'000;

class PreparationAllowance {
public:
    /// @param triangles given
    explicit PreparationAllowance(std::size_t triangles)
        : PreparationAllowance(triangles, std::min(kMaxAllowedSteps,
                                                   kAllowedSteps + kAllowedStepsPerTriangle *
                                                                       std::uint64_t{triangles})) {}
    PreparationAllowance(std::size_t triangles, std::uint64_t allowed_steps)
        : triangles_(triangles), allowed_(allowed_steps) {}

    /// Whether these steps were still allowed. Callable from any thread.
    bool take(std::uint64_t steps) noexcept { return taken_ += steps, !is_exceeded(); }

    [[nodiscard]] bool is_exceeded() const noexcept { return taken_ > allowed_; }
    [[nodiscard]] std::uint64_t taken() const noexcept { return taken_; }

    /// @param purpose       of the stage that exceeded it, after "most of them"
    /// @param needed_steps  an estimate of what all stages up to its end need
    /// @throw InputError with both numbers of steps, always
    [[noreturn]] void refuse(std::string_view purpose, double needed_steps) const;

private:
    std::size_t triangles_;
    std::uint64_t allowed_;
    std::atomic<std::uint64_t> taken_{0};
};

/// The steps of one thread, taken from an allowance in large portions; all when it is destroyed.
class StepCounter {
public:
    explicit StepCounter(PreparationAllowance &allowance) : allowance_(allowance) {}
    ~StepCounter() { allowance_.take(pending_); }
    StepCounter(const StepCounter &) = delete;
    StepCounter &operator=(const StepCounter &) = delete;

    /// False once the portions taken exceed the allowance.
    bool add(std::uint64_t steps) noexcept {
        constexpr std::uint64_t kPortion = 1 << 20;
        pending_ += steps;
        return pending_ < kPortion || allowance_.take(std::exchange(pending_, 0));
    }

private:
    PreparationAllowance &allowance_;
    std::uint64_t pending_ = 0;
};

/// The sum of `steps_of(i)` over all i below `count`, estimated from some of them.
template <typename StepsOf>
[[nodiscard]] double estimated_steps(std::size_t count, const StepsOf &steps_of) {
    constexpr std::size_t kSamples = 256;
    const std::size_t stride = count / kSamples + 1;
    double sum = 0.0;
    std::size_t samples = 0;
    for (std::size_t i = stride / 2; i < count; i += stride) {
        sum += static_cast<double>(steps_of(i));
        ++samples;
    }
    return samples == 0 ? 0.0 : sum * static_cast<double>(count) / static_cast<double>(samples);
}

/// For each vertex the index of its representative: itself, or an earlier vertex within
/// `tolerance_m` that represents itself. So no vertex moves by more than the tolerance, however
/// long a chain of near neighbours is. Vertices that are not finite represent themselves.
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed
[[nodiscard]] std::vector<std::uint32_t> weld_vertices(const std::vector<Vector3> &vertices_m,
                                                       double tolerance_m,
                                                       PreparationAllowance &allowance,
                                                       unsigned threads = 1);

struct ClosedCracks {
    std::vector<std::uint32_t> stands_for; ///< for each vertex the one that replaces it
    std::size_t moved_vertices = 0;
    double largest_move_m = 0.0;
};

/// Welds ends of open edges that lie within the tolerance of each other, the nearest first. No
/// vertex moves by more than the tolerance. Two corners of one triangle are never welded, neither
/// directly nor through others: however fine a mesh, no triangle collapses.
/// @param edges those of `triangles`
/// @param threads the maximum number used; the result is the same for any number
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed
[[nodiscard]] ClosedCracks close_cracks(const std::vector<MeshTriangle> &triangles,
                                        const EdgeTable &edges,
                                        const std::vector<Vector3> &vertices_m, double tolerance_m,
                                        PreparationAllowance &allowance, unsigned threads);

struct SplitEdges {
    std::size_t split_triangles = 0;
    double largest_move_m = 0.0; ///< of a point of an edge
};

/// Routes open edges through the ends of other open edges that lie within the tolerance of their
/// interiors, and divides their triangles accordingly. The pieces are appended to `triangles`,
/// except one that replaces the whole, and keep its index in the soup.
/// @param edges those of `triangles`; no longer valid if anything was split
/// @param threads the maximum number used; the result is the same for any number
/// @pre tolerance_m > 0, threads > 0
/// @throw InputError where it needs more steps than allowed; nothing was divided then
[[nodiscard]] SplitEdges split_edges(std::vector<MeshTriangle> &triangles, const EdgeTable &edges,
                                     const std::vector<Vector3> &vertices_m, double tolerance_m,
                                     PreparationAllowance &allowance, unsigned threads);

} // namespace springdrive::contact
