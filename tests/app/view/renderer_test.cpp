// Covers shaders/lit.*, depth.*, shadow.*, creases.vert and app/view/scene_meshes.cpp: how
// materials are drawn, as seen in pictures. What a picture ought to show is drawn a second time
// without the feature under test, with other geometry, or follows from the light's arithmetic. And
// app/view/gl_objects.cpp: what a frame takes, known from what is drawn.
#include "app/view/gl_objects.h"
#include "app/view/renderer.h"
#include "device/core/phantom/kinematics.h"
#include "tests/support/devices.h"
#include "tests/support/hidden_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {
namespace {

constexpr int kSide_px = 64;
constexpr double kHalf_m = 0.02;     // of the squares that are looked at
constexpr double kDistance_m = 0.08; // from which they are

/// Far from the linkage, which every picture contains.
const Vector3 kStage_m{20.0, 0.0, 0.0};

struct Rgb {
    int red, green, blue;
    bool operator==(const Rgb &) const = default;
};

std::ostream &operator<<(std::ostream &out, const Rgb &colour) {
    return out << colour.red << ", " << colour.green << ", " << colour.blue;
}

/// @param quanta  of eight bits a channel
void expect_alike(const Rgb &a, const Rgb &b, int quanta, const std::string &what) {
    EXPECT_LE(std::abs(a.red - b.red), quanta) << what << ": " << a << " and " << b;
    EXPECT_LE(std::abs(a.green - b.green), quanta) << what << ": " << a << " and " << b;
    EXPECT_LE(std::abs(a.blue - b.blue), quanta) << what << ": " << a << " and " << b;
}

/// The light of a channel that the shader compressed and encoded; see `compressed` there.
double light_of(int channel) {
    constexpr double kUncompressed = 0.60;
    const double shown = std::pow(channel / 255.0, 2.2);
    const double beyond = shown - kUncompressed;
    return beyond <= 0.0 ? shown : kUncompressed + beyond / (1.0 - beyond / (1.0 - kUncompressed));
}

class Picture {
public:
    Picture(std::vector<std::uint8_t> rgba, const Camera &camera)
        : rgba_(std::move(rgba)), camera_(camera) {}

    /// @param offset_m  from the stage's middle
    [[nodiscard]] Rgb at(const Vector3 &offset_m) const {
        const auto pixel = camera_.pixel_of(kStage_m + offset_m, {kSide_px, kSide_px});
        return in(static_cast<int>(pixel->x_px), static_cast<int>(pixel->y_px));
    }
    [[nodiscard]] Rgb middle() const { return at(Vector3::Zero()); }

    /// Counted from the top left.
    [[nodiscard]] Rgb in(int column, int row) const {
        const auto first = static_cast<std::size_t>(4 * ((kSide_px - 1 - row) * kSide_px + column));
        return {rgba_.at(first), rgba_.at(first + 1), rgba_.at(first + 2)};
    }

private:
    std::vector<std::uint8_t> rgba_; ///< bottom row first
    Camera camera_;
};

class Materials : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        window_ = std::make_unique<testing::HiddenWindow>();
        renderer_ = std::make_unique<Renderer>(0);
    }
    static void TearDownTestSuite() {
        renderer_.reset();
        window_.reset();
    }

    /// The stage's middle.
    static Picture draw(const scene::Scene &scene, Viewpoint from = Viewpoint::front,
                        double distance_m = kDistance_m) {
        Camera camera;
        camera.look_from(from);
        return draw(scene, camera, distance_m);
    }

    static Picture draw(const scene::Scene &scene, Camera camera, double distance_m) {
        camera.place(kStage_m - distance_m * camera.forward(), distance_m);
        renderer_->set_scene(scene);
        renderer_->upload(60.0);
        ViewState state;
        state.linkage = device::linkage_pose(testing::phantom_1_0().geometry, Vector3::Zero());
        state.workspace = {kStage_m, Vector3::Constant(0.1)};
        state.floor_height_m = -10.0;
        const Texture2D target(kSide_px, kSide_px, {}, {});
        const Framebuffer framebuffer;
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.name(),
                               0);
        renderer_->draw(camera, {0, 0, kSide_px, kSide_px}, state, 1.0);
        std::vector<std::uint8_t> rgba(static_cast<std::size_t>(4 * kSide_px * kSide_px));
        glReadPixels(0, 0, kSide_px, kSide_px, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        check_gl("reading the picture");
        return {std::move(rgba), camera};
    }

