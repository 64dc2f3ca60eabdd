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
    EXPECT_EQ(line_of_failure(text), "buffer 0: its data: URI has 100000 bytes, but its byteLength "
                                     "is 100001; copy or export it again");
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

TEST(GltfFile, OnlyABuffersOwnBytesAreReadOfALongerFile) {
    const GltfBuilder builder = one_triangle();
    const TemporaryFolder folder;
    folder.write("long.bin", builder.buffer + "and more");
    const auto file = folder.write("scene.gltf", builder.json("long.bin"));
    EXPECT_EQ(load_gltf(file, small_workspace()).surface.triangles.size(), 1U);
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

TEST(GltfFile, RefusedFilesAreToldWhatIsWrongAndWhere) {
    for (const Refused &file : refused_files()) {
        EXPECT_EQ(line_of_failure(file.text), file.line) << file.what;
    }
}

} // namespace
} // namespace springdrive::scene
