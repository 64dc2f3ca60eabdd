#include "engine/study/observers/simulated_sitting.h"

#include "engine/study/conduct/intervals.h"
#include "engine/study/conduct/presentation.h"
#include "engine/study/observers/felt_level.h"
#include "engine/study/observers/simulated_answer.h"
#include "engine/study/protocol/presented_stimulus.h"
#include "engine/study/protocol/stimulus_trial.h"

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace springdrive::study {

namespace {

// A hand is a bit different each time.
constexpr double kPressSpread = 0.05; ///< of the press or speed: standard deviation of its log
constexpr double kAside_m = 0.001;    ///< it comes down within so much of the spot

constexpr std::uint64_t kHandDraws = 1'000'000; ///< apart from a participant's seeds

/// In the contact plane, uniform in a disc; the press is log-normal.
HandDeviation hand_of(RandomKey key, const TurnFrame &frame) {
    const double radius_m = kAside_m * std::sqrt(uniform(child(key, 0)));
    const double angle = 2.0 * std::numbers::pi * uniform(child(key, 1));
    const Vector3 &axis = frame.turn_axis;
    HandDeviation hand;
    hand.aside_m = radius_m * (std::cos(angle) * axis + std::sin(angle) * axis.cross(frame.normal));
    hand.share = std::exp(kPressSpread * standard_normal(child(key, 2)));
    return hand;
}

} // namespace

class SimulatedSitting::Run {
public:
    Run(const Protocol &protocol, const StudySetting &setting,
        const SimulatedParticipant &participant, FeltStimuli felt)
        : protocol_(protocol), setting_(setting), participant_(participant), felt_(felt) {}

    TrialResult present(const PlannedTrial &planned) {
        TrialResult result;
        std::optional<FeltPresentation> comparison;
        std::optional<FeltPresentation> standard;
        double begins_s = 0.0;
        const std::vector<Interval> intervals = intervals_of(protocol_, planned);
        for (std::size_t i = 0; i < intervals.size(); ++i) {
            const Felt felt = feel(intervals[i], child(child(planned.key, kHandDraws), i));
            add(result, felt, begins_s);
            begins_s = *result.presentations.back().end_s + protocol_.timing.pause_s;
            (intervals[i].is_comparison ? comparison : standard) = felt.what;
            if (intervals[i].is_comparison) {
                result.tuning = settings_of(felt.what.condition);
            }
        }
        const double level = delivered_level(protocol_, *comparison, standard);
        const SimulatedAnswer answer = simulated_answer(protocol_, participant_, planned, level);
        result.response = answer.response;
        result.response_time_s = answer.response_time_s;
        return result;
    }

private:
    struct Felt {
        FeltPresentation what;
        DeliveredStimulus delivered;
        StimulusFailure failure = StimulusFailure::none;
        std::string trip;
    };
    /// Condition, level or none, and place.
    using Distinct = std::tuple<std::size_t, std::optional<double>, int>;

    Felt feel(const Interval &interval, RandomKey key) {
        if (felt_ == FeltStimuli::each_simulated) {
            return simulate(interval.presented, &key);
        }
        const Distinct which{interval.presented.condition, interval.presented.level,
                             interval.target};
        const auto known = measured_.find(which);
        return known != measured_.end()
                   ? known->second
                   : measured_.emplace(which, simulate(interval.presented, nullptr)).first->second;
    }

    /// @param key  of the hand's deviations; null: none
    [[nodiscard]] Felt simulate(const Presented &presented, const RandomKey *key) const {
        StimulusCircumstances circumstances;
        if (key != nullptr) {
            circumstances.hand = hand_of(*key, stimulus_of(protocol_, setting_, presented).frame);
        }
        const StimulusTrial trial = try_stimulus(protocol_, setting_, presented, circumstances);
        return {{presented.parameters, intended_measures(protocol_, setting_, presented),
                 trial.delivered.measures},
                trial.delivered,
                trial.failure,
                trial.trip};
    }

    static void add(TrialResult &result, const Felt &felt, double begins_s) {
        Presentation presentation = presentation_of(felt.what.intended, felt.delivered);
        presentation.start_s = begins_s + felt.delivered.start_s;
        presentation.end_s = begins_s + felt.delivered.end_s;
        if (!felt.trip.empty()) {
            result.safety_events.push_back({presentation.end_s, felt.trip});
        } else if (felt.failure != StimulusFailure::none) {
            result.marks.emplace_back(description(felt.failure));
        }
        result.missed_deadlines += felt.delivered.missed_deadlines;
        const Vector3 &winding_C = felt.delivered.winding_C;
        result.windings_degC = {winding_C[0], winding_C[1], winding_C[2]};
        result.presentations.push_back(std::move(presentation));
    }

    Protocol protocol_;
    StudySetting setting_;
    SimulatedParticipant participant_;
    FeltStimuli felt_;
    std::map<Distinct, Felt> measured_;
};

SimulatedSitting::SimulatedSitting(const Protocol &protocol, const StudySetting &setting,
                                   const SimulatedParticipant &participant, FeltStimuli felt)
    : run_(std::make_unique<Run>(protocol, setting, participant, felt)) {}
SimulatedSitting::~SimulatedSitting() = default;
SimulatedSitting::SimulatedSitting(SimulatedSitting &&) noexcept = default;
SimulatedSitting &SimulatedSitting::operator=(SimulatedSitting &&) noexcept = default;

std::optional<TrialResult> SimulatedSitting::present(const PlannedTrial &planned) {
    return run_->present(planned);
}

} // namespace springdrive::study
