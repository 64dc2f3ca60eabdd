// Finds vertices near a point.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace springdrive::contact {

/// Hash table from the cells of a grid to the vertices in them, with open addressing. It stores
/// tags, parts of the cells' hashes, instead of cells: two cells may share a tag, so the distance
/// decides.
class VertexGrid {
public:
    /// For any subset of `vertices_m`, which must outlive it.
    /// @pre cell_m of at least twice reach_m: points within reach are in at most eight cells
    VertexGrid(const std::vector<Vector3> &vertices_m, double reach_m, double cell_m);

    /// Where to look for the vertices of a cell.
    struct Address {
        std::uint32_t slot = 0;
        std::uint32_t tag = 0;
    };

    /// The cell that a vertex is in.
    struct Home {
        Address address;
        bool is_near_wall = false; ///< points within reach of the vertex may be in other cells
    };
    [[nodiscard]] Home home_of(std::uint32_t vertex) const;

    void prefetch(const Home &home) const { __builtin_prefetch(&slots_[home.address.slot]); }

    /// @pre the vertex is not in it yet
    void insert(std::uint32_t vertex, const Home &home) {
        std::size_t slot = home.address.slot;
        while (slots_[slot].vertex != kNone) {
            SPRINGDRIVE_ASSERT_AUDIT(slots_[slot].vertex != vertex);
            slot = (slot + 1) & last_slot_;
        }
        slots_[slot] = {home.address.tag, vertex};
    }

    /// Calls `visit(other)` for inserted vertices within reach of a vertex until it returns true.
    /// Returns whether it did. May visit a vertex twice.
    template <typename Visit>
    [[nodiscard]] bool visit_near(std::uint32_t vertex, const Home &home, Visit visit) const {
        if (visit_cell(home.address, vertex, visit)) {
            return true;
        }
        if (!home.is_near_wall) {
            return false;
        }
        Addresses addresses;
        const std::size_t count = cells_around(vertex, addresses);
        for (std::size_t i = 0; i < count; ++i) {
            if (visit_cell(addresses[i], vertex, visit)) {
                return true;
            }
        }
        return false;
    }

private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    struct Slot {
        std::uint32_t tag = 0;
        std::uint32_t vertex = kNone;
    };

    using Addresses = std::array<Address, 8>;

    /// The cells within reach of a vertex except its own, and their number.
    [[nodiscard]] std::size_t cells_around(std::uint32_t vertex, Addresses &addresses) const;

    [[nodiscard]] Vector3 cell_of(const Vector3 &point_m) const;
    [[nodiscard]] Address address_of(const Vector3 &cell) const;

    template <typename Visit>
    [[nodiscard]] bool visit_cell(const Address &address, std::uint32_t vertex,
                                  Visit &visit) const {
        for (std::size_t i = address.slot; slots_[i].vertex != kNone; i = (i + 1) & last_slot_) {
            if (slots_[i].tag == address.tag && is_near(slots_[i].vertex, vertex) &&
                visit(slots_[i].vertex)) {
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] bool is_near(std::uint32_t a, std::uint32_t b) const {
        return (vertices_m_[a] - vertices_m_[b]).squaredNorm() <= reach_m_ * reach_m_;
    }

    const std::vector<Vector3> &vertices_m_;
    double reach_m_;
    double cells_per_m_;
    std::vector<Slot> slots_; ///< at least half of them free, and a power of two
    std::size_t last_slot_;
};

} // namespace springdrive::contact
