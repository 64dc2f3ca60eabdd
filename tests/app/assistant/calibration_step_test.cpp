// Covers the calibration of app/assistant/board_steps.cpp: on emulated devices whose motors and
// sensors are drawn at random, against their truth; and what can come between.
#include "device/core/device_file.h"
#include "device/simulated/plant_setup.h"
#include "engine/control/winding_observer.h"
#include "tests/app/assistant/walker.h"
#include "tests/support/calibrations.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <tuple>

namespace springdrive::app::assistant {
namespace {

using session::SessionOptions;
using testing::Walker;

constexpr std::uint64_t kSeed = 7;
constexpr const char *kSerial = "emulated-7";

SessionOptions sampled_device(const std::vector<std::string> &faults = {}) {
    SessionOptions options = Walker::options_with(faults);
    options.device_seed = kSeed;
    options.starts_at_zero = true;
    return options;
}

/// A device that has come to its calibration, zeroed.
struct AtCalibration {
    std::filesystem::path folder;
    Walker walker;

    explicit AtCalibration(const SessionOptions &options = sampled_device())
        : folder(folder_at_calibration()), walker(folder, options) {
        EXPECT_EQ(walker.assistant.present(), StepName::calibration) << walker.text();
        walker.run(0.2);
    }

    static std::filesystem::path folder_at_calibration() {
        std::filesystem::path folder =
            testing::fresh_folder(::testing::UnitTest::GetInstance()->current_test_info()->name());
        Progress progress;
        for (std::size_t i = 0; i < index_of(StepName::calibration); ++i) {
            progress.done.set(i);
        }
        write_progress(folder / progress_name("emulated", kSerial), progress);
        return folder;
    }

