// Covers engine/study/stimuli/stimulus_run.cpp: whether free space tells that the condition in
// contact is another one. In half of the presentations dR and λ in contact are others than those
// shared in free space; in the others they are the shared ones. A linear classifier looks at the
// servo's telemetry in free space: before the touch, and in a stroke after it that is the same
// motion whatever was felt. (On the way out of the contact itself a hand is faster where it pressed
// deeper: that tells what was felt, not what free space is.) 60 presentations by default, 4000 by
// tests/long.
#include "base/parallel.h"
#include "engine/study/methods/random_key.h"
#include "engine/study/protocol/stimulus_trial.h"
#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/cases.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace springdrive::study {
namespace {

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
