#include "engine/scene/gltf_uri.h"

#include "tests/engine/scene/gltf_builder.h"

namespace springdrive::scene {
namespace {

std::string text_of(const gltf::Bytes &bytes) { return {bytes.begin(), bytes.end()}; }

template <typename Step> std::string refusal_of(Step &&step) {
    try {
        step();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

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
    EXPECT_EQ(refusal_of([] { (void)gltf::decode_data_uri("data:;base64"); }),
              "is damaged: it has no comma; export it again");
    EXPECT_EQ(refusal_of([] { (void)gltf::decode_data_uri("data:;base64,AA=A"); }),
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
                                             {"link.bin", by_link},
                                             {"dead.bin", by_link},
                                             {"up/secret.bin", by_link},
                                             {"up/none.bin", by_link}}) {
        EXPECT_EQ(refusal_of([&] { (void)gltf::read_uri(one.uri, folders.scene(), 100); }), one.why)
            << one.uri;
    }
    EXPECT_EQ(refusal_of([&] { (void)gltf::read_uri(absolute, folders.scene(), 100); }),
              not_relative);
}

TEST(GltfUri, WhatIsNoFileIsRefused) {
    const Folders folders;
    EXPECT_EQ(refusal_of([&] { (void)gltf::read_uri("textures", folders.scene(), 9); }),
              "cannot be read: it is no ordinary file");
    EXPECT_EQ(refusal_of([&] { (void)gltf::read_uri("none.png", folders.scene(), 9); }),
              "cannot be read: there is no such file");
}

} // namespace
} // namespace springdrive::scene