    [[nodiscard]] const std::optional<device::Calibration> &in_use() {
        return walker.session.description().calibration;
    }
    [[nodiscard]] std::optional<device::Calibration> on_board() {
        std::optional<device::Calibration> stored;
        walker.session.servo().paused(
            [&] { stored = walker.session.device().device().bench()->stored_calibration(); });
        return stored;
    }
    [[nodiscard]] usb::BoardState board_state() {
        return walker.session.device().emulated()->board().board().loop().state();
    }
    void set_plugged(bool is_plugged) { // in lockstep nobody else uses it
        walker.session.device().emulated()->set_plugged(is_plugged);
    }
};

TEST(CalibrationStep, MeasuresTheMotorsWhichAreInUseAtOnceAndAfterwards) {
    AtCalibration at;
    Walker &walker = at.walker;
    const device::DeviceDescription file = walker.session.description();
    EXPECT_EQ(walker.verdict(), Verdict::open);
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    walker.calibrate();
    ASSERT_EQ(walker.verdict(), Verdict::good) << walker.text();
    EXPECT_TRUE(walker.says("kept by the board")) << walker.text();
    ASSERT_TRUE(at.in_use());
    const device::Calibration known = *at.in_use();
    EXPECT_EQ(known.serial, kSerial);
    const simulated::SampledDevice truth = simulated::sampled_device(file, kSeed);
    bool is_another_device = false;
    for (std::size_t j = 0; j < 3; ++j) {
        const double true_Ohm = truth.motor[j].resistance_share * file.motor[j].resistance_Ohm /
                                truth.motor[j].sensing.amplifier.gain;
        const double k_T =
            truth.motor[j].torque_constant_share * file.motor[j].torque_constant_Nm_per_A;
        constexpr double kDeviations = 4.8; // beyond it, by chance: one of 600 000
        const device::MotorCalibration &found = known.motor[j];
        EXPECT_NEAR(found.resistance_Ohm, true_Ohm, kDeviations * found.resistance_deviation_Ohm);
        EXPECT_LT(found.resistance_deviation_Ohm, 8e-3 * true_Ohm);
        EXPECT_NEAR(found.torque_constant_Nm_per_A, k_T,
                    kDeviations * found.torque_constant_deviation_Nm_per_A);
        is_another_device = is_another_device ||
                            std::abs(file.motor[j].resistance_Ohm - true_Ohm) > 0.01 * true_Ohm;
        // The servo that goes on has begun with it.
        const control::ResistanceEstimate used = walker.session.latest().motor[j].mean;
        EXPECT_NEAR(used.resistance_Ohm, true_Ohm, kDeviations * used.deviation_Ohm);
        EXPECT_LT(used.deviation_Ohm, 0.5 * control::known_at_start(file, j).mean.deviation_Ohm);
    }
    EXPECT_TRUE(is_another_device); // or the file's values would have passed, too
    const std::optional<device::Calibration> stored = at.on_board();
    ASSERT_TRUE(stored);
    EXPECT_EQ(stored->made_at_s, known.made_at_s);

    // A record of now has it, to the last bit.
    const session::Record now = walker.session.past().back();
    const device::DeviceDescription recorded =
        device::read_device_text(now.header.device_toml, "of the record");
    ASSERT_TRUE(recorded.calibration);
    testing::expect_equal(*recorded.calibration, known);

    // And it is there when the step is entered again, also after a new zero.
    walker.assistant.again(walker.session);
    EXPECT_EQ(walker.verdict(), Verdict::good);
    EXPECT_TRUE(walker.says(device::text_of_utc(known.made_at_s) + ", kept by the board"))
        << walker.text();
    walker.run_until([&] { return !walker.session.hand().follows_path(); }, 10.0);
    walker.run(0.5);
    EXPECT_TRUE(walker.offers("calibrate again"));
    walker.session.zero_device(Vector3::Zero());
    walker.run(0.2);
    EXPECT_TRUE(walker.says("zeroing anew leaves it")) << walker.text();
    EXPECT_TRUE(at.in_use());
    walker.next();
    walker.touch();
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
}

TEST(CalibrationStep, ShowsHowFarItIsAndStoppedOrLeftKeepsNothing) {
    for (const bool leaves : {false, true}) {
        SessionOptions options = sampled_device();
        options.servo_hz = 2000.0;
        AtCalibration at(options);
        Walker &walker = at.walker;
        walker.choose("start");
        walker.run(0.1);
        EXPECT_TRUE(walker.says("Hold the stylus still in free space")) << walker.text();
        ASSERT_TRUE(walker.run_until([&] { return walker.offers("that is enough"); }, 15.0));
        walker.run(2.0);
        const StepReport early = walker.report();
        ASSERT_EQ(early.bars.size(), 4U); // a motor each, and the time
        walker.run(6.0);
        const StepReport later = walker.report();
        for (std::size_t j = 0; j < 3; ++j) {
            EXPECT_GT(later.bars.at(j).value, early.bars[j].value) << early.bars[j].label;
            EXPECT_NE(early.bars[j].text.find("Ω"), std::string::npos);
        }
        constexpr double kFrame_s = 1.0 / 60.0;
        EXPECT_NEAR(early.bars[3].value - later.bars[3].value, 6.0, 2.0 * kFrame_s); // time left
        EXPECT_TRUE(walker.assistant.theta_rad());
        EXPECT_EQ(walker.verdict(), Verdict::open);
        EXPECT_EQ(at.board_state(), usb::BoardState::driving);
        EXPECT_EQ(walker.session.servo().rate_hz(), commissioning::CalibrationRun::kRate_hz);

        if (leaves) {
            walker.assistant.leave(walker.session);
        } else {
            walker.choose("stop");
        }
        EXPECT_FALSE(walker.session.is_in_exclusive_use());
        EXPECT_EQ(walker.session.servo().rate_hz(), 2000.0);
        walker.session.advance(1e-3);
        walker.session.advance(1e-3);
        EXPECT_EQ(at.board_state(), usb::BoardState::braking);
        EXPECT_FALSE(at.in_use());
        EXPECT_FALSE(at.on_board());
        if (leaves) {
            walker.assistant.open(walker.session);
        }
        walker.run(0.5);
        EXPECT_EQ(walker.assistant.present(), StepName::calibration);
        EXPECT_EQ(walker.verdict(), Verdict::open);
        EXPECT_EQ(walker.says("stopped before its end"), !leaves) << walker.text();
        EXPECT_NE(walker.session.latest().safety.state, servo::SafetyState::tripped);
        EXPECT_TRUE(walker.run_until( // the hand returns
            [&] { return walker.offers(leaves ? "start" : "calibrate again"); }, 10.0));
        walker.choose("skip");
        EXPECT_EQ(walker.verdict(), Verdict::skipped);
        walker.next();
        EXPECT_EQ(walker.assistant.present(), StepName::touch);
    }
}

TEST(CalibrationStep, APulledCableAndAnEmergencyStopAreNamedAndItIsDoneAgain) {
    AtCalibration at;
    Walker &walker = at.walker;
    walker.begin_calibration();
    walker.run(2.0);
    at.set_plugged(false);
    ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_in_exclusive_use(); }, 5.0));
    walker.run(1.0);
    EXPECT_TRUE(walker.says("the device is lost")) << walker.text();
    EXPECT_FALSE(walker.assistant.can_go_on(walker.session));
    EXPECT_FALSE(at.in_use());
    at.set_plugged(true);
    walker.run(1.5);
    EXPECT_FALSE(at.on_board());
    walker.assistant.again(walker.session);
    walker.run(0.2);

    walker.begin_calibration();
    walker.session.servo().emergency_stop();
    walker.run(0.1);
    EXPECT_FALSE(walker.session.is_in_exclusive_use());
    EXPECT_NE(at.board_state(), usb::BoardState::driving);
    EXPECT_TRUE(walker.says("emergency stop")) << walker.text();
    EXPECT_FALSE(walker.offers("calibrate again"));
    walker.assistant.again(walker.session);
    walker.run(0.2);
    walker.calibrate();
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
    EXPECT_TRUE(at.in_use());
}

