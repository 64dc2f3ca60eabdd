// The hands with which a device must be stable: from a fingertip that barely touches it to a firm
// grip. A device counts as stable only if it is with every one of them.
//
// The values are assumed, of the order that the literature on grips gives; the middle of the family
// is the relaxed pen grip of `HandParameters`, its ends are farther by a factor of 5 in mass and
// damping and of 10 in stiffness.
#pragma once

#include "base/assertions.h"
#include "device/core/hand_parameters.h"

#include <cmath>
#include <string>
#include <vector>

namespace springdrive::loops {

/// The linear model of a hand for small motions about rest: a mass on the tip, tied to the ground
/// by spring and damper.
struct Hand {
    std::string name;
    double mass_kg = 0.0;
    double damping_Ns_per_m = 0.0;
    double stiffness_N_per_m = 0.0;
};

/// The device is not held.
[[nodiscard]] inline Hand no_hand() { return {"no hand", 0.0, 0.0, 0.0}; }

/// A hand of the family.
/// @param firmness  from 0, a light fingertip, over 0.5, a relaxed grip, to 1, a firm one
[[nodiscard]] inline Hand hand_of_firmness(double firmness) {
    const device::HandParameters relaxed;
    const double way = 2.0 * firmness - 1.0;
    return {"firmness " + std::to_string(firmness).substr(0, 4),
            relaxed.mass_kg * std::pow(5.0, way), relaxed.damping_Ns_per_m * std::pow(5.0, way),
            relaxed.stiffness_N_per_m * std::pow(10.0, way)};
}

/// Text for messages: "light hand", "hand of firmness 0.25", "no hand".
[[nodiscard]] inline std::string hand_text(const std::string &name) {
    return name.ends_with("hand")          ? name
           : name.starts_with("firmness ") ? "hand of " + name
                                           : name + " hand";
}

/// No hand, and `grips` of the family from light to firm, evenly spread. @pre at least two grips
[[nodiscard]] inline std::vector<Hand> hand_family(int grips = 5) {
    SPRINGDRIVE_ASSERT(grips >= 2);
    std::vector<Hand> hands{no_hand()};
    for (int i = 0; i < grips; ++i) {
        hands.push_back(hand_of_firmness(static_cast<double>(i) / (grips - 1)));
    }
    hands[1].name = "light";
    hands.back().name = "firm";
    return hands;
}

} // namespace springdrive::loops