private:
    inline static std::unique_ptr<testing::HiddenWindow> window_;
    inline static std::unique_ptr<Renderer> renderer_;
};

std::array<float, 3> floats(const Vector3 &vector) {
    return {static_cast<float>(vector.x()), static_cast<float>(vector.y()),
            static_cast<float>(vector.z())};
}

using Colour4 = std::array<float, 4>;

/// A square about a point of the stage; its pictures are upright along `right` and `up`, unit and
/// square to each other.
scene::VisualMesh square(const Vector3 &right, const Vector3 &up,
                         const Colour4 &colour = {0.5F, 0.5F, 0.5F, 1.0F},
                         const Vector3 &offset_m = Vector3::Zero(), double half_m = kHalf_m) {
    scene::VisualMesh mesh;
    const Vector3 normal = right.cross(up);
    for (const auto &[u, v] : {std::pair{0.0F, 1.0F}, {1.0F, 1.0F}, {1.0F, 0.0F}, {0.0F, 0.0F}}) {
        const Vector3 corner_m =
            kStage_m + offset_m + half_m * (2.0 * u - 1.0) * right + half_m * (1.0 - 2.0 * v) * up;
        mesh.vertices.push_back({floats(corner_m), floats(normal), colour, {u, v}});
        const std::array<float, 3> tangent = floats(right);
        mesh.tangents.push_back({tangent[0], tangent[1], tangent[2], 1.0F});
    }
    mesh.indices = {0, 1, 2, 0, 2, 3};
    mesh.centre_m = kStage_m + offset_m;
    return mesh;
}

const Vector3 kRight = Vector3::UnitX();
const Vector3 kUp = Vector3::UnitY();
const Vector3 kNear = Vector3::UnitZ(); // towards the eye

/// A ball about the stage's middle, black, so that only reflections are seen.
scene::VisualMesh ball(const Colour4 &colour) {
    scene::VisualMesh mesh;
    const ShapeMesh &unit = unit_shape(Shape::ball);
    mesh.vertices = unit.vertices;
    mesh.indices = unit.indices;
    for (scene::VisualVertex &vertex : mesh.vertices) {
        const Vector3 at(vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]);
        vertex.position_m = floats(kStage_m + kHalf_m * at);
        vertex.colour = colour;
    }
    return mesh;
}

scene::Texture texture_of(int width, const std::vector<std::uint8_t> &rgba, bool holds_numbers) {
    scene::Texture texture;
    texture.width = width;
    texture.height = static_cast<int>(rgba.size()) / (4 * width);
    texture.rgba = rgba;
    texture.holds_numbers = holds_numbers;
    texture.wrap_s = scene::Texture::Wrap::clamp;
    texture.wrap_t = scene::Texture::Wrap::clamp;
    return texture;
}

/// One pixel of numbers.
scene::Texture numbers(int red, int green, int blue) {
    return texture_of(1,
                      {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
                       static_cast<std::uint8_t>(blue), 255},
                      true);
}

scene::Scene scene_of(std::vector<scene::VisualMesh> meshes,
                      std::vector<scene::Texture> textures = {}) {
    scene::Scene scene;
    scene.meshes = std::move(meshes);
    scene.textures = std::move(textures);
    return scene;
}

/// Shines in this colour, whatever the light.
scene::VisualMesh shining(scene::VisualMesh mesh, const std::array<float, 3> &emission) {
    for (scene::VisualVertex &vertex : mesh.vertices) {
        vertex.colour = {0.0F, 0.0F, 0.0F, 1.0F};
    }
    mesh.emission = emission;
    return mesh;
}

// Left half of alpha 100/255 = 0.392, right half of 200/255 = 0.784.
scene::Texture two_alphas() {
    return texture_of(2, {255, 255, 255, 100, 255, 255, 255, 200}, false);
}

