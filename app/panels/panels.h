// The panels: free functions that show a session and pass the user's requests to it.
#pragma once

#include "app/layout.h"
#include "app/panels/stability_tab.h"
#include "engine/session/session.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// State of the tuning panel between frames. A typed number becomes active only when it is
/// complete, as typing 0.5 passes through 0.
struct TuningPanelState {
    std::optional<std::size_t> typing; ///< which parameter
    double typed = 0.0;
    StabilityTabState stability;
};

/// The six parameters with derived quantities, and a second tab with their stability.
void draw_tuning_panel(session::Session &session, TuningPanelState &state, const Rectangle &place);

/// State of the servo panel between frames.
struct ServoPanelState {
    std::string record_error; ///< why the last record could not be started
};

/// State, rate, jitter, compute time, recording, limits, and refused privileges.
void draw_servo_panel(session::Session &session, ServoPanelState &state, const Rectangle &place);

/// Sliders to lower the safety limits; opened by the servo panel.
void draw_limits_popup(session::Session &session);

/// State of the scene panel between frames.
struct ScenePanelState {
    std::vector<std::filesystem::path> files; ///< offered in the list
    std::string typed;                        ///< path being typed
};
void draw_scene_panel(session::Session &session, ScenePanelState &state, const Rectangle &place);

/// Within the scene panel: the model selected by the scene's tolerance, and the active model.
void draw_model_tab(session::Session &session);

/// Over the scene: how to use the mouse, and a banner after a safety trip.
void draw_scene_overlay(session::Session &session, const Rectangle &view, float scale);

} // namespace springdrive::app
