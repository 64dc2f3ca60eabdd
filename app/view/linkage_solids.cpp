#include "app/view/linkage_solids.h"

#include <Eigen/Geometry>

namespace springdrive::app {

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

struct Builder {
    Vector3 pivot_axis;
    Paint paint;
    std::vector<Solid> solids;

    void bar(const Vector3 &from_m, const Vector3 &to_m, double radius_m) {
        solids.push_back(spindle(Shape::cylinder, from_m, to_m, radius_m, paint(kBarColour)));
        solids.push_back(ball(from_m, radius_m, paint(kBarColour)));
        solids.push_back(ball(to_m, radius_m, paint(kBarColour)));
    }

    /// A short cylinder along the pivot axis.
    void joint(const Vector3 &at_m, double radius_m, double width_m,
               const Colour &colour = kJointColour) {
        const Vector3 half_m = width_m / 2.0 * pivot_axis;
        solids.push_back(
            spindle(Shape::cylinder, at_m - half_m, at_m + half_m, radius_m, paint(colour)));
    }

    void post(const Vector3 &foot_m, double height_m, double radius_m) {
        const Vector3 head_m = foot_m + height_m * Vector3::UnitY();
        solids.push_back(spindle(Shape::cylinder, foot_m, head_m, radius_m, paint(kBaseColour)));
    }

    void forearm(const Vector3 &elbow_m, const Vector3 &tip_m, double radius_m) {
        solids.push_back(spindle(Shape::taper, elbow_m, tip_m, radius_m, paint(kBarColour)));
    }
};

} // namespace

std::vector<Solid> linkage_solids(const device::LinkagePose &pose, double floor_height_m,
                                  bool tripped) {
    Builder build{pivot_axis(pose), Paint{tripped}, {}};

    Vector3 foot_m = pose.base_m;
    foot_m.y() = floor_height_m;
    build.post(foot_m, 0.010, 0.048); // plate
    build.post(foot_m, 0.022, 0.032); // hub
    if (pose.base_m.y() > floor_height_m) {
        build.post(foot_m, pose.base_m.y() - floor_height_m, 0.009); // turret
    }
    build.joint(pose.base_m, 0.015, 0.050, kBaseColour); // both motors of the linkage
    build.joint(pose.base_m, 0.009, 0.056);

    build.bar(pose.base_m, pose.elbow_m, 0.0052);
    build.bar(pose.base_m, pose.crank_m, 0.0042);
    build.bar(pose.crank_m, pose.coupling_m, 0.0030);
    build.forearm(pose.elbow_m, pose.tip_m, 0.0042);
    build.joint(pose.elbow_m, 0.0085, 0.016);
    build.joint(pose.crank_m, 0.0060, 0.013);
    build.joint(pose.coupling_m, 0.0060, 0.013);
    return build.solids;
}

} // namespace springdrive::app