TEST_F(Materials, MaskShowsWhatIsBehindExactlyWhereAlphaIsBelowTheCutoff) {
    const auto shown = [](float cutoff) {
        scene::VisualMesh mask = shining(square(kRight, kUp), {0.5F, 0.0F, 0.0F});
        mask.texture = 0;
        mask.alpha_cutoff = cutoff;
        const scene::VisualMesh behind =
            shining(square(kRight, kUp, {}, -0.01 * kNear, 2.0 * kHalf_m), {0.0F, 0.5F, 0.0F});
        const Picture picture = draw(scene_of({mask, behind}, {two_alphas()}));
        std::string seen;
        for (const double side : {-0.8, 0.8}) {
            const Rgb colour = picture.at(side * kHalf_m * kRight);
            seen += colour.red > 2 * colour.green ? 'm' : 'b';
            EXPECT_NE(colour.red > 2 * colour.green, colour.green > 2 * colour.red) << colour;
        }
        return seen;
    };
    EXPECT_EQ(shown(0.38F), "mm");
    EXPECT_EQ(shown(0.40F), "bm");
    EXPECT_EQ(shown(0.77F), "bm");
    EXPECT_EQ(shown(0.80F), "bb");
}

TEST_F(Materials, MaskedSurfacesCastShadowsOnlyWhereTheyAre) {
    // The ground from above; the occluder hangs where the key light throws its shadow on the
    // middle.
    const Vector3 towards(kTowardsKeyLight.x, kTowardsKeyLight.y, kTowardsKeyLight.z);
    const Vector3 above_m = 0.06 / towards.y() * towards;
    const Vector3 away = -kNear;
    const scene::VisualMesh ground =
        square(kRight, away, {0.5F, 0.5F, 0.5F, 1.0F}, Vector3::Zero(), 0.06);
    scene::VisualMesh occluder = square(kRight, away, {1, 1, 1, 1}, above_m, 0.012);
    occluder.texture = 0;
    const Vector3 left_m = -0.006 * kRight;
    const Vector3 right_m = 0.006 * kRight;
    const auto from_above = [](const scene::Scene &scene) {
        return draw(scene, Viewpoint::top, 0.25);
    };
    const Picture free = from_above(scene_of({ground}));
    occluder.alpha_cutoff = 0.5F;
    const Picture half = from_above(scene_of({ground, occluder}, {two_alphas()}));
    occluder.alpha_cutoff = 0.3F;
    const Picture whole = from_above(scene_of({ground, occluder}, {two_alphas()}));
    EXPECT_EQ(half.at(left_m), free.at(left_m));
    EXPECT_EQ(half.at(right_m), whole.at(right_m));
    // The key light is more than half of what arrives from above.
    EXPECT_LT(light_of(whole.at(left_m).green), 0.5 * light_of(free.at(left_m).green));
    EXPECT_LT(light_of(whole.at(right_m).green), 0.5 * light_of(free.at(right_m).green));
}

/// Both ways in which a normal map's tangents are found.
scene::VisualMesh mapped(scene::VisualMesh mesh, bool with_tangents) {
    mesh.finish.normal_texture = 0;
    if (!with_tangents) {
        mesh.tangents.clear();
    }
    return mesh;
}

// A number from −1 to 1 in eight bits is off by 1/255 at most, so a normal by 0.3°; where light
// falls obliquely, that is two quanta.
constexpr int kEncoded = 2;

TEST_F(Materials, AFlatNormalMapIsNoNormalMap) {
    for (const bool with_tangents : {true, false}) {
        for (const Vector3 &right :
             {kRight, kUp, Vector3(-kRight), Vector3(Vector3(1.0, 0.0, 0.6).normalized())}) {
            const Vector3 up = Vector3(kNear.cross(right)).normalized();
            const scene::VisualMesh plain = square(right, up);
            expect_alike(
                draw(scene_of({mapped(plain, with_tangents)}, {numbers(128, 128, 255)})).middle(),
                draw(scene_of({plain})).middle(), 1, with_tangents ? "file" : "derived");
        }
    }
}

/// One pixel: the normal that leans by `lean` rad to the right and `rise` rad upwards.
scene::Texture leaning(double lean, double rise) {
    const Vector3 normal = Vector3(std::tan(lean), std::tan(rise), 1.0).normalized();
    const auto byte = [](double number) {
        return static_cast<int>(std::lround((number + 1.0) / 2.0 * 255.0));
    };
    return numbers(byte(normal.x()), byte(normal.y()), byte(normal.z()));
}

