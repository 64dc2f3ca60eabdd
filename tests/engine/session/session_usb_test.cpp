// Covers engine/session/session_device.cpp: a session with a board on USB, in process, in a real
// hand: its connection, and how hot its windings may be. What a board of any kind shows:
// session_emulated_test.cpp.
#include "base/error_text.h"
#include "device/core/motor/winding_temperature.h"
#include "device/usb/driver/usb_device.h"
#include "tests/engine/session/session_fixture.h"
#include "tests/support/emulated_port.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
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
        const bool runs = testing::run_until(
            session, [&] { return session.latest().safety.state == servo::SafetyState::running; },
            6.0);
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
        // Of what a loan does, the servo sees nothing.
        testing::run(on.session, 3.0);
        EXPECT_LT(on.winding().max_C, limit_C - 1.0);
        on.session.lend_device([] { return false; });
        ASSERT_TRUE(testing::run_until(
            on.session, [&] { return on.winding().max_C > limit_C - 0.2; }, 3.0));
        EXPECT_FALSE(on.session.is_lent());
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

} // namespace
} // namespace springdrive::session
