#include "app/view/scene_meshes.h"

#include <algorithm>
#include <array>

namespace springdrive {

namespace {

GLint gl_wrap(Texture::Wrap wrap) {
    switch (wrap) {
    case Texture::Wrap::repeat:
        return GL_REPEAT;
    case Texture::Wrap::mirror:
        return GL_MIRRORED_REPEAT;
    case Texture::Wrap::clamp:
        break;
    }
    return GL_CLAMP_TO_EDGE;
}

Texture2D upload(const Texture &texture) {
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

bool has_alpha(const Texture &texture) {
    for (std::size_t i = 3; i < texture.rgba.size(); i += 4) {
        if (texture.rgba[i] < 255) {
            return true;
        }
    }
    return false;
}

bool is_translucent(const VisualMesh &mesh, const Scene &scene) {
    constexpr float kOpaque = 0.999F;
    return (mesh.texture >= 0 &&
            has_alpha(scene.textures[static_cast<std::size_t>(mesh.texture)])) ||
           std::any_of(mesh.vertices.begin(), mesh.vertices.end(),
                       [](const VisualVertex &v) { return v.colour[3] < kOpaque; });
}

Vector3 centre_of(const VisualMesh &mesh) {
    Vector3 sum_m = Vector3::Zero();
    for (const VisualVertex &vertex : mesh.vertices) {
        sum_m += Vector3(vertex.position_m[0], vertex.position_m[1], vertex.position_m[2]);
    }
    return sum_m / std::max(1.0, static_cast<double>(mesh.vertices.size()));
}

} // namespace

SceneMeshes::SceneMeshes(const Scene &scene) {
    textures_.reserve(scene.textures.size() + 1);
    for (const Texture &texture : scene.textures) {
        textures_.push_back(upload(texture));
    }
    textures_.push_back(white());

    const int white_texture = static_cast<int>(scene.textures.size());
    for (const VisualMesh &mesh : scene.meshes) {
        items_.push_back({GpuMesh(mesh.vertices, mesh.indices),
                          mesh.texture >= 0 ? mesh.texture : white_texture,
                          is_translucent(mesh, scene), centre_of(mesh)});
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
        for (const GLenum hidden_side : {GL_FRONT, GL_BACK}) {
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

} // namespace springdrive
