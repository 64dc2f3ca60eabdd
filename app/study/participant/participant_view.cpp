#include "app/study/participant/participant_view.h"

#include "app/view/embedded_shaders.h"
#include "app/view/solids.h"
#include "base/assertions.h"

#include <backends/imgui_impl_opengl3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr double kMinHalfHeight_m = 0.035; // of what is seen about the spot
constexpr double kMaxHalfHeight_m = 0.06;
constexpr double kSteeper_px = 35.0; // of a mouse that would turn the camera so, by 14°
constexpr double kMinFacing = 0.15;  // cosine between the spot's normal and the line of sight

constexpr Colour kRingColour{0.96F, 0.97F, 0.98F};
constexpr double kRingRadius_m = 0.005;
constexpr Colour kBallColour{0.98F, 0.62F, 0.16F};
constexpr double kBallRadius_m = 2.2e-3;
constexpr float kGlow = 0.6F; // both keep their colour on the unlit side
constexpr float kSatinBall = 0.5F;
constexpr float kHiddenBall = 0.35F; // opacity of the ball behind something

constexpr int kSceneShadow_px = 1024;
constexpr int kBallShadow_px = 512;
constexpr double kMinLight_m = 0.1; // radius of what the key light sees
constexpr std::array<std::string_view, 1> kMasked{"MASK"};

Camera looking_from(Viewpoint viewpoint) {
    Camera camera;
    camera.look_from(viewpoint);
    if (viewpoint == Viewpoint::home) {
        camera.orbit(0.0, kSteeper_px);
    }
    return camera;
}

/// From the first of the directions from which the spot is seen, or from the best.
Camera facing(const scene::TouchSpot &spot) {
    Camera best = looking_from(Viewpoint::home);
    double most = -1.0;
    for (const Viewpoint viewpoint : {Viewpoint::home, Viewpoint::top, Viewpoint::front}) {
        const Camera camera = looking_from(viewpoint);
        const double cosine = -spot.normal.dot(camera.forward());
        if (cosine > kMinFacing) {
            return camera;
        }
        if (cosine > most) {
            most = cosine;
            best = camera;
        }
    }
    return best;
}

/// Dark and neutral, with one accent. sRGB, straight alpha.
namespace palette {
// Contrasts by WCAG 2.1 on the ground: ink 14, dim ink 7.
constexpr glm::vec3 kGround{0.105F, 0.115F, 0.130F};
constexpr ImU32 kInk = IM_COL32(236, 238, 241, 255);
constexpr ImU32 kDimInk = IM_COL32(167, 173, 181, 255);
constexpr ImU32 kAccent = IM_COL32(135, 196, 241, 255);
constexpr ImU32 kCard = IM_COL32(43, 48, 54, 255);
constexpr ImU32 kCardRim = IM_COL32(76, 83, 92, 255);
constexpr ImU32 kTrough = IM_COL32(51, 56, 62, 255); // of bars
constexpr ImU32 kBand = (kAccent & ~IM_COL32_A_MASK) | 41U << IM_COL32_A_SHIFT;
constexpr ImU32 kDot = (kInk & ~IM_COL32_A_MASK) | 191U << IM_COL32_A_SHIFT;
constexpr ImU32 kDotRim = IM_COL32(27, 29, 33, 255); // the ground
} // namespace palette

/// Of the course, which is not empty; between its points.
double share_at(const std::vector<OwnCurve::Point> &course, double level) {
    const auto above = std::ranges::lower_bound(course, level, {}, &OwnCurve::Point::level);
    if (above == course.begin() || above == course.end()) {
        return (above == course.begin() ? course.front() : course.back()).right_share;
    }
    const OwnCurve::Point &below = *(above - 1);
    return std::lerp(below.right_share, above->right_share,
                     (level - below.level) / (above->level - below.level));
}

