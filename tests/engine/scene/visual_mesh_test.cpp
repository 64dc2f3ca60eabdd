// Covers engine/scene/visual_mesh.cpp: how a scene is drawn.
#include "engine/scene/gltf_material.h"
#include "engine/scene/visual_mesh.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

namespace springdrive::scene {
namespace {

/// 2 × 1 pixels: one half-transparent orange, one nearly transparent blue.
const std::vector<std::uint8_t> kPixels = {255, 128, 0, 160, 10, 20, 250, 40};

std::string png() {
    std::string bytes;
    const auto collect = [](void *target, void *data, int size) {
        static_cast<std::string *>(target)->append(static_cast<const char *>(data),
                                                   static_cast<std::size_t>(size));
    };
    stbi_write_png_to_func(collect, &bytes, 2, 1, 4, kPixels.data(), 8);
    return bytes;
}

/// A textured triangle; `image` is the image's JSON.
GltfBuilder textured(const std::string &image, const std::string &material_members = "",
                     const std::string &texture_members = "") {
    GltfBuilder builder = one_triangle(R"("name": "picture")");
    builder.add_accessor(std::vector<float>{0.25F, 0.5F, 1, 0, 0, 1}, kFloat, "VEC2"); // 1
    builder.add_accessor(std::vector<std::uint8_t>{51, 102, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0},
                         kUnsignedByte, "VEC4", R"(, "normalized": true)"); // 2, only filler
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1},
                                          "material": 0}]})"};
    builder.materials = {R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0)" +
                         texture_members + "}}" + material_members + "}"};
    builder.textures = {R"({"source": 0})"};
    builder.images = {image};
    return builder;
}

std::string embedded_image() {
    return R"({"uri": "data:image/png;base64,)" + to_base64(png()) + "\"}";
}

const std::string kBlend = R"(, "alphaMode": "BLEND")";

void expect_pixels(const Scene &scene, const std::vector<std::uint8_t> &rgba) {
    ASSERT_EQ(scene.textures.size(), 1U);
    EXPECT_EQ(scene.meshes.front().texture, 0);
    EXPECT_EQ(scene.textures[0].width, 2);
    EXPECT_EQ(scene.textures[0].height, 1);
    EXPECT_EQ(scene.textures[0].rgba, rgba);
}

TEST(GltfMaterial, ImagesInDataUrisAreDecoded) {
    expect_pixels(load(textured(embedded_image(), kBlend)), kPixels);
}

TEST(GltfMaterial, ImagesInBufferViewsAreDecoded) {
    GltfBuilder builder = textured("", kBlend);
    const int view = builder.add_view(png());
    builder.images = {R"({"mimeType": "image/png", "bufferView": )" + std::to_string(view) + "}"};
    expect_pixels(load(builder), kPixels);
    expect_pixels(load_bytes(builder.glb()), kPixels);
}

TEST(GltfMaterial, ImagesBesideTheFileAreDecoded) {
    const TemporaryFolder folder;
    folder.write("a picture.png", png());
    const auto file =
        folder.write("scene.gltf", textured(R"({"uri": "a%20picture.png"})", kBlend).gltf());
    expect_pixels(load_gltf(file, small_workspace()), kPixels);
}

TEST(GltfMaterial, AlphaCountsAsTheMaterialUsesIt) {
    const auto expect = [](const std::string &members, const std::vector<std::uint8_t> &rgba,
                           bool translucent, std::optional<float> cutoff) {
        const Scene scene = load(textured(embedded_image(), members));
        expect_pixels(scene, rgba);
        EXPECT_EQ(scene.meshes.front().translucent, translucent) << members;
        EXPECT_EQ(scene.meshes.front().alpha_cutoff, cutoff) << members;
    };
    expect("", {255, 128, 0, 255, 10, 20, 250, 255}, false, {});
    expect(kBlend, kPixels, true, {});
    expect(R"(, "alphaMode": "MASK")", kPixels, false, 0.5F);
    expect(R"(, "alphaMode": "MASK", "alphaCutoff": 0.75)", kPixels, false, 0.75F);
}

