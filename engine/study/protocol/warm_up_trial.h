// The warm-up before a session: how long it takes by the thermal network, and simulated by the
// whole servo in closed loop with the simulated device.
#pragma once

#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/warm_up.h"

#include <string>

namespace springdrive::study {

/// Where the hand is meanwhile: where it rests before the stimuli of the first condition that has a
/// place within reach.
[[nodiscard]] Vector3 warming_place_m(const Protocol &protocol, const StudySetting &setting);

/// The largest currents of a warm-up there [A].
[[nodiscard]] Vector3 warming_current_A(const StudySetting &setting, const Vector3 &place_m);

/// From the air's temperature until the slowest winding is warm and the tuning is back; infinite if
/// that takes longer than `WarmUp::kMax_s` [s].
[[nodiscard]] double predicted_warm_up_s(const Protocol &protocol, const StudySetting &setting);

/// Of the three motors' windings and housings, in air of the protocol's `air_C`.
struct MotorTemperatures {
    Vector3 winding_C{Vector3::Zero()};
    Vector3 housing_C{Vector3::Zero()};
};

/// After so much time without a current, by the two-body network of winding_temperature.h.
[[nodiscard]] MotorTemperatures cooled(const device::DeviceDescription &device, double air_C,
                                       const MotorTemperatures &before, double seconds);

struct WarmUpTrial {
    MotorTemperatures after;              ///< true ones
    Vector3 estimated_C{Vector3::Zero()}; ///< of the windings, by the monitor
    double duration_s = 0.0;
    double tip_way_m = 0.0;    ///< from end to end, once the servo runs
    double hand_force_N = 0.0; ///< largest deviation from that of a hand that holds still
    WarmUpFailure failure = WarmUpFailure::none;
    std::string trip; ///< of the safety monitor, with its numbers; empty: none
};

/// With the relaxed grip of a hand that holds still, at 1 kHz or the first condition's rate.
/// Deterministic; some hundredths of a second for a second.
///
/// A simulated device begins with all windings and housings as warm as the air, which is here the
/// coldest winding. What they were beyond that at the beginning cools by the network; as it is
/// linear, the sum is what a servo would have seen that had watched them all the time.
[[nodiscard]] WarmUpTrial try_warm_up(const Protocol &protocol, const StudySetting &setting,
                                      const MotorTemperatures &before);

} // namespace springdrive::study
