// A protocol checked before anybody sits down: what is found, by which checks.
#pragma once

#include "engine/study/protocol/session_plan.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::study {

enum class Severity : std::uint8_t {
    error,   ///< nobody should sit down before it is repaired
    warning, ///< to be judged
    note,    ///< to be known
};

struct ProtocolFinding {
    Severity severity = Severity::error;
    std::string where;  ///< "condition \"soft\" at level 0.9", "breaks"
    std::string what;   ///< with the figures that show it
    std::string remedy; ///< what to do; empty for most notes
};

using ProtocolFindings = std::vector<ProtocolFinding>;

/// "error: WHERE: WHAT; REMEDY", on one line.
[[nodiscard]] std::string text_of(const ProtocolFinding &finding);

// What is found when each stimulus of a protocol is presented to a simulated hand, before anybody
// sits down. The hand is the relaxed grip of `device::HandParameters`.

/// The tip may slide so far from where it touched [m]. In a cup it yields, but does not slide.
inline constexpr double kMaxSlide_m = 0.003;

/// And shake so fast [m/s]: as an oscillation by an encoder count, 0.03 mm at the tip, at 100 Hz.
inline constexpr double kMaxShaking_m_per_s = 0.02;

/// What is wrong with what was seen.
[[nodiscard]] ProtocolFindings findings_of(const Protocol &protocol,
                                           const std::vector<StimulusTrial> &trials);

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

/// Names of conditions, blocks and questions that persons take for one, see `look_alike`.
[[nodiscard]] ProtocolFindings check_names(const Protocol &protocol);

/// QUEST+ whose grid keeps the experimenter's window waiting for longer than `kMaxChoice_s` at the
/// first trial of a block, which makes the table of each of its conditions. Of the table's size,
/// not measured, so that a protocol that is well on one machine is on all.
inline constexpr double kMaxChoice_s = 0.05;
[[nodiscard]] ProtocolFindings check_choices(const Protocol &protocol);

/// Spots on their surface, within reach, free to approach and clear of the workspace's soft edge.
[[nodiscard]] ProtocolFindings check_spots(const Protocol &protocol, const StudySetting &setting);

/// Force, current, voltage, depth and energy by statics, see `predicted_press`.
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

// A protocol checked as a whole, before anybody sits down: by reckoning, and by simulating each
// condition.

struct CheckOptions {
    bool simulates = true; ///< each condition at its extremes, some tenths of a second each
};

struct CheckedProtocol {
    ProtocolFindings findings; ///< errors first
    SessionLength length;
    std::vector<StimulusTrial> trials; ///< that were simulated
    double hottest_winding_C = 0.0;    ///< of the session, at the condition that heats most
};

/// All checks, whatever they find.
/// @pre validate(protocol) is empty
/// @throw InputError if the device cannot be read.
[[nodiscard]] CheckedProtocol check_protocol(const Protocol &protocol,
                                             const ProtocolFolders &folders,
                                             const CheckOptions &options = {});

} // namespace springdrive::study
