#include "engine/study/observers/simulated_study_session.h"

#include "engine/study/protocol/stimulus_trial.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

namespace springdrive::study {

namespace {

/// Of the delivered to the intended stiffness; 1 where it was not measured.
double stiffness_share(const FeltPresentation &felt) {
    const std::optional<double> &came = felt.delivered.stiffness_N_per_m;
    const std::optional<double> &intended = felt.intended.stiffness_N_per_m;
    return came && intended && *came > 0.0 && *intended > 0.0 ? *came / *intended : 1.0;
}

/// What the participant draws in a trial.
enum class Drawn : std::uint64_t { bias, perception, guess, time };

RandomKey key_of_draw(const SimulatedParticipant &participant, const PlannedTrial &planned,
                      Drawn what) {
    return child(child(RandomKey{planned.seed}, participant.seed),
                 static_cast<std::uint64_t>(what));
}

/// In (0, 1): no end of a distribution is drawn.
double inner_uniform(RandomKey key) { return std::clamp(uniform(key), 0x1p-53, 1.0 - 0x1p-53); }

double proportion_of(const PsychometricFunction &function, double level) {
    return proportion_at(
        function, function.family.scale == Scale::logarithmic ? std::max(0.0, level) : level);
}

/// The level to which it is set: about the threshold, distributed as F.
double setting_of(const Protocol &protocol, const PsychometricFunction &function, double drawn) {
    const Scale scale = function.family.scale;
    const double level =
        level_from(scale, on_scale(scale, function.threshold) +
                              core_argument(function.family.shape, drawn) / function.slope);
    const auto *adjustment = std::get_if<Adjustment>(&protocol.method);
    return adjustment == nullptr
               ? level
               : std::clamp(level, adjustment->minimum_level, adjustment->maximum_level);
}

Response response_of(const Protocol &protocol, const SimulatedParticipant &participant,
                     const PlannedTrial &planned, double level) {
    const auto draw = [&](Drawn what) {
        return inner_uniform(key_of_draw(participant, planned, what));
    };
    if (protocol.task.kind == TaskKind::adjustment) {
        return Adjusted{setting_of(protocol, participant.function, draw(Drawn::perception))};
    }
    const bool is_biased = draw(Drawn::bias) < std::abs(participant.bias);
    const bool is_positive = draw(Drawn::perception) < proportion_of(participant.function, level);
    if (protocol.task.kind == TaskKind::yes_no) {
        return YesNo{is_biased ? participant.bias > 0.0 : is_positive};
    }
    const int alternatives = protocol.task.alternatives;
    if (is_biased) {
        return Chosen{participant.bias > 0.0 ? 1 : alternatives};
    }
    const int right = planned.target.value();
    if (is_positive) {
        return Chosen{right};
    }
    const auto further = static_cast<int>(below(key_of_draw(participant, planned, Drawn::guess),
                                                static_cast<std::size_t>(alternatives - 1)));
    return Chosen{(right + further) % alternatives + 1};
}

// A hand is a bit different each time.
constexpr double kPressSpread = 0.05; ///< of the press or speed: standard deviation of its log
constexpr double kAside_m = 0.001;    ///< it comes down within so much of the spot

constexpr std::uint64_t kHandDraws = 1'000'000; ///< apart from a participant's seeds

/// The mean of what windings and housings would meet at.
double mean_meeting_C(const device::DeviceDescription &device, const MotorTemperatures &motors) {
    double sum_C = 0.0;
    for (Eigen::Index j = 0; j < 3; ++j) {
        sum_C += meeting_C(device.motor[static_cast<std::size_t>(j)].thermal, motors.winding_C[j],
                           motors.housing_C[j]);
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

SimulatedAnswer simulated_answer(const Protocol &protocol, const SimulatedParticipant &participant,
                                 const PlannedTrial &planned, double level) {
    const double deviations = standard_normal(key_of_draw(participant, planned, Drawn::time));
    const double time_s =
        participant.response_median_s * std::exp(participant.response_spread * deviations);
    if (time_s > protocol.timing.response_s) {
        return {NoResponse{}, std::nullopt};
    }
    return {response_of(protocol, participant, planned, level), time_s};
}

class SimulatedStudySession::Run {
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
            warmed_C_ = mean_meeting_C(setting_.device, motors_);
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

SimulatedStudySession::SimulatedStudySession(const Protocol &protocol, const StudySetting &setting,
                                             const SimulatedParticipant &participant,
                                             FeltStimuli felt)
    : run_(std::make_unique<Run>(protocol, setting, participant, felt)) {}
SimulatedStudySession::~SimulatedStudySession() = default;
SimulatedStudySession::SimulatedStudySession(SimulatedStudySession &&) noexcept = default;
SimulatedStudySession &
SimulatedStudySession::operator=(SimulatedStudySession &&) noexcept = default;

double SimulatedStudySession::warm_up_s() const { return run_->warm_up_s(); }

std::optional<Trial> SimulatedStudySession::present(const PlannedTrial &planned) {
    return run_->present(planned);
}

} // namespace springdrive::study
