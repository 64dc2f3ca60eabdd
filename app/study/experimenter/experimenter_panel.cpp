#include "app/study/experimenter/experimenter_panel.h"

#include "app/study/experimenter/live_charts.h"
#include "app/widgets/widgets.h"
#include "engine/servo/safety_status.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

namespace springdrive::app::study_screen {

namespace {

constexpr double kMaxThought_s = 8.0; ///< between two keys of a note

bool is_in_trial(SittingStep step) {
    return step == SittingStep::interval || step == SittingStep::between_intervals ||
           step == SittingStep::response;
}

void show_course(const SittingState &state, bool shows_stimuli) {
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
    if (state.step == SittingStep::in_break) {
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

} // namespace

ExperimenterActs draw_experimenter_panel(ExperimenterPanelState &panel, const Rectangle &place,
                                         const SittingState &state, const session::Session &session,
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

namespace {

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

} // namespace

void draw_stimuli(ExperimenterPanelState &panel, const Rectangle &place, const SittingState &state,
                  const study::Protocol &protocol, const study::SeriesResult *result) {
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

} // namespace springdrive::app::study_screen
