// Covers app/study/participant/participant_view.cpp.
#include "app/study/participant/participant_view.h"
#include "engine/scene/gltf.h"
#include "tests/app/study/participant_pictures.h"
#include "tests/support/devices.h"
#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>

#include <memory>

namespace springdrive::app::study_screen {
namespace {

class ParticipantPixels : public ::testing::Test {
protected:
    static void SetUpTestSuite() { hidden_window = std::make_unique<testing::HiddenWindow>(); }
    static void TearDownTestSuite() { hidden_window.reset(); }

    static std::vector<std::uint8_t> drawn(const ParticipantPicture &picture) {
        ParticipantView view;
        view.draw(picture, 640, 360);
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
    const auto nothing = of_text("");
    const auto box = of_text("漢");
    EXPECT_NE(box, nothing);
    EXPECT_EQ(box, of_text("字")); // the font lacks both
    for (const char *letter : {"ä", "ß", "Ω", "Ж"}) {
        const auto seen = of_text(letter);
        EXPECT_NE(seen, box) << letter;
        EXPECT_NE(seen, nothing) << letter;
    }
}

TEST_F(ParticipantPixels, AreThoseOfThePictureWhateverWasDrawnBefore) {
    ParticipantView used;
    for (const auto &[name, picture] : pictures_of_a_sitting()) {
        if (picture.scene == SceneShown::nothing) { // with one see below
            used.draw(picture, 640, 360);
            EXPECT_EQ(used.pixels(), drawn(picture)) << name;
        }
    }
    ParticipantPicture picture = picture_of_a_sitting("question");
    used.draw(picture, 1280, 720); // another size, and back
    picture.progress = 0.0;
    used.draw(picture, 640, 360);
    const auto at_start = drawn(picture);
    EXPECT_EQ(used.pixels(), at_start);
    picture.progress = 1.0;
    const auto at_end = drawn(picture);
    EXPECT_NE(at_end, at_start);
    picture.progress = 0.5;
    const auto halfway = drawn(picture);
    EXPECT_NE(halfway, at_start);
    EXPECT_NE(halfway, at_end);
}

TEST_F(ParticipantPixels, OfTheSceneShowBallAndRingAndAreTheSameEachTime) {
    const scene::Scene card =
        scene::load_gltf(std::string(SPRINGDRIVE_ASSET_DIR) + "/scenes/plate.gltf",
                         testing::phantom_1_0().workspace);
    const Vector3 middle_m = 0.5 * (card.lower_m + card.upper_m);
    const scene::TouchSpot spot{{middle_m.x(), card.upper_m.y(), middle_m.z()}, Vector3::UnitY()};
    const scene::TouchSpot aside{spot.point_m + Vector3(0.01, 0.0, 0.0), Vector3::UnitY()};
    ParticipantPicture picture = picture_of_a_sitting("scene");
    picture.tip_m = spot.point_m + Vector3(0.0, 0.012, 0.0);
    ParticipantPicture without_ball = picture;
    without_ball.tip_m.reset();
    const auto seen = [&](ParticipantView &view, const ParticipantPicture &one,
                          const scene::TouchSpot &at) {
        view.set_scene(card, at, -0.1);
        view.draw(one, 640, 360);
        return view.pixels();
    };
    ParticipantView view;
    ParticipantView other;
    const auto with_ball = seen(view, picture, spot);
    EXPECT_NE(seen(view, without_ball, spot), with_ball);
    EXPECT_EQ(seen(other, picture, spot), with_ball);
    EXPECT_NE(seen(other, picture, aside), with_ball);
}

} // namespace
} // namespace springdrive::app::study_screen
