#include "app/panels/stability_field.h"

#include "app/panels/stability_tab.h"
#include "app/widgets/widgets.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace springdrive::app {

namespace {

constexpr double kFieldMoved_rad = 0.1; // below that, the field hardly changes

/// The centre of one of `count` cells between two ends on a logarithmic scale.
double middle(double minimum, double maximum, int cell, int count) {
    return minimum * std::pow(maximum / minimum, (cell + 0.5) / count);
}

double share(double value, double minimum, double maximum) {
    return std::clamp(std::log(std::max(value, minimum) / minimum) / std::log(maximum / minimum),
                      0.0, 1.0);
}

bool has_same_field(const loops::StabilityCase &a, const loops::StabilityCase &b) {
    control::Tuning same = a.tuning;
    same.K_P_V_per_rad = b.tuning.K_P_V_per_rad;
    same.dR_Ohm = b.tuning.dR_Ohm;
    return same == b.tuning && (a.q_rad - b.q_rad).cwiseAbs().maxCoeff() < kFieldMoved_rad &&
           a.period_s == b.period_s && a.delay_periods == b.delay_periods &&
           a.device.name == b.device.name;
}

/// Green where stable, darker for slower decay; red where unstable.
ImU32 colour_of(double eigenvalue, double period_s) {
    if (!(eigenvalue < 1.0)) {
        return IM_COL32(112, 48, 46, 255);
    }
    const double rate_per_s = -std::log(eigenvalue) / period_s;
    const double speed = std::clamp(std::log10(rate_per_s) / 2.5, 0.0, 1.0); // 1/s to 300/s
    return ImGui::ColorConvertFloat4ToU32(ImVec4(0.13F, static_cast<float>(0.24 + 0.26 * speed),
                                                 static_cast<float>(0.22 + 0.16 * speed), 1.0F));
}

void explain_cell(const StabilityGrid &grid, ImVec2 corner, ImVec2 size) {
    const ImVec2 mouse = ImGui::GetMousePos();
    const auto cell = [](float at, float from, float length, int count) {
        return std::clamp(static_cast<int>(static_cast<float>(count) * (at - from) / length), 0,
                          count - 1);
    };
    const int column = cell(mouse.x, corner.x, size.x, StabilityGrid::kColumns);
    const int row =
        StabilityGrid::kRows - 1 - cell(mouse.y, corner.y, size.y, StabilityGrid::kRows);
    const double eigenvalue = grid.at(column, row);
    ui::explain(ui::formatted(
        "K_P {:.3g} V/rad, dR {:.3g} Ω: {}\nlargest eigenvalue {:.4f}, other parameters "
        "unchanged.\nGreen: stable with every hand, darker for slower decay; red: "
        "unstable;\ncross: the active tuning",
        StabilityGrid::K_P_V_per_rad(column), StabilityGrid::dR_Ohm(row),
        eigenvalue < 1.0 ? "stable" : "unstable", eigenvalue));
}

void draw_cells(const StabilityGrid &grid, ImVec2 corner, ImVec2 size) {
    ImDrawList &list = *ImGui::GetWindowDrawList();
    const auto x = [&](int column) {
        return corner.x + size.x * static_cast<float>(column) / StabilityGrid::kColumns;
    };
    const auto y = [&](int row) {
        return corner.y + size.y - size.y * static_cast<float>(row) / StabilityGrid::kRows;
    };
    for (int row = 0; row < StabilityGrid::kRows; ++row) {
        for (int column = 0; column < StabilityGrid::kColumns; ++column) {
            list.AddRectFilled(ImVec2(x(column), y(row + 1)), ImVec2(x(column + 1), y(row)),
                               colour_of(grid.at(column, row), grid.period_s));
        }
    }
}

void draw_cross(const control::Tuning &now, ImVec2 corner, ImVec2 size) {
    const float x =
        corner.x +
        size.x * static_cast<float>(share(now.K_P_V_per_rad, StabilityGrid::kMin_K_P_V_per_rad,
                                          StabilityGrid::kMax_K_P_V_per_rad));
    const float y = corner.y + size.y -
                    size.y * static_cast<float>(share(now.dR_Ohm, StabilityGrid::kMin_dR_Ohm,
                                                      StabilityGrid::kMax_dR_Ohm));
    const float arm = 0.4F * ImGui::GetFontSize();
    ImDrawList &list = *ImGui::GetWindowDrawList();
    const ImU32 ink = ImGui::GetColorU32(kForce);
    list.AddLine(ImVec2(x - arm, y), ImVec2(x + arm, y), ink, 2.0F);
    list.AddLine(ImVec2(x, y - arm), ImVec2(x, y + arm), ink, 2.0F);
}

} // namespace

double StabilityGrid::K_P_V_per_rad(int column) {
    return middle(kMin_K_P_V_per_rad, kMax_K_P_V_per_rad, column, kColumns);
}

double StabilityGrid::dR_Ohm(int row) { return middle(kMin_dR_Ohm, kMax_dR_Ohm, row, kRows); }

double StabilityGrid::at(int column, int row) const {
    return eigenvalue.at(static_cast<std::size_t>(row) * kColumns +
                         static_cast<std::size_t>(column));
}

StabilityGrid stability_grid(const loops::StabilityCase &which, BackgroundTalk &talk) {
    StabilityGrid grid;
    grid.period_s = which.period_s;
    loops::StabilityCase there = which;
    for (int row = 0; row < StabilityGrid::kRows; ++row) {
        there.net_resistance_Ohm = StabilityGrid::dR_Ohm(row);
        for (int column = 0; column < StabilityGrid::kColumns; ++column) {
            there.tuning.K_P_V_per_rad = StabilityGrid::K_P_V_per_rad(column);
            grid.eigenvalue.push_back(talk.is_wanted() ? loops::worst_member(there).eigenvalue
                                                       : 0.0);
        }
        talk.share = (row + 1.0) / StabilityGrid::kRows;
    }
    return grid;
}

void StabilityField::update(const loops::StabilityCase &now) {
    if (std::optional<StabilityGrid> grid = work_.take()) {
        grid_ = std::move(grid);
    }
    if (!work_.is_busy() && (!of_ || !has_same_field(*of_, now))) {
        of_ = now;
        work_.start([now](BackgroundTalk &talk) { return stability_grid(now, talk); });
    }
}

void StabilityField::draw(const control::Tuning &now) const {
    if (!grid_) {
        return;
    }
    ui::text(kFaintInk, "\u2192 K_P {:g} to {:g} V/rad   \u2191 dR {:g} to {:g} Ω",
             StabilityGrid::kMin_K_P_V_per_rad, StabilityGrid::kMax_K_P_V_per_rad,
             StabilityGrid::kMin_dR_Ohm, StabilityGrid::kMax_dR_Ohm);
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(ImGui::GetContentRegionAvail().x, 7.0F * ImGui::GetFontSize());
    ImGui::InvisibleButton("##field", size);
    ui::enter("field", "map", "");
    draw_cells(*grid_, corner, size);
    draw_cross(now, corner, size);
    if (ImGui::IsItemHovered()) {
        explain_cell(*grid_, corner, size);
    }
}

} // namespace springdrive::app
