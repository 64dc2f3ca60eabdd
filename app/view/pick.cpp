#include "app/view/pick.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <array>

namespace springdrive::app {

namespace {

Vector3 corner_of(const scene::VisualVertex &vertex) {
    const auto &[x, y, z] = vertex.position_m;
    return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

/// By Cramer's rule (Möller and Trumbore 1997): origin + t direction = a + u edge_1 + v edge_2.
std::optional<double> hit(const Ray &ray, const Vector3 &a, const Vector3 &b, const Vector3 &c) {
    const Vector3 edge_1 = b - a;
    const Vector3 edge_2 = c - a;
    const Vector3 across = ray.direction.cross(edge_2);
    const double determinant = edge_1.dot(across);
    if (determinant == 0.0) {
        return std::nullopt;
    }
    const Vector3 offset = ray.origin_m - a;
    const double u = offset.dot(across) / determinant;
    const Vector3 aside = offset.cross(edge_1);
    const double v = ray.direction.dot(aside) / determinant;
    const double t = edge_2.dot(aside) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? std::optional(t) : std::nullopt;
}

void keep_nearer(std::optional<double> &nearest, const std::optional<double> &other) {
    if (other && (!nearest || *other < *nearest)) {
        nearest = other;
    }
}

std::optional<double> first_hit_of(const Ray &ray, std::span<const scene::VisualVertex> vertices,
                                   std::span<const std::uint32_t> indices) {
    std::optional<double> nearest;
    for (std::size_t i = 0; i + 3 <= indices.size(); i += 3) {
        keep_nearer(nearest,
                    hit(ray, corner_of(vertices[indices[i]]), corner_of(vertices[indices[i + 1]]),
                        corner_of(vertices[indices[i + 2]])));
    }
    return nearest;
}

} // namespace

Ray line_of_sight(const Camera &camera, const PixelPoint &pixel, const PixelSize &viewport) {
    const Vector3 eye_m = camera.eye_m();
    return {eye_m, (camera.point_at(pixel, viewport, camera.target_m()) - eye_m).normalized()};
}

std::optional<double> first_hit_m(const Ray &ray, std::span<const scene::VisualMesh> meshes) {
    std::optional<double> nearest;
    for (const scene::VisualMesh &mesh : meshes) {
        keep_nearer(nearest, first_hit_of(ray, mesh.vertices, mesh.indices));
    }
    return nearest;
}

std::optional<double> first_hit_m(const Ray &ray, std::span<const Solid> solids) {
    std::optional<double> nearest;
    for (const Solid &solid : solids) {
        Eigen::Matrix4d model;
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                model(row, column) = static_cast<double>(solid.model[column][row]);
            }
        }
        // In the unit shape's coordinates; t is the same there.
        const Eigen::Affine3d to_shape = Eigen::Affine3d(model).inverse();
        const Ray local{to_shape * ray.origin_m, to_shape.linear() * ray.direction};
        const ShapeMesh &mesh = unit_shape(solid.shape);
        keep_nearer(nearest, first_hit_of(local, mesh.vertices, mesh.indices));
    }
    return nearest;
}

std::optional<double> floor_hit_m(const Ray &ray, double floor_height_m) {
    const double t = (floor_height_m - ray.origin_m.y()) / ray.direction.y();
    return t > 0.0 && t < std::numeric_limits<double>::infinity() ? std::optional(t) : std::nullopt;
}

std::optional<SurfacePlace> first_touchable(const contact::HapticSurface &surface,
                                            const Vector3 &from_m, const Vector3 &to_m,
                                            double reach_m) {
    // A thousand times what a search takes: 10 ms at most, for surfaces made to be hard.
    contact::SearchBudget budget{1'000'000};
    const auto found = surface.first_stop(from_m, to_m, reach_m, budget);
    if (!found || !found->is_known) {
        return std::nullopt;
    }
    const Vector3 stopped_m = from_m + found->stop.fraction * (to_m - from_m);
    return SurfacePlace{stopped_m - reach_m * found->stop.normal, found->stop.normal};
}

std::optional<SurfacePlace> place_below(const contact::HapticSurface &surface,
                                        const Vector3 &point_m, double floor_height_m) {
    if (!point_m.allFinite() || point_m.y() <= floor_height_m) {
        return std::nullopt;
    }
    const Vector3 on_floor_m(point_m.x(), floor_height_m, point_m.z());
    const auto found = first_touchable(surface, point_m, on_floor_m);
    return found ? found : SurfacePlace{on_floor_m, Vector3::UnitY()};
}

} // namespace springdrive::app
