// Values spoilt in one place, and what is said of them.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace springdrive::testing {

/// A copy that was changed in one place.
template <typename Value, typename Change> Value spoilt(Value value, const Change &change) {
    change(value);
    return value;
}

struct Refusal {
    std::string said;
    std::string expected; ///< its beginning; empty: nothing is said
};

inline void expect_refusals(const std::vector<Refusal> &all) {
    for (const Refusal &one : all) {
        EXPECT_EQ(
            one.said.substr(0, one.expected.empty() ? std::string::npos : one.expected.size()),
            one.expected)
            << one.said;
    }
}

} // namespace springdrive::testing
