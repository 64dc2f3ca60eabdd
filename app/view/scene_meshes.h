// A scene's meshes and textures on the graphics card.
#pragma once

#include "app/view/gpu_mesh.h"
#include "base/vector.h"
#include "engine/scene/scene.h"

#include <glm/vec3.hpp>

#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

class SceneMeshes {
public:
    SceneMeshes() = default; ///< empty

    /// Nothing is uploaded yet. @param scene must exist until everything is uploaded
    explicit SceneMeshes(const scene::Scene &scene) : uploading_(&scene) {}

    /// Uploads for about `duration_s`. @return whether everything is uploaded
    bool upload(double duration_s);

    /// Remarks on textures of the scene that are not drawn as they are, each once.
    [[nodiscard]] std::vector<std::string> take_remarks() { return std::exchange(remarks_, {}); }

    // The active program must have base_texture at unit 0. Both sides of a surface are drawn, as
    // both can be touched.
    void draw_opaque() const; ///< what has no emission
    /// What has. @param lit is active, with emissive_texture at unit 1
    void draw_opaque_emissive(const Program &lit) const;
    /// From the farthest to the nearest, of each the back faces before the front faces.
    /// @param lit is active, with emissive_texture at unit 1
    /// @param forward unit, from the eye into the scene
    void draw_translucent(const Program &lit, const Vector3 &forward) const;
    void draw_all() const;     ///< without textures
    void draw_casters() const; ///< the same of what is not translucent

private:
    struct Item {
        GpuMesh mesh;
        int texture;
        glm::vec3 emission;
        int emissive_texture;
        bool translucent;
        Vector3 centre_m;

        [[nodiscard]] bool is_emissive() const { return emission != glm::vec3(0.0F); }
    };

    void draw(const Item &item) const;
    void draw_emissive(const Program &lit, const Item &item) const;
    void upload_next();
    void upload_texture(const scene::Texture &texture);

    const scene::Scene *uploading_ = nullptr; ///< until upload is complete
    std::vector<Texture2D> textures_;         ///< the scene's, then a white one
    std::vector<Item> items_;
    std::vector<std::string> remarks_;
};

} // namespace springdrive::app
