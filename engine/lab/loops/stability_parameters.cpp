#include "engine/lab/loops/stability_parameters.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::loops {

namespace {

device::RotorLoad rotor_of(const StabilityCase &which) {
    if (which.rotor) {
        return *which.rotor;
    }
    const DrivenLoad load = driven_load(which, {1, no_hand()});
    return {load.inertia_kg_m2(0, 0), load.damping_Nms_per_rad(0, 0),
            load.stiffness_Nm_per_rad(0, 0)};
}

/// A property of the hand belongs to one hand: the only one of the case, or a relaxed one.
Hand the_hand(const StabilityCase &which) {
    const bool one = which.hands.size() == 1;
    Hand hand = one ? which.hands.front() : hand_of_firmness(0.5);
    hand.name = "one hand";
    return hand;
}

template <double Hand::*member> double get_hand(const StabilityCase &which) {
    return the_hand(which).*member;
}

template <double Hand::*member> void set_hand(StabilityCase &which, double value) {
    Hand hand = the_hand(which);
    hand.*member = value;
    which.hands = {hand};
}

template <double control::Tuning::*member> double get_tuning(const StabilityCase &which) {
    return which.tuning.*member;
}

template <double control::Tuning::*member> void set_tuning(StabilityCase &which, double value) {
    which.tuning.*member = value;
}

using Case = StabilityCase;

const std::array<StabilityParameter, 15> kList{{
    {"kp", "K_P", "V/rad", 0.0, 1e4, 0.1, 200.0, true, get_tuning<&control::Tuning::K_P_V_per_rad>,
     set_tuning<&control::Tuning::K_P_V_per_rad>, "position gain (10)"},
    {"kd", "K_D", "V·s/rad", 0.0, 10.0, 1e-3, 1.0, true,
     get_tuning<&control::Tuning::K_D_Vs_per_rad>, set_tuning<&control::Tuning::K_D_Vs_per_rad>,
     "velocity gain (10)"},
    {"lambda", "λ", "rad/s", 1.0, 1e6, 10.0, 1e4, true,
     get_tuning<&control::Tuning::lambda_rad_per_s>, set_tuning<&control::Tuning::lambda_rad_per_s>,
     "cutoff of the velocity filter (12)"},
    {"dR", "dR", "Ω", -100.0, 100.0, 0.01, 2.18, true,
     [](const Case &c) { return c.dR_Ohm(c.device.motor[1]); },
     [](Case &c, double value) { c.net_resistance_Ohm = value; },
     "residual resistance (7); below 0 for a winding cooler than when tuned"},
    {"alpha", "α", "rad²/m²", 0.0, 1e7, 100.0, 1e5, true,
     get_tuning<&control::Tuning::alpha_rad2_per_m2>,
     [](Case &c, double value) {
         c.tuning.alpha_rad2_per_m2 = value;
         c.tuning.alpha_mode = control::AlphaMode::by_hand;
         c.tuning.map = control::MotionMap::transpose;
     },
     "scale of the transpose map (23), by hand"},
    {"T", "T", "s", 1e-6, 1.0, 1e-5, 0.05, true, [](const Case &c) { return c.period_s; },
     [](Case &c, double value) { c.period_s = value; }, "servo period"},
    {"d", "d", "periods", 0.0, 8.0, 0.0, 8.0, false, [](const Case &c) { return c.delay_periods; },
     [](Case &c, double value) { c.delay_periods = value; },
     "periods from reading θ to applying e_W, a real number"},
    {"eta", "η", "–", 0.0, 1.0, 0.0, 1.0, false, get_tuning<&control::Tuning::eta>,
     set_tuning<&control::Tuning::eta>, "0 rigid, 1 free space (30)"},
    {"hand-mass", "m of the hand", "kg", 0.0, 100.0, 1e-3, 10.0, true, get_hand<&Hand::mass_kg>,
     set_hand<&Hand::mass_kg>, "mass of one hand on the tip, instead of the six of the family"},
    {"hand-damping", "b of the hand", "N·s/m", 0.0, 1e4, 0.01, 100.0, true,
     get_hand<&Hand::damping_Ns_per_m>, set_hand<&Hand::damping_Ns_per_m>, "damping of one hand"},
    {"hand-stiffness", "k of the hand", "N/m", 0.0, 1e6, 1.0, 1e5, true,
     get_hand<&Hand::stiffness_N_per_m>, set_hand<&Hand::stiffness_N_per_m>,
     "stiffness of one hand"},
    {"inertia", "J", "kg·m²", 1e-12, 1e3, 1e-7, 1e-3, true,
     [](const Case &c) { return rotor_of(c).inertia_kg_m2; },
     [](Case &c, double value) {
         c.rotor = rotor_of(c);
         c.rotor->inertia_kg_m2 = value;
     },
     "inertia of one motor and all that it moves, at the motor"},
    {"damping", "b", "N·m·s/rad", 0.0, 1e3, 1e-8, 1e-2, true,
     [](const Case &c) { return rotor_of(c).damping_Nms_per_rad; },
     [](Case &c, double value) {
         c.rotor = rotor_of(c);
         c.rotor->damping_Nms_per_rad = value;
     },
     "damping of one motor and all that it moves, at the motor"},
    {"wall-stiffness", "K", "N/m", 0.0, 1e7, 1.0, 1e5, true,
     [](const Case &c) { return c.wall.stiffness_N_per_m; },
     [](Case &c, double value) { c.wall.stiffness_N_per_m = value; },
     "stiffness of a current drive's virtual wall, at the tip"},
    {"wall-damping", "B", "N·s/m", 0.0, 1e5, 0.1, 100.0, true,
     [](const Case &c) { return c.wall.damping_Ns_per_m; },
     [](Case &c, double value) { c.wall.damping_Ns_per_m = value; },
     "damping of a current drive's virtual wall, at the tip"},
}};

} // namespace

std::span<const StabilityParameter> stability_parameters() { return kList; }

const StabilityParameter *stability_parameter_named(std::string_view name) {
    const auto found = std::find_if(kList.begin(), kList.end(),
                                    [name](const auto &each) { return each.name == name; });
    return found == kList.end() ? nullptr : &*found;
}

std::string names_of_stability_parameters() {
    std::string names;
    for (const StabilityParameter &parameter : kList) {
        names += (names.empty() ? "" : ", ") + std::string(parameter.name);
    }
    return names;
}

std::string validate(const StabilityParameter &parameter, double value) {
    const bool in_range = value >= parameter.minimum && value <= parameter.maximum;
    const bool zero_dR = parameter.name == "dR" && value == 0.0;
    if (in_range && !zero_dR) {
        return {};
    }
    const bool has_unit = parameter.unit != "–";
    return fmt::format("{} is {:g}; it must be from {:g} to {:g}{}{}{}", parameter.name, value,
                       parameter.minimum, parameter.maximum, has_unit ? " " : "",
                       has_unit ? parameter.unit : "", zero_dR ? ", and not 0" : "");
}

} // namespace springdrive::loops