/// Shorter than the time for which the hand comes to rest after a calibration; at its start, and
/// in the middle.
TEST(CalibrationStep, AFaultOfTheBoardOutlastsIt) {
    for (const auto &[fault, says, after_s] : {std::tuple("stop", "stop switch", 0.0),
                                               {"stop", "stop switch", 1.0},
                                               {"brown-out:2", "supply", 0.0}}) {
        AtCalibration at;
        Walker &walker = at.walker;
        walker.begin_calibration();
        ASSERT_TRUE(walker.run_until([&] { return walker.session.servo().is_halted(); }, 5.0));
        walker.run(after_s);
        ASSERT_TRUE(walker.session.is_in_exclusive_use());
        emulator::EmulatedBoard &board = walker.session.device().emulated()->board();
        device::Fault short_one = device::parse_fault(fault);
        short_one.begin_s = board.time_s();
        short_one.end_s = short_one.begin_s + 0.03;
        board.set_fault(short_one);
        ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_in_exclusive_use(); }, 5.0));
        walker.run(0.3);
        EXPECT_EQ(walker.session.latest().safety.state, servo::SafetyState::tripped);
        EXPECT_EQ(walker.session.servo().is_held_stopped(), fault == std::string("stop"));
        EXPECT_TRUE(walker.says(says)) << walker.text();
        walker.assistant.again(walker.session);
        walker.run(0.2);
        EXPECT_FALSE(walker.session.servo().is_held_stopped());
    }
}

