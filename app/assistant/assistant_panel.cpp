#include "app/assistant/assistant.h"

#include "app/panels/panels.h"
#include "app/widgets/rectangle.h"
#include "app/widgets/widgets.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace springdrive::app {

namespace {

using assistant::Assistant;
using assistant::StepName;
using assistant::StepReport;
using assistant::StepState;
using assistant::Verdict;

/// Of a bar: its text is readable on it.
const ImVec4 kFilled{0.16F, 0.42F, 0.62F, 1.0F};

struct StateLook {
    const char *mark = "";
    const ImVec4 &colour;
};

StateLook look_of(StepState state) {
    switch (state) {
    case StepState::done:
        return {"\u2713", kGood};
    case StepState::failed:
        return {"\u2717", kDanger};
    case StepState::present:
        return {"\u2192", kInk};
    case StepState::open:
        break;
    }
    return {"\u00B7", kFaintInk};
}

void draw_steps(session::Session &session, Assistant &assistant) {
    const ui::Scope scope("steps");
    // Otherwise entries are wider than their window by the spacing, and cut off.
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0.0F, ImGui::GetStyle().ItemSpacing.y});
    for (std::size_t i = 0; i < assistant::kSteps; ++i) {
        const auto step = static_cast<StepName>(i);
        const StepState state = assistant.state(step);
        const ui::Disabled disabled(!assistant.can_go_to(step));
        const StateLook look = look_of(state);
        const std::string label =
            ui::formatted("{} {}###{}", look.mark, assistant::kStepTitles[i].title,
                          assistant::kStepTitles[i].name);
        ImGui::PushStyleColor(ImGuiCol_Text, assistant.has_failed(step) ? kDanger : look.colour);
        if (ui::selectable(label.c_str(), state == StepState::present)) {
            assistant.go_to(session, step);
        }
        ImGui::PopStyleColor();
    }
    ImGui::PopStyleVar();
}

/// From the middle of its range to the value, as angles are.
void draw_bar(const assistant::Bar &bar) {
    const ui::Scope scope(bar.label);
    ui::text(kFaintInk, "{}", bar.label);
    if (bar.minimum >= 0.0) {
        ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kFilled);
        ui::progress("bar", std::clamp(bar.value / bar.maximum, 0.0, 1.0), bar.text);
        ImGui::PopStyleColor();
        return;
    }
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size{ImGui::GetContentRegionAvail().x, ImGui::GetFrameHeight()};
    ImGui::Dummy(size);
    ui::enter("bar", "progress", bar.text, bar.value);
    ImDrawList &list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y},
                       ImGui::GetColorU32(ImGuiCol_FrameBg), ImGui::GetStyle().FrameRounding);
    const auto x_of = [&](double value) {
        const double share = (value - bar.minimum) / (bar.maximum - bar.minimum);
        return corner.x + static_cast<float>(std::clamp(share, 0.0, 1.0)) * size.x;
    };
    const float left = std::min(x_of(0.0), x_of(bar.value));
    const float right = std::max(x_of(0.0), x_of(bar.value));
    list.AddRectFilled({left, corner.y}, {right, corner.y + size.y}, ImGui::GetColorU32(kFilled));
    list.AddLine({x_of(0.0), corner.y}, {x_of(0.0), corner.y + size.y},
                 ImGui::GetColorU32(kFaintInk));
    const ImVec2 text = ImGui::CalcTextSize(bar.text.c_str());
    list.AddText({corner.x + size.x - text.x - ImGui::GetStyle().FramePadding.x,
                  corner.y + 0.5F * (size.y - text.y)},
                 ImGui::GetColorU32(kInk), bar.text.c_str());
}

/// The zero pose from the side, the user on the right: upper arm level, forearm hanging.
void draw_pose(const device::PhantomGeometry &geometry) {
    const float font = ImGui::GetFontSize();
    const float scale = 4.0F * font / static_cast<float>(geometry.forearm_m);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::Dummy({ImGui::GetContentRegionAvail().x, 7.0F * font});
    ui::enter("pose", "picture", "the zero pose, from the side");
    const ImVec2 base{corner.x + 1.5F * font, corner.y + 2.0F * font};
    const ImVec2 elbow{base.x + scale * static_cast<float>(geometry.upper_arm_m), base.y};
    const ImVec2 tip{elbow.x, elbow.y + scale * static_cast<float>(geometry.forearm_m)};
    ImDrawList &list = *ImGui::GetWindowDrawList();
    const float line = 0.25F * font;
    const ImU32 ink = ImGui::GetColorU32(kTransposeMap);
    const ImU32 faint = ImGui::GetColorU32(kFaintInk);
    list.AddLine(base, elbow, ink, line);
    list.AddLine(elbow, tip, ink, line);
    list.AddCircleFilled(base, 1.6F * line, faint);
    list.AddCircleFilled(tip, 1.2F * line, ImGui::GetColorU32(kInverseMap));
    const float square = 2.5F * line;
    list.AddLine({elbow.x - square, elbow.y}, {elbow.x - square, elbow.y + square}, faint);
    list.AddLine({elbow.x - square, elbow.y + square}, {elbow.x, elbow.y + square}, faint);
    const float gap = 0.6F * font;
    list.AddText({base.x, base.y - gap - font}, faint, "upper arm level");
    list.AddText({elbow.x + gap, 0.5F * (elbow.y + tip.y)}, faint, "forearm hanging");
    list.AddText({tip.x + gap, tip.y - gap}, faint, "tip at the origin");
    list.AddText({elbow.x + 5.0F * font, elbow.y - gap}, faint, "you");
}

