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
#pragma once

#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/psychometric_function.h"
#include "engine/study/protocol/study_setting.h"

#include <cstdint>
#include <memory>
#include <optional>

namespace springdrive::study {

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

class SimulatedSitting {
public:
    /// Keeps copies of what it is given.
    /// @pre validate(protocol) is empty; the setting is the protocol's
    SimulatedSitting(const Protocol &protocol, const StudySetting &setting,
                     const SimulatedParticipant &participant,
                     FeltStimuli felt = FeltStimuli::each_simulated);
    ~SimulatedSitting();
    SimulatedSitting(SimulatedSitting &&) noexcept;
    SimulatedSitting &operator=(SimulatedSitting &&) noexcept;

    /// For `Conduct::present`. Times of presentations are within the trial: its start is 0.
    [[nodiscard]] std::optional<Trial> present(const PlannedTrial &planned);

    /// How long all warm-ups have taken, each before its trial [s].
    [[nodiscard]] double warm_up_s() const;

private:
    class Run;
    std::unique_ptr<Run> run_;
};

} // namespace springdrive::study
