// Covers engine/lab/charts/plant_model_chart.cpp.
#include "engine/lab/charts/plant_model_chart.h"

#include "tests/engine/lab/charts/quick_setting.h"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace springdrive::charts {
namespace {

/// The points of each line, from the longest step to the shortest.
using Lines = std::map<std::string, std::vector<ChartPoint>>;
const Lines &lines() {
    static const Lines found = [] {
        Lines sorted;
        for (const ChartPoint &point :
             plant_model_chart(testing::quick_setting(), [](double) {}).points) {
            sorted[point.method].push_back(point);
        }
        return sorted;
    }();
    return found;
}

TEST(PlantModelChart, HasEveryModelInFullAndInThePlane) {
    EXPECT_EQ(lines().size(), 2 * simulated::kPlantModels.size());
    for (const auto &[name, points] : lines()) {
        EXPECT_GE(points.size(), 5U) << name;
        for (const ChartPoint &point : points) {
            EXPECT_TRUE(point.stable) << name << " " << point.setting;
            EXPECT_GT(point.cost.min_ns, 0.0);
        }
    }
}

TEST(PlantModelChart, AFullerModelHasASmallerError) {
    const auto error_N = [](const char *model) { return lines().at(model).back().error; };
    EXPECT_LT(error_N("rigid_tip"), error_N("coupling"));
    EXPECT_LT(error_N("electromechanical"), error_N("rigid_tip"));
    // Friction alone does not reduce the error: the compliance of the structure is missing.
    EXPECT_NEAR(error_N("rigid_links"), error_N("electromechanical"), 0.05);
    EXPECT_LT(error_N("full"), 1e-3); // at 10 µs: below what a finger perceives
}

TEST(PlantModelChart, ThePlanarModelIsAsGoodWhereNothingPushesSideways) {
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        const std::string name(model.name);
        const std::vector<ChartPoint> &whole = lines().at(name);
        const std::vector<ChartPoint> &planar = lines().at(name + ", planar");
        ASSERT_EQ(whole.size(), planar.size());
        for (std::size_t i = 0; i < whole.size(); ++i) {
            EXPECT_NEAR(planar[i].error, whole[i].error, 1e-6) << name << " " << whole[i].setting;
        }
    }
}

TEST(ModelPlant, ReadsItsEncodersInWholeCounts) {
    const rig::Scenario press = press_of(testing::quick_setting(), rig::planar_press());
    const double counts_per_rad = press.device.encoder_counts_per_turn / (2.0 * std::numbers::pi);
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        const std::unique_ptr<PressedPlant> plant = model_plant(press, model, false, 10)();
        for (int period = 0; period < periods_of(press); ++period) {
            plant->advance({device::DeviceCommand::braking(), Vector3::Zero()});
            for (const double theta_rad : plant->theta_rad()) {
                const double counts = theta_rad * counts_per_rad;
                ASSERT_NEAR(counts, std::round(counts), 1e-9);
            }
        }
    }
}

} // namespace
} // namespace springdrive::charts
