#include "app/demo/screen.h"

#include "app/host/folders.h"
#include "app/host/output.h"
#include "app/host/process.h"
#include "app/view/pick.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "device/core/phantom/kinematics.h"

#include <imgui_internal.h> // ClosePopupsOverWindow

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace springdrive::app {

namespace {

/// Four samples take three times as long where the processor draws.
constexpr int kSamples = 4;

constexpr double kUploadPerFrame_s = 0.25 * kFrame_s; // a large scene takes several frames

/// The glTF files of a folder, sorted by name.
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

/// Of an included scene, its place in the tour; all others come behind.
std::size_t place_in_tour(const std::filesystem::path &file) {
    const auto found = std::ranges::find(exhibit::kTour, file.stem(), &exhibit::TourStop::scene);
    return static_cast<std::size_t>(found - exhibit::kTour.begin());
}

/// The included scenes in the order of the tour, and those in the folder of the requested scene.
std::vector<std::filesystem::path> offered_scenes(const std::filesystem::path &scene) {
    const std::filesystem::path own = asset_folder() / "scenes";
    std::vector<std::filesystem::path> files = scenes_in(own);
    std::ranges::stable_sort(files, {}, place_in_tour);
    std::error_code ignored;
    if (!std::filesystem::equivalent(scene.parent_path().empty() ? "." : scene.parent_path(), own,
                                     ignored)) {
        const std::vector<std::filesystem::path> beside =
            scenes_in(scene.parent_path().empty() ? "." : scene.parent_path());
        files.insert(files.end(), beside.begin(), beside.end());
    }
    return files;
}

/// What is typed goes before what is remembered.
Window::Wish wish_of(const DemoOptions &options, const Settings &settings) {
    return {.size = {options.width, options.height},
            .remembered = {settings.width, settings.height},
            .scale = options.scale,
            .text_size = options.scale > 0.0 ? 1.0 : settings.text_size,
            .frame_s = options.session.lockstep ? kFrame_s : 0.0,
            .is_kiosk = options.kiosk,
            .is_unseen = options.unseen};
}

} // namespace

Screen::Screen(const DemoOptions &options, session::Session &session)
    : habits_(options.settings), window_("springdrive", wish_of(options, habits_.settings())),
      session_(session), renderer_(Window::draws_in_software() ? 0 : kSamples), editor_(session),
      keeps_frames_(!options.screenshot.empty()) {
    habits_.update(window_); // its panels
    scene_panel_.files = offered_scenes(options.session.scene);
    scene_panel_.plant.draw_assistant_offer = [this] { offer_assistant(session_, assistant_); };
    if (options.kiosk) {
        kiosk_.emplace(session, options.day_log);
        window_.set_room(Window::kRoomForScene);
    }
    assistant_.opens_itself = !options.unattended() && !kiosk_;
    opens_assistant_ = options.assistant;
    // Until the first frame, in which the assistant decides.
    session.keep_released(session.device_choice().kind != factory::DeviceKind::simulated);
    if (!window_.font_warning().empty()) {
        std::cerr << "springdrive: " << window_.font_warning() << '\n';
    }
    show_scene();
    upload(std::numeric_limits<double>::infinity()); // the first frame shows it
    if (!options.opened.empty()) {
        opened_.open(options.opened);
    }
}

void Screen::take_orders() {
    if (window_.take_emergency_stop()) {
        session_.emergency_stop();
    }
    for (const KeyPress &key : window_.take_keys()) {
        kiosk_ ? kiosk_->obey(key) : obey(key);
    }
    for (const std::filesystem::path &file : window_.take_dropped_files()) {
        if (!kiosk_) { // which has its own scenes
            open(file);
        }
    }
}

/// By its kind.
void Screen::open(const std::filesystem::path &file) {
    std::error_code ignored;
    if (file.extension() == ".rec" || std::filesystem::is_directory(file, ignored)) {
        opened_.open(file);
    } else if (file.extension() == ".csv") {
        follow_path_file(session_, scene_panel_.hand, file);
    } else {
        session_.request_scene(file);
    }
}

void Screen::obey(const KeyPress &key) {
    const bool keeps = key.with_ctrl && key.name == "s";
    if (!keeps && ImGui::IsMouseDown(ImGuiMouseButton_Left) && ImGui::IsAnyItemActive()) {
        return; // a slider is being dragged: it would go on in another slot or step
    }
    if ((!key.with_ctrl && move_by_key(key)) || key.is_repeated) {
        return;
    }
    if (const WindowOrder order = window_order_of(key); order != WindowOrder::none) {
        obey(order);
        return;
    }
    const bool is_redo = key.with_ctrl && (key.name == "y" || (key.name == "z" && key.with_shift));
    if (key.name == "F6") {
        go_to_next_panel(key.with_shift);
    } else if (is_redo) {
        editor_.redo();
    } else if (key.with_ctrl && key.name == "z") {
        editor_.undo();
    } else if (keeps) {
        keep();
    } else if (!key.with_ctrl) {
        obey_plain(key.name);
    }
}

/// The hand, and the view. False if the key is for neither.
bool Screen::move_by_key(const KeyPress &key) {
    constexpr double kStep_m = 1e-3;
    constexpr double kFineStep_m = 1e-4;
    // On the floor, away from who looks.
    const Vector3 right = view_control_.camera().right();
    const Vector3 away = Vector3::UnitY().cross(right);
    const std::array<std::pair<std::string_view, Vector3>, 6> moves{{{"w", away},
                                                                     {"s", -away},
                                                                     {"d", right},
                                                                     {"a", -right},
                                                                     {"e", Vector3::UnitY()},
                                                                     {"q", -Vector3::UnitY()}}};
    for (const auto &[name, direction] : moves) {
        if (key.name == name) {
            if (!opened_.is_shown() && !session_.hand().follows_path()) {
                session_.hand().move_to(session_.hand().target_m() +
                                        (key.with_shift ? kFineStep_m : kStep_m) * direction);
            }
            return true;
        }
    }
    return view_control_.obey(key.name);
}

void Screen::obey_plain(const std::string &key) {
    session::ServoRun &servo = session_.servo();
    if (key == "b") {
        editor_.toggle_slot();
    } else if (key == "m") {
        editor_.toggle_map();
    } else if (key == "h") {
        toggle_hold(plot_panel_, opened_.subject(session_).store);
    } else if (key == "-" || key == "+" || key == "=") {
        move_in_time(plot_panel_, opened_.subject(session_).store, key == "-" ? 1.5 : 1.0 / 1.5,
                     0.0);
    } else if (key == "PageUp" || key == "PageDown") {
        move_in_time(plot_panel_, opened_.subject(session_).store, 1.0,
                     key == "PageUp" ? -0.25 : 0.25);
    } else if (key == "r" && opened_.playback().is_open()) {
        opened_.view = opened_.is_shown() ? RecordView::present : RecordView::instead_of;
    } else if (opened_.is_shown() && (key == "p" || key == "." || key == ",")) {
        obey_on_record(key);
    } else if (key == "p") {
        toggle_pause();
    } else if (key == ".") {
        servo.step();
    } else if (key == "Escape") {
        escape();
    }
}

void Screen::obey(WindowOrder order) {
    if (order == WindowOrder::toggle_keys) {
        shows_keys_ = !shows_keys_;
    } else if (order == WindowOrder::tour) {
        opened_.view = RecordView::present;
        guide_.begin({session_, editor_, lift_});
        habits_.say("the tour begins: all scenes, by a scripted hand; Esc ends it");
    } else {
        habits_.obey(order, window_);
    }
}

void Screen::obey_on_record(const std::string &key) {
    session::RecordPlayback &playback = opened_.playback();
    if (key == "p") {
        playback.play(!playback.is_playing());
    } else {
        playback.step(key == "." ? 1 : -1);
    }
}

void Screen::toggle_pause() {
    session::ServoRun &servo = session_.servo();
    if (servo.speed() > 0.0) {
        speed_before_pause_ = servo.speed();
        servo.set_speed(0.0);
    } else {
        servo.set_speed(speed_before_pause_);
    }
}

/// For keys: to the first widget of the next panel, or to the one that was left last.
void Screen::go_to_next_panel(bool backwards) {
    constexpr std::array<const char *, 11> kNames{"message", "Tuning",    "Servo",  "Scene",
                                                  "Plots",   "record",    "lesson", "Start",
                                                  "window",  "Assistant", "legend"};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
        panel_ = (panel_ + (backwards ? kNames.size() - 1 : 1)) % kNames.size();
        ImGuiWindow *const window = ImGui::FindWindowByName(kNames[panel_]);
        if (window != nullptr && window->WasActive) {
            ImGui::FocusWindow(window);
            ImGui::NavInitWindow(window, false);
            ImGui::GetCurrentContext()->NavDisableHighlight = false;
            return;
        }
    }
}

