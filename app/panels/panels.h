// The panels: free functions that show a session and tell it what was asked for.
#pragma once

#include "app/panels/layout.h"
#include "app/panels/stability_tab.h"
#include "engine/session/session.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

/// What the tuning panel remembers between frames: a number is in force only once it is typed to
/// its end, since on the way from 1 to 0.5 stands 0.
struct TuningPanelState {
    std::optional<std::size_t> typing; ///< which parameter
    double typed = 0.0;
    StabilityTabState stability;
};

/// The six parameters with what follows from them, and behind a second tab how stable they are.
void draw_tuning_panel(session::Session &session, TuningPanelState &state, const Rectangle &place);

/// The angle between rendered force and surface normal over time, with both maps.
void draw_force_direction_panel(const session::Session &session, const Rectangle &place);

/// What the servo panel remembers between frames.
struct ServoPanelState {
    std::string record_error; ///< why the last record could not be made
};

/// State, rate, jitter, compute time, recording, limits, and what the system refused.
void draw_servo_panel(session::Session &session, ServoPanelState &state, const Rectangle &place);

/// The safety limits, to lower them; opened by the servo panel.
void draw_limits_popup(session::Session &session);

/// What the scene panel remembers between frames.
struct ScenePanelState {
    std::vector<std::filesystem::path> files; ///< offered in the list
    std::string typed;                        ///< path being typed
};
void draw_scene_panel(session::Session &session, ScenePanelState &state, const Rectangle &place);

/// Within the scene panel: which model the scene would get by its tolerance, and what runs.
void draw_model_tab(session::Session &session);

/// Over the scene: how to use the mouse, and a banner after a safety trip.
void draw_scene_overlay(session::Session &session, const Rectangle &view, float scale);

} // namespace springdrive::app
