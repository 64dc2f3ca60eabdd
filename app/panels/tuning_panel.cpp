#include "app/host/asset_folder.h"
#include "app/panels/held_dR.h"
#include "app/panels/panels.h"
#include "app/panels/presets.h"
#include "app/panels/tuning_consequences.h"
#include "app/plots/symbols.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "engine/control/tuning.h"
#include "engine/control/tuning_difference.h"
#include "engine/control/tuning_file.h"

#include <iostream>

namespace springdrive::app {

namespace {

/// With enough digits for the parameter's range.
const char *number_format(const control::Parameter &parameter) {
    return parameter.maximum >= 1000.0                         ? "%.0f"
           : parameter.logarithmic && parameter.maximum <= 1.0 ? "%.4f"
                                                               : "%.3f";
}

/// A single change by a field or button.
void set_parameter(session::Session &session, TuningEditor &editor, std::size_t index, double value,
                   const control::Tuning &with) {
    control::Tuning tuning = with;
    tuning.*control::kParameters[index].value = value;
    editor.drag(tuning, static_cast<std::uint32_t>(index + 1));
    session.tuning().let_go();
}

/// The unit, and for dR what acts instead of the requested value.
void show_unit(const session::Session &session, const control::Parameter &parameter) {
    const double active_Ohm = active_dR_Ohm(session);
    if (parameter.value == &control::Tuning::dR_Ohm &&
        active_Ohm > session.tuning().now().dR_Ohm * (1.0 + 1e-9)) {
        ui::text(kDanger, "Ω, acts: {:.3f}", active_Ohm);
        ui::explain("held up by the winding guard or the observer of R: see below");
    } else {
        ui::text(kFaintInk, "{}", parameter.unit);
    }
}

void edit_parameter(session::Session &session, TuningEditor &editor, std::size_t index) {
    const control::Parameter &parameter = control::kParameters[index];
    const bool is_alpha = parameter.value == &control::Tuning::alpha_rad2_per_m2;
    control::Tuning tuning = session.tuning().now();
    const bool acts = !is_alpha || tuning.alpha_mode == control::AlphaMode::by_hand;
    if (is_alpha) { // to move it selects α by hand
        tuning.alpha_mode = control::AlphaMode::by_hand;
    }
    const float font = ImGui::GetFontSize();
    const ui::Scope scope(parameter.name);
    const ui::ExplainedRow row(explanation_of(parameter.name));
    ImGui::AlignTextToFramePadding();
    ui::text(acts ? kInk : kFaintInk, "{}", parameter.symbol);
    ImGui::SameLine(2.9F * font);
    ImGui::SetNextItemWidth(9.0F * font);
    double &value = tuning.*parameter.value;
    double typed = value;
    if (ui::slider("##slider", value, parameter.minimum, parameter.maximum,
                   parameter.logarithmic) &&
        control::lies_in_range(parameter, tuning)) {
        editor.drag(tuning, static_cast<std::uint32_t>(index + 1));
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(4.6F * font);
    if (ui::number_field(
            "##typed", typed, number_format(parameter),
            {parameter.symbol, parameter.minimum, parameter.maximum, parameter.unit})) {
        set_parameter(session, editor, index, typed, tuning);
    }
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    show_unit(session, parameter);
    ImGui::SameLine(ImGui::GetContentRegionMax().x - 1.7F * font);
    if (ui::button("\u21BA##reset")) {
        set_parameter(session, editor, index, parameter.default_value(), tuning);
    }
    ui::explain(ui::formatted("reset to {:g}", parameter.default_value()));
}

/// What a preset would change, and what it keeps.
std::string preset_text(const session::Session &session, const std::string &file,
                        const control::Tuning &preset) {
    return "sets " +
           control::text_of(control::changes_between(
               session.tuning().now(), control::with_gains_of(session.tuning().now(), preset))) +
           "\nkeeps the map, the source of α, α and η\n" + file + ".toml of the included tunings";
}

/// Empty if the file is missing: the folder may have been removed while the program runs.
const std::optional<control::Tuning> &preset_of(const std::string &file, TuningPanelState &state) {
    const auto [entry, is_new] = state.presets.try_emplace(file);
    if (is_new && !file.empty()) {
        try {
            entry->second =
                control::read_tuning_file(asset_folder() / "tunings" / (file + ".toml"));
        } catch (const InputError &error) {
            std::cerr << "springdrive: " << error.what() << '\n';
        }
    }
    return entry->second;
}

/// One button per label of the presets.
void draw_presets(session::Session &session, TuningEditor &editor, TuningPanelState &state) {
    for (const char *label : kPresetLabels) {
        const std::string file = preset_file(label, session.servo().rate_hz(),
                                             session.device().device().delay_periods());
        const std::optional<control::Tuning> &preset = preset_of(file, state);
        {
            const ui::Disabled without_file(!preset.has_value());
            if (ui::button(label) && preset) {
                editor.replace(control::with_gains_of(session.tuning().now(), *preset),
                               std::string("preset ") + label);
            }
        }
        ui::explain(preset ? preset_text(session, file, *preset)
                           : "no tuning is stored for this servo rate and delay:\n"
                             "find the stiffest in the Stability tab");
        ImGui::SameLine();
    }
}

void draw_history_buttons(session::Session &session, TuningEditor &editor) {
    const session::TuningHistory &history = session.tuning();
    {
        const ui::Disabled at_start(!history.can_undo());
        if (ui::button("undo")) {
            editor.undo();
        }
    }
    ui::explain(history.done() > 0
                    ? "takes back: " + history.steps()[history.done() - 1].what + "\nCtrl+Z"
                    : "nothing to take back; Ctrl+Z");
    ImGui::SameLine();
    {
        const ui::Disabled at_end(!history.can_redo());
        if (ui::button("redo")) {
            editor.redo();
        }
    }
    ui::explain("Ctrl+Y");
    ImGui::SameLine();
    const bool is_a = history.slots().active() == session::TuningSlot::a;
    if (ui::button(is_a ? "A | b###slot" : "a | B###slot")) {
        editor.toggle_slot();
    }
    ui::explain("two tunings to compare; key B switches. The other one:\n" +
                control::text_of(
                    control::changes_between(session.tuning().now(), history.slots().other())));
    ImGui::SameLine();
    if (ui::button("A = B##store")) {
        session.tuning().store(session.plot_time_s());
    }
    ui::explain("puts the active tuning into the other slot, too");
}

void draw_map_choice(session::Session &session, TuningEditor &editor) {
    const ui::ExplainedRow row(explanation_of("maps") + "\nkey M switches");
    control::Tuning tuning = session.tuning().now();
    ImGui::SetNextItemWidth(9.0F * ImGui::GetFontSize());
    if (ui::choice("##map", tuning.map, control::kMotionMapLabels)) {
        editor.replace(tuning, "map " + std::string(control::label_of(tuning.map)));
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(8.0F * ImGui::GetFontSize());
    if (ui::choice("##alpha", tuning.alpha_mode, control::kAlphaModeLabels)) {
        editor.replace(tuning, std::string(control::label_of(tuning.alpha_mode)));
    }
}

void draw_indicator(TuningEditor &editor) {
    const StabilityIndicator &indicator = editor.indicator();
    const bool is_stable = indicator.is_stable();
    const float font = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 middle{corner.x + 0.5F * font, corner.y + 0.5F * ImGui::GetFrameHeight()};
    ImDrawList &list = *ImGui::GetWindowDrawList();
    list.AddCircleFilled(middle, 0.42F * font,
                         ImGui::ColorConvertFloat4ToU32(is_stable ? kGood : kDanger));
    ImGui::Dummy({1.0F * font, ImGui::GetFrameHeight()});
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    const double time_ms = 1e3 * indicator.time_constant_s();
    ui::text(is_stable ? kGood : kDanger, "{}", is_stable ? "stable" : "UNSTABLE");
    ui::explain(
        ui::formatted("predicted for the active tuning at the present configuration, in contact:\n"
                      "a motion {} by a factor of e in {:.0f} ms, of motor {} with {}",
                      is_stable ? "decays" : "grows", time_ms, indicator.worst.member.motor + 1,
                      loops::hand_text(indicator.worst.member.hand.name)));
    ImGui::SameLine(7.2F * font);
    ImGui::SetNextItemWidth(8.6F * font);
    ui::choice("##hand", editor.hand, kIndicatorHandLabels);
    ui::explain("for which hand the lamp predicts: gains that rest in a firm hand may be unstable\n"
                "in a light one, or when it lets go");
    ImGui::SameLine();
    ui::checkbox("beyond the limit", editor.is_unlocked);
    ui::explain("otherwise no change leads from a stable tuning to one that is predicted to be\n"
                "unstable with this hand");
}

void draw_gains_tab(session::Session &session, TuningEditor &editor, TuningPanelState &state) {
    draw_presets(session, editor, state);
    draw_history_buttons(session, editor);
    draw_map_choice(session, editor);
    draw_indicator(editor);
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        edit_parameter(session, editor, i);
    }
    draw_observed_resistances(session);
    if (!editor.error().empty()) {
        ui::wrapped(kDanger, "{}", editor.error());
    }
    ImGui::Separator();
    show_consequences(session);
}

} // namespace

void draw_tuning_panel(session::Session &session, TuningEditor &editor, TuningPanelState &state,
                       const Rectangle &place) {
    state.stability.finish_search(session, editor); // also while its tab is closed
    const ui::Panel panel("Tuning", place, ImGuiWindowFlags_NoTitleBar);
    const ui::Tabs tabs("tuning");
    if (!tabs) {
        return;
    }
    if (const ui::Tab gains("Gains"); gains) {
        draw_gains_tab(session, editor, state);
    }
    if (const ui::Tab stability("Stability"); stability) {
        draw_stability_tab(session, editor, state.stability);
    }
    if (const ui::Tab compare("Compare"); compare) {
        draw_compare_tab(session, editor, state);
    }
}

} // namespace springdrive::app
