#include "app/view/solids.h"

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

namespace {

constexpr Colour kBarColour{0.86F, 0.87F, 0.89F};   // aluminium
constexpr Colour kJointColour{0.34F, 0.37F, 0.43F}; // anodised
constexpr Colour kBaseColour{0.26F, 0.28F, 0.33F};
constexpr Colour kTrippedColour{0.86F, 0.10F, 0.08F};

struct Paint {
    bool tripped = false;

    /// All parts are clearly red, but still distinguishable by brightness.
    Colour operator()(const Colour &colour) const {
        if (!tripped) {
            return colour;
        }
        constexpr float kShare = 0.75F;
        Colour mixed{};
        for (std::size_t i = 0; i < mixed.size(); ++i) {
            mixed[i] = (1.0F - kShare) * colour[i] + kShare * kTrippedColour[i];
        }
        return mixed;
    }
};

/// The axis of the joints q₂ and q₃: horizontal, normal to the plane of the linkage.
Vector3 pivot_axis(const device::LinkagePose &pose) {
    Vector3 outward = (pose.elbow_m - pose.base_m) + (pose.tip_m - pose.base_m);
    outward.y() = 0.0;
    constexpr double kOnTheBaseAxis_m = 1e-6;
    return outward.norm() < kOnTheBaseAxis_m ? Vector3::UnitX()
                                             : Vector3::UnitY().cross(outward).normalized();
}

// The linkage is drawn in four planes side by side, so that no part passes through another in any
// pose. The forearm, which ends at the tip, is in the middle. Along the pivot axis:
constexpr double kArmAside_m = -0.0140;  // beside the column and the forearm
constexpr double kCrankAside_m = 0.0175; // beside the column, at the motors' end
constexpr double kRodAside_m = 0.0260;   // beside the crank

constexpr double kColumnRadius_m = 0.0080;
constexpr double kMotorRadius_m = 0.0170;
constexpr double kMotorFrom_m = -0.0280;
constexpr double kMotorTo_m = 0.0125;
constexpr double kHubRadius_m = 0.0090; // of the crank
constexpr double kArmRadius_m = 0.0052;
constexpr double kCrankRadius_m = 0.0042;
constexpr double kRodRadius_m = 0.0030;
constexpr double kForearmRadius_m = 0.0042;
constexpr double kElbowRadius_m = 0.0085;
constexpr double kPinRadius_m = 0.0048;
constexpr double kRim_m = 0.0010; // by which pins and hubs stand out over what they hold

struct Builder {
    Vector3 pivot_axis;
    Paint paint;
    std::vector<LinkageSolid> solids;

    [[nodiscard]] Vector3 aside(const Vector3 &at_m, double aside_m) const {
        return at_m + aside_m * pivot_axis;
    }

    void add(LinkagePart part, const Solid &solid) { solids.push_back({part, solid}); }

    void bar(LinkagePart part, const Vector3 &from_m, const Vector3 &to_m, double radius_m) {
        add(part, spindle(Shape::cylinder, from_m, to_m, radius_m, paint(kBarColour)));
        add(part, ball(from_m, radius_m, paint(kBarColour)));
        add(part, ball(to_m, radius_m, paint(kBarColour)));
    }

    /// A cylinder about the pivot axis through a joint.
    void drum(LinkagePart part, const Vector3 &joint_m, double from_m, double to_m, double radius_m,
              const Colour &colour = kJointColour) {
        add(part, spindle(Shape::cylinder, aside(joint_m, from_m), aside(joint_m, to_m), radius_m,
                          paint(colour)));
    }

    void post(const Vector3 &foot_m, double height_m, double radius_m) {
        const Vector3 head_m = foot_m + height_m * Vector3::UnitY();
        add(LinkagePart::base,
            spindle(Shape::cylinder, foot_m, head_m, radius_m, paint(kBaseColour)));
    }

    void base(const Vector3 &motors_m, double floor_height_m) {
        const Vector3 foot_m(motors_m.x(), floor_height_m, motors_m.z());
        post(foot_m, 0.010, 0.048); // plate
        post(foot_m, 0.022, 0.032); // hub
        if (motors_m.y() > floor_height_m) {
            post(foot_m, motors_m.y() - floor_height_m, kColumnRadius_m);
        }
        drum(LinkagePart::base, motors_m, kMotorFrom_m, kMotorTo_m, kMotorRadius_m, kBaseColour);
        drum(LinkagePart::base, motors_m, kMotorFrom_m - 0.003, kMotorFrom_m, kHubRadius_m);
    }

    void upper_arm(const Vector3 &motors_m, const Vector3 &elbow_m) {
        bar(LinkagePart::upper_arm, aside(motors_m, kArmAside_m), aside(elbow_m, kArmAside_m),
            kArmRadius_m);
        drum(LinkagePart::upper_arm, elbow_m, kArmAside_m - kArmRadius_m - kRim_m,
             kForearmRadius_m + kRim_m, kElbowRadius_m);
    }

    void crank(const Vector3 &motors_m, const Vector3 &end_m) {
        drum(LinkagePart::crank, motors_m, kMotorTo_m, kCrankAside_m + kCrankRadius_m,
             kHubRadius_m);
        bar(LinkagePart::crank, aside(motors_m, kCrankAside_m), aside(end_m, kCrankAside_m),
            kCrankRadius_m);
        drum(LinkagePart::crank, end_m, kCrankAside_m - kCrankRadius_m,
             kRodAside_m + kRodRadius_m + kRim_m, kPinRadius_m);
    }

    void rod(const Vector3 &crank_m, const Vector3 &coupling_m) {
        bar(LinkagePart::rod, aside(crank_m, kRodAside_m), aside(coupling_m, kRodAside_m),
            kRodRadius_m);
    }

    void forearm(const Vector3 &elbow_m, const Vector3 &coupling_m, const Vector3 &tip_m) {
        add(LinkagePart::forearm,
            spindle(Shape::taper, elbow_m, tip_m, kForearmRadius_m, paint(kBarColour)));
        drum(LinkagePart::forearm, coupling_m, -kForearmRadius_m - kRim_m,
             kRodAside_m + kRodRadius_m + kRim_m, kPinRadius_m);
    }
};

} // namespace

std::vector<LinkageSolid> linkage_parts(const device::LinkagePose &pose, double floor_height_m,
                                        bool tripped) {
    Builder build{pivot_axis(pose), Paint{tripped}, {}};
    build.base(pose.base_m, floor_height_m);
    build.upper_arm(pose.base_m, pose.elbow_m);
    build.crank(pose.base_m, pose.crank_m);
    build.rod(pose.crank_m, pose.coupling_m);
    build.forearm(pose.elbow_m, pose.coupling_m, pose.tip_m);
    return build.solids;
}

std::vector<Solid> linkage_solids(const device::LinkagePose &pose, double floor_height_m,
                                  bool tripped) {
    std::vector<Solid> solids;
    for (const LinkageSolid &each : linkage_parts(pose, floor_height_m, tripped)) {
        solids.push_back(each.solid);
    }
    return solids;
}

} // namespace springdrive::app