/// One thing at a time, the topmost first. ImGui itself ends typing.
void Screen::escape() {
    if (ImGui::GetIO().WantTextInput) {
        return;
    }
    if (session_.is_in_exclusive_use()) {
        session_.end_exclusive_use();
    } else if (shows_keys_) {
        shows_keys_ = false;
    } else if (had_popup_) {
        ImGui::ClosePopupsOverWindow(nullptr, false); // if ImGui did not
    } else if (guide_.is_on()) {
        guide_.end({session_, editor_, lift_});
    } else if (plot_panel_.is_large) {
        plot_panel_.is_large = false;
    } else if (window_.is_full_screen()) {
        window_.toggle_full_screen();
    }
}

bool Screen::is_over() const {
    return asked_to_end() || window_.is_closing() ||
           (kiosk_ && kiosk_->ending() != exhibit::KioskEnding::none);
}

void Screen::draw() {
    window_.begin_frame();
    const auto [view, state] = draw_contents();
    const std::optional<std::filesystem::path> picture = keeper_.take_picture();
    const std::optional<std::filesystem::path> asked = habits_.take_picture();
    window_.keep_frames(keeps_frames_ || plot_panel_.picture.has_value() || picture.has_value() ||
                        asked.has_value());
    window_.clear();
    draw_scene(view, state);
    window_.end_frame();
    write_pictures(picture);
    if (asked) {
        habits_.note_picture(*asked, error_text_of([&] {
            write_file(
                *asked, [this](std::ostream &out) { window_.write_screenshot(out); },
                Existing::keep);
        }));
    }
}

