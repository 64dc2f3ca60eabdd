#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <string>

namespace springdrive::testing {

/// Of the kinds of contact::AnalyticShape::Size, in their order.
inline std::string shape_name(const ::testing::TestParamInfo<int> &info) {
    const std::array<const char *, 5> names{"Plate", "Sphere", "Box", "Cylinder", "Capsule"};
    return names[static_cast<std::size_t>(info.param)];
}

} // namespace springdrive::testing
