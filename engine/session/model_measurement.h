// The model that a scene gets: remembered from earlier, or measured, at once or in the background.
#pragma once

#include "base/background.h"
#include "engine/lab/model_selection/scene_model.h"

#include <optional>
#include <string>

namespace springdrive::session {

/// A scene without what is only drawn: all that a choice needs, and light enough to be copied.
[[nodiscard]] scene::Scene without_looks(const scene::Scene &scene);

/// By what a choice is remembered, beside its question.
struct ModelMemory {
    std::string device_text; ///< of the device's file
    std::string program_version;
};

/// What was measured before on this machine, by this program, for just this.
[[nodiscard]] std::optional<model_selection::ModelChoice>
remembered_choice(const model_selection::ModelQuestion &question, const ModelMemory &memory);

/// Measures now, whatever is remembered, and remembers that.
[[nodiscard]] model_selection::ModelChoice
measured_choice(const model_selection::ModelQuestion &question, const ModelMemory &memory,
                const model_selection::ModelProgress &progress = {});

/// Remembered, or else measured.
[[nodiscard]] model_selection::ModelChoice
known_choice(const model_selection::ModelQuestion &question, const ModelMemory &memory,
             const model_selection::ModelProgress &progress);

/// Measures in the background, one scene at a time. Of one thread.
class ModelMeasurement {
public:
    /// What is still being measured is let go of.
    void begin(const model_selection::ModelQuestion &question, const ModelMemory &memory);

    [[nodiscard]] bool is_running() const { return measuring_.is_busy(); }

    /// For people: "plant full, 40 %".
    [[nodiscard]] std::string progress() const;

    /// The choice, once, when it is ready. Where it failed, `error` tells why from then on.
    [[nodiscard]] std::optional<model_selection::ModelChoice> take();
    [[nodiscard]] const std::string &error() const { return error_; }

    /// Of another scene: what is being measured is not wanted any more, nor what failed.
    void forget() {
        measuring_.give_up();
        error_.clear();
    }

private:
    Background<model_selection::ModelChoice> measuring_;
    std::string error_;
};

} // namespace springdrive::session
