// Covers false alarms of the safety monitor: hands that press, tap and slide as people do must
// never trip it, with any tuning, rate and surface.
#include "tests/support/fault_trial.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::servo {
namespace {

struct Hand {
    const char *name = "";
    device::HandParameters parameters{};
    double depth_m = 0.0; ///< of its target, when it presses
};

const std::array<Hand, 3> kHands{{{"light", testing::kLightHand, 0.025},
                                  {"relaxed", device::HandParameters{}, 0.012},
                                  {"firm", testing::kFirmHand, 0.004}}};

/// Rests, taps thrice, presses, slides 20 mm and lifts.
simulated::SimulationOptions taps_and_presses(const testing::FaultCase &what, double speed_m_per_s,
                                              double depth_m) {
    std::vector<simulated::HandPath::Point> points{{0.0, what.start_m}, {1.15, what.start_m}};
    const auto go = [&](const Vector3 &to_m) {
        const simulated::HandPath::Point from = points.back();
        points.push_back({from.time_s + (to_m - from.position_m).norm() / speed_m_per_s, to_m});
    };
    const Vector3 above = Vector3(what.start_m.x(), 0.005, what.start_m.z());
    const Vector3 below = Vector3(what.start_m.x(), -depth_m, what.start_m.z());
    go(above);
    for (int tap = 0; tap < 3; ++tap) {
        go(below);
        go(above);
    }
    go(below);
    points.push_back({points.back().time_s + 0.15, below});
    go(below + Vector3(0.02, 0.0, 0.0));
    go(above + Vector3(0.02, 0.0, 0.0));
    simulated::SimulationOptions options;
    options.path.emplace(std::move(points));
    return options;
}

struct Extremes {
    double energy_J = 0.0;
    double force_N = 0.0;
    int runs = 0;
    int touched = 0;
};

/// A run whose path ends with the last of its points.
void run(testing::FaultTrial &rig, double until_s, Extremes &seen) {
    bool touched = false;
    for (int tick = 0; tick < rig.ticks_in(until_s) && !rig.has_tripped(); ++tick) {
        const ServoSample sample = rig.step();
        touched |= sample.contact.touching;
        seen.energy_J = std::max(seen.energy_J, sample.generated_energy_J);
    }
    EXPECT_FALSE(rig.has_tripped()) << description(rig.last.safety);
    seen.force_N = std::max(seen.force_N, rig.max_force_N());
    seen.touched += touched ? 1 : 0;
    ++seen.runs;
}

class FalseAlarm : public ::testing::TestWithParam<double> {};

/// The servo's rate is the parameter; everything else cycles.
TEST_P(FalseAlarm, NoneWhenHandsPressAndTap) {
    std::mt19937 random(51);
    Extremes all;
    for (int tuning = 0; tuning < 3; ++tuning) {
        for (const double eta : {0.0, 0.5, 0.9}) {
            for (const Hand &hand : kHands) {
                for (const double speed_m_per_s : {0.05, 0.1, 0.2, 0.4}) {
                    testing::FaultCase what =
                        testing::random_case(random, tuning, testing::Place::plate);
                    what.servo_hz = GetParam();
                    what.start_m.y() = 0.012;
                    what.tuning.eta = eta;
                    simulated::SimulationOptions options =
                        taps_and_presses(what, speed_m_per_s, hand.depth_m);
                    options.hand = hand.parameters;
                    const double until_s = options.path->points().back().time_s + 0.05;
                    testing::FaultTrial rig(what, options, testing::HandOf::options);
                    Extremes seen;
                    SCOPED_TRACE(what.tuning_name + ", η " + std::to_string(eta) + ", " +
                                 hand.name + " hand at " + std::to_string(speed_m_per_s) + " m/s");
                    run(rig, until_s, seen);
                    all.energy_J = std::max(all.energy_J, seen.energy_J);
                    all.force_N = std::max(all.force_N, seen.force_N);
                    all.touched += seen.touched;
                    all.runs += seen.runs;
                }
            }
        }
    }
    EXPECT_EQ(all.runs, 108);
    EXPECT_EQ(all.touched, all.runs);
    RecordProperty("greatest_generated_mJ", std::to_string(1e3 * all.energy_J));
    RecordProperty("greatest_force_N", std::to_string(all.force_N));
}

INSTANTIATE_TEST_SUITE_P(AtRate, FalseAlarm, ::testing::Values(1000.0, 4000.0),
                         [](const auto &rate) {
                             return std::to_string(static_cast<int>(rate.param)) + "Hz";
                         });

} // namespace
} // namespace springdrive::servo
