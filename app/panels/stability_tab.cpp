#include "app/panels/stability_tab.h"

#include "app/host/output.h"
#include "app/host/output_dir.h"
#include "app/panels/tuning_consequences.h"
#include "app/plots/symbols.h"
#include "app/widgets/widgets.h"
#include "base/file_names.h"
#include "device/core/phantom/kinematics.h"
#include "engine/lab/limits/stability_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
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
    return {worst, which.period_s, headroom_of(which, is_stable, "kp", true),
            headroom_of(which, is_stable, "kd", true), headroom_of(which, is_stable, "dR", false)};
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
        ui::text(kInk, "with every hand");
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

void show_search(const session::Session &session, StabilityTabState &state) {
    const float font = ImGui::GetFontSize();
    ImGui::SetNextItemWidth(8.0F * font);
    ui::slider_with_number("margin", state.margin, kMinMargin, kMaxMargin, "× %.2f");
    ui::explain("for the search: the factor by which K_P and K_D can grow until the loop is\n"
                "unstable with some hand; 1 is the limit, with no reserve for modelling errors");
    ImGui::SameLine();
    if (state.is_tuning()) {
        if (ui::button("cancel")) {
            state.stop_tuning();
        }
        const std::string done =
            "searching: " + std::to_string(std::lround(100.0 * state.tuning_share())) + " %";
        ui::progress("search", state.tuning_share(), done);
        return;
    }
    if (ui::button("find the stiffest")) {
        state.start_tuning(session);
    }
    ui::explain("K_P, K_D and λ for the stiffest contact with this dR, map, servo rate and\n"
                "delay that is stable with every hand, at any η and tip position;\n"
                "takes seconds, is activated at once, and can be undone");
}

void show_margins(const limits::AutoTuned &found) {
    const control::TuningMargins &margins = found.margins;
    ui::wrapped(kInk, "K_DC {:.3g} N·m/rad at dR {:.3g} Ω", margins.K_DC_Nm_per_rad,
                found.tuning.dR_Ohm);
    ui::explain("static stiffness k_T K_P/dR (13) at the motor");
    ui::wrapped(kInk, "margins: gains × {:.2f}, dR to {:.3g} Ω, delay + {}", margins.gain,
                margins.min_dR_Ohm, margins.more_delay_periods);
    ui::explain("changes with which it remains stable, one at a time: larger K_P and K_D, a lower\n"
                "dR, whole periods of delay. With larger gains it becomes unstable\n"
                "first with " +
                loops::hand_text(margins.worst_hand) + ". Stable: " + std::to_string(found.loops) +
                " loops, of all hands, configurations and η");
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

/// K_DC is less than what was found while dR is held up, as by windings that are still cold.
void show_held_K_DC(const session::Session &session, const limits::AutoTuned &found) {
    const double held_Ohm = active_dR_Ohm(session);
    if (held_Ohm > found.tuning.dR_Ohm * (1.0 + 1e-9)) {
        ui::wrapped(kWarning, "now {:.3g} N·m/rad, as dR is held at {:.3g} Ω: see Gains",
                    found.margins.K_DC_Nm_per_rad * found.tuning.dR_Ohm / held_Ohm, held_Ohm);
    }
}

void show_found(session::Session &session, TuningEditor &editor, StabilityTabState &state) {
    if (state.found()) {
        const bool is_active = session.tuning().now() == state.found_tuning();
        {
            const ui::Disabled when_active(is_active);
            if (ui::button("activate")) {
                editor.replace(state.found_tuning(), "found in the window");
            }
        }
        ui::explain("the tuning that was found; undo takes it back");
        ImGui::SameLine();
        if (ui::button("save as file")) {
            state.save();
        }
        ui::explain("writes the tuning and its margins to " + output_dir_text() +
                    ";\nload it with --tuning-file");
        ImGui::SameLine();
        ui::text(is_active ? kGood : kFaintInk, "{}", is_active ? "found, active" : "found");
        show_margins(*state.found());
        if (is_active) {
            show_held_K_DC(session, *state.found());
        }
    }
    if (!state.message().empty()) { // below the buttons, which it must not move
        ui::wrapped(kInk, "{}", state.message());
    }
}

} // namespace

void StabilityTabState::update(const session::Session &session) {
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

void StabilityTabState::finish_search(session::Session &session, TuningEditor &editor) {
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

void StabilityTabState::start_tuning(const session::Session &session) {
    found_.reset();
    message_.clear();
    searched_ = stability_case_of(session, session.tuning().now());
    searched_slot_ = session.tuning().slots().active();
    search_.start([request = limits::AutoTuneRequest{searched_, margin}](BackgroundTalk &talk) {
        return limits::auto_tune(request, [&talk](double share) {
            talk.share = share;
            return talk.is_wanted();
        });
    });
}

void StabilityTabState::stop_tuning() {
    search_.give_up();
    message_ = "cancelled: the tuning is unchanged";
}

void StabilityTabState::save() {
    if (!found_) {
        return;
    }
    message_ = save_as(in_output_dir(dated_name("tuned") + ".toml"), [this](std::ostream &out) {
        control::write_tuning_file(out, {found_tuning_, "found in the window", found_->margins});
    });
}

void draw_stability_tab(session::Session &session, TuningEditor &editor, StabilityTabState &state) {
    state.update(session);
    if (state.prediction()) {
        show_prediction(*state.prediction());
    } else {
        ui::text(kFaintInk, "computing stability …");
    }
    ImGui::Separator();
    show_search(session, state);
    show_found(session, editor, state);
    ui::show_error(editor.error());
    ImGui::Separator();
    state.field().draw(session.tuning().now());
    if (const std::optional<control::Tuning> tuning = state.field().take_clicked()) {
        editor.replace(*tuning, "from the map");
    }
}

} // namespace springdrive::app
