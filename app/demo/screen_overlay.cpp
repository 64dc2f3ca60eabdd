// What stands over the scene and below it: messages, read-outs, the window's menu, the first
// minute.
#include "app/demo/screen.h"

#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "base/input_error.h"

#include <iostream>

namespace springdrive::app {

bool Screen::shows_start() const {
    return habits_.wants_start() && !assistant_.is_open() && !opened_.is_shown() &&
           !plot_panel_.is_large && // nor is there a scene to speak of
           session_.device_choice().kind == factory::DeviceKind::simulated;
}

void Screen::obey(SceneAction action) {
    switch (action) {
    case SceneAction::none:
        return;
    case SceneAction::reset:
        session_.servo().let_go_on();
        return;
    case SceneAction::go_on:
        toggle_pause();
        return;
    case SceneAction::show_present:
        opened_.view = RecordView::present;
        return;
    case SceneAction::zero:
        if (const std::string error =
                error_text_of([this] { session_.zero_device(Vector3::Zero()); });
            !error.empty()) {
            habits_.say(error, true);
        }
        return;
    case SceneAction::retract_hand:
        lift_.start();
        return;
    }
}

/// Beside the plots made large there is only a strip of the scene, for messages and the stop.
bool Screen::has_room_for_cards(const Rectangle &view) const {
    constexpr float kMin = 160.0F; // what lesson, views and help take below each other
    return view.size.y > kMin * window_.scale();
}

bool Screen::shows_lesson() const {
    return !kiosk_ && !opened_.is_shown() && !assistant_.is_open();
}

Rectangle Screen::free_part(const Rectangle &view) const {
    if (kiosk_) {
        return exhibit::free_in_kiosk(view);
    }
    SideCards cards;
    if (has_room_for_cards(view)) {
        cards.left = shows_lesson()
                         ? width_of_scene_card(session_, scene_panel_.card, view, window_.scale())
                         : 0.0F;
        cards.right = legend_width_;
    }
    Rectangle free = free_of_overlays(view, cards, opened_.is_shown(), window_.scale());
    if (!has_panels()) {
        free.size.y -= height_of_read_outs(view);
    }
    return free;
}

/// Nothing else stands over it: no menu, no views, no files.
void Screen::draw_over_kiosk(const Rectangle &view, bool is_inside) {
    draw_captions(session_, view_control_.camera(), view, window_.scale(), exhibit::kArrow);
    kiosk_->update({{session_, editor_, lift_}, view_control_, ImGui::GetIO().DeltaTime, is_inside},
                   view, window_.large_text());
    if (const std::string error = kiosk_->take_error(); !error.empty()) {
        std::cerr << "springdrive: " << error << '\n';
    }
    if (view_control_.holds_hand()) {
        lift_.stop();
    }
    lift_.update(session_, is_inside, ImGui::GetIO().DeltaTime);
}

void Screen::draw_over_scene(const Rectangle &view) {
    const bool is_inside = tip_inside_.at(session_.scenes().now().scene, session_.scenes().id(),
                                          session_.latest().tip_m, ImGui::GetTime());
    if (kiosk_) {
        draw_over_kiosk(view, is_inside);
        return;
    }
    SceneOverlay shown{situation_of(session_, opened_), habits_.notice(),
                       !shows_start() && has_room_for_cards(view)};
    shown.now.is_inside = is_inside && !assistant_.is_open();
    const SceneAnswer answer = draw_scene_overlay(session_, opened_, shown, view, window_.scale());
    obey(answer.action);
    if (shows_lesson() && has_room_for_cards(view)) {
        draw_captions(session_, view_control_.camera(), view, window_.scale());
        draw_scene_card(session_, editor_, scene_panel_.files, scene_panel_.card, answer.free,
                        window_.scale());
    }
    if (view_control_.holds_hand()) {
        lift_.stop();
    }
    lift_.update(session_, is_inside, ImGui::GetIO().DeltaTime);
    guide_.update({session_, editor_, lift_}, ImGui::GetTime());
    if (!has_panels()) {
        const servo::ServoSample now =
            opened_.is_shown() ? opened_.playback().sample() : session_.latest();
        draw_read_outs(opened_.subject(session_), now.tuning.map, view, window_.large_text(),
                       window_.scale());
    }
    if (has_room_for_cards(view)) {
        if (const auto viewpoint = draw_view_buttons(view, window_.scale())) {
            view_control_.look_from(*viewpoint);
        }
        legend_width_ =
            draw_legend(habits_.settings().shown, habits_.settings().opens_legend,
                        shown_values_.last(), view, bottom_of_view_buttons(view, window_.scale()),
                        width_of_view_buttons(), window_.scale());
    }
    const WindowMenuChoice choice = draw_window_menu(habits_, view, window_.scale());
    obey(choice.order);
    if (!choice.opened.empty()) {
        open(choice.opened);
    }
}

void Screen::draw_start(const Rectangle &place) {
    if (place.size.y <= 0.0F) {
        return;
    }
    const StartAnswer answer = draw_start_card(place, start_height_);
    if (answer == StartAnswer::got_it) {
        habits_.settings().dismissed_start = true;
    } else if (answer == StartAnswer::keys) {
        shows_keys_ = true;
    } else if (answer == StartAnswer::wrong_direction) {
        open(asset_folder() / "scenes/wrong_direction.gltf");
    }
}

/// Among recent files: scenes that are not included, and records, once they are there.
void Screen::note_opened() {
    const session::RecordPlayback &playback = opened_.playback();
    const std::filesystem::path record = !playback.is_open() ? std::filesystem::path()
                                         : opened_.run()     ? opened_.run()->folder
                                                             : playback.record().file;
    if (record != noted_record_ && !record.empty()) {
        note_recent(habits_.settings(), record);
    }
    noted_record_ = record;
}

} // namespace springdrive::app
