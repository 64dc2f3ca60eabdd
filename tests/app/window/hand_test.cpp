// Covers test signals of the hand and the stiffness that they meet: app/panels/hand_tab.cpp.
#include "tests/support/devices.h"
#include "tests/support/shown_window.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace springdrive::app {
namespace {

using testing::Report;
using testing::ShownWindow;

struct Stiffness {
    double measured = 0.0;
    double predicted = 0.0;
};

/// Of "measured 1.80 ± 0.00 N/mm, predicted 1.78 N/mm".
Stiffness stiffness_shown(const Report &report) {
    for (const auto &item : report.all().at("items")) {
        std::istringstream text(item.at("text").get<std::string>());
        std::string word;
        Stiffness found;
        if (text >> word && word == "measured" && text >> found.measured) {
            while (text >> word && word != "predicted") {
            }
            text >> found.predicted;
            return found;
        }
    }
    return {};
}

TEST(HandInTheWindow, APressMeetsThePredictedStiffnessWithEitherMap) {
    const std::filesystem::path folder = testing::fresh_folder("press");
    std::ofstream(folder / "down.csv") << "t,x,y,z\n0,0,0.06,0\n1.5,0,0.06,0\n2,0,-0.012,0\n";
    // Without friction and structure, whose forces the servo does not know.
    ShownWindow window({"--scene", testing::assets() / "scenes/plate.gltf", "--path",
                        folder / "down.csv", "--without", "all"});
    window.wait_until([](const Report &report) { return report.column("time_s") > 3.0; },
                      "the tip touches");
    window.click("Scene/Hand");
    for (const char *map : {"transpose", "inverse"}) {
        window.click("Hand/play");
        window.wait_until(
            [](const Report &report) { return stiffness_shown(report).measured == 0.0; },
            "it plays");
        const Stiffness found = stiffness_shown(window.wait_until(
            [](const Report &report) { return stiffness_shown(report).measured > 0.0; },
            "it is measured"));
        // The press moves at up to 20 mm/s; 5 mm deep, J and with it the prediction change by some
        // percent; the shown digits end at 0.01 N/mm.
        EXPECT_NEAR(found.measured / found.predicted, 1.0, 0.05) << map;
        window.person().key("m");
    }
}

} // namespace
} // namespace springdrive::app
