#include "device/core/phantom/dynamics.h"

#include <cmath>

namespace springdrive::device {

namespace {

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
    // Upper arm and crank turn about the base joint, and their inertia already refers to it: only
    // their weight remains to be added.
    moments.ma_kg_m += inertia.upper_arm.mass_kg * inertia.upper_arm.centre_m;
    moments.mb_kg_m += inertia.crank.mass_kg * inertia.crank.centre_m;
    return moments;
}

LinkSines LinkSines::of(const Vector3 &q_rad) {
    return {std::sin(q_rad[1]), std::cos(q_rad[1]), std::sin(q_rad[2]), std::cos(q_rad[2])};
}

Matrix3 mass_matrix(const LinkageMoments &m, const LinkSines &links) {
    const double s2 = links.sin_q2;
    const double c2 = links.cos_q2;
    const double s3 = links.sin_q3;
    const double c3 = links.cos_q3;
    const double axial = m.base_kg_m2 + m.maa_kg_m2 * c2 * c2 + 2.0 * m.mab_kg_m2 * c2 * s3 +
                         m.mbb_kg_m2 * s3 * s3 + m.with_q2_kg_m2[1] * c2 * c2 +
                         m.with_q2_kg_m2[2] * s2 * s2 + m.with_q3_kg_m2[1] * s3 * s3 +
                         m.with_q3_kg_m2[2] * c3 * c3;
    Matrix3 M = Matrix3::Zero();
    M(0, 0) = axial;
    M.bottomRightCorner<2, 2>() = mass_matrix_of_plane(m, links);
    return M;
}

Eigen::Matrix2d mass_matrix_of_plane(const LinkageMoments &m, const LinkSines &links) {
    const double coupling = m.mab_kg_m2 * links.sin_fold();
    Eigen::Matrix2d M;
    M << m.maa_kg_m2 + m.with_q2_kg_m2[0], coupling, //
        coupling, m.mbb_kg_m2 + m.with_q3_kg_m2[0];
    return M;
}

Vector3 coriolis_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad,
                           const Vector3 &q_rate_rad_per_s) {
    const LinkageSecants<3> slope(q_rad, q_rad);
    const double axial_by_q2 = slope.axial_by_q2(moments);
    const double axial_by_q3 = slope.axial_by_q3(moments);
    const double coupling_by_q3 = slope.coupling_by_q3(moments);
    const Vector3 &w = q_rate_rad_per_s;
    return {w[0] * (axial_by_q2 * w[1] + axial_by_q3 * w[2]),
            coupling_by_q3 * w[2] * w[2] - 0.5 * axial_by_q2 * w[0] * w[0],
            -coupling_by_q3 * w[1] * w[1] - 0.5 * axial_by_q3 * w[0] * w[0]};
}

Vector3 gravity_torque_Nm(const LinkageMoments &moments, const Vector3 &q_rad) {
    return gravity_secant_Nm(moments, q_rad, q_rad);
}

double gravity_energy_J(const LinkageMoments &moments, const Vector3 &q_rad) {
    return kGravity_m_per_s2 *
           (moments.ma_kg_m * std::sin(q_rad[1]) - moments.mb_kg_m * std::cos(q_rad[2]));
}

Matrix3 tip_secant(const PhantomGeometry &geometry, const Vector3 &q_a, const Vector3 &q_b) {
    return LinkageSecants<3>(q_a, q_b).tip(geometry);
}

Matrix3 inertia_secant(const LinkageMoments &moments, const Vector3 &q_a, const Vector3 &q_b,
                       const Vector3 &rate_rad_per_s) {
    return LinkageSecants<3>(q_a, q_b).inertia(moments, rate_rad_per_s);
}

Vector3 gravity_secant_Nm(const LinkageMoments &moments, const Vector3 &q_a, const Vector3 &q_b) {
    return LinkageSecants<3>(q_a, q_b).gravity_Nm(moments);
}

} // namespace springdrive::device
