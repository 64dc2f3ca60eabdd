#include "engine/study/observers/simulated_sitting.h"

#include "engine/study/conduct/presentation.h"
#include "engine/study/observers/perceived_level.h"
#include "engine/study/observers/simulated_answer.h"
#include "engine/study/protocol/presented_stimulus.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/warm_up_trial.h"

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

/// The mean of what windings and housings would meet at.
double meeting_C(const device::DeviceDescription &device, const MotorTemperatures &motors) {
    double sum_C = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        const device::ThermalParameters &thermal =
            device.motor[static_cast<std::size_t>(j)].thermal;
        const double C_w = thermal.winding_time_s / thermal.winding_housing_K_per_W;
        const double C_h = thermal.motor_time_s / thermal.housing_ambient_K_per_W;
        sum_C += (C_w * motors.winding_C[j] + C_h * motors.housing_C[j]) / (C_w + C_h);
    }
    return sum_C / 3.0;
}

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
        : protocol_(protocol), setting_(setting), participant_(participant), felt_(felt) {
        const Vector3 air_C = Vector3::Constant(protocol.windings.air_C);
        motors_ = {air_C, air_C};
    }

    Trial present(const PlannedTrial &planned) {
        Trial trial(planned);
        std::optional<FeltPresentation> comparison;
        std::optional<FeltPresentation> standard;
        double begins_s = 0.0;
        warm_if_needed(trial);
        const std::vector<Presented> intervals = intervals_of(protocol_, planned);
        for (std::size_t i = 0; i < intervals.size(); ++i) {
            const Felt felt =
                feel(intervals[i], child(child(RandomKey{planned.seed}, kHandDraws), i));
            add(trial, felt, begins_s);
            pass(felt.seen.duration_s + (i > 0 ? protocol_.timing.pause_s : 0.0), felt.seen);
            begins_s = *trial.presentations.back().end_s + protocol_.timing.pause_s;
            (intervals[i].level ? comparison : standard) = felt.what;
            if (intervals[i].level) {
                trial.tuning = settings_of(felt.what.condition);
            }
        }
        trial.windings_degC = {motors_.winding_C[0], motors_.winding_C[1], motors_.winding_C[2]};
        motors_ = cooled(setting_.device, protocol_.windings.air_C, motors_,
                         protocol_.timing.expected_response_s + protocol_.timing.between_trials_s);
        const double level = delivered_level(protocol_, *comparison, standard);
        const SimulatedAnswer answer = simulated_answer(protocol_, participant_, planned, level);
        trial.response = answer.response;
        trial.response_time_s = answer.response_time_s;
        return trial;
    }

    [[nodiscard]] double warm_up_s() const { return warm_up_s_; }

private:
    struct Felt {
        FeltPresentation what;
        StimulusTrial seen;
    };
    /// Condition, level or none, and place.
    using Distinct = std::tuple<std::size_t, std::optional<double>, int>;

    Felt feel(const Presented &presented, RandomKey key) {
        if (felt_ == FeltStimuli::each_simulated) {
            return simulate(presented, &key);
        }
        const Distinct which{presented.condition, presented.level, presented.target};
        const auto known = measured_.find(which);
        return known != measured_.end()
                   ? known->second
                   : measured_.emplace(which, simulate(presented, nullptr)).first->second;
    }

    /// @param key  of the hand's deviations; null: none
    [[nodiscard]] Felt simulate(const Presented &presented, const RandomKey *key) const {
        StimulusCircumstances circumstances;
        circumstances.winding_C = warmed_C_;
        if (key != nullptr) {
            circumstances.hand = hand_of(*key, stimulus_of(protocol_, setting_, presented).frame);
        }
        const StimulusTrial seen = try_stimulus(protocol_, setting_, presented, circumstances);
        return {{presented.parameters, intended_measures(protocol_, setting_, presented),
                 seen.delivered.measures},
                seen};
    }

    /// What a participant is presented is simulated from what the first one
    /// leaves, so that no result depends on the trials before.
    void warm_if_needed(Trial &trial) {
        if (!WarmUp::is_needed(protocol_.windings, motors_.winding_C)) {
            return;
        }
        const WarmUpTrial warm_up = try_warm_up(protocol_, setting_, motors_);
        motors_ = warm_up.after;
        warm_up_s_ += warm_up.duration_s;
        if (!warmed_C_) {
            warmed_C_ = meeting_C(setting_.device, motors_);
        }
        if (!warm_up.trip.empty()) {
            trial.safety_events.push_back({warm_up.duration_s, warm_up.trip});
        } else if (warm_up.failure != WarmUpFailure::none) {
            trial.marks.emplace_back(description(warm_up.failure));
        }
    }

    void pass(double seconds, const StimulusTrial &seen) {
        motors_ = cooled(setting_.device, protocol_.windings.air_C, motors_, seconds);
        motors_.winding_C += seen.winding_rise_K;
        motors_.housing_C += seen.housing_rise_K;
    }

    static void add(Trial &trial, const Felt &felt, double begins_s) {
        const DeliveredStimulus &delivered = felt.seen.delivered;
        Presentation presentation = presentation_of(felt.what.intended, delivered);
        presentation.start_s = begins_s + delivered.start_s;
        presentation.end_s = begins_s + delivered.end_s;
        if (!felt.seen.trip.empty()) {
            trial.safety_events.push_back({presentation.end_s, felt.seen.trip});
        } else if (felt.seen.failure != StimulusFailure::none) {
            trial.marks.emplace_back(description(felt.seen.failure));
        }
        trial.missed_deadlines += delivered.missed_deadlines;
        trial.presentations.push_back(std::move(presentation));
    }

    Protocol protocol_;
    StudySetting setting_;
    SimulatedParticipant participant_;
    FeltStimuli felt_;
    double warm_up_s_ = 0.0;         ///< of all warm-ups
    MotorTemperatures motors_;       ///< of the session so far
    std::optional<double> warmed_C_; ///< by the first warm-up
    std::map<Distinct, Felt> measured_;
};

SimulatedSitting::SimulatedSitting(const Protocol &protocol, const StudySetting &setting,
                                   const SimulatedParticipant &participant, FeltStimuli felt)
    : run_(std::make_unique<Run>(protocol, setting, participant, felt)) {}
SimulatedSitting::~SimulatedSitting() = default;
SimulatedSitting::SimulatedSitting(SimulatedSitting &&) noexcept = default;
SimulatedSitting &SimulatedSitting::operator=(SimulatedSitting &&) noexcept = default;

double SimulatedSitting::warm_up_s() const { return run_->warm_up_s(); }

std::optional<Trial> SimulatedSitting::present(const PlannedTrial &planned) {
    return run_->present(planned);
}

} // namespace springdrive::study
