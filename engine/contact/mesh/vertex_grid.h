// Finds vertices near a point.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace springdrive::contact {

/// Hash table from the cells of a grid to the vertices in them. However many vertices share a cell,
/// inserting one costs the same. It stores tags, parts of the cells' hashes, instead of cells: two
/// cells may share a tag, so the distance decides.
class VertexGrid {
public:
    /// Has room for `vertices_m`, which must outlive it, and none of them yet.
    /// @pre cell_m of at least twice reach_m: points within reach are in at most eight cells
    VertexGrid(const std::vector<Vector3> &vertices_m, double reach_m, double cell_m,
               unsigned threads = 1);

    /// An insertion or a search a few vertices later finds its place in the cache.
    void prefetch(std::uint32_t vertex) const {
        __builtin_prefetch(&slots_[homes_[vertex].address.slot]);
    }

    /// @pre the vertex is not in it yet
    void insert(std::uint32_t vertex) {
        const Address &address = homes_[vertex].address;
        Slot &slot = slots_[address.slot];
        SPRINGDRIVE_ASSERT_AUDIT(std::ranges::none_of(
            entries_of(slot), [vertex](const Entry &entry) { return entry.vertex == vertex; }));
        entries_[slot.first + slot.count++] = {address.tag, vertex};
    }

    /// Inserts all vertices, in ascending order.
    /// @pre it is empty
    void insert_all(unsigned threads);

    /// Calls `visit(other)` for inserted vertices of a lower number within reach of a vertex until
    /// it returns true: first those in its own cell, in each cell in the order of insertion. May
    /// visit a vertex twice. Returns how many were compared.
    /// @pre vertices were inserted in ascending order
    template <typename Visit>
    [[nodiscard]] std::uint64_t visit_earlier(std::uint32_t vertex, const Visit &visit) const {
        std::uint64_t compared = 0;
        const Home &home = homes_[vertex];
        if (visit_cell(home.address, vertex, visit, compared) || !home.is_near_wall) {
            return compared;
        }
        Addresses addresses;
        const std::size_t count = cells_around(vertex, addresses);
        for (std::size_t i = 0; i < count; ++i) {
            if (visit_cell(addresses[i], vertex, visit, compared)) {
                break;
            }
        }
        return compared;
    }

    /// A slot prefetched this many vertices ahead arrives in time.
    static constexpr std::uint32_t kAhead = 16;

private:
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

    /// A range of entries with room for all vertices whose homes are here.
    struct Slot {
        std::uint32_t first = 0;
        std::uint32_t count = 0; ///< inserted
    };

    struct Entry {
        std::uint32_t tag = 0;
        std::uint32_t vertex = 0;
    };

    using Addresses = std::array<Address, 8>;

    /// Calls `visit(vertex)` for all vertices, those of one slot in ascending order and in the same
    /// thread.
    template <typename Visit> void for_each_of_slots(unsigned threads, const Visit &visit);

    [[nodiscard]] Home home_of(std::uint32_t vertex) const;

    /// The cells within reach of a vertex except its own, and their number.
    [[nodiscard]] std::size_t cells_around(std::uint32_t vertex, Addresses &addresses) const;

    [[nodiscard]] Vector3 cell_of(const Vector3 &point_m) const;
    [[nodiscard]] Address address_of(const Vector3 &cell) const;

    [[nodiscard]] std::span<const Entry> entries_of(const Slot &slot) const {
        return std::span(entries_).subspan(slot.first, slot.count);
    }

    template <typename Visit>
    [[nodiscard]] bool visit_cell(const Address &address, std::uint32_t vertex, const Visit &visit,
                                  std::uint64_t &compared) const {
        for (const Entry &entry : entries_of(slots_[address.slot])) {
            if (entry.vertex >= vertex) {
                break;
            }
            ++compared;
            if (entry.tag == address.tag && is_near(entry.vertex, vertex) && visit(entry.vertex)) {
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
    std::vector<Slot> slots_; ///< at least as many as vertices, and a power of two
    std::size_t last_slot_;
    std::vector<Home> homes_; ///< of the vertices
    std::vector<Entry> entries_;
};

} // namespace springdrive::contact