TEST_F(Materials, ATiltedNormalMapIsLitAsTiltedGeometry) {
    constexpr double kTilt = 0.5; // rad
    for (const auto &[lean, rise] :
         {std::pair{kTilt, 0.0}, {-kTilt, 0.0}, {0.0, kTilt}, {0.0, -kTilt}, {kTilt, -0.3}}) {
        const Vector3 normal = Vector3(std::tan(lean), std::tan(rise), 1.0).normalized();
        const Vector3 up = normal.cross(kRight).normalized();
        const Rgb tilted = draw(scene_of({square(up.cross(normal), up)})).middle();
        const Rgb straight = draw(scene_of({square(kRight, kUp)})).middle();
        EXPECT_GT(std::abs(tilted.green - straight.green), 4 * kEncoded) << lean << " " << rise;
        for (const bool with_tangents : {true, false}) {
            const Picture map =
                draw(scene_of({mapped(square(kRight, kUp), with_tangents)}, {leaning(lean, rise)}));
            expect_alike(map.middle(), tilted, kEncoded, with_tangents ? "file" : "derived");
        }
    }
}

TEST_F(Materials, ANormalMapFollowsMirroredCoordinatesAndShowsItsDentsBehind) {
    constexpr double kTilt = 0.5;
    const auto tilted = [](double lean) {
        const Vector3 normal = Vector3(std::sin(lean), 0.0, std::cos(lean));
        return draw(scene_of({square(kUp.cross(normal), kUp)})).middle();
    };
    for (const bool with_tangents : {true, false}) {
        scene::VisualMesh mirrored = mapped(square(kRight, kUp), with_tangents);
        for (scene::VisualVertex &vertex : mirrored.vertices) {
            vertex.texture_coordinate[0] = 1.0F - vertex.texture_coordinate[0];
        }
        for (std::array<float, 4> &tangent : mirrored.tangents) {
            tangent[0] = -tangent[0];
            tangent[3] = -1.0F;
        }
        expect_alike(draw(scene_of({mirrored}, {leaning(kTilt, 0.0)})).middle(), tilted(-kTilt),
                     kEncoded, "mirrored");
        // Seen from behind, the square's right is the picture's left. The surface that leans to its
        // right in front has its back side facing the other way.
        const scene::VisualMesh behind = mapped(square(-kRight, kUp), with_tangents);
        expect_alike(draw(scene_of({behind}, {leaning(kTilt, 0.0)})).middle(), tilted(kTilt),
                     kEncoded, "behind");
    }
}

TEST_F(Materials, TheNormalScaleMultipliesTheSlope) {
    const double half = std::atan(0.5 * std::tan(0.8));
    scene::VisualMesh scaled = mapped(square(kRight, kUp), false);
    scaled.finish.normal_scale = 0.5F;
    const scene::VisualMesh whole = mapped(square(kRight, kUp), false);
    const Rgb requested = draw(scene_of({whole}, {leaning(half, 0.0)})).middle();
    expect_alike(draw(scene_of({scaled}, {leaning(0.8, 0.0)})).middle(), requested, kEncoded,
                 "half");
    EXPECT_GT(
        std::abs(draw(scene_of({whole}, {leaning(0.8, 0.0)})).middle().green - requested.green),
        4 * kEncoded);
}

scene::VisualMesh finished(scene::VisualMesh mesh, float metallic, float roughness) {
    mesh.finish.metallic = metallic;
    mesh.finish.roughness = roughness;
    return mesh;
}

TEST_F(Materials, ARougherSurfaceHasAWiderAndWeakerHighlight) {
    const double radius_px =
        0.5 * kSide_px * kHalf_m / (kDistance_m * Camera::half_height_per_depth());
    int wider_px = 0;
    double weaker = 10.0;
    for (const float roughness : {0.1F, 0.3F, 0.5F, 1.0F}) {
        const Picture picture =
            draw(scene_of({finished(ball({0.0F, 0.0F, 0.0F, 1.0F}), 0.0F, roughness)}));
        std::vector<double> lights; // of the part that faces the eye
        for (int i = 0; i < kSide_px * kSide_px; ++i) {
            const int column = i % kSide_px;
            const int row = i / kSide_px;
            const double middle_px = 0.5 * (kSide_px - 1);
            if (std::hypot(column - middle_px, row - middle_px) < 0.8 * radius_px) {
                lights.push_back(light_of(picture.in(column, row).green));
            }
        }
        const double brightest = *std::ranges::max_element(lights);
        const auto wide_px = static_cast<int>(
            std::ranges::count_if(lights, [&](double light) { return light > 0.5 * brightest; }));
        EXPECT_GT(wide_px, wider_px) << roughness;
        EXPECT_LT(brightest, weaker) << roughness;
        wider_px = wide_px;
        weaker = brightest;
    }
}

