#include "app/view/scene_meshes.h"

#include "app/view/embedded_shaders.h"
#include "engine/scene/visual_mesh.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace springdrive::app {

namespace {

struct LitDefine {
    bool LitVariant::*needed;
    std::string_view name;
};

constexpr std::array kLitDefines{
    LitDefine{&LitVariant::metal, "METAL"},
    LitDefine{&LitVariant::finish_texture, "FINISH_TEXTURE"},
    LitDefine{&LitVariant::normal_texture, "NORMAL_TEXTURE"},
    LitDefine{&LitVariant::tangents, "TANGENTS"},
    LitDefine{&LitVariant::occlusion_texture, "OCCLUSION_TEXTURE"},
    LitDefine{&LitVariant::emission, "EMISSION"},
    LitDefine{&LitVariant::mask, "MASK"},
    LitDefine{&LitVariant::translucent, "TRANSLUCENT"},
};

Program compiled(const LitVariant &variant) {
    std::string name = "lit";
    std::vector<std::string_view> defines;
    for (const LitDefine &define : kLitDefines) {
        if (variant.*define.needed) {
            defines.push_back(define.name);
            name.append(" ").append(define.name);
        }
    }
    return {name, shaders::lit_vert, shaders::lit_frag, defines};
}

void set_units(const Program &lit, const LitVariant &variant) {
    lit.set("base_texture", kBaseUnit);
    lit.set("scene_shadow", kSceneShadowUnit);
    lit.set("moving_shadow", kMovingShadowUnit);
    if (variant.finish_texture) {
        lit.set("finish_texture", kFinishUnit);
    }
    if (variant.normal_texture) {
        lit.set("normal_texture", kNormalUnit);
    }
    if (variant.occlusion_texture) {
        lit.set("occlusion_texture", kOcclusionUnit);
    }
    if (variant.emission) {
        lit.set("emissive_texture", kEmissiveUnit);
    }
}

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
            Texture2D::Format{.internal = texture.holds_numbers ? GL_RGBA8 : GL_SRGB8_ALPHA8,
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

const Program &LitPrograms::with(const LitVariant &variant) {
    auto found = programs_.find(variant);
    const bool is_new = found == programs_.end();
    if (is_new) {
        found = programs_.emplace(variant, compiled(variant)).first;
    }
    found->second.use();
    if (is_new) {
        set_units(found->second, variant);
    }
    return found->second;
}

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
    warnings_.push_back("a texture of " + size(texture) + " pixels is drawn with " + size(smaller) +
                        ": OpenGL allows " + std::to_string(max_side) + " a side here");
    textures_.push_back(uploaded(smaller));
}

/// Uploads one texture or mesh; neither is large.
void SceneMeshes::upload_next() {
    const scene::Scene &scene = *uploading_;
    if (textures_.size() < scene.textures.size()) {
        upload_texture(scene.textures[textures_.size()]);
    } else if (textures_.size() == scene.textures.size()) {
        textures_.push_back(white());
    } else if (items_.size() < scene.meshes.size()) {
        upload_mesh(scene.meshes[items_.size()]);
    } else {
        std::ranges::stable_sort(items_, {}, &Item::variant);
        if (!scene.creases.empty()) {
            creases_.emplace(scene.creases);
        }
        uploading_ = nullptr;
    }
}

void SceneMeshes::upload_mesh(const scene::VisualMesh &mesh) {
    const scene::Finish &finish = mesh.finish;
    const glm::vec3 emission(mesh.emission[0], mesh.emission[1], mesh.emission[2]);
    const LitVariant variant{.metal = finish.metallic > 0.0F,
                             .finish_texture = finish.metallic_roughness_texture >= 0,
                             .normal_texture = finish.normal_texture >= 0,
                             .tangents = finish.normal_texture >= 0 && !mesh.tangents.empty(),
                             .occlusion_texture = finish.occlusion_texture >= 0,
                             .emission = emission != glm::vec3(0.0F),
                             .mask = mesh.alpha_cutoff.has_value(),
                             .translucent = mesh.translucent};
    items_.push_back({GpuMesh(mesh.vertices, mesh.indices, mesh.tangents), finish, mesh.texture,
                      emission, mesh.emissive_texture, mesh.alpha_cutoff.value_or(0.0F),
                      mesh.centre_m, variant});
}

void SceneMeshes::bind(int texture, int unit) const {
    const std::size_t white = textures_.size() - 1;
    textures_[texture >= 0 ? static_cast<std::size_t>(texture) : white].bind(unit);
}

std::set<LitVariant> SceneMeshes::variants() const {
    std::set<LitVariant> variants;
    for (const Item &item : items_) {
        variants.insert(item.variant);
    }
    return variants;
}

void SceneMeshes::draw(const Program &lit, const Item &item) const {
    const LitVariant &variant = item.variant;
    lit.set("roughness", item.finish.roughness);
    if (variant.metal) {
        lit.set("metallic", item.finish.metallic);
    }
    if (variant.finish_texture) {
        bind(item.finish.metallic_roughness_texture, kFinishUnit);
    }
    if (variant.normal_texture) {
        lit.set("normal_scale", item.finish.normal_scale);
        bind(item.finish.normal_texture, kNormalUnit);
    }
    if (variant.occlusion_texture) {
        lit.set("occlusion_strength", item.finish.occlusion_strength);
        bind(item.finish.occlusion_texture, kOcclusionUnit);
    }
    if (variant.emission) {
        lit.set("emission", item.emission);
        bind(item.emissive_texture, kEmissiveUnit);
    }
    if (variant.mask) {
        lit.set("alpha_cutoff", item.alpha_cutoff);
    }
    bind(item.texture, kBaseUnit);
    item.mesh.draw();
}

void SceneMeshes::draw_opaque(const Begin &begin) const {
    const Program *lit = nullptr;
    const LitVariant *variant = nullptr;
    for (const Item &item : items_) {
        if (item.variant.translucent) {
            continue;
        }
        if (variant == nullptr || *variant != item.variant) {
            variant = &item.variant;
            lit = &begin(item.variant);
        }
        draw(*lit, item);
    }
}

void SceneMeshes::draw_translucent(const Begin &begin, const Vector3 &forward) const {
    std::vector<const Item *> sorted;
    for (const Item &item : items_) {
        if (item.variant.translucent) {
            sorted.push_back(&item);
        }
    }
    std::sort(sorted.begin(), sorted.end(), [&](const Item *a, const Item *b) {
        return a->centre_m.dot(forward) > b->centre_m.dot(forward);
    });
    glEnable(GL_CULL_FACE);
    for (const Item *item : sorted) {
        const Program &lit = begin(item->variant);
        for (const GLenum hidden_side : {GLenum{GL_FRONT}, GLenum{GL_BACK}}) {
            glCullFace(hidden_side);
            draw(lit, *item);
        }
    }
    glDisable(GL_CULL_FACE);
}

void SceneMeshes::draw_creases() const {
    if (creases_) {
        creases_->draw();
    }
}

void SceneMeshes::draw_solid_casters() const {
    for (const Item &item : items_) {
        if (!item.variant.translucent && !item.variant.mask) {
            item.mesh.draw();
        }
    }
}

void SceneMeshes::draw_translucent_casters() const {
    for (const Item &item : items_) {
        if (item.variant.translucent) {
            item.mesh.draw();
        }
    }
}

void SceneMeshes::draw_masked_casters(const Program &program) const {
    program.set("base_texture", kBaseUnit);
    for (const Item &item : items_) {
        if (item.variant.mask) {
            program.set("alpha_cutoff", item.alpha_cutoff);
            bind(item.texture, kBaseUnit);
            item.mesh.draw();
        }
    }
}

} // namespace springdrive::app
