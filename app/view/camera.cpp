#include "app/view/camera.h"

#include "app/view/solids.h"
#include "base/assertions.h"
#include "base/degrees.h"

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace springdrive::app {

namespace {

constexpr double kFieldOfView_rad = 32.0 * kRadiansPerDegree; // vertical
constexpr double kHomeYaw_rad = 24.0 * kRadiansPerDegree;
constexpr double kHomePitch_rad = 22.0 * kRadiansPerDegree;
constexpr double kSteepestPitch_rad = 90.0 * kRadiansPerDegree;
constexpr double kOrbit_rad_per_px = 0.4 * kRadiansPerDegree;
constexpr double kZoomPerStep = 0.9;
constexpr double kNearestZoom = 1.0 / 20.0; // of the framed distance
constexpr double kFarthestZoom = 5.0;

// Relative to the distance, so that the depth buffer's precision scales with the zoom.
constexpr double kNearPlane = 0.02;
constexpr double kFarPlane = 5.0;
constexpr double kFarPlaneBeyond_m = 2.0; // the floor remains visible when zoomed in

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kBeforeThePoints = 0.1; // of their extent in depth
constexpr double kNearestEye_m = 1e-3;

/// How the points and the borders of a part limit the eye along one axis of the view.
class AxisLimits {
public:
    /// @param low, high  offset from the optical axis per depth at the borders
    AxisLimits(const Vector3 &axis, const Vector3 &forward, double low, double high)
        : axis_(axis), forward_(forward), low_(low), high_(high) {}

    void hold(const Vector3 &point_m) {
        const double across_m = point_m.dot(axis_);
        const double depth_m = point_m.dot(forward_);
        min_m_ = std::max(min_m_, across_m - high_ * depth_m);
        max_m_ = std::min(max_m_, across_m - low_ * depth_m);
    }

    /// The eye's largest coordinate along `forward`.
    [[nodiscard]] double nearest_m() const { return (max_m_ - min_m_) / (high_ - low_); }

    /// The eye's coordinate along the axis, for one along `forward`.
    [[nodiscard]] double middle_m(double eye_forward_m) const {
        return (min_m_ + max_m_ + (low_ + high_) * eye_forward_m) / 2.0;
    }

private:
    Vector3 axis_;
    Vector3 forward_;
    double low_;
    double high_;
    double min_m_ = -kInfinite;
    double max_m_ = kInfinite;
};

} // namespace

double Camera::half_height_per_depth() { return std::tan(kFieldOfView_rad / 2.0); }

void Camera::look_from(Viewpoint viewpoint) {
    yaw_rad_ = viewpoint == Viewpoint::home ? kHomeYaw_rad : 0.0;
    pitch_rad_ = viewpoint == Viewpoint::home  ? kHomePitch_rad
                 : viewpoint == Viewpoint::top ? kSteepestPitch_rad
                                               : 0.0;
}

void Camera::place(const Vector3 &eye_m, double distance_m) {
    SPRINGDRIVE_ASSERT(distance_m > 0.0);
    target_m_ = eye_m + distance_m * forward();
    distance_m_ = framed_distance_m_ = distance_m;
}

void Camera::orbit(double dx_px, double dy_px) {
    yaw_rad_ = std::remainder(yaw_rad_ - kOrbit_rad_per_px * dx_px, 2.0 * std::numbers::pi);
    pitch_rad_ =
        std::clamp(pitch_rad_ + kOrbit_rad_per_px * dy_px, -kSteepestPitch_rad, kSteepestPitch_rad);
}

void Camera::pan(double dx_px, double dy_px, double viewport_height_px) {
    const double pixel_m = metres_per_pixel(target_m_, viewport_height_px);
    target_m_ += pixel_m * (dy_px * up() - dx_px * right());
}

void Camera::zoom(double steps, const Vector3 &about_m) {
    const double distance_m =
        std::clamp(distance_m_ * std::pow(kZoomPerStep, steps), kNearestZoom * framed_distance_m_,
                   kFarthestZoom * framed_distance_m_);
    // Eye and target are scaled about the point.
    target_m_ = about_m + distance_m / distance_m_ * (target_m_ - about_m);
    distance_m_ = distance_m;
}

glm::mat4 Camera::view() const {
    return glm::lookAt(to_glm(eye_m()), to_glm(target_m_), to_glm(up()));
}

glm::mat4 Camera::projection(double aspect) const {
    return glm::perspective(static_cast<float>(kFieldOfView_rad), static_cast<float>(aspect),
                            static_cast<float>(kNearPlane * distance_m_),
                            static_cast<float>(kFarPlane * distance_m_ + kFarPlaneBeyond_m));
}

Vector3 Camera::right() const { return {std::cos(yaw_rad_), 0.0, -std::sin(yaw_rad_)}; }

Vector3 Camera::up() const {
    return {-std::sin(pitch_rad_) * std::sin(yaw_rad_), std::cos(pitch_rad_),
            -std::sin(pitch_rad_) * std::cos(yaw_rad_)};
}

Vector3 Camera::forward() const {
    return {-std::cos(pitch_rad_) * std::sin(yaw_rad_), -std::sin(pitch_rad_),
            -std::cos(pitch_rad_) * std::cos(yaw_rad_)};
}

double Camera::metres_per_pixel(const Vector3 &at_m, double viewport_height_px) const {
    return 2.0 * half_height_per_depth() * std::abs(depth_m(at_m)) / viewport_height_px;
}

Vector3 Camera::point_at(const PixelPoint &pixel, const PixelSize &viewport,
                         const Vector3 &at_m) const {
    const double pixel_m = metres_per_pixel(at_m, viewport.height_px);
    const double x_px = pixel.x_px - viewport.width_px / 2.0;
    const double y_px = viewport.height_px / 2.0 - pixel.y_px;
    return eye_m() + depth_m(at_m) * forward() + pixel_m * (x_px * right() + y_px * up());
}

std::optional<PixelPoint> Camera::pixel_of(const Vector3 &point_m,
                                           const PixelSize &viewport) const {
    if (!(depth_m(point_m) > 0.0)) {
        return std::nullopt;
    }
    const double pixel_m = metres_per_pixel(point_m, viewport.height_px);
    const Vector3 offset_m = point_m - eye_m();
    return PixelPoint{viewport.width_px / 2.0 + offset_m.dot(right()) / pixel_m,
                      viewport.height_px / 2.0 - offset_m.dot(up()) / pixel_m};
}

Camera framed(Camera camera, std::span<const Vector3> points_m, const PixelSize &viewport,
              const PixelRectangle &part) {
    SPRINGDRIVE_ASSERT(!points_m.empty());
    SPRINGDRIVE_ASSERT(part.bottom_right.x_px > part.top_left.x_px &&
                       part.bottom_right.y_px > part.top_left.y_px);
    const double slope_per_px = 2.0 * Camera::half_height_per_depth() / viewport.height_px;
    const double middle_x_px = viewport.width_px / 2.0;
    const double middle_y_px = viewport.height_px / 2.0;
    const Vector3 forward = camera.forward();
    AxisLimits across(camera.right(), forward, slope_per_px * (part.top_left.x_px - middle_x_px),
                      slope_per_px * (part.bottom_right.x_px - middle_x_px));
    AxisLimits upwards(camera.up(), forward, slope_per_px * (middle_y_px - part.bottom_right.y_px),
                       slope_per_px * (middle_y_px - part.top_left.y_px));
    double first_m = kInfinite;
    double last_m = -kInfinite;
    for (const Vector3 &point_m : points_m) {
        across.hold(point_m);
        upwards.hold(point_m);
        first_m = std::min(first_m, point_m.dot(forward));
        last_m = std::max(last_m, point_m.dot(forward));
    }
    const double before_m = std::max(kBeforeThePoints * (last_m - first_m), kNearestEye_m);
    const double eye_m = std::min({across.nearest_m(), upwards.nearest_m(), first_m - before_m});
    camera.place(across.middle_m(eye_m) * camera.right() + upwards.middle_m(eye_m) * camera.up() +
                     eye_m * forward,
                 (first_m + last_m) / 2.0 - eye_m);
    return camera;
}

std::array<Vector3, 8> box_corners(const Vector3 &lower_m, const Vector3 &upper_m) {
    std::array<Vector3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        corners[i] = Vector3((i & 1U) != 0 ? upper_m.x() : lower_m.x(),
                             (i & 2U) != 0 ? upper_m.y() : lower_m.y(),
                             (i & 4U) != 0 ? upper_m.z() : lower_m.z());
    }
    return corners;
}

PixelRectangle drawn_part(const Camera &camera, std::span<const Vector3> points_m,
                          const PixelSize &viewport) {
    PixelRectangle part{{kInfinite, kInfinite}, {-kInfinite, -kInfinite}};
    for (const Vector3 &point_m : points_m) {
        if (const std::optional<PixelPoint> pixel = camera.pixel_of(point_m, viewport)) {
            part.top_left.x_px = std::min(part.top_left.x_px, pixel->x_px);
            part.top_left.y_px = std::min(part.top_left.y_px, pixel->y_px);
            part.bottom_right.x_px = std::max(part.bottom_right.x_px, pixel->x_px);
            part.bottom_right.y_px = std::max(part.bottom_right.y_px, pixel->y_px);
        }
    }
    return part;
}

} // namespace springdrive::app
