// Covers engine/commissioning/{self_test,device_checks,pulse_fit}: a whole self-test on an emulated
// board, healthy and with each fault.
#include "engine/commissioning/self_test.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/factory/device_factory.h"
#include "device/simulated/hand_tours.h"
#include "device/simulated/plant_setup.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::commissioning {
namespace {

using device::FaultKind;

/// A problem, and on which channel, from 1; 0: on none.
using Named = std::set<std::pair<Problem, int>>;

Named named(const SelfTestReport &report) {
    Named all;
    for (const Finding &finding : report.findings) {
        all.emplace(finding.problem, finding.channel ? static_cast<int>(*finding.channel) + 1 : 0);
    }
    return all;
}

std::string text_of(const SelfTestReport &report) {
    std::string text;
    for (const Finding &finding : report.findings) {
        text += finding.what + "\n";
    }
    return text;
}

simulated::HandPath slowed(const simulated::HandPath &path, double slowness) {
    std::vector<simulated::HandPath::Point> points = path.points();
    for (simulated::HandPath::Point &point : points) {
        point.time_s *= slowness;
    }
    return simulated::HandPath(points);
}

/// An emulated board, whose hand does as the self-test asks.
struct Tried {
    factory::BoardRequest request;
    Vector3 declared_rad{Vector3::Zero()}; ///< θ at the zeroing, in the zero pose
    SelfTestOptions options;
    double slowness = 1.0; ///< of the hand that goes to the stops

    Tried() {
        request.description = testing::phantom_1_0();
        request.truth = request.description;
        request.emulation.start_tip_m = Vector3::Zero();
    }