TEST(GltfMaterial, AMaskIsOneOnlyWhereSomethingShowsThrough) {
    const auto cutoff = [](const std::string &members) {
        GltfBuilder builder = one_triangle();
        builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]})"};
        builder.materials = {R"({"alphaMode": "MASK")" + members + "}"};
        return load(builder).meshes.front().alpha_cutoff;
    };
    EXPECT_FALSE(cutoff("").has_value());
    EXPECT_FALSE(cutoff(R"(, "alphaCutoff": 1)").has_value());
    EXPECT_EQ(cutoff(R"(, "alphaCutoff": 1.5)"), 1.5F); // glTF: then there is nothing
    EXPECT_EQ(cutoff(R"(, "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]})"), 0.5F);
}

/// The triangle with a material of these members, and the embedded image as texture 0.
GltfBuilder with_material(const std::string &members) {
    GltfBuilder builder = textured(embedded_image());
    builder.materials = {"{" + members + "}"};
    return builder;
}

Finish finish_of(const std::string &material_members) {
    return load(with_material(material_members)).meshes.front().finish;
}

TEST(GltfMaterial, MetalAndRoughnessComeThroughAndAreOneByDefault) {
    for (const Finish &finish : {load(one_triangle()).meshes.front().finish, finish_of(""),
                                 finish_of(R"("pbrMetallicRoughness": {})")}) {
        EXPECT_EQ(finish.metallic, 1.0F);
        EXPECT_EQ(finish.roughness, 1.0F);
        EXPECT_EQ(finish.metallic_roughness_texture, -1);
        EXPECT_EQ(finish.normal_texture, -1);
        EXPECT_EQ(finish.occlusion_texture, -1);
    }
    const Finish finish = finish_of(
        R"("pbrMetallicRoughness": {"metallicFactor": 0.25, "roughnessFactor": 0.5,
                                    "metallicRoughnessTexture": {"index": 0}})");
    EXPECT_EQ(finish.metallic, 0.25F);
    EXPECT_EQ(finish.roughness, 0.5F);
    EXPECT_EQ(finish.metallic_roughness_texture, 0);
}

TEST(GltfMaterial, NumbersBeyondTheirRangeAreDrawnAtItsEndAndWarnedOf) {
    const Scene scene = load(with_material(
        R"("pbrMetallicRoughness": {"metallicFactor": 1.5, "roughnessFactor": -0.5})"));
    EXPECT_EQ(scene.meshes.front().finish.metallic, 1.0F);
    EXPECT_EQ(scene.meshes.front().finish.roughness, 0.0F);
    EXPECT_TRUE(has_warning(scene, "node 'picture': its material's metallicFactor is 1.5, drawn as "
                                   "1: it is from 0 to 1"));
    EXPECT_TRUE(has_warning(scene, "roughnessFactor is -0.5, drawn as 0"));
    for (const double edge : {0.0, 1.0}) {
        EXPECT_FALSE(
            has_warning(load(with_material(R"("pbrMetallicRoughness": {"metallicFactor": )" +
                                           std::to_string(edge) + "}")),
                        "metallicFactor"));
    }
    EXPECT_EQ(
        line_of_failure(with_material(R"("normalTexture": {"index": 0, "scale": 1e39})").gltf()),
        "node 'picture': material 0: the normal texture's scale is 1e+39; a number must be "
        "finite in single precision");
}