void Screen::write_pictures(const std::optional<std::filesystem::path> &of_session) {
    const auto picture_of = [this](const Rectangle &part) {
        return [this, part](std::ostream &out) { window_.write_screenshot(out, part); };
    };
    if (plot_panel_.picture) {
        const auto [file, where] = *std::exchange(plot_panel_.picture, {});
        plot_panel_.message = save_as(file, picture_of(where));
    }
    if (of_session) {
        const std::string error = error_text_of([&] {
            write_file(*of_session, picture_of({}), Existing::keep);
            keeper_.note_picture(*of_session, session_, log_);
        });
        if (!error.empty()) {
            keeper_.fail(error);
        }
    }
}

void Screen::keep() {
    session_.tuning().let_go();
    keeper_.keep(session_, log_);
}

std::string Screen::finish() {
    habits_.finish(window_);
    session_.tuning().let_go();
    log_.update(session_);
    keeper_.finish(session_, log_);
    return keeper_.folder().empty() ? std::string() : keeper_.error();
}

/// All but the scene itself, which is drawn once it is known whether the frame is kept.
Screen::SceneView Screen::draw_contents() {
    take_orders();
    if (shown_scene_ != session_.scenes().id()) {
        show_scene();
    }
    upload(kUploadPerFrame_s);
    note_opened();
    habits_.update(window_);
    if (has_panels()) { // the assistant's, too
        window_.set_room(Window::kRoomForPanels);
    }
    const Layout places = current_layout();
    opened_.update(ImGui::GetIO().DeltaTime, session_.tuning().now());
    const ViewState state = view_state();
    view_control_.update(session_, state, places.scene_view, free_part(places.scene_view),
                         !opened_.is_shown());
    view_control_.report(session_, state, places.scene_view);
    editor_.update();
    if (std::exchange(opens_assistant_, false)) {
        assistant_.open(session_);
    }
    assistant_.update(session_);
    draw_panels(places);
    draw_over_scene(places.scene_view);
    draw_start(places.start);
    // Raised by its first frame only: to be raised in each would end what is done with the mouse.
    shows_keys_ = shows_keys_ && !ImGui::IsMouseClicked(ImGuiMouseButton_Left);
    if (shows_keys_) {
        draw_keys_overlay({{0.0F, 0.0F}, ImGui::GetIO().DisplaySize});
    }
    had_popup_ = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId);
    return {places.scene_view, state};
}