/// Makes a context of ImGui current, and again the former one at the end.
class CurrentGui {
public:
    explicit CurrentGui(ImGuiContext *gui) : before_(ImGui::GetCurrentContext()) {
        ImGui::SetCurrentContext(gui);
    }
    ~CurrentGui() { ImGui::SetCurrentContext(before_); }
    CurrentGui(const CurrentGui &) = delete;
    CurrentGui &operator=(const CurrentGui &) = delete;

private:
    ImGuiContext *before_;
};

ImGuiContext *new_gui(ImFontAtlas &letters) {
    ImGuiContext *const gui = ImGui::CreateContext(&letters);
    const CurrentGui current(gui);
    ImGui::GetIO().IniFilename = nullptr;
    ImGui_ImplOpenGL3_Init("#version 330 core");
    return gui;
}

void end_gui(ImGuiContext *gui) {
    {
        const CurrentGui current(gui);
        ImGui_ImplOpenGL3_Shutdown();
    }
    ImGui::DestroyContext(gui);
}

ImVec2 end_of(const Rectangle &box) {
    return {box.corner.x + box.size.x, box.corner.y + box.size.y};
}

/// A page of plates, bars and text.
class Page {
public:
    Page(ImDrawList &list, int height)
        : list_(list), round_px_(static_cast<float>(height) / 90.0F),
          thin_px_(std::max(1.0F, std::round(static_cast<float>(height) / 480.0F))) {}

    void add_card(const Rectangle &box, ImU32 fill, ImU32 rim) {
        if (!is_empty(box)) {
            list_.AddRectFilled(box.corner, end_of(box), fill, round_px_);
            list_.AddRect(box.corner, end_of(box), rim, round_px_, 0, thin_px_);
        }
    }

    void add_bar(const Rectangle &bar, double share) {
        if (is_empty(bar)) {
            return;
        }
        const float round_px = 0.5F * bar.size.y;
        list_.AddRectFilled(bar.corner, end_of(bar), palette::kTrough, round_px);
        const auto full = static_cast<float>(std::round(std::clamp(share, 0.0, 1.0) * bar.size.x));
        if (full > 0.0F) { // its ends are round
            const Rectangle filled{bar.corner, {std::max(full, bar.size.y), bar.size.y}};
            list_.AddRectFilled(filled.corner, end_of(filled), palette::kAccent, round_px);
        }
    }

    void add_text(const TextLines &text, ImU32 colour) {
        for (const TextLine &line : text.lines) {
            const float right =
                text.is_centred ? std::floor(0.5F * (text.box.size.x - line.width)) : 0.0F;
            list_.AddText(text.font, text.size_px,
                          {text.box.corner.x + right, text.box.corner.y + line.top}, colour,
                          line.text.data(), line.text.data() + line.text.size());
        }
    }

private:
    ImDrawList &list_;
    float round_px_;
    float thin_px_;
};

} // namespace

Camera camera_on(const scene::TouchSpot &spot, const scene::Scene &scene) {
    const double half_size_m = 0.5 * (scene.upper_m - scene.lower_m).norm();
    const double half_height_m = std::clamp(half_size_m, kMinHalfHeight_m, kMaxHalfHeight_m);
    const double distance_m = half_height_m / Camera::half_height_per_depth();
    Camera camera = facing(spot);
    camera.place(spot.point_m - distance_m * camera.forward(), distance_m);
    return camera;
}

ParticipantScene::ParticipantScene(int samples)
    : depth_("depth", shaders::depth_vert, shaders::depth_frag),
      depth_masked_("depth, masked", shaders::depth_vert, shaders::depth_frag, kMasked),
      scene_shadow_(kSceneShadow_px), ball_shadow_(kBallShadow_px), target_(samples) {}

void ParticipantScene::set(const scene::Scene &scene, const scene::TouchSpot &spot,
                           double floor_height_m) {
    SceneMeshes meshes(scene);
    meshes.upload(std::numeric_limits<double>::infinity());
    check_gl("uploading the participant's scene");
    for (const LitVariant &variant : meshes.variants()) {
        lit_.with(variant); // compiled here, so that none fails later
    }
    meshes_ = std::move(meshes);
    spot_ = spot;
    camera_ = camera_on(spot, scene);
    floor_height_m_ = static_cast<float>(floor_height_m);
    const Vector3 centre_m = 0.5 * (scene.lower_m + scene.upper_m);
    const double radius_m = std::max(kMinLight_m, 0.5 * (scene.upper_m - scene.lower_m).norm());
    light_ = light_matrix(kTowardsKeyLight, to_glm(centre_m), static_cast<float>(radius_m));
    scene_is_cast_ = false;
}

