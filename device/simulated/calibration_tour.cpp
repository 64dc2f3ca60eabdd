#include "device/simulated/calibration_tour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace springdrive::simulated {

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

} // namespace springdrive::simulated