TEST(GltfMaterial, TexturesOfNumbersAreNoColoursAndHaveNoAlpha) {
    const Scene scene = load(with_material(
        R"("normalTexture": {"index": 0, "scale": 0.75},
           "occlusionTexture": {"index": 0, "strength": 0.5},
           "pbrMetallicRoughness": {"baseColorTexture": {"index": 0},
                                    "metallicRoughnessTexture": {"index": 0}})"));
    const VisualMesh &mesh = scene.meshes.front();
    EXPECT_EQ(mesh.finish.normal_scale, 0.75F);
    EXPECT_EQ(mesh.finish.occlusion_strength, 0.5F);
    // Decoded once for each use.
    ASSERT_EQ(scene.textures.size(), 2U);
    EXPECT_EQ(mesh.finish.occlusion_texture, mesh.finish.normal_texture);
    EXPECT_EQ(mesh.finish.metallic_roughness_texture, mesh.finish.normal_texture);
    EXPECT_NE(mesh.texture, mesh.finish.normal_texture);
    for (const int texture : {mesh.texture, mesh.finish.normal_texture}) {
        EXPECT_EQ(scene.textures.at(static_cast<std::size_t>(texture)).holds_numbers,
                  texture != mesh.texture);
        EXPECT_EQ(scene.textures.at(static_cast<std::size_t>(texture)).rgba,
                  (std::vector<std::uint8_t>{255, 128, 0, 255, 10, 20, 250, 255}));
    }
}

TEST(GltfMaterial, TexturesOfNumbersThatCannotBeDrawnAreWarnedOf) {
    const std::string finish = R"("pbrMetallicRoughness": {"metallicFactor": 0.5,
                                   "metallicRoughnessTexture": {"index": 0}})";
    GltfBuilder missing = with_material(finish);
    missing.images = {R"({"uri": "none.png"})"};
    EXPECT_TRUE(has_warning(load(missing), "image 'none.png': left out, as it cannot be read"));
    EXPECT_EQ(load(missing).meshes.front().finish.metallic_roughness_texture, -1);
    EXPECT_EQ(load(missing).meshes.front().finish.metallic, 0.5F);
    const std::string elsewhere = R"("normalTexture": {"index": 0, "texCoord": 1},
                                     "occlusionTexture": {"index": 0, "texCoord": 1}, )";
    const Scene placed = load(with_material(elsewhere + finish));
    EXPECT_TRUE(has_warning(placed, "node 'picture': its normal map is left out, as it is placed "
                                    "differently from the material's others"));
    EXPECT_TRUE(has_warning(placed, "its occlusion is left out, as it is placed differently"));
    EXPECT_EQ(placed.meshes.front().finish.normal_texture, -1);
    EXPECT_EQ(placed.meshes.front().finish.occlusion_texture, -1);
    EXPECT_EQ(placed.meshes.front().finish.metallic_roughness_texture, 0);
    // Alone, it is drawn at its own place.
    const Scene unplaced = load(with_material(R"("normalTexture": {"index": 0, "texCoord": 1})"));
    EXPECT_TRUE(has_warning(unplaced, "node 'picture': it has a texture but no TEXCOORD_1"));
    EXPECT_EQ(unplaced.meshes.front().finish.normal_texture, -1);
}

/// The triangle with normals towards z, tangents along x, and a normal map.
GltfBuilder with_tangents(const std::string &node_members, const std::string &material) {
    GltfBuilder builder = with_material(material);
    builder.add_accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3"); // 3
    builder.add_accessor(std::vector<float>{1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1}, kFloat, "VEC4");
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1,
                                          "NORMAL": 3, "TANGENT": 4}, "material": 0}]})"};
    builder.nodes = {R"({"name": "picture", "mesh": 0)" + node_members + "}"};
    return builder;
}

TEST(GltfMaterial, TangentsComeThroughWhereANormalMapNeedsThem) {
    const std::string map = R"("normalTexture": {"index": 0})";
    using Tangents = std::vector<std::array<float, 4>>;
    EXPECT_EQ(load(with_tangents("", map)).meshes.front().tangents,
              (Tangents{{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, -1}}));
    EXPECT_TRUE(load(with_tangents("", "")).meshes.front().tangents.empty());
    EXPECT_TRUE(load(with_material(map)).meshes.front().tangents.empty());
    // Along the surface as the node turns and stretches it, and unit; a mirrored bitangent.
    EXPECT_EQ(load(with_tangents(R"(, "scale": [-2, 1, 3])", map)).meshes.front().tangents,
              (Tangents{{-1, 0, 0, -1}, {-1, 0, 0, -1}, {-1, 0, 0, 1}}));
    GltfBuilder short_of_one = with_tangents("", map);
    short_of_one.add_accessor(std::vector<float>{1, 0, 0, 1, 0, 0}, kFloat, "VEC3"); // 5
    short_of_one.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1,
                               "NORMAL": 3, "TANGENT": 5}, "material": 0}]})"};
    expect_failure(short_of_one, "TANGENT has 3 numbers a vertex; it takes 4");
}

TEST(GltfMaterial, OneTextureUsedTwiceIsDecodedOnce) {
    GltfBuilder builder = textured(embedded_image());
    builder.nodes.push_back(builder.nodes.front());
    const Scene scene = load(builder);
    EXPECT_EQ(scene.textures.size(), 1U);
    EXPECT_EQ(scene.meshes[1].texture, 0);
}

TEST(GltfMaterial, WrapModesFollowTheSampler) {
    EXPECT_EQ(load(textured(embedded_image())).textures[0].wrap_s, Texture::Wrap::repeat);
    GltfBuilder builder = textured(embedded_image());
    builder.textures = {R"({"source": 0, "sampler": 0})"};
    builder.samplers = {R"({"wrapS": 33071, "wrapT": 33648})"};
    const Texture texture = load(builder).textures[0];
    EXPECT_EQ(texture.wrap_s, Texture::Wrap::clamp);
    EXPECT_EQ(texture.wrap_t, Texture::Wrap::mirror);
}

