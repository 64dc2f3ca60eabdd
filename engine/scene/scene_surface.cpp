#include "engine/scene/scene_surface.h"

#include "base/input_error.h"
#include "base/text.h"

#include <new>
#include <string>

namespace springdrive::scene {

contact::HapticSurface haptic_surface_of(const Scene &scene) {
    const std::string place = one_line(scene.file.string(), 1000) + ": ";
    const auto prepared = [&] {
        try {
            return contact::HapticSurface(scene.surface, scene.shapes);
        } catch (const InputError &error) {
            throw InputError(place + error.what());
        } catch (const std::bad_alloc &) {
            throw InputError(place + "needs more memory than there is; simplify it");
        }
    };
    contact::HapticSurface surface = prepared();
    if (surface.report().triangles_kept == 0 && surface.shapes().empty()) {
        throw InputError(place + "has nothing to touch: its triangles, " +
                         std::to_string(surface.report().triangles_given) +
                         " in number, are all too thin to have a normal; export it again");
    }
    return surface;
}

} // namespace springdrive::scene
