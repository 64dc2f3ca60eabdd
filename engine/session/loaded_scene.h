// The scene that is shown and touched, and its replacement while the servo is running. Scenes are
// loaded in the background, so that neither window nor servo has to wait, and each may get a model
// of its own.
//
//   request ──► load_scene, in the background ──► take_loaded ──► now()
//                                                   │ the previous one
//                                                   ▼
//                        release on its own thread ◄── kept until the servo no longer uses it
#pragma once

#include "base/background.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/scene/load_messages.h"
#include "engine/scene/scene.h"
#include "engine/session/model/model_selection.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::session {

/// A scene ready for display and touch.
struct LoadedScene {
    scene::Scene scene;
    contact::HapticSurface surface;
    std::string sha256; ///< of the scene's file
    std::optional<model_selection::ModelSelection>
        choice{}; ///< of the scene's model, if one was chosen
};

/// Loads a glTF file and prepares its surface. Any thread.
/// @param gltf_scene  as of `load_gltf`
/// @throw InputError as `load_gltf` does.
/// @throw Cancelled soon after `progress` was cancelled
[[nodiscard]] std::unique_ptr<LoadedScene> load_scene(const std::filesystem::path &file,
                                                      const device::Workspace &workspace,
                                                      scene::LoadProgress &progress,
                                                      const std::string &gltf_scene = {});

/// For use by one thread. The destructor cancels loading and waits until it has ended, at most a
/// second.
class Scenes {
public:
    /// A final step for a loaded scene, also in the background. It must own all that it uses; if it
    /// fails, the scene is not shown.
    using Finish = std::function<void(LoadedScene &, scene::LoadProgress &, BackgroundTalk &)>;

    /// @param first  not null
    Scenes(device::Workspace workspace, std::unique_ptr<LoadedScene> first)
        : now_(std::move(first)), workspace_(std::move(workspace)) {}
    ~Scenes() { progress_->give_up(); }
    Scenes(const Scenes &) = delete;
    Scenes &operator=(const Scenes &) = delete;

    /// Loads in the background; on failure the current scene stays and `error` holds the reason. Of
    /// several requests while loading, the last one counts.
    /// @param gltf_scene  as of `load_gltf`
    void request(const std::filesystem::path &file, const std::string &gltf_scene = {},
                 const Finish &finish = {});

    /// Makes a loaded scene the current one, with a new number. Returns the previous scene, which
    /// stays valid until the servo no longer uses it; null if none was loaded.
    [[nodiscard]] const LoadedScene *take_loaded();

    /// Call when the servo uses the scene with this number: earlier ones are released.
    void note_in_use(std::uint32_t id);

    /// Scenes requested from now on are fitted into this workspace.
    void set_workspace(const device::Workspace &workspace) { workspace_ = workspace; }

    [[nodiscard]] LoadedScene &now() { return *now_; }
    [[nodiscard]] const LoadedScene &now() const { return *now_; }
    /// Number of the current scene: 1 for the first.
    [[nodiscard]] std::uint32_t id() const { return id_; }
    /// Number of previous scenes not yet released, as the servo may still use them.
    [[nodiscard]] std::size_t retired() const { return retired_.size(); }

    [[nodiscard]] bool is_loading() const { return loading_.is_busy(); }
    [[nodiscard]] std::string progress() const { return progress_->text(); }
    [[nodiscard]] const std::string &error() const { return error_; }

private:
    struct Request {
        std::filesystem::path file;
        std::string gltf_scene;
        Finish finish;
    };

    BackgroundRelease<LoadedScene> release_;
    std::unique_ptr<LoadedScene> now_;
    std::uint32_t id_ = 1;
    std::vector<std::unique_ptr<LoadedScene>> retired_;
    device::Workspace workspace_;
    std::shared_ptr<scene::LoadProgress> progress_ = std::make_shared<scene::LoadProgress>();
    std::optional<Request> next_; ///< requested while another was loading
    std::string error_;
    Background<std::unique_ptr<LoadedScene>> loading_; ///< last member, so that it is joined first
};

// Selects the model of a scene: what is simulated of the device, the touched surface, and the
// control law. Depending on the options it is the most detailed one, or the cheapest that meets the
// scene's tolerance.

