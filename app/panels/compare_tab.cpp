#include "app/host/output_dir.h"
#include "app/panels/panels.h"
#include "app/plots/symbols.h"
#include "app/widgets/widgets.h"
#include "engine/control/tuning_difference.h"

#include <algorithm>
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
    {
        const ui::Disabled not_own(!file || !file->is_own);
        if (ui::button("rename") && file) {
            state.file_message = state.files.rename(*file, state.file_name);
        }
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

} // namespace

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
    if (!editor.error().empty()) {
        ui::wrapped(kDanger, "{}", editor.error());
    }
    ImGui::Separator();
    draw_steps(session);
}

} // namespace springdrive::app
