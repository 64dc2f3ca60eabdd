// Which model of a scene runs: how much of the device is simulated, what surface is touched, and by
// what law. By the options it is the fullest, or the cheapest that the scene's tolerance allows.
#pragma once

#include "engine/session/model_measurement.h"
#include "engine/session/model_options.h"
#include "engine/session/scene_loader.h"

#include <optional>

namespace springdrive::session {

/// What a model is measured for, beside the scene and the gains.
struct ModelGround {
    device::DeviceDescription device;
    ModelMemory memory;
    double period_s = 1e-3;
    double delay_periods = 0.0;
};

/// Of one thread.
class SceneModels {
public:
    /// @param started_with  whose motion controller is a model's to replace
    SceneModels(const ModelOptions &wanted, const control::Tuning &started_with,
                const ModelGround &ground)
        : wanted_(wanted), started_with_(started_with), ground_(ground) {}

    /// On another device, or at another rate. What was measured is of the old one.
    void set_ground(const ModelGround &ground);
    [[nodiscard]] const ModelGround &ground() const { return ground_; }

    /// From now on every scene gets its own.
    void choose_automatically() { wanted_.automatic = true; }
    [[nodiscard]] bool is_automatic() const { return wanted_.automatic; }

    /// What loading a scene ends with: its model is found, and its surface is that model's.
    /// @param tuning  whose gains are in force: a model is as good as those it was measured with
    [[nodiscard]] SceneLoader::Finish finish(const control::Tuning &tuning) const;

    /// The scene is shown from now on: what was measured is of another.
    void note_shown(const LoadedScene &scene);

    /// What is simulated and by what law, from what was chosen for the scene and what is set. What
    /// somebody tuned since the choice before stays.
    /// @param before          of the scene before, if one ran with a choice
    /// @param may_hold_base   whether the base joint may be held from now on
    void apply_to(const LoadedScene &scene,
                  const std::optional<model_selection::ModelChoice> &before, bool may_hold_base,
                  simulated::SimulationOptions &simulation, control::Tuning &tuning) const;

    /// Finds in the background which model the scene would get, for `choice` to tell.
    /// @param fresh  even if it is remembered from before
    void measure(const scene::Scene &scene, const control::Tuning &tuning, bool fresh);
    void give_up_measuring() { measurement_.forget(); }
    /// Takes in what was measured.
    void update();

    [[nodiscard]] const ModelMeasurement &measurement() const { return measurement_; }
    /// What the scene would get, once somebody measured it.
    [[nodiscard]] const std::optional<model_selection::ModelChoice> &choice() const {
        return choice_;
    }

private:
    [[nodiscard]] model_selection::ModelQuestion question(const scene::Scene &scene,
                                                          const control::Tuning &tuning) const;

    ModelOptions wanted_;
    control::Tuning started_with_;
    ModelGround ground_;
    std::optional<model_selection::ModelChoice> choice_; ///< of the scene that is shown
    ModelMeasurement measurement_;
};

} // namespace springdrive::session
