#include "engine/lab/loops/tuning_constraints.h"

#include "device/core/phantom/kinematics.h"
#include "engine/control/motion_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

namespace springdrive::loops {

namespace {

/// From rigid to free; most failures are near the ends.
constexpr std::array kEtas{0.0, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0};

/// Joint angles at a grid of reachable points of the workspace, and those of the case.
std::vector<Vector3> configurations(const StabilityCase &which) {
    std::vector<Vector3> all{which.q_rad};
    const device::Workspace &box = which.device.workspace;
    for (int i = 0; i < 27; ++i) {
        const int layer = i / 9 - 1;
        const Vector3 share(i % 3 - 1, i / 3 % 3 - 1, layer);
        const Vector3 point_m = box.centre_m + 0.5 * share.cwiseProduct(box.size_m);
        const std::optional<Vector3> q_rad =
            device::joint_angles_rad(which.device.geometry, point_m);
        if (q_rad && which.device.joint_limits.allow(*q_rad)) {
            all.push_back(*q_rad);
        }
    }
    return all;
}

/// Hands between two, spaced by equal ratios: `count` of them with the first and without the last.
void add_hands_between(std::vector<Hand> &all, const Hand &first, const Hand &last, int count) {
    all.push_back(first);
    for (int i = 1; i < count; ++i) {
        const auto between = [share = static_cast<double>(i) / count](double from, double to) {
            return from * std::pow(to / from, share);
        };
        all.push_back({first.name + " to " + last.name, between(first.mass_kg, last.mass_kg),
                       between(first.damping_Ns_per_m, last.damping_Ns_per_m),
                       between(first.stiffness_N_per_m, last.stiffness_N_per_m)});
    }
}

bool is_there(const Hand &hand) {
    return hand.mass_kg > 0.0 && hand.damping_Ns_per_m > 0.0 && hand.stiffness_N_per_m > 0.0;
}

/// A family's hands with others between them, `count` times as many: one of these may resonate
/// where its neighbours do not, above all in free space, where no gain has a margin.
std::vector<Hand> with_hands_between(const std::vector<Hand> &hands, int count) {
    std::vector<Hand> all;
    for (std::size_t i = 0; i < hands.size(); ++i) {
        if (i + 1 < hands.size() && is_there(hands[i]) && is_there(hands[i + 1])) {
            add_hands_between(all, hands[i], hands[i + 1], count);
        } else {
            all.push_back(hands[i]);
        }
    }
    return all;
}

/// One configuration's loops, for one member and all η.
void add_loops(std::vector<TuningConstraint> &loops, StabilityCase which,
               const LoopMember &member) {
    which.tuning.eta = 0.0;
    const LinearLoop loop = linear_loop(which, member);
    const Eigen::MatrixXd rigid = held_share(which);
    for (const double eta : kEtas) {
        loops.push_back({loop, (1.0 - eta) * rigid, member.hand.name, eta, member.structure});
    }
}

} // namespace

TuningConstraints::TuningConstraints(const StabilityCase &which) {
    constexpr int kDivisionsOneMotor = 10;
    constexpr int kDivisionsThreeMotors = 2; // these loops take twenty times as long
    StabilityCase each = which;
    each.freedom = Freedom::one_motor;
    each.hands = with_hands_between(which.hands, kDivisionsOneMotor);
    for (const LoopMember &member : members(each)) {
        add_loops(loops_, each, member);
    }
    if (!which.rotor) {
        each.freedom = Freedom::three_motors;
        each.hands = with_hands_between(which.hands, kDivisionsThreeMotors);
        for (const Vector3 &q_rad : configurations(which)) {
            each.q_rad = q_rad;
            for (const LoopMember &member : members(each)) {
                add_loops(loops_, each, member);
            }
        }
    }
    order_.resize(loops_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
}

double TuningConstraints::largest_eigenvalue(std::size_t index, const Gains &gains) const {
    const TuningConstraint &constraint = loops_[index];
    return constraint.loop.largest_eigenvalue(
        drift_compensation(constraint.loop.load().torque_Nm_per_A, gains, constraint.share,
                           constraint.loop.sampling()));
}

bool TuningConstraints::is_stable(std::size_t index, const Gains &gains) const {
    // In free space no gain acts: a mass without friction coasts, whatever the tuning.
    const double maximum =
        loops_[index].eta < 1.0 ? 1.0 - kEigenvalueRoundOff : 1.0 + kEigenvalueRoundOff;
    return largest_eigenvalue(index, gains) < maximum;
}

bool TuningConstraints::are_stable(const std::vector<std::size_t> &some, const Gains &gains) const {
    return std::all_of(some.begin(), some.end(),
                       [&](std::size_t loop) { return is_stable(loop, gains); });
}

std::size_t TuningConstraints::first_unstable(const Gains &gains) {
    for (std::size_t i = 0; i < order_.size(); ++i) {
        if (!is_stable(order_[i], gains)) {
            const std::size_t failed = order_[i];
            std::rotate(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(i),
                        order_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
            return failed;
        }
    }
    return count();
}

} // namespace springdrive::loops
