// Divides a run of boxes into up to eight, for one node of a BoxTree: by the surface-area heuristic
// (a box is searched about as often as its surface is large) with binned centres.
#pragma once

#include "engine/contact/bvh/box_node.h"
#include "engine/contact/bvh/numbered_box.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace springdrive::contact {

/// Neighbours in the list of all boxes, and what holds them.
struct BoxRun {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    Bounds bounds;        ///< of the boxes [m]
    Bounds twice_centres; ///< of their centres [2 m]
};

/// As many runs as a node has lanes or fewer, one behind the other.
struct BoxFork {
    std::array<BoxRun, kBoxLanes> runs;
    std::size_t size = 0;
};

enum class SplitRule : std::uint8_t {
    surface_area,
    halves, ///< by number: no run stays larger than half, rounded up
};

class BoxSplitter {
public:
    /// @param boxes  reordered by `fork`
    /// @param gap_m  added to a box's edges where their area counts, so that points, lines and
    ///               planes are told apart too
    BoxSplitter(std::span<NumberedBox> boxes, float gap_m) noexcept
        : boxes_(boxes), gap_m_(gap_m) {}

    [[nodiscard]] BoxRun run(std::uint32_t first, std::uint32_t count) const noexcept;

    /// Divides a run into two runs or more, or into its items if they fit into one node. May be
    /// called for several runs at a time if they do not overlap.
    [[nodiscard]] BoxFork fork(const BoxRun &whole, SplitRule rule) const;

private:
    /// A wall between two bins.
    struct Wall {
        int axis = -1;
        int bin = 0; ///< the first above the wall
        float cost = std::numeric_limits<float>::infinity();
    };

    [[nodiscard]] float half_area(const Bounds &bounds) const noexcept;
    [[nodiscard]] Wall cheapest_wall(const BoxRun &whole) const noexcept;
    [[nodiscard]] std::uint32_t reorder(const BoxRun &whole, const Wall &wall) const noexcept;
    [[nodiscard]] std::uint32_t reorder_in_halves(const BoxRun &whole) const;
    void split(BoxFork &fork, std::size_t index, SplitRule rule) const;
    void open(BoxFork &fork, std::size_t index) const noexcept;

    std::span<NumberedBox> boxes_;
    float gap_m_;
};

} // namespace springdrive::contact
