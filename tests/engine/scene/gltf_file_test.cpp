// Covers engine/scene/gltf_file.cpp and gltf_json.cpp.
#include "engine/scene/gltf_file.h"

#include "base/input_error.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"
#include "tests/engine/contact/mesh/soups.h"
#include "tests/engine/scene/gltf_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace springdrive::scene {
namespace {

void expect_message(const std::string &message, const std::string &part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

std::string failure_of_file(const std::filesystem::path &file) {
    return error_text_of([&file] { (void)load_gltf(file, small_workspace()); });
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
    folder.write("my data.bin", builder.buffer + "and more");
    const auto file = folder.write("scene.gltf", builder.json("my%20data.bin"));
    const auto relative = std::filesystem::relative(file, std::filesystem::current_path());
    for (const std::filesystem::path &path : {file, relative}) {
        EXPECT_EQ(load_gltf(path, small_workspace()).surface.triangles.size(), 1U);
    }
    const auto binary = folder.write("empty.gltf", builder.json("absent.bin"));
    expect_message(failure_of_file(binary), "absent.bin");
    folder.write("short.bin", "abc");
    const auto mismatch = folder.write("mismatch.gltf", builder.json("short.bin"));
    expect_message(failure_of_file(mismatch), "short.bin");
    const auto a_folder = folder.write("folder.gltf", builder.json("."));
    EXPECT_NE(failure_of_file(a_folder), "");
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
    expect_message(failure_of(with_number(4, 1)), "is .glb version 1");
    expect_message(failure_of(with_number(8, 12)), "first .glb chunk is no JSON");
    expect_message(failure_of(with_number(16, 0x12345678)), "first .glb chunk is no JSON");
}

TEST(GltfFile, DeeplyNestedJsonIsRefusedBeforeItIsParsed) {
    const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
    expect_message(failure_of(R"({"asset": {"version": "2.0"}, "extras": )" + deep + "}"),
                   "nests its JSON deeper than 100");
    using gltf::json_nesting_depth; // which counts brackets outside of strings only
    EXPECT_EQ(json_nesting_depth(R"({"a": [{"b": []}, {}], "c": []})"), 4U);
    EXPECT_EQ(json_nesting_depth(R"({"[[[[\"[[[[": "{{{{"})"), 1U);
    EXPECT_EQ(json_nesting_depth("]]]]{\"\\"), 1U);
}

TEST(GltfFile, WrongTypesInTheJsonAreRefusedInOneLine) {
    for (const std::string members :
         {R"("buffers": [3])", R"("buffers": [{"byteLength": "many"}])", R"("meshes": [null])",
          R"("meshes": [{"primitives": [7]}])", R"("nodes": ["a"])", R"("accessors": [{}])",
          R"("buffers": [{"byteLength": 0, "uri": ""}])", R"("scene": "first")",
          R"("nodes": [{"matrix": ["a"], "children": {"b": 1}}], "scenes": [[]])",
          R"("bufferViews": [{"buffer": 0.5, "byteLength": 1e30}])",
          R"("images": [{"uri": "a", "bufferView": 0}])"}) {
        EXPECT_NE(failure_of(R"({"asset": {"version": "2.0"}, )" + members + "}"), "") << members;
    }
}

/// Files as other programs make them: valid, and more than the least that glTF asks for.
struct Accepted {
    const char *what;
    std::string text;
    std::size_t triangles;
};

std::vector<Accepted> accepted_files() {
    std::vector<Accepted> files;
    const auto add = [&](const char *what, const GltfBuilder &builder) {
        files.push_back({what, builder.gltf(), 1});
    };
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsUsed": ["KHR_animation_pointer"], "animations": [{"channels": [
        {"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer":
        {"pointer": "/nodes/0/translation"}}}}], "samplers": [{"input": 0, "output": 0}]}], )";
    add("an animation by KHR_animation_pointer", builder);
    builder = one_triangle();
    builder.accessors.emplace_back(R"({"componentType": 5123, "count": 3, "type": "SCALAR"})");
    builder.nodes.emplace_back(R"({"mesh": 1})");
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 1)");
    files.push_back({"indices without a buffer view are zeros", builder.gltf(), 2});
    builder = one_triangle();
    builder.add_accessor(std::vector<std::uint16_t>{1, 2}, kUnsignedShort, "SCALAR"); // 1, view 1
    builder.accessors.emplace_back(R"({"componentType": 5123, "count": 3, "type": "SCALAR",
        "sparse": {"count": 2, "indices": {"bufferView": 1, "componentType": 5123},
                   "values": {"bufferView": 1}}})");
    builder.meshes.clear();
    builder.add_mesh(R"("attributes": {"POSITION": 0}, "indices": 2)");
    add("sparse indices without a buffer view", builder);
    builder = one_triangle();
    std::string text =
        builder.json("data:application/octet-stream," + percent_encoded(builder.buffer));
    files.push_back({"a data URI that is percent-encoded", text, 1});
    text = builder.json("DATA:;BASE64," + to_base64(builder.buffer));
    files.push_back({"a data URI without a media type", text, 1});
    text = builder.json("data:;base64," + to_base64(builder.buffer + "more"));
    files.push_back({"a data URI longer than its buffer", text, 1});
    text = builder.gltf();
    text.replace(text.find(R"("buffers": [)"), 12,
                 R"("buffers": [ )"); // a second buffer behind the first
    text.insert(text.find("}]", text.find("\"buffers\"")) + 1, R"(, {"byteLength": 8})");
    files.push_back({"a buffer without uri that nothing refers to", text, 1});
    text = builder.gltf();
    text.insert(1, R"("extensions": [3], "extras": {"byteOffset": -4}, )");
    files.push_back({"members of other programs", text, 1});
    text = builder.gltf();
    text.replace(text.find("\"count\": 3"), 10, "\"count\": 3.0");
    files.push_back({"whole numbers with a fraction of zero", text, 1});
    return files;
}

