#include "engine/scene/gltf_json.h"

#include <gtest/gtest.h>

namespace springdrive::gltf {
namespace {

TEST(GltfJson, DepthCountsBracketsOutsideStringsOnly) {
    EXPECT_EQ(json_nesting_depth("{}"), 1U);
    EXPECT_EQ(json_nesting_depth(R"({"a": [{"b": []}, {}], "c": []})"), 4U);
    EXPECT_EQ(json_nesting_depth(R"({"[[[[\"[[[[": "{{{{"})"), 1U);
    EXPECT_EQ(json_nesting_depth(std::string(5000, '[')), 5000U);
    EXPECT_EQ(json_nesting_depth("]]]]{\"\\"), 1U);
}

TEST(GltfJson, OnlyDracoPrimitivesLoseTheirIndices) {
    const std::string text = without_what_tinygltf_refuses(
        R"({"meshes": [{"primitives": [{"indices": 7, "mode": 4},
            {"indices": 8, "extensions": {"KHR_draco_mesh_compression": {}}}]}]})");
    EXPECT_NE(text.find("\"indices\":7"), std::string::npos) << text;
    EXPECT_EQ(text.find("\"indices\":8"), std::string::npos) << text;
}

TEST(GltfJson, SkinsGo) {
    EXPECT_EQ(without_what_tinygltf_refuses(R"({"skins":[{"joints":[0]}],"nodes":[]})"),
              R"({"nodes":[]})");
}

TEST(GltfJson, WhatIsNoGltfComesBackAsItIs) {
    for (const std::string text : {"{\"meshes\": [", "[1, 2]", "{\"meshes\":3}", ""}) {
        EXPECT_EQ(without_what_tinygltf_refuses(text), text);
    }
    EXPECT_EQ(
        without_what_tinygltf_refuses(R"({"meshes":[3,{"primitives":[4,{"extensions":5}]}]})"),
        R"({"meshes":[3,{"primitives":[4,{"extensions":5}]}]})");
}

} // namespace
} // namespace springdrive::gltf
