// Covers engine/lab/limits as a whole, over many random loops: predicted limits against simulated
// ones, which takes a minute; auto_tune.cpp against an exhaustive search, and with hands that were
// not in the family, some seconds for each of twenty devices.
#include "base/input_error.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/auto_tune.h"
#include "engine/lab/limits/stability_limits.h"
#include "engine/lab/limits/stability_simulation.h"
#include "tests/support/cases.h"
#include "tests/support/runge_kutta_loop.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace springdrive::limits {
namespace {

constexpr std::size_t kLoopParameters = 13; ///< the list's others are the wall's

/// Expects Runge-Kutta to agree with the eigenvalues 2 % inside and 2 % outside of a limit of K_P.
void expect_runge_kutta_agrees(const loops::StabilityCase &which, const StabilityLimit &limit) {
    const double outward = limit.stable_below ? 0.02 : -0.02;
    for (const double share : {1.0 - outward, 1.0 + outward}) {
        loops::StabilityCase beside = which;
        beside.tuning.K_P_V_per_rad = share * limit.predicted;
        EXPECT_EQ(testing::RungeKuttaLoop(beside).dies_out(), limit.stable_below == (share < 1.0))
            << "K_P " << share << " of " << limit.predicted << ", T " << which.period_s << ", d "
            << which.delay_periods;
    }
}

/// For random loops with d from 0 to 3: the K_P at which they become unstable, by eigenvalues, is
/// within 2 % of that of a simulated motor, and on the correct side by Runge-Kutta steps. Returns
/// the largest relative deviation of the former.
double expect_gain_limits_agree(int loops, unsigned seed) {
    std::mt19937_64 random(seed);
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    double worst = 0.0;
    for (int found = 0; found < loops;) {
        const loops::StabilityCase which = testing::random_delayed_loop(random);
        const std::vector<StabilityLimit> limits = predicted_limits(which, kp, {kp.from, kp.to});
        if (limits.empty()) {
            continue;
        }
        ++found;
        const StabilityLimit &limit = limits.front();
        const std::optional<double> tried =
            simulated_limit(which, kp, limit, TrialOptions::linear());
        EXPECT_TRUE(tried) << limit.predicted << ", d " << which.delay_periods;
        const double deviation = std::abs(tried.value_or(HUGE_VAL) / limit.predicted - 1.0);
        EXPECT_LE(deviation, 0.02) << "T " << which.period_s << ", d " << which.delay_periods;
        worst = std::max(worst, deviation);
        expect_runge_kutta_agrees(which, limit);
    }
    return worst;
}

struct Found {
    loops::StabilityCase which;
    const loops::StabilityParameter *parameter = nullptr;
    StabilityLimit limit;
};

/// Random loops with a limit along one parameter; the parameters take turns.
std::vector<Found> random_limits(int count, std::mt19937_64 &random) {
    std::vector<Found> all;
    for (std::size_t i = 0; static_cast<int>(all.size()) < count; ++i) {
        Found found;
        found.which = testing::random_rotor_loop(random);
        found.parameter = &loops::stability_parameters()[i % kLoopParameters];
        const std::vector<StabilityLimit> limits = predicted_limits(
            found.which, *found.parameter, {found.parameter->from, found.parameter->to});
        if (!limits.empty()) {
            found.limit = limits.front();
            all.push_back(found);
        }
    }
    return all;
}

/// Where trials fail relative to the prediction: 1 at the prediction, above 1 beyond it. Nothing
/// where no trial nearby differs.
std::optional<double> lateness(const Found &found, const TrialOptions &options) {
    const std::optional<double> tried =
        simulated_limit(found.which, *found.parameter, found.limit, options);
    if (!tried) {
        return std::nullopt;
    }
    const double ratio = *tried / found.limit.predicted;
    return found.limit.stable_below ? ratio : 2.0 - ratio; // dR may go below zero
}

TEST(StabilityAgreement, RandomLoopsWithinTwoPerCent) {
    const int count = testing::cases(20, 200);
    std::mt19937_64 random(31);
    double worst = 0.0;
    for (const Found &found : random_limits(count, random)) {
        const std::optional<double> tried =
            simulated_limit(found.which, *found.parameter, found.limit, TrialOptions::linear());
        ASSERT_TRUE(tried) << found.parameter->name << " " << found.limit.predicted;
        EXPECT_NEAR(*tried, found.limit.predicted, 0.02 * std::abs(found.limit.predicted))
            << found.parameter->name << ", T " << found.which.period_s << ", d "
            << found.which.delay_periods;
        worst = std::max(worst, std::abs(*tried / found.limit.predicted - 1.0));
    }
    std::printf("worst of %d: %.2f %%\n", count, 100.0 * worst);
}

TEST(StabilityAgreement, LoopsWithAnyDelayWithinTwoPerCent) {
    const int count = testing::cases(10, 100);
    std::printf("worst of %d: %.2f %%\n", count, 100.0 * expect_gain_limits_agree(count, 34));
}

double share_of(const std::vector<double> &values, const std::function<bool(double)> &what) {
    return static_cast<double>(std::count_if(values.begin(), values.end(), what)) /
           static_cast<double>(values.size());
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

/// Counts excite a loop with little damping, friction damps it: so they fail earlier and later,
/// respectively. Most of them: where a count is small compared with the accepted chatter, motion of
/// the last digit counts as rest slightly beyond the limit.
TEST(StabilityAgreement, CountsFailEarlierAndFrictionLater) {
    const int count = testing::cases(40, 200);
    std::mt19937_64 random(32);
    std::vector<double> with_counts;
    std::vector<double> with_friction;
    std::vector<double> friction_over_counts;
    for (const Found &found : random_limits(count, random)) {
        const auto counts = lateness(found, TrialOptions::with(SimulationEffects::electronics()));
        const auto all = lateness(found, TrialOptions::with(SimulationEffects::all()));
        if (counts) {
            with_counts.push_back(*counts);
        }
        if (all) {
            with_friction.push_back(*all);
        }
        if (counts && all) {
            friction_over_counts.push_back(*all - *counts);
        }
    }
    ASSERT_GT(static_cast<int>(friction_over_counts.size()), count * 3 / 4);
    const auto earlier = [](double late) { return late < 0.998; };
    const auto later = [](double late) { return late > 1.002; };
    std::printf("counts: median %.3f, earlier %.2f, later %.2f; with friction: median %.3f, "
                "earlier %.2f, later %.2f\n",
                median(with_counts), share_of(with_counts, earlier), share_of(with_counts, later),
                median(with_friction), share_of(with_friction, earlier),
                share_of(with_friction, later));
    EXPECT_LT(median(with_counts), 1.0);
    EXPECT_GT(share_of(with_counts, earlier), 2.0 * share_of(with_counts, later));
    EXPECT_GT(median(with_friction), 1.0);
    EXPECT_GT(share_of(with_friction, later), 2.0 * share_of(with_friction, earlier));
    // In the same loop friction does not make it fail earlier, within bisection's 1e-3.
    EXPECT_GT(share_of(friction_over_counts, [](double later_by) { return later_by > -2e-3; }),
              0.9);
}

/// Three motors anywhere in the workspace, on rigid links, behind cables, a tip or both: prediction
/// and trials agree within 2 %.
TEST(StructuralAgreement, ThreeMotorsWithinTwoPerCent) {
    std::mt19937_64 random(33);
    const loops::StabilityParameter &kp = *loops::stability_parameter_named("kp");
    const int count = testing::cases(12, 200);
    int tried = 0;
    int agreed = 0;
    while (tried < count) {
        testing::Draw draw(random);
        loops::StabilityCase which;
        which.device = tried % 2 == 0 ? testing::phantom_1_0() : testing::phantom_premium_1_5();
        for (device::MotorParameters &motor : which.device.motor) {
            motor.torque_constant_Nm_per_A *= draw.even(0.8, 1.25);
        }
        which.freedom = loops::Freedom::three_motors;
        const std::array<loops::Structure, 4> structures{{{}, {1.0}, {draw.even(0.1, 0.9)}, {0.0}}};
        which.structures = {structures[static_cast<std::size_t>(tried % 4)]};
        which.q_rad = testing::random_workspace_angles(which.device, random);
        which.tuning.map =
            tried % 3 == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
        which.tuning.dR_Ohm = draw.by_ratio(0.1, 2.0);
        which.tuning.K_D_Vs_per_rad = draw.even(0.0, 0.02);
        which.tuning.lambda_rad_per_s = draw.by_ratio(300.0, 3000.0);
        which.period_s = draw.by_ratio(5e-4, 2e-3);
        which.delay_periods = draw.whole(0, 2);
        which.hands = {draw.whole(0, 2) == 0 ? loops::no_hand()
                                             : loops::hand_of_firmness(draw.even(0.0, 1.0))};
        const std::vector<StabilityLimit> limits = predicted_limits(which, kp, {0.01, 1000.0});
        if (limits.empty()) {
            continue;
        }
        ++tried;
        const StabilityLimit &limit = limits.front();
        const double outward = limit.stable_below ? 0.02 : -0.02;
        for (const double share : {1.0 - outward, 1.0 + outward}) {
            kp.set(which, share * limit.predicted);
            const bool is_stable =
                simulated(which, loops::members(which).front(), TrialOptions::linear()).stable;
            EXPECT_EQ(is_stable, limit.stable_below == (share < 1.0))
                << loops::structure_text(which.structures.front()) << ", K_P " << share << " of "
                << limit.predicted << ", T " << which.period_s << ", hand "
                << which.hands.front().name << ", " << which.q_rad.transpose();
            agreed += is_stable == (limit.stable_below == (share < 1.0)) ? 1 : 0;
        }
    }
    std::printf("counts: %d of %d trials agree\n", agreed, 2 * count);
}

/// A PHANTOM of another size and mass, with other motors.
device::DeviceDescription random_device(std::mt19937_64 &random) {
    testing::Draw draw(random);
    device::DeviceDescription device = testing::phantom_1_0();
    const double size = draw.by_ratio(0.7, 1.5);
    device.geometry.upper_arm_m *= size;
    device.geometry.forearm_m *= size;
    device.workspace.centre_m *= size;
    device.workspace.size_m *= size;
    device.friction.viscous_Nms_per_rad *= draw.by_ratio(0.3, 3.0);
    device.inertia.base_kg_m2 *= draw.by_ratio(0.5, 2.0);
    device.inertia.tip_load_kg = draw.even(0.0, 0.03);
    const device::MotorParameters motor = testing::random_motor(random);
    for (device::MotorParameters &each : device.motor) {
        each = motor;
        each.torque_constant_Nm_per_A *= draw.even(0.95, 1.05);
    }
    return device;
}

AutoTuneRequest random_request(std::mt19937_64 &random) {
    testing::Draw draw(random);
    AutoTuneRequest request;
    request.which.device = random_device(random);
    const double R = request.which.device.motor[0].resistance_Ohm;
    request.which.tuning.dR_Ohm = std::min(R, draw.by_ratio(0.1, 2.0));
    request.which.tuning.map =
        draw.whole(0, 1) == 0 ? control::MotionMap::inverse : control::MotionMap::transpose;
    request.which.period_s = 1.0 / draw.by_ratio(300.0, 4000.0);
    request.which.delay_periods = draw.whole(0, 3);
    request.margin = draw.even(1.0, 2.0);
    return request;
}

/// The n-th of the requests for which a tuning exists.
struct Tuned {
    AutoTuneRequest request;
    AutoTuned found;
};

Tuned tuned_device(int seed) {
    std::mt19937_64 random(static_cast<unsigned>(1000 + seed));
    while (true) {
        Tuned tuned;
        tuned.request = random_request(random);
        try {
            tuned.found = auto_tune(tuned.request);
            return tuned;
        } catch (const InputError &) { // no stable tuning: the next
        }
    }
}

/// The stiffest on a grid over K_P, K_D and λ that is stable with the margin for the five hands and
/// without a hand. The hands between those, with which a tuning must be stable as well, could only
/// reduce it.
class EverythingTried {
public:
    EverythingTried(const loops::TuningConstraints &loops, double margin)
        : loops_(loops), margin_(margin) {
        // Loops of one motor first: they cost a twentieth.
        for (const Eigen::Index size : {1, 3}) {
            for (std::size_t i = 0; i < loops.count(); ++i) {
                const bool between = loops[i].hand.find(" to ") != std::string::npos;
                if (loops[i].share.rows() == size && !between) {
                    order_.push_back(i);
                }
            }
        }
    }

    double stiffest_K_P() {
        constexpr int kGrid = 21;
        constexpr double kStep = 1.03;
        double best = 0.0;
        for (int i = 0; i < kGrid; ++i) {
            const double share = static_cast<double>(i) / (kGrid - 1);
            for (int j = 0; j < kGrid; ++j) {
                const loops::Gains pair{0.0, share * share * share,
                                        100.0 *
                                            std::pow(50.0, static_cast<double>(j) / (kGrid - 1))};
                const auto holds = [&](double K_P) {
                    return all_stable({K_P, pair.K_D_Vs_per_rad, pair.lambda_rad_per_s});
                };
                constexpr double kMax_K_P = 500.0;
                double K_P = kMax_K_P;
                while (K_P > std::max(best, 0.01) && !holds(K_P)) {
                    K_P /= kStep;
                }
                if (K_P <= best) {
                    continue;
                }
                double fails = K_P * kStep;
                for (int halving = 0; halving < 4 && K_P < kMax_K_P; ++halving) {
                    const double middle = 0.5 * (K_P + fails);
                    (holds(middle) ? K_P : fails) = middle;
                }
                best = K_P;
            }
        }
        return best;
    }

    /// Whether any of a coarser grid, with that K_P, is stable so and comes to rest with counts.
    bool any_rests(double K_P, loops::StabilityCase which) {
        constexpr int kGrid = 11;
        const TrialOptions electronics = TrialOptions::with(SimulationEffects::electronics());
        which.tuning.K_P_V_per_rad = K_P;
        for (int i = 0; i < kGrid * kGrid; ++i) {
            const int row = i / kGrid;
            const double share = static_cast<double>(row) / (kGrid - 1);
            which.tuning.K_D_Vs_per_rad = share * share * share;
            which.tuning.lambda_rad_per_s =
                100.0 * std::pow(50.0, static_cast<double>(i % kGrid) / (kGrid - 1));
            bool rests =
                all_stable({K_P, which.tuning.K_D_Vs_per_rad, which.tuning.lambda_rad_per_s});
            for (const loops::Freedom freedom :
                 {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
                which.freedom = freedom;
                rests = rests && is_stable_simulated(which, electronics);
            }
            if (rests) {
                return true;
            }
        }
        return false;
    }

private:
    bool all_stable(loops::Gains gains) {
        gains.K_P_V_per_rad *= margin_;
        gains.K_D_Vs_per_rad *= margin_;
        for (std::size_t i = 0; i < order_.size(); ++i) {
            if (!loops_.is_stable(order_[i], gains)) {
                std::swap(order_[i], order_[i / 2]); // loops that fail often move forward
                return false;
            }
        }
        return true;
    }

    const loops::TuningConstraints &loops_;
    double margin_;
    std::vector<std::size_t> order_;
};

class AutoTuneSearch : public ::testing::TestWithParam<int> {};

/// The family's hands with others between them, at any η, without the search's own list of loops.
void expect_stable_in_every_hand(loops::StabilityCase which, std::mt19937_64 &random) {
    which.hands = loops::hand_family(41);
    const Vector3 own_rad = which.q_rad;
    for (int i = 0; i <= 20; ++i) {
        which.tuning.eta = i / 20.0;
        which.freedom = loops::Freedom::one_motor;
        which.q_rad = own_rad;
        const loops::WorstMember one = loops::worst_member(which);
        EXPECT_TRUE(one.is_stable()) << "motor " << one.member.motor << ", " << one.member.hand.name
                                     << ", η " << which.tuning.eta << ": " << one.eigenvalue;
        which.freedom = loops::Freedom::three_motors;
        which.q_rad = i == 0 ? own_rad : testing::random_workspace_angles(which.device, random);
        const loops::WorstMember three = loops::worst_member(which);
        EXPECT_TRUE(three.is_stable())
            << three.member.hand.name << ", η " << which.tuning.eta << ": " << three.eigenvalue;
    }
}

void expect_some_at_rest(loops::StabilityCase which, std::mt19937_64 &random) {
    which.hands = {loops::no_hand(), loops::hand_of_firmness(0.0),
                   loops::hand_of_firmness(testing::Draw(random).even(0.0, 1.0)),
                   loops::hand_of_firmness(1.0)};
    for (const double eta : {0.0, 0.6}) {
        which.tuning.eta = eta;
        EXPECT_TRUE(is_stable_simulated(which, TrialOptions::linear())) << eta;
    }
}

TEST_P(AutoTuneSearch, NearlyReachesTheOptimumAndIsStableWithEveryHand) {
    const Tuned tuned = tuned_device(GetParam());
    loops::StabilityCase which = tuned.request.which;
    which.tuning = tuned.found.tuning;
    const loops::TuningConstraints loops(which);
    EverythingTried everything(loops, tuned.request.margin);
    const double best = everything.stiffest_K_P();
    const double found = which.tuning.K_P_V_per_rad; // after the reduction, if any
    std::printf("%.0f Hz, delay %g, dR %.2f Ω, margin %.2f: K_P %.3f, by trying all %.3f, "
                "taken back %.0f %%\n",
                1.0 / which.period_s, which.delay_periods, which.tuning.dR_Ohm,
                tuned.request.margin, found, best, 100.0 * tuned.found.taken_back);
    // Where that is not reached, the counts must keep all other tunings from rest.
    constexpr double kShare = 0.95;
    EXPECT_TRUE(found >= kShare * best || !everything.any_rests(found / kShare, which));
    std::mt19937_64 random(static_cast<unsigned>(GetParam()));
    expect_stable_in_every_hand(which, random);
    expect_some_at_rest(which, random);
}

INSTANTIATE_TEST_SUITE_P(Devices, AutoTuneSearch, ::testing::Range(0, testing::cases(1, 20)));

} // namespace
} // namespace springdrive::limits