TEST(GltfFile, ValidFilesOfOtherProgramsLoad) {
    for (const Accepted &file : accepted_files()) {
        try {
            EXPECT_EQ(load_bytes(file.text).surface.triangles.size(), file.triangles) << file.what;
        } catch (const InputError &error) {
            ADD_FAILURE() << file.what << ": " << error.what();
        }
    }
}

TEST(GltfFile, TheBinaryChunkIsTheFirstBuffersOnly) {
    GltfBuilder builder = one_triangle();
    builder.views[0].replace(builder.views[0].find("\"buffer\": 0"), 11, "\"buffer\": 1");
    std::string glb = builder.glb();
    const std::string one = R"("buffers": [{"byteLength": 36}])";
    const std::string two = R"("buffers": [{"byteLength": 36}, {"byteLength": 36}])";
    const std::size_t length = glb.size();
    glb.replace(glb.find(one), one.size(), two);
    std::string json = glb.substr(20, glb.find(std::string("BIN\0", 4)) - 24);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    glb = "glTF" + uint32_bytes(2) + uint32_bytes(20 + json.size() + 8 + 36) +
          uint32_bytes(json.size()) + "JSON" + json + uint32_bytes(36) + std::string("BIN\0", 4) +
          builder.buffer;
    EXPECT_GT(glb.size(), length);
    EXPECT_EQ(line_of_failure(glb), "node 0: buffer view 0: buffer 1 has no uri, so the file does "
                                    "not say where its bytes are");
}

struct Refused {
    const char *what;
    std::string text;
    std::string line;
};

