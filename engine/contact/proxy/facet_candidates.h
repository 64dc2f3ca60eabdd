// Facets found near a place, as many as fit into a neighbourhood.
#pragma once

#include "engine/contact/proxy/neighbourhood.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::contact {

/// Collects indices only, before the facets themselves are read. Where there are too many, the ball
/// shrinks.
class FacetCandidates {
public:
    // Entries beyond size_ are never read. NOLINTNEXTLINE(cppcoreguidelines-pro-type-member-init)
    FacetCandidates(double radius_m, double min_radius_m, std::size_t capacity) noexcept
        : squared_radius_m2_(radius_m * radius_m),
          min_squared_radius_m2_(min_radius_m * min_radius_m), capacity_(capacity) {}

    void add(std::uint32_t index, double squared_distance_m2) noexcept {
        while (size_ == capacity_ && squared_distance_m2 <= squared_radius_m2_ && is_useful()) {
            squared_radius_m2_ *= 0.5;
            shrink();
        }
        if (squared_distance_m2 <= squared_radius_m2_ && size_ < capacity_) {
            found_[size_++] = {index, squared_distance_m2};
        }
    }

    /// Whether it is listed already; as near as its nearest part then.
    [[nodiscard]] bool comes_nearer(std::uint32_t index, double squared_distance_m2) noexcept {
        for (std::size_t i = 0; i < size_; ++i) {
            if (found_[i].index == index) {
                found_[i].squared_distance_m2 =
                    std::min(found_[i].squared_distance_m2, squared_distance_m2);
                return true;
            }
        }
        return false;
    }

    [[nodiscard]] double squared_radius_m2() const noexcept { return squared_radius_m2_; }

    /// Whether the ball is large enough to be useful.
    [[nodiscard]] bool is_useful() const noexcept {
        return squared_radius_m2_ >= min_squared_radius_m2_;
    }

    template <typename Visit> void for_each(const Visit &visit) const noexcept {
        for (std::size_t i = 0; i < size_; ++i) {
            visit(found_[i].index);
        }
    }

private:
    struct Found {
        std::uint32_t index;
        double squared_distance_m2;
    };

    void shrink() noexcept {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            if (found_[i].squared_distance_m2 <= squared_radius_m2_) {
                found_[kept++] = found_[i];
            }
        }
        size_ = kept;
    }

    double squared_radius_m2_;
    double min_squared_radius_m2_;
    std::size_t capacity_;
    std::size_t size_ = 0;
    std::array<Found, Neighbourhood::kCapacity> found_;
};

} // namespace springdrive::contact
