#include "engine/scene/gltf_file.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

void expect_message(const std::string &message, const std::string &part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

std::string failure_of_file(const std::filesystem::path &file) {
    try {
        (void)load_gltf(file, small_workspace());
    } catch (const InputError &error) {
        return error.what();
    }
    return "loaded";
}

TEST(GltfFile, TextAndBinaryGiveTheSameScene) {
    const GltfBuilder builder = one_triangle();
    const Scene text = load_bytes(builder.gltf());
    const Scene binary = load_bytes(builder.glb());
    const Scene marked = load_bytes("\xEF\xBB\xBF \n" + builder.gltf()); // a byte order mark
    EXPECT_EQ(text.surface.vertices_m, binary.surface.vertices_m);
    EXPECT_EQ(text.surface.triangles, binary.surface.triangles);
    EXPECT_EQ(text.surface.vertices_m, marked.surface.vertices_m);
}

TEST(GltfFile, BuffersBesideTheFileAreRead) {
    const GltfBuilder builder = one_triangle();
    const TemporaryFolder folder;
    folder.write("my data.bin", builder.buffer);
    const auto file = folder.write("scene.gltf", builder.json("my%20data.bin"));
    EXPECT_EQ(load_gltf(file, small_workspace()).surface.triangles.size(), 1U);
    const auto binary = folder.write("empty.gltf", builder.json("absent.bin"));
    expect_message(failure_of_file(binary), "absent.bin");
    folder.write("short.bin", "abc");
    const auto mismatch = folder.write("mismatch.gltf", builder.json("short.bin"));
    expect_message(failure_of_file(mismatch), "short.bin");
    const auto a_folder = folder.write("folder.gltf", builder.json("."));
    EXPECT_NE(failure_of_file(a_folder), "loaded");
}

TEST(GltfFile, ARelativePathFindsItsBuffers) {
    const GltfBuilder builder = one_triangle();
    const TemporaryFolder folder;
    folder.write("data.bin", builder.buffer);
    const auto file = folder.write("scene.gltf", builder.json("data.bin"));
    const auto here = std::filesystem::current_path();
    const auto relative = std::filesystem::relative(file, here);
    EXPECT_EQ(load_gltf(relative, small_workspace()).surface.triangles.size(), 1U);
}

TEST(GltfFile, SaysWhatIsWrongWithTheFileItself) {
    const TemporaryFolder folder;
    expect_message(failure_of_file(folder.path() / "none.glb"), "none.glb: there is no such file");
    expect_message(failure_of_file(folder.path()), "is a folder");
    expect_message(failure_of_file("/dev/null"), "is no ordinary file");
    expect_message(failure_of(""), "is empty");
    expect_message(failure_of("solid cube\nfacet normal 0 0 1\n"), "is neither .gltf nor .glb");
    expect_message(failure_of(" \n\t "), "is neither .gltf nor .glb");
    expect_message(failure_of("{\"asset\": \n{\"version\": \n oops"), "is no valid glTF");
    expect_message(failure_of("{}"), "is no valid glTF");
    expect_message(failure_of("glTF"), "is truncated: 4 bytes");
}

TEST(GltfFile, RefusesOtherVersions) {
    GltfBuilder builder = one_triangle();
    builder.asset = R"({"version": "1.0"})";
    expect_failure(builder, "is glTF version '1.0'");
    std::string glb = one_triangle().glb();
    glb[4] = 1;
    expect_message(failure_of(glb), "is .glb version 1");
}

TEST(GltfFile, EveryTruncationOfABinaryFileIsRefused) {
    const std::string glb = one_triangle().glb();
    for (std::size_t size = 0; size < glb.size(); ++size) {
        const std::string message = failure_of(glb.substr(0, size));
        EXPECT_TRUE(message.find("is truncated") != std::string::npos || size < 4) << message;
    }
}

TEST(GltfFile, BinaryChunksMustLieWithinTheFile) {
    const std::string glb = one_triangle().glb();
    const auto with_number = [&](std::size_t offset, std::size_t value) {
        std::string bytes = glb;
        bytes.replace(offset, 4, uint32_bytes(value));
        return bytes;
    };
    const std::size_t binary_chunk = glb.size() - 36 - 8;
    expect_message(failure_of(with_number(12, glb.size())),
                   "is damaged: the .glb chunk at byte 12");
    expect_message(failure_of(with_number(12, 0xffffffff)), "is damaged");
    // Longer by the chunk's own header: within the file's length, but eight bytes too many.
    expect_message(failure_of(with_number(binary_chunk, 36 + 8)), "is damaged");
    expect_message(failure_of(with_number(8, 12)), "first .glb chunk is no JSON");
    expect_message(failure_of(with_number(16, 0x12345678)), "first .glb chunk is no JSON");
}

TEST(GltfFile, DeeplyNestedJsonIsRefusedBeforeItIsParsed) {
    const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
    expect_message(failure_of(R"({"asset": {"version": "2.0"}, "extras": )" + deep + "}"),
                   "nests its JSON deeper than 100");
}

TEST(GltfFile, WrongTypesInTheJsonAreRefusedOrHarmless) {
    // The message is one line whatever tinygltf or its JSON library says.
    for (const std::string members :
         {R"("buffers": [3])", R"("buffers": [{"byteLength": "many"}])", R"("meshes": [null])",
          R"("meshes": [{"primitives": [7]}])", R"("nodes": ["a"])", R"("accessors": [{}])",
          R"("meshes": {"primitives": []})", R"("buffers": [{"byteLength": 0, "uri": ""}])",
          R"("nodes": [{"matrix": ["a"], "children": {"b": 1}}], "scenes": [[]])",
          R"("bufferViews": [{"buffer": 0.5, "byteLength": 1e30}])",
          R"("images": [{"uri": "a", "bufferView": 0}])", R"("scene": "first")"}) {
        const std::string text = R"({"asset": {"version": "2.0"}, )" + members + "}";
        EXPECT_NE(failure_of(text), "") << text;
    }
}

TEST(GltfFile, ALongDataUriIsNotRepeatedInTheMessage) {
    GltfBuilder builder = one_triangle();
    builder.buffer.resize(100'000);
    std::string text = builder.gltf();
    text.replace(text.find("\"byteLength\": 100000"), 20, "\"byteLength\": 100001");
    expect_message(failure_of(text), "..."); // failure_of checks the length
}

TEST(GltfFile, RequiredExtensionsThatWeLackAreNamed) {
    GltfBuilder builder = one_triangle();
    for (const char *fine : {"KHR_mesh_quantization", "KHR_materials_unlit",
                             "KHR_materials_clearcoat", "KHR_texture_transform"}) {
        builder.more = R"("extensionsRequired": [")" + std::string(fine) + "\"], ";
        EXPECT_EQ(load(builder).surface.triangles.size(), 1U) << fine;
    }
    for (const char *lacking : {"EXT_meshopt_compression", "KHR_texture_basisu"}) {
        builder.more = R"("extensionsRequired": [")" + std::string(lacking) + "\"], ";
        expect_failure(builder, "needs the extension '" + std::string(lacking) + "'");
    }
}

