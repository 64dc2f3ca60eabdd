// Covers engine/session/model/model_selection.cpp; reading names is covered by
// selection_cache_test.cpp.
#include "engine/session/model/model_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace springdrive::model_selection {
namespace {

TEST(ModelSelection, GivesAShortReason) {
    const scene::ModelTolerance tolerance{0.05, 2.0 * M_PI / 180.0, 100.0};
    const double degree = M_PI / 180.0;
    EXPECT_EQ(verdict({0.05, 0.0}, tolerance), "meets");
    EXPECT_EQ(verdict({0.21, 0.0}, tolerance), "force 0.21 N > 0.05 N");
    EXPECT_EQ(verdict({0.0, 8.0 * degree}, tolerance), "direction 8° > 2°");
    EXPECT_EQ(verdict({1.0, 8.0 * degree}, tolerance), "force 1 N > 0.05 N, direction 8° > 2°");
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(verdict({infinity, infinity}, tolerance), "runs away");
}

} // namespace
} // namespace springdrive::model_selection
