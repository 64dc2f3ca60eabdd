#include "tests/bench/touch_path.h"

#include "engine/lab/rig/scenario/known_shapes.h"
#include "engine/lab/rig/scenario/scanned_surface.h"
#include "engine/lab/rig/scenario/test_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace springdrive::bench {

namespace {

constexpr double kMeanSpeed_m_per_s = 0.1;

/// Over a hole and beside it, as the proxy is not straight above its tip, a tip is lifted to this
/// height, within that angle.
constexpr double kLifted_m = 0.5e-3;
constexpr double kBesideHole_rad = 0.03;
constexpr double kLifting_rad = 0.02;

/// The mean length of the figure on a unit sphere per radian of phase.
double mean_length_per_phase() {
    constexpr int kSteps = 200'000;
    constexpr double kStep = 1e-2;
    double length = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        length += (rig::lissajous_direction((i + 1) * kStep) - rig::lissajous_direction(i * kStep))
                      .norm();
    }
    return length / (kSteps * kStep);
}

double bumpy_radius_m(const Vector3 &direction) {
    const Vector3 phase =
        2.0 * std::numbers::pi / rig::kTestBumpLength_m * rig::kTestSphereRadius_m * direction;
    return rig::kTestSphereRadius_m +
           rig::kTestBumpHeight_m * std::sin(phase.x()) * std::sin(phase.y()) * std::sin(phase.z());
}

double surface_radius_m(Relief relief, const Vector3 &direction) {
    switch (relief) {
    case Relief::smooth:
        break;
    case Relief::bumpy:
        return bumpy_radius_m(direction);
    case Relief::scanned:
        return rig::scanned_body_radius_m(direction);
    case Relief::machined:
        return rig::machined_body_radius_m(direction);
    }
    return rig::kTestSphereRadius_m;
}

/// 0 over a hole and beside it, 1 where none is near.
double pressing(const std::vector<rig::ScanHole> &holes, const Vector3 &direction) {
    double share = 1.0;
    for (const rig::ScanHole &hole : holes) {
        const double angle_rad = std::acos(std::clamp(direction.dot(hole.direction), -1.0, 1.0));
        const double beside_rad = angle_rad - hole.half_angle_rad - kBesideHole_rad;
        share = std::min(share, std::clamp(beside_rad / kLifting_rad, 0.0, 1.0));
    }
    return share;
}

/// Tips at heights over the surface that swing from `low_m` to `high_m`; below it if negative.
std::vector<Vector3> tips_m(Relief relief, const std::vector<Vector3> &directions, double low_m,
                            double high_m) {
    std::vector<Vector3> tips;
    tips.reserve(directions.size());
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const double height_m = rig::swing_m(i, low_m, high_m);
        tips.emplace_back((surface_radius_m(relief, directions[i]) + height_m) * directions[i]);
    }
    return tips;
}

} // namespace

std::vector<Vector3> lissajous_directions(int updates) {
    const double phase_per_tick =
        kMeanSpeed_m_per_s * kServoPeriod_s / (rig::kTestSphereRadius_m * mean_length_per_phase());
    std::vector<Vector3> directions;
    directions.reserve(static_cast<std::size_t>(updates));
    for (int i = 0; i < updates; ++i) {
        directions.push_back(rig::lissajous_direction(phase_per_tick * i));
    }
    return directions;
}

std::vector<Vector3> pressed_tips_m(Relief relief, const std::vector<Vector3> &directions) {
    std::vector<Vector3> tips = tips_m(relief, directions, -2e-3, -1e-3);
    if (relief != Relief::scanned) {
        return tips;
    }
    const std::vector<rig::ScanHole> holes = rig::scan_holes(rig::kTestScanSeed);
    for (std::size_t i = 0; i < tips.size(); ++i) {
        const double share = pressing(holes, directions[i]);
        if (share < 1.0) {
            const double lifted_m = surface_radius_m(relief, directions[i]) + kLifted_m;
            tips[i] = share * tips[i] + (1.0 - share) * lifted_m * directions[i];
        }
    }
    return tips;
}

std::vector<Vector3> free_tips_m(Relief relief, const std::vector<Vector3> &directions) {
    return tips_m(relief, directions, 5e-3, 20e-3);
}

} // namespace springdrive::bench
