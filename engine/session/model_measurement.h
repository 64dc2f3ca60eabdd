// Measures in the background which model a scene would get.
#pragma once

#include "base/background.h"
#include "engine/session/model/model_chooser.h"

#include <memory>
#include <optional>
#include <string>

namespace springdrive::session {

/// A scene without its visual data: all that a choice needs, and small enough to be copied.
[[nodiscard]] scene::Scene without_looks(const scene::Scene &scene);

/// Measures in the background, one scene at a time. For use by one thread.
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

} // namespace springdrive::session
