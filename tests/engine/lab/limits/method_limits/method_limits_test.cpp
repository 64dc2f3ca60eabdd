// Covers engine/lab/limits/method_limits: each limit found by trials is crossed from both sides of
// its prediction, and where none is predicted, none is found. The limits of sampled loops are in
// loop_limits_test.cpp.
#include "engine/lab/limits/method_limits/method_limits.h"

#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace springdrive::limits {
namespace {

/// Relative distance of both sides from the limit. Trials of some seconds do not resolve less; the
/// linear prediction of a released hand lacks the filter's lag and the motion between two samples,
/// some 0.5 %.
constexpr double kAside = 0.01;

void expect_crossing(const LimitTrial &trial) {
    const double line = trial.line.predicted.value();
    if (trial.whole) {
        EXPECT_TRUE(trial.holds(line));
        EXPECT_FALSE(trial.holds(line + 1.0));
        return;
    }
    const double outward = (trial.fails_at > trial.holds_at ? kAside : -kAside) * std::abs(line);
    EXPECT_TRUE(trial.holds(line - outward));
    EXPECT_FALSE(trial.holds(line + outward));
}

void expect_as_predicted(const LimitTrial &trial) {
    SCOPED_TRACE(trial.line.method + ": " + trial.line.fails + ", " + trial.line.setting);
    if (trial.reading) {
        const std::optional<double> read = trial.reading();
        ASSERT_TRUE(read.has_value());
        ASSERT_TRUE(trial.line.predicted.has_value());
        // The commutator's angle, up to 2 % of R, affects the heat of a held contact but not its
        // prediction; values counted in ticks have a tolerance of one tick.
        EXPECT_NEAR(*read, *trial.line.predicted, 3e-3 * *trial.line.predicted);
    } else if (trial.line.predicted) {
        expect_crossing(trial);
    } else {
        EXPECT_EQ(measured(trial).measured, std::nullopt);
    }
}

TEST(MethodLimits, AreWhereTheyArePredicted) {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    for (const LimitTrial &trial : limit_trials(which)) {
        expect_as_predicted(trial);
    }
}

/// Predictions from a device's parameters hold for another device, too. Its links are unequal, for
/// which some limits have no closed form.
TEST(MethodLimits, OfAnotherDeviceAreWhereTheyArePredicted) {
    loops::StabilityCase which;
    which.device = testing::phantom_premium_1_5();
    which.device.motor[0].resistance_Ohm *= 1.2;
    which.device.motor[1].resistance_Ohm *= 1.1;
    which.device.motor[1].inductance_H *= 1.3;
    int crossed = 0;
    for (const LimitTrial &trial : limit_trials(which)) {
        if (trial.line.predicted) {
            expect_as_predicted(trial);
            ++crossed;
        }
    }
    EXPECT_GT(crossed, 20);
}

TEST(MethodLimits, AreOfEveryMethodOfTheDesign) {
    loops::StabilityCase which;
    which.device = testing::phantom_1_0();
    std::set<std::string> methods;
    for (const LimitTrial &trial : limit_trials(which)) {
        methods.insert(trial.line.method);
    }
    for (const char *method :
         {"resistance cancellation (6)", "inverse kinematics (18)", "transpose kinematics (23)",
          "explicit Euler", "semi-implicit Euler", "Runge-Kutta 4", "closest point (penalty)",
          "proxy", "servo", "motor"}) {
        EXPECT_EQ(methods.count(method), 1U) << method;
    }
}

/// As the program prints it: every row once, each found within what its method allows.
TEST(MethodLimits, TheTableHoldsEveryRowAndWhatWasPredicted) {
    std::vector<double> shares;
    const std::vector<MethodLimit> lines =
        method_limits(testing::firm(), [&shares](double share) { shares.push_back(share); });
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    ASSERT_FALSE(shares.empty());
    EXPECT_NEAR(shares.back(), 1.0, 1e-9);
    std::set<std::string> rows;
    std::size_t of_loops = 0;
    for (const MethodLimit &line : lines) {
        SCOPED_TRACE(line.method + ": " + line.fails + ", " + line.setting);
        EXPECT_TRUE(rows.insert(line.method + line.fails + line.setting).second);
        of_loops += line.method.starts_with("drift") || line.method == "current-drive wall" ||
                            line.fails == "α above"
                        ? 1
                        : 0;
        if (line.predicted && line.measured) {
            EXPECT_NEAR(*line.measured, *line.predicted, 0.02 * std::abs(*line.predicted));
        } else {
            EXPECT_FALSE(line.predicted); // every predicted limit is found
        }
    }
    EXPECT_EQ(lines.size(), limit_trials(testing::firm()).size() + of_loops);
    EXPECT_EQ(of_loops, 10U);
}

TEST(MethodLimits, TheTableIsForTheRequestedHand) {
    loops::StabilityCase gripped = testing::firm();
    gripped.hands = {loops::hand_of_firmness(1.0)};
    const std::vector<MethodLimit> lines = method_limits(gripped, [](double) {});
    const auto row = std::ranges::find(lines, "K_P above", &MethodLimit::fails);
    ASSERT_NE(row, lines.end());
    ASSERT_TRUE(row->predicted);
    const auto at = [&row](const loops::StabilityCase &which, double share) {
        return testing::with(which, testing::named("kp"), share * *row->predicted);
    };
    EXPECT_TRUE(loops::is_stable(at(gripped, 0.99)));
    EXPECT_FALSE(loops::is_stable(at(gripped, 1.01)));
    EXPECT_FALSE(loops::is_stable(at(testing::firm(), 0.99))); // another hand is less stable
}

TEST(MethodLimits, AreWrittenAsMarkdownAndAsCsv) {
    const std::vector<MethodLimit> lines{
        {"servo", "a tick later than", "ms", "1 kHz, 2 V", 51.0, 51.00001, {}}};
    std::ostringstream csv;
    write_csv(csv, method_limits_table(lines));
    EXPECT_EQ(csv.str(), "method,fails,unit,setting,predicted,measured,measured_as_it_is\n"
                         "servo,a tick later than,ms,\"1 kHz, 2 V\",51,51.00001,\n");
    std::ostringstream out;
    write_markdown(out, method_limits_document(lines));
    EXPECT_EQ(out.str(), "| method | fails | setting | predicted | measured | as it is |\n"
                         "| --- | --- | --- | ---: | ---: | ---: |\n"
                         "| servo | a tick later than (ms) | 1 kHz, 2 V | 51 | 51 | – |\n");
}

} // namespace
} // namespace springdrive::limits
