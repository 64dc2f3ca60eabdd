#include "app/view/lit_programs.h"

#include "app/view/embedded_shaders.h"

#include <array>
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

} // namespace springdrive::app