    SelfTestReport run() const {
        const factory::OpenBoard board = factory::open_board(request);
        board.device->zero(declared_rad);
        SelfTest test(*board.device, options);
        simulated::SimulatedPhantom &phantom = board.emulated->phantom();
        std::optional<double> ends_s;
        while (test.step()) {
            if (test.stage() == SelfTestStage::motion && !ends_s) {
                const auto path = slowed(
                    simulated::stop_tour(request.description, phantom.truth().tip_m), slowness);
                ends_s = phantom.truth().time_s + path.end_s();
                phantom.follow(path);
            }
            if (ends_s && phantom.truth().time_s > *ends_s) {
                test.finish_motion();
            }
        }
        return test.report();
    }
};

/// Against (11) solved with V_b sgn(i), from I − e/R to −(I + e/R): i = 0 is passed after
/// (L/R) ln(2 U/(U + V_b + e)), until when brushes drive it, too.
TEST(PulseFit, FindsWhatTheClosedFormWasMadeOf) {
    const device::MotorParameters file = testing::phantom_motor();
    const double R_Ohm = 2.0;
    const double L_H = 0.25e-3;
    for (const double V_b_V : {0.0, 0.05, 0.3}) {
        std::vector<PulseLevel> levels;
        for (const double U_V : {0.5, 0.9, 1.2, 1.5}) {
            const double e_V = 0.1 * U_V;
            const double I_A = (U_V - V_b_V) / R_Ohm;
            const double passed_s = L_H / R_Ohm * std::log(2.0 * U_V / (U_V + V_b_V + e_V));
            levels.push_back({U_V, I_A, L_H / R_Ohm - V_b_V * passed_s / (R_Ohm * I_A), e_V});
        }
        const PulseFit fit = fit_pulses(file, levels);
        // The least i_b, 10 mA, is as good as sgn(i); that V_b is about as probable as any up to
        // the file's draws it by 10 mV² to 500 mV² to zero.
        EXPECT_NEAR(fit.curve[0].resistance_Ohm, R_Ohm, 1e-3 * R_Ohm) << V_b_V;
        EXPECT_NEAR(fit.curve[0].voltage_V, V_b_V, 1e-3 * V_b_V + 1e-9) << V_b_V;
        // With another i_b it would be another R, as the fit says.
        EXPECT_NEAR(fit.resistance_Ohm, R_Ohm, fit.resistance_deviation_Ohm) << V_b_V;
        EXPECT_NEAR(fit.brush_V, V_b_V, fit.brush_deviation_V) << V_b_V;
        EXPECT_LT(fit.resistance_deviation_Ohm, 0.02 * R_Ohm) << V_b_V;
        EXPECT_NEAR(fit.inductance_H, L_H, 0.005 * L_H + 0.1 * V_b_V * L_H) << V_b_V;
    }
}

/// What brushes do not spoil.
TEST(SelfTestOnBoard, WithoutBrushesRIsMeasuredWithin3Percent) {
    for (int seed = 1; seed <= testing::cases(2, 30); ++seed) {
        Tried tried;
        tried.request.emulation.simulation.device_seed = static_cast<std::uint64_t>(seed);
        tried.request.emulation.simulation.effects.brush_voltage = false;
        for (device::MotorParameters &motor : tried.request.description.motor) {
            motor.max_brush_voltage_V = 0.0; // as a device file can say
        }
        tried.options.has_motion = false;
        const SelfTestReport report = tried.run();
        EXPECT_TRUE(report.has_passed()) << "seed " << seed << "\n" << text_of(report);
        const simulated::SampledDevice drawn = simulated::sampled_device(
            tried.request.truth, tried.request.emulation.simulation.device_seed);
        for (std::size_t i = 0; i < 3; ++i) {
            const double R_Ohm = drawn.motor[i].resistance_share *
                                 tried.request.truth.motor[i].resistance_Ohm /
                                 drawn.motor[i].sensing.converter.gain;
            EXPECT_NEAR(report.windings.motor[i].resistance_Ohm, R_Ohm, 0.03 * R_Ohm) << seed;
            EXPECT_EQ(report.windings.motor[i].brush_V, 0.0) << seed;
        }
    }
}

TEST(SelfTestOnBoard, AHealthyDevicePassesAndIsMeasured) {
    for (int seed = 0; seed < testing::cases(3, 100); ++seed) {
        Tried tried;
        tried.request.emulation.simulation.device_seed = static_cast<std::uint64_t>(seed);
        const SelfTestReport report = tried.run();
        EXPECT_TRUE(report.has_passed()) << "seed " << seed << "\n" << text_of(report);
        if (seed == 0) { // the file's own, with ideal sensors
            continue;
        }
        const simulated::SampledDevice drawn = simulated::sampled_device(
            tried.request.truth, tried.request.emulation.simulation.device_seed);
        for (std::size_t i = 0; i < 3; ++i) {
            const double gain = drawn.motor[i].sensing.converter.gain;
            const double R_Ohm = drawn.motor[i].resistance_share *
                                 tried.request.truth.motor[i].resistance_Ohm / gain;
            const double L_H = tried.request.truth.motor[i].inductance_H / gain;
            const double V_b_V = drawn.motor[i].brush_voltage_V;
            const double i_b_A =
                std::max(drawn.motor[i].brush_current_A, drawn.motor[i].carried_brush_current_A);
            const WindingFigures &winding = report.windings.motor[i];
            // What brushes may take more at the highest level than at the lowest one above i_b, by
            // an i_b that pulses do not tell: the levels are 0.2 and 0.5 A where they take most.
            const double more_V = V_b_V * (1.0 - std::tanh(0.2 / i_b_A));
            // 2 % of ripple at an angle that is not known, 1 % of back-EMF.
            EXPECT_NEAR(winding.resistance_Ohm, R_Ohm, 0.03 * R_Ohm + more_V / 0.3) << seed;
            // That ripple at the lowest level, 0.23 A.
            EXPECT_NEAR(winding.brush_V, V_b_V, 0.01 + more_V) << seed;
            EXPECT_NEAR(winding.inductance_H, L_H, 0.03 * L_H) << seed;
            // That R, and 1 % of noise and offset. Where a hand hardly moves a motor faster than
            // V_b/k_T, its current stays near i_b, which is not known: it says so.
            const MotionFigures &motion = report.motion.motor[i];
            EXPECT_NEAR(motion.counts_per_turned, 1.0 / drawn.motor[i].torque_constant_share,
                        0.04 + (V_b_V > 0.1 ? 2.0 * motion.counts_deviation : 0.0))
                << seed;
            EXPECT_LT(motion.counts_deviation, V_b_V > 0.1 ? 0.2 : 0.02) << seed;
        }
    }
}

struct Case {
    std::string name;
    std::function<void(Tried &)> damage;
    Named expected;
};

/// Faults of the emulated board.
Case with(const std::vector<std::string> &faults, Named expected) {
    return {faults.front(),
            [faults](Tried &tried) {
                for (const std::string &fault : faults) {
                    tried.request.emulation.faults.push_back(device::parse_fault(fault));
                }
            },
            std::move(expected)};
}

/// Zeroed where a joint was off by 8°.
Case zeroed_wrongly(int joint) {
    return {"zero of joint " + std::to_string(joint),
            [joint](Tried &tried) {
                tried.declared_rad =
                    device::motor_from_joint(tried.request.description.geometry,
                                             8.0 * kRadiansPerDegree * Vector3::Unit(joint - 1));
            },
            {{Problem::wrong_zero, joint}}};
}

TEST(SelfTestOnDamagedBoard, NamesTheFault) {
    const std::vector<Case> cases{
        with({"reversed-encoder:2"}, {{Problem::reversed_encoder, 2}}),
        with({"reversed-sensor:3"}, {{Problem::reversed_sensor, 3}}),
        with({"crossed-encoders:1:3"},
             {{Problem::crossed_encoders, 1}, {Problem::crossed_encoders, 3}}),
        with({"crossed-sensors:2:3"},
             {{Problem::crossed_sensors, 2}, {Problem::crossed_sensors, 3}}),
        with({"crossed-motors:1:2"},
             {{Problem::crossed_encoders, 1}, {Problem::crossed_encoders, 2}}),
        with({"open-winding:3"}, {{Problem::open_winding, 3}}),
        with({"open-winding:1@0.9-1.5"}, {{Problem::open_winding, 1}}), // for a moment
        with({"stuck-encoder:1"}, {{Problem::dead_encoder, 1}}),
        with({"lost-counts:2:0.1"}, {{Problem::wrong_counts, 2}}),
        with({"sensor-gain:1:1.1"}, {{Problem::wrong_sensor_gain, 1}}),
        with({"sensor-gain:2:0.9"}, {{Problem::wrong_sensor_gain, 2}}),
        with({"sensor-gain:1:1.4"}, {{Problem::wrong_sensor_gain, 1}}),
        with({"sensor-gain:1:1.1", "sensor-gain:2:1.1"},
             {{Problem::wrong_sensor_gain, 1}, {Problem::wrong_sensor_gain, 2}}),
        with({"stop@0.5"}, {{Problem::board_fault, 0}}),
        {"another supply",
         [](Tried &tried) {
             tried.request.emulation.settings.measures_supply = false;
             tried.request.emulation.faults = {device::parse_fault("brown-out:16.4")};
         },
         {{Problem::wrong_voltage, 0}}},
        {"R 20 % high",
         [](Tried &tried) { tried.request.truth.motor[1].resistance_Ohm *= 1.2; },
         {{Problem::wrong_resistance, 2}}},
        {"R 20 % low",
         [](Tried &tried) { tried.request.truth.motor[0].resistance_Ohm *= 0.8; },
         {{Problem::wrong_resistance, 1}}},
        {"L 50 % high",
         [](Tried &tried) { tried.request.truth.motor[2].inductance_H *= 1.5; },
         {{Problem::wrong_inductance, 3}}},
        {"L 50 % low",
         [](Tried &tried) { tried.request.truth.motor[0].inductance_H *= 0.5; },
         {{Problem::wrong_inductance, 1}}},
        {"seized joint",
         [](Tried &tried) { tried.request.truth.friction.coulomb_Nm[0] = 100.0; },
         {{Problem::seized_joint, 1}}},
        zeroed_wrongly(1),
        zeroed_wrongly(2),
    };
    for (const Case &one : cases) {
        for (int seed = 1; seed <= testing::cases(1, 5); ++seed) {
            Tried tried;
            tried.request.emulation.simulation.device_seed = static_cast<std::uint64_t>(seed);
            one.damage(tried);
            const SelfTestReport report = tried.run();
            EXPECT_EQ(named(report), one.expected) << one.name << ", device " << seed << "\n"
                                                   << text_of(report);
        }
    }
}

TEST(SelfTestOnBoard, PassesWhateverPersonAndBoardDoRightly) {
    const std::vector<Case> cases{
        {"a hand that drifts by 2 cm/s during the pulses",
         [](Tried &tried) {
             tried.request.emulation.simulation.path =
                 simulated::HandPath({{0.0, Vector3::Zero()}, {4.0, Vector3(0.03, 0.03, 0.06)}});
         },
         {}},
        {"a slow hand",
         [](Tried &tried) {
             tried.slowness = testing::cases(4, 25);
             tried.options.longest_motion_s = 1000.0;
         },
         {}},
        {"a slower loop, which gets longer pulses",
         [](Tried &tried) { tried.request.emulation.settings.loop_rate_hz = 20'000; },
         {}},
        {"pulses alone", [](Tried &tried) { tried.options.has_motion = false; }, {}},
        {"a stop that was latched before, let go on by a person",
         [](Tried &tried) {
             tried.request.emulation.faults = {device::parse_fault("stop@0-0.08")};
             tried.options.lets_go_on = true;
         },
         {}},
        {"the same stop, without a person",
         [](Tried &tried) {
             tried.request.emulation.faults = {device::parse_fault("stop@0-0.08")};
         },
         {{Problem::board_fault, 0}}},
    };
    for (const Case &one : cases) {
        Tried tried;
        one.damage(tried);
        const SelfTestReport report = tried.run();
        EXPECT_EQ(named(report), one.expected) << one.name << "\n" << text_of(report);
        EXPECT_EQ(report.is_complete, one.expected.empty()) << one.name;
        EXPECT_EQ(report.has_motion, report.is_complete && tried.options.has_motion) << one.name;
    }
}

/// Also in the time in which it resets what the board has latched, and where no report shows it
/// while it is pressed.
TEST(SelfTestOnBoard, AStopOfAnyTimeEndsIt) {
    for (const auto &[lets_go_on, is_unseen] :
         {std::pair(false, false), {true, false}, {false, true}, {true, true}}) {
        for (double begin_s = 0.005; begin_s < 0.7; begin_s += 0.04) {
            Tried tried;
            tried.options.has_motion = false;
            tried.options.lets_go_on = lets_go_on;
            const factory::OpenBoard board = factory::open_board(tried.request);
            board.device->zero(Vector3::Zero());
            device::Fault stop = device::parse_fault("stop");
            stop.begin_s = board.emulated->time_s() + begin_s;
            stop.end_s = stop.begin_s + (is_unseen ? 0.008 : 0.05);
            board.emulated->set_fault(stop);
            if (is_unseen) {
                device::Fault loss = device::parse_fault("drop:in");
                loss.begin_s = stop.begin_s - 0.002;
                loss.end_s = stop.end_s + 0.003;
                board.emulated->set_fault(loss);
            }
            SelfTest test(*board.device, tried.options);
            while (test.step()) {
            }
            EXPECT_EQ(named(test.report()), (Named{{Problem::board_fault, 0}})) << begin_s;
        }
    }
}

TEST(SelfTestOnBoard, SilenceIsSaid) {
    Tried tried;
    tried.request.emulation.faults = {device::parse_fault("stall:in@3.5")};
    const std::string said = error_text_of([&] { static_cast<void>(tried.run()); });
    EXPECT_NE(said.find("no reports"), std::string::npos) << said;
}

TEST(SelfTestOnBoard, WithoutAHandThatMovesNothingIsComplete) {
    Tried tried;
    const factory::OpenBoard board = factory::open_board(tried.request);
    board.device->zero(Vector3::Zero());
    SelfTestOptions options;
    options.longest_motion_s = 2.0;
    SelfTest test(*board.device, options);
    while (test.step()) {
        EXPECT_GE(test.share(), 0.0);
        EXPECT_LE(test.share(), 1.0);
        EXPECT_FALSE(test.instruction().empty());
    }
    EXPECT_FALSE(test.report().has_passed());
}

} // namespace
} // namespace springdrive::commissioning