std::vector<Refused> refused_files() {
    std::vector<Refused> files;
    const auto add = [&](const char *what, const std::string &members, const std::string &line) {
        files.push_back({what, R"({"asset": {"version": "2.0"}, )" + members + "}", line});
    };
    const auto with_uri = [&](const char *what, const std::string &uri, const std::string &line) {
        files.push_back({what, one_triangle().json(uri), "buffer 0: " + line});
    };
    add("an object for an array", R"("meshes": {"primitives": []})",
        R"(its meshes is {"primitives":[]}; it must be an array of objects)");
    add("an object for an array within", R"("nodes": [{}, {"children": {"b": 1}}])",
        R"(node 1: its children is {"b":1}; it must be an array of whole numbers)");
    add("a primitive that is none", R"("meshes": [{"primitives": [{"attributes": {}}, 7]}])",
        "mesh 0: primitive 1 is 7; it must be an object");
    add("an infinite colour",
        R"("materials": [{}, {"pbrMetallicRoughness": {"baseColorFactor": [0, 1e999, 0, 1]}}])",
        "materials[1].pbrMetallicRoughness.baseColorFactor[1] is 1e999; it must be a number that "
        "is finite in double precision");
    add("no JSON", R"("nodes": [{]})",
        "is no valid glTF: parse error at line 1, column 42: syntax error while parsing object key "
        "- unexpected ']'; expected string literal");
    const auto with_offset = [&](const std::string &offset, const std::string &line) {
        add("an offset",
            R"("accessors": [{"componentType": 5126, "count": 1, "type": "VEC3", )" + offset + "}]",
            "accessor 0: " + line);
    };
    with_offset(R"("byteOffset": 4.5)", "its byteOffset is 4.5; it must be a whole number from 0");
    with_offset(R"("byteOffset": "4")",
                R"(its byteOffset is "4"; it must be a whole number from 0)");
    with_offset(R"("byteOffset": null)",
                "its byteOffset is null; it must be a whole number from 0");
    with_offset(R"("sparse": {"count": 1, "indices": {"bufferView": 0, "componentType": 5121},
                              "values": {"bufferView": 0, "byteOffset": -1}})",
                "sparse: values: its byteOffset is -1; it must be a whole number from 0 to "
                "2147483647");
    add("a stride", R"("bufferViews": [{"buffer": 0, "byteLength": 4, "byteStride": -12}])",
        "buffer view 0: its byteStride is -12; it must be a whole number from 0");
    add("no length", R"("buffers": [{}])", "buffer 0 has no byteLength");
    add("an index that wraps around", R"("nodes": [{"mesh": 4294967296}])",
        "node 0: its mesh is 4294967296; it must be a whole number of 32 bits");
    with_uri("a missing file", "absent%20one.bin",
             "'absent one.bin' cannot be read: there is no such file");
    with_uri("base64 that is none", "data:;base64,AAAA*AAA",
             "its data: URI is damaged: character 5 of its data is no base64 digit; export it "
             "again");
    with_uri("too short a data URI", "data:,abc",
             "its data: URI has 3 bytes, but its byteLength is 36; copy or export it again");
    return files;
}

TEST(GltfJson, NumbersBeyondDoublesAreNamedByTheirPlace) {
    EXPECT_EQ(
        line_of_failure(R"({"asset": {"version": "2.0"}, "a": {"b": [1, [2], {"c": -1e400}]}})"),
        "a.b[2].c is -1e400; it must be a number that is finite in double precision");
}

TEST(GltfFile, RefusedFilesAreToldWhatIsWrongAndWhere) {
    EXPECT_EQ(line_of_failure("{}"), "is no valid glTF: it has no asset");
    for (const Refused &file : refused_files()) {
        EXPECT_EQ(line_of_failure(file.text), file.line) << file.what;
    }
}

GltfBuilder requiring(const std::string &extension) {
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsRequired": [")" + extension + "\"], ";
    return builder;
}

TEST(GltfExtensions, ThoseWithoutEffectOnTheShapeMayBeRequired) {
    for (const char *fine :
         {"KHR_mesh_quantization", "KHR_materials_unlit", "KHR_materials_clearcoat",
          "KHR_texture_transform", "KHR_animation_pointer", "EXT_meshopt_compression",
          "KHR_meshopt_compression", "EXT_mesh_gpu_instancing"}) {
        EXPECT_EQ(load(requiring(fine)).surface.triangles.size(), 1U) << fine;
    }
}

TEST(GltfExtensions, OthersThatAreRequiredAreNamed) {
    for (const std::string lacking :
         {"KHR_texture_basisu2", "KHR_materials_", "KHR_materials_velvet", "KHR_materials_unlit2",
          "KHR_node_visibility", ""}) {
        EXPECT_EQ(line_of_failure(requiring(lacking).gltf()),
                  "needs the extension '" + lacking +
                      "', which is not supported; export it without");
    }
}

