// The whole user interface: the window, the 3-D view and the panels.
#pragma once

#include "app/assistant/assistant.h"
#include "app/demo/demo.h"
#include "app/demo/layout.h"
#include "app/demo/shown_values.h"
#include "app/exhibit/kiosk.h"
#include "app/exhibit/tour.h"
#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "app/panels/scene_overlay.h"
#include "app/panels/session_keeper.h"
#include "app/panels/tuning_editor.h"
#include "app/panels/window_habits.h"
#include "app/plots/plot_panel.h"
#include "app/stage/frame_loop.h"
#include "app/stage/touch_by_click.h"
#include "app/stage/view_control.h"
#include "app/view/renderer.h"
#include "app/window/window.h"
#include "engine/session/session.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::app {

class Screen : public Activity {
public:
    /// @param session  must outlive it
    /// @throw InputError if no window can be opened
    Screen(const DemoOptions &options, session::Session &session);

    /// When the window is closed, the exhibit has ended, or termination is requested.
    [[nodiscard]] bool is_over() const override;
    void draw() override;
    [[nodiscard]] ReportedWindow reported() const override {
        return {window_.size(), window_.scale(), window_.has_waiting_input()};
    }

    /// Once the session has stopped: completes the folder in which it is kept.
    /// @return why that was not possible; else empty
    std::string finish();

    [[nodiscard]] const Window &window() const { return window_; }

    /// Null unless this is a kiosk.
    [[nodiscard]] exhibit::Kiosk *kiosk() { return kiosk_ ? &*kiosk_ : nullptr; }

    /// Of the view.
    [[nodiscard]] const FrameLoad &frame_load() const { return renderer_.load(); }

private:
    struct SceneView {
        Rectangle place;
        ViewState state;
    };

    SceneView draw_contents();
    /// Of plots and session, once the frame that shows them is complete.
    void write_pictures(const std::optional<std::filesystem::path> &of_session);
    void keep();
    [[nodiscard]] Layout current_layout() const;
    [[nodiscard]] bool has_panels() const;
    [[nodiscard]] bool shows_start() const;
    void draw_panels(const Layout &places);
    void draw_over_scene(const Rectangle &view);
    [[nodiscard]] bool has_room_for_cards(const Rectangle &view) const;
    [[nodiscard]] bool shows_lesson() const;
    /// Of the scene's view: where device and scene are shown whole.
    [[nodiscard]] Rectangle free_part(const Rectangle &view) const;
    void draw_over_kiosk(const Rectangle &view, bool is_inside);
    void draw_start(const Rectangle &place);
    void take_orders();
    void obey(const KeyPress &key);
    void obey_plain(const std::string &key);
    void obey(WindowOrder order);
    void obey(SceneAction action);
    bool move_by_key(const KeyPress &key);
    void escape();
    void go_to_next_panel(bool backwards);
    void toggle_pause();
    void show_scene();
    void upload(double duration_s); ///< of the scene to the graphics card, for about that long
    void print(const std::vector<std::string> &warnings) const; ///< on the scene
    void draw_scene(const Rectangle &view, const ViewState &state);
    [[nodiscard]] ViewState view_state();
    void open(const std::filesystem::path &file);
    void note_opened();
    void obey_on_record(const std::string &key);

    WindowHabits habits_;
    float legend_width_ = 0.0F; ///< of its plate in the last frame
    Window window_;
    session::Session &session_;
    Renderer renderer_;
    ViewControl view_control_;
    TuningEditor editor_;
    TuningPanelState tuning_panel_;
    ServoPanelState servo_panel_;
    ScenePanelState scene_panel_;
    PlotPanelState plot_panel_;
    OpenedRecord opened_;
    assistant::Assistant assistant_{assistant::progress_folder()};
    bool opens_assistant_ = false; ///< with the first frame
    DoctorPopup assistants_doctor_;
    TipInside tip_inside_;
    HandRetraction lift_;
    ShownValues shown_values_;
    float start_height_ = 0.0F; ///< of the first minute's plate, as measured; 0: not yet
    std::optional<exhibit::Kiosk> kiosk_;
    exhibit::Guide guide_;
    SessionKeeper keeper_{output_dir()};
    EventLog log_;
    double speed_before_pause_ = 1.0;
    bool shows_keys_ = false; ///< the overlay with all keys
    bool had_popup_ = false;  ///< in the last frame
    std::size_t panel_ = 0;   ///< to which F6 went last
    std::uint32_t shown_scene_ = 0;
    std::filesystem::path noted_record_; ///< the last that was noted among recent files
    bool keeps_frames_;
};

} // namespace springdrive::app
