// The single checks of protocol_check.h.
#pragma once

#include "engine/study/protocol/predicted_press.h"
#include "engine/study/protocol/presented.h"
#include "engine/study/protocol/protocol_finding.h"
#include "engine/study/protocol/session_length.h"
#include "engine/study/protocol/study_setting.h"

#include <cstddef>
#include <vector>

namespace springdrive::study {

/// What was found of one stimulus.
struct StimulusFinding {
    std::size_t condition = 0;
    ProtocolFinding finding;
};

/// Of those of one condition that have the same remedy only the first, with how many more there
/// are.
[[nodiscard]] ProtocolFindings once_per_condition(const std::vector<StimulusFinding> &all);

/// Conditions that are compared must be the same in free space, see protocol.h. Lags may differ by
/// `kSameLag` of them: of the 10 g or so that they add, 0.1 g.
inline constexpr double kSameLag = 0.01;
[[nodiscard]] ProtocolFindings check_free_space(const Protocol &protocol,
                                                const device::DeviceDescription &device);

/// Every loop of every stimulus with every hand of `tune`, at the spot: each motor alone and all
/// three, in contact, in free space, and on the way between their tunings. Where a factor of
/// `kGainMargin` on K_P and K_D is enough to make it unstable, that is a warning.
inline constexpr double kGainMargin = 1.1;
[[nodiscard]] ProtocolFindings check_stability(const Protocol &protocol,
                                               const StudySetting &setting,
                                               const std::vector<Presented> &presented);

/// Spots on their surface, within reach, free to approach and clear of the workspace's soft edge.
[[nodiscard]] ProtocolFindings check_spots(const Protocol &protocol, const StudySetting &setting);

/// Force, current, voltage, depth and energy by statics, see predicted_press.h.
[[nodiscard]] ProtocolFindings check_limits(const Protocol &protocol, const StudySetting &setting,
                                            const std::vector<Presented> &presented);

/// Bands of `[marking]` in which even a stimulus that is as intended would not be found, see
/// `count_angle_deg`.
[[nodiscard]] ProtocolFindings check_marking(const Protocol &protocol, const StudySetting &setting,
                                             const std::vector<Presented> &presented);

/// By how much an encoder count turns the direction that is measured of a press or a pulse [°], of
/// the motor whose count turns it most:
///
///   pulse   the current that the law alone drives follows k_T θ̇ (11), so a count ε of motor j is
///           an impulse of J⁻ᵀ e_j k_T² ε/dR. Its part across the pulse, against the pulse's own
///           impulse, ½ height/frequency.
///   press   the force is J⁻ᵀ k_T i, and J is that of the angles: turned by a count.
///
/// 0 of other stimuli, and where nothing is pressed.
[[nodiscard]] double count_angle_deg(const Protocol &protocol, const StudySetting &setting,
                                     const Presented &presented);

/// Trials and minutes, breaks and the balance of orders.
[[nodiscard]] ProtocolFindings check_session(const Protocol &protocol, const SessionLength &length);

/// What precision is to be expected of a participant's thresholds, by simulated observers who are
/// as [expected] says. Only told, not judged.
[[nodiscard]] ProtocolFindings check_precision(const Protocol &protocol);

/// The windings' temperatures over a session of the stimulus that heats most, and of the mean one.
struct SessionWarmth {
    ProtocolFindings findings;
    double hottest_C = 0.0;
};
[[nodiscard]] SessionWarmth check_warmth(const Protocol &protocol, const StudySetting &setting,
                                         const std::vector<Presented> &presented,
                                         const SessionLength &length);

} // namespace springdrive::study
