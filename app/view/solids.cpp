#include "app/view/solids.h"

#include "app/view/gl_vector.h"
#include "base/assertions.h"

#include <Eigen/Geometry>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace springdrive::app {

namespace {

constexpr float kTurn = 2.0F * std::numbers::pi_v<float>;
constexpr int kAround = 24; // smooth up to a thumb's width on the screen

struct SurfacePoint {
    glm::vec3 position;
    glm::vec3 normal;
};

/// Adds a grid over a surface with parameters angle (0 to a full turn about z) and v (0 to 1).
/// ∂/∂angle × ∂/∂v must point outward.
template <typename Surface>
void append_surface(ShapeMesh &mesh, int rows, const Surface &surface_at) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int row = 0; row <= rows; ++row) {
        for (int column = 0; column <= kAround; ++column) {
            const float angle = kTurn * static_cast<float>(column) / static_cast<float>(kAround);
            const SurfacePoint p =
                surface_at(angle, static_cast<float>(row) / static_cast<float>(rows));
            mesh.vertices.push_back({{p.position.x, p.position.y, p.position.z},
                                     {p.normal.x, p.normal.y, p.normal.z},
                                     {1.0F, 1.0F, 1.0F, 1.0F},
                                     {0.0F, 0.0F}});
        }
    }
    constexpr std::uint32_t kStride = kAround + 1;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < kAround; ++column) {
            const std::uint32_t corner = first + static_cast<std::uint32_t>(row) * kStride +
                                         static_cast<std::uint32_t>(column);
            mesh.indices.insert(mesh.indices.end(),
                                {corner, corner + 1, corner + kStride + 1, //
                                 corner, corner + kStride + 1, corner + kStride});
        }
    }
}

glm::vec3 around_z(float angle, float radius, float z) {
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// The side of a cylinder, taper or cone between z = 0 and 1.
void append_side(ShapeMesh &mesh, float first_radius, float last_radius) {
    append_surface(mesh, 1, [=](float angle, float v) {
        const float radius = first_radius + v * (last_radius - first_radius);
        return SurfacePoint{around_z(angle, radius, v),
                            glm::normalize(around_z(angle, 1.0F, first_radius - last_radius))};
    });
}

void append_lower_cap(ShapeMesh &mesh, float radius) {
    append_surface(mesh, 1, [=](float angle, float v) {
        return SurfacePoint{around_z(angle, v * radius, 0.0F), {0.0F, 0.0F, -1.0F}};
    });
}

void append_upper_cap(ShapeMesh &mesh, float radius) {
    append_surface(mesh, 1, [=](float angle, float v) {
        return SurfacePoint{around_z(angle, (1.0F - v) * radius, 1.0F), {0.0F, 0.0F, 1.0F}};
    });
}

ShapeMesh make_ball() {
    ShapeMesh mesh;
    append_surface(mesh, kAround / 2, [](float angle, float v) {
        const float latitude = kTurn / 2.0F * (v - 0.5F);
        const glm::vec3 p = around_z(angle, std::cos(latitude), std::sin(latitude));
        return SurfacePoint{p, p};
    });
    return mesh;
}

ShapeMesh make_frustum(float last_radius) {
    ShapeMesh mesh;
    append_side(mesh, 1.0F, last_radius);
    append_lower_cap(mesh, 1.0F);
    append_upper_cap(mesh, last_radius);
    return mesh;
}

ShapeMesh make_cone() {
    ShapeMesh mesh;
    append_side(mesh, 1.0F, 0.0F);
    append_lower_cap(mesh, 1.0F);
    return mesh;
}

ShapeMesh make_ring() {
    ShapeMesh mesh;
    append_surface(mesh, 8, [](float angle, float v) {
        const glm::vec3 normal = around_z(angle, std::cos(kTurn * v), std::sin(kTurn * v));
        return SurfacePoint{around_z(angle, 1.0F, 0.0F) + kRingThickness / 2.0F * normal, normal};
    });
    return mesh;
}

/// Maps z to `axis` and the unit circle in x, y to one of `radius_m` about it.
glm::mat4 placed_along(const Vector3 &origin_m, const Vector3 &axis_m, double radius_m) {
    const Vector3 across = axis_m.unitOrthogonal();
    const Vector3 third = axis_m.normalized().cross(across);
    return {glm::vec4(to_glm(radius_m * across), 0.0F), glm::vec4(to_glm(radius_m * third), 0.0F),
            glm::vec4(to_glm(axis_m), 0.0F), glm::vec4(to_glm(origin_m), 1.0F)};
}

float linear(float srgb) {
    return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

} // namespace

ShapeMesh make_shape(Shape shape) {
    switch (shape) {
    case Shape::ball:
        return make_ball();
    case Shape::cylinder:
        return make_frustum(1.0F);
    case Shape::taper:
        return make_frustum(kTaperEnd);
    case Shape::cone:
        return make_cone();
    case Shape::ring:
        return make_ring();
    }
    throw std::logic_error("no such shape");
}

const ShapeMesh &unit_shape(Shape shape) {
    static const std::vector<ShapeMesh> kMade = [] {
        std::vector<ShapeMesh> made;
        for (const Shape each : kShapes) {
            made.push_back(make_shape(each));
        }
        return made;
    }();
    return kMade.at(static_cast<std::size_t>(shape));
}

glm::vec4 linear(const Colour &colour) {
    return {linear(colour[0]), linear(colour[1]), linear(colour[2]), 1.0F};
}

Solid ball(const Vector3 &centre_m, double radius_m, const Colour &colour) {
    return {Shape::ball, placed_along(centre_m, radius_m * Vector3::UnitZ(), radius_m),
            linear(colour)};
}

Solid spindle(Shape shape, const Vector3 &from_m, const Vector3 &to_m, double radius_m,
              const Colour &colour) {
    SPRINGDRIVE_ASSERT(from_m != to_m);
    return {shape, placed_along(from_m, to_m - from_m, radius_m), linear(colour)};
}

Solid ring(const Vector3 &centre_m, const Vector3 &axis, double radius_m, const Colour &colour) {
    return {Shape::ring, placed_along(centre_m, radius_m * axis, radius_m), linear(colour)};
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

} // namespace springdrive::app
