#include "engine/scene/gltf_nodes.h"

#include "base/degrees.h"
#include "tests/engine/scene/gltf_builder.h"

#include <algorithm>

#include <cmath>

namespace springdrive::scene {
namespace {

constexpr double kRounding_m = 1e-14; // a few double operations on metres

std::vector<Vector3> vertices_under(const std::vector<std::string> &nodes) {
    GltfBuilder builder = one_triangle();
    builder.nodes = nodes;
    return load(builder).surface.vertices_m;
}

TEST(GltfNodes, TranslationRotationAndScaleApplyInThatOrderFromTheLeft) {
    // x ↦ t + R S x, R a quarter turn about z: (x, y) ↦ (−y, x).
    const double half = std::sqrt(0.5);
    const auto vertices = vertices_under(
        {R"({"mesh": 0, "translation": [1, 2, 3], "scale": [2, 4, 8], "rotation": [0, 0, )" +
         std::to_string(half) + ", " + std::to_string(half) + "]}"});
    EXPECT_LT((vertices[0] - Vector3(1, 2, 3)).norm(), kRounding_m);
    EXPECT_LT((vertices[1] - Vector3(1, 3, 3)).norm(), kRounding_m); // (½,0,0) → (1,0,0) → (0,1,0)
    EXPECT_LT((vertices[2] - Vector3(0, 2, 3)).norm(), kRounding_m); // (0,¼,0) → (0,1,0) → (−1,0,0)
}

TEST(GltfNodes, MatrixIsReadColumnByColumn) {
    const auto vertices =
        vertices_under({R"({"mesh": 0, "matrix": [0,2,0,0, 0,0,4,0, 1,0,0,0, 10,20,30,1]})"});
    EXPECT_EQ(vertices[0], Vector3(10, 20, 30));
    EXPECT_EQ(vertices[1], Vector3(10, 21, 30));
    EXPECT_EQ(vertices[2], Vector3(10, 20, 31));
}

TEST(GltfNodes, ParentsApplyAfterTheirChildren) {
    const auto vertices = vertices_under({R"({"children": [1], "scale": [2, 2, 2]})",
                                          R"({"children": [2], "translation": [1, 0, 0]})",
                                          R"({"mesh": 0, "scale": [3, 1, 1]})"});
    EXPECT_EQ(vertices[0], Vector3(2, 0, 0));
    EXPECT_EQ(vertices[1], Vector3(5, 0, 0)); // 2 (3 · ½ + 1)
}

TEST(GltfNodes, OneMeshStandsWhereverANodePlacesIt) {
    GltfBuilder builder = one_triangle();
    builder.nodes = {R"({"mesh": 0, "name": "left"})",
                     R"({"mesh": 0, "name": "right", "translation": [1, 0, 0]})"};
    const Scene scene = load(builder);
    ASSERT_EQ(scene.surface.triangles.size(), 2U);
    ASSERT_EQ(scene.meshes.size(), 2U);
    EXPECT_EQ(scene.meshes[1].name, "right");
    const auto corners = corners_of(scene.surface);
    EXPECT_EQ(corners[1][0] - corners[0][0], Vector3(1, 0, 0));
    EXPECT_EQ(scene.surface.material_of_triangle, (std::vector<std::uint16_t>{0, 1}));
}

TEST(GltfNodes, OnlyTheDefaultSceneIsTaken) {
    GltfBuilder builder = one_triangle();
    builder.nodes = {R"({"mesh": 0})", R"({"mesh": 0, "translation": [7, 0, 0]})"};
    EXPECT_EQ(load(builder).surface.triangles.size(), 2U); // no scene: all roots
    builder.scenes = {R"({"nodes": [0]})", R"({"nodes": [1]})"};
    EXPECT_EQ(load(builder).surface.vertices_m[0], Vector3(0, 0, 0)); // the first
    builder.more = R"("scene": 1, )";
    EXPECT_EQ(load(builder).surface.vertices_m[0], Vector3(7, 0, 0));
    builder.more = R"("scene": 2, )";
    expect_failure(builder, "scene 2 is not in the file, which has 2");
}

TEST(GltfNodes, AllRootsIncludeNoChildren) {
    GltfBuilder builder = one_triangle();
    builder.nodes = {R"({"mesh": 0})", R"({"children": [0]})"};
    EXPECT_EQ(load(builder).surface.triangles.size(), 1U);
}

TEST(GltfNodes, GraphsThatAreNoTreesAreRefused) {
    const auto failing = [](const std::vector<std::string> &nodes, const std::string &roots) {
        GltfBuilder builder = one_triangle();
        builder.nodes = nodes;
        builder.scenes = {R"({"nodes": [)" + roots + "]}"};
        expect_failure(builder, "is reached twice");
    };
    failing({R"({"mesh": 0, "children": [0]})"}, "0");
    failing({R"({"mesh": 0, "children": [1]})", R"({"children": [0]})"}, "0");
    failing({R"({"children": [2]})", R"({"children": [2]})", R"({"mesh": 0})"}, "0, 1");
    failing({R"({"mesh": 0})"}, "0, 0");
    // Fifty doublings would be 2⁵⁰ visits.
    std::vector<std::string> doubling;
    for (int i = 1; i <= 50; ++i) {
        const std::string next = std::to_string(i);
        doubling.push_back(R"({"mesh": 0, "children": [)" + next + ", " + next + "]}");
    }
    doubling.emplace_back(R"({"mesh": 0})");
    failing(doubling, "0");
}

TEST(GltfNodes, AChainOfManyNodesNeedsNoRecursion) {
    constexpr int kDepth = 50'000;
    GltfBuilder builder = one_triangle();
    builder.nodes.clear();
    for (int i = 1; i < kDepth; ++i) {
        builder.nodes.push_back(R"({"children": [)" + std::to_string(i) + "]}");
    }
    builder.nodes.emplace_back(R"({"mesh": 0})");
    EXPECT_EQ(load(builder).surface.vertices_m[1], Vector3(0.5, 0, 0));
}

TEST(GltfNodes, RefusesReferencesToWhatIsNotThere) {
    const auto failing = [](const std::string &node, const std::string &message) {
        GltfBuilder builder = one_triangle();
        builder.nodes = {node};
        builder.scenes = {R"({"nodes": [0]})"};
        expect_failure(builder, message);
    };
    failing(R"({"mesh": 1, "name": "lost"})", "node 'lost': mesh 1 is not in the file");
    failing(R"({"children": [1]})", "node 1 is not in the file");
    failing(R"({"children": [-1]})", "node -1 is not in the file");
}

TEST(GltfNodes, RefusesTransformsThatAreNoneAndNamesTheNode) {
    const auto failing = [](const std::string &members, const std::string &message) {
        expect_failure(one_triangle(R"("name": "X", )" + members), "node 'X': " + message);
    };
    failing(R"("matrix": [1, 0, 0])", "its matrix has 3 numbers; it takes 16");
    failing(R"("scale": [1, 2])", "its scale has 2 numbers");
    failing(R"("matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1])", "its matrix is no affine map");
    failing(R"("scale": [1e308, 1e308, 1e308], "translation": [1e308, 0, 0]}, {"mesh": 0,
               "children": [0], "scale": [1e308, 1, 1])",
            "its transform is not finite");
    failing(R"("scale": [1e308, 1, 1]}, {"children": [0], "scale": [100, 1, 1])",
            "its transform is not finite");
}

