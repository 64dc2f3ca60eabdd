// Covers engine/session/session_device.cpp: a session with a board on USB, in process, in a real
// hand: its connection, and how hot its windings may be; engine/session/windings_file.cpp, and
// WindingGuard over times that nobody watched. What a board of any kind shows:
// session_emulated_test.cpp.
#include "base/input_error.h"
#include "device/core/motor/winding_heat.h"
#include "device/usb/driver/usb_device.h"
#include "engine/session/windings_file.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/devices.h"
#include "tests/support/emulated_port.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {
namespace {

using device::kColdestAir_C;
using device::kWarmestAir_C;

/// A session on a board, with nobody's simulated hand at it.
struct OnBoard {
    explicit OnBoard(const std::filesystem::path &folder)
        : board(testing::phantom_1_0(), board_options()), session(options(folder)) {
        port = new testing::EmulatedPort(board);
        auto device = std::make_unique<usb::UsbDevice>(std::unique_ptr<usb::BoardPort>(port),
                                                       testing::phantom_1_0(), "", 1e-3,
                                                       usb::Pacing::reports);
        device::HapticDevice &on_usb = *device;
        session.hand().take_hold(nullptr, session.description(), std::nullopt, Vector3::Zero());
        replaced = std::exchange(session.device(), factory::OpenDevice(std::move(device), nullptr));
        session.servo().renew(on_usb);
        session.start();
        session.advance(2e-3);
    }

    static emulator::EmulatedBoardOptions board_options() {
        emulator::EmulatedBoardOptions options;
        options.start_tip_m = Vector3::Zero();
        return options;
    }
    static SessionOptions options(const std::filesystem::path &folder) {
        SessionOptions options = testing::scripted();
        options.plays_script = false;
        options.starts_at_zero = true;
        options.windings_folder = folder;
        return options;
    }

    [[nodiscard]] const servo::WindingStatus &winding(std::size_t motor = 1) const {
        return session.latest().winding[motor];
    }
    /// Above the plate until it runs, then into it.
    [[nodiscard]] bool press(double time_s) {
        board.phantom().set_hand_target({0.0, 0.03, 0.0});
        const bool runs = testing::run_until_state(session, servo::SafetyState::running, 6.0);
        board.phantom().set_hand_target({0.0, -0.02, 0.0});
        testing::run(session, time_s);
        return runs;
    }

