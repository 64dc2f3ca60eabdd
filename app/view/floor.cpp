#include "app/view/floor.h"

#include "app/view/embedded_shaders.h"

#include <glm/mat4x4.hpp>

namespace springdrive::app {

namespace {

constexpr double kShadowPerWorkspace = 1.4; // half size of the shadows' square; includes the base
constexpr float kFloorPerShadow = 2.2F;     // of the floor, which fades out at its edge
constexpr float kOpacityFromBelow = 0.25F;

} // namespace

Floor::Floor() : program_("floor", shaders::floor_vert, shaders::floor_frag) {}

void Floor::lay(const device::Workspace &workspace, double height_m) {
    const ShadowArea area{
        {static_cast<float>(workspace.centre_m.x()), static_cast<float>(workspace.centre_m.z())},
        static_cast<float>(kShadowPerWorkspace * workspace.size_m.maxCoeff()),
        static_cast<float>(height_m)};
    if (area != area_) {
        area_ = area;
        scene_cast_ = false;
    }
}

void Floor::cast_shadows(const SceneMeshes &scene, const SolidPainter &painter,
                         std::span<const Solid> moving) {
    if (!scene_cast_) {
        scene_shadow_.cast(
            shadow_programs_, area_,
            [&](const Program &cast) {
                cast.set("model", glm::mat4(1.0F));
                scene.draw_solid_casters();
                scene.draw_translucent_casters();
            },
            [&](const Program &cast) {
                cast.set("model", glm::mat4(1.0F));
                scene.draw_masked_casters(cast);
            });
        scene_cast_ = true;
    }
    moving_shadow_.cast(shadow_programs_, area_,
                        [&](const Program &cast) { painter.draw_geometry(cast, moving); });
}

void Floor::draw(const glm::mat4 &view_projection, const Vector3 &eye_m, double pixel_scale) const {
    program_.use();
    program_.set("view_projection", view_projection);
    program_.set("centre_m", area_.centre_m);
    program_.set("half_size_m", kFloorPerShadow * area_.half_size_m);
    program_.set("height_m", area_.height_m);
    program_.set("shadow_centre_m", area_.centre_m);
    program_.set("shadow_half_size_m", area_.half_size_m);
    program_.set("opacity",
                 eye_m.y() > static_cast<double>(area_.height_m) ? 1.0F : kOpacityFromBelow);
    program_.set("pixel_scale", static_cast<float>(pixel_scale));
    scene_shadow_.texture().bind(0);
    program_.set("scene_shadow", 0);
    moving_shadow_.texture().bind(1);
    program_.set("moving_shadow", 1);
    glBindVertexArray(no_vertices_.name());
    draw_arrays(GL_TRIANGLE_STRIP, 4);
}

} // namespace springdrive::app
