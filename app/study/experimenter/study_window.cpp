#include "app/study/experimenter/study_window.h"

#include "app/host/process.h"
#include "app/view/pick.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "device/core/phantom/kinematics.h"
#include "engine/servo/safety_status.h"
#include "engine/study/conduct/conduct.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

namespace springdrive::app::study_screen {

namespace {

constexpr float kButtonColumn = 24.0F; ///< of buttons, in heights of text
constexpr float kHidden = 6.5F;        ///< the panel of stimuli while they are hidden, the same
constexpr float kStimuliShare = 0.5F;  ///< of the window's height, while they are shown

constexpr double kMaxThought_s = 8.0; ///< between two keys of a note

bool is_in_trial(StudySessionStep step) {
    return step == StudySessionStep::interval || step == StudySessionStep::between_intervals ||
           step == StudySessionStep::response;
}

void show_course(const StudySessionState &state, bool shows_stimuli) {
    ui::text(kInk, "{}, session {}", state.participant, state.session);
    ui::wrapped(kFaintInk, "{} {}.", state.participant, description(state.step));
    ui::progress("progress", state.progress,
                 ui::formatted("{:.0f} % done", 100.0 * state.progress));
    ui::explain("trials stored, of the most that the protocol may take");
    if (state.trial) {
        ui::text(kInk, "{}", text_of(state.trial->place));
        if (state.intervals > 1) {
            ui::text(kFaintInk, "interval {} of {}: {}", state.interval + 1, state.intervals,
                     description(state.phase));
        } else {
            ui::text(kFaintInk, "{}", description(state.phase));
        }
    }
    const auto marked = std::ranges::count_if(
        state.trials, [](const study::Trial &trial) { return !trial.marks.empty(); });
    ui::text(kFaintInk, "trials stored: {}, marked: {}", state.trials.size(), marked);
    if (!state.trials.empty() && !state.trials.back().marks.empty()) {
        ui::wrapped(kWarning, "The last is marked{}{}.", shows_stimuli ? ": " : "",
                    shows_stimuli ? state.trials.back().marks.front() : "");
    }
    if (state.step == StudySessionStep::in_break) {
        ui::text(kInk, "{:.0f} s of the break are left", std::max(0.0, state.left_s));
    }
}

void show_device(const session::Session &session, bool shows_stimuli) {
    const servo::ServoSample &now = session.latest();
    switch (now.safety.state) {
    case servo::SafetyState::running:
        ui::text(kGood, "the motors run");
        break;
    case servo::SafetyState::tripped:
        ui::wrapped(kDanger, "stopped: {}{}", servo::description(now.safety),
                    session.servo().is_held_stopped() ? "; it stays so until you let it go on"
                                                      : "");
        break;
    case servo::SafetyState::waiting:
    case servo::SafetyState::starting:
    case servo::SafetyState::releasing:
        ui::text(kWarning, "{}",
                 !session.is_zeroed()   ? "waits to be zeroed"
                 : now.contact.touching ? "waits until the tip is lifted off the surface"
                                        : "waits for the tip to rest in free space");
        break;
    }
    std::string windings;
    for (const servo::WindingStatus &winding : now.winding) {
        windings += ui::formatted("{}{:.0f}", windings.empty() ? "" : ", ",
                                  0.5 * (winding.min_C + winding.max_C));
    }
    ui::text(kFaintInk, "windings {} °C", windings);
    ui::explain("the middle of the safety monitor's bounds, motor by motor");
    if (shows_stimuli) {
        ui::text(kFaintInk, "force {:.1f} N of {:.1f}", now.tip_force_N.norm(),
                 now.limits.tip_force_N);
    }
    ui::text(now.missed_in_a_row > 0 ? kWarning : kFaintInk, "deadlines missed: {}",
             session.servo().statistics().missed_deadlines());
}

/// Two steps: what ends a session is not done by a slip.
void confirm_end(ExperimenterPanelState &panel, ExperimenterOrders &orders) {
    if (panel.asked == EndAsked::nothing) {
        if (ui::button("Stop the session")) {
            panel.asked = EndAsked::stop;
        }
        ui::explain("ends it now; springdrive study resume goes on with it later, also on another "
                    "day");
        ImGui::SameLine();
        if (ui::button("Participant leaves")) {
            panel.asked = EndAsked::leave;
        }
        ui::explain("ends it now, and stores that it was the participant's wish");
        return;
    }
    ui::text(kWarning, "{}",
             panel.asked == EndAsked::stop ? "Stop the session now?"
                                           : "The participant leaves now?");
    if (ui::button("Yes")) {
        (panel.asked == EndAsked::stop ? orders.stops : orders.participant_leaves) = true;
    }
    ImGui::SameLine();
    if (ui::button("No, go on")) {
        panel.asked = EndAsked::nothing;
    }
}

void take_note(ExperimenterPanelState &panel, std::optional<std::string> &note) {
    ImGui::SetNextItemWidth(-1.0F);
    const std::string before = panel.note;
    const bool is_entered =
        ui::text_field("##note", "a note, without names: Enter stores it", panel.note);
    const bool is_typing = ImGui::IsItemActive();
    if (ImGui::IsItemActivated() || panel.note != before) {
        panel.typed_s = ImGui::GetTime();
    } else if (is_typing && ImGui::GetTime() - panel.typed_s > kMaxThought_s) {
        ImGui::SetWindowFocus(nullptr);
    }
    if (is_typing) {
        ui::wrapped(kWarning,
                    "There is one keyboard: answers and the space bar are typed here now, and F12 "
                    "stops the device. After some seconds without a key they are the "
                    "participant's again.");
    }
    const bool has_words = panel.note.find_first_not_of(' ') != std::string::npos;
    if (is_entered && has_words) {
        note = std::exchange(panel.note, {});
    }
    std::for_each(panel.notes_of_today.rbegin(), panel.notes_of_today.rend(),
                  [](const std::string &said) { ui::wrapped(kFaintInk, "{}", said); });
}

/// The column of buttons, the course of the session and the notes.
ExperimenterActs draw_experimenter_panel(ExperimenterPanelState &panel, const Rectangle &place,
                                         const StudySessionState &state,
                                         const session::Session &session,
                                         const study::Protocol &protocol) {
    ExperimenterActs acts;
    const ui::Panel window("Session", place);
    ui::wrapped(kInk, "{}", protocol.title);
    ImGui::Separator();
    show_course(state, panel.shows_stimuli);
    ImGui::Separator();
    show_device(session, panel.shows_stimuli);
    ImGui::PushStyleColor(ImGuiCol_Button, ImVec4(0.62F, 0.13F, 0.12F, 1.0F));
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ImVec4(0.75F, 0.18F, 0.16F, 1.0F));
    acts.emergency_stop = ui::button("STOP the device (F12)", {-1.0F, 0.0F});
    ImGui::PopStyleColor(2);
    const bool is_stopped = session.latest().safety.state == servo::SafetyState::tripped;
    {
        const ui::Disabled disabled(!is_stopped);
        acts.orders.resets_device = ui::button("Let the device go on", {-1.0F, 0.0F});
        ui::explain("after a stop by hand, or by the switch of the device's board; after others it "
                    "goes on by itself, 3 s later");
    }
    if (!session.is_zeroed()) {
        acts.zeroes_device = ui::button("It is in its zero pose", {-1.0F, 0.0F});
        ui::explain("hold the upper arm level and the forearm hanging, the tip at the origin, and "
                    "press this: the device does not know its angles yet");
        if (!panel.error.empty()) {
            ui::wrapped(kDanger, "{}", panel.error);
        }
    }
    ImGui::Separator();
    if (ui::button(panel.is_paused ? "Go on###pause" : "Pause###pause")) {
        panel.is_paused = !panel.is_paused;
    }
    ui::explain("before the next trial");
    ImGui::SameLine();
    acts.orders.skips_to_break = ui::button("Break");
    ui::explain("before the next trial, as long as a break within a block");
    ImGui::SameLine();
    {
        const ui::Disabled disabled(!is_in_trial(state.step)); // others are stored, or not begun
        acts.orders.repeats = ui::button("Repeat this trial");
        ui::explain("the present trial is marked, does not count, and comes again later in the "
                    "block");
    }
    confirm_end(panel, acts.orders);
    ImGui::Separator();
    take_note(panel, acts.note);
    acts.orders.is_paused = panel.is_paused;
    return acts;
}

std::string answer_of(const study::Trial &trial) {
    if (const auto *chosen = std::get_if<study::Chosen>(&trial.response)) {
        return ui::formatted("{}{}", chosen->alternative,
                             trial.is_correct ? (*trial.is_correct ? ", right" : ", wrong") : "");
    }
    if (const auto *said = std::get_if<study::YesNo>(&trial.response)) {
        return said->yes ? "yes" : "no";
    }
    if (const auto *set = std::get_if<study::Adjusted>(&trial.response)) {
        return ui::formatted("{:.3g}", set->level);
    }
    return "none";
}

void show_last_trial(const study::Trial &trial) {
    ui::text(kInk, "Last: {}, level {:.3g}", trial.condition, trial.level.value_or(0.0));
    ui::text(kFaintInk, "answer {}{}", answer_of(trial),
             trial.response_time_s ? ui::formatted(" after {:.2f} s", *trial.response_time_s) : "");
    if (!ImGui::BeginTable("delivered", 4, ImGuiTableFlags_SizingFixedFit)) {
        return;
    }
    for (const char *const head : {"interval", "", "intended", "delivered"}) {
        ImGui::TableNextColumn();
        ui::text(kFaintInk, "{}", head);
    }
    for (std::size_t i = 0; i < trial.presentations.size(); ++i) {
        for (const study::StimulusValue &value : trial.presentations[i].values) {
            if (!value.delivered) {
                continue;
            }
            ImGui::TableNextColumn();
            ui::text(kFaintInk, "{}", i + 1);
            ImGui::TableNextColumn();
            ui::text(kInk, "{}", value.name);
            ImGui::TableNextColumn();
            ui::text(kInk, "{}", value.intended ? ui::formatted("{:.4g}", *value.intended) : "");
            ImGui::TableNextColumn();
            ui::text(kInk, "{:.4g}", *value.delivered);
        }
    }
    ImGui::EndTable();
}

/// What is presented and answered, or that it is hidden. @param result  null: nothing yet
void draw_stimuli(ExperimenterPanelState &panel, const Rectangle &place,
                  const StudySessionState &state, const study::Protocol &protocol,
                  const study::SeriesResult *result) {
    const ui::Panel window("Stimuli", place);
    ui::checkbox("show stimuli and answers", panel.shows_stimuli);
    ui::explain("off, you are as blind as the participant");
    if (!panel.shows_stimuli) {
        ui::wrapped(kFaintInk,
                    "Hidden, so that nobody can tell them from your face or your voice.");
        return;
    }
    if (!ImGui::BeginTable("halves", 2)) {
        return;
    }
    ImGui::TableSetupColumn("trial", ImGuiTableColumnFlags_WidthFixed,
                            27.0F * ImGui::GetFontSize());
    ImGui::TableSetupColumn("charts", ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableNextColumn();
    if (state.trial) {
        const study::PlannedTrial &trial = *state.trial;
        ui::text(kInk, "Now: {}, level {:.3g}{}", trial.condition, trial.level.value(),
                 trial.target ? ui::formatted(", at {}", *trial.target) : "");
    }
    if (!state.trials.empty()) {
        show_last_trial(state.trials.back());
    }
    ImGui::TableNextColumn();
    if (result != nullptr) {
        draw_live_charts(protocol, *result);
    }
    ImGui::EndTable();
}

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

void StudyWindow::store_note(const StudySessionState &state, const std::string &text) {
    store_.append(study::Note{study::utc_now(), "note", text, state.participant, state.session});
}

void StudyWindow::renew_fit(const StudySessionState &state) {
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

void StudyWindow::draw_experimenter(const StudySessionState &state, ExperimenterActs &acts) {
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
void StudyWindow::report_participant(const StudySessionState &state,
                                     const ParticipantPicture &picture) {
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

StudySessionFrame StudyWindow::show(const ParticipantPicture &picture,
                                    const StudySessionState &state) {
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
    StudySessionFrame frame{participant_window_.take_inputs(session_.servo()), acts.orders};
    frame.orders.stops = frame.orders.stops || window_.is_closing() || asked_to_end();
    const double now_s = steady_clock_s();
    longest_frame_s_ = std::max(longest_frame_s_, now_s - std::exchange(frame_end_s_, now_s));
    if (ui::report().is_requested()) {
        report_participant(state, picture);
    }
    return frame;
}

ViewState experimenter_view(const servo::ServoSample &now, const device::DeviceDescription &device,
                            const contact::HapticSurface &surface,
                            const std::optional<Vector3> &hidden_at) {
    servo::ServoSample shown = now;
    const bool hides_tip = hidden_at && now.contact.touching;
    if (hidden_at) {
        shown.tip_force_N = Vector3::Zero();
    }
    if (hides_tip) {
        shown.tip_m = *hidden_at;
        shown.contact.x0_m = *hidden_at;
    }
    ViewState state = view_of(shown, device, surface);
    if (hides_tip) {
        if (const auto q_rad = device::joint_angles_rad(device.geometry, *hidden_at)) {
            state.linkage = device::linkage_pose(device.geometry, *q_rad);
        }
    }
    return state;
}

} // namespace springdrive::app::study_screen