void ParticipantScene::cast_shadows(const std::vector<Solid> &ball) {
    if (!scene_is_cast_) {
        scene_shadow_.cast(depth_, light_, [&](const Program &depth) {
            depth.set("model", glm::mat4(1.0F));
            meshes_.draw_solid_casters();
            depth_masked_.use();
            depth_masked_.set("light", light_);
            depth_masked_.set("model", glm::mat4(1.0F));
            meshes_.draw_masked_casters(depth_masked_);
        });
        scene_is_cast_ = true;
    }
    ball_shadow_.cast(depth_, light_,
                      [&](const Program &depth) { painter_.draw_geometry(depth, ball); });
}

const Program &ParticipantScene::begin(const LitVariant &variant,
                                       const glm::mat4 &view_projection) {
    const Program &lit = lit_.with(variant);
    lit.set("view_projection", view_projection);
    lit.set("eye_m", to_glm(camera_.eye_m()));
    lit.set("tip_m", tip_m_);
    lit.set("floor_height_m", floor_height_m_);
    lit.set("light", light_);
    lit.set("key_direction", kTowardsKeyLight);
    scene_shadow_.bind(kSceneShadowUnit);
    ball_shadow_.bind(kMovingShadowUnit);
    lit.set("model", glm::mat4(1.0F));
    lit.set("normal_matrix", glm::mat3(1.0F));
    lit.set("colour", glm::vec4(1.0F));
    lit.set("glow", 0.0F);
    lit.set("roughness", kSatinBall);
    return lit;
}

void ParticipantScene::draw(GLuint framebuffer, const Rectangle &part, int height,
                            const std::optional<Vector3> &tip_m, const glm::vec3 &background) {
    // Without a ball its shadow is cast from where nothing is.
    constexpr float kFarBelow_m = -1.0e3F;
    tip_m_ = tip_m ? to_glm(*tip_m) : glm::vec3(0.0F, kFarBelow_m, 0.0F);
    std::vector<Solid> balls;
    if (tip_m) {
        balls.push_back(ball(*tip_m, kBallRadius_m, kBallColour));
    }
    const std::vector<Solid> rings{ring(spot_.point_m, spot_.normal, kRingRadius_m, kRingColour)};
    cast_shadows(balls);

    const int part_width = static_cast<int>(part.size.x);
    const int part_height = static_cast<int>(part.size.y);
    const double aspect = static_cast<double>(part_width) / part_height;
    const glm::mat4 view_projection = camera_.projection(aspect) * camera_.view();
    const auto begin_variant = [&](const LitVariant &variant) -> const Program & {
        return begin(variant, view_projection);
    };
    target_.begin(part_width, part_height);
    glDepthMask(GL_TRUE);
    glClearColor(background.r, background.g, background.b, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    meshes_.draw_opaque(begin_variant);

    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const Program &lit = begin_variant({});
    lit.set("glow", kGlow);
    painter_.draw(lit, rings);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_GREATER);
    painter_.draw(lit, balls, kHiddenBall);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_LESS);
    painter_.draw(lit, balls);
    glDepthMask(GL_FALSE);
    meshes_.draw_translucent(begin_variant, camera_.forward());
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(0);
    target_.end(framebuffer, static_cast<int>(part.corner.x),
                height - static_cast<int>(part.corner.y) - part_height);
}

