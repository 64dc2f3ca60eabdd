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

TEST(GltfNodes, OnlyTheDefaultSceneIsTaken) {
    GltfBuilder builder = one_triangle();
    builder.nodes = {R"({"mesh": 0})", R"({"mesh": 0, "translation": [7, 0, 0]})"};
    EXPECT_EQ(load(builder).surface.triangles.size(), 2U); // no scene: all roots
    builder.scenes = {R"({"nodes": [0]})", R"({"nodes": [1]})"};
    EXPECT_EQ(load(builder).surface.vertices_m[0], Vector3(0, 0, 0)); // the first with triangles
    builder.more = R"("scene": 1, )";
    EXPECT_EQ(load(builder).surface.vertices_m[0], Vector3(7, 0, 0));
    builder.more = R"("scene": 2, )";
    expect_failure(builder, "scene 2 is not in the file, which has 2");
}

Scene load_scene_named(const GltfBuilder &builder, const std::string &name) {
    const TemporaryFolder folder;
    return load_gltf(folder.write("scene.gltf", builder.gltf()), small_workspace(), nullptr, name);
}

/// Four scenes: an empty one, one of points, and two of a triangle, at x = 2 and 3.
GltfBuilder four_scenes() {
    GltfBuilder builder = one_triangle();
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "mode": 0)");
    builder.nodes = {R"({"children": [1]})", R"({"mesh": 1})",
                     R"({"mesh": 0, "translation": [2, 0, 0]})", R"({"children": [4]})",
                     R"({"mesh": 0, "translation": [3, 0, 0]})"};
    builder.scenes = {R"({"name": "nothing"})", R"({"name": "3", "nodes": [0]})",
                      R"({"nodes": [1, 2]})",
                      R"({"name": "attic", "nodes": [0, 3], "extras": {"planar": true}})"};
    return builder;
}

TEST(GltfNodes, WithoutADefaultTheFirstSceneWithTrianglesIsTaken) {
    GltfBuilder builder = four_scenes();
    const Scene scene = load(builder);
    EXPECT_EQ(scene.surface.vertices_m[0], Vector3(2, 0, 0));
    EXPECT_FALSE(scene.planar);
    EXPECT_TRUE(has_warning(scene, "scene 2 is loaded, of 0 'nothing', 1 '3', 2, 3 'attic'"));
    builder.scenes.erase(builder.scenes.begin() + 2);
    EXPECT_EQ(load(builder).surface.vertices_m[0], Vector3(3, 0, 0));
    EXPECT_TRUE(load(builder).planar);
    builder.more = R"("scene": 0, )"; // what the file says is obeyed
    expect_failure(builder, "has no triangle to touch");
    builder.more.clear();
    builder.scenes.pop_back();
    expect_failure(builder, "has no triangle to touch");
    EXPECT_FALSE(has_warning(load(one_triangle()), "--gltf-scene"));
}

