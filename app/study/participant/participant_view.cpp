#include "app/study/participant/participant_view.h"

#include "app/study/participant/participant_palette.h"
#include "base/assertions.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

glm::vec2 corner_of(const PixelBox &box) {
    return {static_cast<float>(box.x), static_cast<float>(box.y)};
}

glm::vec2 size_of(const PixelBox &box) {
    return {static_cast<float>(box.width), static_cast<float>(box.height)};
}

Plate plate(const PixelBox &box, const glm::vec4 &colour, float radius_px, float border_px = 0.0F) {
    return {corner_of(box), size_of(box), colour, radius_px, border_px};
}

/// The part of a bar that is filled, from the left.
PixelBox filled(PixelBox bar, double share) {
    bar.width = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * bar.width));
    return bar;
}

/// What the layout depends on.
ParticipantPicture laid_out(ParticipantPicture picture) {
    picture.tip_m.reset();
    picture.chosen.reset();
    picture.choices_take_clicks = false;
    picture.progress = picture.progress ? std::optional(0.0) : std::nullopt;
    picture.left_share = picture.left_share ? std::optional(0.0) : std::nullopt;
    return picture;
}

} // namespace

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

ParticipantView::ParticipantView(int samples) : text_(typeface_), scene_(samples) {
    check_gl("setting up the participant's picture");
}

void ParticipantView::set_scene(const scene::Scene &scene, const MarkedSpot &spot,
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
    if (is_resized || laid_out(picture) != laid_out(picture_)) {
        layout_ = lay_out(picture, width, height, typeface_);
    }
    picture_ = picture;
    is_outdated_ = false;

    glBindFramebuffer(GL_FRAMEBUFFER, target_->framebuffer.name());
    glViewport(0, 0, width, height);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glClearColor(palette::kGround.r, palette::kGround.g, palette::kGround.b, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    if (!layout_.scene.is_empty()) {
        scene_.draw(target_->framebuffer.name(), layout_.scene, height, picture.tip_m,
                    palette::kGround);
        glViewport(0, 0, width, height);
    }
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    draw_plates();
    draw_texts();
    glDisable(GL_BLEND);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    check_gl("drawing the participant's picture");
}

void ParticipantView::draw_plates() {
    const float round_px = static_cast<float>(target_->height) / 90.0F;
    const float thin_px = std::max(1.0F, static_cast<float>(target_->height) / 480.0F);
    std::vector<Plate> plates;
    const auto add = [&](const PixelBox &box, const glm::vec4 &colour, float radius_px,
                         float border_px = 0.0F) {
        if (!box.is_empty()) {
            plates.push_back(plate(box, colour, radius_px, border_px));
        }
    };
    const auto add_bar = [&](const PixelBox &bar, double share) {
        const float half_px = 0.5F * static_cast<float>(bar.height);
        add(bar, palette::kTrough, half_px);
        PixelBox full = filled(bar, share);
        if (full.width > 0) {
            full.width = std::max(full.width, bar.height); // its ends are round
            add(full, palette::kAccent, half_px);
        }
    };
    add(layout_.calm_plate, palette::kPlate, round_px);
    add(layout_.calm_plate, palette::kPlateRim, round_px, thin_px);
    for (std::size_t i = 0; i < layout_.choices.size(); ++i) {
        const PlacedChoice &choice = layout_.choices[i];
        const bool is_chosen = picture_.chosen == i;
        add(choice.plate, is_chosen ? palette::kChosenPlate : palette::kPlate, round_px);
        add(choice.plate, is_chosen ? palette::kAccent : palette::kPlateRim, round_px, thin_px);
        add(choice.key, palette::kAccent, 0.7F * round_px, thin_px);
    }
    add(layout_.field, palette::kPlate, round_px);
    add(layout_.field, palette::kPlateRim, round_px, thin_px);
    add(layout_.cursor, palette::kAccent, 0.0F);
    add_bar(layout_.left_bar, picture_.left_share.value_or(0.0));
    add_bar(layout_.progress, picture_.progress.value_or(0.0));
    plates.insert(plates.end(), layout_.curve.plates.begin(), layout_.curve.plates.end());
    plates_.draw(plates, {static_cast<float>(target_->width), static_cast<float>(target_->height)});
}

void ParticipantView::draw_text(const PlacedText &text, const glm::vec4 &colour) {
    text_.draw(text.lines, text.box.x, text.box.y, colour,
               {static_cast<float>(target_->width), static_cast<float>(target_->height)});
}

void ParticipantView::draw_texts() {
    draw_text(layout_.heading, palette::kInk);
    draw_text(layout_.text, palette::kInk);
    draw_text(layout_.left_text, palette::kDimInk);
    draw_text(layout_.typed, palette::kInk);
    for (const PlacedChoice &choice : layout_.choices) {
        draw_text(choice.text, palette::kInk);
        draw_text(choice.key_text, palette::kAccent);
    }
    for (const PlacedText &label : layout_.curve.texts) {
        draw_text(label, palette::kDimInk);
    }
    draw_text(layout_.footer, palette::kDimInk);
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