TEST(CalibrationStep, ABoardThatDoesNotKeepItIsDoubtfulUntilAFileDoes) {
    AtCalibration at(sampled_device({"failed-store"}));
    Walker &walker = at.walker;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(at.folder); // the program's own folder
    walker.calibrate();
    EXPECT_EQ(walker.verdict(), Verdict::doubtful);
    EXPECT_TRUE(walker.says("could not store a calibration")) << walker.text();
    ASSERT_TRUE(at.in_use()); // all the same
    walker.assistant.again(walker.session);
    EXPECT_TRUE(walker.says("in use until the program ends")) << walker.text();
    walker.choose("calibrate again");
    ASSERT_TRUE(walker.run_until([&] { return walker.offers("save as a file"); }, 60.0));
    walker.choose("save as a file");
    std::filesystem::current_path(before);
    EXPECT_EQ(walker.verdict(), Verdict::good) << walker.text();
    const device::Calibration known = *at.in_use();
    int files = 0;
    for (const auto &entry : std::filesystem::directory_iterator(at.folder)) {
        if (entry.path().filename().string().starts_with("calibrated-")) {
            ++files;
            EXPECT_TRUE(walker.says("--device-file " + entry.path().string())) << walker.text();
            const device::DeviceDescription read = device::read_device_file(entry.path());
            ASSERT_TRUE(read.calibration);
            testing::expect_equal(*read.calibration, known);
        }
    }
    EXPECT_EQ(files, 1);
}

TEST(CalibrationStep, TooLittleMotionIsDoubtful) {
    AtCalibration at;
    Walker &walker = at.walker;
    walker.begin_calibration();
    walker.run(0.5);
    walker.choose("that is enough");
    ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_in_exclusive_use(); }, 10.0));
    walker.run(0.1);
    EXPECT_EQ(walker.verdict(), Verdict::doubtful);
    EXPECT_TRUE(walker.says("was not turned enough")) << walker.text();
    EXPECT_FALSE(at.in_use());
    EXPECT_FALSE(at.on_board());
    walker.assistant.continue_all_the_same(walker.session);
    EXPECT_EQ(walker.assistant.present(), StepName::touch);
}

TEST(CalibrationStep, AnotherMotorThanTheFilesIsNotPassed) {
    SessionOptions options = sampled_device();
    options.emulation.truth = testing::phantom_1_0();
    options.emulation.truth->motor[1].resistance_Ohm *= 1.15; // of tolerances of 6 %
    AtCalibration at(options);
    Walker &walker = at.walker;
    walker.calibrate();
    EXPECT_EQ(walker.verdict(), Verdict::bad) << walker.text();
    EXPECT_TRUE(walker.says("motor 2")) << walker.text();
    EXPECT_FALSE(at.in_use());
    EXPECT_FALSE(at.on_board());
    walker.assistant.leave(walker.session);
    EXPECT_TRUE(walker.session.is_kept_released());
}

TEST(CalibrationStep, OneOfTheDeviceFileIsShownAndComesBeforeTheBoards) {
    SessionOptions options = sampled_device();
    options.device.file = testing::fresh_folder("calibrated") / "mine.toml";
    std::ofstream(options.device.file) << device::with_calibration(
        testing::contents_of(testing::assets() / "devices/phantom_1_0.toml"),
        testing::possible_calibration(kSerial));
    AtCalibration at(options);
    Walker &walker = at.walker;
    EXPECT_EQ(walker.verdict(), Verdict::good);
    EXPECT_TRUE(walker.says("2025-11-24T16:00:00Z, kept in the device file")) << walker.text();
    const device::Calibration before = *at.in_use();
    walker.choose("calibrate again");
    ASSERT_TRUE(walker.run_until([&] { return walker.offers("that is enough"); }, 15.0));
    ASSERT_TRUE(walker.run_until([&] { return !walker.session.is_in_exclusive_use(); }, 60.0));
    walker.run(0.2);
    EXPECT_NE(at.in_use()->made_at_s, before.made_at_s);
    ASSERT_TRUE(at.on_board());
    EXPECT_EQ(walker.verdict(), Verdict::doubtful); // for the next start
    EXPECT_TRUE(walker.says("comes before the board's")) << walker.text();
}

} // namespace
} // namespace springdrive::app::assistant
