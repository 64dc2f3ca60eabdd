#include "engine/scene/touch_extras.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

gltf::TouchExtras read(const std::string &json, const gltf::TouchExtras &parent = {}) {
    return gltf::read_touch(json, parent, "node 'pad'");
}

/// With `value` under `key` a file is refused, and the line names node, key, value and remedy.
void expect_refused(const std::string &key, const std::string &value, const std::string &shown,
                    const std::string &remedy) {
    expect_failure(one_triangle(R"("name": "pad", "extras": {")" + key + "\": " + value + "}"),
                   "node 'pad': extras." + key + " is " + shown + "; it must be " + remedy);
}

TEST(TouchExtras, NodesWithoutAnyFeelRigidAndSmooth) {
    for (const std::string json : {"", "{}", "null", "[1]", "7", R"("text")", R"({"other": 1})"}) {
        const gltf::TouchExtras touch = read(json);
        EXPECT_EQ(touch.material.eta, 0.0);
        EXPECT_EQ(touch.material.static_friction, 0.0);
        EXPECT_EQ(touch.material.dynamic_friction, 0.0);
        EXPECT_EQ(touch.material.sides, contact::TouchSides::automatic);
        EXPECT_FALSE(touch.smooth);
        EXPECT_FALSE(touch.shape);
    }
}

TEST(TouchExtras, AFileCanSayAllOfIt) {
    const Scene scene = load(one_triangle(R"("name": "pad", "extras": {"eta": 0.25,
        "static_friction": 0.75, "dynamic_friction": 0.5, "sides": "two"})"));
    ASSERT_EQ(scene.surface.materials.size(), 1U);
    const contact::SurfaceMaterial &material = scene.surface.materials[0];
    EXPECT_EQ(material.name, "pad");
    EXPECT_EQ(material.eta, 0.25);
    EXPECT_EQ(material.static_friction, 0.75);
    EXPECT_EQ(material.dynamic_friction, 0.5);
    EXPECT_EQ(material.sides, contact::TouchSides::two);
}

TEST(TouchExtras, OneCoefficientOfFrictionStandsForBoth) {
    for (const std::string key : {"static_friction", "dynamic_friction"}) {
        const gltf::TouchExtras touch = read("{\"" + key + "\": 0.5}");
        EXPECT_EQ(touch.material.static_friction, 0.5) << key;
        EXPECT_EQ(touch.material.dynamic_friction, 0.5) << key;
    }
}

TEST(TouchExtras, ANodeThatGivesOneCoefficientForgetsItsParentsOther) {
    const gltf::TouchExtras parent = read(R"({"static_friction": 0.9, "dynamic_friction": 0.1})");
    EXPECT_EQ(read(R"({"static_friction": 0.05})", parent).material.dynamic_friction, 0.05);
    EXPECT_EQ(read(R"({"dynamic_friction": 2})", parent).material.static_friction, 2.0);
}

TEST(TouchExtras, AllButTheShapePassesToTheChildren) {
    GltfBuilder builder = one_triangle();
    builder.nodes = {R"({"children": [1, 2], "extras": {"eta": 0.5, "static_friction": 0.75,
                         "dynamic_friction": 0.25, "sides": "one"}})",
                     R"({"mesh": 0, "name": "heir"})",
                     R"({"mesh": 0, "name": "rebel", "extras": {"eta": 0, "dynamic_friction": 0,
                         "sides": "two"}})"};
    const Scene scene = load(builder);
    ASSERT_EQ(scene.surface.materials.size(), 2U);
    const contact::SurfaceMaterial &heir = scene.surface.materials[0];
    EXPECT_EQ(heir.eta, 0.5);
    EXPECT_EQ(heir.static_friction, 0.75);
    EXPECT_EQ(heir.dynamic_friction, 0.25);
    EXPECT_EQ(heir.sides, contact::TouchSides::one);
    const contact::SurfaceMaterial &rebel = scene.surface.materials[1];
    EXPECT_EQ(rebel.eta, 0.0);
    EXPECT_EQ(rebel.static_friction, 0.0);
    EXPECT_EQ(rebel.sides, contact::TouchSides::two);

    const gltf::TouchExtras parent = read(R"({"smooth": true, "shape": "box"})");
    EXPECT_EQ(parent.shape, gltf::ShapeKind::box);
    EXPECT_TRUE(read("", parent).smooth);
    EXPECT_FALSE(read(R"({"smooth": false})", parent).smooth);
    EXPECT_FALSE(read("", parent).shape);
}

