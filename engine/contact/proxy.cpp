#include "engine/contact/proxy.h"

#include "engine/contact/contact_planes.h"

#include <algorithm>
#include <optional>

namespace springdrive {

namespace {

/// Beyond this no tip can be [m]: a value to refuse, not to compute with.
constexpr double kFarthestTip_m = 1e3;

/// What is left of the clearance when the proxy is lifted to have all of it again [m]. More than a
/// rim, so that a proxy that comes over an edge from one face passes beside the rim of the other.
constexpr double kLeastClearance_m = 0.5 * kClearance_m;
static_assert(kRim_m < kLeastClearance_m);

/// A proxy that would move less is where it belongs, and does not move [m]. In a pit of many facets
/// it would go on for long by a few nanometres at a time.
constexpr double kSettled_m = 1e-8;

/// A proxy held back this near to its goal needs no motion, and so no sweep [m].
constexpr double kAtGoal_m = 1e-11;

/// What one tick may cost. Most need three sweeps and no lift; this bounds the time of a wild one,
/// and the next tick goes on from where it ended.
struct Effort {
    int sweeps_left = 128;
    int lifts_left = 2; ///< see plane_above

    /// Enough for another slide: one cut short ends where its planes do not hold it yet.
    [[nodiscard]] bool lasts() const noexcept { return sweeps_left > 16; }
};

[[nodiscard]] bool is_usable(const Vector3 &tip_m) noexcept {
    return tip_m.allFinite() && tip_m.cwiseAbs().maxCoeff() < kFarthestTip_m;
}

/// The plane to stay above because of a facet that stops the proxy, on the side the proxy is on.
///
/// It is raised by the clearance, or by as much less as the proxy has: a proxy that no plane
/// lifts never moves away from the tip, and so comes to rest also where six facets meet in a
/// saddle and their raised planes do not. One that has lost half of its clearance is lifted to
/// get all of it back, as long as the effort lasts.
[[nodiscard]] ContactPlane plane_above(const Facet &facet, const Vector3 &proxy_m,
                                       Effort &effort) noexcept {
    const double height_m = facet.height_m(proxy_m);
    const double side = facet.sides() == FacetSides::two && height_m < 0.0 ? -1.0 : 1.0;
    const double kept_m = side * height_m;
    const bool is_lifted = kept_m < kLeastClearance_m && effort.lifts_left-- > 0;
    const double clearance_m = is_lifted ? kClearance_m : std::min(kept_m, kClearance_m);
    // The plane's own offset is minus the height of the origin.
    return {side * facet.normal(), clearance_m - side * facet.height_m(Vector3::Zero()),
            facet.triangle()};
}

[[nodiscard]] bool holds(const ContactPlanes &planes, std::uint32_t triangle) noexcept {
    return std::ranges::any_of(
        planes, [triangle](const ContactPlane &plane) { return plane.triangle == triangle; });
}

/// One slide from `proxy_m` towards the tip, along the planes in `held_by` to begin with. Keeps
/// only planes that hold it back: every new one then raises the least distance to the tip, so that
/// the slide cannot go round in circles. Adds all that it meets to `met`. Returns where it ends,
/// and the planes that hold it there.
[[nodiscard]] NearestPoint slide(const HapticSurface &mesh, const Vector3 &tip_m, Vector3 proxy_m,
                                 const ContactPlanes &held_by, ContactPlanes &met,
                                 Effort &effort) noexcept {
    NearestPoint goal = nearest_point(tip_m, held_by, proxy_m);
    while (effort.sweeps_left-- > 0) {
        if (goal.active.size() > 0 && (goal.point_m - proxy_m).norm() < kAtGoal_m) {
            break;
        }
        const std::optional<SurfaceHit> hit = mesh.first_hit(proxy_m, goal.point_m);
        if (!hit) {
            proxy_m = goal.point_m;
            break;
        }
        if (holds(goal.active, hit->facet->triangle())) {
            break; // by round-off: the goal lies above this plane
        }
        const ContactPlane plane = plane_above(*hit->facet, proxy_m, effort);
        proxy_m += hit->fraction * (goal.point_m - proxy_m);
        if (!holds(met, plane.triangle)) {
            met.add(plane);
        }
        ContactPlanes planes = goal.active;
        planes.add(plane);
        goal = nearest_point(tip_m, planes, proxy_m);
    }
    return {proxy_m, goal.active};
}

[[nodiscard]] Contact free_at(const Vector3 &point_m) noexcept {
    Contact contact;
    contact.x0_m = point_m;
    return contact;
}

[[nodiscard]] Contact contact_of(const HapticSurface &mesh, const Vector3 &tip_m,
                                 const Vector3 &proxy_m, const ContactPlanes &active) noexcept {
    const AllowedMotion motion = allowed_motion(active);
    const Vector3 gap = proxy_m - tip_m;
    const double gap_m = gap.norm();
    Contact contact;
    contact.touching = true;
    contact.x0_m = proxy_m;
    contact.allowed_motion = motion.projector;
    contact.normal = gap_m > kRoundOff_m ? Vector3(gap / gap_m) : active[0].normal;
    contact.active_constraints = motion.blocked_directions;
    contact.triangle = active[0].triangle;
    for (const ContactPlane &plane : active) {
        contact.eta = std::min(contact.eta, mesh.eta(plane.triangle));
    }
    return contact;
}

} // namespace

void Proxy::reset(const Vector3 &tip_m) noexcept {
    if (is_usable(tip_m)) {
        position_m_ = tip_m;
    }
}

Contact Proxy::update(const HapticSurface &mesh, const Vector3 &tip_m) noexcept {
    if (!is_usable(tip_m)) {
        return free_at(position_m_);
    }
    Effort effort;
    ContactPlanes active;
    // Where facets meet in a saddle, planes that hold the proxy when met in one order let it go in
    // another. So it rests only if it also stays when it starts along any one that it met here.
    ContactPlanes met;
    std::size_t tried = 0;
    while (effort.lasts() && (tried == 0 || tried < met.size())) {
        ContactPlanes first;
        if (tried > 0) {
            first.add(met[tried]);
        }
        const NearestPoint end = slide(mesh, tip_m, position_m_, first, met, effort);
        if (end.active.size() == 0) {
            position_m_ = end.point_m;
            return free_at(position_m_);
        }
        const bool has_moved = (end.point_m - position_m_).norm() > kSettled_m;
        if (has_moved || tried == 0) {
            active = end.active;
        }
        ++tried;
        if (has_moved) {
            position_m_ = end.point_m;
            met = ContactPlanes();
            tried = 0;
        }
    }
    return contact_of(mesh, tip_m, position_m_, active);
}

} // namespace springdrive