TEST_F(Materials, MetalReflectsInItsOwnColourAndADielectricInThatOfTheLight) {
    const Colour4 gold{0.8F, 0.4F, 0.1F, 1.0F};
    // Half-way between eye and light: the middle of the highlight.
    const Vector3 towards(kTowardsKeyLight.x, kTowardsKeyLight.y, kTowardsKeyLight.z);
    const Vector3 normal = (towards + kNear).normalized();
    const Vector3 right = kUp.cross(normal).normalized();
    const auto seen = [&](const Colour4 &colour, float metallic, float roughness) {
        const Rgb shown = draw(scene_of({finished(square(right, normal.cross(right), colour),
                                                  metallic, roughness)}))
                              .middle();
        return std::array{light_of(shown.red), light_of(shown.green), light_of(shown.blue)};
    };
    const Colour4 white{1.0F, 1.0F, 1.0F, 1.0F};
    const std::array gold_metal = seen(gold, 1.0F, 0.6F);
    const std::array white_metal = seen(white, 1.0F, 0.6F);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        // A third of the light is reflected more than once at this roughness, and takes the colour
        // as often.
        const double once = static_cast<double>(gold[channel]) * white_metal[channel];
        EXPECT_LT(gold_metal[channel], 1.05 * once);
        EXPECT_GT(gold_metal[channel], 0.60 * once);
    }
    // Over the base colour's tenth of blue, a dielectric's highlight is as blue as the light.
    EXPECT_LT(gold_metal[2] / white_metal[2], 0.11);
    EXPECT_GT(seen(gold, 0.0F, 0.4F)[2] / seen(white, 0.0F, 0.4F)[2], 0.20);
}

TEST_F(Materials, TheFinishTextureHasRoughnessInGreenAndMetalInBlueAndIsLinear) {
    const Colour4 gold{0.8F, 0.4F, 0.1F, 1.0F};
    for (const auto &[green, blue] : {std::pair{128, 255}, {255, 128}, {90, 200}}) {
        scene::VisualMesh with = finished(ball(gold), 1.0F, 1.0F);
        with.finish.metallic_roughness_texture = 0;
        const Picture textured = draw(scene_of({with}, {numbers(37, green, blue)}));
        const Picture plain = draw(scene_of({finished(ball(gold), static_cast<float>(blue) / 255.0F,
                                                      static_cast<float>(green) / 255.0F)}));
        for (const Vector3 &at : {Vector3(0.0, 0.0, 0.0), Vector3(-0.005, 0.008, 0.0)}) {
            expect_alike(textured.at(at), plain.at(at), 1, std::to_string(green));
        }
    }
}

TEST_F(Materials, OcclusionTakesTheLightFromAllAroundByItsStrength) {
    // Facing down, the key light does not reach it.
    const Vector3 normal = Vector3(0.3, -0.6, 0.7).normalized();
    const Vector3 right = kUp.cross(normal).normalized();
    const auto shown = [&](int red, float strength) {
        scene::VisualMesh mesh = square(right, normal.cross(right));
        mesh.finish.occlusion_texture = 0;
        mesh.finish.occlusion_strength = strength;
        return draw(scene_of({mesh}, {numbers(red, 0, 0)})).middle();
    };
    const Rgb open = draw(scene_of({square(right, normal.cross(right))})).middle();
    ASSERT_GT(open.green, 60);
    expect_alike(shown(255, 1.0F), open, 0, "open");
    expect_alike(shown(0, 0.0F), open, 0, "without strength");
    EXPECT_EQ(shown(0, 1.0F), (Rgb{0, 0, 0}));
    constexpr double kQuantum = 0.01; // relative, of the light of a channel above 60
    EXPECT_NEAR(light_of(shown(0, 0.5F).green) / light_of(open.green), 0.5, 2.0 * kQuantum);
    EXPECT_NEAR(light_of(shown(51, 1.0F).green) / light_of(open.green), 0.2, 2.0 * kQuantum);
}

