#include "app/panels/stability_tab.h"

#include "app/host/folders.h"
#include "app/host/output.h"
#include "app/panels/panels.h"
#include "app/plots/channels.h"
#include "app/widgets/widgets.h"
#include "base/new_file.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/stability_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::app {

namespace {

constexpr double kMoved_rad = 0.03; // below that, limits stay as they are

/// The value up to which the parameter may change, or must return, given the direction of
/// instability: upwards or not.
StabilityHeadroom headroom_of(const loops::StabilityCase &which, bool is_stable, const char *name,
                              bool upwards) {
    const loops::StabilityParameter &parameter = *loops::stability_parameter_named(name);
    stop_if_given_up();
    StabilityHeadroom headroom;
    headroom.now = parameter.get(which);
    const bool looks_up = upwards == is_stable;
    for (const limits::StabilityLimit &limit :
         limits::predicted_limits(which, parameter, {parameter.from, parameter.to})) {
        const bool is_ahead =
            looks_up ? limit.predicted >= headroom.now : limit.predicted <= headroom.now;
        const bool is_nearer = !headroom.limit || (looks_up ? limit.predicted < *headroom.limit
                                                            : limit.predicted > *headroom.limit);
        if (limit.stable_below == upwards && is_ahead && is_nearer) {
            headroom.limit = limit.predicted;
            headroom.who = "motor " + std::to_string(limit.worst.motor + 1) + ", " +
                           loops::hand_text(limit.worst.hand.name);
        }
    }
    return headroom;
}

StabilityPrediction prediction_of(const loops::StabilityCase &which) {
    const loops::WorstMember worst = loops::worst_member(which);
    const bool is_stable = worst.is_stable();
    return {worst,
            which.period_s,
            loops::passivity(which),
            loops::stability_with_linear_hands(which),
            headroom_of(which, is_stable, "kp", true),
            headroom_of(which, is_stable, "kd", true),
            headroom_of(which, is_stable, "dR", false)};
}

/// Device, rate and tuning can all be exchanged.
bool is_another(const loops::StabilityCase &before, const loops::StabilityCase &now) {
    return (now.q_rad - before.q_rad).cwiseAbs().maxCoeff() > kMoved_rad ||
           before.tuning != now.tuning || before.period_s != now.period_s ||
           before.delay_periods != now.delay_periods || before.device.name != now.device.name;
}

constexpr double kMinMargin = 1.0;
constexpr double kMaxMargin = 3.0;

/// One limit: its parameter, its value, and its distance from the current value.
void show_headroom(const control::Parameter &parameter, const StabilityHeadroom &headroom,
                   bool stable, bool upwards) {
    const std::string_view unit = parameter.unit;
    const std::string way =
        std::string(stable ? " may " : " must ") + (upwards == stable ? "rise to" : "fall to");
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    const ui::ExplainedRow row(explanation_of(parameter.name) +
                                   "\nits limit is predicted, other parameters unchanged, at the "
                                   "current configuration",
                               ui::ExplainedRow::Reach::items);
    ui::text(kFaintInk, "{}{}", parameter.symbol, way);
    ImGui::TableNextColumn();
    if (!headroom.limit) {
        ui::text(kFaintInk, "{}", stable ? "no limit found" : "does not help");
        ImGui::TableNextColumn();
        return;
    }
    ui::text(kInk, "{:.3g} {}", *headroom.limit, unit);
    ui::explain("unstable first beyond: " + headroom.who);
    ImGui::TableNextColumn();
    const double factor = std::max(*headroom.limit, headroom.now) /
                          std::max(1e-12, std::min(*headroom.limit, headroom.now));
    const ImVec4 ink = !stable ? kDanger : factor < 1.15 ? kWarning : kInk;
    ui::text(ink, "{} {:.3g}", upwards == stable ? "×" : "÷", factor);
    ui::explain(ui::formatted("from the current value, {:.3g} {}\nunstable first beyond: {}",
                              headroom.now, unit, headroom.who));
}

void show_verdict(const StabilityPrediction &prediction) {
    const bool stable = prediction.worst.is_stable();
    ui::text(stable ? kGood : kDanger, "{}", stable ? "stable" : "UNSTABLE");
    ImGui::SameLine();
    const double rate = std::log(prediction.worst.eigenvalue) / prediction.period_s;
    const std::string who = "motor " + std::to_string(prediction.worst.member.motor + 1) + ", " +
                            loops::hand_text(prediction.worst.member.hand.name);
    if (stable) {
        ui::text(kInk, "with the hands tried");
        ui::text(kFaintInk, "slowest decay: {:.0f} ms, {}", -1000.0 / rate, who);
    } else {
        ui::text(kInk, "grows e-fold in {:.1f} ms", 1000.0 / rate);
        ui::text(kFaintInk, "fastest: {}", who);
    }
    ui::explain(ui::formatted(
        "largest eigenvalue of the sampled loop, {:.5f}, in contact,\n"
        "each motor separately, with no hand and with five hands from light to firm;\n"
        "a motion decays, or grows, by a factor of e = 2.7 in this time",
        prediction.worst.eigenvalue));
    // One line whatever it says: the buttons below stay where they are.
    ui::text(kInk, "coupling {}",
             prediction.passive.holds()        ? "passive"
             : prediction.linear_hands.holds() ? "not passive, linear hands rest"
                                               : "not passive, some hands do not rest");
    ui::explain(
        loops::port_text(prediction.passive, prediction.linear_hands) +
        ".\npassive: whatever holds the device, and whatever is between it and the motors,\n"
        "cannot be made to oscillate; in contact and in free space, at any η.\n"
        "A linear hand is any of masses, springs and dampers that do not change");
}

void show_prediction(const StabilityPrediction &prediction) {
    show_verdict(prediction);
    const bool stable = prediction.worst.is_stable();
    if (ImGui::BeginTable("room", 3, ImGuiTableFlags_SizingStretchProp)) {
        show_headroom(control::parameter_of(&control::Tuning::K_P_V_per_rad), prediction.K_P,
                      stable, true);
        show_headroom(control::parameter_of(&control::Tuning::K_D_Vs_per_rad), prediction.K_D,
                      stable, true);
        show_headroom(control::parameter_of(&control::Tuning::dR_Ohm), prediction.dR, stable,
                      false);
        ImGui::EndTable();
    }
}

void show_margins(const limits::AutoTuned &found) {
    const control::TuningMargins &margins = found.margins;
    ui::wrapped(kInk, "K_DC {:.3g} N·m/rad at dR {:.3g} Ω", margins.K_DC_Nm_per_rad,
                found.tuning.dR_Ohm);
    ui::explain("static stiffness k_T K_P/dR (13) at the motor");
    ui::wrapped(kInk, "coupling {}", found.coupling);
    ui::wrapped(kInk, "margins: gains × {:.2f}, dR to {:.3g} Ω, delay + {}", margins.gain,
                margins.min_dR_Ohm, margins.more_delay_periods);
    ui::explain("changes with which it remains stable, one at a time: larger K_P and K_D, a lower\n"
                "dR, whole periods of delay. With larger gains it becomes unstable\n"
                "first with " +
                loops::hand_text(margins.worst_hand) + ". Stable: " + std::to_string(found.loops) +
                " loops, of all hands, configurations and η");
    ui::wrapped(found.gain_with_structure < 1.0 ? kWarning : kInk,
                "with compliance in cables or links: gains × {:.2f}", found.gain_with_structure);
    ui::explain("how much larger K_P and K_D may be until the loop is unstable with the data\n"
                "sheet's compliance between rotors and tip, wherever it is; below 1 it is now");
    if (found.tuning.K_P_V_per_rad >= limits::AutoTuneRequest{}.max_K_P_V_per_rad) {
        ui::text(kFaintInk, "K_P is at the end of its range: larger values would be stable");
    }
    if (found.taken_back > 0.0) {
        ui::wrapped(kInk,
                    "K_P is {:.0f} % below the predicted limit: encoder counts sustained a "
                    "vibration",
                    100.0 * found.taken_back);
    }
}

/// K_DC is less than what was found where a motor whose dR is held up would lose margin.
void show_held_K_DC(const session::Session &session, const limits::AutoTuned &found) {
    const double share = session.latest().stiffness_share.maxCoeff();
    if (share < 1.0 - 1e-9) {
        ui::wrapped(kWarning, "now {:.3g} N·m/rad, as dR is held at {:.3g} Ω: see Gains",
                    found.margins.K_DC_Nm_per_rad * share, active_dR_Ohm(session));
    }
}

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

/// Takes finished results, and restarts the computation if tuning or configuration changed.
void StabilityTab::update(const session::Session &session) {
    try {
        if (std::optional<StabilityPrediction> prediction = watch_.take()) {
            prediction_ = std::move(prediction);
        }
    } catch (const std::exception &error) {
        message_ = error.what();
    }
    const loops::StabilityCase now = stability_case_of(session, session.tuning().now());
    field_.update(now);
    if (!watch_.is_busy() && (!looked_at_ || is_another(*looked_at_, now))) {
        looked_at_ = now;
        watch_.start([now](BackgroundTalk &) { return prediction_of(now); });
    }
}

void StabilityTab::finish_search(session::Session &session, TuningEditor &editor) {
    try {
        std::optional<limits::AutoTuned> found = search_.take();
        if (!found) {
            return;
        }
        found_tuning_ = found->tuning;
        found_tuning_.eta = session.tuning().now().eta; // stable with any η
        found_ = std::move(found);
        const loops::StabilityCase now = stability_case_of(session, session.tuning().now());
        if (session.tuning().slots().active() == searched_slot_ &&
            now.period_s == searched_.period_s && now.delay_periods == searched_.delay_periods &&
            now.device.name == searched_.device.name) {
            message_.clear();
            editor.replace(found_tuning_, "found in the window");
        } else {
            message_ = "found for another slot, device or servo than now: not activated";
        }
    } catch (const std::exception &error) {
        message_ = error.what();
    }
}

/// For the stiffest tuning with the active dR and the selected margin.
void StabilityTab::start_search(const session::Session &session) {
    found_.reset();
    message_.clear();
    searched_ = stability_case_of(session, session.tuning().now());
    searched_slot_ = session.tuning().slots().active();
    search_.start(
        [request = limits::AutoTuneRequest{searched_, margin_, is_passive_}](BackgroundTalk &talk) {
            return limits::auto_tune(request, [&talk](double share) {
                talk.share = share;
                return talk.is_needed();
            });
        });
}

/// The result as a tuning file in the own folder.
void StabilityTab::save() {
    if (!found_) {
        return;
    }
    message_ = save_as(in_output_dir(dated_name("tuned") + ".toml"), [this](std::ostream &out) {
        control::write_tuning_file(out, {found_tuning_, "found in the window", found_->margins});
    });
}

void StabilityTab::draw_search(const session::Session &session) {
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(8.0F * font);
    ui::slider_with_number("margin", margin_, kMinMargin, kMaxMargin, "× %.2f");
    ui::explain("for the search: the factor by which K_P and K_D can grow until the loop is\n"
                "unstable with some hand; 1 is the limit, with no reserve for modelling errors");
    ImGui::SameLine();
    if (search_.is_busy()) {
        if (ui::button("cancel")) {
            search_.give_up();
            message_ = "cancelled: the tuning is unchanged";
        }
        const std::string done =
            "searching: " + std::to_string(std::lround(100.0 * search_.share())) + " %";
        ui::progress("search", search_.share(), done);
        return;
    }
    ui::checkbox("passive", is_passive_);
    ui::explain("for the search: whatever holds the device cannot be made to oscillate, not only\n"
                "the hands tried; less stiff");
    ImGui::SameLine();
    if (ui::button("find the stiffest")) {
        start_search(session);
    }
    ui::explain("K_P, K_D and λ for the stiffest contact with this dR, map, servo rate and\n"
                "delay that is stable with every hand, at any η and tip position;\n"
                "takes seconds, is activated at once, and can be undone");
}

void StabilityTab::draw_found(session::Session &session, TuningEditor &editor) {
    if (found_) {
        const bool is_active = session.tuning().now() == found_tuning_;
        if (enabled_button("activate", !is_active)) {
            editor.replace(found_tuning_, "found in the window");
        }
        ui::explain("the tuning that was found; undo takes it back");
        ImGui::SameLine();
        if (ui::button("save as file")) {
            save();
        }
        ui::explain("writes the tuning and its margins to " + output_dir_text() +
                    ";\nload it with --tuning-file");
        ImGui::SameLine();
        ui::text(is_active ? kGood : kFaintInk, "{}", is_active ? "found, active" : "found");
        show_margins(*found_);
        if (is_active) {
            show_held_K_DC(session, *found_);
        }
    }
    if (!message_.empty()) { // below the buttons, which it must not move
        ui::wrapped(kInk, "{}", message_);
    }
}

void StabilityTab::draw(session::Session &session, TuningEditor &editor) {
    update(session);
    if (prediction_) {
        show_prediction(*prediction_);
    } else {
        ui::text(kFaintInk, "computing stability …");
    }
    ImGui::Separator();
    draw_search(session);
    draw_found(session, editor);
    ui::show_error(editor.error());
    ImGui::Separator();
    if (const auto tuning = field_.draw(session.tuning().now())) {
        editor.replace(*tuning, "from the map");
    }
}

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
            grid.eigenvalue.push_back(talk.is_needed() ? loops::worst_member(there).eigenvalue
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

std::optional<control::Tuning> StabilityField::draw(const control::Tuning &now) {
    if (!grid_) {
        ui::text(kFaintInk, "computing the map …");
        return std::nullopt;
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
        return std::nullopt;
    }
    explain_point(*grid_, area, mouse);
    if (!ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
        return std::nullopt;
    }
    control::Tuning clicked = now;
    clicked.K_P_V_per_rad = area.x_at(mouse.x);
    clicked.dR_Ohm = area.y_at(mouse.y);
    return clicked;
}

} // namespace springdrive::app