    emulator::EmulatedBoard board;
    testing::EmulatedPort *port = nullptr;
    Session session;
    std::optional<factory::OpenDevice> replaced;
};

TEST(SessionOnUsb, SaysEachTimeThatItIsConnectedAgain) {
    OnBoard usb("");
    for (int time = 1; time <= 3; ++time) {
        usb.port->unplug();
        usb.port->pass(0.01);
        testing::run(usb.session, 0.6);
        ASSERT_EQ(usb.session.latest().health, device::DeviceHealth::lost);
        static_cast<void>(usb.session.warnings().take_new());
        usb.port->is_plugged = true;
        testing::run(usb.session, 0.6);
        const std::vector<std::string> said = usb.session.warnings().take_new();
        EXPECT_EQ(said.size(), 1U) << time;
        EXPECT_TRUE(!said.empty() && said[0].find("connected again") != std::string::npos);
    }
}

TEST(SessionOnUsb, DoesNotTakeItsOwnBoardForAnotherProgram) {
    OnBoard usb("");
    const DeviceChoice own{usb.session.device_choice().file, factory::DeviceKind::usb,
                           usb.session.device().identity().serial};
    const std::string error = error_text_of([&] { usb.session.exchange_device(own); });
    EXPECT_NE(error.find("in use already"), std::string::npos) << error;
    EXPECT_FALSE(usb.session.is_exchanging());
    EXPECT_EQ(usb.session.device().state(), factory::DeviceState::zeroed);
}

TEST(SessionWindings, AFormerClockGivesNoLowerBound) {
    OnBoard on("");
    ASSERT_TRUE(on.press(2.0));
    ASSERT_GT(on.winding().min_C, kColdestAir_C + 0.05);
    const double before_C = on.winding().max_C;
    // The board loses its power, and runs for longer than before: its clock shows no gap.
    device::Fault restart = device::parse_fault("restart");
    restart.begin_s = on.board.time_s();
    on.board.set_fault(restart);
    const double limit_Ohm = on.winding().R_hat_limit_Ohm;
    ASSERT_TRUE(testing::run_until(
        on.session, [&] { return on.session.latest().health == device::DeviceHealth::lost; }, 2.0));
    EXPECT_GT(on.winding().min_C, kColdestAir_C + 0.05);
    ASSERT_TRUE(testing::run_until(
        on.session, [&] { return on.session.latest().health == device::DeviceHealth::ok; }, 4.0));
    testing::run(on.session, 0.02);
    EXPECT_LT(on.winding().min_C, kColdestAir_C + 1e-3);
    EXPECT_LT(on.winding().R_hat_limit_Ohm, limit_Ohm);
    EXPECT_GT(on.winding().max_C, 0.95 * before_C);
    on.session.stop();
}

TEST(SessionWindings, TheNextStartKnowsHowHotTheyMayBe) {
    const std::filesystem::path folder = testing::fresh_folder("windings session");
    const auto count = [&] {
        return std::distance(std::filesystem::directory_iterator(folder), {});
    };
    const double limit_C = testing::phantom_motor().thermal.max_winding_C;
    double end_C = 0.0;
    std::chrono::steady_clock::time_point ended;
    {
        OnBoard on(folder);
        EXPECT_NEAR(on.winding().max_C, limit_C, 0.01); // nothing is known
        EXPECT_LT(on.winding().min_C, kColdestAir_C + 1e-3);
        ASSERT_TRUE(on.press(1.0));
        EXPECT_EQ(count(), 0);
        end_C = on.winding().max_C;
        ended = std::chrono::steady_clock::now();
        on.session.stop();
        EXPECT_EQ(count(), 1);
    }
    {
        OnBoard on(folder);
        // 12 K above its housing, with a time constant of 12 s, it cools by less than 1.01 K/s.
        const std::chrono::duration<double> away = std::chrono::steady_clock::now() - ended;
        EXPECT_LE(on.winding().max_C, end_C);
        EXPECT_GE(on.winding().max_C, end_C - 1.01 * away.count());
        EXPECT_LT(on.winding().max_C, limit_C - 0.2);
        EXPECT_EQ(count(), 0);
        testing::run(on.session, 0.1); // and it is never stopped
    }
    {
        OnBoard on(folder);
        EXPECT_NEAR(on.winding().max_C, limit_C, 0.01);
        // Of what an exclusive use does, the servo sees nothing.
        testing::run(on.session, 3.0);
        EXPECT_LT(on.winding().max_C, limit_C - 1.0);
        on.session.begin_exclusive_use([] { return false; });
        ASSERT_TRUE(testing::run_until(
            on.session, [&] { return on.winding().max_C > limit_C - 0.2; }, 3.0));
        EXPECT_FALSE(on.session.is_in_exclusive_use());
        // Nor of a device that is lost.
        on.port->unplug();
        testing::run(on.session, 0.05);
        on.session.stop();
        EXPECT_EQ(count(), 0);
    }
    Session simulated(OnBoard::options(folder));
    simulated.start();
    testing::run(simulated, 0.1);
    EXPECT_LT(simulated.latest().winding[0].max_C, kWarmestAir_C + 0.1);
    simulated.stop();
    EXPECT_EQ(count(), 0);
}

using device::MotorTemperature;
using device::WindingGuard;
using device::WindingTemperature;

constexpr double kPeriod_s = 1e-3;
constexpr double kTolerance = 0.06;
constexpr const char *kSerial = "PH-7 \"/..";

std::array<device::MotorParameters, 3> motors() { return testing::phantom_1_0().motor; }

/// Of a motor without current.
MotorTemperature cooled(const MotorTemperature &from, double air_C, double time_s) {
    WindingTemperature motor(testing::phantom_motor().thermal, air_C, time_s);
    motor.raise_to(from);
    motor.update(0.0);
    return motor.temperature();
}

/// A motor that differs from its file as far as that allows, in any air, its monitor, and the
/// computer with its clocks.
class History {
public:
    explicit History(std::uint64_t seed, std::filesystem::path folder)
        : folder_(std::move(folder)), random_(seed), air_C_(any(kColdestAir_C, kWarmestAir_C)),
          truth_(motor_.thermal, air_C_, kPeriod_s), guard_(motor_, 2.8, kPeriod_s, kTolerance) {
        motor_.resistance_Ohm *= any(1.0 - kTolerance, 1.0 + kTolerance);
        motor_.commutator_phase_rad = any(0.0, 6.0);
        start();
    }

    /// As long as the upper bound allows: then the monitor brakes.
    void drive(double time_s, double target_A) {
        for (int tick = 0; tick < static_cast<int>(time_s / kPeriod_s); ++tick) {
            step(guard_.max_C() > motor_.thermal.max_winding_C ? 0.0 : target_A);
            guard_.update(current_A_);
            check();
        }
    }

    /// The board brakes once no command has come for 50 ms; its clock tells how long it was.
    void miss_periods(std::uint32_t periods) {
        for (int tick = 0; tick < 50; ++tick) {
            step(current_A_);
        }
        current_A_ = 0.0;
        pass(kPeriod_s * periods);
        guard_.update(0.0, periods + 50);
        check();
    }

