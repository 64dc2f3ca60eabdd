// Covers app/view/gl_objects.cpp: what a frame takes, known from what is drawn.
#include "app/view/gl_objects.h"

#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>

namespace springdrive::app {
namespace {

constexpr int kWidth_px = 48;
constexpr int kHeight_px = 32;

/// One triangle that covers all.
constexpr const char *kCover = R"(
void main() {
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
)";
constexpr const char *kWhite = R"(
out vec4 pixel;
void main() { pixel = vec4(1.0); }
)";

TEST(FrameLoad, CountsCallsTrianglesAndSamples) {
    const testing::HiddenWindow window;
    const Texture2D target(kWidth_px, kHeight_px, {}, {});
    const Framebuffer framebuffer;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.name(), 0);
    glViewport(0, 0, kWidth_px, kHeight_px);
    const Program fill("fill", kCover, kWhite);
    const VertexArray no_vertices;
    FrameLoadMeter meter;
    const auto frame = [&](int calls, int top_px) {
        meter.begin();
        fill.use();
        glBindVertexArray(no_vertices.name());
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, kWidth_px, top_px);
        for (int i = 0; i < calls; ++i) {
            draw_arrays(GL_TRIANGLES, 3); // covers all
        }
        meter.end();
        glFinish(); // so that it is answered when the next one begins
    };
    frame(1, kHeight_px);
    EXPECT_EQ(meter.latest().draw_calls, 0); // nothing is known of it yet
    frame(3, 10);
    EXPECT_EQ(meter.latest().draw_calls, 1);
    EXPECT_EQ(meter.latest().primitives, 1U);
    EXPECT_EQ(meter.latest().samples, static_cast<std::uint64_t>(kWidth_px * kHeight_px));
    frame(0, kHeight_px);
    EXPECT_EQ(meter.latest().draw_calls, 3);
    EXPECT_EQ(meter.latest().primitives, 3U);
    EXPECT_EQ(meter.latest().samples, static_cast<std::uint64_t>(3 * kWidth_px * 10));
    frame(1, kHeight_px);
    EXPECT_EQ(meter.latest().draw_calls, 0);
    EXPECT_EQ(meter.latest().primitives, 0U);
    EXPECT_EQ(meter.latest().samples, 0U);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    check_gl("measuring frames");
}

} // namespace
} // namespace springdrive::app
