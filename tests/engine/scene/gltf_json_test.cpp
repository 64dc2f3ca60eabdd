#include "engine/scene/gltf_json.h"

#include "base/input_error.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>

namespace springdrive::scene {
namespace {

using gltf::json_nesting_depth;

/// The message with which the members of `text` are refused; empty if they are not.
std::string refusal_of(const std::string &members) {
    const std::string text = R"({"asset": {"version": "2.0"}, )" + members + "}";
    try {
        nlohmann::json document = gltf::parse_json(text);
        gltf::check_members(document);
        return "";
    } catch (const InputError &error) {
        return error.what();
    }
}

TEST(GltfJson, DepthCountsBracketsOutsideStringsOnly) {
    EXPECT_EQ(json_nesting_depth("{}"), 1U);
    EXPECT_EQ(json_nesting_depth(R"({"a": [{"b": []}, {}], "c": []})"), 4U);
    EXPECT_EQ(json_nesting_depth(R"({"[[[[\"[[[[": "{{{{"})"), 1U);
    EXPECT_EQ(json_nesting_depth(std::string(5000, '[')), 5000U);
    EXPECT_EQ(json_nesting_depth("]]]]{\"\\"), 1U);
}

TEST(GltfJson, ByteOffsetsMustBeWholeNumbersFromZero) {
    const auto refused = [](const std::string &members, const std::string &message) {
        EXPECT_EQ(refusal_of(members), message + "; it must be a whole number from 0");
    };
    const std::string view = R"("buffer": 0, "byteLength": 4)";
    const std::string accessor = R"("componentType": 5126, "count": 1, "type": "VEC3")";
    refused(R"("bufferViews": [{)" + view + "}, {" + view + R"(, "byteOffset": -4}])",
            "buffer view 1: its byteOffset is -4");
    refused(R"("bufferViews": [{)" + view + R"(, "byteStride": -12}])",
            "buffer view 0: its byteStride is -12");
    refused(R"("accessors": [{)" + accessor + R"(, "byteOffset": 4.5}])",
            "accessor 0: its byteOffset is 4.5");
    refused(R"("accessors": [{)" + accessor + R"(, "byteOffset": "4"}])",
            R"(accessor 0: its byteOffset is "4")");
    refused(R"("accessors": [{)" + accessor + R"(, "byteOffset": null}])",
            "accessor 0: its byteOffset is null");
    EXPECT_EQ(
        refusal_of(R"("accessors": [{)" + accessor +
                   R"(, "sparse": {"count": 1, "indices": {"bufferView": 0, "componentType": 5121},
                    "values": {"bufferView": 0, "byteOffset": -1}}}])"),
        "accessor 0: sparse: values: its byteOffset is -1; it must be a whole number from 0 to "
        "2147483647");
}

TEST(GltfJson, MembersOfOtherProgramsAreNotChecked) {
    for (const std::string members :
         {R"("extras": {"byteOffset": -4})", R"("nodes": [{"name": 7, "weights": "many"}])",
          R"("meshes": [], "extensions": [3])"}) {
        EXPECT_EQ(refusal_of(members), "") << members;
    }
}

TEST(GltfJson, WhatIsNoObjectIsRefused) {
    for (const std::string text : {"[1, 2]", "7"}) {
        EXPECT_THROW((void)gltf::parse_json(text), InputError) << text;
    }
}

TEST(GltfJson, NumbersBeyondDoublesAreNamedByTheirPlace) {
    EXPECT_EQ(refusal_of(R"("a": {"b": [1, [2], {"c": -1e400}]})"),
              "a.b[2].c is -1e400; it must be a number that is finite in double precision");
}

} // namespace
} // namespace springdrive::scene
