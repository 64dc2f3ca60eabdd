// A scene's meshes and textures on the graphics card.
#pragma once

#include "app/view/gpu_mesh.h"
#include "base/vector.h"
#include "engine/scene/scene.h"

#include <vector>

namespace springdrive {

class SceneMeshes {
public:
    SceneMeshes() = default; ///< nothing to see
    explicit SceneMeshes(const Scene &scene);

    // The program in use has base_texture at unit 0. Both sides of a surface are drawn, as both
    // can be touched.
    void draw_opaque() const;
    /// From the farthest to the nearest, the far side of each before its near side.
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

    std::vector<Texture2D> textures_; ///< the scene's, then a white one
    std::vector<Item> items_;
};

} // namespace springdrive
