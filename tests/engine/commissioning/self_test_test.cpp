// Covers engine/commissioning: a whole self-test on an emulated board, healthy and with each fault.
#include "engine/commissioning/self_test.h"

#include "base/degrees.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "device/factory/board_factory.h"
#include "device/simulated/sampled_device.h"
#include "device/simulated/stop_tour.h"
#include "tests/support/cases.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cctype>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
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

TEST(SelfTestOnBoard, AHealthyDevicePasses) {
    for (int seed = 0; seed < testing::cases(3, 100); ++seed) {
        Tried tried;
        tried.request.emulation.simulation.device_seed = static_cast<std::uint64_t>(seed);
        const SelfTestReport report = tried.run();
        EXPECT_TRUE(report.has_passed()) << "seed " << seed << "\n" << text_of(report);
    }
}

struct Case {
    const char *name = "";
    std::function<void(Tried &)> damage;
    Named expected;
};

/// For GoogleTest.
void PrintTo(const Case &one, std::ostream *out) { *out << one.name; }

std::vector<Case> cases_of_faults() {
    const auto with_fault = [](const char *fault) {
        return [fault](Tried &tried) {
            tried.request.emulation.faults = {device::parse_fault(fault)};
        };
    };
    return {
        {"reversed encoder", with_fault("reversed-encoder:2"), {{Problem::reversed_encoder, 2}}},
        {"reversed sensor", with_fault("reversed-sensor:3"), {{Problem::reversed_sensor, 3}}},
        {"crossed encoders",
         with_fault("crossed-encoders:1:3"),
         {{Problem::crossed_encoders, 1}, {Problem::crossed_encoders, 3}}},
        {"crossed sensors",
         with_fault("crossed-sensors:2:3"),
         {{Problem::crossed_sensors, 2}, {Problem::crossed_sensors, 3}}},
        {"crossed motors",
         with_fault("crossed-motors:1:2"),
         {{Problem::crossed_encoders, 1}, {Problem::crossed_encoders, 2}}},
        {"open winding", with_fault("open-winding:3"), {{Problem::open_winding, 3}}},
        {"dead encoder", with_fault("stuck-encoder:1"), {{Problem::dead_encoder, 1}}},
        {"lost counts", with_fault("lost-counts:2:0.1"), {{Problem::wrong_counts, 2}}},
        {"sensor too high", with_fault("sensor-gain:1:1.1"), {{Problem::wrong_sensor_gain, 1}}},
        {"sensor too low", with_fault("sensor-gain:2:0.9"), {{Problem::wrong_sensor_gain, 2}}},
        {"winding open for a moment",
         with_fault("open-winding:1@0.9-1.5"),
         {{Problem::open_winding, 1}}},
        {"two sensors too high",
         [](Tried &tried) {
             tried.request.emulation.faults = {device::parse_fault("sensor-gain:1:1.1"),
                                               device::parse_fault("sensor-gain:2:1.1")};
         },
         {{Problem::wrong_sensor_gain, 1}, {Problem::wrong_sensor_gain, 2}}},
        {"sensor far too high", with_fault("sensor-gain:1:1.4"), {{Problem::wrong_sensor_gain, 1}}},
        {"another supply",
         [](Tried &tried) {
             tried.request.emulation.settings.measures_supply = false;
             tried.request.emulation.faults = {device::parse_fault("brown-out:16.4")};
         },
         {{Problem::wrong_voltage, 0}}},
        {"stop switch", with_fault("stop@0.5"), {{Problem::board_fault, 0}}},
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
        {"wrong zero of the base",
         [](Tried &tried) {
             tried.declared_rad = device::motor_from_joint(
                 tried.request.description.geometry, Vector3(8.0 * kRadiansPerDegree, 0.0, 0.0));
         },
         {{Problem::wrong_zero, 1}}},
        {"wrong zero of a link",
         [](Tried &tried) {
             tried.declared_rad = device::motor_from_joint(
                 tried.request.description.geometry, Vector3(0.0, 8.0 * kRadiansPerDegree, 0.0));
         },
         {{Problem::wrong_zero, 2}}},
    };
}

class SelfTestOnDamagedBoard : public ::testing::TestWithParam<Case> {};

