// Boxes in arrangements that are difficult for a search tree, and slow reference searches.
#pragma once

#include "tests/engine/contact/mesh/soups.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace springdrive::testing {

using Boxes = std::vector<Eigen::AlignedBox3d>;

struct BoxSet {
    std::string name;
    Boxes boxes;
    Vector3 centre_m = Vector3::Zero();
    double half_m = 0.1; ///< most boxes lie within so much of the centre
};

inline Eigen::AlignedBox3d box_about(const Vector3 &centre_m, const Vector3 &half_m) {
    return {Vector3(centre_m - half_m), Vector3(centre_m + half_m)};
}

inline Boxes random_boxes(std::mt19937_64 &random, int count, double half_m, double size_m,
                          const Vector3 &centre_m = Vector3::Zero()) {
    Boxes boxes;
    for (int i = 0; i < count; ++i) {
        const Vector3 at = centre_m + random_vector(random, half_m);
        boxes.push_back(box_about(at, random_vector(random, size_m).cwiseAbs()));
    }
    return boxes;
}

inline Boxes boxes_of(const contact::TriangleSoup &soup) {
    Boxes boxes(soup.triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        for (const Vector3 &corner : corners(soup, i)) {
            boxes[i].extend(corner);
        }
    }
    return boxes;
}

/// Nested about one corner, each half as large again as the last, which makes a tree deep.
inline Boxes growing_boxes(int count) {
    Boxes boxes;
    for (int i = 0; i < count; ++i) {
        boxes.emplace_back(Vector3::Zero(), Vector3::Constant(1e-12 * std::pow(1.5, i)));
    }
    return boxes;
}

inline std::vector<BoxSet> box_sets(std::mt19937_64 &random) {
    const Vector3 far(1000.0, -999.9, 998.7);
    std::vector<BoxSet> sets{
        {"one", random_boxes(random, 1, 0.01, 0.05)},
        {"two", random_boxes(random, 2, 0.05, 0.05)},
        {"nine", random_boxes(random, 9, 0.1, 0.05)},
        {"scattered", random_boxes(random, 700, 0.1, 0.005)},
        {"overlapping", random_boxes(random, 300, 0.1, 0.08)},
        {"sphere", boxes_of(bumpy_sphere(3, 0.08))},
        {"points", random_boxes(random, 500, 0.1, 0.0)},
        {"identical", Boxes(1000, box_about({0.01, 0.02, 0.03}, {0.02, 0.03, 0.01}))},
        {"identical points", Boxes(1000, box_about({0.01, 0.02, 0.03}, Vector3::Zero()))},
        {"growing", growing_boxes(64)},
        {"far", random_boxes(random, 500, 0.1, 0.005, far), far},
        {"large", random_boxes(random, 500, 1000.0, 40.0), Vector3::Zero(), 1000.0},
        {"line", random_boxes(random, 500, 0.1, 0.001)},
        {"plane", random_boxes(random, 500, 0.1, 0.01)},
    };
    for (Eigen::AlignedBox3d &box : (sets.end() - 2)->boxes) {
        box.min().tail<2>().setConstant(0.02);
        box.max().tail<2>().setConstant(0.02);
    }
    for (Eigen::AlignedBox3d &box : sets.back().boxes) {
        box.min().y() = box.max().y() = -0.01;
    }
    return sets;
}

/// The fraction at which a motion enters a box grown by `reach_m`, or infinity if it never does.
inline double entry_fraction(const Eigen::AlignedBox3d &box, const Vector3 &from_m,
                             const Vector3 &to_m, double reach_m) {
    double enters = 0.0;
    double leaves = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double lower = box.min()[axis] - reach_m - from_m[axis];
        const double upper = box.max()[axis] + reach_m - from_m[axis];
        const double length = to_m[axis] - from_m[axis];
        if (length == 0.0) {
            leaves = lower <= 0.0 && upper >= 0.0 ? leaves : -1.0;
        } else {
            enters = std::max(enters, std::min(lower / length, upper / length));
            leaves = std::min(leaves, std::max(lower / length, upper / length));
        }
    }
    return enters <= leaves ? enters : INFINITY;
}

struct Motion {
    Vector3 from_m;
    Vector3 to_m;
    double reach_m = 0.0;
};

/// Of all lengths, zero among them; some along an axis or in a plane of two, some that start in
/// the middle of a box or on its corner.
inline Motion random_motion(std::mt19937_64 &random, const BoxSet &set) {
    std::uniform_real_distribution<double> exponent(-7.0, 0.0);
    Motion motion;
    motion.from_m = set.centre_m + random_vector(random, 1.2 * set.half_m);
    const Eigen::AlignedBox3d &box = set.boxes[random() % set.boxes.size()];
    switch (random() % 4) {
    case 0:
        motion.from_m = box.center();
        break;
    case 1:
        motion.from_m = random() % 2 == 0 ? box.min() : box.max();
        break;
    default:
        break;
    }
    Vector3 step = std::pow(10.0, exponent(random)) * random_vector(random, 3.0 * set.half_m);
    for (int axis = 0; axis < 3; ++axis) {
        step[axis] = random() % 4 == 0 ? 0.0 : step[axis];
    }
    motion.to_m = motion.from_m + step;
    motion.reach_m = random() % 3 == 0 ? 0.0 : set.half_m * std::pow(10.0, exponent(random));
    return motion;
}

} // namespace springdrive::testing