void draw_curve(const CurveChart &chart, const OwnCurve &curve, ImDrawList &list) {
    const Rectangle &plot = chart.plot;
    const float line = chart.line_px;
    const float right = plot.corner.x + plot.size.x;
    const float bottom = chart.y_px(0.0);
    for (const double share : kNamedShares) {
        const float y = chart.y_px(share);
        list.AddLine({plot.corner.x, y}, {right, y},
                     share == 0.0 ? palette::kDimInk : palette::kTrough, line);
    }
    const float chance_y = chart.y_px(curve.guess);
    for (float x = plot.corner.x; x < right; x += 8.0F * line) { // dashes
        list.AddLine({x, chance_y}, {std::min(x + 4.0F * line, right), chance_y}, palette::kCardRim,
                     line);
    }
    for (const double level : curve.ticks) {
        const float x = chart.x_px(curve, level);
        list.AddLine({x, bottom}, {x, bottom + 4.0F * line}, palette::kDimInk, line);
    }
    list.PushClipRect(plot.corner, {right, bottom}, true); // the course may be longer
    const ImDrawListFlags flags = list.Flags;
    list.Flags &= ~ImDrawListFlags_AntiAliasedFill; // or seams would be seen in the band
    std::vector<ImVec2> course;
    for (std::size_t i = 0; i < curve.course.size(); ++i) {
        const OwnCurve::Point &point = curve.course[i];
        const float x = chart.x_px(curve, point.level);
        course.emplace_back(x, chart.y_px(point.right_share));
        if (i > 0) {
            const OwnCurve::Point &before = curve.course[i - 1];
            const float x_before = chart.x_px(curve, before.level);
            list.AddQuadFilled({x_before, chart.y_px(before.low)}, {x, chart.y_px(point.low)},
                               {x, chart.y_px(point.high)}, {x_before, chart.y_px(before.high)},
                               palette::kBand);
        }
    }
    list.Flags = flags;
    list.AddPolyline(course.data(), static_cast<int>(course.size()), palette::kAccent, 0,
                     2.0F * line);
    list.PopClipRect();
    if (curve.threshold && !course.empty()) { // down from the function to its interval
        const auto x_of = [&](double level) {
            return std::clamp(chart.x_px(curve, level), plot.corner.x, right);
        };
        const float x = x_of(curve.threshold->level);
        list.AddLine({x, chart.y_px(share_at(curve.course, curve.threshold->level))}, {x, bottom},
                     palette::kInk, line);
        list.AddLine({x_of(curve.threshold->low), bottom}, {x_of(curve.threshold->high), bottom},
                     palette::kInk, 4.0F * line);
        list.AddCircleFilled({x, bottom}, 5.0F * line, palette::kInk);
    }
    for (const OwnCurve::Dot &dot : curve.dots) {
        const ImVec2 place{chart.x_px(curve, dot.level), chart.y_px(dot.right_share)};
        const float radius = dot_radius_px(dot.trials, plot.size.y);
        list.AddCircleFilled(place, radius, palette::kDot);
        list.AddCircle(place, radius, palette::kDotRim, 0, line);
    }
}

ParticipantView::Target::Target(int wide, int high)
    : texture(wide, high, Texture2D::Format{}, {}), width(wide), height(high) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (status != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("OpenGL cannot draw the participant's picture into a texture");
    }
}

ParticipantView::ParticipantView(int samples)
    : gui_(new_gui(letters_.atlas()), end_gui), scene_(samples) {
    check_gl("setting up the participant's picture");
}

void ParticipantView::set_scene(const scene::Scene &scene, const scene::TouchSpot &spot,
                                double floor_height_m) {
    scene_.set(scene, spot, floor_height_m);
    is_outdated_ = true;
}

