// Where a surface leads downhill from a vertex.
//
// The proxy's clearance rounds off the vertices of a mesh, and where valleys and ridges meet, the
// rounded surface can have a pit although a facet or an edge of the mesh leads on downhill. Such a
// pit is a place of rest in every respect, but as small as the clearance and only some picometres
// deep on a scanned surface. The proxy therefore tries these directions before it rests at a
// vertex.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/neighbourhood.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace springdrive::contact {

/// A list of unit vectors.
class DownhillDirections {
public:
    static constexpr std::size_t kCapacity = 32;

    /// Does nothing for a direction that is listed, or when the list is full.
    void add(const Vector3 &direction) noexcept {
        const bool is_listed = std::any_of(begin(), end(), [&](const Vector3 &other) {
            return (direction - other).squaredNorm() < 1e-20;
        });
        if (!is_listed && size_ < kCapacity) {
            directions_[size_++] = direction;
        }
    }

    [[nodiscard]] const Vector3 *begin() const noexcept { return directions_.data(); }
    [[nodiscard]] const Vector3 *end() const noexcept { return directions_.data() + size_; }

private:
    std::array<Vector3, kCapacity> directions_;
    std::size_t size_ = 0;
};

/// Straight motions of one length from one place, and whether they end above some planes. At a
/// corner few do, so this is tried before the facets are.
class MotionsAbove {
public:
    MotionsAbove(const ContactPlanes &planes, const Vector3 &from_m, double length_m) noexcept
        : planes_(planes), length_m_(length_m) {
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            heights_m_[i] = planes_[i].height_m(from_m);
        }
    }

    /// Whether the motion in that direction is one of them.
    [[nodiscard]] bool contain(const Vector3 &direction) const noexcept {
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            if (heights_m_[i] + length_m_ * planes_[i].normal.dot(direction) < 0.0) {
                return false;
            }
        }
        return true;
    }

    [[nodiscard]] double length_m() const noexcept { return length_m_; }

private:
    const ContactPlanes &planes_;
    std::array<double, ContactPlanes::kCapacity> heights_m_{};
    double length_m_;
};

/// Of the facets of `near` that come within `within_m` of a point: where their planes lead towards
/// the target, if the first of that, as long as the motions, is over the same facet or, at a rim,
/// over none; and their edges that lead towards it and continue for that long. Only directions that
/// the motions contain; none where the mesh itself has a pit. RT-safe.
/// @pre `near` covers the point
[[nodiscard]] DownhillDirections
downhill_directions(const HapticSurface &surface, const Neighbourhood &near, const Vector3 &point_m,
                    const Vector3 &target_m, double within_m, const MotionsAbove &motions) noexcept;

} // namespace springdrive::contact
