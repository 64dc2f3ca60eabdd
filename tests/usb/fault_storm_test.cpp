// Random faults of the board and its link, and of its cable.
#include "tests/usb/fault_storm.h"

#include "tests/support/cases.h"
#include "tests/support/devices.h"
#include "tests/support/fault_judge.h"
#include "tests/support/surfaces.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <string>

namespace springdrive::usb {
namespace {

// Random faults of the board and its link: each is named as documented, and none makes a true force
// or speed above the limits.

constexpr std::uint64_t kStormSeed = 74'000'000;

TEST(FaultStorm, EachFaultIsNamedAndHarmless) {
    const int number = testing::cases(60, 1000);
    std::map<std::string, int> summaries;
    double largest_A = 0.0;
    double largest_m_per_s = 0.0;
    double longest_over_s = -1.0;
    std::string worst;
    for (int i = 0; i < number; ++i) {
        const testing::StormCase what = testing::random_storm_case(kStormSeed, i);
        const testing::StormOutcome outcome = testing::outcome_of(what);
        EXPECT_EQ(outcome.broken, "") << i << ": " << what.description();
        EXPECT_EQ(testing::misnaming(what, outcome), "") << i << ": " << what.description();
        ++summaries[testing::summary(what, outcome)];
        largest_A = std::max(largest_A, outcome.largest_A);
        largest_m_per_s = std::max(largest_m_per_s, outcome.largest_m_per_s);
        if (outcome.longest_over_s > longest_over_s) {
            longest_over_s = outcome.longest_over_s;
            worst = fmt::format("{}: {:.2f} N, above the limit for {:.2f} ms; {}", i,
                                outcome.largest_N, 1e3 * longest_over_s, what.description());
        }
    }
    std::string all;
    for (const auto &[summary, count] : summaries) {
        all += summary + " " + std::to_string(count) + "; ";
    }
    RecordProperty("outcomes", all);
    RecordProperty("largest_current_A", std::to_string(largest_A));
    RecordProperty("largest_m_per_s", std::to_string(largest_m_per_s));
    RecordProperty("worst", worst);
    fmt::print("worst of {}: {}; {:.3f} m/s\n{}\n", number, worst, largest_m_per_s, all);
}

// The cable is pulled at any time: in contact, in free space, while the gains rise. The board
// brakes by itself, the servo trips, and after plugging in again and a reset the surface can be
// touched again.

const Vector3 kAboveBox_m(0.02, 0.015, 0.01);
const Vector3 kInBox_m(0.02, -0.006, 0.01);
constexpr double kRaised_s = 1.3;   ///< gains have risen by then
constexpr double kPressed_s = 0.6;  ///< the tip has reached the surface
constexpr double kMinTouch_N = 0.5; ///< of a hand with 300 N/m, 6 mm behind the surface

enum class When : std::uint8_t { starting, free, pressing };

struct Unplug {
    When when = When::pressing;
    double at_s = 0.0;       ///< in the tick that begins then
    bool after_read = false; ///< between `read` and `write` of that tick, or after it
    double in_tick_s = 0.0;  ///< how long the board then runs before the next `read`
    double unplugged_s = 0.0;
    bool moves_away = false; ///< whether the hand leaves the surface meanwhile
};

Unplug random_unplug(std::mt19937_64 &random, int number) {
    const auto uniform = [&](double from, double to) {
        return std::uniform_real_distribution(from, to)(random);
    };
    Unplug unplug;
    unplug.when = static_cast<When>(number % 3);
    const double from_s = unplug.when == When::starting ? 0.0 : kRaised_s;
    const double until_s = unplug.when == When::starting ? kRaised_s : kRaised_s + kPressed_s;
    unplug.at_s = uniform(from_s, until_s);
    unplug.after_read = uniform(0.0, 1.0) < 0.5;
    unplug.in_tick_s = uniform(25e-6, 2e-3);
    unplug.unplugged_s = uniform(0.001, 0.3);
    unplug.moves_away = uniform(0.0, 1.0) < 0.5;
    return unplug;
}

class UnpluggedServo : public testing::ServoOnBoard {
public:
    UnpluggedServo()
        : ServoOnBoard(testing::phantom_1_0(), board_options()),
          box_(testing::box_soup(Vector3(-0.1, -0.05, -0.1), Vector3(0.1, 0.0, 0.1))) {
        inputs.surface = &box_;
    }

    void try_unplugging(const Unplug &unplug) {
        run_to(unplug);
        const board::State before = state();
        pull_cable(unplug);
        expect_board_is_safe(before);
        expect_servo_is_safe();
        EXPECT_FALSE(has_started_again(0.02)); // absent, it stays so
        away_until_plugged(unplug);
        expect_touch_again();
    }

private:
    static emulator::EmulatedBoardOptions board_options() {
        emulator::EmulatedBoardOptions options;
        options.start_tip_m = kAboveBox_m;
        return options;
    }

