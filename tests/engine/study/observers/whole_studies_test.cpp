// Covers engine/study/observers and engine/study/stimuli as a whole, on the simulated device:
// studies of participants whose function is known, every presentation through the device, one by
// default, 20 by tests/long; one device for a long time, whose windings warm up: what was delivered
// against what was intended, by the plant's true state, a minute by default, an hour by tests/long;
// and whether free space tells that the condition in contact is another one.
//
// For the last, dR and λ in contact are others than those shared in free space in half of the
// presentations; in the others they are the shared ones. A linear classifier looks at the servo's
// telemetry in free space: before the touch, and in a stroke after it that is the same motion
// whatever was felt. (On the way out of the contact itself a hand is faster where it pressed
// deeper: that tells what was felt, not what free space is.) 60 presentations by default, 4000 by
// tests/long.
#include "base/degrees.h"
#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/rig/servo_rig.h"
#include "engine/study/analysis/posterior.h"
#include "engine/study/conduct/conduct.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/observers/simulated_study_session.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "engine/study/protocol/study_setting.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/cases.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::study {
namespace {

/// Force-direction discrimination as it is shipped, of one of its conditions, in 40 trials.
Protocol short_direction_protocol() {
    Protocol protocol = read_protocol_file(testing::assets() / "protocols" / "direction.toml");
    protocol.blocks = {{"one", {2}}};
    auto &method = std::get<QuestPlus>(protocol.method);
    method.min_trials = 40;
    method.max_trials = 40;
    protocol.practice = {};
    protocol.catch_trials = {};
    return protocol;
}

UtcTime some_time() {
    using namespace std::chrono;
    return UtcTime(sys_days(2026y / January / 1));
}

struct WholeStudy {
    SessionEnding ending = SessionEnding::failed;
    std::vector<Trial> trials;
};

WholeStudy whole_study(const Protocol &protocol, const StudySetting &setting,
                       const SimulatedParticipant &participant) {
    StudyStore store = StudyStore::in_memory({protocol.title, "text", "0.1.0"}, some_time());
    store.add({"P01", 1, some_time()});
    Session session;
    session.participant = "P01";
    session.started = some_time();
    session.software = "0.1.0";
    session.id = store.begin(session);
    SimulatedStudySession study_session(protocol, setting, participant);
    Conduct how;
    how.present = [&study_session](const PlannedTrial &planned) {
        return study_session.present(planned);
    };
    how.ends = [] { return std::nullopt; };
    how.now = some_time;
    const SessionEnding ending = conduct(store, protocol, session, how);
    return {ending, store.contents().trials};
}

std::vector<PastMethodTrial> counting(const Protocol &protocol, const std::vector<Trial> &trials) {
    std::vector<PastMethodTrial> counted;
    for (const Trial &trial : trials) {
        if (counts(trial)) {
            counted.push_back({{*trial.level, 0}, outcome_of(protocol, trial)});
        }
    }
    return counted;
}

TEST(WholeStudies, GiveBackTheTruthOfTheirParticipants) {
    const Protocol protocol = short_direction_protocol();
    const StudySetting setting =
        study_setting(protocol, {testing::assets() / "protocols", testing::assets()});
    // What the method takes to be likely; the truths are drawn from it.
    const FunctionPriors priors = priors_of(std::get<QuestPlus>(protocol.method));
    const int studies = testing::cases(1, 20);
    int held = 0;
    std::size_t all_trials = 0;
    std::size_t marked = 0;
    for (int i = 0; i < studies; ++i) {
        const RandomKey key = child(RandomKey{20'260'101}, static_cast<std::uint64_t>(i));
        SimulatedParticipant participant;
        participant.function = drawn_function(priors, child(key, 0));
        participant.seed = key.bits;
        const WholeStudy study = whole_study(protocol, setting, participant);
        EXPECT_EQ(study.ending, SessionEnding::completed);
        const std::vector<PastMethodTrial> trials = counting(protocol, study.trials);
        EXPECT_EQ(trials.size(), 40U);
        all_trials += study.trials.size();
        marked += study.trials.size() - trials.size();
        const PosteriorSummary threshold =
            Posterior(counted(trials), priors).of(FunctionParameter::threshold);
        held += threshold.low <= participant.function.threshold &&
                        participant.function.threshold <= threshold.high
                    ? 1
                    : 0;
    }
    std::printf("counts: %d of %d intervals of 95 %% hold the truth; %zu trials, %zu marked\n",
                held, studies, all_trials, marked);
    // Of 20 at 95 % fewer than 16 hold the truth once in 390 times; of one, this seed's does.
    EXPECT_GE(held, studies == 1 ? 1 : 16);
    EXPECT_LE(marked, all_trials / 20);
}

/// Of the settled half of a press, by true currents and the true tip.
struct TruePress {
    Vector3 force_sum_N{Vector3::Zero()};
    double F_delta = 0.0;
    double delta_squares = 0.0;
};

/// Two newtons at any angle up to 40°, in a cup, one after the other.
Protocol warming_protocol() {
    Protocol protocol = read_protocol_file(testing::assets() / "protocols" / "direction.toml");
    protocol.conditions.resize(1);
    protocol.blocks = {{"one", {0}}};
    protocol.conditions[0].press_N = 2.0;
    protocol.timing.rest_s = 0.2;
    protocol.timing.approach_s = 4.0; // the hand waits as if the servo had to start each time
    return protocol;
}

TEST(StimuliOfAnHour, AreWithinTheirBandsOrMarkedWhileTheMotorsWarm) {
    const Protocol protocol = warming_protocol();
    const StudySetting setting =
        study_setting(protocol, {testing::assets() / "protocols", testing::assets()});
    simulated::SimulationOptions options;
    options.servo_period_s = 1e-3;
    options.delay_periods = protocol.conditions[0].delay_periods;
    options.ambient_C = 25.0;
    const Vector3 start_m =
        setting.conditions[0].spot.point_m + kApproach_m * setting.conditions[0].spot.normal;
    rig::ServoRig rig(setting.device, options, start_m, setting.conditions[0].surface.get());
    rig.inputs.global_alpha_rad2_per_m2 = setting.global_alpha_rad2_per_m2;
    rig.inputs.observes_resistance = true;

    const double whole_s = testing::cases(30, 3600);
    int presented = 0;
    int marked = 0;
    double worst_stiffness = 0.0;
    double worst_deg = 0.0;
    double worst_marked_deg = 0.0;
    const double k_T = setting.device.motor[0].torque_constant_Nm_per_A;
    while (rig.last.time_s < whole_s) {
        const RandomKey key = child(RandomKey{41}, static_cast<std::uint64_t>(presented));
        Condition parameters = protocol.conditions[0];
        parameters.turn_deg = 40.0 * uniform(child(key, 0));
        parameters.turn_axis_deg = 360.0 * uniform(child(key, 1)) - 180.0;
        const Presented one{0, std::nullopt, parameters, parameters.tuning};
        const Stimulus stimulus = stimulus_of(protocol, setting, one);
        const HandTrajectory trajectory = hand_trajectory(setting, one, stimulus, {});
        rig.phantom().follow(simulated::HandPath(trajectory.points));
        StimulusRun run(setting.device, stimulus, options.servo_period_s);
        DeliveryMeter meter(setting.device, stimulus, options.servo_period_s);
        TruePress truth;
        const auto ticks = std::lround(trajectory.points.back().time_s / options.servo_period_s);
        for (long tick = 0; tick < ticks; ++tick) {
            const servo::ServoSample &sample = rig.tick();
            run.update(sample, rig.inputs);
            meter.take(sample, run);
            if (run.phase() == StimulusPhase::presenting &&
                run.presented_s() > 0.5 * stimulus.presentation_s) {
                const auto &state = rig.truth();
                const Matrix3 J = device::motor_jacobian(
                    setting.device.geometry,
                    device::joint_from_motor(setting.device.geometry, state.theta_rad));
                const Vector3 force_N = J.transpose().inverse() * (k_T * state.current_A);
                const double delta_m = stimulus.frame.normal.dot(sample.contact.x0_m - state.tip_m);
                truth.force_sum_N += force_N;
                truth.F_delta += stimulus.frame.normal.dot(force_N) * delta_m;
                truth.delta_squares += delta_m * delta_m;
            }
        }
        ASSERT_FALSE(rig.has_tripped()) << servo::description(rig.last.safety);
        ++presented;
        const StimulusMeasures intended = intended_measures(protocol, setting, one);
        const Presentation stored = presentation_of(intended, meter.delivered());
        const bool is_marked = run.failure() != StimulusFailure::none ||
                               !marks_of(protocol.marking, {&stored, 1}).empty();
        const double off_deg =
            kDegreesPerRadian * std::atan2(truth.force_sum_N.cross(stimulus.direction).norm(),
                                           truth.force_sum_N.dot(stimulus.direction));
        if (is_marked) {
            ++marked;
            worst_marked_deg = std::max(worst_marked_deg, off_deg);
            continue;
        }
        worst_deg = std::max(worst_deg, off_deg);
        worst_stiffness = std::max(
            worst_stiffness,
            std::abs(truth.F_delta / truth.delta_squares / *intended.stiffness_N_per_m - 1.0));
    }
    const Vector3 winding_C = rig.truth().winding_C;
    std::printf("worst of %d, %d of them marked: stiffness %.2f %%, direction %.2f deg; windings "
                "to %.0f degC\n",
                presented, marked, 100.0 * worst_stiffness, worst_deg, winding_C.maxCoeff());
    // The true tip lies within half an encoder count, 0.015 mm, of the measured one, at an
    // indentation of 1.2 mm: 1.3 % on top of the band of 2 %.
    EXPECT_LT(worst_stiffness, 0.02 + 0.013);
    // In and out of the plane of the turn up to 1° each.
    EXPECT_LT(worst_deg, std::numbers::sqrt2);
    EXPECT_LT(marked, presented / 10 + 1);
    EXPECT_GT(winding_C.maxCoeff(), 25.5) << "they warm";
}

/// Before the touch and in the stroke after it: of the force at the tip the root mean square along
/// each axis and how much of it goes with velocity and with acceleration; of e_W and of the
/// currents the root mean square; the root mean square of the velocity.
constexpr Eigen::Index kFeaturesOfAWay = 3 + 2 + 2 + 1;
using Features = Eigen::Matrix<double, kFeaturesOfAWay, 1>;

/// Of one presentation.
struct Ways {
    Features before;
    Features after;
};

/// Sums over one way through free space.
class WaySums {
public:
    void take(const servo::ServoSample &sample) {
        if (ticks_ > 0) {
            const Vector3 velocity = (sample.tip_m - last_tip_m_) / 1e-3;
            if (ticks_ > 1) {
                const Vector3 acceleration = (velocity - last_velocity_) / 1e-3;
                F_v_ += sample.tip_force_N.dot(velocity);
                F_a_ += sample.tip_force_N.dot(acceleration);
                a_a_ += acceleration.squaredNorm();
            }
            v_v_ += velocity.squaredNorm();
            last_velocity_ = velocity;
        }
        last_tip_m_ = sample.tip_m;
        F_F_ += sample.tip_force_N.cwiseAbs2();
        e_e_ += sample.command.e_W_V.squaredNorm();
        i_i_ += sample.current_A.squaredNorm();
        ++ticks_;
    }
    [[nodiscard]] Features features() const {
        const auto n = static_cast<double>(std::max(1L, ticks_));
        Features all;
        all << (F_F_ / n).cwiseSqrt(), F_v_ / (v_v_ + 1e-12), F_a_ / (a_a_ + 1e-12),
            std::sqrt(e_e_ / n), std::sqrt(i_i_ / n), std::sqrt(v_v_ / n);
        return all;
    }

private:
    long ticks_ = 0;
    Vector3 last_tip_m_{Vector3::Zero()};
    Vector3 last_velocity_{Vector3::Zero()};
    Vector3 F_F_{Vector3::Zero()};
    double F_v_ = 0.0;
    double F_a_ = 0.0;
    double a_a_ = 0.0;
    double v_v_ = 0.0;
    double e_e_ = 0.0;
    double i_i_ = 0.0;
};

Protocol protocol_of_case(bool is_changed, bool is_told) {
    Protocol protocol = testing::protocol_of(testing::kPlainProtocol);
    protocol.variable.standard = 0.0;
    protocol.free_space = FreeSpaceTuning{0.8, 800.0};
    protocol.free_space_is_stimulus = is_told;
    protocol.timing.presentation_s = 0.5;
    Condition &condition = protocol.conditions[0];
    condition.hold = Hold::cup;
    condition.tuning.dR_Ohm = is_changed ? 0.5 : 0.8;
    condition.tuning.lambda_rad_per_s = is_changed ? 1200.0 : 800.0;
    condition.tuning.K_P_V_per_rad = 7.0;
    return protocol;
}

/// Of a hand that is another one each time.
Ways ways_of_case(int number, bool is_changed, bool is_told) {
    const Protocol protocol = protocol_of_case(is_changed, is_told);
    const StudySetting setting = study_setting(protocol, testing::folders());
    const RandomKey key = child(RandomKey{909}, static_cast<std::uint64_t>(number));
    StimulusCircumstances circumstances;
    circumstances.hand.share = 0.8 + 0.4 * uniform(child(key, 0));
    circumstances.hand.aside_m =
        1e-3 * Vector3(uniform(child(key, 1)) - 0.5, 0.0, uniform(child(key, 2)) - 0.5);
    circumstances.device_seed = 3; // its sensors have noise
    circumstances.strokes_after_s = 1.0;
    WaySums before;
    std::vector<servo::ServoSample> at_last;
    circumstances.watch = [&](const servo::ServoSample &sample, StimulusPhase phase) {
        if (sample.contact.touching || sample.safety.state != servo::SafetyState::running) {
            return;
        }
        if (phase == StimulusPhase::waiting || phase == StimulusPhase::approaching) {
            before.take(sample);
        } else if (phase == StimulusPhase::done) {
            at_last.push_back(sample);
        }
    };
    const StimulusTrial trial =
        try_stimulus(protocol, setting, all_presented(protocol)[0], circumstances);
    EXPECT_EQ(trial.failure, StimulusFailure::none) << trial.trip;
    constexpr std::size_t kStrokeTicks = 1000;
    EXPECT_GT(at_last.size(), kStrokeTicks);
    WaySums after;
    for (std::size_t i = at_last.size() - kStrokeTicks; i < at_last.size(); ++i) {
        after.take(at_last[i]);
    }
    return {before.features(), after.features()};
}

/// The share that Fisher's discriminant tells rightly, each tenth by what it learnt of the others.
double told_rightly(const std::vector<Features> &all, const std::vector<bool> &is_changed) {
    constexpr std::size_t kFolds = 10;
    Features mean = Features::Zero();
    Features scale = Features::Zero();
    for (const Features &one : all) {
        mean += one / static_cast<double>(all.size());
    }
    for (const Features &one : all) {
        scale += (one - mean).cwiseAbs2() / static_cast<double>(all.size());
    }
    scale = (scale.cwiseSqrt().array() + 1e-12).inverse();
    std::size_t right = 0;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
        std::array<Features, 2> centre{Features::Zero(), Features::Zero()};
        std::array<double, 2> count{};
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (i % kFolds != fold) {
                const std::size_t group = is_changed[i] ? 1 : 0;
                centre[group] += scale.cwiseProduct(all[i] - mean);
                count[group] += 1.0;
            }
        }
        centre[0] /= count[0];
        centre[1] /= count[1];
        Eigen::Matrix<double, kFeaturesOfAWay, kFeaturesOfAWay> within =
            1e-6 * Eigen::Matrix<double, kFeaturesOfAWay, kFeaturesOfAWay>::Identity();
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (i % kFolds != fold) {
                const Features off =
                    scale.cwiseProduct(all[i] - mean) - centre[is_changed[i] ? 1 : 0];
                within += off * off.transpose() / (count[0] + count[1]);
            }
        }
        const Features weights = within.ldlt().solve(centre[1] - centre[0]);
        const double middle = 0.5 * weights.dot(centre[0] + centre[1]);
        for (std::size_t i = fold; i < all.size(); i += kFolds) {
            const bool says_changed = weights.dot(scale.cwiseProduct(all[i] - mean)) > middle;
            right += says_changed == is_changed[i] ? 1 : 0;
        }
    }
    return static_cast<double>(right) / static_cast<double>(all.size());
}

