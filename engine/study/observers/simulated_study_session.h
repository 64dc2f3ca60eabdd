// Simulated participants: what they feel, what they answer, and their sessions.
#pragma once

#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/protocol.h"
#include "engine/study/protocol/study_setting.h"
#include "engine/study/stimuli/stimulus.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace springdrive::study {

/// A presentation: its condition, and what it was measured by.
struct FeltPresentation {
    Condition condition;
    StimulusMeasures intended;
    StimulusMeasures delivered;
};

/// The variable under test as it was delivered: angle, pulse, press and speed as measured; of η,
/// K_P and dR in contact what would give the measured stiffness; of anything else the intended
/// value, as of what was not measured.
///
///   η = 1 − (1 − η_i) k      K_P = K_P,i k      dR = dR_i/k      k delivered over intended
///   stiffness
[[nodiscard]] double delivered_value(const Protocol &protocol, const FeltPresentation &felt);

/// The same as a level of the method. Without a standard in the trial it is what the protocol says.
[[nodiscard]] double delivered_level(const Protocol &protocol, const FeltPresentation &comparison,
                                     const std::optional<FeltPresentation> &standard);

// A session of a simulated participant on the simulated device: a study tried without people.
//
// Each presentation is the whole servo in closed loop with the simulated device, held by a relaxed
// hand, as in a study with people; what was delivered is measured from the servo's samples. The
// participant judges the delivered level, not the intended one, with a psychometric function that
// is known: so an analysis can be held against the truth.
//
// A session begins with windings as cold as the air, and warms them to the protocol's band before
// the first trial and before any other for which one is too cold, by `WarmUp` on the simulated
// device. Their temperatures follow from the heat of all presentations, and the times between.
//
// What is presented and answered in a trial is a function of protocol, setting, participant and
// planned trial alone: each presentation begins with windings and housings as the first warm-up has
// left them. So a session that was stopped goes on with what an undisturbed one would have given;
// only warm-ups, times and the temperatures that are stored are its own. Breaks are not simulated.

struct SimulatedParticipant {
    /// Of a level, as the method means it: the probability of a right answer in a forced choice, of
    /// "yes" in a yes/no task. A setting of an adjustment lies about the threshold, as F does.
    PsychometricFunction function;
    double response_median_s = 0.6; ///< response times are log-normal
    double response_spread = 0.25;  ///< standard deviation of their logarithm
    /// The share of trials in which the answer is the first alternative, or yes, whatever was felt;
    /// below 0: the last alternative, or no. −1 to 1.
    double bias = 0.0;
    std::uint64_t seed = 1; ///< of all that the participant draws
};

/// What a participant is given to feel.
enum class FeltStimuli : std::uint8_t {
    each_simulated, ///< every presentation through the simulated device, the hand a bit different
    measured_once,  ///< each condition at each level once, by a hand as the protocol says; reused
};

class SimulatedStudySession {
public:
    /// Keeps copies of what it is given.
    /// @pre validate(protocol) is empty; the setting is the protocol's
    SimulatedStudySession(const Protocol &protocol, const StudySetting &setting,
                          const SimulatedParticipant &participant,
                          FeltStimuli felt = FeltStimuli::each_simulated);
    ~SimulatedStudySession();
    SimulatedStudySession(SimulatedStudySession &&) noexcept;
    SimulatedStudySession &operator=(SimulatedStudySession &&) noexcept;

    /// For `Conduct::present`. Times of presentations are within the trial: its start is 0.
    [[nodiscard]] std::optional<Trial> present(const PlannedTrial &planned);

    /// How long all warm-ups have taken, each before its trial [s].
    [[nodiscard]] double warm_up_s() const;

private:
    class Run;
    std::unique_ptr<Run> run_;
};

struct SimulatedAnswer {
    Response response; ///< none if it came too late
    std::optional<double> response_time_s;
};

/// A function of its arguments alone.
/// @param level  as it was delivered; below 0 on a logarithmic scale it counts as none
[[nodiscard]] SimulatedAnswer simulated_answer(const Protocol &protocol,
                                               const SimulatedParticipant &participant,
                                               const PlannedTrial &planned, double level);

} // namespace springdrive::study