/// Options for the model of a scene that a session runs.
///
/// By default the other options determine the model, and the scene's surface is used as it is.
struct ModelOptions {
    /// Must be there for `automatic`, for `surface`, and for a session that measures models.
    std::shared_ptr<const model_selection::ModelChooser> chooser;
    /// Use the cheapest model that meets the scene's tolerance; measured first if it is not cached.
    bool automatic = false;
    /// Whether an automatic model may set the motion controller: not if the user has tuned one.
    bool takes_controller = true;
    // Values that are set take precedence.
    std::optional<simulated::PlantModel> plant;
    std::optional<double> longest_step_s;
    std::optional<model_selection::ContactShape> surface;
};

/// Measures in the background which model a scene would get, one scene at a time. For use by one
/// thread.
class ModelMeasurement {
public:
    /// Starts a measurement; cancels one that is running.
    void begin(std::shared_ptr<const model_selection::ModelChooser> chooser,
               const model_selection::ModelQuestion &question,
               const model_selection::ModelMemory &memory);

    [[nodiscard]] bool is_running() const { return measuring_.is_busy(); }

    /// For display: "plant full, 40 %".
    [[nodiscard]] std::string progress() const;

    /// The choice, once, when it is ready. If the measurement failed, `error` holds the reason from
    /// then on.
    [[nodiscard]] std::optional<model_selection::ModelSelection> take();
    [[nodiscard]] const std::string &error() const { return error_; }

    /// Cancels the measurement and clears the error, for example because of a new scene.
    void discard() {
        measuring_.give_up();
        error_.clear();
    }

private:
    Background<model_selection::ModelSelection> measuring_;
    std::string error_;
};

/// The conditions for which a model is measured, in addition to the scene and the gains.
struct ModelGround {
    device::DeviceDescription device;
    model_selection::ModelMemory memory;
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// For use by one thread.
class SceneModels {
public:
    /// @param started_with  its motion controller may be replaced by a model's
    SceneModels(const ModelOptions &requested, const control::Tuning &started_with,
                const ModelGround &ground)
        : requested_(requested), started_with_(started_with), ground_(ground) {}

    /// Sets another device or rate, and cancels a measurement for the old one.
    void set_ground(const ModelGround &ground);
    [[nodiscard]] const ModelGround &ground() const { return ground_; }

    /// Effects that the user chose: of a plant that the options fix, too.
    void set_effects(const simulated::PlantEffects &effects) {
        if (requested_.plant) {
            requested_.plant->effects = effects;
        }
    }

    /// From now on every scene gets its own model.
    void choose_automatically() { requested_.automatic = true; }
    [[nodiscard]] bool is_automatic() const { return requested_.automatic; }

    /// The final step of loading a scene: finds its model and uses that model's surface.
    /// @param tuning  the active gains, for which the model is measured
    [[nodiscard]] Scenes::Finish finish(const control::Tuning &tuning) const;

    /// Call when the scene is shown: cancels a measurement for the previous one.
    void note_shown(const LoadedScene &scene);

    /// Sets simulation and control law from the scene's choice and the options. A controller that
    /// was tuned since the previous choice is kept.
    /// @param before          choice of the previous scene, if it had one
    /// @param may_hold_base   whether the base joint may be locked from now on
    void apply_to(const LoadedScene &scene,
                  const std::optional<model_selection::ModelSelection> &before, bool may_hold_base,
                  simulated::SimulationOptions &simulation, control::Tuning &tuning) const;

    /// Finds in the background which model the scene would get; `choice` returns it.
    /// @param fresh  measures even if a choice is cached
    void measure(const scene::Scene &scene, const control::Tuning &tuning, bool fresh);
    void give_up_measuring() { measurement_.discard(); }
    /// Fetches a finished measurement.
    void update();

    [[nodiscard]] const ModelMeasurement &measurement() const { return measurement_; }
    /// The choice for the shown scene, if measured.
    [[nodiscard]] const std::optional<model_selection::ModelSelection> &choice() const {
        return choice_;
    }

private:
    [[nodiscard]] model_selection::ModelQuestion question(const scene::Scene &scene,
                                                          const control::Tuning &tuning) const;

    ModelOptions requested_;
    control::Tuning started_with_;
    ModelGround ground_;
    std::optional<model_selection::ModelSelection> choice_; ///< for the shown scene
    ModelMeasurement measurement_;
};

} // namespace springdrive::session
