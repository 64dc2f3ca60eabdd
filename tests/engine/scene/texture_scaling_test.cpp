#include "engine/scene/texture_scaling.h"

#include <gtest/gtest.h>

namespace springdrive::scene {
namespace {

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
