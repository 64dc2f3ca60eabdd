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
