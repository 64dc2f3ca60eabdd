#include "app/assistant/rehearsal.h"

#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"

#include <cmath>
#include <utility>
#include <vector>

namespace springdrive::app::assistant {

namespace {

using simulated::HandPath;

/// The true angles: those of the servo may be wrong.
Vector3 true_joints_rad(session::Session &session) {
    factory::EmulatedDevice *const emulated = session.device().emulated();
    if (emulated == nullptr) {
        throw InputError("only the hand of an emulated device can be moved by the program");
    }
    Vector3 q_rad;
    session.servo().paused([&] {
        q_rad = device::joint_from_motor(session.description().geometry,
                                         emulated->board().phantom().truth().theta_rad);
    });
    return q_rad;
}

constexpr double kAbove_m = 0.02; ///< the scene, before and after a press

Vector3 above_the_middle(const session::Session &session, double above_m) {
    const scene::Scene &scene = session.scenes().now().scene;
    const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
    return {middle_m.x(), scene.upper_m.y() + above_m, middle_m.z()};
}

} // namespace

void move_joint(session::Session &session, std::size_t joint, double angle_rad) {
    const Vector3 from_rad = true_joints_rad(session);
    constexpr int kParts = 12;
    constexpr double kPart_s = 0.1;
    std::vector<HandPath::Point> points;
    for (int i = 0; i <= 2 * kParts; ++i) {
        const double share = 1.0 - std::abs(static_cast<double>(i - kParts)) / kParts;
        Vector3 q_rad = from_rad;
        q_rad[static_cast<Eigen::Index>(joint)] += share * angle_rad;
        points.push_back(
            {i * kPart_s, device::tip_position_m(session.description().geometry, q_rad)});
    }
    session.follow_path(HandPath(std::move(points)));
}

void hold_zero_pose(session::Session &session) {
    session.follow_path(HandPath({{0.0, Vector3::Zero()}}));
}

void hold_above(session::Session &session) {
    const Vector3 there_m = above_the_middle(session, kAbove_m);
    session.follow_path(HandPath({{0.0, there_m}, {0.5, there_m}}));
}

void press_and_lift(session::Session &session) {
    constexpr double kDepth_m = 0.004;
    session.follow_path(HandPath({{0.0, above_the_middle(session, kAbove_m)},
                                  {1.0, above_the_middle(session, -kDepth_m)},
                                  {2.5, above_the_middle(session, -kDepth_m)},
                                  {3.5, above_the_middle(session, kAbove_m)}}));
}

} // namespace springdrive::app::assistant
