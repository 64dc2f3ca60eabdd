#include "app/panels/panels.h"
#include "app/plot.h"
#include "app/widgets/widgets.h"
#include "engine/control/perception.h"

namespace springdrive::app {

void draw_force_direction_panel(const session::Session &session, const Rectangle &place) {
    const ui::Panel panel("Force direction", place);
    const session::History &history = session.servo().history();
    const bool transpose = session.servo().inputs().tuning.map == control::MotionMap::transpose;

    Plot error;
    error.title = "angle force–normal [°]";
    error.min_top = 10.0;
    error.max_top = 60.0; // peaks during an impact would compress the scale
    error.samples = history.size();
    error.time_s = [&history](std::size_t i) { return history[i].time_s; };
    ImVec4 faint = kUsedMap;
    faint.w = 0.35F;
    error.lines = {
        {"every tick", faint, [&history](std::size_t i) { return history[i].used_error_deg; }},
        {transpose ? "inverse, ideal" : "transpose, ideal", kOtherMap,
         [&history](std::size_t i) { return history[i].other_error_deg; }},
        {transpose ? "transpose, measured" : "inverse, measured", kUsedMap,
         [&history](std::size_t i) { return history[i].felt_error_deg; }}};
    error.levels = {{control::kNoticeable_deg, "25°: limit of perception"}};

    Plot force = error;
    force.title = "force [N]";
    force.min_top = 1.0;
    force.max_top = 1e9;
    force.lines = {{"measured", kForce, [&history](std::size_t i) { return history[i].force_N; }}};
    force.levels.clear();

    const ImVec2 room = ImGui::GetContentRegionAvail();
    const float gap = ImGui::GetStyle().ItemSpacing.x;
    draw_plot(error, {0.66F * room.x - gap, room.y});
    ImGui::SameLine();
    draw_plot(force, {0.34F * room.x, room.y});
}

} // namespace springdrive::app