TEST(GltfNodes, RefusesVerticesTakenOutOfTheFinite) {
    GltfBuilder builder = one_triangle(R"("name": "X", "scale": [1e308, 1, 1])");
    const float large = 1e10F;
    std::memcpy(&builder.buffer[12], &large, sizeof large);
    expect_failure(builder, "node 'X': its transform takes vertex 1 out of the finite");
}

TEST(GltfNodes, RotationsOffUnitLengthByRoundingAreNormalisedOthersRefused) {
    // Turned by 180° about x, so (0, ¼, 0) comes out at (0, −¼, 0) whatever the length.
    const auto vertices = vertices_under({R"({"mesh": 0, "rotation": [1.0009, 0, 0, 0]})"});
    EXPECT_LT((vertices[2] - Vector3(0, -0.25, 0)).norm(), kRounding_m);
    EXPECT_NO_THROW(load(one_triangle(R"("rotation": [0, 0, 0, 0.9991])")));
    const auto failing = [](const std::string &rotation, const std::string &length) {
        expect_failure(one_triangle(R"("name": "X", "rotation": )" + rotation),
                       "node 'X': its rotation is a quaternion of length " + length +
                           "; it must have length 1");
    };
    failing("[0, 0, 0, 1.0011]", "1.0011");
    failing("[0, 0, 0, 0.9989]", "0.9989");
    failing("[0, 0, 3, 4]", "5");
    failing("[0, 0, 0, 0]", "0");
}

