// Rigid-body dynamics of the PHANTOM's linkage after Çavuşoğlu, Feygin and Tendick 2002, in joint
// coordinates:
//
//   M(q) q̈ + C(q, q̇) q̇ + g(q) = τ
//
// Every link turns with q₂ or q₃ and the whole plane with q₁, so that a centre of mass lies at
//
//   r = a cos q₂ + b sin q₃  from the axis,      h = a sin q₂ − b cos q₃  above the base joint
//
// with two lengths a, b per link. The equations need only the sums of m a², m a b, m b², m a, m b
// over all links (`LinkageMoments`). A load at the tip is a further link with a = l₁, b = l₂.
//
// Pure functions over values. RT-safe: no allocation, lock, I/O or throw.
#pragma once

#include "base/vector.h"
#include "device/core/phantom/kinematics.h"

#include <cmath>

namespace springdrive::device {

inline constexpr double kGravity_m_per_s2 = 9.80665;

/// The sums over all links that the equations of motion need; symbols as at the top of this file.
struct LinkageMoments {
    double maa_kg_m2 = 0.0; ///< Σ m a²
    double mab_kg_m2 = 0.0; ///< Σ m a b
    double mbb_kg_m2 = 0.0; ///< Σ m b²
    double ma_kg_m = 0.0;   ///< Σ m a, for gravity
    double mb_kg_m = 0.0;   ///< Σ m b, for gravity
    double base_kg_m2 = 0.0;
    Vector3 with_q2_kg_m2{Vector3::Zero()}; ///< inertia of links that turn with q₂, as in LinkBody
    Vector3 with_q3_kg_m2{Vector3::Zero()}; ///< the same with q₃
};

/// @param tip_load_kg  at the tip, instead of `inertia.tip_load_kg`
[[nodiscard]] LinkageMoments linkage_moments(const PhantomGeometry &geometry,
                                             const LinkageInertia &inertia, double tip_load_kg);

/// Orientation of the links in their plane.
struct LinkSines {
    double sin_q2 = 0.0;
    double cos_q2 = 1.0;
    double sin_q3 = 0.0;
    double cos_q3 = 1.0;

    [[nodiscard]] static LinkSines of(const Vector3 &q_rad);

    /// sin(q₃ − q₂).
    [[nodiscard]] double sin_fold() const { return sin_q3 * cos_q2 - cos_q3 * sin_q2; }
};

/// M(q) [kg·m²], symmetric and positive definite. Without the rotors.
[[nodiscard]] Matrix3 mass_matrix(const LinkageMoments &moments, const LinkSines &links);
[[nodiscard]] inline Matrix3 mass_matrix(const LinkageMoments &moments, const Vector3 &q_rad) {
    return mass_matrix(moments, LinkSines::of(q_rad));
}

/// The part of M(q) that belongs to joints 2 and 3.
[[nodiscard]] Eigen::Matrix2d mass_matrix_of_plane(const LinkageMoments &moments,
                                                   const LinkSines &links);

/// C(q, q̇) q̇ [N·m]: Coriolis and centrifugal torques.
[[nodiscard]] Vector3 coriolis_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad,
                                         const Vector3 &q_rate_rad_per_s);

/// g(q) [N·m]: the torques that balance gravity, the gradient of `gravity_energy_J`.
[[nodiscard]] Vector3 gravity_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad);

/// Relative to the linkage with level upper arm and level forearm.
[[nodiscard]] double gravity_energy_J(const LinkageMoments &moments, const Vector3 &q_rad);

// Secants: difference quotients between two configurations a step apart, so that energy is balanced
// exactly over that step. Each equals the derivative if the two coincide, and is accurate to second
// order about their midpoint.

/// J̄ [m/rad] with J̄ (q_b − q_a) = fk(q_b) − fk(q_a).
[[nodiscard]] Matrix3 tip_secant(const PhantomGeometry &geometry, const Vector3 &q_a,
                                 const Vector3 &q_b);

/// Γ [kg·m²/s] with (q_b − q_a)ᵀ Γ v = ½ uᵀ (M(q_b) − M(q_a)) v for every v; u = `rate_rad_per_s`.
[[nodiscard]] Matrix3 inertia_secant(const LinkageMoments &moments, const Vector3 &q_a,
                                     const Vector3 &q_b, const Vector3 &rate_rad_per_s);

/// ḡ [N·m] with ḡᵀ (q_b − q_a) = the difference in `gravity_energy_J`.
[[nodiscard]] Vector3 gravity_secant_Nm(const LinkageMoments &moments, const Vector3 &q_a,
                                        const Vector3 &q_b);