TEST(GltfMaterial, ImagesThatCannotBeHadAreWarnedOfAndLeftOut) {
    const auto expect_left_out = [](const GltfBuilder &builder, const std::string &warning) {
        const Scene scene = load(builder);
        EXPECT_EQ(scene.surface.triangles.size(), 1U);
        EXPECT_EQ(scene.meshes.front().texture, -1);
        EXPECT_TRUE(scene.textures.empty());
        EXPECT_TRUE(std::ranges::count(scene.warnings, warning) == 1)
            << warning << '\n'
            << (scene.warnings.empty() ? "" : scene.warnings.back());
    };
    const auto in_uri = [](const std::string &bytes, const std::string &members = "") {
        return textured(R"({"uri": "data:image/png;base64,)" + to_base64(bytes) + "\"" + members +
                        "}");
    };
    const auto sized = [](const std::string &width_and_height) {
        std::string bytes = png(); // the header's width and height, big-endian, from byte 16
        return bytes.replace(16, 8, width_and_height);
    };
    expect_left_out(
        textured(R"({"uri": "missing%20one.png", "name": "wood"})"),
        "image 'missing one.png': left out, as it cannot be read: there is no such file");
    expect_left_out(
        textured(R"({"uri": "../wood.png"})"),
        "image '../wood.png': left out, as it lies outside the scene's folder and is not "
        "read; put the file there");
    expect_left_out(in_uri("hello world"), "image 0: left out, as it is neither PNG nor JPEG");
    expect_left_out(in_uri("", R"(, "name": "wood")"), "image 'wood': left out, as it is empty");
    expect_left_out(in_uri(png().substr(0, 30), R"(, "name": "wood")"),
                    "image 'wood': left out, as it is damaged");
    expect_left_out(in_uri(png().substr(0, 20)), "image 0: left out, as it is damaged");
    expect_left_out(textured(R"({"uri": "data:image/png;base64,&"})"),
                    "image 0: left out, as it is damaged: character 1 of its data is no base64 "
                    "digit; export it again");
    expect_left_out(in_uri(sized(std::string("\0\0\x3a\x98\0\0\x3a\x98", 8))),
                    "image 0: left out, as it is too large with 15000 x 15000 pixels: of 134217728 "
                    "for all textures together, 134217728 are left");
    expect_left_out(in_uri(sized(std::string("\0\0\x75\x30\0\0\x75\x30", 8))),
                    "image 0: left out, as it is too large with 30000 x 30000 pixels: of 134217728 "
                    "for all textures together, 134217728 are left");
    GltfBuilder webp = textured(embedded_image());
    webp.textures = {R"({"extensions": {"EXT_texture_webp": {"source": 0}}})"};
    webp.more = R"("extensionsUsed": ["EXT_texture_webp"], )";
    expect_left_out(webp, "texture 0: left out, as it names no PNG or JPEG");
    EXPECT_TRUE(has_warning(load(webp), "extension 'EXT_texture_webp' is left out"));
}

TEST(GltfMaterial, ColoursBeyondSinglePrecisionAreRefused) {
    GltfBuilder builder = textured(embedded_image());
    builder.materials = {R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1e39, 1, 1]}})"};
    EXPECT_EQ(line_of_failure(builder.gltf()),
              "node 'picture': material 0: baseColorFactor is 1e+39; a colour is from 0 to 1, and "
              "must be finite in single precision");
    builder.materials = {R"({"emissiveFactor": [1, 1, 1], "extensions":
                             {"KHR_materials_emissive_strength": {"emissiveStrength": 1e39}}})"};
    EXPECT_EQ(line_of_failure(builder.gltf()),
              "node 'picture': material 0: emissiveFactor is 1e+39; a colour is from 0 to 1, and "
              "must be finite in single precision");
}

