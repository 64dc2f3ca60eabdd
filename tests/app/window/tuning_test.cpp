// Covers what a person does to tune: app/panels/tuning_panel.cpp, the keys.
#include "engine/control/tuning.h"
#include "engine/control/tuning_file.h"
#include "tests/support/csv.h"
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <numbers>

namespace springdrive::app {
namespace {

using testing::Point;
using testing::Report;
using testing::ShownWindow;

constexpr const char *kK_P = "K_P_V_per_rad";

/// Into the plate by a centimetre, where it stays.
std::filesystem::path pressing_path(const std::filesystem::path &folder) {
    std::ofstream(folder / "press.csv")
        << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2.5,0,-0.014,0\n600,0,-0.014,0\n";
    return folder / "press.csv";
}

/// The rows of an exported record.
std::vector<std::vector<double>> exported(const std::filesystem::path &record,
                                          const std::string &columns) {
    const testing::Ending ending =
        testing::run_program({"export", record, "--csv", "-", "--columns", columns});
    EXPECT_EQ(ending.exit_status, 0) << ending.error;
    return testing::parsed_numbers(ending.out);
}

double greatest_step(const std::vector<std::vector<double>> &rows, double from_s, double to_s) {
    double greatest = 0.0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
        for (std::size_t motor = 0; rows[i][0] > from_s && rows[i][0] < to_s && motor < 3;
             ++motor) {
            greatest = std::max(greatest, std::abs(rows[i][2 + motor] - rows[i - 1][2 + motor]));
        }
    }
    return greatest;
}

TEST(TuningInTheWindow, ADragIsOneStepAMonotoneRecordAndNoStepOfTheVoltage) {
    const std::filesystem::path folder = testing::fresh_folder("drag");
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf", "--path",
                        pressing_path(folder), "--record", folder / "t.rec"});
    window.wait_until_running();
    window.wait_until([](const Report &report) { return report.column("time_s") > 3.5; },
                      "the tip rests on the plate");
    const double start_s = window.look().column("time_s");
    const Point from = window.point_in(std::string(kK_P) + "/slider", 0.67F);
    window.person().drag(from, {from.x + 25.0F, from.y}, 5.0);
    const double end_s = window.look().column("time_s");
    const double reached = window.look().item("K_P_V_per_rad/typed").at("value");
    EXPECT_GT(reached, 10.0);
    window.click("undo");
    window.wait_until(
        [](const Report &report) { return std::abs(report.column(kK_P) - 6.0) < 1e-3; },
        "one step back is the beginning of the drag");
    window.click("redo");
    window.wait_until(
        [&](const Report &report) { return std::abs(report.column(kK_P) - reached) < 1e-3; },
        "and forth its end");
    window.program().end(SIGTERM);
    const auto rows = exported(folder / "t.rec", "time_s,K_P_V_per_rad,e_W1_V,e_W2_V,e_W3_V");
    for (std::size_t i = 1; i < rows.size(); ++i) {
        if (rows[i][0] > start_s && rows[i][0] < end_s) {
            ASSERT_GE(rows[i][1], rows[i - 1][1]) << rows[i][0];
        }
    }
    // A change moves e_W by at most 50 V/s · T. The tip moves meanwhile, as it becomes stiffer: a
    // count of the encoder, 2π/4096, moves it by K_P plus (K_D + k_T)(1 − e^(−λT))/T times that.
    const double count_rad = 2.0 * std::numbers::pi / 4096.0;
    const double of_a_count_V =
        (reached + (0.01 + 0.0234) * (1.0 - std::exp(-1.0)) / 1e-3) * count_rad;
    EXPECT_LE(greatest_step(rows, start_s, end_s), 0.05 + of_a_count_V);
}

void wait_for_K_P(ShownWindow &window, double value) {
    window.wait_until(
        [value](const Report &report) { return std::abs(report.column(kK_P) - value) < 1e-3; },
        "K_P is " + std::to_string(value));
}