TEST(GltfExtensions, ThoseThatConcernOnlyLooksAreLeftOutThoughRequired) {
    for (const std::string looks :
         {"EXT_texture_webp", "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds",
          "KHR_materials_pbrSpecularGlossiness", "KHR_techniques_webgl"}) {
        GltfBuilder builder = requiring(looks);
        const std::string own =
            R"({"extensions": {")" + looks + R"(": {"source": 0, "index": 0}}})";
        builder.materials = {own,
                             R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})"};
        builder.textures = {own};
        builder.images = {R"({"uri": "none.ktx2", "mimeType": "image/ktx2"})"};
        builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "material": 0},
                                             {"attributes": {"POSITION": 0}, "material": 1}]})"};
        builder.more += R"("extensionsUsed": [")" + looks + "\"], ";
        const Scene scene = load(builder);
        EXPECT_EQ(scene.surface.triangles.size(), 2U) << looks;
        ASSERT_EQ(scene.meshes.size(), 2U) << looks;
        EXPECT_EQ(scene.meshes[1].texture, -1) << looks;
        EXPECT_EQ(std::ranges::count(scene.warnings, "extension '" + looks + "' is left out"), 1);
    }
}

TEST(GltfExtensions, WhatIsLeftOutIsWarnedOf) {
    GltfBuilder builder = one_triangle();
    builder.more = R"("extensionsUsed": ["KHR_node_visibility", "KHR_materials_velvet"],
                      "animations": [{}, {}], )";
    const Scene scene = load(builder);
    EXPECT_TRUE(has_warning(scene, "extension 'KHR_node_visibility' is left out"));
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

std::string text_of(const gltf::Bytes &bytes) { return {bytes.begin(), bytes.end()}; }

TEST(GltfUri, DataInBase64OrPercentEncodedComeOutAlike) {
    const std::string bytes("\0\x01 any%\xff\"bytes", 13);
    for (std::size_t length = 0; length <= bytes.size(); ++length) {
        const std::string part = bytes.substr(0, length);
        EXPECT_EQ(text_of(gltf::decode_data_uri("data:;base64," + to_base64(part))), part);
        EXPECT_EQ(
            text_of(gltf::decode_data_uri("data:text/plain;charset=x," + percent_encoded(part))),
            part);
    }
    EXPECT_EQ(text_of(gltf::decode_data_uri("data:;base64,YQ%3D%3D")), "a"); // an encoded '='
    EXPECT_EQ(text_of(gltf::decode_data_uri("data:;base64,YQ")), "a");
    EXPECT_EQ(text_of(gltf::decode_data_uri("data:,100%,%4")), "100%,%4");
}

TEST(GltfUri, DamagedDataAreRefused) {
    EXPECT_EQ(error_text_of([] { (void)gltf::decode_data_uri("data:;base64"); }),
              "is damaged: it has no comma; export it again");
    EXPECT_EQ(error_text_of([] { (void)gltf::decode_data_uri("data:;base64,AA=A"); }),
              "is damaged: character 3 of its data is no base64 digit; export it "
              "again");
}

/// A folder with a scene's folder in it, and a file in each.
class Folders : public TemporaryFolder {
public:
    Folders() {
        std::filesystem::create_directories(scene() / "textures");
        write("secret.bin", "secret");
        write("scene/data.bin", "data");
        write("scene/textures/wood.png", "wood");
    }
    [[nodiscard]] std::filesystem::path scene() const { return path() / "scene"; }
};

TEST(GltfUri, FilesWithinTheScenesFolderAreRead) {
    const Folders folders;
    for (const auto &[uri, bytes] :
         std::vector<std::pair<std::string, std::string>>{{"data.bin", "data"},
                                                          {"./data.bin", "data"},
                                                          {"textures/../data.bin", "data"},
                                                          {"textures/wood.png", "wood"},
                                                          {"textures/%77ood.png", "wood"}}) {
        EXPECT_EQ(text_of(gltf::read_uri(uri, folders.scene(), 100)), bytes) << uri;
    }
    EXPECT_EQ(text_of(gltf::read_uri("data.bin", folders.scene(), 3)), "dat");
}

