#include "engine/contact/proxy/contact_planes.h"

#include "engine/contact/mesh/facet.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace springdrive::contact {

namespace {

/// A solution may lie this far below a plane [m]: round-off of the arithmetic.
constexpr double kExact_m = 1e-12;

/// The same where planes are so nearly parallel that their line of intersection is ill-conditioned,
/// and one of them has to represent both [m]. A hundredth of the proxy's clearance.
constexpr double kTolerable_m = 0.01 * kClearance_m;

/// Sine of the angle below which that is so.
constexpr double kParallel = 1e-7;

/// Sine of the angle below which planes count as one for motion control.
constexpr double kOneFace = 1e-6;

/// The nearest point on the intersection of one to three planes, built up one plane at a time by
/// Gram-Schmidt:  n_k = Σ_j r_jk q_j,  x = tip + Σ_k y_k q_k,  Rᵀ y = deficits.
class ActiveSet {
public:
    explicit ActiveSet(Vector3 tip_m) noexcept : point_m_(std::move(tip_m)) {}

    /// This set and one more plane. False, and unusable, if the plane is nearly parallel to the
    /// directions that the set blocks already.
    [[nodiscard]] bool add(const ContactPlane &plane) noexcept {
        Vector3 rest = plane.normal;
        for (int j = 0; j < size_; ++j) {
            R_(j, size_) = Q_.col(j).dot(plane.normal);
            rest -= R_(j, size_) * Q_.col(j);
        }
        const double sine = rest.norm();
        if (sine < kParallel) {
            return false;
        }
        Q_.col(size_) = rest / sine;
        R_(size_, size_) = sine;
        // Along the new direction only: the earlier planes stay satisfied.
        y_m_[size_] = -plane.height_m(point_m_) / sine;
        point_m_ += y_m_[size_] * Q_.col(size_);
        ++size_;
        return true;
    }

    /// The least of the multipliers (R λ = y), or one of them that is not positive: then a plane
    /// would have to pull the point down. Without planes, infinite.
    [[nodiscard]] double min_push_m() const noexcept {
        double min_m = std::numeric_limits<double>::infinity();
        Vector3 lambda = Vector3::Zero();
        for (int k = size_ - 1; k >= 0; --k) {
            double rest = y_m_[k];
            for (int j = k + 1; j < size_; ++j) {
                rest -= R_(k, j) * lambda[j];
            }
            lambda[k] = rest / R_(k, k);
            min_m = std::min(min_m, lambda[k]);
            if (!(lambda[k] > 0.0)) {
                return lambda[k];
            }
        }
        return min_m;
    }

    /// The volume that the normals span: no larger than the sine between any of them and the plane
    /// of the others.
    [[nodiscard]] double volume() const noexcept {
        double volume = 1.0;
        for (int k = 0; k < size_; ++k) {
            volume *= R_(k, k);
        }
        return volume;
    }

    [[nodiscard]] const Vector3 &point_m() const noexcept { return point_m_; }

private:
    Vector3 point_m_;
    Matrix3 Q_{Matrix3::Zero()};
    Matrix3 R_{Matrix3::Zero()};
    Vector3 y_m_{Vector3::Zero()};
    int size_ = 0;
};

/// How far a point lies below the planes [m].
[[nodiscard]] double violation_of(const ContactPlanes &planes, const Vector3 &point_m) noexcept {
    double violation_m = 0.0;
    for (const ContactPlane &plane : planes) {
        violation_m = std::max(violation_m, -plane.height_m(point_m));
    }
    return violation_m;
}

/// The solution where all planes are active, as those that held the proxy before usually still are,
/// and clearly so: nothing where `Search` might find a smaller set.
///
/// Where a set without plane k is exact to ε, x its point and x* that of all planes, then
/// ½|x − x*|² <= ε Σ λ over the missing planes, by the Lagrangian at x*, and |x − x*| >= λₖ sₖ with
/// the sine sₖ between nₖ and the plane of the others. So λₖ sₖ² <= 6 ε for the largest of them.
[[nodiscard]] std::optional<Vector3> nearest_on_all(const Vector3 &tip_m,
                                                    const ContactPlanes &planes) noexcept {
    ActiveSet set(tip_m);
    for (const ContactPlane &plane : planes) {
        if (!set.add(plane)) {
            return std::nullopt;
        }
    }
    constexpr double kClear_m = 10.0 * kExact_m;
    const bool is_clear = set.min_push_m() * set.volume() * set.volume() > kClear_m &&
                          violation_of(planes, set.point_m()) <= kExact_m;
    return is_clear ? std::optional(set.point_m()) : std::nullopt;
}

/// Tries every set of up to three planes, small sets first: the solution is the set whose planes
/// all push and whose point lies above all other planes.
class Search {
public:
    Search(const Vector3 &tip_m, const ContactPlanes &planes) noexcept
        : tip_m_(tip_m), planes_(planes) {
        const std::size_t count = planes.size();
        consider({});
        for (std::size_t i = 0; i < count; ++i) {
            consider({&planes[i], 1});
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = i + 1; j < count; ++j) {
                consider(std::array{planes[i], planes[j]});
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = i + 1; j < count; ++j) {
                for (std::size_t k = j + 1; k < count; ++k) {
                    consider(std::array{planes[i], planes[j], planes[k]});
                }
            }
        }
    }

