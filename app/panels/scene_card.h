// Over the scene: what it is there to let one feel, and words on its parts.
#pragma once

#include "app/panels/tuning_editor.h"
#include "app/view/camera.h"
#include "app/view/view_state.h"
#include "app/widgets/rectangle.h"
#include "engine/session/session.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

namespace springdrive::app {

/// State of the plate between frames.
struct SceneCardState {
    std::uint32_t scene = 0;  ///< number of the scene that all of this is about
    bool is_put_away = false; ///< for this scene
    /// The angle from normal to push by map, as last measured.
    std::array<std::optional<double>, 2> angle_rad;
};

/// Of the plate, with its distance to what is beside it; 0 while it is not shown.
[[nodiscard]] float width_of_scene_card(const session::Session &session,
                                        const SceneCardState &state, const Rectangle &view,
                                        float scale);

/// A plate with the scene's title and sentence, in the upper left corner of `place`; buttons to the
/// scenes before and after it in `files`, and one to put it away. Where the scene says where to
/// touch, also the angles from the normal to the push, as measured with both maps.
void draw_scene_card(session::Session &session, TuningEditor &editor,
                     std::span<const std::filesystem::path> files, SceneCardState &state,
                     const Rectangle &place, float scale);

/// The captions of the scene's parts; and where to touch, until it is touched.
void draw_captions(const session::Session &session, const Camera &camera, const Rectangle &view,
                   float scale, const ArrowSize &arrow = {});

} // namespace springdrive::app
