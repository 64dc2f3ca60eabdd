#include "app/view/scene_meshes.h"

#include "engine/scene/texture_scaling.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>

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

Texture2D uploaded(const scene::Texture &texture) {
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

void SceneMeshes::upload_texture(const scene::Texture &texture) {
    GLint max_side = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_side);
    if (texture.width <= max_side && texture.height <= max_side) {
        textures_.push_back(uploaded(texture));
        return;
    }
    const scene::Texture smaller = scene::scaled_down(texture, max_side);
    const auto size = [](const scene::Texture &of) {
        return std::to_string(of.width) + " x " + std::to_string(of.height);
    };
    remarks_.push_back("a texture of " + size(texture) + " pixels is drawn with " + size(smaller) +
                       ": OpenGL allows " + std::to_string(max_side) + " a side here");
    textures_.push_back(uploaded(smaller));
}

/// Uploads one texture or mesh; neither is large.
void SceneMeshes::upload_next() {
    const scene::Scene &scene = *uploading_;
    const int white_texture = static_cast<int>(scene.textures.size());
    if (textures_.size() < scene.textures.size()) {
        upload_texture(scene.textures[textures_.size()]);
    } else if (textures_.size() == scene.textures.size()) {
        textures_.push_back(white());
    } else if (items_.size() < scene.meshes.size()) {
        const scene::VisualMesh &mesh = scene.meshes[items_.size()];
        const auto texture_or_white = [&](int texture) {
            return texture >= 0 ? texture : white_texture;
        };
        items_.push_back({GpuMesh(mesh.vertices, mesh.indices), texture_or_white(mesh.texture),
                          glm::vec3(mesh.emission[0], mesh.emission[1], mesh.emission[2]),
                          texture_or_white(mesh.emissive_texture), mesh.translucent,
                          mesh.centre_m});
    } else {
        uploading_ = nullptr;
    }
}

void SceneMeshes::draw(const Item &item) const {
    textures_[static_cast<std::size_t>(item.texture)].bind(0);
    item.mesh.draw();
}

void SceneMeshes::draw_emissive(const Program &lit, const Item &item) const {
    lit.set("emission", item.emission);
    textures_[static_cast<std::size_t>(item.emissive_texture)].bind(1);
    draw(item);
}

void SceneMeshes::draw_opaque() const {
    for (const Item &item : items_) {
        if (!item.translucent && !item.is_emissive()) {
            draw(item);
        }
    }
}

void SceneMeshes::draw_opaque_emissive(const Program &lit) const {
    for (const Item &item : items_) {
        if (!item.translucent && item.is_emissive()) {
            draw_emissive(lit, item);
        }
    }
}

void SceneMeshes::draw_translucent(const Program &lit, const Vector3 &forward) const {
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
            draw_emissive(lit, *item);
        }
    }
    glDisable(GL_CULL_FACE);
}

void SceneMeshes::draw_all() const {
    for (const Item &item : items_) {
        item.mesh.draw();
    }
}

void SceneMeshes::draw_casters() const {
    for (const Item &item : items_) {
        if (!item.translucent) {
            item.mesh.draw();
        }
    }
}

} // namespace springdrive::app