    void run_to(const Unplug &unplug) {
        for (int i = 0; i < ticks_in(unplug.at_s); ++i) {
            if (unplug.when == When::pressing && i == ticks_in(kRaised_s)) {
                board.phantom().set_hand_target(kInBox_m);
            }
            tick();
        }
        ASSERT_FALSE(has_tripped()) << servo::description(last.safety);
    }

    void pull_cable(const Unplug &unplug) {
        if (unplug.after_read) {
            const device::Measurement measured = loop.read();
            port->unplug();
            last = loop.update(measured, inputs);
            loop.write(); // goes nowhere
        } else {
            port->unplug();
        }
        board.pass(unplug.in_tick_s);
    }

    /// At once, not only after the watchdog's period.
    void expect_board_is_safe(board::State before) const {
        const board::State now = state();
        if (before == board::State::driving) {
            EXPECT_EQ(now, board::State::fault_braking);
            EXPECT_NE(board.board().loop().faults() & device::BoardFaults::kNoCommand, 0);
        } else {
            EXPECT_EQ(now, board::State::braking);
        }
    }

    void expect_servo_is_safe() {
        tick();
        EXPECT_EQ(last.health, device::DeviceHealth::lost);
        EXPECT_FALSE(device::is_new(last.arrival));
        ASSERT_TRUE(has_tripped());
        EXPECT_EQ(last.safety.cause, servo::TripCause::device_lost)
            << servo::description(last.safety);
        expect_braking();
    }

    void expect_braking() const {
        EXPECT_EQ(last.command.mode, device::CommandMode::brake);
        EXPECT_TRUE(last.command.e_W_V.isZero(0.0));
        EXPECT_TRUE(last.command.cancelled_resistance_Ohm.isZero(0.0));
    }

    /// After a reset that comes too early.
    bool has_started_again(double within_s) {
        ++inputs.reset_count;
        for (int i = 0; i < ticks_in(within_s); ++i) {
            board.pass(period_s());
            tick();
            expect_braking();
            if (!has_tripped()) {
                return true;
            }
        }
        EXPECT_EQ(last.safety.cause, servo::TripCause::device_lost);
        return false;
    }

    void away_until_plugged(const Unplug &unplug) {
        if (unplug.moves_away) {
            board.phantom().set_hand_target(kAboveBox_m);
        }
        port->pass(unplug.unplugged_s);
        EXPECT_NE(state(), board::State::driving);
        port->is_plugged = true;
        device.reconnect();
        EXPECT_TRUE(device.is_zeroed());
        expect_counts_are_kept();
        run(0.05); // connected, but not reset
        EXPECT_TRUE(has_tripped());
        expect_braking();
        EXPECT_NE(state(), board::State::driving);
    }

    void expect_counts_are_kept() {
        tick();
        const Vector3 apart_rad = last.theta_rad - truth().theta_rad;
        // A count for rounding, one for the motion since the measurement of a braking device.
        EXPECT_LE(apart_rad.cwiseAbs().maxCoeff(), 2.0 * device.description().rad_per_count());
    }

    void expect_touch_again() {
        board.phantom().set_hand_target(kAboveBox_m);
        run(0.3);
        ++inputs.reset_count;
        run(kRaised_s);
        ASSERT_EQ(last.safety.state, servo::SafetyState::running)
            << servo::description(last.safety);
        EXPECT_EQ(state(), board::State::driving);
        EXPECT_EQ(last.board_faults, 0);
        board.phantom().set_hand_target(kInBox_m);
        run(kPressed_s);
        EXPECT_EQ(last.safety.state, servo::SafetyState::running)
            << servo::description(last.safety);
        EXPECT_TRUE(last.contact.touching);
        const testing::TipAt tip(device.description().geometry, truth().theta_rad);
        const Vector3 force_N = tip.force_N(
            control::torque_constants(device.description()).cwiseProduct(truth().current_A));
        EXPECT_GT(force_N.dot(last.contact.normal), kMinTouch_N);
    }

    contact::HapticSurface box_;
};

std::string text_of(const Unplug &unplug) {
    constexpr std::array<const char *, 3> kNames{"starting", "free", "pressing"};
    return std::string(kNames.at(static_cast<std::size_t>(unplug.when))) + ", at " +
           std::to_string(unplug.at_s) + " s" + (unplug.after_read ? ", after read, " : ", ") +
           std::to_string(1e6 * unplug.in_tick_s) + " us to the next";
}

void expect_touch_after_unplugs(int number) {
    constexpr std::uint64_t kSeed = 20'261'125;
    std::mt19937_64 random(kSeed);
    for (int i = 0; i < number; ++i) {
        const Unplug unplug = random_unplug(random, i);
        SCOPED_TRACE(std::to_string(i) + ": " + text_of(unplug));
        UnpluggedServo servo;
        servo.try_unplugging(unplug);
        if (::testing::Test::HasFatalFailure()) {
            return;
        }
    }
    ::testing::Test::RecordProperty("unplugs", number);
}

TEST(UnplugAnywhere, TouchComesBack) { expect_touch_after_unplugs(testing::cases(20, 200)); }

} // namespace
} // namespace springdrive::usb