TEST(GltfUri, TheOnlyFileThatAUriCanMeanIsRead) {
    const Folders folders;
    folders.write("scene/part%20one.bin", "percent");
    folders.write("scene/textures/back\\slash.bin", "backslash");
    struct Case {
        std::string uri;
        std::string bytes;
        std::string file; ///< that a warning names; empty: no warning
    };
    for (const Case &one :
         std::vector<Case>{{"textures\\wood.png", "wood", "textures/wood.png"},
                           {".\\textures\\..\\data.bin", "data", "data.bin"},
                           {"Textures/WOOD.PNG", "wood", "textures/wood.png"},
                           {"TEXTURES\\%77OOD.png", "wood", "textures/wood.png"},
                           {"part%20one.bin", "percent", "part%20one.bin"},
                           {"PART%20one.bin", "percent", "part%20one.bin"},
                           {"part%2520one.bin", "percent", ""}, // as RFC 3986 has it
                           {"textures/back\\slash.bin", "backslash", ""},
                           {"textures/wood.png", "wood", ""}}) {
        WarningList warnings;
        EXPECT_EQ(text_of(gltf::read_uri(one.uri, folders.scene(), 100, &warnings)), one.bytes)
            << one.uri;
        ASSERT_EQ(warnings.lines().size(), one.file.empty() ? 0U : 1U) << one.uri;
        if (!one.file.empty()) {
            expect_message(warnings.lines().front(), " is read from '" + one.file + "'");
        }
    }
    // A file of just that name comes before all others.
    folders.write("scene/part one.bin", "blank");
    EXPECT_EQ(text_of(gltf::read_uri("part%20one.bin", folders.scene(), 100)), "blank");
    folders.write("scene/DATA.bin", "capitals");
    EXPECT_EQ(text_of(gltf::read_uri("data.bin", folders.scene(), 100)), "data");
    const std::string several =
        error_text_of([&] { (void)gltf::read_uri("Data.bin", folders.scene(), 100); });
    expect_message(several, "'DATA.bin' and 'data.bin'");
    expect_message(several, "there is no such file");
}

TEST(GltfUri, LettersThatAreComposedOtherwiseAreNamed) {
    const Folders folders;
    struct Names {
        std::string composed;
        std::string decomposed;
    };
    for (const auto &[composed, decomposed] :
         std::vector<Names>{{"Gr\u00f6\u00dfe.bin", "Gro\u0308\u00dfe.bin"},
                            {"\u01d8\u00e9", "u\u0308\u0301e\u0301"},
                            {"\u0439.bin", "\u0438\u0306.bin"},                          // Cyrillic
                            {"\u304c", "\u304b\u3099"},                                  // kana
                            {"\ud55c\uae00", "\u1112\u1161\u11ab\u1100\u1173\u11af"}}) { // Hangul
        EXPECT_TRUE(gltf::may_be_composed_otherwise(composed, decomposed)) << composed;
        EXPECT_TRUE(gltf::may_be_composed_otherwise(decomposed, composed)) << composed;
        EXPECT_FALSE(gltf::may_be_composed_otherwise(composed, decomposed + "x"));
        EXPECT_FALSE(gltf::may_be_composed_otherwise("x" + composed, decomposed));
        for (const auto &[there, named] :
             {std::pair(composed, decomposed), {decomposed, composed}}) {
            const std::filesystem::path file = folders.write("scene/" + there, "there");
            const std::string message = error_text_of([&, uri = percent_encoded(named)] {
                (void)gltf::read_uri(uri, folders.scene(), 100);
            });
            expect_message(message, "'" + there + "'");
            expect_message(message, "NFD");
            std::filesystem::remove(file);
        }
    }
    EXPECT_FALSE(gltf::may_be_composed_otherwise("o\u0308", "o"));
    EXPECT_FALSE(gltf::may_be_composed_otherwise("\xff\u00f6", "\xffo\u0308")); // no UTF-8
    EXPECT_FALSE(gltf::may_be_composed_otherwise("", "\u0308"));
}