TEST(GltfNodes, NamesFallBackToTheMeshAndThenToTheNumber) {
    GltfBuilder builder = one_triangle();
    builder.meshes.emplace_back(
        R"({"name": "lathe\nwork", "primitives": [{"attributes": {"POSITION": 0}}]})");
    builder.nodes = {R"({"mesh": 0})", R"({"mesh": 1})"};
    const Scene scene = load(builder);
    EXPECT_EQ(scene.meshes[0].name, "node 0");
    EXPECT_EQ(scene.meshes[1].name, "lathe work");
}

gltf::TouchExtras read(const std::string &json, const gltf::TouchExtras &parent = {}) {
    WarningList warnings;
    return gltf::read_touch(json, parent, "node 'pad'", warnings);
}

/// With `value` under `key` a file loads as without, and a warning names node, key, value and what
/// it would have to be: other programs use the same names.
void expect_left_out(const std::string &key, const std::string &value, const std::string &shown,
                     const std::string &wanted) {
    const Scene scene =
        load(one_triangle(R"("name": "pad", "extras": {")" + key + "\": " + value + "}"));
    EXPECT_TRUE(has_warning(scene, "node 'pad': extras." + key + " is " + shown +
                                       ": left out as another program's; it would have to be " +
                                       wanted))
        << key << ' ' << value;
    ASSERT_EQ(scene.surface.materials.size(), 1U);
    contact::SurfaceMaterial plain;
    plain.name = "pad";
    EXPECT_EQ(scene.surface.materials[0].eta, plain.eta);
    EXPECT_EQ(scene.surface.materials[0].static_friction, plain.static_friction);
    EXPECT_EQ(scene.surface.materials[0].sides, plain.sides);
    EXPECT_TRUE(scene.shapes.empty());
    EXPECT_TRUE(scene.flat_surface.triangles.empty());
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
    const contact::SurfaceMaterial &inheriting = scene.surface.materials[0];
    EXPECT_EQ(inheriting.eta, 0.5);
    EXPECT_EQ(inheriting.static_friction, 0.75);
    EXPECT_EQ(inheriting.dynamic_friction, 0.25);
    EXPECT_EQ(inheriting.sides, contact::TouchSides::one);
    const contact::SurfaceMaterial &overriding = scene.surface.materials[1];
    EXPECT_EQ(overriding.eta, 0.0);
    EXPECT_EQ(overriding.static_friction, 0.0);
    EXPECT_EQ(overriding.sides, contact::TouchSides::two);

    const gltf::TouchExtras parent = read(R"({"smooth": true, "shape": "box"})");
    EXPECT_EQ(parent.shape, ShapeKind::box);
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

TEST(TouchExtras, LeavesNumbersOutOfRangeToOtherPrograms) {
    const std::string eta = "a number from 0 (rigid) to 1 (free space)";
    expect_left_out("eta", "1.0000001", "1.0000001", eta);
    expect_left_out("eta", "-1e-9", "-1e-09", eta);
    expect_left_out("eta", "4294967296", "4294967296", eta); // 0, if cut to 32 bits
    for (const std::string key : {"static_friction", "dynamic_friction"}) {
        expect_left_out(key, "10.5", "10.5", "a number from 0 to 10");
        expect_left_out(key, "-0.5", "-0.5", "a number from 0 to 10");
    }
}

