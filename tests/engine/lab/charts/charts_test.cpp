// Covers engine/lab/charts/charts.h: press_charts.cpp, and the charts of motion_charts.cpp,
// touch_charts.cpp and servo_rate_chart.cpp.
#include "engine/lab/charts/charts.h"

#include "base/input_error.h"
#include "device/simulated/plant_model.h"
#include "tests/engine/lab/charts/quick_setting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace springdrive::charts {
namespace {

/// The charts that are tried, each made once, with how often its progress was reported.
const SpeedAccuracyChart &chart(const std::string &name) {
    static std::map<std::string, SpeedAccuracyChart> made;
    if (!made.contains(name)) {
        const auto *maker = std::ranges::find(kCharts, name, &ChartMaker::name);
        double last_share = 0.0;
        made[name] = maker->make(testing::quick_setting(), [&last_share](double share) {
            EXPECT_GT(share, last_share);
            last_share = share;
        });
        EXPECT_NEAR(last_share, 1.0, 1e-12) << name;
    }
    return made[name];
}

/// The points of each line, in their order.
std::map<std::string, std::vector<ChartPoint>> lines(const std::string &name) {
    std::map<std::string, std::vector<ChartPoint>> sorted;
    for (const ChartPoint &point : chart(name).points) {
        sorted[point.method].push_back(point);
    }
    return sorted;
}

TEST(Charts, HaveTheirLinesWithCostsAndCrosses) {
    const std::size_t models = simulated::kPlantModels.size();
    struct Case {
        const char *name;
        std::size_t lines;
        std::size_t points;
        bool first_diverges; // explicit Euler at 1 ms
    };
    for (const Case &each :
         {Case{"integrators_vice", 7, 5 * 11 + 2 * 5, true},
          Case{"integrators_friction", 7, 5 * 7 + 2 * 6, true},
          Case{"plant_models", 2 * models, 2 * models * 7, false},
          Case{"motion_direction", 4, 4 * 5, false}, Case{"motion_stiffness", 4, 3 + 5, false},
          Case{"proxies_thin_plate", 3, 2 * 6 + 1, true},
          Case{"servo_rate_stiffness", 3, 3 * 7, false},
          Case{"servo_rate_direction", 3, 3 * 7, false}}) {
        SCOPED_TRACE(each.name);
        EXPECT_EQ(chart(each.name).name, each.name);
        EXPECT_EQ(lines(each.name).size(), each.lines);
        EXPECT_EQ(chart(each.name).points.size(), each.points);
        for (const ChartPoint &point : chart(each.name).points) {
            SCOPED_TRACE(point.method + ", " + point.setting);
            EXPECT_FALSE(point.setting.empty());
            EXPECT_TRUE(std::isfinite(point.error) || !point.stable);
            EXPECT_TRUE(point.stable || !std::isfinite(point.error) ||
                        !chart(each.name).name.starts_with("integrators"));
            EXPECT_TRUE(point.cost.min_ns > 0.0 || !point.stable);
            EXPECT_LE(point.cost.min_ns, point.cost.median_ns);
            EXPECT_LE(point.cost.median_ns, point.cost.max_ns);
        }
        if (each.first_diverges) {
            EXPECT_FALSE(chart(each.name).points.front().stable);
        }
    }
}

TEST(PlantModelChart, AFullerModelHasASmallerError) {
    auto of_models = lines("plant_models");
    const auto error_N = [&](const char *model) { return of_models.at(model).back().error; };
    EXPECT_LT(error_N("rigid_tip"), error_N("coupling"));
    EXPECT_LT(error_N("electromechanical"), error_N("rigid_tip"));
    // Friction alone does not reduce the error: the compliance of the structure is missing.
    EXPECT_NEAR(error_N("rigid_links"), error_N("electromechanical"), 0.05);
    EXPECT_LT(error_N("full"), 1e-3); // at 10 µs: below what a finger perceives
}

/// Also where nothing pushes sideways the planar model is as good as the whole.
TEST(PlantModelChart, ThePlanarModelIsAsGoodAndNoneDiverges) {
    auto of_models = lines("plant_models");
    for (const simulated::PlantModel &model : simulated::kPlantModels) {
        const std::string name(model.name);
        const std::vector<ChartPoint> &whole = of_models.at(name);
        const std::vector<ChartPoint> &planar = of_models.at(name + ", planar");
        for (std::size_t i = 0; i < whole.size(); ++i) {
            EXPECT_TRUE(whole[i].stable && planar[i].stable) << name << " " << whole[i].setting;
            EXPECT_NEAR(planar[i].error, whole[i].error, 1e-6) << name << " " << whole[i].setting;
        }
    }
}

TEST(MotionControlChart, FinerEncodersReduceTheErrorOfTheTransposeAndNotOfTheInverse) {
    for (const auto &[method, points] : lines("motion_direction")) {
        const bool is_inverse = method.starts_with("inverse");
        for (std::size_t i = 1; i < points.size(); ++i) { // each four times as fine
            const double ratio = points[i - 1].error / points[i].error;
            EXPECT_NEAR(ratio, is_inverse ? 1.0 : 4.0, is_inverse ? 0.05 : 1.5) << method;
        }
        if (is_inverse) {
            EXPECT_GT(points.back().error, 25.0); // the perceptible angle of the paper
        } else {
            EXPECT_LT(points.front().error, 0.2);
        }
    }
}

TEST(MotionControlChart, GlobalAlphaIsSofterThanOnTheFlyAndThatThanTheInverse) {
    auto of_methods = lines("motion_stiffness");
    const double inverse = of_methods["inverse (18)"].front().error;
    const double on_the_fly = of_methods["transpose (23), α on the fly"].front().error;
    const double global = of_methods["transpose, global α"].front().error;
    EXPECT_LT(inverse, on_the_fly); // (28)
    EXPECT_LT(on_the_fly, global);  // the global α is the minimum
    const std::vector<ChartPoint> &by_hand = of_methods["transpose, α by hand"];
    for (std::size_t i = 1; i < by_hand.size(); ++i) { // (27): twice the α, half the compliance
        EXPECT_NEAR(by_hand[i - 1].error / by_hand[i].error, 2.0, 1e-6);
        EXPECT_LE(by_hand[i].stable, by_hand[i - 1].stable);
    }
    EXPECT_TRUE(by_hand.front().stable);
    EXPECT_FALSE(by_hand.back().stable);
}

TEST(MotionControlChart, RefusesATuningWithoutStaticStiffness) {
    ChartSetting without = testing::quick_setting();
    without.tuning.K_P_V_per_rad = 0.0;
    EXPECT_THROW((void)motion_direction_chart(without, [](double) {}), InputError);
    without = testing::quick_setting();
    without.tuning.eta = 1.0;
    EXPECT_THROW((void)motion_stiffness_chart(without, [](double) {}), InputError);
}

TEST(ProxyChart, OnAThinPlateThePenaltyAlwaysFailsAndTheProxyIsExact) {
    for (const ChartPoint &point : chart("proxies_thin_plate").points) {
        const bool is_penalty = point.method.find("penalty") != std::string::npos;
        EXPECT_EQ(point.stable, !is_penalty) << point.method;
        if (!is_penalty) {
            EXPECT_LT(point.error, 1e-15) << point.method; // round-off of 50 mm
        }
    }
}

TEST(ServoRateChart, AFasterServoCostsMoreAndHasSmallerErrors) {
    for (const char *name : {"servo_rate_stiffness", "servo_rate_direction"}) {
        for (const auto &[method, points] : lines(name)) {
            EXPECT_EQ(points.front().setting, "250 Hz");
            EXPECT_EQ(points.back().setting, "20 kHz");
            for (std::size_t i = 1; i < points.size(); ++i) {
                SCOPED_TRACE(method + ' ' + points[i].setting);
                EXPECT_GT(points[i].cost.median_ns, points[i - 1].cost.median_ns);
                EXPECT_LT(points[i].error, points[i - 1].error);
                EXPECT_GE(points[i].stable, points[i - 1].stable);
            }
        }
    }
}

TEST(ChartCsv, HasARowForEachPoint) {
    SpeedAccuracyChart chart;
    chart.points = {{"one", "100 µs", {1.5, 2.0, 1e6}, 1e-17, true},
                    {"two", "", {0.0, 0.0, 0.0}, NAN, false},
                    {"a, \"b\"", "two\nlines", {1.0, 1.0, 1.0}, INFINITY, false}};
    std::ostringstream out;
    write_csv(out, chart_table(chart, "AMD EPYC (2 cores)"));
    EXPECT_EQ(out.str(),
              "method,setting,cost_least_ns,cost_median_ns,cost_greatest_ns,error,stable,machine\n"
              "one,100 µs,1.5,2,1e+06,1e-17,1,AMD EPYC (2 cores)\n"
              "two,,0,0,0,,0,AMD EPYC (2 cores)\n"
              "\"a, \"\"b\"\"\",\"two\nlines\",1,1,1,,0,AMD EPYC (2 cores)\n");
}

} // namespace
} // namespace springdrive::charts