    [[nodiscard]] bool found() const noexcept { return violation_m_ <= kTolerable_m; }
    [[nodiscard]] const NearestPoint &best() const noexcept { return best_; }

private:
    void consider(std::span<const ContactPlane> planes) noexcept {
        if (violation_m_ <= kExact_m) {
            return;
        }
        ActiveSet set(tip_m_);
        for (const ContactPlane &plane : planes) {
            if (!set.add(plane)) {
                return;
            }
        }
        if (!(set.min_push_m() > 0.0)) {
            return;
        }
        const double violation_m = violation_of(planes_, set.point_m());
        if (violation_m < violation_m_) {
            violation_m_ = violation_m;
            best_.point_m = set.point_m();
            best_.active = ContactPlanes();
            for (const ContactPlane &plane : planes) {
                best_.active.add(plane);
            }
        }
    }

    const Vector3 &tip_m_;
    const ContactPlanes &planes_;
    NearestPoint best_;
    double violation_m_ = std::numeric_limits<double>::infinity();
};

} // namespace

NearestPoint nearest_point(const Vector3 &tip_m, const ContactPlanes &planes,
                           const Vector3 &inside_m) noexcept {
    // Most calls have no plane or one.
    if (planes.size() == 0) {
        return {tip_m, {}};
    }
    if (planes.size() == 1) {
        const double depth_m = -planes[0].height_m(tip_m);
        return depth_m > 0.0 ? NearestPoint{tip_m + depth_m * planes[0].normal, planes}
                             : NearestPoint{tip_m, {}};
    }
    if (planes.size() <= 3) {
        if (const std::optional<Vector3> point_m = nearest_on_all(tip_m, planes)) {
            return {*point_m, planes};
        }
    }
    const Search search(tip_m, planes);
    if (search.found()) {
        return search.best();
    }
    ContactPlanes lowered;
    for (ContactPlane plane : planes) {
        plane.offset_m += std::min(0.0, plane.height_m(inside_m));
        lowered.add(plane);
    }
    const Search second_search(tip_m, lowered);
    if (second_search.found()) {
        return second_search.best();
    }
    // Not reached in exact arithmetic. Staying is always allowed.
    NearestPoint stay{inside_m, {}};
    for (std::size_t i = 0; i < std::min<std::size_t>(3, planes.size()); ++i) {
        stay.active.add(lowered[i]);
    }
    return stay;
}

AllowedMotion tangent_projector(const ContactPlanes &active) noexcept {
    AllowedMotion motion;
    for (const ContactPlane &plane : active) {
        const Vector3 rest = motion.projector * plane.normal;
        const double sine = rest.norm();
        if (sine > kOneFace && motion.blocked_directions < 3) {
            const Vector3 blocked = rest / sine;
            motion.projector -= blocked * blocked.transpose();
            ++motion.blocked_directions;
        }
    }
    if (motion.blocked_directions == 3) {
        motion.projector.setZero();
    }
    return motion;
}

} // namespace springdrive::contact