void draw_troubles(const StepReport &report) {
    for (std::size_t i = 0; i < report.troubles.size(); ++i) {
        const ui::Scope scope(ui::formatted("trouble {}", i + 1));
        ui::wrapped(report.verdict == Verdict::doubtful ? kWarning : kDanger, "{}",
                    report.troubles[i].what);
        if (!report.troubles[i].remedy.empty()) {
            ui::wrapped(kInk, "\u2192 {}", report.troubles[i].remedy);
        }
    }
}

void draw_gap() { ImGui::Dummy({0.0F, 0.4F * ImGui::GetFontSize()}); }

/// Side by side, as far as there is room. @return whether there are any
bool draw_offers(const std::vector<assistant::Offer> &offers) {
    bool is_first = true;
    for (const assistant::Offer &offer : offers) {
        const ImGuiStyle &style = ImGui::GetStyle();
        const float width =
            ImGui::CalcTextSize(offer.label.c_str()).x + 2.0F * style.FramePadding.x;
        if (!std::exchange(is_first, false)) {
            ImGui::SameLine();
            if (ImGui::GetContentRegionAvail().x < width) {
                ImGui::NewLine();
            }
        }
        if (enabled_button(offer.label.c_str(), offer.is_enabled)) {
            offer.choose();
        }
        if (!offer.explanation.empty()) {
            ui::explain(offer.explanation);
        }
    }
    return !is_first;
}

/// What is to be done changes while it is done; what is below stays where it is, under the cursor.
void draw_to_do(const std::string &text) {
    constexpr float kLines = 4.0F; // of the longest, in a panel as wide as at the start
    const float below_px = ImGui::GetCursorPosY() + kLines * ImGui::GetTextLineHeightWithSpacing();
    ui::wrapped(kTransposeMap, "{}", text);
    ImGui::SetCursorPosY(std::max(ImGui::GetCursorPosY(), below_px));
}

void draw_step(session::Session &session, Assistant &assistant, DoctorPopup &doctor) {
    const StepReport report = assistant.report(session);
    const std::size_t at = assistant::index_of(assistant.present());
    const ui::Scope scope(assistant::kStepTitles[at].name);
    ui::text(kInk, "{} of {}: {}", at + 1, assistant::kSteps, assistant::kStepTitles[at].title);
    ImGui::Spacing();
    draw_to_do(report.to_do);
    draw_gap();
    if (report.shows_pose) {
        draw_pose(session.description().geometry);
    }
    for (const assistant::Bar &bar : report.bars) {
        draw_bar(bar);
    }
    if (!report.bars.empty()) {
        draw_gap();
    }
    if (draw_offers(report.offers)) {
        draw_gap();
    }
    for (std::size_t i = 0; i < report.seen.size(); ++i) {
        const ui::Scope seen(ui::formatted("seen {}", i + 1));
        ui::wrapped(kInk, "{}", report.seen[i]);
    }
    draw_troubles(report);
    if (!report.asks_doctor.empty() && report.verdict != Verdict::good) {
        doctor.offer(report.asks_doctor, session.servo().rate_hz());
    }
    if (report.verdict == Verdict::doubtful) {
        ui::wrapped(kWarning, "If you continue: {}.", report.unchecked);
        if (ui::button("continue all the same")) {
            assistant.continue_all_the_same(session);
        }
    }
    if (!assistant.error().empty()) {
        const ui::Scope error("complaint");
        ui::wrapped(kWarning, "Progress is not kept: {}", assistant.error());
    }
}

void draw_ways(session::Session &session, Assistant &assistant) {
    if (enabled_button("Back", assistant.present() != StepName::link)) {
        assistant.back(session);
    }
    ImGui::SameLine();
    if (ui::button("Again")) {
        assistant.again(session);
    }
    ui::explain("this step from its beginning; resets a stop");
    ImGui::SameLine();
    if (enabled_button(assistant.present() == StepName::touch ? "Finish###Next" : "Next",
                       assistant.can_go_on(session))) {
        assistant.next(session);
    }
    ImGui::SameLine();
    if (ui::button("Leave")) {
        assistant.leave(session);
    }
    ui::explain("closes the assistant; it goes on here later, by the button in the tab Plant");
}

} // namespace

void draw_assistant_panel(session::Session &session, Assistant &assistant, DoctorPopup &doctor,
                          const Rectangle &place) {
    const ui::Panel panel("Assistant", place, ImGuiWindowFlags_NoScrollbar);
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const float footer = ImGui::GetFrameHeightWithSpacing() + ImGui::GetStyle().ItemSpacing.y;
    const float steps = 8.0F * ImGui::GetFontSize();
    ImGui::BeginChild("steps", {steps, room.y - footer});
    draw_steps(session, assistant);
    ImGui::EndChild();
    ImGui::SameLine();
    ImGui::BeginChild("step", {0.0F, room.y - footer});
    draw_step(session, assistant, doctor);
    ImGui::EndChild();
    draw_ways(session, assistant);
    doctor.draw();
}

void offer_assistant(session::Session &session, Assistant &assistant) {
    if (ui::button("assistant…")) {
        assistant.open(session);
    }
    ui::explain("step by step from the connection to the first touch");
    if (!assistant.holds_back().empty()) {
        ui::wrapped(kDanger,
                    "The device only brakes: the assistant found in \"{}\" why it must not be "
                    "driven. Repair it, and do that step again.",
                    assistant.holds_back());
    }
}

} // namespace springdrive::app