TEST(GltfMaterial, RefusesReferencesToWhatIsNotThere) {
    GltfBuilder builder = textured(embedded_image());
    builder.textures = {R"({"source": 1})"};
    expect_failure(builder, "image 1 is not in the file, which has 1");
    builder.textures = {R"({"source": 0, "sampler": 0})"};
    expect_failure(builder, "sampler 0 is not in the file");
    builder.textures.clear();
    expect_failure(builder, "texture 0 is not in the file");
    builder = textured(R"({"bufferView": 0, "mimeType": "image/png"})");
    builder.views[0] = R"({"buffer": 0, "byteOffset": 4000000, "byteLength": 100})";
    expect_failure(builder, "buffer view 0");
    builder = textured(embedded_image());
    builder.materials = {R"({"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}})"};
    expect_failure(builder, "baseColorFactor");
}

TEST(GltfMaterial, TheTextureSetIsChosenByTheMaterial) {
    GltfBuilder builder = textured(embedded_image(), "", R"(, "texCoord": 1)");
    EXPECT_TRUE(has_warning(load(builder), "node 'picture': it has a texture but no TEXCOORD_1"));
    EXPECT_EQ(load(builder).meshes.front().texture, -1);
    // A second set, of bytes four apart.
    const std::vector<std::uint8_t> bytes = {51, 102, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0};
    const int view = builder.add_view({reinterpret_cast<const char *>(bytes.data()), 12},
                                      R"(, "byteStride": 4)");
    builder.accessors[2] = R"({"bufferView": )" + std::to_string(view) +
                           R"(, "componentType": 5121, "normalized": true, "count": 3,
                               "type": "VEC2"})";
    builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1,
                                          "TEXCOORD_1": 2}, "material": 0}]})"};
    const VisualMesh mesh = load(builder).meshes.front();
    EXPECT_EQ(mesh.texture, 0);
    EXPECT_FLOAT_EQ(mesh.vertices[0].texture_coordinate[0], 0.2F);
    EXPECT_FLOAT_EQ(mesh.vertices[0].texture_coordinate[1], 0.4F);
}

TEST(GltfMaterial, TextureTransformScalesThenTurnsThenShifts) {
    const std::string quarter_turn = std::to_string(std::numbers::pi / 2);
    const VisualMesh mesh = load(textured(embedded_image(), "",
                                          R"(, "extensions": {"KHR_texture_transform":
                          {"offset": [10, 20], "scale": [2, 4], "rotation": )" +
                                              quarter_turn + "}}"))
                                .meshes.front();
    // (¼, ½) → scaled (½, 2) → a quarter turn, (u, v) ↦ (v, −u) → (2, −½) → shifted.
    constexpr float kRounding = 1e-5F; // to_string gives π/2 six digits
    EXPECT_NEAR(mesh.vertices[0].texture_coordinate[0], 12.0F, kRounding);
    EXPECT_NEAR(mesh.vertices[0].texture_coordinate[1], 19.5F, kRounding);
}

TEST(GltfMaterial, TextureTransformMayChooseTheSetToo) {
    const Scene scene = load(
        textured(embedded_image(), "",
                 R"(, "texCoord": 3, "extensions": {"KHR_texture_transform": {"texCoord": 0}})"));
    EXPECT_EQ(scene.meshes.front().texture, 0);
    EXPECT_FLOAT_EQ(scene.meshes.front().vertices[0].texture_coordinate[1], 0.5F);
}

/// The textured triangle with a black base and emission; `base` stands in pbrMetallicRoughness.
GltfBuilder emissive(const std::string &base, const std::string &texture_members = "") {
    GltfBuilder builder = textured(embedded_image());
    builder.materials = {R"({"emissiveFactor": [0.25, 0.5, 1], "emissiveTexture": {"index": 0)" +
                         texture_members + R"(}, "pbrMetallicRoughness": {)" + base + "}}"};
    return builder;
}

const std::array<float, 3> kEmission{0.25F, 0.5F, 1.0F};
const std::array<float, 3> kDark{0.0F, 0.0F, 0.0F};

TEST(GltfMaterial, EmissionComesThroughWithItsTexture) {
    EXPECT_EQ(load(one_triangle()).meshes.front().emission, kDark);
    const VisualMesh alone = load(emissive(R"("baseColorFactor": [0, 0, 0, 1])")).meshes.front();
    EXPECT_EQ(alone.emission, kEmission);
    EXPECT_EQ(alone.texture, -1);
    EXPECT_EQ(alone.emissive_texture, 0);
    EXPECT_FLOAT_EQ(alone.vertices[0].texture_coordinate[1], 0.5F);
    const Scene both = load(emissive(R"("baseColorTexture": {"index": 0})"));
    EXPECT_EQ(both.meshes.front().emission, kEmission);
    EXPECT_EQ(both.meshes.front().texture, 0);
    EXPECT_EQ(both.meshes.front().emissive_texture, 0);
    EXPECT_TRUE(both.warnings.empty() || !has_warning(both, "emission"));
}

