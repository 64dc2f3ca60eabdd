#include "app/view/scene_meshes.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace springdrive::app {

namespace {

GLint gl_wrap(scene::Texture::Wrap wrap) {
    switch (wrap) {
    case scene::Texture::Wrap::repeat:
        return GL_REPEAT;
    case scene::Texture::Wrap::mirror:
        return GL_MIRRORED_REPEAT;
    case scene::Texture::Wrap::clamp:
        break;
    }
    return GL_CLAMP_TO_EDGE;
}

Texture2D upload_texture(const scene::Texture &texture) {
    return {texture.width, texture.height,
            Texture2D::Format{.internal = GL_SRGB8_ALPHA8,
                              .wrap_s = gl_wrap(texture.wrap_s),
                              .wrap_t = gl_wrap(texture.wrap_t),
                              .mipmaps = true},
            texture.rgba};
}

Texture2D white() {
    constexpr std::array<std::uint8_t, 4> kWhite{255, 255, 255, 255};
    return {1, 1, Texture2D::Format{}, kWhite};
}

} // namespace

bool SceneMeshes::upload(double duration_s) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    while (uploading_ != nullptr &&
           std::chrono::duration<double>(Clock::now() - start).count() < duration_s) {
        upload_next();
    }
    return uploading_ == nullptr;
}

/// Uploads one texture or mesh; neither is large.
void SceneMeshes::upload_next() {
    const scene::Scene &scene = *uploading_;
    const int white_texture = static_cast<int>(scene.textures.size());
    if (textures_.size() < scene.textures.size()) {
        textures_.push_back(upload_texture(scene.textures[textures_.size()]));
    } else if (textures_.size() == scene.textures.size()) {
        textures_.push_back(white());
    } else if (items_.size() < scene.meshes.size()) {
        const scene::VisualMesh &mesh = scene.meshes[items_.size()];
        items_.push_back({GpuMesh(mesh.vertices, mesh.indices),
                          mesh.texture >= 0 ? mesh.texture : white_texture, mesh.translucent,
                          mesh.centre_m});
    } else {
        uploading_ = nullptr;
    }
}

void SceneMeshes::draw(const Item &item) const {
    textures_[static_cast<std::size_t>(item.texture)].bind(0);
    item.mesh.draw();
}

void SceneMeshes::draw_opaque() const {
    for (const Item &item : items_) {
        if (!item.translucent) {
            draw(item);
        }
    }
}

void SceneMeshes::draw_translucent(const Vector3 &forward) const {
    std::vector<const Item *> sorted;
    for (const Item &item : items_) {
        if (item.translucent) {
            sorted.push_back(&item);
        }
    }
    std::sort(sorted.begin(), sorted.end(), [&](const Item *a, const Item *b) {
        return a->centre_m.dot(forward) > b->centre_m.dot(forward);
    });
    glEnable(GL_CULL_FACE);
    for (const Item *item : sorted) {
        for (const GLenum hidden_side : {GLenum{GL_FRONT}, GLenum{GL_BACK}}) {
            glCullFace(hidden_side);
            draw(*item);
        }
    }
    glDisable(GL_CULL_FACE);
}

void SceneMeshes::draw_all() const {
    for (const Item &item : items_) {
        item.mesh.draw();
    }
}

} // namespace springdrive::app
