#include "device/phantom/dynamics.h"

#include <cmath>

namespace springdrive {

namespace {

/// sin(x)/x.
double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(x) / x; }

/// Sine and cosine of an angle that goes from a to b: their difference quotients and the means of
/// their end values, by the sum formulas, so that nothing cancels where a and b are close.
class AngleSecant {
public:
    AngleSecant(double a, double b)
        : sin_middle_(std::sin(0.5 * (a + b))), cos_middle_(std::cos(0.5 * (a + b))),
          cos_half_(std::cos(0.5 * (b - a))), sinc_half_(sinc(0.5 * (b - a))) {}

    [[nodiscard]] double sin_slope() const { return cos_middle_ * sinc_half_; }
    [[nodiscard]] double cos_slope() const { return -sin_middle_ * sinc_half_; }
    [[nodiscard]] double mean_sin() const { return sin_middle_ * cos_half_; }
    [[nodiscard]] double mean_cos() const { return cos_middle_ * cos_half_; }
    /// Of sin²; that of cos² is its negative.
    [[nodiscard]] double square_slope() const { return 2.0 * mean_sin() * sin_slope(); }

private:
    double sin_middle_;
    double cos_middle_;
    double cos_half_;
    double sinc_half_;
};

/// How M changes from one configuration to the next; where they meet, its derivative.
struct InertiaSlopes {
    double axial_by_q2 = 0.0; ///< M₁₁
    double axial_by_q3 = 0.0;
    double coupling_by_q3 = 0.0; ///< M₂₃, and its negative by q₂
};

InertiaSlopes inertia_slopes(const LinkageMoments &m, const Vector3 &q_a, const Vector3 &q_b) {
    const AngleSecant two(q_a[1], q_b[1]);
    const AngleSecant three(q_a[2], q_b[2]);
    const AngleSecant fold(q_a[2] - q_a[1], q_b[2] - q_b[1]);
    InertiaSlopes slopes;
    slopes.axial_by_q2 =
        -(m.maa_kg_m2 + m.with_q2_kg_m2[1] - m.with_q2_kg_m2[2]) * two.square_slope() +
        2.0 * m.mab_kg_m2 * two.cos_slope() * three.mean_sin();
    slopes.axial_by_q3 =
        (m.mbb_kg_m2 + m.with_q3_kg_m2[1] - m.with_q3_kg_m2[2]) * three.square_slope() +
        2.0 * m.mab_kg_m2 * two.mean_cos() * three.sin_slope();
    slopes.coupling_by_q3 = m.mab_kg_m2 * fold.sin_slope();
    return slopes;
}

void add_mass(LinkageMoments &moments, double mass_kg, double a_m, double b_m) {
    moments.maa_kg_m2 += mass_kg * a_m * a_m;
    moments.mab_kg_m2 += mass_kg * a_m * b_m;
    moments.mbb_kg_m2 += mass_kg * b_m * b_m;
    moments.ma_kg_m += mass_kg * a_m;
    moments.mb_kg_m += mass_kg * b_m;
}

} // namespace

LinkageMoments linkage_moments(const PhantomGeometry &geometry, const LinkageInertia &inertia,
                               double tip_load_kg) {
    LinkageMoments moments;
    add_mass(moments, inertia.rod.mass_kg, inertia.rod.centre_m, geometry.crank_m);
    add_mass(moments, inertia.forearm.mass_kg, geometry.upper_arm_m, inertia.forearm.centre_m);
    add_mass(moments, tip_load_kg, geometry.upper_arm_m, geometry.forearm_m);
    moments.base_kg_m2 = inertia.base_kg_m2;
    moments.with_q2_kg_m2 = inertia.upper_arm.inertia_kg_m2 + inertia.rod.inertia_kg_m2;
    moments.with_q3_kg_m2 = inertia.crank.inertia_kg_m2 + inertia.forearm.inertia_kg_m2;
    // Upper arm and crank turn about the base joint, to which their inertia refers already: what
    // is left of their mass is its weight.
    moments.ma_kg_m += inertia.upper_arm.mass_kg * inertia.upper_arm.centre_m;
    moments.mb_kg_m += inertia.crank.mass_kg * inertia.crank.centre_m;
    return moments;
}