TEST(GltfUri, LinksMayLeadToFilesWithinTheScenesFolder) {
    const Folders folders;
    std::filesystem::create_symlink("textures/wood.png", folders.scene() / "link.png");
    std::filesystem::create_symlink(folders.scene(), folders.path() / "other_name");
    EXPECT_EQ(text_of(gltf::read_uri("link.png", folders.scene(), 100)), "wood");
    EXPECT_EQ(text_of(gltf::read_uri("link.png", folders.path() / "other_name", 100)), "wood");
}

TEST(GltfUri, FilesOutsideAreRefusedAlikeWhetherTheyExistOrNot) {
    const Folders folders;
    std::filesystem::create_symlink(folders.path() / "secret.bin", folders.scene() / "link.bin");
    std::filesystem::create_symlink(folders.path() / "none.bin", folders.scene() / "dead.bin");
    std::filesystem::create_symlink("..", folders.scene() / "up");
    const std::string outside =
        "lies outside the scene's folder and is not read; put the file there";
    const std::string not_relative = "is not relative to the scene's file and is not read; put the "
                                     "file into the scene's folder";
    const std::string by_link =
        "lies outside the scene's folder, by way of a link, and is not read; "
        "put the file there";
    const std::string no_file = "cannot be read: there is no such file";
    const std::string absolute = (folders.path() / "secret.bin").string();
    struct Case {
        std::string uri;
        std::string why;
    };
    for (const Case &one : std::vector<Case>{{"../secret.bin", outside},
                                             {"../none.bin", outside},
                                             {"%2e%2e/secret.bin", outside},
                                             {"textures/../../secret.bin", outside},
                                             {"../scene/data.bin", outside},
                                             {"..", outside},
                                             {"data.bin%00.png", outside},
                                             {"/none.bin", not_relative},
                                             {"file:///etc/passwd", not_relative},
                                             {"http://example.org/a.bin", not_relative},
                                             {"C:\\data.bin", not_relative},
                                             {"\\\\host\\data.bin", not_relative},
                                             {"..\\secret.bin", outside},
                                             {"..\\none.bin", outside},
                                             {"%2e%2e%5csecret.bin", outside},
                                             {"textures\\..\\..\\secret.bin", outside},
                                             {"link.bin", by_link},
                                             {"dead.bin", by_link},
                                             {"up/secret.bin", by_link},
                                             {"up/none.bin", by_link},
                                             {"UP/secret.bin", no_file},
                                             {"UP\\none.bin", no_file}}) {
        EXPECT_EQ(error_text_of([&] { (void)gltf::read_uri(one.uri, folders.scene(), 100); }),
                  one.why)
            << one.uri;
    }
    EXPECT_EQ(error_text_of([&] { (void)gltf::read_uri(absolute, folders.scene(), 100); }),
              not_relative);
}

TEST(GltfUri, WhatIsNoFileIsRefused) {
    const Folders folders;
    EXPECT_EQ(error_text_of([&] { (void)gltf::read_uri("textures", folders.scene(), 9); }),
              "cannot be read: it is no ordinary file");
    EXPECT_EQ(error_text_of([&] { (void)gltf::read_uri("none.png", folders.scene(), 9); }),
              "cannot be read: there is no such file");
}

TEST(LoadProgress, TellsStageAndPercentWhereItIsKnown) {
    LoadProgress progress;
    EXPECT_EQ(progress.text(), "reading the file");
    progress.begin(LoadProgress::Stage::gathering, true);
    EXPECT_EQ(progress.text(), "gathering triangles, 0 %");
    progress.advance_to(0.404);
    EXPECT_EQ(progress.text(), "gathering triangles, 40 %");
    progress.advance_to(1.1);
    EXPECT_EQ(progress.text(), "gathering triangles, 100 %");
    progress.begin(LoadProgress::Stage::preparing, false);
    EXPECT_EQ(progress.text(), "preparing the surface for touch");
    progress.begin(LoadProgress::Stage::measuring, true);
    progress.advance_to(0.1);
    EXPECT_EQ(progress.text(), "measuring models, 10 %");
}