struct Told {
    double before = 0.0;
    double after = 0.0;
};

Told told_rightly_of(int cases, bool is_told) {
    std::vector<Ways> all(static_cast<std::size_t>(cases));
    std::vector<bool> is_changed(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        is_changed[i] = uniform(child(RandomKey{910}, i)) < 0.5;
    }
    for_each_in_parallel(all.size(), all_processors(), [&](std::size_t i) {
        all[i] = ways_of_case(static_cast<int>(i), is_changed[i], is_told);
    });
    std::vector<Features> before;
    std::vector<Features> after;
    for (const Ways &ways : all) {
        before.push_back(ways.before);
        after.push_back(ways.after);
    }
    const Told told{told_rightly(before, is_changed), told_rightly(after, is_changed)};
    std::printf("counts: of %d told rightly before the touch %.1f %%, after it %.1f %%\n", cases,
                100.0 * told.before, 100.0 * told.after);
    return told;
}

TEST(FreeSpace, TellsNothingOfTheConditionInContact) {
    const int cases = testing::cases(60, 4000);
    const Told told = told_rightly_of(cases, false);
    // Three standard deviations of guesses.
    const double chance = 0.5 + 3.0 * 0.5 / std::sqrt(cases);
    EXPECT_LT(told.before, chance);
    EXPECT_LT(told.after, chance);
}

/// Where each condition has its own free space the same classifier finds it.
TEST(FreeSpace, TellsEverythingWhereItIsTheStimulus) {
    const Told told = told_rightly_of(testing::cases(40, 200), true);
    EXPECT_GT(told.before, 0.95);
    EXPECT_GT(told.after, 0.95);
}

} // namespace
} // namespace springdrive::study