TEST_P(SelfTestOnDamagedBoard, NamesTheFault) {
    for (int seed = 1; seed <= testing::cases(1, 5); ++seed) {
        Tried tried;
        tried.request.emulation.simulation.device_seed = static_cast<std::uint64_t>(seed);
        GetParam().damage(tried);
        const SelfTestReport report = tried.run();
        EXPECT_EQ(named(report), GetParam().expected)
            << GetParam().name << ", device " << seed << "\n"
            << text_of(report);
    }
}

INSTANTIATE_TEST_SUITE_P(EachFault, SelfTestOnDamagedBoard, ::testing::ValuesIn(cases_of_faults()),
                         [](const ::testing::TestParamInfo<Case> &one) {
                             std::string name;
                             for (const char letter : std::string(one.param.name)) {
                                 name += std::isalnum(static_cast<unsigned char>(letter)) != 0
                                             ? letter
                                             : '_';
                             }
                             return name;
                         });

TEST(SelfTestOnBoard, MeasuresWhatIsThere) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        Tried tried;
        tried.request.emulation.simulation.device_seed = seed;
        const SelfTestReport report = tried.run();
        const simulated::SampledDevice drawn = simulated::sampled_device(tried.request.truth, seed);
        for (std::size_t i = 0; i < 3; ++i) {
            const double gain = drawn.motor[i].sensing.converter.gain;
            const double R_Ohm = drawn.motor[i].resistance_share *
                                 tried.request.truth.motor[i].resistance_Ohm / gain;
            const double L_H = tried.request.truth.motor[i].inductance_H / gain;
            // 2 % of ripple at an angle that is not known, 1 % of back-EMF.
            EXPECT_NEAR(report.windings.motor[i].resistance_Ohm, R_Ohm, 0.03 * R_Ohm);
            EXPECT_NEAR(report.windings.motor[i].inductance_H, L_H, 0.03 * L_H);
            // That R, and 1 % of noise and offset.
            EXPECT_NEAR(report.motion.motor[i].counts_per_turned,
                        1.0 / drawn.motor[i].torque_constant_share, 0.04);
        }
    }
}

TEST(SelfTestOnBoard, AHandNeedNotBeStillNorFast) {
    Tried drifting; // 2 cm/s during the pulses
    drifting.request.emulation.simulation.path =
        simulated::HandPath({{0.0, Vector3::Zero()}, {4.0, Vector3(0.03, 0.03, 0.06)}});
    const SelfTestReport drifted = drifting.run();
    EXPECT_TRUE(drifted.has_passed()) << text_of(drifted);
    Tried slow;
    slow.slowness = testing::cases(4, 25);
    slow.options.longest_motion_s = 1000.0;
    const SelfTestReport slowly = slow.run();
    EXPECT_TRUE(slowly.has_passed()) << text_of(slowly);
}

TEST(SelfTestOnBoard, SlowerLoopsGetLongerPulses) {
    Tried tried;
    tried.request.emulation.settings.loop_rate_hz = 20'000;
    const SelfTestReport report = tried.run();
    EXPECT_TRUE(report.has_passed()) << text_of(report);
}

TEST(SelfTestOnBoard, APersonsTestResetsWhatTheBoardHasLatched) {
    Tried tried;
    tried.request.emulation.faults = {device::parse_fault("stop@0-0.08")}; // before it begins
    tried.options.lets_go_on = true;
    const SelfTestReport report = tried.run();
    EXPECT_TRUE(report.has_passed()) << text_of(report);
    tried.options.lets_go_on = false;
    EXPECT_EQ(named(tried.run()), (Named{{Problem::board_fault, 0}}));
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

TEST(SelfTestOnBoard, PulsesAloneAreAnAnswer) {
    Tried tried;
    tried.options.has_motion = false;
    const SelfTestReport report = tried.run();
    EXPECT_TRUE(report.has_passed()) << text_of(report);
    EXPECT_FALSE(report.has_motion);
}

TEST(SelfTestOnBoard, SilenceIsSaid) {
    Tried tried;
    tried.request.emulation.faults = {device::parse_fault("stall:in@3.5")};
    try {
        static_cast<void>(tried.run());
        FAIL();
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("no reports"), std::string::npos) << error.what();
    }
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
