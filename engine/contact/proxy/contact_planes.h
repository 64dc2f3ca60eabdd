// The proxy's problem without the mesh: given a few planes to stay above, which point above all
// of them is nearest to the tip? A quadratic program in three dimensions, solved exactly.
//
// Zilles and Salisbury (see proxy.h) solve the equations of the Lagrange multipliers for the planes
// that are taken to be active; Ruspini and others pass the program to a general solver. Here every
// set of up to three planes is tried until the Karush-Kuhn-Tucker conditions hold: all multipliers
// positive, no plane violated. So the solution includes which planes are active.
#pragma once

#include "base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace springdrive::contact {

/// The half-space  normal · x >= offset_m  in which the proxy has to stay.
struct ContactPlane {
    Vector3 normal{Vector3::Zero()}; ///< unit, towards the free side
    double offset_m = 0.0;
    std::uint32_t obstacle = 0; ///< what lies behind it, by the numbering of `HapticSurface`

    [[nodiscard]] double height_m(const Vector3 &point_m) const noexcept {
        return normal.dot(point_m) - offset_m;
    }
};

/// A small list of planes without allocation: the three that can hold a point, and one newly met.
class ContactPlanes {
public:
    static constexpr std::size_t kCapacity = 4;

    /// Does nothing when the list is full.
    void add(const ContactPlane &plane) noexcept {
        if (size_ < kCapacity) {
            planes_[size_++] = plane;
        }
    }

    /// Makes it a list of one.
    void keep_only(const ContactPlane &plane) noexcept {
        planes_[0] = plane;
        size_ = 1;
    }

    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    [[nodiscard]] const ContactPlane &operator[](std::size_t i) const noexcept {
        return planes_[i];
    }
    [[nodiscard]] const ContactPlane *begin() const noexcept { return planes_.data(); }
    [[nodiscard]] const ContactPlane *end() const noexcept { return planes_.data() + size_; }

private:
    std::array<ContactPlane, kCapacity> planes_;
    std::size_t size_ = 0;
};

/// A solution, and the planes that constrain it: at most three, with normals that are linearly
/// independent, and x − tip = Σ λᵢ nᵢ with every λᵢ > 0.
struct NearestPoint {
    Vector3 point_m{Vector3::Zero()};
    ContactPlanes active;
};

/// The point above all `planes` that is nearest to `tip_m`. RT-safe.
///
/// Where there is no such point (two planes face each other closer than their clearances allow) the
/// planes above `inside_m` are lowered to it, which makes `inside_m` feasible.
[[nodiscard]] NearestPoint nearest_point(const Vector3 &tip_m, const ContactPlanes &planes,
                                         const Vector3 &inside_m) noexcept;

/// P: the projector onto the directions that are tangential to all of `active`, and the number of
/// directions that they block. Planes less than a microradian apart count as one.
struct AllowedMotion {
    Matrix3 projector{Matrix3::Identity()};
    int blocked_directions = 0;
};
[[nodiscard]] AllowedMotion tangent_projector(const ContactPlanes &active) noexcept;

} // namespace springdrive::contact
