#include "engine/scene/scripted_touch.h"

#include "engine/contact/proxy/proxy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

namespace springdrive::scene {

namespace {

/// Room left about a box for a tip to be free in.
constexpr double kRoom_m = 0.01;

/// A chord of 60° comes nearer to the middle than its ends by this factor, cos 30°.
constexpr double kNearestOfChord = 0.866;

} // namespace

SurfaceProbe::SurfaceProbe(const contact::HapticSurface &surface, const Eigen::AlignedBox3d &box,
                           double radius_m)
    : surface_(surface), box_(box), radius_m_(radius_m),
      far_m_((0.5 * box.diagonal().norm() + radius_m + kRoom_m) / kNearestOfChord) {}

std::optional<Vector3> SurfaceProbe::first_touch(const Vector3 &from_m, const Vector3 &to_m) const {
    contact::Proxy proxy(radius_m_);
    proxy.reset(from_m);
    static_cast<void>(proxy.update(surface_, to_m));
    // It goes straight until something stops it, and only then along the surface.
    if (proxy.path().size() < 2 || proxy.path()[1] == to_m) {
        return std::nullopt;
    }
    return proxy.path()[1];
}

std::optional<Vector3> SurfaceProbe::touch_from(const Vector3 &direction) const {
    return first_touch(outside(direction), middle_m());
}

namespace {

/// Room left above a box for a tip to be free in.
constexpr double kRoomAbove_m = 0.015;

/// Where a tip that sinks straight down at (x, z) first touches, if it does.
std::optional<Vector3> first_contact(const contact::HapticSurface &mesh, const Vector3 &lower_m,
                                     const Vector3 &upper_m, double x_m, double z_m) {
    constexpr int kSteps = 200;
    const double top_m = upper_m.y() + 0.5 * kRoomAbove_m;
    contact::Proxy proxy;
    proxy.reset(Vector3(x_m, top_m, z_m));
    for (int i = 1; i <= kSteps; ++i) {
        const Vector3 tip_m(x_m, top_m + (lower_m.y() - top_m) * i / kSteps, z_m);
        if (proxy.update(mesh, tip_m).touching) {
            return tip_m;
        }
    }
    return std::nullopt;
}

/// The first contact nearest to the middle of the box, on rings about it.
std::optional<Vector3> contact_near_middle(const contact::HapticSurface &mesh,
                                           const Vector3 &lower_m, const Vector3 &upper_m) {
    const Vector3 middle_m = 0.5 * (lower_m + upper_m);
    const Vector3 half_m = 0.5 * (upper_m - lower_m);
    for (int ring = 0; ring < 8; ++ring) {
        const int points = ring == 0 ? 1 : 6 * ring;
        for (int i = 0; i < points; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / points;
            const double reach = ring / 8.0;
            const std::optional<Vector3> contact = first_contact(
                mesh, lower_m, upper_m, middle_m.x() + reach * half_m.x() * std::cos(angle),
                middle_m.z() + reach * half_m.z() * std::sin(angle));
            if (contact) {
                return contact;
            }
        }
    }
    return std::nullopt;
}

/// Where a tip that sinks straight down onto a circle about `centre_m` first touches, by angle.
class CircleOverSurface {
public:
    CircleOverSurface(const contact::HapticSurface &mesh, const Vector3 &lower_m,
                      const Vector3 &upper_m, const Vector3 &centre_m, double radius_m)
        : centre_m_(centre_m), radius_m_(radius_m) {
        for (std::size_t i = 0; i < kPoints; ++i) {
            const Vector3 around_m = at(2.0 * std::numbers::pi * static_cast<double>(i) / kPoints);
            const std::optional<Vector3> contact =
                first_contact(mesh, lower_m, upper_m, around_m.x(), around_m.z());
            // Over a hole or a cliff the hand keeps the height of the middle.
            const double drop_m = contact ? centre_m.y() - contact->y() : 0.0;
            height_m_[i] = centre_m.y() - (std::abs(drop_m) < radius_m ? drop_m : 0.0);
        }
    }

    [[nodiscard]] Vector3 at(double angle) const {
        const double turns = angle / (2.0 * std::numbers::pi);
        const double place = (turns - std::floor(turns)) * kPoints;
        const auto index = static_cast<std::size_t>(place) % kPoints;
        const double share = place - std::floor(place);
        const double height_m =
            (1.0 - share) * height_m_[index] + share * height_m_[(index + 1) % kPoints];
        return {centre_m_.x() + radius_m_ * std::sin(angle), height_m,
                centre_m_.z() + radius_m_ * std::cos(angle)};
    }

private:
    static constexpr std::size_t kPoints = 64;

    Vector3 centre_m_;
    double radius_m_;
    std::array<double, kPoints> height_m_{};
};

} // namespace

Vector3 start_above(const device::DeviceDescription &device, const Vector3 &lower_m,
                    const Vector3 &upper_m) {
    const Vector3 above_m(0.5 * (lower_m.x() + upper_m.x()), upper_m.y() + kRoomAbove_m,
                          0.5 * (lower_m.z() + upper_m.z()));
    return device::can_reach(device, above_m) ? above_m : device.workspace.centre_m;
}

std::vector<device::PathPoint> scripted_touch(const device::DeviceDescription &device,
                                              const contact::HapticSurface &mesh,
                                              const Vector3 &lower_m, const Vector3 &upper_m,
                                              const ScriptedTouch &how) {
    const Vector3 start_m = start_above(device, lower_m, upper_m);
    const Vector3 middle_m = 0.5 * (lower_m + upper_m);
    const Vector3 contact_m = contact_near_middle(mesh, lower_m, upper_m)
                                  .value_or(Vector3(middle_m.x(), upper_m.y(), middle_m.z()));
    if (!device::can_reach(device, contact_m)) {
        return {{0.0, start_m}};
    }
    const double radius_m =
        std::min(0.015, 0.12 * std::min(upper_m.x() - lower_m.x(), upper_m.z() - lower_m.z()));
    const CircleOverSurface circle(mesh, lower_m, upper_m, contact_m, radius_m);
    const Vector3 depth_m = how.depth_m * Vector3::UnitY();

    const double pressed_s = how.wait_s + how.approach_s;
    std::vector<device::PathPoint> points{
        {0.0, start_m},
        {how.wait_s, start_m},
        {how.wait_s + 0.5 * how.approach_s, contact_m + 0.01 * Vector3::UnitY()},
        {pressed_s, contact_m - depth_m},
    };
    // Out to the circle within half a second, then round it; straight pieces of 10 ms.
    const double turn_rate = how.speed_m_per_s / std::max(radius_m, 1e-3);
    constexpr double kPiece_s = 0.01;
    for (double t = kPiece_s; pressed_s + t < how.duration_s; t += kPiece_s) {
        const double outward = std::min(1.0, 2.0 * t);
        points.push_back({pressed_s + t, (1.0 - outward) * contact_m +
                                             outward * circle.at(turn_rate * t) - depth_m});
    }
    return points;
}

} // namespace springdrive::scene
