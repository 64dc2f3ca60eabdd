// Covers app/study/participant/participant_view.cpp, participant_scene.cpp.
//
// With SPRINGDRIVE_PICTURES set to a folder, all pictures are written there, to be looked at.
#include "app/study/participant/participant_view.h"
#include "engine/scene/gltf.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/support/devices.h"
#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>
#include <stb/stb_image_write.h>

#include <cstdlib>
#include <memory>

namespace springdrive::app::study_screen {
namespace {

class ParticipantPixels : public ::testing::Test {
protected:
    static void SetUpTestSuite() { hidden_window = std::make_unique<testing::HiddenWindow>(); }
    static void TearDownTestSuite() { hidden_window.reset(); }

    static std::vector<std::uint8_t> drawn(const ParticipantPicture &picture, int width = 640,
                                           int height = 360) {
        ParticipantView view;
        view.draw(picture, width, height);
        return view.pixels();
    }

    inline static std::unique_ptr<testing::HiddenWindow> hidden_window;
};

TEST_F(ParticipantPixels, ShowLettersOfEveryAlphabetAndABoxForOthers) {
    const auto of_text = [](const char *text) {
        ParticipantPicture picture;
        picture.heading = text;
        return drawn(picture);
    };
    const auto box = of_text("漢");
    EXPECT_NE(box, of_text(""));
    EXPECT_EQ(box, of_text("字")); // the font lacks both
    for (const char *letter : {"ä", "ß", "Ω", "Ж"}) {
        EXPECT_NE(of_text(letter), box) << letter;
        EXPECT_NE(of_text(letter), of_text("")) << letter;
    }
}

TEST_F(ParticipantPixels, AreThoseOfThePictureWhateverWasDrawnBefore) {
    const auto pictures = pictures_of_a_sitting();
    ParticipantView used;
    for (const auto &[name, picture] : pictures) {
        if (picture.scene == SceneShown::scene) {
            continue; // needs one, see below
        }
        used.draw(picture, 640, 360);
        EXPECT_EQ(used.pixels(), drawn(picture)) << name;
    }
    used.draw(pictures.at(1).second, 1280, 720); // another size, and back
    used.draw(pictures.at(0).second, 640, 360);
    EXPECT_EQ(used.pixels(), drawn(pictures.at(0).second));
}

TEST_F(ParticipantPixels, OfProgressFillFromTheLeft) {
    ParticipantPicture picture;
    std::vector<std::vector<std::uint8_t>> seen;
    for (const double share : {0.0, 0.5, 1.0}) {
        picture.progress = share;
        seen.push_back(drawn(picture));
        for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
            EXPECT_NE(seen[i], seen.back());
        }
    }
}

void write(const ParticipantView &view, const std::string &file, int width, int height) {
    const std::vector<std::uint8_t> pixels = view.pixels();
    ASSERT_NE(stbi_write_png(file.c_str(), width, height, 3, pixels.data(), 3 * width), 0) << file;
}

TEST_F(ParticipantPixels, OfTheSceneShowBallAndRingAndAreTheSameEachTime) {
    const scene::Scene card =
        scene::load_gltf(std::string(SPRINGDRIVE_ASSET_DIR) + "/scenes/plate.gltf",
                         testing::phantom_1_0().workspace);
    const Vector3 middle_m = 0.5 * (card.lower_m + card.upper_m);
    const Vector3 spot_m(middle_m.x(), card.upper_m.y(), middle_m.z());
    auto pictures = pictures_of_a_sitting();
    ParticipantView view;
    view.set_scene(card, {spot_m, Vector3::UnitY()}, -0.1);
    const char *const folder = std::getenv("SPRINGDRIVE_PICTURES");
    for (auto &[name, picture] : pictures) {
        if (picture.tip_m) {
            picture.tip_m = spot_m + Vector3(0.0, 0.012, 0.0);
        }
        for (const int height : {720, 1080, 1440}) {
            if (folder != nullptr) {
                view.draw(picture, height * 16 / 9, height);
                write(view,
                      std::string(folder) + "/" + name + "_" + std::to_string(height) + ".png",
                      height * 16 / 9, height);
            }
        }
    }
    ParticipantPicture picture = pictures.at(6).second;
    view.draw(picture, 640, 360);
    const auto with_ball = view.pixels();
    picture.tip_m.reset();
    view.draw(picture, 640, 360);
    EXPECT_NE(view.pixels(), with_ball);
    ParticipantView other;
    other.set_scene(card, {spot_m, Vector3::UnitY()}, -0.1);
    other.draw(pictures.at(6).second, 640, 360);
    EXPECT_EQ(other.pixels(), with_ball);
    other.set_scene(card, {spot_m + Vector3(0.01, 0.0, 0.0), Vector3::UnitY()}, -0.1);
    other.draw(pictures.at(6).second, 640, 360);
    EXPECT_NE(other.pixels(), with_ball);
}

} // namespace
} // namespace springdrive::app::study_screen
