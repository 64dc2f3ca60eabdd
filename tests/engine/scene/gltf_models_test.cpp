// Real models, made by other people's programs. Triangle counts were taken from the files' JSON by
// a separate script: index counts of the primitives, summed over the nodes of the default scene.
#include "engine/scene/gltf.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

class GltfModels : public ::testing::Test {
protected:
    void SetUp() override {
        if (!std::filesystem::is_directory(SPRINGDRIVE_MODELS_DIR)) {
            GTEST_SKIP() << "no models to load: there is no folder " << SPRINGDRIVE_MODELS_DIR;
        }
    }

    static Scene load_model(const std::string &name) {
        const Scene scene =
            load_gltf(std::filesystem::path(SPRINGDRIVE_MODELS_DIR) / name, small_workspace());
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
        EXPECT_TRUE(scene.lower_m.allFinite() && scene.upper_m.allFinite());
        const Vector3 share =
            (scene.upper_m - scene.lower_m).cwiseQuotient(small_workspace().size_m);
        EXPECT_NEAR(share.maxCoeff(), 0.6, 1e-12); // rounding
        EXPECT_EQ(scene.surface.material_of_triangle.size(), scene.surface.triangles.size());
        std::size_t drawn = 0;
        for (const VisualMesh &mesh : scene.meshes) {
            drawn += mesh.indices.size() / 3;
        }
        EXPECT_EQ(drawn, scene.surface.triangles.size());
        return scene;
    }
};

TEST_F(GltfModels, Box) {
    const Scene scene = load_model("Box.glb");
    EXPECT_EQ(scene.surface.triangles.size(), 12U);
    EXPECT_FLOAT_EQ(scene.meshes[0].vertices[0].colour[0], 0.8F);
}

TEST_F(GltfModels, TwoCylinderEngine) {
    // 75,730 triangles in its meshes, of which several stand in more than one place.
    const Scene scene = load_model("2CylinderEngine.glb");
    EXPECT_EQ(scene.surface.triangles.size(), 121'496U);
}

TEST_F(GltfModels, Knight) {
    const Scene scene = load_model("chr_knight.glb");
    EXPECT_EQ(scene.surface.triangles.size(), 1460U);
    ASSERT_EQ(scene.textures.size(), 1U);
    EXPECT_EQ(scene.meshes[0].texture, 0);
    EXPECT_GT(scene.textures[0].width, 0);
}

TEST_F(GltfModels, ShapeCollection) {
    const Scene scene = load_model("ShapeCollection.glb");
    EXPECT_EQ(scene.surface.triangles.size(), 3542U);
    EXPECT_EQ(scene.surface.materials.size(), 7U);
    EXPECT_EQ(scene.meshes[6].name, "Torus.001");
}

TEST_F(GltfModels, DenseSphereIsASphereOnceDecompressed) {
    const Scene scene = load_model("DenseSphere.glb");
    EXPECT_EQ(scene.surface.triangles.size(), 30'720U);
    const Vector3 centre_m = small_workspace().centre_m;
    double min_m = 1.0;
    double max_m = 0.0;
    for (const Vector3 &vertex : scene.surface.vertices_m) {
        const double radius_m = (vertex - centre_m).norm();
        min_m = std::min(min_m, radius_m);
        max_m = std::max(max_m, radius_m);
    }
    // The model's own vertices lie about 1 % within the sphere of its farthest ones at most.
    EXPECT_GT(min_m, 0.989 * max_m);
    // Its uncompressed bounds stand in the file: ±32555 by ±32767 by ±32575; Draco rounded to
    // 14 bits.
    const Vector3 extent = scene.upper_m - scene.lower_m;
    EXPECT_NEAR(extent.x() / extent.y(), 32555.0 / 32767.0, 2.0 / 16384.0);
    EXPECT_NEAR(extent.z() / extent.y(), 32575.0 / 32767.0, 2.0 / 16384.0);
}

} // namespace
} // namespace springdrive::scene