TEST(GltfFile, ExtensionsAndAnimationsLeftOutAreRemarkedOn) {
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsUsed": ["EXT_mesh_gpu_instancing"], "animations": [{}, {}], )";
    const Scene scene = load(builder);
    EXPECT_TRUE(has_remark(scene, "extension 'EXT_mesh_gpu_instancing' is left out"));
    EXPECT_TRUE(has_remark(scene, "2 animation(s) are not played"));
}

using gltf::adapted_to_tinygltf;
using gltf::check_byte_offsets;
using gltf::json_nesting_depth;

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
    const std::string text = adapted_to_tinygltf(
        R"({"meshes": [{"primitives": [{"indices": 7, "mode": 4},
            {"indices": 8, "extensions": {"KHR_draco_mesh_compression": {}}}]}]})");
    EXPECT_NE(text.find("\"indices\":7"), std::string::npos) << text;
    EXPECT_EQ(text.find("\"indices\":8"), std::string::npos) << text;
}

TEST(GltfJson, SkinsGo) {
    EXPECT_EQ(adapted_to_tinygltf(R"({"skins":[{"joints":[0]}],"nodes":[]})"), R"({"nodes":[]})");
}

TEST(GltfJson, WhatIsNoGltfComesBackAsItIs) {
    for (const std::string text : {"{\"meshes\": [", "[1, 2]", "{\"meshes\":3}", ""}) {
        EXPECT_EQ(adapted_to_tinygltf(text), text);
    }
    EXPECT_EQ(adapted_to_tinygltf(R"({"meshes":[3,{"primitives":[4,{"extensions":5}]}]})"),
              R"({"meshes":[3,{"primitives":[4,{"extensions":5}]}]})");
}

} // namespace
} // namespace springdrive::scene
