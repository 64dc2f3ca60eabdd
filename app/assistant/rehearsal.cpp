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

void press_and_lift(session::Session &session) {
    const scene::Scene &scene = session.scenes().now().scene;
    const Vector3 middle_m = 0.5 * (scene.lower_m + scene.upper_m);
    const auto at = [&](double above_m) {
        return Vector3(middle_m.x(), scene.upper_m.y() + above_m, middle_m.z());
    };
    constexpr double kAbove_m = 0.02;
    constexpr double kDepth_m = 0.004;
    session.follow_path(HandPath({{0.0, at(kAbove_m)},
                                  {1.5, at(kAbove_m)},
                                  {2.5, at(-kDepth_m)},
                                  {4.0, at(-kDepth_m)},
                                  {5.0, at(kAbove_m)}}));
}

} // namespace springdrive::app::assistant
