// Covers light_matrix of app/view/shadow_map.cpp.
#include "app/view/shadow_map.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <random>

namespace springdrive::app {
namespace {

constexpr float kMapRounding = 1e-4F; // the key light is unit to four digits

glm::vec3 seen(const glm::mat4 &light, const glm::vec3 &point_m) {
    return glm::vec3(light * glm::vec4(point_m, 1.0F));
}

TEST(LightMatrix, TakesItsBallToTheMapAndKeepsDepthsAlongTheLight) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<float> coordinate(-1.0F, 1.0F);
    const glm::vec3 centre_m(0.1F, -0.2F, 0.05F);
    constexpr float kRadius_m = 0.4F;
    for (const glm::vec3 &towards : {kTowardsKeyLight, glm::vec3(0.0F, 1.0F, 0.0F)}) {
        const glm::mat4 light = light_matrix(towards, centre_m, kRadius_m);
        EXPECT_LT(glm::length(seen(light, centre_m) - glm::vec3(0.5F)), kMapRounding);
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 offset_m =
                kRadius_m * glm::normalize(glm::vec3(coordinate(random), coordinate(random),
                                                     coordinate(random)));
            const glm::vec3 at = seen(light, centre_m + offset_m);
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_GT(at[axis], -kMapRounding);
                ASSERT_LT(at[axis], 1.0F + kMapRounding);
            }
            // Depth 0 is nearest to the light, one diameter before 1.
            ASSERT_NEAR(at.z, 0.5F - glm::dot(offset_m, towards) / (2.0F * kRadius_m),
                        kMapRounding);
            // What is farther along the light is at the same place of the map, and behind.
            const glm::vec3 behind = seen(light, centre_m + offset_m - 0.1F * towards);
            ASSERT_LT(glm::length(glm::vec2(behind) - glm::vec2(at)), kMapRounding);
            ASSERT_NEAR(behind.z - at.z, 0.1F / (2.0F * kRadius_m), kMapRounding);
        }
    }
}

TEST(LightMatrix, KeyLightIsUnitAndFromTheUpperLeftOfTheUser) {
    EXPECT_NEAR(glm::length(kTowardsKeyLight), 1.0F, kMapRounding);
    EXPECT_LT(kTowardsKeyLight.x, 0.0F);
    EXPECT_GT(kTowardsKeyLight.y, 0.5F);
    EXPECT_GT(kTowardsKeyLight.z, 0.0F);
}

} // namespace
} // namespace springdrive::app
