#include "engine/scene/gltf_nodes.h"

#include "tests/engine/scene/gltf_builder.h"

#include <cmath>
#include <numbers>

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

} // namespace
} // namespace springdrive::scene
