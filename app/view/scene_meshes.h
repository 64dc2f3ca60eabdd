// A scene's meshes and textures on the graphics card.
#pragma once

#include "app/view/gpu_mesh.h"
#include "base/vector.h"
#include "engine/scene/scene.h"

#include <vector>

namespace springdrive::app {

class SceneMeshes {
public:
    SceneMeshes() = default; ///< empty

    /// Nothing is uploaded yet. @param scene must exist until everything is uploaded
    explicit SceneMeshes(const scene::Scene &scene) : uploading_(&scene) {}

    /// Uploads for about `duration_s`. @return whether everything is uploaded
    bool upload(double duration_s);

    // The active program must have base_texture at unit 0. Both sides of a surface are drawn, as
    // both can be touched.
    void draw_opaque() const;
    /// From the farthest to the nearest, of each the back faces before the front faces.
    /// @param forward unit, from the eye into the scene
    void draw_translucent(const Vector3 &forward) const;
    void draw_all() const; ///< without textures

private:
    struct Item {
        GpuMesh mesh;
        int texture;
        bool translucent;
        Vector3 centre_m;
    };

    void draw(const Item &item) const;
    void upload_next();

    const scene::Scene *uploading_ = nullptr; ///< until upload is complete
    std::vector<Texture2D> textures_;         ///< the scene's, then a white one
    std::vector<Item> items_;
};

} // namespace springdrive::app