TEST(TuningInTheWindow, NumbersAreAsTypedOrSaidAndNotSet) {
    ShownWindow window;
    window.wait_until_running();
    const std::string field = std::string(kK_P) + "/typed";
    window.click(field);
    window.person().clear_field();
    window.person().type("9");
    window.person().key("Escape");
    EXPECT_EQ(window.look().item(field).at("text"), "6.000");
    EXPECT_FALSE(window.look().item("undo").value("enabled", true));
    window.enter(field, "999");
    EXPECT_TRUE(window.look().shows("K_P 999 is out of range, 0 to 500 V/rad: not set"));
    EXPECT_EQ(window.look().column(kK_P), 6.0);
    window.enter(field, "6,5");
    wait_for_K_P(window, 6.5);
    EXPECT_FALSE(window.look().shows("out of range"));
    window.enter("K_D_Vs_per_rad/typed", "0,01");
    EXPECT_EQ(window.look().item("K_D_Vs_per_rad/typed").at("value"), 0.01);

    window.click(field);
    window.person().settle_by([] {}); // all of it within one frame
    kill(window.program().process(), SIGSTOP);
    window.person().key("ctrl+a");
    window.person().type("12,3456789012345");
    window.person().key("Return");
    kill(window.program().process(), SIGCONT);
    EXPECT_EQ(window.look().item(field).at("value"), 12.3456789012345);
}

TEST(TuningInTheWindow, KeysUndoRedoSwitchSlotsAndMapsButNotWhileTypingAndAfterTheEndOfADrag) {
    ShownWindow window;
    window.wait_until_running();
    const Point from = window.point_in(std::string(kK_P) + "/slider", 0.67F);
    window.person().move_to(from.x, from.y);
    window.person().press();
    window.person().move_to(from.x + 10.0F, from.y);
    window.person().key("b");
    window.person().key("ctrl+z");
    window.person().release();
    const Report dragged = window.look();
    EXPECT_EQ(dragged.item("slot").at("text"), "A | b");
    EXPECT_GT(dragged.item("K_P_V_per_rad/typed").at("value"), 6.0);
    window.person().key("b"); // the other slot is as it was
    EXPECT_EQ(window.look().item("K_P_V_per_rad/typed").at("value"), 6.0);
    window.enter(std::string(kK_P) + "/typed", "9");
    wait_for_K_P(window, 9.0);
    window.person().key("b");
    wait_for_K_P(window, dragged.item("K_P_V_per_rad/typed").at("value"));
    window.person().key("b");
    wait_for_K_P(window, 9.0);
    const auto press_until_map_is = [&](const std::string &key, double map) {
        window.person().key(key);
        window.wait_until([map](const Report &report) { return report.column("map") == map; },
                          "map " + std::to_string(map) + " by " + key);
    };
    press_until_map_is("m", 0.0);
    press_until_map_is("ctrl+z", 1.0);
    press_until_map_is("ctrl+y", 0.0);
    window.click("Scene/path");
    window.person().type("bmb");
    window.person().key("ctrl+z"); // of the text
    const Report typing = window.look();
    EXPECT_EQ(typing.column("map"), 0.0);
    EXPECT_NEAR(typing.column(kK_P), 9.0, 1e-3);
}

TEST(TuningInTheWindow, TheLockHoldsAtTheLimitForTheChosenHandUntilItIsUnlocked) {
    ShownWindow window;
    window.wait_until_running();
    window.enter(std::string(kK_P) + "/typed", "100");
    const Report held = window.look();
    EXPECT_TRUE(held.shows("held at the limit"));
    EXPECT_TRUE(held.shows("stable"));
    EXPECT_FALSE(held.shows("UNSTABLE"));
    EXPECT_LT(held.item("K_P_V_per_rad/typed").at("value").get<double>(), 60.0);
    window.click("beyond the limit");
    window.enter(std::string(kK_P) + "/typed", "100");
    const Report beyond = window.look();
    EXPECT_EQ(beyond.item("K_P_V_per_rad/typed").at("value"), 100.0);
    EXPECT_TRUE(beyond.shows("UNSTABLE"));
    // Gains that rest in a held hand are unstable without one, and so with the worst of all.
    window.enter(std::string(kK_P) + "/typed", "34");
    EXPECT_TRUE(window.look().shows("UNSTABLE"));
    window.choose("Gains/hand", "relaxed hand");
    EXPECT_FALSE(window.look().shows("UNSTABLE"));
    window.choose("Gains/hand", "no hand");
    EXPECT_TRUE(window.look().shows("UNSTABLE"));
}