TEST(TouchExtras, TheEndsOfTheRangesAreAllowed) {
    EXPECT_EQ(read(R"({"eta": 1})").material.eta, 1.0);
    EXPECT_EQ(read(R"({"static_friction": 10})").material.dynamic_friction, 10.0);
    EXPECT_EQ(read(R"({"static_friction": 0})").material.static_friction, 0.0);
    EXPECT_EQ(
        read(R"({"static_friction": 0.5, "dynamic_friction": 0.5})").material.dynamic_friction,
        0.5);
}

TEST(TouchExtras, RefusesNumbersOutOfRange) {
    const std::string eta = "a number from 0 (rigid) to 1 (free space)";
    expect_refused("eta", "1.0000001", "1.0000001", eta);
    expect_refused("eta", "-1e-9", "-1e-09", eta);
    expect_refused("eta", "4294967296", "4294967296", eta); // 0, if cut to 32 bits
    for (const std::string key : {"static_friction", "dynamic_friction"}) {
        expect_refused(key, "10.5", "10.5", "a number from 0 to 10");
        expect_refused(key, "-0.5", "-0.5", "a number from 0 to 10");
    }
}

TEST(TouchExtras, RefusesWhatIsNoNumberNoWordNoFlag) {
    for (const std::string key : {"eta", "static_friction", "dynamic_friction"}) {
        expect_refused(key, "null", "null", "a number from 0");
        expect_refused(key, "\"high\"", "'high'", "a number from 0");
        expect_refused(key, "true", "true", "a number from 0");
        expect_refused(key, "[0.5]", "[0.5]", "a number from 0");
        expect_refused(key, R"({"a": 1})", R"({"a":1})", "a number from 0");
    }
    for (const std::string value : {"null", "2", "true", "[\"one\"]"}) {
        expect_refused("sides", value, value, "'one' or 'two', or left out");
        expect_refused("shape", value, value, "'plate', 'sphere', 'box', 'cylinder' or 'capsule'");
    }
    expect_refused("sides", "\"both\"", "'both'", "'one' or 'two'");
    expect_refused("sides", "\"\"", "''", "'one' or 'two'");
    expect_refused("shape", "\"Box\"", "'Box'", "'plate', 'sphere'");
    for (const std::string value : {"null", "1", "\"yes\""}) {
        expect_refused("smooth", value, value[0] == '"' ? "'yes'" : value, "true or false");
    }
}

TEST(TouchExtras, RefusesDynamicFrictionAboveStatic) {
    expect_failure(one_triangle(R"("name": "pad", "extras": {"static_friction": 0.25,
                                "dynamic_friction": 0.5})"),
                   "node 'pad': extras.dynamic_friction is 0.5; it must be a number from 0 to 10, "
                   "not above its static_friction");
}

TEST(TouchExtras, RefusesSidesThatAShapeDoesNotHave) {
    EXPECT_NO_THROW(read(R"({"shape": "plate", "sides": "two"})"));
    EXPECT_NO_THROW(read(R"({"shape": "sphere", "sides": "one"})"));
    expect_failure(one_triangle(R"("name": "pad", "extras": {"shape": "plate", "sides": "one"})"),
                   "node 'pad': a plate is touched from both sides; set extras.sides to 'two'");
    expect_failure(one_triangle(R"("name": "pad", "extras": {"shape": "box", "sides": "two"})"),
                   "node 'pad': a box is touched from outside only; set extras.sides to 'one'");
}

} // namespace
} // namespace springdrive::scene
