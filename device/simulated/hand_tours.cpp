#include "device/simulated/hand_tours.h"

#include "base/degrees.h"
#include "device/core/phantom/kinematics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::simulated {

namespace {

/// By which the hand pulls beyond a stop, so that the tip reaches it against friction and weight.
constexpr double kBeyond_rad = 4.0 * kRadiansPerDegree;
/// Of the joints: at the tip some 0.3 N against a braking device.
constexpr double kSpeed_rad_per_s = 1.6;
constexpr double kStep_rad = 5.0 * kRadiansPerDegree;

/// Angles of the second and third joint with a fold q₃ − q₂, the third as near to 0 as its lower
/// stop allows.
Vector3 folded(double fold_rad, double lowest_q3_rad) {
    const double q3_rad = std::max(0.5 * fold_rad, lowest_q3_rad);
    return {0.0, q3_rad - fold_rad, q3_rad};
}

} // namespace

HandPath calibration_tour(const device::DeviceDescription &device, const Vector3 &start_m,
                          double duration_s) {
    constexpr double kStep_s = 0.02;
    constexpr double kBeginning_s = 2.0;   // to the middle
    constexpr double kShare = 0.22;        // of the workspace, to each side
    const Vector3 period_s(2.6, 3.1, 3.7); // no two in step for long
    const Vector3 amplitude_m = kShare * device.workspace.size_m;
    std::vector<HandPath::Point> points{{0.0, start_m}};
    const long steps = std::lround(duration_s / kStep_s);
    for (long i = 1; i <= steps; ++i) {
        const double time_s = static_cast<double>(i) * kStep_s;
        const double share = std::min(1.0, time_s / kBeginning_s);
        const Vector3 aside_m = (2.0 * std::numbers::pi * time_s * period_s.cwiseInverse())
                                    .array()
                                    .sin()
                                    .matrix()
                                    .cwiseProduct(amplitude_m);
        points.push_back(
            {time_s, start_m + share * (device.workspace.centre_m - start_m + aside_m)});
    }
    return HandPath(std::move(points));
}

std::function<double(double)> calibration_tour_of(HandControl *hand,
                                                  const device::DeviceDescription &device) {
    if (hand == nullptr) {
        return {};
    }
    return [hand, &device](double longest_s) {
        hand->follow(calibration_tour(device, hand->hand_m(), longest_s));
        return longest_s;
    };
}

HandPath stop_tour(const device::DeviceDescription &device, const Vector3 &start_m, double rest_s) {
    const device::JointLimits &limits = device.joint_limits;
    const double clear_rad = limits.min_rad[2] + 2.0 * kRadiansPerDegree;
    const std::vector<Vector3> stops{
        {limits.min_rad[0] - kBeyond_rad, 0.0, 0.0},
        {limits.max_rad[0] + kBeyond_rad, 0.0, 0.0},
        Vector3::Zero(),
        folded(limits.max_q3_minus_q2_rad + kBeyond_rad, clear_rad),
        folded(limits.min_q3_minus_q2_rad - kBeyond_rad, clear_rad),
        Vector3(0.0, limits.min_rad[2], limits.min_rad[2] - kBeyond_rad),
        Vector3::Zero()};
    constexpr double kApproach_s = 1.0;
    Vector3 q_rad = Vector3::Zero();
    std::vector<HandPath::Point> points{
        {0.0, start_m},
        {rest_s, start_m},
        {rest_s + kApproach_s, device::tip_position_m(device.geometry, q_rad)}};
    if (rest_s == 0.0) {
        points.erase(points.begin()); // times increase
    }
    for (const Vector3 &next_rad : stops) {
        const Vector3 way_rad = next_rad - q_rad;
        const double length_rad = way_rad.cwiseAbs().maxCoeff();
        const auto steps = std::max(1L, std::lround(length_rad / kStep_rad));
        const double began_s = points.back().time_s;
        for (long step = 1; step <= steps; ++step) {
            const double share = static_cast<double>(step) / static_cast<double>(steps);
            points.push_back({began_s + share * length_rad / kSpeed_rad_per_s,
                              device::tip_position_m(device.geometry, q_rad + share * way_rad)});
        }
        q_rad = next_rad;
        constexpr double kPressing_s = 0.3;
        points.push_back({points.back().time_s + kPressing_s, points.back().position_m});
    }
    return HandPath(std::move(points));
}

std::function<double(double)> stop_tour_of(HandControl *hand,
                                           const device::DeviceDescription &device) {
    if (hand == nullptr) {
        return {};
    }
    return [hand, &device](double /*longest_s*/) {
        const HandPath tour = stop_tour(device, hand->hand_m());
        hand->follow(tour);
        return tour.end_s();
    };
}

} // namespace springdrive::simulated
