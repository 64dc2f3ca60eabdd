// The choice of a scene's model: read from the cache, or measured, immediately or in the
// background.
#pragma once

#include "base/background.h"
#include "engine/lab/model_selection/scene_model.h"

#include <optional>
#include <string>

namespace springdrive::session {

/// A scene without its visual data: all that a choice needs, and small enough to be copied.
[[nodiscard]] scene::Scene without_looks(const scene::Scene &scene);

/// The key of a cached choice, in addition to its question.
struct ModelMemory {
    std::string device_text; ///< text of the device file
    std::string program_version;
};

/// The cached choice for exactly this question on this machine and program version, if any.
[[nodiscard]] std::optional<model_selection::ModelSelection>
stored_selection(const model_selection::ModelQuestion &question, const ModelMemory &memory);

/// Measures now, even if a choice is cached, and caches the result.
[[nodiscard]] model_selection::ModelSelection
measured_selection(const model_selection::ModelQuestion &question, const ModelMemory &memory,
                   const model_selection::ModelProgress &progress = {});

/// The cached choice, or else a measured one.
[[nodiscard]] model_selection::ModelSelection
known_selection(const model_selection::ModelQuestion &question, const ModelMemory &memory,
                const model_selection::ModelProgress &progress);

/// Measures in the background, one scene at a time. For use by one thread.
class ModelMeasurement {
public:
    /// Starts a measurement; cancels one that is running.
    void begin(const model_selection::ModelQuestion &question, const ModelMemory &memory);

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

} // namespace springdrive::session