// The same secants, all for the same two configurations, so that sines and cosines are computed
// once: for three joints, or for joints 2 and 3 while the base is at rest.

/// Vectors over the last `joints` joints: joints 2 and 3 if there are two.
template <int joints> using JointVector = Eigen::Matrix<double, joints, 1>;
template <int joints> using JointMatrix = Eigen::Matrix<double, joints, joints>;

/// cos x and sin(x)/x, with x half of an angle's change over a step.
struct HalfTurn {
    explicit HalfTurn(double half_rad) : x_rad(half_rad) {
        // Truncated after x⁶, the series are exact to round-off: the next term is x⁸/40320 < 1e-20.
        constexpr double kSmall_rad = 0.01;
        if (std::abs(x_rad) < kSmall_rad) {
            const double y = x_rad * x_rad;
            cos = 1.0 - y * (1.0 / 2 - y * (1.0 / 24 - y * (1.0 / 720)));
            sinc = 1.0 - y * (1.0 / 6 - y * (1.0 / 120 - y * (1.0 / 5040)));
        } else {
            cos = std::cos(x_rad);
            sinc = std::sin(x_rad) / x_rad;
        }
    }

    double x_rad;
    double cos = 1.0;
    double sinc = 1.0;
};

/// Sine and cosine of an angle that changes from a to b: difference quotients and means of the end
/// values, by the sum formulas, so that no digits cancel if a and b are close.
class AngleSecant {
public:
    AngleSecant(double a, double b)
        : sin_middle_(std::sin(0.5 * (a + b))), cos_middle_(std::cos(0.5 * (a + b))),
          half_(0.5 * (b - a)) {}

    /// The secant of the angle from one to the other.
    [[nodiscard]] static AngleSecant between(const AngleSecant &one, const AngleSecant &other) {
        return {other.sin_middle_ * one.cos_middle_ - other.cos_middle_ * one.sin_middle_,
                other.cos_middle_ * one.cos_middle_ + other.sin_middle_ * one.sin_middle_,
                HalfTurn(other.half_.x_rad - one.half_.x_rad)};
    }

    [[nodiscard]] double sin_slope() const { return cos_middle_ * half_.sinc; }
    [[nodiscard]] double cos_slope() const { return -sin_middle_ * half_.sinc; }
    [[nodiscard]] double mean_sin() const { return sin_middle_ * half_.cos; }
    [[nodiscard]] double mean_cos() const { return cos_middle_ * half_.cos; }
    /// Slope of sin²; that of cos² is its negative.
    [[nodiscard]] double square_slope() const { return 2.0 * mean_sin() * sin_slope(); }

    [[nodiscard]] double sin_b() const { return mean_sin() + half_.x_rad * sin_slope(); }
    [[nodiscard]] double cos_b() const { return mean_cos() + half_.x_rad * cos_slope(); }

private:
    AngleSecant(double sin_middle, double cos_middle, const HalfTurn &half)
        : sin_middle_(sin_middle), cos_middle_(cos_middle), half_(half) {}

    double sin_middle_;
    double cos_middle_;
    HalfTurn half_;
};

/// Secants of the links within their plane.
class PlaneSecants {
public:
    PlaneSecants(const Vector3 &q_a, const Vector3 &q_b)
        : two_(q_a[1], q_b[1]), three_(q_a[2], q_b[2]), fold_(AngleSecant::between(two_, three_)) {}

    [[nodiscard]] const AngleSecant &two() const { return two_; }
    [[nodiscard]] const AngleSecant &three() const { return three_; }

    /// The links at q_b.
    [[nodiscard]] LinkSines end() const {
        return {two_.sin_b(), two_.cos_b(), three_.sin_b(), three_.cos_b()};
    }

    /// Slope of M₂₃ with respect to q₃; with respect to q₂ it is the negative.
    [[nodiscard]] double coupling_by_q3(const LinkageMoments &m) const {
        return m.mab_kg_m2 * fold_.sin_slope();
    }
    /// ḡ of joints 2 and 3; the base has none.
    [[nodiscard]] JointVector<2> gravity_Nm(const LinkageMoments &m) const {
        return {kGravity_m_per_s2 * m.ma_kg_m * two_.sin_slope(),
                -kGravity_m_per_s2 * m.mb_kg_m * three_.cos_slope()};
    }

private:
    AngleSecant two_;
    AngleSecant three_;
    AngleSecant fold_;
};

/// `tip` is J̄ [m/rad], `inertia` Γ [kg·m²/s] and `gravity_Nm` ḡ, as defined above; `end`
/// gives the links at q_b.
template <int joints> class LinkageSecants;