TEST(TouchExtras, LeavesWhatIsNoNumberNoWordNoFlagToOtherPrograms) {
    for (const std::string key : {"eta", "static_friction", "dynamic_friction"}) {
        expect_left_out(key, "null", "null", "a number from 0");
        expect_left_out(key, "\"high\"", "'high'", "a number from 0");
        expect_left_out(key, "true", "true", "a number from 0");
        expect_left_out(key, "[0.5]", "[0.5]", "a number from 0");
        expect_left_out(key, R"({"a": 1})", R"({"a":1})", "a number from 0");
    }
    for (const std::string value : {"null", "6", "true", "[\"one\"]"}) {
        expect_left_out("sides", value, value, "'one' or 'two'");
        expect_left_out("shape", value, value, "'plate', 'sphere', 'box', 'cylinder' or 'capsule'");
    }
    expect_left_out("sides", "\"both\"", "'both'", "'one' or 'two'");
    expect_left_out("sides", "\"\"", "''", "'one' or 'two'");
    expect_left_out("shape", "\"Box\"", "'Box'", "'plate', 'sphere'");
    for (const std::string value : {"null", "1", "\"yes\""}) {
        expect_left_out("smooth", value, value[0] == '"' ? "'yes'" : value, "true or false");
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

TEST(SceneExtras, LeavesWhatIsNoToleranceAndNoFlagToOtherPrograms) {
    const auto expect_left_out = [](const std::string &extras, const std::string &warning) {
        const Scene scene = load(with_scene_extras(extras));
        EXPECT_TRUE(has_warning(scene, warning)) << warning;
        EXPECT_EQ(scene.tolerance.force_N, ModelTolerance{}.force_N);
        EXPECT_FALSE(scene.planar);
    };
    const std::string other = ": left out as another program's; it would have to be ";
    for (const std::string value : {"0.05", "null", "[0.05]", "true", R"({"chord":1})"}) {
        expect_left_out(R"({"tolerance": )" + value + "}",
                        "scene: extras.tolerance is " + value + other +
                            "an object of force_N, direction_deg and bandwidth_hz");
    }
    expect_left_out(R"({"planar": "yes"})",
                    "scene: extras.planar is 'yes'" + other + "true or false");
    expect_refused(R"({"tolerance": {"force_N": 1, "force": 1}})",
                   "scene: extras.tolerance.force is not known; what may stand there is force_N, "
                   "direction_deg, bandwidth_hz");
}

TEST(SceneExtras, ALessonIsReadWhole) {
    const Scene scene = load(with_scene_extras(
        R"({"units": "m", "lesson": {"title": "A wall", "feel": "Press\non it.",
            "point": [0.01, 0.02, -0.03], "normal": [0, 0, -2]}})"));
    EXPECT_EQ(scene.lesson.title, "A wall");
    EXPECT_EQ(scene.lesson.feel, "Press on it."); // on one line
    ASSERT_TRUE(scene.lesson.spot);
    EXPECT_EQ(scene.lesson.spot->point_m, Vector3(0.01, 0.02, -0.03));
    EXPECT_EQ(scene.lesson.spot->normal, Vector3(0.0, 0.0, -1.0));
    EXPECT_TRUE(load(one_triangle()).lesson.is_empty());
    EXPECT_TRUE(load(with_scene_extras(R"({"lesson": {}})")).lesson.is_empty());
}

TEST(SceneExtras, ASpotIsFittedWithItsScene) {
    GltfBuilder builder =
        with_scene_extras(R"({"lesson": {"point": [0, 0, 0], "normal": [0, 1, 0]}})");
    builder.asset = R"({"version": "2.0"})"; // in no particular unit
    const Scene scene = load(builder);
    ASSERT_TRUE(scene.lesson.spot);
    // The triangle has a corner at the file's origin.
    const auto is_corner = [&](const Vector3 &p) {
        return (p - scene.lesson.spot->point_m).isZero(1e-9);
    };
    EXPECT_TRUE(std::ranges::any_of(scene.surface.vertices_m, is_corner));
    EXPECT_FALSE(scene.lesson.spot->point_m.isZero(1e-3)); // it was moved
}

TEST(SceneExtras, ALessonOfAnotherKindIsLeftOutAndAWrongOneRefused) {
    for (const std::string value : {"\"touch\"", "null", "[1]", R"({"chapter":1})"}) {
        const Scene scene = load(with_scene_extras(R"({"lesson": )" + value + "}"));
        EXPECT_TRUE(scene.lesson.is_empty());
        EXPECT_TRUE(has_warning(scene, "left out as another program's; it would have to be an "
                                       "object of title, feel, point and normal"))
            << value;
    }
    const auto lesson = [](const std::string &members) {
        return R"({"lesson": {)" + members + "}}";
    };
    expect_refused(lesson(R"("title": 5)"),
                   "scene: extras.lesson.title is 5; it must be a text of 1 to 40 bytes");
    expect_refused(lesson(R"("title": " ")"), "extras.lesson.title is ''; it must be a text");
    EXPECT_NO_THROW(load(with_scene_extras(lesson(R"("title": ")" + std::string(40, 'a') + '"'))));
    expect_refused(lesson(R"("title": ")" + std::string(41, 'a') + '"'),
                   "it must be a text of 1 to 40 bytes");
    expect_refused(lesson(R"("feel": ")" + std::string(201, 'a') + '"'),
                   "it must be a text of 1 to 200 bytes");
    expect_refused(lesson(R"("point": [0, 0], "normal": [0, 1, 0])"),
                   "scene: extras.lesson.point is [0,0]; it must be a list of three numbers");
    expect_refused(lesson(R"("point": [0, 0, "0"], "normal": [0, 1, 0])"),
                   "it must be a list of three numbers from -1e+06 to 1e+06");
    expect_refused(lesson(R"("point": [0, 0, 2e6], "normal": [0, 1, 0])"),
                   "it must be a list of three numbers from");
    expect_refused(lesson(R"("point": [0, 0, 0])"),
                   "extras.lesson.point is [0,0,0]; it must be given with its normal");
    expect_refused(lesson(R"("normal": [0, 1, 0])"),
                   "extras.lesson.normal is [0,1,0]; it must be given with its point");
    expect_refused(lesson(R"("point": [0, 0, 0], "normal": [0, 0, 0])"),
                   "extras.lesson.normal is [0,0,0]; it must be a direction, not zero");
    expect_refused(lesson(R"("title": "A wall", "sentence": "Press.")"),
                   "scene: extras.lesson.sentence is not known; what may stand there is title, "
                   "feel, point, normal");
}

TEST(TouchExtras, ACaptionStandsOnItsNodeAloneAndAnotherProgramsIsLeftOut) {
    const Scene scene = load(one_triangle(R"("extras": {"caption": "soft"})"));
    ASSERT_EQ(scene.captions.size(), 1U);
    EXPECT_EQ(scene.captions.front().text, "soft");
    EXPECT_NEAR(scene.captions.front().at_m.y(), scene.upper_m.y(), 1e-12);
    const Scene other = load(one_triangle(R"("extras": {"caption": 7})"));
    EXPECT_TRUE(other.captions.empty());
    EXPECT_TRUE(has_warning(other, "extras.caption is 7: left out as another program's; it would "
                                   "have to be a text of 1 to 40 bytes"));
    WarningList warnings;
    gltf::TouchExtras parent;
    parent.caption = "all of it";
    EXPECT_EQ(gltf::read_touch("{}", parent, "node 'child'", warnings).caption, "");
}

TEST(GltfNodes, AMillionChildrenOfOneNodeAreRefusedByName) {
    GltfBuilder builder = one_triangle();
    std::string children = "1";
    for (int i = 0; i < 1'000'000; ++i) {
        children += ",1";
    }
    builder.nodes = {R"({"children": [)" + children + "]}", R"({"mesh": 0, "name": "shared"})"};
    builder.scenes = {R"({"nodes": [0]})"};
    EXPECT_EQ(line_of_failure(builder.gltf()),
              "node 'shared' is reached twice; glTF nodes must form a tree, without cycles or "
              "second parents");
}

} // namespace
} // namespace springdrive::scene
