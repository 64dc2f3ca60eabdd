// Goes down the distance to a target, in free space and along the surface, until nothing nearer can
// be reached: the proxy's constraint problem, solved by moving from one set of touching planes to
// the next.
#pragma once

#include "base/vector.h"
#include "engine/contact/proxy/contact_planes.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/contact/proxy/neighbourhood.h"
#include "engine/contact/proxy/proxy_path.h"

#include <cstddef>
#include <optional>

namespace springdrive::contact {

/// What one tick may cost: what bounds its time by construction. Most ticks need one to four
/// motions and no node of the tree; a wild one ends where its effort does, short of the target but
/// on the right side of every surface, and the next tick goes on from there.
struct Effort {
    static constexpr std::size_t kMotions = 96;
    int motions_left = static_cast<int>(kMotions);
    SearchBudget search{20'000};
};

/// Where a proxy is, and the planes that hold it there.
struct Rest {
    Vector3 point_m{Vector3::Zero()};
    ContactPlanes held_by; ///< at most three, each touching

    [[nodiscard]] bool is_touching() const noexcept { return held_by.size() > 0; }
};

/// One descent after another over the same surface.
///
/// The free space of a proxy with a reach is what lies at least that far from every obstacle. Where
/// obstacles touch, each leaves a half-space; a point is at rest where the target lies in the cone
/// that the touching planes hold back (the conditions of Karush, Kuhn and Tucker).
class Descent {
public:
    /// @param near a neighbourhood of `surface`, or of nothing; may be replaced along the way
    Descent(const HapticSurface &surface, const Neighbourhood &near, double reach_m, Effort &effort,
            ProxyPath &path) noexcept
        : surface_(surface), near_(near), reach_m_(reach_m), effort_(effort), path_(path) {}

    /// Moves from `rest`, whose planes may be any that touched there, to the nearest rest on the
    /// way to the target. True if it is reached, false if the effort ended before. RT-safe.
    [[nodiscard]] bool settle(Rest &rest, const Vector3 &target_m) const noexcept;

    /// What stops a straight motion first. RT-safe.
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
    Effort &effort_;
    ProxyPath &path_;
};

} // namespace springdrive::contact
