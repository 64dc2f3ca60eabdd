#include "engine/scene/gltf_json.h"

#include "base/input_error.h"

#include <gtest/gtest.h>

namespace springdrive::scene::gltf {
namespace {

TEST(GltfJson, DepthCountsBracketsOutsideStringsOnly) {
    EXPECT_EQ(json_nesting_depth("{}"), 1U);
    EXPECT_EQ(json_nesting_depth(R"({"a": [{"b": []}, {}], "c": []})"), 4U);
    EXPECT_EQ(json_nesting_depth(R"({"[[[[\"[[[[": "{{{{"})"), 1U);
    EXPECT_EQ(json_nesting_depth(std::string(5000, '[')), 5000U);
    EXPECT_EQ(json_nesting_depth("]]]]{\"\\"), 1U);
}

TEST(GltfJson, ByteOffsetsMustBeWholeNumbersFromZero) {
    const auto refused = [](const std::string &text, const std::string &message) {
        try {
            check_byte_offsets(text);
            ADD_FAILURE() << text;
        } catch (const InputError &error) {
            EXPECT_EQ(error.what(), message + "; it must be a whole number from 0");
        }
    };
    refused(R"({"bufferViews": [{}, {"byteOffset": -4}]})", "buffer view 1: its byteOffset is -4");
    refused(R"({"bufferViews": [{"byteStride": -12}]})", "buffer view 0: its byteStride is -12");
    refused(R"({"accessors": [{"byteOffset": 4.5}]})", "accessor 0: its byteOffset is 4.5");
    refused(R"({"accessors": [{}, {}, {"byteOffset": "4"}]})",
            R"(accessor 2: its byteOffset is "4")");
    refused(R"({"accessors": [{"byteOffset": null}]})", "accessor 0: its byteOffset is null");
    refused(R"({"accessors": [{"sparse": {"values": {"byteOffset": -1}}}]})",
            "accessor 0: sparse values: its byteOffset is -1");
    for (const std::string text :
         {"", "[]", R"({"bufferViews": 3})", R"({"bufferViews": [7], "accessors": [[], null]})",
          R"({"accessors": [{"sparse": 1}, {"sparse": {"indices": []}}, {"byteOffset": 0}]})",
          R"({"bufferViews": [{"byteOffset": 18446744073709551615, "byteStride": 12}]})",
          R"({"extras": {"byteOffset": -4}})"}) {
        EXPECT_NO_THROW(check_byte_offsets(text)) << text;
    }
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
} // namespace springdrive::scene::gltf
