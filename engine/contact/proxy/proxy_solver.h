// Descends towards a target, in free space and along the surface, until no nearer point can be
// reached: the proxy's constrained minimisation, solved by moving from one set of touching planes
// to the next.
#pragma once

#include "base/assertions.h"
#include "base/vector.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace springdrive::contact {

/// The straight pieces along which a proxy moved in one tick, from its start to its place of rest,
/// with every corner. No piece crosses a surface; a straight line from the first point to the last
/// may, where the path bends around an edge.
class ProxyPath {
public:
    static constexpr std::size_t kCapacity = 128;

    void restart(const Vector3 &at_m) noexcept {
        points_m_[0] = at_m;
        size_ = 1;
    }

    /// @pre not full
    [[gnu::always_inline]] void add(const Vector3 &point_m) noexcept {
        SPRINGDRIVE_ASSERT(size_ < kCapacity);
        points_m_[size_++] = point_m;
    }

    /// Removes all but the first `count` points.
    void cut(std::size_t count) noexcept { size_ = count; }

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] const Vector3 &operator[](std::size_t i) const noexcept { return points_m_[i]; }
    [[nodiscard]] const Vector3 *begin() const noexcept { return points_m_.data(); }
    [[nodiscard]] const Vector3 *end() const noexcept { return points_m_.data() + size_; }

private:
    std::array<Vector3, kCapacity> points_m_;
    std::size_t size_ = 0;
};

/// The budget of one tick, which bounds its time by construction. Most ticks need one to four
/// motions and no node of the tree; an extreme one stops when its budget is exhausted, short of the
/// target but on the right side of every surface, and the next tick continues from there.
struct SolverBudget {
    static constexpr std::size_t kMotions = 96;
    static constexpr int kEffort = 3000; ///< 30 µs
    int motions_left = static_cast<int>(kMotions);
    SearchBudget search{kEffort};

    [[nodiscard]] bool has_any_left() const noexcept {
        return motions_left > 0 && search.effort_left > 0;
    }

    /// A motion besides its search: the goal above its planes, and which of them still touch.
    void take_motion() noexcept {
        constexpr int kMotionEffort = 30;
        --motions_left;
        search.effort_left -= kMotionEffort;
    }
};

/// Where a proxy is, and the planes that hold it there.
struct Rest {
    Vector3 point_m{Vector3::Zero()};
    ContactPlanes held_by; ///< at most three, each touching

    [[nodiscard]] bool is_touching() const noexcept { return held_by.size() > 0; }
};

/// Descents over one surface.
///
/// The free space of a proxy with a reach is what lies at least that far from every obstacle. Where
/// obstacles touch, each leaves a half-space; a point is at rest where the target lies in the cone
/// that the touching planes block (the Karush-Kuhn-Tucker conditions).
class ProxySolver {
public:
    /// @param near a neighbourhood of `surface`, or empty; may be replaced between descents
    ProxySolver(const HapticSurface &surface, const Neighbourhood &near, double reach_m,
                SolverBudget &budget, ProxyPath &path) noexcept
        : surface_(surface), near_(near), reach_m_(reach_m), budget_(budget), path_(path) {}

    /// Moves from `rest`, whose planes may be any that touched there, downhill to the first place
    /// of rest with respect to the target. True if it is reached, false if the budget ran out
    /// first. RT-safe.
    [[nodiscard]] bool solve(Rest &rest, const Vector3 &target_m) const noexcept;

    /// The first stop of a straight motion. RT-safe.
    [[nodiscard]] std::optional<SurfaceStop> first_stop(const Vector3 &from_m,
                                                        const Vector3 &to_m) const noexcept;

private:
    [[nodiscard]] bool is_on_one_shape(const ContactPlanes &planes) const noexcept;
    [[nodiscard]] std::optional<Vector3> above_rest(const ContactPlanes &planes,
                                                    const Vector3 &target_m) const noexcept;
    [[nodiscard]] bool refresh(ContactPlanes &planes, const Vector3 &point_m) const noexcept;
    void move(Rest &rest, const Vector3 &to_m) const noexcept;

    const HapticSurface &surface_;
    const Neighbourhood &near_;
    double reach_m_;
    SolverBudget &budget_;
    ProxyPath &path_;
};

// Where a surface leads downhill from a vertex.
//
// The proxy's clearance rounds off the vertices of a mesh, and where valleys and ridges meet, the
// rounded surface can have a pit although a facet or an edge of the mesh leads on downhill. Such a
// pit is a place of rest in every respect, but as small as the clearance and only some picometres
// deep on a scanned surface. The proxy therefore tries these directions before it rests at a
// vertex.

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

/// Straight motions of one length from one place, and whether they meet some facets, each where its
/// plane touches: these end, and so does what they forbid, unless their planes are taken as
/// endless, which costs little. At a corner most motions do, so this is tried before other facets
/// are.
class MotionsAbove {
public:
    MotionsAbove(const HapticSurface &surface, const ContactPlanes &planes, const Vector3 &from_m,
                 double length_m, bool are_endless) noexcept
        : surface_(surface), planes_(planes), from_m_(from_m), length_m_(length_m),
          are_endless_(are_endless) {
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            heights_m_[i] = planes_[i].height_m(from_m);
        }
    }

    /// Whether the motion in that direction meets none of them.
    [[nodiscard]] bool contain(const Vector3 &direction) const noexcept {
        for (std::size_t i = 0; i < planes_.size(); ++i) {
            const double slope = planes_[i].normal.dot(direction);
            if (heights_m_[i] + length_m_ * slope < 0.0 &&
                (are_endless_ || surface_.shape(planes_[i].obstacle) != nullptr ||
                 surface_.facet(planes_[i].obstacle)
                     .is_over(from_m_ - heights_m_[i] / slope * direction))) {
                return false;
            }
        }
        return true;
    }

    [[nodiscard]] double length_m() const noexcept { return length_m_; }

private:
    const HapticSurface &surface_;
    const ContactPlanes &planes_;
    const Vector3 &from_m_;
    std::array<double, ContactPlanes::kCapacity> heights_m_{};
    double length_m_;
    bool are_endless_;
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
