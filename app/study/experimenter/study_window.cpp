#include "app/study/experimenter/study_window.h"

#include "app/host/ending_signal.h"
#include "app/study/experimenter/experimenter_view.h"
#include "app/study/participant/input_times.h"
#include "app/study/participant/monitors.h"
#include "app/widgets/widgets.h"
#include "base/error_text.h"
#include "engine/study/conduct/conduct.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace springdrive::app::study_screen {

namespace {

constexpr float kButtonColumn = 24.0F; ///< of buttons, in heights of text
constexpr float kHidden = 6.5F;        ///< the panel of stimuli while they are hidden, the same
constexpr float kStimuliShare = 0.5F;  ///< of the window's height, while they are shown

} // namespace

StudyWindow::StudyWindow(const StudyWindowOptions &options, session::Session &session,
                         study::StudyStore &store, const study::Protocol &protocol)
    : session_(session), store_(store), protocol_(protocol),
      window_(
          "springdrive: experimenter",
          {.size = options.size, .remembered = {}, .scale = options.scale, .swaps_at_once = true}),
      renderer_(Window::draws_in_software() ? 0 : 4), participant_window_(options.participant),
      fit_(protocol), frame_end_s_(steady_clock_s()) {}

std::vector<study::Setting> StudyWindow::facts() const {
    const Window::Size pixels = participant_window_.framebuffer();
    std::vector<study::Setting> facts{
        {"picture_width_px", static_cast<double>(pixels.width)},
        {"picture_height_px", static_cast<double>(pixels.height)},
        {"frame_time_ms", 1e3 * participant_window_.frame_s()},
    };
    for (const MonitorFacts &monitor : monitors_there()) {
        if (monitor.name == participant_window_.monitor()) {
            facts.push_back({"monitor", monitor.name});
            if (monitor.width_mm > 0 && monitor.height_mm > 0) {
                facts.push_back({"monitor_width_mm", static_cast<double>(monitor.width_mm)});
                facts.push_back({"monitor_height_mm", static_cast<double>(monitor.height_mm)});
            }
        }
    }
    return facts;
}

void StudyWindow::show_scene(const scene::Scene &scene, const scene::TouchSpot &spot) {
    spot_m_ = spot.point_m;
    participant_window_.show_scene(scene, spot, session_.description().workspace);
}

/// There is one keyboard: a click of the experimenter takes it, and what the participant then
/// types would be lost. Only where the participant's window covers nothing of this one.
void StudyWindow::give_keys_back() {
    const bool is_typing = ImGui::GetIO().WantTextInput;
    const bool is_clicking = ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (participant_window_.is_full_screen() && window_.has_focus() && !is_typing && !is_clicking) {
        participant_window_.take_focus();
    }
}

void StudyWindow::store_note(const SittingState &state, const std::string &text) {
    store_.append(study::Note{study::utc_now(), "note", text, state.participant, state.session});
}

void StudyWindow::renew_fit(const SittingState &state) {
    if (state.trials.size() != fitted_trials_ && state.trial) {
        fitted_trials_ = state.trials.size();
        const study::StudyContents contents = store_.contents();
        fit_.request(contents, state.participant, study::condition_of(protocol_, *state.trial),
                     study::session_of(contents, state.session).device);
    }
}

void StudyWindow::draw_view(const Rectangle &place) {
    if (shown_scene_ != session_.scenes().id()) {
        shown_scene_ = session_.scenes().id();
        renderer_.set_scene(session_.scenes().now().scene);
        renderer_.upload(std::numeric_limits<double>::infinity());
    }
    const ViewState state = experimenter_view(session_.latest(), session_.description(),
                                              session_.scenes().now().surface,
                                              panel_.shows_stimuli ? std::nullopt : spot_m_);
    const ImVec2 margin{0.04F * place.size.x, 0.04F * place.size.y};
    const Rectangle free{{place.corner.x + margin.x, place.corner.y + margin.y},
                         {place.size.x - 2.0F * margin.x, place.size.y - 2.0F * margin.y}};
    view_control_.update(session_, state, place, free, false);
    view_control_.draw(renderer_, state, place, window_);
}

void StudyWindow::draw_experimenter(const SittingState &state, ExperimenterActs &acts) {
    const Window::Size size = window_.size();
    const float line = ImGui::GetFontSize();
    const ImVec2 whole{static_cast<float>(size.width), static_cast<float>(size.height)};
    const float column = std::min(kButtonColumn * line, 0.45F * whole.x);
    const float left = whole.x - column;
    const float stimuli = panel_.shows_stimuli ? kStimuliShare * whole.y : kHidden * line;
    draw_view({{0.0F, 0.0F}, {left, whole.y - stimuli}});
    acts = draw_experimenter_panel(panel_, {{left, 0.0F}, {column, whole.y}}, state, session_,
                                   protocol_);
    draw_stimuli(panel_, {{0.0F, whole.y - stimuli}, {left, stimuli}}, state, protocol_,
                 fit_.latest());
}

/// What the participant sees, for tests: the plates at their places in that window, in its pixels.
void StudyWindow::report_participant(const SittingState &state, const ParticipantPicture &picture) {
    const auto enter = [](const char *name, std::string text, decltype(ShownItem::value) value = {},
                          const Rectangle &box = {}) {
        ui::report().enter({std::string("participant/") + name,
                            "text",
                            std::move(text),
                            std::move(value),
                            {},
                            box});
    };
    enter("heading", picture.heading);
    enter("text", picture.text);
    enter("step", std::string(description(state.step)));
    enter("phase", std::string(description(state.phase)));
    enter("trial", state.trial ? text_of(state.trial->place) : "");
    enter("interval", "", static_cast<double>(state.interval + 1));
    enter("servo_ahead_s", "", servo_ahead_s(session_.servo()));
    enter("longest_frame_s", "", std::exchange(longest_frame_s_, 0.0));
    const std::vector<PlacedChoice> &cards = participant_window_.layout().choices;
    for (std::size_t i = 0; i < cards.size(); ++i) {
        enter("choice", picture.choices.at(i).text, {}, cards[i].card);
    }
}

SittingFrame StudyWindow::show(const ParticipantPicture &picture, const SittingState &state) {
    window_.begin_frame();
    window_.clear();
    static_cast<void>(window_.take_keys());
    static_cast<void>(window_.take_dropped_files());
    renew_fit(state);
    ExperimenterActs acts;
    draw_experimenter(state, acts);
    give_keys_back();
    window_.end_frame();
    participant_window_.show(picture);
    const bool by_experimenter = window_.take_emergency_stop();
    const bool by_participant = participant_window_.take_emergency_stop();
    if (acts.emergency_stop || by_experimenter || by_participant) {
        session_.emergency_stop();
    }
    if (acts.zeroes_device) {
        panel_.error = error_text_of([this] { session_.zero_device(Vector3::Zero()); });
    }
    if (acts.note) {
        const std::string error = error_text_of([&] { store_note(state, *acts.note); });
        panel_.notes_of_today.push_back(error.empty() ? *acts.note : "not stored: " + error);
    }
    SittingFrame frame{participant_window_.take_inputs(session_.servo()), acts.orders};
    frame.orders.stops = frame.orders.stops || window_.is_closing() || asked_to_end();
    const double now_s = steady_clock_s();
    longest_frame_s_ = std::max(longest_frame_s_, now_s - std::exchange(frame_end_s_, now_s));
    if (ui::report().is_wanted()) {
        report_participant(state, picture);
    }
    return frame;
}

} // namespace springdrive::app::study_screen