TEST(LoadProgress, LoadingEndsWithEverythingPlaced) {
    const TemporaryFolder folder;
    LoadProgress progress;
    const Scene scene =
        load_gltf(folder.write("scene.gltf", one_triangle().gltf()), small_workspace(), &progress);
    EXPECT_EQ(progress.stage(), LoadProgress::Stage::placing);
    EXPECT_EQ(progress.text(), "placing the scene, 100 %");
    EXPECT_EQ(scene.surface.triangles.size(), 1U);
}

/// A triangle takes 300 bytes and a vertex 220: of 8 GiB, 39,045,155.9 vertices beside one
/// triangle.
TEST(WorkBudget, EndsAtTheStatedMemory) {
    const auto declaring = [](int vertices) {
        GltfBuilder builder = one_triangle();
        builder.add_accessor(std::vector<std::uint8_t>{0, 1, 2}, kUnsignedByte, "SCALAR");
        builder.meshes = {R"({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]})"};
        builder.accessors[0] = R"({"bufferView": 0, "componentType": 5126, "count": )" +
                               std::to_string(vertices) + R"(, "type": "VEC3"})";
        return builder;
    };
    expect_failure(
        declaring(39'045'156),
        "node 0: with it the scene has 1 triangles and 39045156 vertices, "
        "for which loading needs about 8 GiB of memory; at most 8 GiB are allowed: simplify it");
    // Just few enough to look inside.
    expect_failure(declaring(39'045'155), "its 39045155 elements reach beyond buffer view 0");
}

using Lines = std::vector<std::string>;

TEST(WarningList, EqualWarningsOnSeveralThingsAreOneLine) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, "is left out");
    warnings.add("the scene stands still");
    EXPECT_EQ(warnings.lines(), (Lines{"node 'a': is left out", "the scene stands still"}));
    warnings.add_of("node 7", nullptr, "is left out");
    warnings.add_of("image 'a'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines(), (Lines{"nodes 'a', 7: is left out", "the scene stands still",
                                       "image 'a': is left out"}));
    warnings.add_of("node 'b c'", nullptr, "is left out");
    warnings.add_of("node 'd'", nullptr, "is left out");
    warnings.add_of("node 'e'", nullptr, "is left out");
    EXPECT_EQ(warnings.lines().front(), "nodes 'a', 7, 'b c' and 2 more: is left out");
}

TEST(WarningList, NumbersAreAddedUp) {
    WarningList warnings;
    warnings.add_of("node 'a'", nullptr, 3, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"node 'a': 3 points are left out"});
    warnings.add_of("node 'b'", nullptr, 4, "points are left out");
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'a', 'b': 7 points are left out"});
}

TEST(WarningList, PartsOfOneThingCountOnce) {
    WarningList warnings;
    const int a = 0;
    const int b = 0;
    for (const int *identity : {&a, &a, &b, &b}) {
        warnings.add_of("node 'same'", identity, 1, "points are left out");
    }
    EXPECT_EQ(warnings.lines(), Lines{"nodes 'same', 'same': 4 points are left out"});
}

TEST(WarningList, TheNumberOfLinesIsBounded) {
    WarningList warnings;
    for (std::size_t i = 0; i < kMaxWarningLines; ++i) {
        warnings.add(std::to_string(i));
    }
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), std::to_string(kMaxWarningLines - 1));
    warnings.add("one");
    warnings.add("two");
    EXPECT_EQ(warnings.lines().size(), kMaxWarningLines);
    EXPECT_EQ(warnings.lines().back(), "and 3 more remarks");
}

TEST(SceneSurface, NamesTheFileWhoseSurfaceIsTooMuchWork) {
    std::mt19937_64 random(1);
    Scene scene;
    scene.file = "folder/line.glb";
    scene.surface = testing::soup_in_a_line(random, 6000);
    const std::string error = error_text_of([&] { static_cast<void>(haptic_surface_of(scene)); });
    EXPECT_TRUE(error.starts_with("folder/line.glb: preparing its 6000 triangles for touch needs "
                                  "about "))
        << error;
    EXPECT_NE(error.find("; at most 2012 million are allowed: "), std::string::npos) << error;
}

} // namespace
} // namespace springdrive::scene
