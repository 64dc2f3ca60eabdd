// What a session can run of a scene: how much of the device, how finely, what surface, what law.
#pragma once

#include "device/simulated/plant_model.h"
#include "device/simulated/simulation_options.h"
#include "engine/control/tuning.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace springdrive::model_selection {

/// What is touched in place of a scene's surface.
struct ContactShape {
    enum class Kind : std::uint8_t {
        primitives, ///< plates, spheres, boxes, ... where a node's mesh is one
        simplified, ///< a mesh of fewer triangles
        flat,       ///< the file's triangles where the scene asks for a curved surface
        given,      ///< what the scene asks for
    };
    Kind kind = Kind::given;
    int divisor = 1; ///< simplified: a triangle is left of so many

    friend bool operator==(const ContactShape &, const ContactShape &) = default;
};

/// "primitives", "simplified_8", "flat", "given".
[[nodiscard]] std::string name_of(const ContactShape &shape);
[[nodiscard]] std::optional<ContactShape> contact_shape_named(std::string_view name);

/// A way from the tip's set-point to the motors'.
struct MotionController {
    std::string_view name;
    control::MotionMap map = control::MotionMap::transpose;
    control::AlphaMode alpha_mode = control::AlphaMode::on_the_fly;
};

/// The last is the fullest: the paper's, with α at its bound everywhere.
inline constexpr std::array<MotionController, 3> kMotionControllers{{
    {"inverse", control::MotionMap::inverse, control::AlphaMode::on_the_fly},
    {"transpose_global", control::MotionMap::transpose, control::AlphaMode::global},
    {"transpose_on_the_fly", control::MotionMap::transpose, control::AlphaMode::on_the_fly},
}};

[[nodiscard]] const MotionController *motion_controller_named(std::string_view name);

/// One of `kPlantModels`; null where none has that name.
[[nodiscard]] const simulated::PlantModel *plant_model_named(std::string_view name);

/// One choice of each.
struct Model {
    simulated::PlantModel plant = simulated::kPlantModels.back();
    int steps = 1; ///< of the plant, in a servo period
    bool planar = false;
    ContactShape shape;
    MotionController controller = kMotionControllers.back();
};

/// What the simulated device has to be told of it. @pre the period is set
void apply(const Model &model, simulated::SimulationOptions &simulation);

/// The tuning with the model's motion controller in place of its own.
[[nodiscard]] control::Tuning with_controller(const MotionController &controller,
                                              control::Tuning tuning);

} // namespace springdrive::model_selection
