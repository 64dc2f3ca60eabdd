// Covers engine/scene/scene_extras.cpp.
#include "base/degrees.h"
#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

GltfBuilder with_scene_extras(const std::string &extras) {
    GltfBuilder builder = one_triangle();
    builder.scenes = {R"({"nodes": [0], "extras": )" + extras + "}"};
    return builder;
}

void expect_refused(const std::string &extras, const std::string &message) {
    expect_failure(with_scene_extras(extras), message);
}

TEST(SceneExtras, WithoutAnyTheDefaultsHold) {
    const Scene scene = load(one_triangle());
    EXPECT_FALSE(scene.planar);
    EXPECT_EQ(scene.tolerance.force_N, 0.05);
    EXPECT_NEAR(scene.tolerance.direction_rad, 5.0 * kRadiansPerDegree, 1e-4);
    EXPECT_EQ(scene.tolerance.bandwidth_hz, 200.0);
}

TEST(SceneExtras, AFileCanSayAllOfIt) {
    const Scene scene = load(with_scene_extras(
        R"({"planar": true, "other": [1], "tolerance": {"force_N": 0.25, "direction_deg": 9,
            "bandwidth_hz": 30}})"));
    EXPECT_TRUE(scene.planar);
    EXPECT_EQ(scene.tolerance.force_N, 0.25);
    EXPECT_NEAR(scene.tolerance.direction_rad, 9.0 * kRadiansPerDegree, 1e-15);
    EXPECT_EQ(scene.tolerance.bandwidth_hz, 30.0);
}

TEST(SceneExtras, WhatIsLeftOutKeepsItsDefault) {
    const Scene scene = load(with_scene_extras(R"({"tolerance": {"force_N": 1}})"));
    EXPECT_EQ(scene.tolerance.force_N, 1.0);
    EXPECT_EQ(scene.tolerance.bandwidth_hz, ModelTolerance{}.bandwidth_hz);
    EXPECT_EQ(load(with_scene_extras(R"({"tolerance": {}})")).tolerance.force_N, 0.05);
}

TEST(SceneExtras, TheAssetSpeaksWhereTheSceneIsSilent) {
    GltfBuilder builder = with_scene_extras(R"({"tolerance": {"force_N": 1}})");
    builder.asset = R"({"version": "2.0", "extras": {"planar": true,
                        "tolerance": {"force_N": 2, "bandwidth_hz": 50}}})";
    const Scene scene = load(builder);
    EXPECT_TRUE(scene.planar);
    EXPECT_EQ(scene.tolerance.force_N, 1.0);
    EXPECT_EQ(scene.tolerance.bandwidth_hz, 50.0);
}

TEST(SceneExtras, TheEndsOfTheRangesAreAllowedAndNothingBeyond) {
    const auto force = [](const std::string &value) {
        return R"({"tolerance": {"force_N": )" + value + "}}";
    };
    EXPECT_EQ(load(with_scene_extras(force("0.0001"))).tolerance.force_N, 0.0001);
    EXPECT_EQ(load(with_scene_extras(force("10"))).tolerance.force_N, 10.0);
    expect_refused(force("0.00009"),
                   "scene: extras.tolerance.force_N is 9e-05; it must be a number from 0.0001");
    expect_refused(force("10.1"), "scene: extras.tolerance.force_N is 10.1; it must be");
    expect_refused(force("\"low\""), "scene: extras.tolerance.force_N is 'low'; it must be");
    expect_refused(force("null"), "scene: extras.tolerance.force_N is null; it must be");
    expect_refused(R"({"tolerance": {"direction_deg": 0}})",
                   "extras.tolerance.direction_deg is 0; it must be a number from 0.01 to 180");
    expect_refused(R"({"tolerance": {"bandwidth_hz": 0.5}})",
                   "extras.tolerance.bandwidth_hz is 0.5; it must be a number from 1 to 5000");
}

TEST(SceneExtras, RefusesWhatIsNoToleranceAndNoFlag) {
    for (const std::string value : {"0.05", "null", "[0.05]", "true"}) {
        expect_refused(R"({"tolerance": )" + value + "}",
                       "scene: extras.tolerance is " + value + "; it must be an object of force_N");
    }
    expect_refused(R"({"tolerance": {"force": 1}})",
                   "scene: extras.tolerance.force is not known; what may stand there is force_N, "
                   "direction_deg, bandwidth_hz");
    expect_refused(R"({"planar": "yes"})", "scene: extras.planar is 'yes'; it must be true or");
}

} // namespace
} // namespace springdrive::scene