Matrix3 mass_matrix(const LinkageMoments &m, const Vector3 &q_rad) {
    const double s2 = std::sin(q_rad[1]);
    const double c2 = std::cos(q_rad[1]);
    const double s3 = std::sin(q_rad[2]);
    const double c3 = std::cos(q_rad[2]);
    const double coupling = m.mab_kg_m2 * std::sin(q_rad[2] - q_rad[1]);
    const double axial = m.base_kg_m2 + m.maa_kg_m2 * c2 * c2 + 2.0 * m.mab_kg_m2 * c2 * s3 +
                         m.mbb_kg_m2 * s3 * s3 + m.with_q2_kg_m2[1] * c2 * c2 +
                         m.with_q2_kg_m2[2] * s2 * s2 + m.with_q3_kg_m2[1] * s3 * s3 +
                         m.with_q3_kg_m2[2] * c3 * c3;
    Matrix3 M;
    M << axial, 0.0, 0.0,                                //
        0.0, m.maa_kg_m2 + m.with_q2_kg_m2[0], coupling, //
        0.0, coupling, m.mbb_kg_m2 + m.with_q3_kg_m2[0];
    return M;
}

Vector3 coriolis_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad,
                           const Vector3 &q_rate_rad_per_s) {
    const InertiaSlopes slope = inertia_slopes(moments, q_rad, q_rad);
    const Vector3 &w = q_rate_rad_per_s;
    return {w[0] * (slope.axial_by_q2 * w[1] + slope.axial_by_q3 * w[2]),
            slope.coupling_by_q3 * w[2] * w[2] - 0.5 * slope.axial_by_q2 * w[0] * w[0],
            -slope.coupling_by_q3 * w[1] * w[1] - 0.5 * slope.axial_by_q3 * w[0] * w[0]};
}

Vector3 gravity_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad) {
    return gravity_secant_Nm(moments, q_rad, q_rad);
}

double gravity_energy_J(const LinkageMoments &moments, const Vector3 &q_rad) {
    return kGravity_m_per_s2 *
           (moments.ma_kg_m * std::sin(q_rad[1]) - moments.mb_kg_m * std::cos(q_rad[2]));
}

Matrix3 tip_secant(const PhantomGeometry &geometry, const Vector3 &q_a, const Vector3 &q_b) {
    const double l1 = geometry.upper_arm_m;
    const double l2 = geometry.forearm_m;
    const AngleSecant one(q_a[0], q_b[0]);
    const AngleSecant two(q_a[1], q_b[1]);
    const AngleSecant three(q_a[2], q_b[2]);
    const double mean_r = l1 * two.mean_cos() + l2 * three.mean_sin();
    const double r_by_q2 = l1 * two.cos_slope();
    const double r_by_q3 = l2 * three.sin_slope();
    Matrix3 secant;
    secant << mean_r * one.sin_slope(), one.mean_sin() * r_by_q2, one.mean_sin() * r_by_q3, //
        0.0, l1 * two.sin_slope(), -l2 * three.cos_slope(),                                 //
        mean_r * one.cos_slope(), one.mean_cos() * r_by_q2, one.mean_cos() * r_by_q3;
    return secant;
}

Matrix3 inertia_secant(const LinkageMoments &moments, const Vector3 &q_a, const Vector3 &q_b,
                       const Vector3 &rate_rad_per_s) {
    const InertiaSlopes slope = inertia_slopes(moments, q_a, q_b);
    const Vector3 &u = rate_rad_per_s;
    Matrix3 secant;
    secant << 0.0, 0.0, 0.0, //
        slope.axial_by_q2 * u[0], -slope.coupling_by_q3 * u[2], -slope.coupling_by_q3 * u[1],
        slope.axial_by_q3 * u[0], slope.coupling_by_q3 * u[2], slope.coupling_by_q3 * u[1];
    return 0.5 * secant;
}

Vector3 gravity_secant_Nm(const LinkageMoments &moments, const Vector3 &q_a, const Vector3 &q_b) {
    return {0.0, kGravity_m_per_s2 * moments.ma_kg_m * AngleSecant(q_a[1], q_b[1]).sin_slope(),
            -kGravity_m_per_s2 * moments.mb_kg_m * AngleSecant(q_a[2], q_b[2]).cos_slope()};
}

} // namespace springdrive
