#include "app/demo.h"

#include "app/asset_folder.h"
#include "app/ending_signal.h"
#include "app/frame_pace.h"
#include "app/mouse.h"
#include "app/panels/layout.h"
#include "app/panels/panels.h"
#include "app/session.h"
#include "app/session_report.h"
#include "app/view/camera.h"
#include "app/view/renderer.h"
#include "app/window.h"
#include "base/input_error.h"
#include "device/phantom/kinematics.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <system_error>

namespace springdrive {

namespace {

constexpr double kUploadPerFrame_s = 0.25 * kFrame_s; // a large scene takes several frames

/// The glTF files of a folder, in order of their names.
std::vector<std::filesystem::path> scenes_in(const std::filesystem::path &folder) {
    std::vector<std::filesystem::path> files;
    std::error_code ignored;
    for (const auto &entry : std::filesystem::directory_iterator(folder, ignored)) {
        const std::string ending = entry.path().extension().string();
        if (ending == ".gltf" || ending == ".glb") {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// What lies around the scene asked for, and the project's own.
std::vector<std::filesystem::path> offered_scenes(const std::filesystem::path &scene) {
    const std::filesystem::path own = asset_folder() / "scenes";
    std::vector<std::filesystem::path> files = scenes_in(own);
    std::error_code ignored;
    if (!std::filesystem::equivalent(scene.parent_path().empty() ? "." : scene.parent_path(), own,
                                     ignored)) {
        const std::vector<std::filesystem::path> beside =
            scenes_in(scene.parent_path().empty() ? "." : scene.parent_path());
        files.insert(files.end(), beside.begin(), beside.end());
    }
    return files;
}

/// Everything that is on the screen, made once.
class Screen {
public:
    Screen(const DemoOptions &options, Session &session)
        : window_("springdrive", {options.width, options.height}, options.scale),
          session_(session) {
        scene_panel_.files = offered_scenes(options.session.scene);
        window_.keep_frames(!options.screenshot.empty());
        if (!window_.font_remark().empty()) {
            std::cerr << "springdrive: " << window_.font_remark() << '\n';
        }
        show_scene();
        renderer_.upload(std::numeric_limits<double>::infinity()); // the first frame shows it
    }

    void draw_frame() {
        window_.begin_frame();
        if (window_.take_emergency_stop()) {
            session_.emergency_stop();
        }
        for (const std::filesystem::path &file : window_.take_dropped_files()) {
            session_.request_scene(file);
        }
        if (shown_scene_ != session_.scene_id()) {
            show_scene();
        }
        renderer_.upload(kUploadPerFrame_s);
        const Layout places = current_layout();
        mouse_.apply(session_, camera_, places.scene_view);
        window_.clear();
        draw_scene(places.scene_view);
        draw_tuning_panel(session_, tuning_panel_, places.tuning);
        draw_servo_panel(session_, servo_panel_, places.servo);
        draw_scene_panel(session_, scene_panel_, places.scene);
        draw_force_direction_panel(session_, places.force_direction);
        draw_scene_overlay(session_, places.scene_view, window_.scale());
        window_.end_frame();
    }

    [[nodiscard]] const Window &window() const { return window_; }

private:
    [[nodiscard]] Layout current_layout() const {
        const Window::Size size = window_.size();
        return layout({static_cast<float>(size.width), static_cast<float>(size.height)},
                      window_.scale());
    }

    void show_scene() {
        const Scene &scene = session_.scene().scene;
        const Layout places = current_layout();
        renderer_.set_scene(scene);
        // All of the scene, and of the device at least up to its motors.
        const double motors_m = session_.device().geometry.forearm_m;
        const Vector3 upper_m =
            scene.upper_m.cwiseMax(Vector3(scene.upper_m.x(), motors_m + 0.03, scene.upper_m.z()));
        camera_.frame(scene.lower_m, upper_m,
                      places.scene_view.size.x / std::max(1.0F, places.scene_view.size.y));
        shown_scene_ = session_.scene_id();
        for (const std::string &remark : scene.remarks) {
            std::cerr << "springdrive: " << scene.file.filename().string() << ": " << remark
                      << '\n';
        }
    }

    void draw_scene(const Rectangle &view) {
        const Window::Size pixels = window_.framebuffer();
        const Window::Size size = window_.size();
        const float pixel_scale =
            static_cast<float>(pixels.width) / static_cast<float>(std::max(1, size.width));
        ViewportPixels viewport;
        viewport.x = static_cast<int>(view.corner.x * pixel_scale);
        viewport.y = pixels.height - static_cast<int>((view.corner.y + view.size.y) * pixel_scale);
        viewport.width = static_cast<int>(view.size.x * pixel_scale);
        viewport.height = static_cast<int>(view.size.y * pixel_scale);
        if (viewport.width > 0 && viewport.height > 0) {
            renderer_.draw(camera_, viewport, view_state(), pixel_scale * window_.scale());
        }
    }

    [[nodiscard]] ViewState view_state() const {
        const ServoSample &now = session_.latest();
        const DeviceDescription &device = session_.device();
        ViewState state;
        state.linkage =
            linkage_pose(device.geometry, joint_from_motor(device.geometry, now.theta_rad));
        state.tip_m = now.tip_m;
        state.proxy_m = now.contact.x0_m;
        state.touching = now.contact.touching;
        state.normal = now.contact.normal;
        state.tip_force_N = now.tip_force_N;
        state.hand_target_m = session_.hand_target_m();
        state.hand_held = mouse_.holds_hand();
        state.tripped = now.safety.state == SafetyState::tripped;
        state.workspace = device.workspace;
        state.floor_height_m = device.workspace.centre_m.y() - 0.5 * device.workspace.size_m.y();
        return state;
    }

    Window window_;
    Session &session_;
    Renderer renderer_;
    Camera camera_;
    MouseInView mouse_;
    TuningPanelState tuning_panel_;
    ServoPanelState servo_panel_;
    ScenePanelState scene_panel_;
    std::uint32_t shown_scene_ = 0;
};

} // namespace

bool run_demo(const DemoOptions &options) {
    Session session(options.session);
    Screen screen(options, session);
    note_ending_signals();
    for (const std::string &remark : session.start()) {
        std::cerr << "springdrive: " << remark << '\n';
    }
    FramePace pace;
    const bool lockstep = options.session.lockstep;
    for (int frame = 0; !asked_to_end() && !screen.window().is_closing(); ++frame) {
        const double elapsed_s = lockstep ? frame * kFrame_s : pace.elapsed_s();
        if ((options.frames > 0 && frame >= options.frames) ||
            (options.seconds > 0.0 && elapsed_s >= options.seconds - 1e-9)) {
            break;
        }
        session.advance(kFrame_s);
        screen.draw_frame();
        if (!lockstep) {
            pace.wait();
        }
    }
    session.stop();
    if (!options.screenshot.empty()) {
        screen.window().write_screenshot(options.screenshot);
    }
    if (options.unattended()) {
        write_session_report(std::cout, options.session, session);
        if (!options.screenshot.empty()) {
            std::cout << "screenshot: " << options.screenshot.string() << '\n';
        }
    }
    // Who sits before the window sees it stop.
    const bool stopped = options.unattended() && was_stopped(session);
    const bool well = record_is_whole(session) && !stopped;
    if (session.is_loading()) {
        // A scene is still being read, and nobody waits for it any more. The device has its safe
        // state and the files are written; the rest the system takes back.
        std::cout.flush();
        std::quick_exit(well ? 0 : 1);
    }
    return well;
}

} // namespace springdrive