TEST(GltfMaterial, EmissionIsMultipliedByItsStrength) {
    GltfBuilder builder = textured(embedded_image());
    builder.materials = {R"({"emissiveFactor": [0.25, 0.5, 1], "extensions":
                             {"KHR_materials_emissive_strength": {"emissiveStrength": 2.5}}})"};
    const std::array<float, 3> strong{0.625F, 1.25F, 2.5F};
    EXPECT_EQ(load(builder).meshes.front().emission, strong);
}

TEST(GltfMaterial, EmissionWhoseTextureCannotBeDrawnIsLeftOut) {
    const Scene elsewhere = load(emissive(R"("baseColorTexture": {"index": 0})",
                                          R"(, "extensions": {"KHR_texture_transform":
                                              {"scale": [2, 2]}})"));
    EXPECT_EQ(elsewhere.meshes.front().emission, kDark);
    EXPECT_TRUE(has_warning(elsewhere,
                            "node 'picture': its emission is left out, as its texture is "
                            "placed differently from the material's others"));
    GltfBuilder missing = emissive("");
    missing.images = {R"({"uri": "none.png"})"};
    EXPECT_EQ(load(missing).meshes.front().emission, kDark);
    EXPECT_TRUE(has_warning(load(missing), "image 'none.png': left out"));
    const Scene without = load(emissive("", R"(, "texCoord": 1)"));
    EXPECT_EQ(without.meshes.front().emission, kDark);
    EXPECT_TRUE(has_warning(without, "node 'picture': it has a texture but no TEXCOORD_1"));
}

using Point = std::array<float, 3>;

void add_triangle(VisualMesh &mesh, const std::array<Point, 3> &corners,
                  const std::array<Point, 3> &normals) {
    for (std::size_t i = 0; i < 3; ++i) {
        mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
        mesh.vertices.push_back({corners[i], normals[i], {}, {}});
    }
}

/// Two triangles.
void add_quad(VisualMesh &mesh, const std::array<Point, 4> &corners,
              const std::array<Point, 4> &normals) {
    add_triangle(mesh, {corners[0], corners[1], corners[2]}, {normals[0], normals[1], normals[2]});
    add_triangle(mesh, {corners[0], corners[2], corners[3]}, {normals[0], normals[2], normals[3]});
}

/// The closed wall and both ends of a prism over a regular polygon.
/// @param smooth  whether the wall's normals are those of a cylinder, or of its faces
VisualMesh prism(int sides, bool smooth) {
    VisualMesh mesh;
    const auto at = [&](double turn, float height) {
        const double angle = 2.0 * std::numbers::pi * std::fmod(turn, sides) / sides;
        return Point{static_cast<float>(std::cos(angle)), height,
                     static_cast<float>(std::sin(angle))};
    };
    for (int i = 0; i < sides; ++i) {
        const Point facing = at(i + 0.5, 0.0F);
        const Point from = smooth ? at(i, 0.0F) : facing;
        const Point to = smooth ? at(i + 1, 0.0F) : facing;
        add_quad(mesh, {at(i, 0.0F), at(i + 1, 0.0F), at(i + 1, 1.0F), at(i, 1.0F)},
                 {from, to, to, from});
        for (const float height : {0.0F, 1.0F}) {
            const Point up{0.0F, height > 0.5F ? 1.0F : -1.0F, 0.0F};
            add_triangle(mesh, {Point{0.0F, height, 0.0F}, at(i, height), at(i + 1, height)},
                         {up, up, up});
        }
    }
    return mesh;
}

std::vector<LineSegment> creases(const VisualMesh &mesh) { return creases_of({&mesh, 1}); }

/// Neighbouring faces of a prism over n sides meet at 360°/n, wall and ends at 90°.
TEST(Creases, OfPrismsAreTheEdgesThatTurnByMoreThanTheirAngle) {
    for (int sides = 3; sides <= 40; ++sides) {
        const bool has_edges = 360.0 / sides > kCrease_deg;
        if (360.0 / sides == kCrease_deg) {
            continue; // round-off decides
        }
        const auto rims = 2 * static_cast<std::size_t>(sides);
        EXPECT_EQ(creases(prism(sides, false)).size(),
                  rims + (has_edges ? static_cast<std::size_t>(sides) : 0))
            << sides;
        EXPECT_EQ(creases(prism(sides, true)).size(), rims) << sides; // drawn round
    }
}