/// The assistant needs its place also where panels are hidden.
bool Screen::has_panels() const {
    return !kiosk_ && (assistant_.is_open() || !habits_.settings().hides_panels);
}

void Screen::draw_panels(const Layout &places) {
    if (has_panels() && !assistant_.is_open()) {
        draw_tuning_panel(session_, editor_, tuning_panel_, places.tuning);
    } else if (assistant_.is_open()) {
        draw_assistant_panel(session_, assistant_, assistants_doctor_, places.assistant);
    }
    if (!ImGui::IsAnyItemActive()) {
        session_.tuning().let_go();
    }
    log_.update(session_);
    keeper_.update(session_);
    if (has_panels() && !assistant_.is_open()) {
        if (draw_servo_panel(session_, log_, keeper_, servo_panel_, places.servo)) {
            keep();
        }
        draw_scene_panel(session_, editor_, opened_, scene_panel_, places.scene);
    }
    if (has_panels()) {
        draw_plot_panel(session_, opened_.subject(session_), session_.tuning().slots(), plot_panel_,
                        places.plots, window_.scale());
    }
}

Layout Screen::current_layout() const {
    const Window::Size pixels = window_.size();
    const ImVec2 size{static_cast<float>(pixels.width), static_cast<float>(pixels.height)};
    const float plots_height = plot_panel_.is_large ? size.y : plot_panel_.height * window_.scale();
    const Layout places = has_panels() ? layout(size, window_.scale(), plots_height,
                                                assistant_.is_open() ? kAssistant : kPanels)
                                       : layout_of_scene(size);
    constexpr float kExpectedHeight = 100.0F; // until it has been drawn
    return !shows_start()
               ? places
               : with_start_card(places, start_height_ > 0.0F ? start_height_
                                                              : kExpectedHeight * window_.scale());
}

void Screen::show_scene() {
    const scene::Scene &scene = session_.scenes().now().scene;
    renderer_.set_scene(scene);
    view_control_.look_from(Viewpoint::home);
    shown_scene_ = session_.scenes().id();
    std::error_code ignored;
    if (!std::filesystem::equivalent(scene.file.parent_path(), asset_folder() / "scenes",
                                     ignored)) {
        note_recent(habits_.settings(), scene.file);
    }
    print(scene.warnings);
}

void Screen::upload(double duration_s) {
    renderer_.upload(duration_s);
    print(renderer_.take_warnings());
}

void Screen::print(const std::vector<std::string> &warnings) const {
    for (const std::string &warning : warnings) {
        std::cerr << "springdrive: " << session_.scenes().now().scene.file.filename().string()
                  << ": " << warning << '\n';
    }
}

void Screen::draw_scene(const Rectangle &view, const ViewState &state) {
    view_control_.draw(renderer_, state, view, window_);
    ui::enter_at({view.corner, {0.0F, 0.0F}}, "marks", "drawing", renderer_.marks_text());
}

ViewState Screen::view_state() {
    const bool is_record = opened_.is_shown();
    const servo::ServoSample now = is_record ? opened_.playback().sample() : session_.latest();
    const device::DeviceDescription &device =
        is_record ? opened_.playback().record().device : session_.description();
    servo::ServoSample shown = now;
    const auto theta_rad = is_record ? std::nullopt : assistant_.theta_rad();
    if (theta_rad) {
        shown.theta_rad = *theta_rad;
        shown.tip_m = device::tip_position_m(device.geometry,
                                             device::joint_from_motor(device.geometry, *theta_rad));
    }
    ViewState state = view_of(shown, device, session_.scenes().now().surface);
    if (!is_record && !theta_rad) {
        state.hand_target_m = session_.hand().target_m();
    }
    state.hand_held = view_control_.holds_hand();
    state.shown = habits_.settings().shown;
    state.touch = shown_values_.at(state.shown, device, now, opened_.subject(session_));
    if (kiosk_) {
        state.arrow = exhibit::kArrow;
    }
    return state;
}

} // namespace springdrive::app
