// Descends towards a target, in free space and along the surface, until no nearer point can be
// reached: the proxy's constrained minimisation, solved by moving from one set of touching planes
// to the next.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/neighbourhood.h"
#include "engine/contact/proxy/proxy_path.h"

#include <cstddef>
#include <optional>

namespace springdrive::contact {

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

} // namespace springdrive::contact