/// Two joints: the tip moves outward in the links' plane and up, the base is at rest.
template <> class LinkageSecants<2> {
public:
    LinkageSecants(const Vector3 &q_a, const Vector3 &q_b) : plane_(q_a, q_b) {}

    [[nodiscard]] JointMatrix<2> tip(const PhantomGeometry &geometry) const {
        const double l1 = geometry.upper_arm_m;
        const double l2 = geometry.forearm_m;
        JointMatrix<2> secant;
        secant << l1 * plane_.two().cos_slope(), l2 * plane_.three().sin_slope(), //
            l1 * plane_.two().sin_slope(), -l2 * plane_.three().cos_slope();
        return secant;
    }
    [[nodiscard]] JointMatrix<2> inertia(const LinkageMoments &m,
                                         const JointVector<2> &rate_rad_per_s) const {
        const JointVector<2> u = 0.5 * plane_.coupling_by_q3(m) * rate_rad_per_s;
        JointMatrix<2> secant;
        secant << -u[1], -u[0], u[1], u[0];
        return secant;
    }
    [[nodiscard]] JointVector<2> gravity_Nm(const LinkageMoments &m) const {
        return plane_.gravity_Nm(m);
    }
    [[nodiscard]] LinkSines end() const { return plane_.end(); }

private:
    PlaneSecants plane_;
};

/// All three joints, the tip in space.
template <> class LinkageSecants<3> {
public:
    LinkageSecants(const Vector3 &q_a, const Vector3 &q_b)
        : one_(q_a[0], q_b[0]), plane_(q_a, q_b) {}

    [[nodiscard]] Matrix3 tip(const PhantomGeometry &geometry) const {
        const double l1 = geometry.upper_arm_m;
        const double l2 = geometry.forearm_m;
        const AngleSecant &two = plane_.two();
        const AngleSecant &three = plane_.three();
        const double mean_r = l1 * two.mean_cos() + l2 * three.mean_sin();
        const double r_by_q2 = l1 * two.cos_slope();
        const double r_by_q3 = l2 * three.sin_slope();
        Matrix3 secant;
        secant << mean_r * one_.sin_slope(), one_.mean_sin() * r_by_q2,
            one_.mean_sin() * r_by_q3,                          //
            0.0, l1 * two.sin_slope(), -l2 * three.cos_slope(), //
            mean_r * one_.cos_slope(), one_.mean_cos() * r_by_q2, one_.mean_cos() * r_by_q3;
        return secant;
    }
    [[nodiscard]] Matrix3 inertia(const LinkageMoments &m, const Vector3 &rate_rad_per_s) const {
        const double by_q2 = axial_by_q2(m);
        const double by_q3 = axial_by_q3(m);
        const double coupling = plane_.coupling_by_q3(m);
        const Vector3 &u = rate_rad_per_s;
        Matrix3 secant;
        secant << 0.0, 0.0, 0.0,                              //
            by_q2 * u[0], -coupling * u[2], -coupling * u[1], //
            by_q3 * u[0], coupling * u[2], coupling * u[1];
        return 0.5 * secant;
    }
    [[nodiscard]] Vector3 gravity_Nm(const LinkageMoments &m) const {
        const JointVector<2> in_plane = plane_.gravity_Nm(m);
        return {0.0, in_plane[0], in_plane[1]};
    }
    [[nodiscard]] LinkSines end() const { return plane_.end(); }

    /// Slopes of M₁₁ with respect to q₂ and q₃; its derivatives if the configurations coincide.
    [[nodiscard]] double axial_by_q2(const LinkageMoments &m) const {
        return -(m.maa_kg_m2 + m.with_q2_kg_m2[1] - m.with_q2_kg_m2[2]) *
                   plane_.two().square_slope() +
               2.0 * m.mab_kg_m2 * plane_.two().cos_slope() * plane_.three().mean_sin();
    }
    [[nodiscard]] double axial_by_q3(const LinkageMoments &m) const {
        return (m.mbb_kg_m2 + m.with_q3_kg_m2[1] - m.with_q3_kg_m2[2]) *
                   plane_.three().square_slope() +
               2.0 * m.mab_kg_m2 * plane_.two().mean_cos() * plane_.three().sin_slope();
    }
    [[nodiscard]] double coupling_by_q3(const LinkageMoments &m) const {
        return plane_.coupling_by_q3(m);
    }

private:
    AngleSecant one_;
    PlaneSecants plane_;
};

} // namespace springdrive::device
