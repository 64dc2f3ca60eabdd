#include "engine/study/observers/perceived_level.h"

namespace springdrive::study {

namespace {

/// Of the delivered to the intended stiffness; 1 where it was not measured.
double stiffness_share(const FeltPresentation &felt) {
    const std::optional<double> &came = felt.delivered.stiffness_N_per_m;
    const std::optional<double> &wanted = felt.intended.stiffness_N_per_m;
    return came && wanted && *came > 0.0 && *wanted > 0.0 ? *came / *wanted : 1.0;
}

} // namespace

double delivered_value(const Protocol &protocol, const FeltPresentation &felt) {
    const ParameterFacts &variable = variable_of(protocol);
    const double intended = variable.get(felt.condition);
    const StimulusMeasures &came = felt.delivered;
    if (variable.of_condition == &Condition::turn_deg) {
        return came.turn_deg.value_or(intended);
    }
    if (variable.of_condition == &Condition::pulse_N) {
        return came.pulse_N.value_or(intended);
    }
    if (variable.of_condition == &Condition::press_N) {
        return came.press_N.value_or(intended);
    }
    if (variable.of_condition == &Condition::speed_m_per_s) {
        return came.speed_m_per_s.value_or(intended);
    }
    const double share = stiffness_share(felt);
    if (variable.gain == &control::Tuning::eta) {
        return 1.0 - (1.0 - intended) * share;
    }
    if (variable.gain == &control::Tuning::K_P_V_per_rad) {
        return intended * share;
    }
    return variable.gain == &control::Tuning::dR_Ohm ? intended / share : intended;
}

double delivered_level(const Protocol &protocol, const FeltPresentation &comparison,
                       const std::optional<FeltPresentation> &standard) {
    const double value = delivered_value(protocol, comparison);
    const double compared_with =
        standard ? delivered_value(protocol, *standard) : protocol.variable.standard;
    switch (protocol.variable.level) {
    case LevelMeaning::added:
        return value - compared_with;
    case LevelMeaning::taken_off:
        return compared_with - value;
    case LevelMeaning::value:
        break;
    }
    return value;
}

} // namespace springdrive::study
