// Covers device/simulated/hand.cpp.
#include "device/simulated/hand.h"

#include "base/input_error.h"
#include "device/simulated/simulated_phantom.h"
#include "tests/support/devices.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::simulated {
namespace {

std::filesystem::path written(const std::string &name, const std::string &text) {
    const std::filesystem::path file = testing::fresh_folder("hand_path") / name;
    std::ofstream(file) << text;
    return file;
}

std::string error(const std::string &text) {
    try {
        static_cast<void>(HandPath::read_csv(written("hand_path_test.csv", text)));
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

TEST(HandPath, IsLinearBetweenPointsAndAtRestOutside) {
    HandPath path({{1.0, Vector3(0, 0, 0)}, {2.0, Vector3(2, 0, -4)}, {4.0, Vector3(2, 1, -4)}});
    EXPECT_EQ(path.at(0.0).position_m, Vector3(0, 0, 0));
    EXPECT_EQ(path.at(0.0).velocity_m_per_s, Vector3::Zero());
    EXPECT_EQ(path.at(1.5).position_m, Vector3(1, 0, -2));
    EXPECT_EQ(path.at(1.5).velocity_m_per_s, Vector3(2, 0, -4));
    EXPECT_EQ(path.at(3.0).position_m, Vector3(2, 0.5, -4));
    EXPECT_EQ(path.at(9.0).position_m, Vector3(2, 1, -4));
    EXPECT_EQ(path.at(9.0).velocity_m_per_s, Vector3::Zero());
}

TEST(HandPath, ReadsCsvWithBlanksAndWindowsLineEnds) {
    const HandPath path = HandPath::read_csv(
        written("hand_path_good.csv", "t,x,y,z\r\n0, 0.1 ,0,-1e-2\r\n\r\n2.5,0.2,0,0\r\n"));
    ASSERT_EQ(path.points().size(), 2U);
    EXPECT_EQ(path.points()[0].position_m, Vector3(0.1, 0, -1e-2));
    EXPECT_EQ(path.points()[1].time_s, 2.5);
}

TEST(HandPath, ReadsNumbersWithTheirSign) {
    const HandPath path =
        HandPath::read_csv(written("hand_path_sign.csv", "t,x,y,z\n+0,+0.05, +.5e-1 ,-0.05\n"));
    EXPECT_EQ(path.points().at(0).position_m, Vector3(0.05, 0.05, -0.05));
    for (const char *const wrong : {"+", "++1", "+-1", "-+1", "+ 1", "1+", "+nan"}) {
        EXPECT_NE(error("t,x,y,z\n0,0,0," + std::string(wrong) + '\n').find(":2:"),
                  std::string::npos)
            << wrong;
    }
}

TEST(HandPath, ReadsCsvWithoutAHeaderWhereThatIsAllowed) {
    using Header = HandPath::Header;
    for (const char *text : {"0,0.1,0,0\n1,0.2,0,0\n", "t,x,y,z\n0,0.1,0,0\n1,0.2,0,0\n"}) {
        const HandPath path =
            HandPath::read_csv(written("hand_path_header.csv", text), Header::optional);
        ASSERT_EQ(path.points().size(), 2U);
        EXPECT_EQ(path.points()[0].position_m, Vector3(0.1, 0, 0));
    }
    EXPECT_THROW(static_cast<void>(HandPath::read_csv(
                     written("hand_path_header.csv", "time,x,y,z\n0,0,0,0\n"), Header::optional)),
                 InputError);
}

TEST(HandPath, SaysWhichLineIsWrong) {
    EXPECT_NE(error("0,0,0,0\n").find(":1:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0\n").find(":2:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0,0\n").find(":2:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,nan,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,2mm,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n1,0,0,0\n1,0,0,0\n").find(":3:"), std::string::npos);
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1,0,5.1,0\n").find(":3:"), std::string::npos);
    EXPECT_EQ(error("\xEF\xBB\xBFt,x,y,z\n0,0,0,0\n1,0,4.9,0\n"), "");
    EXPECT_NE(error("t,x,y,z\n").find("no point"), std::string::npos);
    EXPECT_NE(error("").find("no point"), std::string::npos);
    EXPECT_THROW(static_cast<void>(HandPath::read_csv("no such file.csv")), InputError);
}

/// A recorded hand: to and fro as fast as hands are, at a rate of trackers and servos.
std::vector<HandPath::Point> recorded_hand(std::mt19937_64 &random) {
    std::uniform_real_distribution<> any(0.0, 1.0);
    const double rate_hz = 30.0 * std::pow(100.0, any(random));
    const double swing_m = 0.01 + 0.05 * any(random);
    const double turn_hz = 0.2 + 1.5 * any(random); // at most π 0.12 m 1.7 Hz, 0.6 m/s
    const double rests_s = 10.0 * any(random);
    std::vector<HandPath::Point> points{{rests_s, Vector3(swing_m, 0.0, 0.0)}};
    for (int i = 1; i < 3.0 * rate_hz; ++i) {
        const double t = i / rate_hz;
        points.push_back(
            {rests_s + t, Vector3(swing_m * std::cos(2.0 * std::numbers::pi * turn_hz * t), 0.0,
                                  0.001 * any(random) / rate_hz)});
    }
    return points;
}

std::string csv_of(const std::vector<HandPath::Point> &points, double per_s, double begin) {
    std::ostringstream text;
    text << "t,x,y,z\n" << std::setprecision(17);
    for (const HandPath::Point &point : points) {
        text << begin + per_s * point.time_s << ',' << point.position_m.x() << ','
             << point.position_m.y() << ',' << point.position_m.z() << '\n';
    }
    return text.str();
}

TEST(HandPath, HasNoTimesOfAnotherUnitOrClock) {
    std::mt19937_64 random(50);
    for (int i = 0; i < 20; ++i) {
        const std::vector<HandPath::Point> hand = recorded_hand(random);
        EXPECT_EQ(error(csv_of(hand, 1.0, 0.0)), "") << i;
        for (const double per_s : {1e3, 1e6, 1e9}) {
            EXPECT_NE(error(csv_of(hand, per_s, -per_s * hand[0].time_s)).find("1000"),
                      std::string::npos)
                << i << ", " << per_s << " a second";
        }
        for (const double per_s : {1.0, 1e3, 1e6}) { // since 1970, and since a computer's start
            for (const double at_s : {1.7e9, 4e5}) {
                EXPECT_NE(error(csv_of(hand, per_s, per_s * at_s)).find("first time"),
                          std::string::npos)
                    << i << ", " << per_s << " a second";
            }
        }
    }
    // Of few points, too; waits, long holds and slow presses are meant.
    EXPECT_NE(error("t,x,y,z\n0,0,0.05,0\n1500,0,0.02,0\n3000,0,0.02,0\n").find("1000"),
              std::string::npos);
    for (const char *meant :
         {"3600,0,0.05,0\n3601,0,0,0\n", "0,0,0.05,0\n3000,0,0.05,0\n",
          "0,0,0.05,0\n1,0,0,0\n600,0,0,0\n", "0,0,0.05,0\n1,0,0,0\n900,0,-0.001,0\n",
          "0,0,0.001,0\n600,0,0,0\n", "0,0,0.05,0\n", "-5,0,0.05,0\n1,0,0,0\n"}) {
        EXPECT_EQ(error(std::string("t,x,y,z\n") + meant), "") << meant;
    }
    EXPECT_NE(error("t,x,y,z\n3601,0,0.05,0\n3602,0,0,0\n"), "");
    EXPECT_NE(error("t,x,y,z\n-3601,0,0.05,0\n1,0,0,0\n"), "");
    EXPECT_NE(error("t,x,y,z\n0,0,0.001,0\n601,0,0,0\n"), "");
    EXPECT_NE(error("t,x,y,z\n0,0,0,0\n1000,0,1.99,0\n"), "");
    EXPECT_EQ(error("t,x,y,z\n0,0,0,0\n1000,0,2.01,0\n"), "");
}

HandStimulus random_stimulus(std::mt19937_64 &random, StimulusKind kind) {
    std::uniform_real_distribution<> any(0.0, 1.0);
    HandStimulus stimulus;
    stimulus.kind = kind;
    stimulus.direction = Vector3(any(random) - 0.5, any(random) - 0.5, any(random)).normalized();
    stimulus.amplitude_m = 0.01 * any(random);
    stimulus.duration_s = 0.2 + 3.0 * any(random);
    stimulus.from_Hz = 1.0 + 5.0 * any(random);
    stimulus.to_Hz = 1.0 + 30.0 * any(random);
    stimulus.number = 1;
    return stimulus;
}

TEST(HandStimulus, MovesAlongItsLineContinuouslyAndEndsWhereItBegan) {
    std::mt19937_64 random(3);
    for (const StimulusKind kind : {StimulusKind::step, StimulusKind::hold, StimulusKind::chirp}) {
        for (int i = 0; i < 50; ++i) {
            const HandStimulus stimulus = random_stimulus(random, kind);
            EXPECT_EQ(offset_of(stimulus, -1e-9).position_m, Vector3::Zero());
            EXPECT_NEAR(offset_of(stimulus, 0.0).position_m.norm(), 0.0, 1e-15);
            EXPECT_NEAR(offset_of(stimulus, stimulus.duration_s).position_m.norm(), 0.0, 1e-12);
            EXPECT_EQ(offset_of(stimulus, stimulus.duration_s + 1e-9).position_m, Vector3::Zero());
            constexpr int kSteps = 400;
            constexpr double kShort_s = 1e-6;
            for (int k = 1; k < kSteps; ++k) {
                const double t = stimulus.duration_s * k / kSteps;
                const HandTarget at = offset_of(stimulus, t);
                EXPECT_LE(at.position_m.norm(), stimulus.amplitude_m * (1.0 + 1e-12));
                EXPECT_NEAR(at.position_m.cross(stimulus.direction).norm(), 0.0, 1e-15);
                // The velocity is the position's derivative: central differences err by h²/6 times
                // the third derivative, at most A (π/rise)³ or A ω³.
                const Vector3 slope = (offset_of(stimulus, t + kShort_s).position_m -
                                       offset_of(stimulus, t - kShort_s).position_m) /
                                      (2.0 * kShort_s);
                const double third = stimulus.amplitude_m * std::pow(std::numbers::pi / 0.005, 3);
                const bool is_at_a_corner = t < kShort_s || t > stimulus.duration_s - kShort_s;
                if (!is_at_a_corner) {
                    EXPECT_NEAR((slope - at.velocity_m_per_s).norm(), 0.0, kShort_s * third + 1e-9);
                }
            }
        }
    }
}

TEST(HandStimulus, AChirpHasItsFrequencies) {
    HandStimulus stimulus;
    stimulus.kind = StimulusKind::chirp;
    stimulus.amplitude_m = 1.0;
    stimulus.duration_s = 10.0;
    stimulus.from_Hz = 2.0;
    stimulus.to_Hz = 20.0;
    const auto crossings_between = [&](double from_s, double to_s) {
        int crossings = 0;
        double before = offset_of(stimulus, from_s).position_m.y();
        constexpr int kSteps = 100'000;
        for (int k = 1; k <= kSteps; ++k) {
            const double now =
                offset_of(stimulus, from_s + (to_s - from_s) * k / kSteps).position_m.y();
            crossings += (now > 0.0) != (before > 0.0) ? 1 : 0;
            before = now;
        }
        return crossings;
    };
    // f(t) = 2 · 10^(t/10): the number of half periods is twice its integral.
    const auto periods = [](double t) { return 20.0 / std::log(10.0) * std::pow(10.0, t / 10.0); };
    for (const double from_s : {1.0, 4.0, 8.0}) {
        EXPECT_NEAR(crossings_between(from_s, from_s + 1.0),
                    2.0 * (periods(from_s + 1.0) - periods(from_s)), 1.0);
    }
}

TEST(HandStimulus, MovesTheSimulatedHandOncePerNumber) {
    SimulationOptions options;
    const Vector3 start_m(0.0, 0.02, 0.0);
    SimulatedPhantom phantom(testing::phantom_1_0(), options, start_m);
    const auto run = [&phantom](double seconds) {
        double farthest_m = 0.0;
        const double start_y_m = phantom.truth().hand_target_m.y();
        for (int tick = 0; tick < static_cast<int>(std::lround(1e3 * seconds)); ++tick) {
            static_cast<void>(phantom.read());
            phantom.write(device::DeviceCommand::braking());
            farthest_m =
                std::max(farthest_m, std::abs(phantom.truth().hand_target_m.y() - start_y_m));
        }
        return farthest_m;
    };
    run(0.2);
    HandStimulus stimulus;
    stimulus.kind = StimulusKind::hold;
    stimulus.amplitude_m = 0.004;
    stimulus.duration_s = 0.5;
    stimulus.number = 1;
    phantom.play(stimulus);
    EXPECT_NEAR(run(0.6), 0.004, 1e-9);
    EXPECT_NEAR(run(0.6), 0.0, 1e-9); // it is over
    phantom.play(stimulus);           // the same number
    EXPECT_NEAR(run(0.6), 0.0, 1e-9);
    stimulus.number = 2;
    phantom.play(stimulus);
    EXPECT_NEAR(run(0.6), 0.004, 1e-9);
}

} // namespace
} // namespace springdrive::simulated
