// Covers base/timing.cpp.
#include "base/timing.h"

#include <gtest/gtest.h>

#include <sstream>

namespace springdrive {
namespace {

TEST(MachineName, IsTheFirstModelThatCpuinfoNames) {
    std::istringstream two("processor\t: 0\nmodel\t\t: 17\nmodel name\t: Fast: one\n"
                           "model name\t: Slow one\n");
    EXPECT_EQ(processor_model(two), "Fast: one");
}

TEST(MachineName, MayBeUnknown) {
    std::istringstream nothing("");
    EXPECT_EQ(processor_model(nothing), "unknown processor");
    std::istringstream other("Hardware : board\nmodel name\t: \nmodel name");
    EXPECT_EQ(processor_model(other), "unknown processor");
}

TEST(MachineName, EndsWithTheCores) {
    EXPECT_NE(machine_name().find(" core"), std::string::npos);
    EXPECT_EQ(machine_name().back(), ')');
}

} // namespace
} // namespace springdrive
