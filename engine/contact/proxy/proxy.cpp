#include "engine/contact/proxy/proxy.h"

#include "engine/contact/mesh/mesh_preparation.h"
#include "engine/contact/proxy/proxy_solver.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

namespace springdrive::contact {

namespace {

/// On a step to a nearer place of rest, the proxy may move away from the tip by up to this [m]: a
/// third of what the device resolves. Facets of a smooth shape leave such low ridges between them,
/// and edges that do not quite meet leave such steps.
constexpr double kLowRidge_m = 1e-5;

/// Maximum number of steps in a tick, over a ridge or out of a pit, to a nearer place of rest.
constexpr int kMaxJumps = 14;

// A tick's path never overflows: every motion adds at most one point, a step out of a pit and
// friction two more each.
static_assert(ProxyPath::kCapacity >= 1 + SolverBudget::kMotions + std::size_t{2} * kMaxJumps + 2);

/// A place counts as nearer if it is nearer by more than this, which is above round-off [m].
constexpr double kNearer_m = 1e-12;

/// A step over a ridge that ends this near to its aim has arrived [m].
constexpr double kArrived_m = 1e-9;

/// Maximum length of a step over a ridge [m]. The neighbourhood covers this distance, or half of it
/// where facets are so fine that it cannot hold more.
constexpr double kMaxJump_m = 2e-4;

/// The first two motions out of a pit at a vertex [m]: away from the tip, and then along the
/// surface, to where the clearance's rounding of the vertex has no effect.
constexpr double kDetour_m = 30.0 * kClearance_m;
static_assert(kDetour_m <= kLowRidge_m);

/// The same amid facets so small that no list of ordinary size has room for them, as in the middle
/// of a graded fan, and the radius within which they are listed for these motions.
constexpr double kShortDetour_m = 10.0 * kClearance_m;
constexpr double kShortDetourRadius_m = 1.6 * kShortDetour_m;
static_assert(kShortDetourRadius_m > std::numbers::sqrt2 * kShortDetour_m + kClearance_m);

/// Facets within this belong to the vertex [m].
constexpr double kVertex_m = 3.0 * kClearance_m;

/// A pit is searched again for ways out that facets' ends leave once the tip has moved by more than
/// this multiple of its distance: the force has turned by a degree.
constexpr double kTurned = 0.02;

/// Normals with a smaller sine between them share no line with a reliable direction.
constexpr double kMinSine = 1e-6;

/// Of an update after many that could not move.
constexpr int kMaxEffort = 100 * SolverBudget::kEffort;

/// Radius of the neighbourhood [m]: initial, minimum besides the proxy's reach, and maximum.
constexpr double kInitialSearchRadius_m = 1e-3;
constexpr double kMinSearchRadius_m = 4e-6;
constexpr double kMaxSearchRadius_m = 0.5;

/// Where the neighbourhood was too small to be of use, how fast it is allowed to be larger again.
constexpr double kRetryGrowth = 1.1;

[[nodiscard]] bool is_usable(const Vector3 &tip_m) noexcept {
    return tip_m.allFinite() && tip_m.cwiseAbs().maxCoeff() < kFarthest_m;
}

// Coulomb friction for a proxy: how far along its frictionless path it moves.
//
// The force on the tip has to lie in the friction cone about the normal, which at a distance N from
// the tip is a circle of radius μ N about the frictionless point: Zilles and Salisbury (see
// proxy.h), and W. Harwin and N. Melder, "Improved haptic rendering for multi-finger manipulation
// using friction cone based god-objects", 2002. There the god-object moves to the nearest point of
// that circle; here it stops where its own path over the surface enters it, which is the same on a
// plane, and never leaves the surface at an edge or a bend.

/// A point of a path, and whether friction holds the proxy there.
struct FrictionStop {
    std::size_t piece = 0; ///< the point lies between points `piece` and `piece + 1` of the path
    Vector3 point_m{Vector3::Zero()};
    bool sticks = false; ///< at the first point: it has not moved
};

/// Where a proxy with friction stops on the path of one without.
///
/// The path's end is N from the tip, along the force without friction; a proxy that lags by t makes
/// a force at an angle of atan(t/N) to that. It sticks as long as t <= μ N, with the static
/// coefficient if it stuck before and the dynamic one if it was sliding; otherwise it slides on to
/// where t = μ N with the dynamic one. RT-safe.
///
/// @param first index of the point at which it was, or first touched
/// @param normal_m  N
[[nodiscard]] FrictionStop stop_by_friction(const ProxyPath &path, std::size_t first,
                                            double normal_m, const SurfaceMaterial &material,
                                            bool was_sliding) noexcept {
    const Vector3 &end_m = path[path.size() - 1];
    const double sticking = was_sliding ? material.dynamic_friction : material.static_friction;
    const double behind_m = (path[first] - end_m).norm();
    if (behind_m <= sticking * normal_m) {
        return {first, path[first], true};
    }
    // From the end backwards to the piece that crosses the sphere of radius μ N about the end.
    const double left_m = material.dynamic_friction * normal_m;
    std::size_t piece = path.size() - 1;
    while (piece > first && (path[piece] - end_m).squaredNorm() <= left_m * left_m) {
        --piece;
    }
    if (piece == path.size() - 1) {
        return {piece, end_m, false};
    }
    const Vector3 start = path[piece] - end_m;
    const Vector3 way = path[piece + 1] - path[piece];
    const double a = way.squaredNorm();
    const double b = start.dot(way);
    const double c = start.squaredNorm() - left_m * left_m;
    const double share = (-b - std::sqrt(std::max(0.0, b * b - a * c))) / a;
    return {piece, path[piece] + std::clamp(share, 0.0, 1.0) * way, false};
}

void set_touched_point(const SurfacePoint &touched, Contact &contact) noexcept {
    contact.surface_m = touched.point_m;
    contact.barycentric = touched.barycentric;
    contact.triangle = touched.triangle;
    contact.material = touched.material;
}

/// The contact of a proxy that touches nothing.
[[nodiscard]] Contact free_contact(const Vector3 &point_m) noexcept {
    Contact contact;
    contact.x0_m = point_m;
    return contact;
}

/// The same for a proxy held by its planes, at least one.
[[nodiscard]] Contact resting_contact(const HapticSurface &surface, const Vector3 &tip_m,
                                      const Rest &rest) noexcept {
    const AllowedMotion motion = tangent_projector(rest.held_by);
    const ContactPlane &first = rest.held_by[0];
    const Vector3 gap = rest.point_m - tip_m;
    const double gap_m = gap.norm();
    Contact contact;
    contact.touching = true;
    contact.x0_m = rest.point_m;
    contact.tangent_projector = motion.projector;
    contact.normal = gap_m > kLostByRoundOff_m ? Vector3(gap / gap_m) : first.normal;
    contact.active_constraints = motion.blocked_directions;
    for (const ContactPlane &plane : rest.held_by) {
        contact.eta = std::min(contact.eta, surface.material(plane.obstacle).eta);
    }
    set_touched_point(surface.nearest(first.obstacle, rest.point_m), contact);
    return contact;
}

/// The same where it has come to rest at the end of a slide over a shape.
[[nodiscard]] Contact resting_contact(const HapticSurface &surface, std::uint32_t shape_obstacle,
                                      const ShapeSlide &slide, double reach_m) noexcept {
    Contact contact;
    contact.touching = true;
    contact.x0_m = slide.rest_m;
    contact.tangent_projector -= slide.normal * slide.normal.transpose();
    contact.normal = slide.normal;
    contact.active_constraints = 1;
    contact.eta = surface.material(shape_obstacle).eta;
    set_touched_point(surface.point_on_shape(shape_obstacle, slide.rest_m - reach_m * slide.normal),
                      contact);
    return contact;
}

} // namespace

Proxy::Proxy(double radius_m)
    : reach_m_(std::max(radius_m, kClearance_m)),
      search_radius_m_(kInitialSearchRadius_m + reach_m_) {}

void Proxy::reset(const Vector3 &tip_m) noexcept {
    if (is_usable(tip_m)) {
        rest_ = {tip_m, {}};
        sticks_ = slides_ = false;
        last_tip_m_ = tip_m;
        pit_m_.setConstant(NAN);
        effort_ = SolverBudget::kEffort;
    }
}

void Proxy::update_neighbourhood(const HapticSurface &surface, const Vector3 &tip_m,
                                 SolverBudget &budget) noexcept {
    const Vector3 step = tip_m - last_tip_m_;
    const double step_m = step.norm();
    const double jump_m = search_radius_m_ > 4.0 * kMaxJump_m ? kMaxJump_m : 0.5 * kMaxJump_m;
    const double needed_m = reach_m_ + std::max(step_m, jump_m);
    if (near_.surface_serial() == surface.serial() && near_.covers(rest_.point_m, needed_m)) {
        return;
    }
    near_.clear();
    if (rest_.held_by.size() == 0) {
        search_radius_m_ = std::max(search_radius_m_, 2.0 * needed_m);
    } else if (search_radius_m_ < 2.0 * needed_m) {
        search_radius_m_ *= kRetryGrowth;
        return; // too fast among too many facets for a list to be worthwhile
    }
    // Centred ahead of the proxy, so that it lasts; but not so far that it might reach other facets
    // by then.
    constexpr double kMaxAhead_steps = 10.0;
    const double ahead =
        step_m > 0.0 ? std::min(kMaxAhead_steps, 0.85 * (search_radius_m_ - needed_m) / step_m)
                     : 0.0;
    search_neighbourhood(surface, rest_.point_m + ahead * step, budget);
    if (!near_.covers(rest_.point_m, reach_m_)) {
        search_neighbourhood(surface, rest_.point_m, budget); // too many facets ahead to list
    }
}

void Proxy::search_neighbourhood(const HapticSurface &surface, const Vector3 &centre_m,
                                 SolverBudget &budget) noexcept {
    // What is left is for the motions, which do without a list if need be.
    constexpr int kListEffort = SolverBudget::kEffort / 3;
    SearchBudget part{std::min(kListEffort, budget.search.effort_left)};
    budget.search.effort_left -= part.effort_left;
    surface.find_near(centre_m, search_radius_m_, part, near_);
    budget.search.effort_left += part.effort_left;
    // Enough facets to make a list worthwhile, and not so many that it overflows: on a surface
    // their number grows with the square of the radius.
    constexpr double kRequested = 0.35 * Neighbourhood::kCapacity;
    const double seen_m = near_.radius_m() > 0.0 ? near_.radius_m() : 0.5 * search_radius_m_;
    const double growth = std::sqrt(kRequested / std::max(1, near_.size()));
    search_radius_m_ = std::clamp(seen_m * std::clamp(growth, 0.7, 1.5),
                                  reach_m_ + kMinSearchRadius_m, kMaxSearchRadius_m);
}

bool Proxy::moves_freely(const HapticSurface &surface, const Vector3 &tip_m,
                         SolverBudget &budget) const noexcept {
    if (rest_.is_touching() || !near_.covers(rest_.point_m, reach_m_) ||
        !near_.covers(tip_m, reach_m_)) {
        return false;
    }
    const bool is_far_from_shapes =
        near_.size() == 0 &&
        surface.is_clear_of(near_.shapes(), near_, rest_.point_m, tip_m, reach_m_);
    return is_far_from_shapes ||
           !surface.first_stop(near_, rest_.point_m, tip_m, reach_m_, budget.search);
}

/// The result of `move_to_rest` in closed form, where only one face of one shape is involved.
std::optional<ShapeSlide> Proxy::free_slide(const HapticSurface &surface,
                                            const Vector3 &tip_m) const noexcept {
    if (rest_.held_by.size() != 1 || !near_.covers(rest_.point_m, reach_m_)) {
        return std::nullopt;
    }
    return surface.slide_over(rest_.held_by[0].obstacle, near_, rest_.point_m, tip_m, reach_m_);
}

void Proxy::follow(const ShapeSlide &slide) noexcept {
    if (slide.rest_m != rest_.point_m) {
        if (!slide.is_flat) {
            path_.add(slide.over_m);
        }
        path_.add(slide.rest_m);
    }
    rest_.point_m = slide.rest_m;
    rest_.held_by.keep_only(
        {slide.normal, slide.normal.dot(slide.rest_m), rest_.held_by[0].obstacle});
}

bool Proxy::jump_to_nearer_rest(const ProxySolver &solver, const HapticSurface &surface,
                                const Vector3 &tip_m) noexcept {
    const double here_m = (rest_.point_m - tip_m).norm();
    double min_m = here_m - reach_m_ - kNearer_m;
    std::optional<Vector3> aim_m;
    near_.for_each_shallower(tip_m, min_m, [&](std::uint32_t index, double depth_m) noexcept {
        const Facet &facet = surface.facet(index);
        const double side = facet.height_m(tip_m) <= 0.0 ? 1.0 : -1.0;
        const Vector3 rest_m = tip_m + side * (depth_m + reach_m_) * facet.normal();
        if (depth_m < min_m && (rest_m - rest_.point_m).squaredNorm() <= kMaxJump_m * kMaxJump_m &&
            facet.is_over(tip_m)) {
            aim_m = rest_m;
            min_m = depth_m;
        }
    });
    if (!aim_m) {
        return false;
    }
    Rest there = rest_;
    const std::size_t before = path_.size();
    const bool has_settled = solver.solve(there, *aim_m);
    const bool is_low = std::all_of(path_.begin() + before, path_.end(), [&](const Vector3 &point) {
        return (point - tip_m).norm() <= here_m + kLowRidge_m;
    });
    if (!has_settled || !is_low || (there.point_m - *aim_m).norm() > kArrived_m) {
        path_.cut(before);
        return false;
    }
    rest_ = there;
    return true;
}

bool Proxy::leave_along(const Vector3 &motion_m, const Vector3 &above_m, const ProxySolver &solver,
                        const Vector3 &tip_m) noexcept {
    const Vector3 beside_m = above_m + motion_m;
    if (solver.first_stop(above_m, beside_m)) {
        return false;
    }
    // In a pit of the mesh most motions end over its slopes, from where it would slide back; to
    // solve for each would take the whole budget amid hundreds of facets.
    const double max_m = (rest_.point_m - tip_m).norm() - kNearer_m;
    const std::optional<SurfaceStop> landing = solver.first_stop(beside_m, tip_m);
    if (landing && (1.0 - landing->stop.fraction) * (beside_m - tip_m).norm() >= max_m) {
        return false;
    }
    const std::size_t before = path_.size();
    path_.add(above_m);
    path_.add(beside_m);
    Rest there{beside_m, {}};
    if (!solver.solve(there, tip_m) || (there.point_m - tip_m).norm() >= max_m) {
        path_.cut(before);
        return false;
    }
    rest_ = there;
    return true;
}

bool Proxy::leave_vertex(const ProxySolver &solver, const HapticSurface &surface,
                         const Vector3 &tip_m, SolverBudget &budget) noexcept {
    const Vector3 from_tip_m = rest_.point_m - tip_m;
    if (rest_.held_by.size() < 3 || reach_m_ > kClearance_m ||
        from_tip_m.squaredNorm() <= kDetour_m * kDetour_m) {
        return false;
    }
    double detour_m = kDetour_m;
    if (!near_.covers(rest_.point_m, kVertex_m)) {
        // Without a list, each of these motions would take a large part of the budget.
        surface.find_near(rest_.point_m, kShortDetourRadius_m, budget.search, near_,
                          kShortDetourRadius_m);
        if (!near_.covers(rest_.point_m, kVertex_m)) {
            return false;
        }
        detour_m = kShortDetour_m;
    }
    const Vector3 high_m = rest_.point_m + detour_m / from_tip_m.norm() * from_tip_m;
    const bool is_searched =
        rest_.point_m == pit_m_ &&
        (tip_m - pit_tip_m_).squaredNorm() <= kTurned * kTurned * from_tip_m.squaredNorm();
    const MotionsAbove motions(surface, rest_.held_by, high_m, detour_m, is_searched);
    DownhillDirections directions =
        downhill_directions(surface, near_, rest_.point_m, tip_m, kVertex_m, motions);
    // Where surfaces cross, what leads on may be no facet and no edge, but a line between planes.
    for (std::size_t i = 0; i < 3 && !is_searched; ++i) {
        const Vector3 line = rest_.held_by[i].normal.cross(rest_.held_by[(i + 1) % 3].normal);
        const double sine = line.norm();
        const Vector3 along = (line.dot(from_tip_m) < 0.0 ? 1.0 : -1.0) / sine * line;
        if (sine > kMinSine && motions.contain(along)) {
            directions.add(along);
        }
    }
    if (directions.begin() != directions.end()) {
        const std::optional<SurfaceStop> stop = solver.first_stop(rest_.point_m, high_m);
        const Vector3 above_m =
            stop ? Vector3(rest_.point_m + stop->stop.fraction * (high_m - rest_.point_m)) : high_m;
        if (std::ranges::any_of(directions, [&](const Vector3 &direction) {
                return leave_along(detour_m * direction, above_m, solver, tip_m);
            })) {
            return true;
        }
    }
    if (!is_searched && budget.has_any_left()) {
        pit_m_ = rest_.point_m;
        pit_tip_m_ = tip_m;
    }
    return false;
}

bool Proxy::move_to_rest(const ProxySolver &solver, const HapticSurface &surface,
                         const Vector3 &tip_m, SolverBudget &budget) noexcept {
    bool has_settled = solver.solve(rest_, tip_m);
    for (int i = 0; has_settled && rest_.is_touching() && budget.has_any_left(); ++i) {
        if (i == kMaxJumps) {
            return false;
        }
        if (!near_.covers(rest_.point_m, std::max(reach_m_, kVertex_m))) {
            search_neighbourhood(surface, rest_.point_m, budget); // it has moved far
        }
        if (!jump_to_nearer_rest(solver, surface, tip_m) &&
            !leave_vertex(solver, surface, tip_m, budget)) {
            break;
        }
        has_settled = solver.solve(rest_, tip_m);
    }
    return has_settled && budget.has_any_left();
}

void Proxy::apply_friction(const ProxySolver &solver, const Rest &before,
                           const SurfaceMaterial &material, const Vector3 &tip_m) noexcept {
    const std::size_t first = before.is_touching() || path_.size() < 2 ? 0 : 1;
    const double normal_m = (rest_.point_m - tip_m).norm();
    const FrictionStop held = stop_by_friction(path_, first, normal_m, material, slides_);
    sticks_ = held.sticks;
    slides_ = !held.sticks;
    if (held.sticks && first == 0) {
        rest_ = before;
        path_.cut(1);
        return;
    }
    // Where the path leaves the surface over an edge, down to what lies below.
    const std::optional<SurfaceStop> below = solver.first_stop(held.point_m, tip_m);
    if (!below || !below->is_known) {
        sticks_ = slides_ = false; // no friction in this tick
        return;
    }
    path_.cut(held.piece + 1);
    rest_.point_m = held.point_m + below->stop.fraction * (tip_m - held.point_m);
    rest_.held_by = ContactPlanes();
    rest_.held_by.add({below->stop.normal, below->stop.offset_m, below->obstacle});
    path_.add(held.point_m);
    path_.add(rest_.point_m);
}

Contact Proxy::update(const HapticSurface &surface, const Vector3 &tip_m) noexcept {
    path_.restart(rest_.point_m);
    if (!is_usable(tip_m)) {
        return free_contact(rest_.point_m);
    }
    if (surface.serial() != surface_serial_) {
        surface_serial_ = surface.serial();
        rest_.held_by = ContactPlanes(); // planes of another surface do not apply here
        pit_m_.setConstant(NAN);
        sticks_ = slides_ = false;
    }
    SolverBudget budget;
    const int effort = std::exchange(effort_, SolverBudget::kEffort);
    budget.search.effort_left = effort;
    update_neighbourhood(surface, tip_m, budget);
    last_tip_m_ = tip_m;
    if (moves_freely(surface, tip_m, budget)) {
        rest_.point_m = tip_m;
        path_.add(tip_m);
        return free_contact(tip_m);
    }
    const std::optional<ShapeSlide> slide = free_slide(surface, tip_m);
    if (slide && !(surface.material(rest_.held_by[0].obstacle).static_friction > 0.0)) {
        follow(*slide);
        return resting_contact(surface, rest_.held_by[0].obstacle, *slide, reach_m_);
    }
    const Rest before = rest_;
    bool has_settled = true;
    const ProxySolver solver(surface, near_, reach_m_, budget, path_);
    if (slide) {
        follow(*slide);
    } else {
        has_settled = move_to_rest(solver, surface, tip_m, budget);
        if (!has_settled && rest_.point_m == before.point_m) {
            // Where hundreds of facets meet, more is needed to find any way.
            effort_ = std::min(2 * effort, kMaxEffort);
        }
    }
    if (!rest_.is_touching()) {
        // A proxy that stopped in mid-air when the budget ran out exerts no force either.
        sticks_ = slides_ = false;
        Contact contact = free_contact(rest_.point_m);
        contact.settled = has_settled;
        return contact;
    }
    const SurfaceMaterial &material = surface.material(rest_.held_by[0].obstacle);
    if (material.static_friction > 0.0) {
        apply_friction(solver, before, material, tip_m);
    }
    Contact contact = resting_contact(surface, tip_m, rest_);
    contact.settled = has_settled;
    if (sticks_ && material.static_friction > 0.0) {
        contact.sticking = true;
        contact.tangent_projector.setZero();
    }
    return contact;
}

} // namespace springdrive::contact