void ParticipantView::draw(const ParticipantPicture &picture, int width, int height) {
    SPRINGDRIVE_ASSERT(width > 0 && height > 0);
    const bool is_resized = !target_ || target_->width != width || target_->height != height;
    if (!is_outdated_ && !is_resized && picture == picture_) {
        return;
    }
    if (is_resized) {
        target_.reset(); // first, so that both are never held
        target_.emplace(width, height);
    }
    layout_ = lay_out(picture, width, height, letters_);
    picture_ = picture;
    is_outdated_ = false;

    glBindFramebuffer(GL_FRAMEBUFFER, target_->framebuffer.name());
    glViewport(0, 0, width, height);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glClearColor(palette::kGround.r, palette::kGround.g, palette::kGround.b, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    if (!is_empty(layout_.scene)) {
        scene_.draw(target_->framebuffer.name(), layout_.scene, height, picture.tip_m,
                    palette::kGround);
    }
    draw_page();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    check_gl("drawing the participant's picture");
}

void ParticipantView::draw_page() {
    const CurrentGui current(gui_.get());
    ImGuiIO &io = ImGui::GetIO();
    ImGui_ImplOpenGL3_NewFrame();
    if (std::exchange(letters_version_, letters_.version()) != letters_.version()) {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    }
    glBindTexture(GL_TEXTURE_2D,
                  static_cast<GLuint>(reinterpret_cast<std::uintptr_t>(io.Fonts->TexID)));
    for (const int filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) {
        // Exactly the letters' pixels, unless they are drawn smaller than they were made.
        glTexParameteri(GL_TEXTURE_2D, static_cast<GLenum>(filter),
                        layout_.is_readable ? GL_NEAREST : GL_LINEAR);
    }
    io.DisplaySize = {static_cast<float>(target_->width), static_cast<float>(target_->height)};
    ImGui::NewFrame();
    ImDrawList &list = *ImGui::GetBackgroundDrawList();
    Page page(list, target_->height);
    page.add_card(layout_.calm_plate, palette::kCard, palette::kCardRim);
    page.add_text(layout_.heading, palette::kInk);
    page.add_text(layout_.text, palette::kInk);
    page.add_bar(layout_.left_bar, picture_.left_share.value_or(0.0));
    page.add_text(layout_.left_text, palette::kDimInk);
    page.add_card(layout_.field, palette::kCard, palette::kCardRim);
    page.add_text(layout_.typed, palette::kInk);
    list.AddRectFilled(layout_.cursor.corner, end_of(layout_.cursor), palette::kAccent);
    for (const PlacedChoice &choice : layout_.choices) {
        page.add_card(choice.card, palette::kCard, palette::kCardRim);
        page.add_card(choice.key, 0, palette::kAccent);
        page.add_text(choice.text, palette::kInk);
        page.add_text(choice.key_text, palette::kAccent);
    }
    if (picture_.curve) {
        draw_curve(layout_.curve, *picture_.curve, list);
        for (const TextLines &label : layout_.curve.labels) {
            page.add_text(label, palette::kDimInk);
        }
    }
    page.add_text(layout_.footer, palette::kDimInk);
    page.add_bar(layout_.progress, picture_.progress.value_or(0.0));
    ImGui::Render();
    glUseProgram(0); // ImGui makes the present one current again, which may be deleted already
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    vertices_ += static_cast<std::size_t>(ImGui::GetDrawData()->TotalVtxCount);
}

void ParticipantView::copy_to_window(int width, int height) const {
    const bool is_same = target_->width == width && target_->height == height;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_->framebuffer.name());
    glBlitFramebuffer(0, 0, target_->width, target_->height, 0, 0, width, height,
                      GL_COLOR_BUFFER_BIT, is_same ? GL_NEAREST : GL_LINEAR);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

std::vector<std::uint8_t> ParticipantView::pixels() const {
    if (!target_) {
        return {};
    }
    const std::size_t row = 3 * static_cast<std::size_t>(target_->width);
    std::vector<std::uint8_t> upward(row * static_cast<std::size_t>(target_->height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_->framebuffer.name());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, target_->width, target_->height, GL_RGB, GL_UNSIGNED_BYTE, upward.data());
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    std::vector<std::uint8_t> downward;
    downward.reserve(upward.size());
    for (auto y = static_cast<std::size_t>(target_->height); y-- > 0;) {
        const auto from = upward.begin() + static_cast<std::ptrdiff_t>(y * row);
        downward.insert(downward.end(), from, from + static_cast<std::ptrdiff_t>(row));
    }
    return downward;
}

} // namespace springdrive::app::study_screen
