#include "engine/scene/gltf_material.h"

#include "tests/engine/scene/gltf_builder.h"

#include <stb/stb_image_write.h>

#include <algorithm>
#include <numbers>
#include <optional>

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

} // namespace
} // namespace springdrive::scene
