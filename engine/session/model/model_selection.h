// The model of a scene that a session runs: plant effects, step, surface and motion controller. And
// what was measured for a scene: every candidate with its cost and error, and which are chosen.
#pragma once

#include "base/timing.h"
#include "device/core/device_description.h"
#include "device/simulated/simulation_options.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/tuning.h"
#include "engine/scene/scene.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// The difference between the rendered and the reference force.
struct ModelError {
    double force_N = 0.0;       ///< rms of the difference over the whole path
    double direction_rad = 0.0; ///< rms of the angle, while both touch with 0.2 N or more
};

/// One alternative for modelling one aspect of a scene.
struct Candidate {
    std::string name;
    Cost cost;        ///< per servo tick, of the part that this axis decides
    ModelError error; ///< with all other axes at their fullest
};

/// A cheaper candidate that was tried instead of the chosen one, all other axes as chosen, and
/// missed the tolerance.
struct CheaperTrial {
    std::size_t candidate = 0;
    ModelError error;
};

/// An aspect that can be modelled in several ways.
struct ModelAxis {
    std::string name;
    std::vector<Candidate> candidates; ///< the last is the fullest
    std::size_t chosen = 0;
    std::vector<CheaperTrial> cheaper; ///< the next cheaper one, and each that meets on its own
};

/// The axes, in this order.
enum class ModelAspect : std::uint8_t { plant, steps, joints, surface, controller };
inline constexpr std::size_t kModelAspects = 5;

/// The result. Names as in `kPlantModels`, `name_of(ContactShape)` and `kMotionControllers`; steps
/// and joints are numbers.
struct ModelSelection {
    scene::ModelTolerance tolerance;
    std::vector<ModelAxis> axes; ///< one for each `ModelAspect`
    ModelError error;            ///< of the chosen model as a whole
    double cost_ns = 0.0;        ///< of that model per servo tick: plant, proxy and map
    double fullest_cost_ns = 0.0;
    std::vector<std::string> warnings;

    [[nodiscard]] const ModelAxis &axis(ModelAspect aspect) const {
        return axes[static_cast<std::size_t>(aspect)];
    }
    [[nodiscard]] const std::string &chosen(ModelAspect aspect) const {
        return axis(aspect).candidates[axis(aspect).chosen].name;
    }
};

/// The model that a choice names.
/// @throw InputError for names and numbers that this program does not know, as from an old file.
[[nodiscard]] Model model_of(const ModelSelection &choice);

/// The larger of the two errors relative to its tolerance: 1 just meets. NaN counts as infinite.
[[nodiscard]] double share_of_tolerance(const ModelError &error,
                                        const scene::ModelTolerance &tolerance);

[[nodiscard]] inline bool meets(const ModelError &error, const scene::ModelTolerance &tolerance) {
    return share_of_tolerance(error, tolerance) <= 1.0;
}

/// Why a candidate with that error is accepted or not: "meets", "force 0.21 N > 0.05 N", "runs
/// away".
[[nodiscard]] std::string verdict(const ModelError &error, const scene::ModelTolerance &tolerance);

// Who chooses the model of a scene: handed in by the caller of a session, so that a session needs
// no laboratory.

/// The input of a choice.
struct ModelQuestion {
    const scene::Scene *scene = nullptr;
    device::DeviceDescription device;
    control::Tuning tuning;
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// Receives what is being measured and the overall progress, from 0 to 1.
using ModelProgress = std::function<void(const std::string &what, double share)>;

/// The key of a stored choice, in addition to its question.
struct ModelMemory {
    std::string device_text; ///< text of the device file
    std::string program_version;
};

/// For any thread.
class ModelChooser {
public:
    virtual ~ModelChooser() = default;

    /// The stored choice for exactly this question on this machine and program version, if any.
    [[nodiscard]] virtual std::optional<ModelSelection> stored(const ModelQuestion &question,
                                                               const ModelMemory &memory) const = 0;

    /// Measures now, even if a choice is stored, and stores the result.
    [[nodiscard]] virtual ModelSelection measured(const ModelQuestion &question,
                                                  const ModelMemory &memory,
                                                  const ModelProgress &progress) const = 0;

    /// The stored choice, or else a measured one.
    [[nodiscard]] ModelSelection known(const ModelQuestion &question, const ModelMemory &memory,
                                       const ModelProgress &progress) const {
        std::optional<ModelSelection> choice = stored(question, memory);
        return choice ? *std::move(choice) : measured(question, memory, progress);
    }

    /// The scene's surface in that form, prepared for touch.
    /// @throw InputError for a shape that the scene cannot be touched as
    [[nodiscard]] virtual contact::HapticSurface surface_of(const scene::Scene &scene,
                                                            const ContactShape &shape) const = 0;
};

} // namespace springdrive::model_selection