TEST(Creases, AreTheBorderOfAQuadButNotItsDiagonal) {
    const Point up{0.0F, 1.0F, 0.0F};
    VisualMesh mesh;
    add_quad(mesh, {Point{0, 0, 0}, Point{0, 0, 1}, Point{1, 0, 1}, Point{1, 0, 0}},
             {up, up, up, up});
    const std::vector<LineSegment> found = creases(mesh);
    EXPECT_EQ(found.size(), 4U);
    EXPECT_EQ(std::ranges::count(found, LineSegment{Point{0, 0, 0}, Point{1, 0, 1}}), 0);
}

TEST(Creases, AreNotOfWhatHasATextureAMaskOrIsSeenThrough) {
    const VisualMesh plain = prism(4, false);
    EXPECT_EQ(creases(plain).size(), 12U);
    VisualMesh textured = plain;
    textured.texture = 0;
    EXPECT_TRUE(creases(textured).empty());
    VisualMesh bumped = plain;
    bumped.finish.normal_texture = 0;
    EXPECT_TRUE(creases(bumped).empty());
    VisualMesh glass = plain;
    glass.translucent = true;
    EXPECT_TRUE(creases(glass).empty());
    VisualMesh masked = plain;
    masked.alpha_cutoff = 0.5F;
    EXPECT_TRUE(creases(masked).empty());
}

/// Neither the order of the triangles nor the meshes that they are in matter.
TEST(Creases, AreTheSameOfAMeshInPieces) {
    std::mt19937_64 dice(7);
    VisualMesh mesh = prism(24, false);
    const std::vector<LineSegment> whole = creases(mesh);
    ASSERT_EQ(whole.size(), 48U);
    for (const std::size_t vertices : {3U, 9U, 30U, 100U}) {
        std::vector<std::size_t> order(mesh.indices.size() / 3);
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
        }
        std::ranges::shuffle(order, dice);
        VisualMesh shuffled = mesh;
        for (std::size_t i = 0; i < order.size(); ++i) {
            std::copy_n(mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * order[i]), 3,
                        shuffled.indices.begin() + static_cast<std::ptrdiff_t>(3 * i));
        }
        EXPECT_EQ(creases_of(in_pieces(shuffled, vertices)), whole) << vertices;
    }
}

TEST(Creases, AreLeftOutWhereTheyAreTooMany) {
    const auto open_triangles = [](std::size_t count) { // of three creases each
        VisualMesh mesh;
        const Point up{0.0F, 1.0F, 0.0F};
        for (std::size_t i = 0; i < count; ++i) {
            const auto x = static_cast<float>(2 * i);
            add_triangle(mesh, {Point{x, 0, 0}, Point{x, 0, 1}, Point{x + 1.0F, 0, 0}},
                         {up, up, up});
        }
        return mesh;
    };
    constexpr std::size_t kMax = kMaxCreases / 3;
    EXPECT_EQ(creases(open_triangles(kMax)).size(), 3 * kMax);
    EXPECT_TRUE(creases(open_triangles(kMax + 1)).empty());
    VisualMesh closed = prism(4, false);
    const std::vector<std::uint32_t> once = closed.indices;
    while (closed.indices.size() <= 3 * kMaxCreasedTriangles - once.size()) {
        closed.indices.insert(closed.indices.end(), once.begin(), once.end());
    }
    EXPECT_EQ(creases(closed).size(), 12U);
    closed.indices.insert(closed.indices.end(), once.begin(), once.end());
    EXPECT_TRUE(creases(closed).empty());
}

/// Vertices that carry their number as x; triangles between random ones.
VisualMesh random_mesh(std::size_t vertices, std::size_t triangles) {
    std::mt19937_64 dice(20260733);
    std::uniform_int_distribution<std::uint32_t> any(0, static_cast<std::uint32_t>(vertices) - 1);
    VisualMesh mesh;
    mesh.name = "mesh";
    mesh.texture = 3;
    mesh.double_sided = true;
    mesh.finish.normal_texture = 5;
    for (std::size_t i = 0; i < vertices; ++i) {
        mesh.vertices.push_back({{static_cast<float>(i), 0.0F, 0.0F}, {}, {}, {}});
        mesh.tangents.push_back({0.0F, static_cast<float>(i), 0.0F, 1.0F});
    }
    for (std::size_t i = 0; i < 3 * triangles; ++i) {
        mesh.indices.push_back(any(dice));
    }
    return mesh;
}

