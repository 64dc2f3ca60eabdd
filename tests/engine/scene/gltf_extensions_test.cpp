#include "engine/scene/gltf_extensions.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

GltfBuilder requiring(const std::string &extension) {
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsRequired": [")" + extension + "\"], ";
    return builder;
}

TEST(GltfExtensions, ThoseWithoutEffectOnTheShapeMayBeRequired) {
    for (const char *fine :
         {"KHR_mesh_quantization", "KHR_materials_unlit", "KHR_materials_clearcoat",
          "KHR_texture_transform", "KHR_animation_pointer", "EXT_meshopt_compression"}) {
        EXPECT_EQ(load(requiring(fine)).surface.triangles.size(), 1U) << fine;
    }
}

TEST(GltfExtensions, OthersThatAreRequiredAreNamed) {
    for (const std::string lacking :
         {"KHR_texture_basisu", "EXT_mesh_gpu_instancing", "KHR_materials_", "KHR_materials_velvet",
          "KHR_materials_unlit2", "KHR_node_visibility", ""}) {
        EXPECT_EQ(line_of_failure(requiring(lacking).gltf()),
                  "needs the extension '" + lacking +
                      "', which is not supported; export it without");
    }
}

TEST(GltfExtensions, RequiredSpecularGlossinessNeedsAnotherColourBesideIt) {
    const std::string extension = "KHR_materials_pbrSpecularGlossiness";
    GltfBuilder builder = requiring(extension);
    const std::string members = R"("extensions": {")" + extension + R"(": {}})";
    builder.materials = {"{}", "{" + members + R"(, "pbrMetallicRoughness": {}})"};
    EXPECT_EQ(load(builder).surface.triangles.size(), 1U);
    builder.materials.push_back("{" + members + "}");
    EXPECT_EQ(line_of_failure(builder.gltf()),
              "material 2 needs the extension '" + extension +
                  "', which is not supported; export it with metallic-roughness");
    builder.more = R"("extensionsUsed": [")" + extension + "\"], ";
    EXPECT_TRUE(has_warning(load(builder), "extension '" + extension + "' is left out"));
}

TEST(GltfExtensions, WhatIsLeftOutIsWarnedOf) {
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_materials_velvet"],
                      "animations": [{}, {}], )";
    const Scene scene = load(builder);
    EXPECT_TRUE(has_warning(scene, "extension 'EXT_mesh_gpu_instancing' is left out"));
    EXPECT_TRUE(has_warning(scene, "extension 'KHR_materials_velvet' is left out"));
    EXPECT_TRUE(has_warning(scene, "2 animation(s) are not played"));
}

TEST(GltfExtensions, AMinimumVersionAboveOursIsRefused) {
    GltfBuilder builder = one_triangle();
    for (const std::string fine : {R"("2.0")", R"("2.1")", R"("2.1", "minVersion": "2.0")"}) {
        builder.asset = R"({"version": )" + fine + "}";
        EXPECT_EQ(load(builder).surface.triangles.size(), 1U) << fine;
    }
    for (const std::string minimum : {"2.1", "3.0", "2", "", "2.0.1", "two", "2.00000000000000"}) {
        builder.asset = R"({"version": "2.1", "minVersion": ")" + minimum + "\"}";
        EXPECT_EQ(line_of_failure(builder.gltf()),
                  "needs glTF version '" + minimum + "' (its minVersion); export it as glTF 2.0");
    }
    for (const std::string version : {"1.0", "20.0", "2", "2.", ".0", "2.x"}) {
        builder.asset = R"({"version": ")" + version + "\"}";
        EXPECT_EQ(line_of_failure(builder.gltf()),
                  "is glTF version '" + version + "'; export it as glTF 2.0");
    }
}

} // namespace
} // namespace springdrive::scene
