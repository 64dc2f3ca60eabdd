// The model of a scene that a session runs: plant effects, step, surface and motion controller.
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

/// The surface that is touched instead of a scene's own.
struct ContactShape {
    enum class Kind : std::uint8_t {
        primitives, ///< plates, spheres, boxes, ... where a node's mesh represents one
        simplified, ///< a mesh of fewer triangles
        flat,       ///< the file's triangles where the scene specifies a curved surface
        given,      ///< the surface that the scene specifies
    };
    Kind kind = Kind::given;
    int divisor = 1; ///< simplified: one triangle remains of this many

    friend bool operator==(const ContactShape &, const ContactShape &) = default;
};

/// "primitives", "simplified_8", "flat", "given".
[[nodiscard]] std::string name_of(const ContactShape &shape);
[[nodiscard]] std::optional<ContactShape> contact_shape_named(std::string_view name);

/// A map from the tip's set-point to the motors'.
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

/// One choice for each aspect.
struct Model {
    simulated::PlantModel plant = simulated::kPlantModels.back();
    int steps = 1; ///< of the plant per servo period
    bool planar = false;
    ContactShape shape;
    MotionController controller = kMotionControllers.back();
};

/// Sets the options of the simulated device for the model. @pre the period is set
void apply(const Model &model, simulated::SimulationOptions &simulation);

/// The tuning with the model's motion controller in place of its own.
[[nodiscard]] control::Tuning with_controller(const MotionController &controller,
                                              control::Tuning tuning);

} // namespace springdrive::model_selection
