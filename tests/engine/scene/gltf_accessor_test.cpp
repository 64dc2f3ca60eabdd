#include "engine/scene/gltf_accessor.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

/// A triangle whose position accessor and buffer view are given in full.
GltfBuilder with_positions(const std::string &accessor, const std::string &view = "") {
    GltfBuilder builder = one_triangle();
    builder.accessors = {accessor};
    if (!view.empty()) {
        builder.views = {view};
    }
    return builder;
}

TEST(GltfAccessor, InterleavedVerticesAreReadByTheirStride) {
    GltfBuilder builder = one_triangle();
    const std::vector<float> interleaved = {9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 2, 3};
    builder.add_view({reinterpret_cast<const char *>(interleaved.data()), 48},
                     R"(, "byteStride": 16)");
    builder.accessors = {R"({"bufferView": 1, "byteOffset": 4, "componentType": 5126, "count": 3,
                             "type": "VEC3"})"};
    const auto vertices = load(builder).surface.vertices_m;
    EXPECT_EQ(vertices[0], Vector3(0, 0, 0));
    EXPECT_EQ(vertices[1], Vector3(1, 0, 0));
    EXPECT_EQ(vertices[2], Vector3(0, 2, 3));
}

TEST(GltfAccessor, SparseValuesReplaceThoseOfTheView) {
    GltfBuilder builder = one_triangle();
    builder.add_accessor(std::vector<std::uint16_t>{2}, kUnsignedShort, "SCALAR");
    builder.add_accessor(std::vector<float>{0.0F, 0.75F, 0.5F}, kFloat, "VEC3");
    const std::string sparse = R"("sparse": {"count": 1,
        "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}}})";
    builder.accessors[0] =
        R"({"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", )" + sparse;
    const auto vertices = load(builder).surface.vertices_m;
    EXPECT_EQ(vertices[1], Vector3(0.5, 0, 0));
    EXPECT_EQ(vertices[2], Vector3(0, 0.75, 0.5));

    builder.accessors[0] = R"({"componentType": 5126, "count": 3, "type": "VEC3", )" + sparse;
    const auto from_zero = load(builder).surface.vertices_m;
    EXPECT_EQ(from_zero[1], Vector3(0, 0, 0));
    EXPECT_EQ(from_zero[2], Vector3(0, 0.75, 0.5));
}

TEST(GltfAccessor, RefusesSparsePartsThatReachOutside) {
    const auto failing = [](const std::string &sparse, const std::string &message) {
        GltfBuilder builder = one_triangle();
        builder.add_accessor(std::vector<std::uint16_t>{3}, kUnsignedShort, "SCALAR");
        builder.accessors[0] = R"({"componentType": 5126, "count": 3, "type": "VEC3",
            "sparse": )" + sparse +
                               "}";
        expect_failure(builder, message);
    };
    const auto sparse = [](const std::string &count, const std::string &indices,
                           const std::string &values) {
        return R"({"count": )" + count + R"(, "indices": {)" + indices + R"(}, "values": {)" +
               values + "}}";
    };
    const std::string indices = R"("bufferView": 1, "componentType": 5123)";
    const std::string values = R"("bufferView": 0)";
    failing(sparse("1", indices, values), "sparse index 3 is beyond its 3 elements");
    failing(sparse("4", indices, values), "impossible count");
    failing(sparse("-1", indices, values), "impossible count");
    failing(sparse("2", indices, values), "reach beyond buffer view 1");
    failing(sparse("1", indices + R"(, "byteOffset": -2)", values),
            "sparse indices: its byteOffset is -2");
    failing(sparse("1", R"("bufferView": 1, "componentType": 5126)", values), "impossible count");
    failing(sparse("1", indices, R"("bufferView": 7)"), "buffer view 7 is not in the file");
}

TEST(GltfAccessor, RefusesWhatReachesOutsideItsView) {
    const auto accessor = [](const std::string &count, const std::string &offset) {
        return R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" + count +
               R"(, "byteOffset": )" + offset + "}";
    };
    EXPECT_EQ(load(with_positions(accessor("3", "0"))).surface.triangles.size(), 1U);
    expect_failure(with_positions(accessor("4", "0")), "reach beyond buffer view 0 of 36 bytes");
    expect_failure(with_positions(accessor("3", "1")), "reach beyond buffer view 0");
    expect_failure(with_positions(accessor("1", "37")), "reach beyond buffer view 0");
    expect_failure(with_positions(accessor("3", "18446744073709551600")), "reach beyond");
    // 3 × 12 bytes more than 2⁶⁴ would wrap around to 36.
    expect_failure(with_positions(accessor("1537228672809129305", "0")),
                   "1537228672809129305 vertices");
    expect_failure(with_positions(accessor("20000000", "0")), "reach beyond buffer view 0");
}

TEST(GltfAccessor, RefusesViewsThatReachOutsideTheirBuffer) {
    const std::string accessor =
        R"({"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3})";
    const auto view = [](const std::string &members) { return "{" + members + "}"; };
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 37)")),
                   "buffer view 0: 37 bytes from 0 reach beyond buffer 0 of 36 bytes");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteOffset": 1,
                                                    "byteLength": 36)")),
                   "reach beyond buffer 0");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteOffset": 18446744073709551600)")),
                   "reach beyond buffer 0");
    expect_failure(with_positions(accessor, view(R"("buffer": 1, "byteLength": 36)")),
                   "buffer 1 is not in the file");
    expect_failure(with_positions(accessor, view(R"("buffer": -1, "byteLength": 36)")),
                   "buffer -1 is not in the file");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteStride": 8)")),
                   "take 12 bytes, but stand 8 apart");
    expect_failure(with_positions(accessor, view(R"("buffer": 0, "byteLength": 36,
                                                    "byteStride": 16)")),
                   "reach beyond buffer view 0");
}

TEST(GltfAccessor, RefusesComponentTypesThatAttributesCannotHave) {
    for (const char *type : {"5124", "5125", "5127", "5130"}) {
        const std::string message = failure_of(
            with_positions(R"({"bufferView": 0, "type": "VEC3", "count": 3, "componentType": )" +
                           std::string(type) + "}"));
        EXPECT_NE(message.find("accessor 0"), std::string::npos) << message;
    }
    expect_failure(with_positions(R"({"bufferView": 0, "type": "SCALAR", "count": 3,
                                      "componentType": 5126})"),
                   "a vertex attribute is a vector");
    expect_failure(with_positions(R"({"bufferView": 0, "type": "MAT2", "count": 2,
                                      "componentType": 5126})"),
                   "a vertex attribute is a vector");
}

} // namespace
} // namespace springdrive::scene
