#include "app/host/folders.h"
#include "app/panels/panels.h"
#include "app/panels/tuning_editor.h"
#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "base/input_error.h"
#include "engine/control/tuning.h"
#include "engine/control/tuning_file.h"

#include <algorithm>
#include <iostream>
#include <optional>

namespace springdrive::app {

namespace {

/// What the active tuning can be compared with.
struct Compared {
    std::string name;
    control::Tuning tuning;
    std::optional<TuningFiles::Entry> file{};

    /// Unchanged while files come and go.
    [[nodiscard]] std::string key() const { return file ? file->file.string() : name; }
};

std::vector<Compared> candidates(const session::Session &session, const TuningPanelState &state) {
    const session::TuningHistory &history = session.tuning();
    std::vector<Compared> all{{"slot " + std::string(session::name_of(history.slots().inactive())),
                               history.slots().other()},
                              {"the first tuning", history.journal().front().tuning}};
    for (const TuningFiles::Entry &entry : state.files.entries()) {
        all.push_back({entry.name, entry.contents.tuning, entry});
    }
    return all;
}

void draw_differences(const session::Session &session, const control::Tuning &other) {
    const std::vector<control::TuningChange> changes =
        control::changes_between(other, session.tuning().now());
    if (changes.empty()) {
        ui::text(kFaintInk, "no difference");
        return;
    }
    if (!ImGui::BeginTable("differences", 3, ImGuiTableFlags_SizingStretchProp)) {
        return;
    }
    for (const char *title : {"", "there", "now"}) {
        ImGui::TableNextColumn();
        ui::text(kFaintInk, "{}", title);
    }
    for (const control::TuningChange &change : changes) {
        const ui::Scope scope(change.name);
        ImGui::TableNextColumn();
        const ui::ExplainedRow row(explanation_of(change.name), ui::ExplainedRow::Reach::items);
        ui::text(kFaintInk, "{}", change.symbol);
        for (const std::string &value : {change.before, change.after}) {
            ImGui::TableNextColumn();
            ui::text(kInk, "{} {}", value, change.unit);
        }
    }
    ImGui::EndTable();
}

void draw_files(const session::Session &session, TuningPanelState &state,
                const std::optional<TuningFiles::Entry> &file) {
    ImGui::SetNextItemWidth(11.0F * ImGui::GetFontSize());
    ui::text_field("##name", "name of a file", state.file_name);
    ImGui::SameLine();
    if (ui::button("save")) {
        state.file_message = state.files.save(state.file_name, session.tuning().now());
    }
    ui::explain("writes the active tuning to NAME.toml in " + output_dir_text() +
                ";\nload it here, or with --tuning-file");
    ImGui::SameLine();
    if (enabled_button("rename", file && file->is_own) && file) {
        state.file_message = state.files.rename(*file, state.file_name);
    }
    ui::explain("renames the chosen file; those in brackets belong to the project");
    if (!state.file_message.empty()) {
        ui::wrapped(kInk, "{}", state.file_message);
    }
}

void draw_steps(const session::Session &session) {
    const session::TuningHistory &history = session.tuning();
    ui::text(kFaintInk, "changes: {}, the newest first", history.done());
    std::size_t shown = 0;
    for (std::size_t i = history.done(); i > 0 && shown < 50; --i, ++shown) {
        const session::TuningStep &step = history.steps()[i - 1];
        ui::wrapped(kInk, "{:.1f} s  {}", step.time_s, step.what);
    }
}

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
        if (enabled_button(label, preset.has_value()) && preset) {
            editor.replace(control::with_gains_of(session.tuning().now(), *preset),
                           std::string("preset ") + label);
        }
        ui::explain(preset ? preset_text(session, file, *preset)
                           : "no tuning is stored for this servo rate and delay:\n"
                             "find the stiffest in the Stability tab");
        ImGui::SameLine();
    }
}

void draw_history_buttons(session::Session &session, TuningEditor &editor) {
    const session::TuningHistory &history = session.tuning();
    if (enabled_button("undo", history.can_undo())) {
        editor.undo();
    }
    ui::explain(history.done() > 0
                    ? "takes back: " + history.steps()[history.done() - 1].what + "\nCtrl+Z"
                    : "nothing to take back; Ctrl+Z");
    ImGui::SameLine();
    if (enabled_button("redo", history.can_redo())) {
        editor.redo();
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
    ui::text(is_stable ? kGood : kDanger, "{}",
             !is_stable             ? "UNSTABLE"
             : indicator.is_passive ? "passive"
                                    : "stable");
    ui::explain(
        ui::formatted("passive: with whatever holds the device, in contact and in free space;\n"
                      "stable: with the hand chosen here, in contact.\n"
                      "predicted for the active tuning at the present configuration, in contact:\n"
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
    ui::show_error(editor.error());
    ImGui::Separator();
    show_consequences(session);
}

/// The active tuning against the other slot, the first one, or a file; files to save and load; the
/// steps so far.
void draw_compare_tab(session::Session &session, TuningEditor &editor, TuningPanelState &state) {
    const std::vector<Compared> all = candidates(session, state);
    auto chosen = std::ranges::find(all, state.compared, &Compared::key);
    chosen = chosen == all.end() ? all.begin() : chosen;
    ImGui::SetNextItemWidth(14.0F * ImGui::GetFontSize());
    if (const ui::DropDown list("##with", chosen->name.c_str()); list) {
        for (auto entry = all.begin(); entry != all.end(); ++entry) {
            if (ui::selectable(entry->name.c_str(), entry == chosen)) {
                state.compared = entry->key();
            }
        }
    }
    const Compared &other = *chosen;
    ImGui::SameLine();
    if (ui::button("load")) {
        editor.replace(other.tuning, other.name);
    }
    ui::explain("makes it the active tuning: all of it, with map, α and η");
    ImGui::SameLine();
    if (ui::button("refresh")) {
        state.files.refresh();
    }
    ui::explain("looks for tuning files again");
    draw_differences(session, other.tuning);
    ImGui::Separator();
    draw_files(session, state, other.file);
    ui::show_error(editor.error());
    ImGui::Separator();
    draw_steps(session);
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
        state.stability.draw(session, editor);
    }
    if (const ui::Tab compare("Compare"); compare) {
        draw_compare_tab(session, editor, state);
    }
}

} // namespace springdrive::app