TEST_F(Materials, EveryPairOfFeaturesCompilesAndTakesItsNumbers) {
    LitPrograms programs;
    constexpr std::array kFeatures{
        &LitVariant::metal,    &LitVariant::finish_texture,    &LitVariant::normal_texture,
        &LitVariant::tangents, &LitVariant::occlusion_texture, &LitVariant::emission,
        &LitVariant::mask,     &LitVariant::translucent};
    for (const auto first : kFeatures) {
        for (const auto second : kFeatures) {
            LitVariant variant;
            variant.*first = true;
            variant.*second = true;
            variant.normal_texture = variant.normal_texture || variant.tangents;
            const Program &lit = programs.with(variant);
            EXPECT_NO_THROW(lit.set("roughness", 0.5F));
            if (variant.metal) {
                EXPECT_NO_THROW(lit.set("metallic", 0.5F));
            } else {
                EXPECT_THROW(lit.set("metallic", 0.5F), std::logic_error);
            }
            if (variant.normal_texture) {
                EXPECT_NO_THROW(lit.set("normal_scale", 0.5F));
            }
            if (variant.mask) {
                EXPECT_NO_THROW(lit.set("alpha_cutoff", 0.5F));
            }
        }
    }
    check_gl("compiling variants");
}

TEST_F(Materials, WhiteKeepsItsShading) {
    for (const float metallic : {0.0F, 1.0F}) {
        const Picture picture =
            draw(scene_of({finished(ball({1.0F, 1.0F, 1.0F, 1.0F}), metallic, 1.0F)}));
        int brightest = 0;
        for (int i = 0; i < kSide_px * kSide_px; ++i) {
            brightest = std::max(brightest, picture.in(i % kSide_px, i / kSide_px).green);
        }
        EXPECT_LT(brightest, 250) << metallic;
        EXPECT_GT(brightest, 200) << metallic;
    }
}

/// A crease is a dark line where it is, hidden by what is nearer, and nothing elsewhere.
TEST_F(Materials, CreasesAreDarkLinesBeforeTheTrianglesThatMeetThere) {
    const auto shown = [](bool has_crease, bool is_covered) {
        std::vector<scene::VisualMesh> meshes{square(kRight, kUp)};
        if (is_covered) { // its right half, 10 mm before it
            meshes.push_back(
                square(kRight, kUp, {0.5F, 0.5F, 0.5F, 1.0F}, kHalf_m * kRight + 0.01 * kNear));
        }
        scene::Scene scene = scene_of(std::move(meshes));
        if (has_crease) {
            scene.creases = {{floats(kStage_m - 0.9 * kHalf_m * kRight),
                              floats(kStage_m + 0.9 * kHalf_m * kRight)}};
        }
        return draw(scene);
    };
    for (const bool is_covered : {false, true}) {
        const Picture plain = shown(false, is_covered);
        const Picture lined = shown(true, is_covered);
        int left = 0;
        int right = 0;
        for (int column = 0; column < kSide_px; ++column) {
            for (int row = 0; row < kSide_px; ++row) {
                const Rgb before = plain.in(column, row);
                const Rgb after = lined.in(column, row);
                if (after != before) {
                    EXPECT_LE(std::abs(row - kSide_px / 2), 1) << column;
                    EXPECT_LT(after.green, 3 * before.green / 4);
                    (column < kSide_px / 2 ? left : right) += 1;
                }
            }
        }
        EXPECT_GT(left, kSide_px / 8);
        EXPECT_EQ(right > 0, !is_covered) << right;
    }
}

constexpr int kWidth_px = 48;
constexpr int kHeight_px = 32;

/// One triangle that covers all.
constexpr const char *kCover = R"(
void main() {
    vec2 corner = vec2(gl_VertexID % 2, gl_VertexID / 2);
    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
)";
constexpr const char *kFillWhite = R"(
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
    const Program fill("fill", kCover, kFillWhite);
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
