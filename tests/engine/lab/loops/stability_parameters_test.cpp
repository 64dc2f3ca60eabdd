// Covers engine/lab/loops/stability_parameters.cpp.
#include "engine/lab/loops/stability_parameters.h"

#include "engine/control/tuning.h"
#include "tests/support/devices.h"
#include "tests/support/stability_cases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>

namespace springdrive::loops {
namespace {

TEST(StabilityParameters, HaveUniqueNamesAndSearchWithinTheirRange) {
    std::set<std::string_view> names;
    for (const StabilityParameter &parameter : stability_parameters()) {
        SCOPED_TRACE(parameter.name);
        EXPECT_TRUE(names.insert(parameter.name).second);
        EXPECT_EQ(stability_parameter_named(parameter.name), &parameter);
        EXPECT_NE(names_of_stability_parameters().find(parameter.name), std::string::npos);
        EXPECT_FALSE(parameter.help.empty());
        EXPECT_LT(parameter.from, parameter.to);
        for (const double good :
             {parameter.from, parameter.to, parameter.minimum, parameter.maximum}) {
            EXPECT_EQ(validate(parameter, good), "");
        }
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double bad :
             {std::nextafter(parameter.minimum, -infinity),
              std::nextafter(parameter.maximum, infinity), std::nan(""), infinity, -infinity}) {
            const std::string wrong = validate(parameter, bad);
            EXPECT_EQ(wrong.find(parameter.name), 0U) << wrong;
            EXPECT_NE(wrong.find(" from "), std::string::npos) << wrong;
            EXPECT_EQ(wrong.find('\n'), std::string::npos);
        }
    }
    EXPECT_EQ(stability_parameter_named("K_P"), nullptr);
    EXPECT_EQ(stability_parameter_named(""), nullptr);
    EXPECT_NE(validate(testing::named("dR"), 0.0).find("not 0"), std::string::npos);
    EXPECT_EQ(validate(testing::named("d"), 1.5), "");
    EXPECT_NE(validate(testing::named("d"), 8.5).find("0 to 8 periods"), std::string::npos);
}

TEST(StabilityParameters, GetWhatWasSetAndLeaveTheOthersAlone) {
    for (const StabilityParameter &parameter : stability_parameters()) {
        for (const double share : {0.0, 0.3, 1.0}) {
            const double value = parameter.from + share * (parameter.to - parameter.from);
            StabilityCase which = testing::firm();
            parameter.set(which, value);
            EXPECT_EQ(parameter.get(which), value) << parameter.name;
            for (const StabilityParameter &other : stability_parameters()) {
                if (&other != &parameter) {
                    EXPECT_EQ(other.get(which), other.get(testing::firm()))
                        << parameter.name << " moves " << other.name;
                }
            }
        }
    }
}

/// So that a limit that is found can also be set, in a file and by a slider.
TEST(StabilityParameters, AreSearchedNoFurtherThanGainsCanBeSet) {
    for (const control::Parameter &parameter : control::kParameters) {
        if (parameter.value == &control::Tuning::K_P_V_per_rad ||
            parameter.value == &control::Tuning::K_D_Vs_per_rad) {
            EXPECT_GE(parameter.maximum, stability_parameter_named(parameter.option)->to)
                << parameter.name;
        }
    }
}

TEST(StabilityParameters, AnInertiaOfItsOwnStartsAsTheSecondMotors) {
    StabilityCase which = testing::firm();
    const double damping = stability_parameter_named("damping")->get(which);
    const DrivenLoad load = driven_load(which, {1, no_hand()});
    EXPECT_EQ(damping, load.damping_Nms_per_rad(0, 0));
    stability_parameter_named("inertia")->set(which, 3e-5);
    ASSERT_TRUE(which.rotor);
    EXPECT_EQ(which.rotor->damping_Nms_per_rad, damping);
    EXPECT_EQ(driven_load(which, {1, no_hand()}).inertia_kg_m2(0, 0), 3e-5);
}

} // namespace
} // namespace springdrive::loops
