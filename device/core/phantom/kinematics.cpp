#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <cmath>

namespace springdrive::device {

namespace {

/// Sines, cosines and reach, shared by position and Jacobian.
struct PoseTerms {
    PoseTerms(const PhantomGeometry &g, const Vector3 &q)
        : s1(std::sin(q[0])), c1(std::cos(q[0])), s2(std::sin(q[1])), c2(std::cos(q[1])),
          s3(std::sin(q[2])), c3(std::cos(q[2])), r(g.upper_arm_m * c2 + g.forearm_m * s3) {}

    double s1, c1, s2, c2, s3, c3, r;
};

Vector3 position_m(const PhantomGeometry &g, const PoseTerms &p) {
    return {p.r * p.s1, g.forearm_m - g.forearm_m * p.c3 + g.upper_arm_m * p.s2,
            p.r * p.c1 - g.upper_arm_m};
}

Matrix3 jacobian_m_per_rad(const PhantomGeometry &geometry, const PoseTerms &p) {
    const double l1 = geometry.upper_arm_m;
    const double l2 = geometry.forearm_m;
    Matrix3 jacobian;
    jacobian << p.r * p.c1, -l1 * p.s2 * p.s1, l2 * p.c3 * p.s1, //
        0.0, l1 * p.c2, l2 * p.s3,                               //
        -p.r * p.s1, -l1 * p.s2 * p.c1, l2 * p.c3 * p.c1;
    return jacobian;
}

} // namespace

Vector3 tip_position_m(const PhantomGeometry &geometry, const Vector3 &q_rad) {
    return position_m(geometry, PoseTerms(geometry, q_rad));
}

Matrix3 joint_jacobian(const PhantomGeometry &geometry, const Vector3 &q_rad) {
    return jacobian_m_per_rad(geometry, PoseTerms(geometry, q_rad));
}

TipPlace tip_place(const PhantomGeometry &geometry, const Vector3 &q_rad) {
    const PoseTerms p(geometry, q_rad);
    return {position_m(geometry, p), jacobian_m_per_rad(geometry, p)};
}

Matrix3 motor_jacobian(const PhantomGeometry &geometry, const Vector3 &q_rad) {
    return joint_jacobian(geometry, q_rad) *
           geometry.transmission_ratio.cwiseInverse().asDiagonal();
}

Matrix3 joint_jacobian_rate(const PhantomGeometry &geometry, const Vector3 &q_rad,
                            const Vector3 &q_rate_rad_per_s) {
    const double l1 = geometry.upper_arm_m;
    const double l2 = geometry.forearm_m;
    const PoseTerms p(geometry, q_rad);
    const Vector3 &w = q_rate_rad_per_s;
    const double r_rate = -l1 * p.s2 * w[1] + l2 * p.c3 * w[2];
    Matrix3 rate;
    rate << r_rate * p.c1 - p.r * p.s1 * w[0],           //
        -l1 * (p.c2 * p.s1 * w[1] + p.s2 * p.c1 * w[0]), //
        l2 * (-p.s3 * p.s1 * w[2] + p.c3 * p.c1 * w[0]), //
        0.0, -l1 * p.s2 * w[1], l2 * p.c3 * w[2],        //
        -r_rate * p.s1 - p.r * p.c1 * w[0],              //
        -l1 * (p.c2 * p.c1 * w[1] - p.s2 * p.s1 * w[0]), //
        l2 * (-p.s3 * p.c1 * w[2] - p.c3 * p.s1 * w[0]);
    return rate;
}

std::optional<Vector3> joint_angles_rad(const PhantomGeometry &geometry, const Vector3 &tip_m) {
    const double l1 = geometry.upper_arm_m;
    const double l2 = geometry.forearm_m;
    const double reach = std::hypot(tip_m.x(), tip_m.z() + l1);
    const double height = tip_m.y() - l2;
    // r² + h² = l₁² + l₂² + 2 l₁ l₂ sin(q₃ − q₂)
    const double sine = (reach * reach + height * height - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
    // Written so that NaN is rejected too.
    if (!(std::abs(sine) <= 1.0)) {
        return std::nullopt;
    }
    const double q3_minus_q2 = std::asin(sine);
    const double q1 = reach > 0.0 ? std::atan2(tip_m.x(), tip_m.z() + l1) : 0.0;
    const double q2 =
        std::atan2(height, reach) + std::atan2(l2 * std::cos(q3_minus_q2), l1 + l2 * sine);
    return Vector3(q1, q2, q2 + q3_minus_q2);
}

LinkagePose linkage_pose(const PhantomGeometry &geometry, const Vector3 &q_rad) {
    const PoseTerms p(geometry, q_rad);
    const Vector3 outward(p.s1, 0.0, p.c1);
    const Vector3 up = Vector3::UnitY();
    const Vector3 along_arm = p.c2 * outward + p.s2 * up;
    const Vector3 along_forearm = p.s3 * outward - p.c3 * up;
    LinkagePose pose;
    pose.base_m = Vector3(0.0, geometry.forearm_m, -geometry.upper_arm_m);
    pose.elbow_m = pose.base_m + geometry.upper_arm_m * along_arm;
    pose.tip_m = pose.elbow_m + geometry.forearm_m * along_forearm;
    pose.crank_m = pose.base_m + geometry.crank_m * along_forearm;
    pose.coupling_m = pose.elbow_m + geometry.crank_m * along_forearm;
    return pose;
}

} // namespace springdrive::device