    void lose_the_board(double time_s) {
        current_A_ = 0.0;
        pass(time_s);
        guard_.resume({});
        guard_.update(0.0);
        check();
    }

    enum class End { orderly, crash, damage, other_serial };

    /// @param boots     whether the computer does, too
    /// @param jump_s    of its date meanwhile
    void restart(End end, double time_s, bool boots, std::int64_t jump_s) {
        current_A_ = 0.0;
        if (end != End::crash) {
            ASSERT_TRUE(store_windings(
                folder_, kSerial, {guard_.hottest(), guard_.hottest(), guard_.hottest()}, now_));
        }
        if (end == End::damage) {
            damage();
        }
        pass(time_s);
        now_.utc_s += jump_s;
        if (boots) {
            now_.boot = "boot " + std::to_string(random_());
            now_.since_boot_s = any(20.0, 1e5);
        }
        guard_ = WindingGuard(testing::phantom_motor(), 2.8, kPeriod_s, kTolerance);
        const bool is_known =
            end == End::orderly && (jump_s >= 0 || static_cast<double>(-jump_s) < time_s);
        start(end == End::other_serial ? "another" : kSerial);
        EXPECT_EQ(guard_.max_C() == motor_.thermal.max_winding_C, !is_known);
    }

    [[nodiscard]] double any(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    [[nodiscard]] bool by_chance() { return random_() % 2 == 0; }

    int warm_ticks = 0; ///< with a lower bound that has risen
    int used_ticks = 0; ///< with an upper bound below the limit

private:
    void start(const std::string &serial = kSerial) {
        guard_.resume(take_windings(folder_, serial, motors(), now_)[0]);
        EXPECT_FALSE(std::filesystem::exists(windings_file(folder_, serial)));
        check();
    }

    /// One period, in which the current changes monotonically.
    void step(double target_A) {
        const double before_A = current_A_;
        current_A_ += 0.5 * (target_A - current_A_);
        theta_rad_ += 0.05;
        const double mean_A2 =
            (before_A * before_A + before_A * current_A_ + current_A_ * current_A_) / 3.0;
        truth_.update(mean_A2 *
                      device::winding_resistance_Ohm(motor_, truth_.winding_C(), theta_rad_));
        count(kPeriod_s);
    }

    void pass(double time_s) {
        const MotorTemperature before = truth_.temperature();
        truth_ = WindingTemperature(motor_.thermal, air_C_, kPeriod_s);
        truth_.raise_to(cooled(before, air_C_, time_s));
        count(time_s);
    }

    void count(double time_s) {
        passed_s_ += time_s;
        now_.since_boot_s += time_s;
        const auto whole_s = static_cast<std::int64_t>(passed_s_);
        passed_s_ -= static_cast<double>(whole_s);
        now_.utc_s += whole_s;
    }

    void damage() {
        const std::filesystem::path file = windings_file(folder_, kSerial);
        std::string text = testing::contents_of(file);
        switch (random_() % 4) {
        case 0:
            text.resize(random_() % text.size());
            break;
        case 1:
            text[random_() % (text.size() - 1)] ^= static_cast<char>(1U << (random_() % 7));
            break;
        case 2:
            text = std::string(1 << 20, '[');
            break;
        default:
            text[text.find("winding_C") + 12] = '2';
            text[text.find("winding_C") + 13] = '2';
            break;
        }
        std::ofstream(file, std::ios::binary) << text;
    }

    void check() {
        ASSERT_LE(guard_.min_C(), truth_.winding_C() + 1e-9);
        ASSERT_GE(guard_.max_C(), truth_.winding_C() - 1e-9);
        ASSERT_GE(guard_.hottest().housing_C, truth_.housing_C() - 1e-9);
        warm_ticks += guard_.min_C() > kColdestAir_C + 5.0 ? 1 : 0;
        used_ticks += guard_.max_C() < 99.0 ? 1 : 0;
    }

    std::filesystem::path folder_;
    std::mt19937_64 random_;
    StoringTime now_{1'800'000'000, "the first", 300.0};
    double passed_s_ = 0.0; ///< of a second
    device::MotorParameters motor_ = testing::phantom_motor();
    double air_C_;
    WindingTemperature truth_;
    WindingGuard guard_;
    double current_A_ = 0.0;
    double theta_rad_ = 0.0;
};

TEST(WindingsFile, BoundsHoldOverAnyHistory) {
    const std::filesystem::path folder = testing::fresh_folder("windings history");
    int warm_ticks = 0;
    int used_ticks = 0;
    for (std::uint64_t seed = 0; seed < 28; ++seed) {
        SCOPED_TRACE(seed);
        History history(seed, folder);
        for (int part = 0; part < 14 && !HasFailure(); ++part) {
            history.drive(history.any(0.2, 2.0), history.any(-5.5, 5.5));
            const double away_s = std::exp(history.any(std::log(0.02), std::log(4000.0)));
            switch (static_cast<int>(history.any(0.0, 8.0))) {
            case 0:
                history.miss_periods(static_cast<std::uint32_t>(history.any(0.0, 200.0)));
                break;
            case 1:
                history.miss_periods(static_cast<std::uint32_t>(history.any(200.0, 1e6)));
                break;
            case 2:
                history.lose_the_board(away_s);
                break;
            case 3:
                history.restart(History::End::orderly, away_s, false, 0);
                break;
            case 4:
                history.restart(History::End::orderly, away_s, true, 0);
                break;
            case 5: // a clock without a battery, which is set later
                history.restart(History::End::orderly, away_s, history.by_chance(), 1'000'000'000);
                break;
            case 6:
                history.restart(History::End::orderly, away_s, true, -1'000'000);
                break;
            default:
                history.restart(history.by_chance() ? History::End::crash : History::End::damage,
                                away_s, history.by_chance(), 0);
                break;
            }
        }
        history.restart(History::End::other_serial, 5.0, false, 0);
        std::filesystem::remove(windings_file(folder, kSerial));
        warm_ticks += history.warm_ticks;
        used_ticks += history.used_ticks;
    }
    EXPECT_GT(warm_ticks, 5'000); // not vacuous
    EXPECT_GT(used_ticks, 25'000);
}

/// In the worst case: 1.1 A at once and for ever, and what more is possible after some rest.
TEST(WindingsFile, NothingKnownStillPermitsWork) {
    const device::MotorParameters &motor = testing::phantom_motor();
    const auto holds_s = [&](double rest_s, double current_A) {
        WindingGuard guard(motor, 2.8, kPeriod_s, 0.05);
        guard.resume(take_windings("", "", motors(), storing_time())[0]);
        for (int tick = 0; tick < static_cast<int>(rest_s / kPeriod_s); ++tick) {
            guard.update(0.0);
            EXPECT_LE(guard.max_C(), motor.thermal.max_winding_C);
        }
        int ticks = 0;
        while (guard.max_C() <= motor.thermal.max_winding_C && ticks < 100'000) {
            guard.update(current_A);
            ++ticks;
        }
        return kPeriod_s * ticks;
    };
    EXPECT_EQ(holds_s(1.1, 1.1), 100.0); // the servo's start takes as long
    for (const double rest_s : {1.1, 10.0, 60.0, 600.0}) {
        const double at_4_A_s = holds_s(rest_s, 4.0);
        // Its heat capacity alone takes (100 °C − T) 3.87 J/K of 16 A² R, and more is lost.
        const MotorTemperature rested =
            cooled(device::hottest_motors(motors())[0], kWarmestAir_C, rest_s);
        const double capacity_J_per_K =
            motor.thermal.winding_time_s / motor.thermal.winding_housing_K_per_W;
        const double hot_Ohm = 1.05 * device::max_resistance_Ohm(motor, 100.0);
        EXPECT_GE(at_4_A_s,
                  (100.0 - rested.winding_C) * capacity_J_per_K / (16.0 * hot_Ohm) - 0.002);
    }
}

TEST(WindingsFile, IsOnlyWhereItCanBeTrusted) {
    const std::filesystem::path folder = testing::fresh_folder("windings trust");
    const std::array<MotorTemperature, 3> warm{{{60.0, 50.0}, {61.0, 51.0}, {62.0, 52.0}}};
    const StoringTime then{1000, "boot", 10.0};
    const double limit_C = testing::phantom_motor().thermal.max_winding_C;
    const auto taken = [&] { return take_windings(folder, kSerial, motors(), then); };
    ASSERT_TRUE(store_windings(folder / "new", kSerial, warm, then)); // makes the folder
    ASSERT_TRUE(store_windings(folder, kSerial, warm, then));
    EXPECT_EQ(taken()[2].housing_C, 52.0);
    EXPECT_EQ(taken()[2].winding_C, limit_C); // it is gone
    EXPECT_FALSE(store_windings("", kSerial, warm, then));
    std::filesystem::create_directories(windings_file(folder, kSerial) / "not empty");
    EXPECT_FALSE(store_windings(folder, kSerial, warm, then));
    EXPECT_EQ(taken()[0].winding_C, limit_C);
    std::filesystem::remove_all(windings_file(folder, kSerial));
    for (const double wrong_C : {std::nan(""), 1e9, -5.0}) {
        static_cast<void>(store_windings(
            folder, kSerial, {MotorTemperature{wrong_C, 40.0}, warm[1], warm[2]}, then));
        EXPECT_EQ(taken()[0].winding_C, limit_C) << wrong_C;
    }
}

} // namespace
} // namespace springdrive::session