TEST(TuningInTheWindow, ATuningIsSavedComparedLoadedAndRenamedAndAPresetKeepsTheMap) {
    const std::filesystem::path folder = testing::fresh_folder("tunings");
    ShownWindow window({"--map", "inverse", "--eta", "0.25"}, {}, folder);
    window.wait_until_running();
    window.enter(std::string(kK_P) + "/typed", "8");
    window.click("Tuning/Compare");
    window.enter("Compare/name", "mine");
    window.click("Compare/save");
    EXPECT_TRUE(window.look().shows("saved as mine.toml"));
    EXPECT_EQ(control::read_tuning_file(folder / "mine.toml").K_P_V_per_rad, 8.0);
    window.click("Compare/save"); // nothing is overwritten
    EXPECT_TRUE(window.look().shows("mine.toml"));
    EXPECT_FALSE(window.look().shows("saved as mine.toml"));
    window.choose("Compare/with", "mine");
    EXPECT_TRUE(window.look().shows("no difference"));
    window.choose("Compare/with", "the first tuning");
    const Report compared = window.look();
    EXPECT_TRUE(compared.shows("6 V/rad")) << compared.texts();
    EXPECT_TRUE(compared.shows("8 V/rad"));
    window.click("Compare/load");
    wait_for_K_P(window, 6.0);
    window.choose("Compare/with", "mine");
    window.enter("Compare/name", "yours");
    window.click("Compare/rename");
    EXPECT_TRUE(std::filesystem::exists(folder / "yours.toml"));
    window.choose("Compare/with", "yours");
    window.enter("Compare/name", std::string(300, 'x'));
    window.click("Compare/rename");
    EXPECT_TRUE(window.look().shows("too long")) << window.look().texts();
    EXPECT_EQ(window.look().item("Compare/with").at("text"), "yours"); // as chosen
    EXPECT_FALSE(std::filesystem::exists(folder / "mine.toml"));

    window.click("Tuning/Gains");
    const Point soft = window.point_in("soft");
    window.person().move_to(soft.x, soft.y);
    const Report told = window.wait_until(
        [](const Report &report) { return report.shows("keeps the map"); }, "the tooltip");
    EXPECT_TRUE(told.shows("sets dR")) << told.texts();
    window.click("soft");
    wait_for_K_P(window,
                 control::read_tuning_file(testing::assets() / "tunings/soft.toml").K_P_V_per_rad);
    const Report after = window.look();
    EXPECT_EQ(after.column("map"), static_cast<double>(control::MotionMap::inverse));
    EXPECT_EQ(after.column("eta"), 0.25);
    EXPECT_EQ(after.item("map").at("text"), "inverse (18)");
}

TEST(TuningInTheWindow, TheStiffestWithColdWindingsSaysWhatActs) {
    const std::filesystem::path folder = testing::fresh_folder("stiffest");
    // With that delay a motor whose dR is held up costs all three some stiffness.
    ShownWindow window({"--dR", "0.2", "--device-seed", "7", "--delay", "1"}, {}, folder);
    window.wait_until_running();
    window.click("Tuning/Stability");
    window.wait_until([](const Report &report) { return report.shows("K_P may rise to"); },
                      "the margins, above the button, are there");
    window.click("find the stiffest");
    const Report found = window.wait_until(
        [](const Report &report) { return report.shows("found, active"); }, "found", 60.0);
    EXPECT_TRUE(found.shows("at dR 0.2 Ω")) << found.texts();
    EXPECT_TRUE(found.shows("as dR is held at")) << found.texts();
    const auto place = [](const Report &report) {
        return std::pair{report.item("save as file").at("x").get<double>(),
                         report.item("save as file").at("y").get<double>()};
    };
    const auto before = place(found);
    window.click("save as file");
    const Report saved =
        window.wait_until([](const Report &report) { return report.shows("saved as"); }, "saved");
    EXPECT_EQ(place(saved), before);
}

TEST(TuningInTheWindow, AClickOnTheStabilityMapSetsGains) {
    ShownWindow window;
    window.wait_until_running();
    window.click("Tuning/Stability");
    const Report map = window.wait_until(
        [](const Report &report) { return report.find("field") != nullptr; }, "the map");
    const auto &numbers = map.item("field").at("numbers");
    // Low K_P and high dR, which is stable: a quarter from the left, an eighth from the top.
    const float x =
        numbers.at("area_x").get<float>() + 0.25F * numbers.at("area_width").get<float>();
    const float y =
        numbers.at("area_y").get<float>() + 0.125F * numbers.at("area_height").get<float>();
    window.person().click(x, y);
    // By the axes: K_P from 0.5 to 500 V/rad, dR from 0.02 to 2 Ω, both logarithmic. A pixel is
    // some 2 % of K_P and 3 % of dR.
    const double K_P = 0.5 * std::pow(1000.0, 0.25);
    const double dR = 0.02 * std::pow(100.0, 0.875);
    window.wait_until(
        [&](const Report &report) {
            return std::abs(report.column(kK_P) / K_P - 1.0) < 0.05 &&
                   std::abs(report.column("dR_Ohm") / dR - 1.0) < 0.05;
        },
        "the clicked gains are active");
}

} // namespace
} // namespace springdrive::app