TEST(GltfNodes, ASceneIsNamedByNameOrElseByNumber) {
    GltfBuilder builder = four_scenes();
    const auto x_of = [&builder](const std::string &name) {
        return load_scene_named(builder, name).surface.vertices_m[0].x();
    };
    EXPECT_EQ(x_of("attic"), 3.0);
    EXPECT_EQ(x_of("2"), 2.0);
    builder.more = R"("scene": 2, )";
    EXPECT_EQ(x_of("attic"), 3.0);
    const auto failure = [&builder](const std::string &name) {
        return error_text_of([&] { (void)load_scene_named(builder, name); });
    };
    EXPECT_NE(failure("3").find("has no triangle"), std::string::npos); // a name before a number
    for (const char *name : {"Attic", "4", "-1", "02", "1e0", " 2"}) {
        const std::string message = failure(name);
        EXPECT_NE(message.find("has no scene '"), std::string::npos) << message;
        EXPECT_NE(message.find("0 'nothing', 1 '3', 2, 3 'attic'"), std::string::npos) << message;
    }
    builder.scenes[1] = builder.scenes[3];
    EXPECT_NE(failure("attic").find("has 2 scene 'attic'"), std::string::npos);
    builder.scenes.assign(5000, R"({"name": "many\nlines", "nodes": [2]})");
    EXPECT_NE(failure("attic").find("and 4990 more"), std::string::npos);
    builder.scenes.clear();
    builder.more.clear();
    EXPECT_NE(failure("attic").find("leave --gltf-scene out"), std::string::npos);
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

TEST(TouchExtras, OneCoefficientOfFrictionStandsForBothAndForgetsTheParents) {
    const gltf::TouchExtras parent = read(R"({"static_friction": 0.9, "dynamic_friction": 0.1})");
    struct Case {
        const char *json;
        double static_friction;
        double dynamic_friction;
    };
    for (const Case &one :
         std::vector<Case>{{R"({"static_friction": 0.05})", 0.05, 0.05},
                           {R"({"dynamic_friction": 2})", 2.0, 2.0},
                           {R"({"static_friction": 10})", 10.0, 10.0}, // the ends of the range
                           {R"({"static_friction": 0})", 0.0, 0.0},
                           {R"({"static_friction": 0.5, "dynamic_friction": 0.5})", 0.5, 0.5},
                           {R"({"eta": 1})", 0.9, 0.1}}) {
        const contact::SurfaceMaterial material = read(one.json, parent).material;
        EXPECT_EQ(material.static_friction, one.static_friction) << one.json;
        EXPECT_EQ(material.dynamic_friction, one.dynamic_friction) << one.json;
    }
    EXPECT_EQ(read(R"({"eta": 1})").material.eta, 1.0);
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
    EXPECT_EQ(inheriting.name, "heir");
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

/// With `value` under `key` a file loads as without, and a warning names node, key, value and what
/// it would have to be: other programs use the same names.
TEST(TouchExtras, LeavesWhatCannotBeToOtherPrograms) {
    struct Case {
        std::string key;
        std::vector<std::pair<std::string, std::string>> values; ///< and as they are shown
        std::string requested;
    };
    const std::vector<std::pair<std::string, std::string>> no_numbers{
        {"null", "null"},
        {R"("high")", "'high'"},
        {"true", "true"},
        {"[0.5]", "[0.5]"},
        {R"({"a": 1})", R"({"a":1})"}};
    const std::vector<std::pair<std::string, std::string>> no_words{
        {"null", "null"},       {"6", "6"},
        {"true", "true"},       {R"(["one"])", R"(["one"])"},
        {R"("")", "''"},        {R"("Box")", "'Box'"},
        {R"("both")", "'both'"}};
    const std::string eta = "a number from 0 (rigid) to 1 (free space)";
    for (const Case &one : std::vector<Case>{
             {"eta", no_numbers, eta},
             {"eta", {{"1.0000001", "1.0000001"}, {"-1e-9", "-1e-09"}}, eta},
             {"eta", {{"4294967296", "4294967296"}}, eta}, // 0, if cut to 32 bits
             {"static_friction", no_numbers, "a number from 0 to 10"},
             {"static_friction", {{"10.5", "10.5"}, {"-0.5", "-0.5"}}, "a number from 0 to 10"},
             {"dynamic_friction", no_numbers, "a number from 0 to 10"},
             {"dynamic_friction", {{"10.5", "10.5"}, {"-0.5", "-0.5"}}, "a number from 0 to 10"},
             {"sides", no_words, "'one' or 'two'"},
             {"shape", no_words, "'plate', 'sphere', 'box', 'cylinder' or 'capsule'"},
             {"smooth", {{"null", "null"}, {"1", "1"}, {R"("yes")", "'yes'"}}, "true or false"},
             {"caption", {{"7", "7"}}, "a text of 1 to 40 bytes"}}) {
        for (const auto &[value, shown] : one.values) {
            SCOPED_TRACE(one.key + " " + value);
            const Scene scene = load(
                one_triangle(R"("name": "pad", "extras": {")" + one.key + "\": " + value + "}"));
            EXPECT_TRUE(has_warning(scene, "node 'pad': extras." + one.key + " is " + shown +
                                               ": left out as another program's; it would have "
                                               "to be " +
                                               one.requested));
            ASSERT_EQ(scene.surface.materials.size(), 1U);
            EXPECT_EQ(scene.surface.materials[0].eta, 0.0);
            EXPECT_EQ(scene.surface.materials[0].static_friction, 0.0);
            EXPECT_EQ(scene.surface.materials[0].sides, contact::TouchSides::automatic);
            EXPECT_TRUE(scene.shapes.empty() && scene.captions.empty());
            EXPECT_TRUE(scene.flat_surface.triangles.empty());
        }
    }
}

TEST(TouchExtras, RefusesWhatContradictsItself) {
    EXPECT_NO_THROW(read(R"({"shape": "plate", "sides": "two"})"));
    EXPECT_NO_THROW(read(R"({"shape": "sphere", "sides": "one"})"));
    for (const auto &[extras, message] : std::vector<std::pair<std::string, std::string>>{
             {R"("static_friction": 0.25, "dynamic_friction": 0.5)",
              "extras.dynamic_friction is 0.5; it must be a number from 0 to 10, not above"},
             {R"("shape": "plate", "sides": "one")", "a plate is touched from both sides"},
             {R"("shape": "box", "sides": "two")", "a box is touched from outside only"}}) {
        expect_failure(one_triangle(R"("name": "pad", "extras": {)" + extras + "}"),
                       "node 'pad': " + message);
    }
}

TEST(TouchExtras, ACaptionStandsOnItsNodeAlone) {
    const Scene scene = load(one_triangle(R"("extras": {"caption": "soft"})"));
    ASSERT_EQ(scene.captions.size(), 1U);
    EXPECT_EQ(scene.captions.front().text, "soft");
    EXPECT_NEAR(scene.captions.front().at_m.y(), scene.upper_m.y(), 1e-12);
    gltf::TouchExtras parent;
    parent.caption = "all of it";
    EXPECT_EQ(read("{}", parent).caption, "");
}

GltfBuilder with_scene_extras(const std::string &extras) {
    GltfBuilder builder = one_triangle();
    builder.scenes = {R"({"nodes": [0], "extras": )" + extras + "}"};
    return builder;
}

TEST(SceneExtras, AFileCanSayAllOfIt) {
    const Scene silent = load(one_triangle());
    EXPECT_FALSE(silent.planar);
    EXPECT_EQ(silent.tolerance.force_N, 0.05);
    EXPECT_NEAR(silent.tolerance.direction_rad, 5.0 * kRadiansPerDegree, 1e-4);
    EXPECT_EQ(silent.tolerance.bandwidth_hz, 200.0);
    EXPECT_EQ(load(with_scene_extras(R"({"tolerance": {}})")).tolerance.force_N, 0.05);
    const Scene scene = load(with_scene_extras(
        R"({"planar": true, "other": [1], "tolerance": {"force_N": 0.25, "direction_deg": 9,
            "bandwidth_hz": 30}})"));
    EXPECT_TRUE(scene.planar);
    EXPECT_EQ(scene.tolerance.force_N, 0.25);
    EXPECT_NEAR(scene.tolerance.direction_rad, 9.0 * kRadiansPerDegree, 1e-15);
    EXPECT_EQ(scene.tolerance.bandwidth_hz, 30.0);
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

TEST(SceneExtras, LeavesWhatIsOfAnotherKindToOtherPrograms) {
    struct Case {
        std::string key;
        std::vector<std::string> values;
        std::string requested;
    };
    for (const Case &one :
         std::vector<Case>{{"tolerance",
                            {"0.05", "null", "[0.05]", "true", R"({"chord":1})"},
                            "an object of force_N, direction_deg and bandwidth_hz"},
                           {"lesson",
                            {"7", "null", "[1]", R"({"chapter":1})"},
                            "an object of title, feel, point and normal"},
                           {"planar", {"null", "1"}, "true or false"}}) {
        for (const std::string &value : one.values) {
            const Scene scene = load(with_scene_extras("{\"" + one.key + "\": " + value + "}"));
            EXPECT_TRUE(has_warning(scene, "scene: extras." + one.key + " is " + value +
                                               ": left out as another program's; it would have "
                                               "to be " +
                                               one.requested))
                << value;
            EXPECT_EQ(scene.tolerance.force_N, ModelTolerance{}.force_N);
            EXPECT_FALSE(scene.planar);
            EXPECT_TRUE(scene.lesson.is_empty());
        }
    }
}

TEST(SceneExtras, RefusesWhatCannotBeInAnObjectOfOurs) {
    const auto tolerance = [](const std::string &members) {
        return R"({"tolerance": {)" + members + "}}";
    };
    const auto lesson = [](const std::string &members) {
        return R"({"lesson": {)" + members + "}}";
    };
    for (const std::string force : {"0.0001", "10"}) { // the ends of the range
        EXPECT_EQ(load(with_scene_extras(tolerance(R"("force_N": )" + force))).tolerance.force_N,
                  std::stod(force));
    }
    const std::string longest(40, 'a');
    EXPECT_EQ(load(with_scene_extras(lesson(R"("title": ")" + longest + '"'))).lesson.title,
              longest);
    const std::string point = R"("point": [0, 0, 0])";
    const std::string normal = R"("normal": [0, 1, 0])";
    for (const auto &[extras, message] : std::vector<std::pair<std::string, std::string>>{
             {tolerance(R"("force_N": 0.00009)"), "tolerance.force_N is 9e-05; it must be a number "
                                                  "from 0.0001"},
             {tolerance(R"("force_N": 10.1)"), "tolerance.force_N is 10.1; it must be"},
             {tolerance(R"("force_N": "low")"), "tolerance.force_N is 'low'; it must be"},
             {tolerance(R"("force_N": null)"), "tolerance.force_N is null; it must be"},
             {tolerance(R"("direction_deg": 0)"), "it must be a number from 0.01 to 180"},
             {tolerance(R"("bandwidth_hz": 0.5)"), "it must be a number from 1 to 5000"},
             {tolerance(R"("force_N": 1, "force": 1)"),
              "tolerance.force is not known; what may stand there is force_N, direction_deg, "
              "bandwidth_hz"},
             {lesson(R"("title": 5)"), "lesson.title is 5; it must be a text of 1 to 40 bytes"},
             {lesson(R"("title": " ")"), "lesson.title is ' '; it must be a text"},
             {lesson(R"("title": ")" + longest + "a\""), "it must be a text of 1 to 40 bytes"},
             {lesson(R"("feel": ")" + std::string(201, 'a') + '"'), "a text of 1 to 200 bytes"},
             {lesson(R"("point": [0, 0], )" + normal),
              "lesson.point is [0,0]; it must be a list of three numbers"},
             {lesson(R"("point": [0, 0, "0"], )" + normal), "three numbers from -1e+06 to 1e+06"},
             {lesson(R"("point": [0, 0, 2e6], )" + normal), "a list of three numbers from"},
             {lesson(point), "lesson.point is [0,0,0]; it must be given with its normal"},
             {lesson(normal), "lesson.normal is [0,1,0]; it must be given with its point"},
             {lesson(point + R"(, "normal": [0, 0, 0])"), "it must be a direction, not zero"},
             {lesson(R"("title": "A wall", "sentence": "Press.")"),
              "lesson.sentence is not known; what may stand there is title, feel, point, "
              "normal"}}) {
        expect_failure(with_scene_extras(extras), message);
    }
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
