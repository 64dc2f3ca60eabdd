#include "app/panels/stability_tab.h"

#include "app/plots/axis.h"
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

bool has_same_field(const loops::StabilityCase &a, const loops::StabilityCase &b) {
    control::Tuning same = a.tuning;
    same.K_P_V_per_rad = b.tuning.K_P_V_per_rad;
    same.dR_Ohm = b.tuning.dR_Ohm;
    return same == b.tuning && (a.q_rad - b.q_rad).cwiseAbs().maxCoeff() < kFieldMoved_rad &&
           a.period_s == b.period_s && a.delay_periods == b.delay_periods &&
           a.device.name == b.device.name;
}

/// Green where stable, darker for slower decay; red where unstable.
ImVec4 colour_of(double eigenvalue, double period_s) {
    if (!(eigenvalue < 1.0)) {
        return {0.44F, 0.19F, 0.18F, 1.0F};
    }
    const double rate_per_s = -std::log(eigenvalue) / period_s;
    const double speed = std::clamp(std::log10(rate_per_s) / 2.5, 0.0, 1.0); // 1/s to 300/s
    return {0.13F, static_cast<float>(0.24 + 0.26 * speed), static_cast<float>(0.22 + 0.16 * speed),
            1.0F};
}

const Axis kAxisOfK_P{StabilityGrid::kMin_K_P_V_per_rad, StabilityGrid::kMax_K_P_V_per_rad, true};
const Axis kAxisOf_dR{StabilityGrid::kMin_dR_Ohm, StabilityGrid::kMax_dR_Ohm, true};

/// The cell at a share of an axis.
int cell_at(double share, int count) {
    return std::clamp(static_cast<int>(share * count), 0, count - 1);
}

void explain_point(const StabilityGrid &grid, const PlotArea &area, ImVec2 mouse) {
    const double K_P = area.x_at(mouse.x);
    const double dR = area.y_at(mouse.y);
    const double eigenvalue = grid.at(cell_at(area.x.share(K_P), StabilityGrid::kColumns),
                                      cell_at(area.y.share(dR), StabilityGrid::kRows));
    ui::explain(ui::formatted("K_P {:.3g} V/rad, dR {:.3g} Ω: {}\nlargest eigenvalue {:.4f}, other "
                              "parameters unchanged, with every hand.\nA click sets them.",
                              K_P, dR, eigenvalue < 1.0 ? "stable" : "unstable", eigenvalue));
}

/// Unstable cells are hatched, and a line is drawn around them: nothing is told by colour alone.
void draw_cells(Canvas &canvas, const StabilityGrid &grid, const PlotArea &area) {
    const float width = area.where.size.x / StabilityGrid::kColumns;
    const float height = area.where.size.y / StabilityGrid::kRows;
    const auto is_stable = [&](int column, int row) { return grid.at(column, row) < 1.0; };
    for (int row = 0; row < StabilityGrid::kRows; ++row) {
        for (int column = 0; column < StabilityGrid::kColumns; ++column) {
            const ImVec2 corner{area.where.corner.x + width * static_cast<float>(column),
                                area.where.end().y - height * static_cast<float>(row + 1)};
            canvas.fill({corner, {width + 0.5F, height + 0.5F}},
                        colour_of(grid.at(column, row), grid.period_s));
            if (!is_stable(column, row) && (column + row) % 2 == 0) {
                canvas.line({corner.x, corner.y + height}, {corner.x + width, corner.y},
                            {ImVec4(0.85F, 0.55F, 0.52F, 0.6F), 1.0F});
            }
        }
    }
    const Stroke boundary{kInk, 2.0F};
    for (int row = 0; row < StabilityGrid::kRows; ++row) {
        for (int column = 0; column < StabilityGrid::kColumns; ++column) {
            const float left = area.where.corner.x + width * static_cast<float>(column);
            const float top = area.where.end().y - height * static_cast<float>(row + 1);
            if (column + 1 < StabilityGrid::kColumns &&
                is_stable(column, row) != is_stable(column + 1, row)) {
                canvas.line({left + width, top}, {left + width, top + height}, boundary);
            }
            if (row + 1 < StabilityGrid::kRows &&
                is_stable(column, row) != is_stable(column, row + 1)) {
                canvas.line({left, top}, {left + width, top}, boundary);
            }
        }
    }
}

/// Names a region in its largest part: the middle of its longest row of cells.
void draw_region_name(Canvas &canvas, const StabilityGrid &grid, const PlotArea &area,
                      bool of_stable, std::string_view name) {
    int best_length = 0;
    ImVec2 best{};
    for (int row = 1; row + 1 < StabilityGrid::kRows; ++row) {
        int length = 0;
        for (int column = 0; column < StabilityGrid::kColumns; ++column) {
            length = (grid.at(column, row) < 1.0) == of_stable ? length + 1 : 0;
            if (length > best_length) {
                best_length = length;
                best = {area.where.corner.x + area.where.size.x *
                                                  (static_cast<float>(column + 1) -
                                                   0.5F * static_cast<float>(length)) /
                                                  StabilityGrid::kColumns,
                        area.where.corner.y +
                            area.where.size.y *
                                (1.0F - (static_cast<float>(row) + 0.5F) / StabilityGrid::kRows)};
            }
        }
    }
    const float room =
        area.where.size.x * static_cast<float>(best_length) / StabilityGrid::kColumns;
    if (text_width(name) < room) {
        canvas.text({best.x - 0.5F * text_width(name), best.y - 0.5F * text_height()}, kInk, name);
    }
}

void draw_cross(Canvas &canvas, const control::Tuning &now, const PlotArea &area) {
    const float x = area.place_x(std::clamp(now.K_P_V_per_rad, area.x.from, area.x.to));
    const float y = area.place_y(std::clamp(now.dR_Ohm, area.y.from, area.y.to));
    const float arm = 0.45F * text_height();
    canvas.line({x - arm, y}, {x + arm, y}, {kForce, 2.5F});
    canvas.line({x, y - arm}, {x, y + arm}, {kForce, 2.5F});
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

void StabilityField::draw(const control::Tuning &now) {
    if (!grid_) {
        ui::text(kFaintInk, "computing the map …");
        return;
    }
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const Rectangle where{corner, {room.x, std::max(room.y, 9.0F * text_height())}};
    ScreenCanvas canvas(*ImGui::GetWindowDrawList(), text_height() / 15.0F);
    const PlotArea area = draw_axes(canvas, where, kAxisOfK_P, kAxisOf_dR, "K_P, V/rad", "dR, Ω");
    draw_cells(canvas, *grid_, area);
    draw_region_name(canvas, *grid_, area, true, "stable");
    draw_region_name(canvas, *grid_, area, false, "unstable");
    draw_cross(canvas, now, area);
    ImGui::InvisibleButton("##field", where.size);
    ui::enter("field", "map", "", {},
              {{"area_x", area.where.corner.x},
               {"area_y", area.where.corner.y},
               {"area_width", area.where.size.x},
               {"area_height", area.where.size.y}});
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (!ImGui::IsItemHovered() || !area.where.contains(mouse)) {
        return;
    }
    explain_point(*grid_, area, mouse);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        clicked_ = now;
        clicked_->K_P_V_per_rad = area.x_at(mouse.x);
        clicked_->dR_Ohm = area.y_at(mouse.y);
    }
}

} // namespace springdrive::app
