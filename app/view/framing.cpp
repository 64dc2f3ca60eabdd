#include "app/view/framing.h"

#include "app/view/gl_vector.h"
#include "base/assertions.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace springdrive::app {

namespace {

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

std::vector<Vector3> drawn_points(std::span<const Solid> solids) {
    std::vector<Vector3> points_m;
    for (const Solid &solid : solids) {
        for (const scene::VisualVertex &vertex : unit_shape(solid.shape).vertices) {
            const auto &[x, y, z] = vertex.position_m;
            points_m.push_back(to_vector3(glm::vec3(solid.model * glm::vec4(x, y, z, 1.0F))));
        }
    }
    return points_m;
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