/// The numbers of all corners, triangle by triangle.
std::vector<float> corners(const std::vector<VisualMesh> &meshes) {
    std::vector<float> numbers;
    for (const VisualMesh &mesh : meshes) {
        for (const std::uint32_t index : mesh.indices) {
            numbers.push_back(mesh.vertices.at(index).position_m[0]);
        }
    }
    return numbers;
}

TEST(VisualPieces, HoldTheSameTrianglesInTheSameOrder) {
    const VisualMesh mesh = random_mesh(1000, 3000);
    const std::vector<float> requested = corners({mesh});
    for (const std::size_t maximum : {3U, 4U, 10U, 100U, 999U}) {
        const std::vector<VisualMesh> pieces = in_pieces(mesh, maximum);
        EXPECT_GT(pieces.size(), 1U);
        EXPECT_EQ(corners(pieces), requested) << maximum;
        for (const VisualMesh &piece : pieces) {
            EXPECT_LE(piece.vertices.size(), maximum);
            EXPECT_LE(piece.indices.size(), 6 * maximum);
            EXPECT_FALSE(piece.indices.empty());
            EXPECT_EQ(piece.name, "mesh");
            EXPECT_EQ(piece.texture, 3);
            EXPECT_EQ(piece.finish.normal_texture, 5);
            ASSERT_EQ(piece.tangents.size(), piece.vertices.size());
            for (std::size_t i = 0; i < piece.vertices.size(); ++i) {
                ASSERT_EQ(piece.tangents[i][1], piece.vertices[i].position_m[0]);
            }
            EXPECT_TRUE(piece.double_sided);
        }
    }
}

TEST(VisualPieces, ASmallMeshStaysAsItIs) {
    const VisualMesh mesh = random_mesh(100, 200);
    const std::vector<VisualMesh> pieces = in_pieces(mesh, 100);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_EQ(pieces[0].indices, mesh.indices);
    EXPECT_EQ(pieces[0].vertices.size(), mesh.vertices.size());
    EXPECT_EQ(in_pieces(random_mesh(100, 201), 100).size(), 2U); // few vertices, many triangles
    EXPECT_EQ(in_pieces(random_mesh(3, 0), 100).size(), 1U);
}

/// Grey values in rows of `width`; alpha is the grey value less one.
Texture grey(int width, const std::vector<int> &values) {
    Texture texture;
    texture.width = width;
    texture.height = static_cast<int>(values.size()) / width;
    for (const int value : values) {
        const auto byte = static_cast<std::uint8_t>(value);
        texture.rgba.insert(texture.rgba.end(),
                            {byte, byte, byte, static_cast<std::uint8_t>(byte - 1)});
    }
    return texture;
}

TEST(TextureScaling, SmallTexturesStayAsTheyAre) {
    const Texture texture = grey(3, {1, 2, 3, 4, 5, 6});
    EXPECT_EQ(scaled_down(texture, 3).rgba, texture.rgba);
}

TEST(TextureScaling, EachPixelIsTheMeanOfThoseThatItCovers) {
    Texture texture = grey(4, {10, 20, 30, 50, 30, 40, 50, 70});
    texture.wrap_s = Texture::Wrap::mirror;
    texture.has_alpha = true;
    texture.holds_numbers = true;
    const Texture half = scaled_down(texture, 2);
    EXPECT_EQ(half.rgba, grey(2, {15, 40, 35, 60}).rgba);
    EXPECT_EQ(half.wrap_s, Texture::Wrap::mirror);
    EXPECT_TRUE(half.has_alpha);
    EXPECT_TRUE(half.holds_numbers);
    EXPECT_EQ(scaled_down(texture, 1).rgba, grey(1, {38}).rgba); // 37.5
}

TEST(TextureScaling, OnlyTheSideThatIsTooLongIsScaled) {
    // Three pixels on two: the middle one is covered by both.
    const Texture scaled = scaled_down(grey(3, {10, 20, 50}), 2);
    EXPECT_EQ(scaled.width, 2);
    EXPECT_EQ(scaled.height, 1);
    EXPECT_EQ(scaled.rgba, grey(2, {15, 35}).rgba);
}

} // namespace
} // namespace springdrive::scene
