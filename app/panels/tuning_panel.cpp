#include "app/panels/panels.h"
#include "app/widgets/widgets.h"

#include "app/asset_folder.h"
#include "app/panels/presets.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"
#include "engine/control/tuning_file.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace springdrive::app {

namespace {

/// A number with its unit, laid out as `label   value unit`.
void show(const char *label, CheckedFormat<double> format, double value, const char *unit,
          const char *explanation) {
    ImGui::TableNextColumn();
    ui::text(kFaintInk, "{}", label);
    ui::explain(explanation);
    ImGui::TableNextColumn();
    const ui::Scope scope(label);
    std::array<char, 32> digits{};
    print(digits, format, value);
    ui::text(kInk, "{} {}", digits.data(), unit);
    ui::explain(explanation);
}

/// Enough digits for the parameter's range.
const char *digits_for(const control::Parameter &parameter) {
    if (parameter.maximum >= 1000.0) {
        return "%.0f";
    }
    return parameter.logarithmic && parameter.maximum <= 1.0 ? "%.4f" : "%.3f";
}

/// The number beside the slider. It becomes active on Enter or when the field loses focus.
void edit_typed(TuningPanelState &state, std::size_t index, double &value) {
    double shown = state.typing == index ? state.typed : value;
    ImGui::SetNextItemWidth(4.6F * ImGui::GetFontSize());
    ui::number_field("##typed", shown, digits_for(control::kParameters[index]));
    if (ImGui::IsItemActive()) {
        state.typing = index;
        state.typed = shown;
    }
    if (ImGui::IsItemDeactivatedAfterEdit()) {
        value = state.typed;
    }
    if (ImGui::IsItemDeactivated()) {
        state.typing.reset();
    }
}

bool edit_parameter(std::size_t index, control::Tuning &tuning, TuningPanelState &state,
                    bool is_active) {
    const control::Parameter &parameter = control::kParameters[index];
    double &value = tuning.*parameter.value;
    const double before = value;
    const float font = ImGui::GetFontSize();
    const ui::Scope scope(parameter.name);
    ImGui::AlignTextToFramePadding();
    ui::text(is_active ? kInk : kFaintInk, "{}", parameter.symbol);
    ui::explain(ui::formatted("{} {}\nfrom {:g} to {:g} {}", parameter.help, parameter.equation,
                              parameter.minimum, parameter.maximum, parameter.unit));
    ImGui::SameLine(2.9F * font);
    ImGui::SetNextItemWidth(9.0F * font);
    ui::slider("##slider", value, parameter.minimum, parameter.maximum, parameter.logarithmic);
    ImGui::SameLine();
    edit_typed(state, index, value);
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ui::text(kFaintInk, "{}", parameter.unit);
    ImGui::SameLine(ImGui::GetContentRegionMax().x - 1.7F * font);
    if (ui::button("\u21BA##reset")) {
        value = parameter.default_value();
    }
    ui::explain(ui::formatted("reset to {:g}", parameter.default_value()));
    // Typed values may be out of range.
    if (!(value >= parameter.minimum && value <= parameter.maximum)) {
        value =
            std::isnan(value) ? before : std::clamp(value, parameter.minimum, parameter.maximum);
    }
    return value != before;
}

/// One button per label of the presets.
bool choose_preset(const session::Session &session, control::Tuning &tuning) {
    bool changed = false;
    for (const char *label : kPresetLabels) {
        const std::string file = preset_file(label, session.servo().rate_hz(),
                                             session.device().device().delay_periods());
        const ui::Disabled without_file(file.empty());
        if (ui::button(label)) {
            try {
                tuning = control::read_tuning_file(asset_folder() / "tunings" / (file + ".toml"));
                changed = true;
            } catch (const InputError &) {
                // The folder was removed while the program runs: the button does nothing.
            }
        }
        ui::explain(file.empty() ? "no tuning is stored for this servo rate and delay:\n"
                                   "find the stiffest in the Stability tab"
                                 : "assets/tunings/" + file + ".toml");
        ImGui::SameLine();
    }
    return changed;
}

/// A motor's active dR: larger than requested if too little is known of its R.
double active_dR_Ohm(const session::Session &session, std::size_t motor) {
    const servo::ServoSample &now = session.latest();
    const control::ObservedMotor &R = now.motor[motor];
    const double dR_Ohm =
        std::max(session.servo().inputs().tuning.dR_Ohm, control::held_up_dR_Ohm(R));
    const servo::WindingStatus &winding = now.winding[motor];
    return winding.is_limited ? std::max(dR_Ohm, R.mean.resistance_Ohm - winding.R_hat_limit_Ohm)
                              : dR_Ohm;
}

double active_dR_Ohm(const session::Session &session) {
    return std::max(
        {active_dR_Ohm(session, 0), active_dR_Ohm(session, 1), active_dR_Ohm(session, 2)});
}

/// What the servo knows of each motor's R.
void show_resistances(session::Session &session) {
    bool is_wanted = session.wants_resistance_observed();
    if (ui::checkbox("observe R", is_wanted)) {
        session.observe_resistance(is_wanted);
    }
    ui::explain("R of each winding, observed while it is driven:\n"
                "R̂ follows it, so that dR is what the slider says. So are k_T,\n"
                "for an equal K_q, and the offset of the current's sensor.\n"
                "Otherwise all are those of the device file.");
    const control::ObservedMotors &R = session.latest().motor;
    if (!R.front().is_observed) {
        if (is_wanted) {
            ImGui::SameLine();
            ui::text(kFaintInk, "no inductance");
        }
        return;
    }
    constexpr double kUnknown_Ohm = 0.02;
    for (std::size_t j = 0; j < R.size(); ++j) {
        const control::ResistanceEstimate &mean = R[j].mean;
        const bool is_known = R[j].is_trusted && mean.deviation_Ohm < kUnknown_Ohm;
        ImGui::SameLine();
        ui::text(R[j].is_trusted ? kFaintInk : kDanger, "{}",
                 is_known ? ui::formatted("{:.2f}", mean.resistance_Ohm)
                          : ui::formatted("{:.1f}?", mean.resistance_Ohm));
        ui::explain(
            ui::formatted("motor {}: R is {:.4f} ± {:.4f} Ω, averaged over the commutator's\n"
                          "angles, as the amplifier's sensor sees it; k_T is {:.4f} N·m/A,\n"
                          "the sensor's offset {:.1f} mA",
                          j + 1, mean.resistance_Ohm, mean.deviation_Ohm,
                          R[j].torque_constant_Nm_per_A, 1e3 * R[j].offset_A));
    }
    ImGui::SameLine();
    ui::text(kFaintInk, "Ω");
}

/// Why dR is larger than requested.
void show_held_up_dR(const session::Session &session) {
    const servo::ServoSample &now = session.latest();
    const double wanted_Ohm = session.servo().inputs().tuning.dR_Ohm;
    double left_s = 0.0;
    for (std::size_t j = 0; j < now.motor.size(); ++j) {
        if (!now.motor[j].is_trusted) {
            ui::text(kDanger, "motor {}: its current contradicts its motion", j + 1);
            ui::explain("a current sensor is wrong, or the motor is not the file's;\n"
                        "to observe anew, switch \"observe R\" off and on");
        }
        left_s = std::max(left_s,
                          control::touch_left_s(session.description(), j, now.motor[j], wanted_Ohm,
                                                now.current_A[static_cast<Eigen::Index>(j)]));
    }
    const double active_Ohm = active_dR_Ohm(session);
    if (!(active_Ohm > wanted_Ohm)) {
        return;
    }
    constexpr double kTooLong_s = 20.0;
    const bool are_trusted = std::ranges::all_of(now.motor, &control::ObservedMotor::is_trusted);
    if (!are_trusted) {
        ui::text(kDanger, "dR is held at {:.3f} Ω", active_Ohm);
    } else if (left_s == 0.0) {
        ui::text(kDanger, "dR is held at {:.3f} Ω by the winding guard", active_Ohm);
    } else if (left_s > kTooLong_s) {
        ui::text(kDanger, "dR is held at {:.3f} Ω: press on a surface", active_Ohm);
    } else {
        ui::text(kDanger, "dR is held at {:.3f} Ω: touch on, {:.1f} s", active_Ohm,
                 std::max(0.1, left_s));
    }
}

void show_consequences(const session::Session &session) {
    control::Tuning tuning = session.servo().inputs().tuning;
    tuning.dR_Ohm = active_dR_Ohm(session);
    const servo::ServoSample &now = session.latest();
    control::Coupling c = control::coupling(session.description().motor.front(), tuning,
                                            1.0 / session.servo().rate_hz(),
                                            session.device().device().delay_periods());
    // The rotors' added inertia as a mass at the tip, a mean over directions.
    const Matrix3 J_inverse =
        device::motor_jacobian(
            session.description().geometry,
            device::joint_from_motor(session.description().geometry, now.theta_rad))
            .inverse();
    const double added_mass_g = 1000.0 * c.added_inertia_kg_m2 * J_inverse.squaredNorm() / 3.0;
    c.K_DC_Nm_per_rad = control::mean_static_stiffness_Nm_per_rad(session.description(), tuning);
    const double stiffness = control::tip_stiffness_N_per_m(c, now.alpha_rad2_per_m2, tuning.eta);

    if (!ImGui::BeginTable("consequences", 4, ImGuiTableFlags_SizingFixedFit)) {
        return;
    }
    show("K_L = K_HF", "{:.2f}", c.K_L_Nm_per_rad, "N·m/rad",
         "inductive stiffness k_T²/L (4), (14)");
    show("K_DC", "{:.3f}", c.K_DC_Nm_per_rad, "N·m/rad", "static stiffness k_T K_P/dR (13)");
    show("B_dR", "{:.2e}", c.B_dR_Nms_per_rad, "N·m·s/rad", "residual series damper k_T²/dR (8)");
    show("lag τ", "{:.2f}", 1000.0 * c.loop_lag_s, "ms",
         "lag of the velocity loop: T (a/(1 − a) + 1 + d), a = exp(−λT)");
    show("added", "{:.1e}", c.added_inertia_kg_m2, "kg·m²",
         "inertia added to each rotor in free space: k_T² τ/dR");
    show("at the tip", "{:.0f}", added_mass_g, "g",
         "the same as a mass at the tip, mean over directions, at this configuration");
    show("tip stiffness", "{:.2f}", 1e-3 * stiffness, "N/mm",
         "(1 − η) α K_DC with the transpose map, on a rigid surface, at this configuration");
    show("active α", "{:.0f}", now.alpha_rad2_per_m2, "rad²/m²", "α of (23) at this configuration");
    ImGui::EndTable();
    show_held_up_dR(session);
    if (tuning.map == control::MotionMap::transpose &&
        now.alpha_rad2_per_m2 > now.alpha_bound_rad2_per_m2 * (1.0 + 1e-9)) {
        ui::text(kDanger, "α is above its bound (29), {:.0f} rad²/m²", now.alpha_bound_rad2_per_m2);
        ui::explain("the gains of a motor exceed its tuning, so that its margin is smaller;\n"
                    "the loop's own stability limit lies higher");
    }
}

void draw_tuning_tab(session::Session &session, TuningPanelState &state) {
    control::Tuning tuning = session.servo().inputs().tuning;
    const float font = ImGui::GetFontSize();
    bool changed = choose_preset(session, tuning);
    show_resistances(session);
    ImGui::SetNextItemWidth(9.0F * font);
    changed |= ui::choice("##map", tuning.map, control::kMotionMapLabels);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(9.0F * font);
    changed |= ui::choice("##alpha", tuning.alpha_mode, control::kAlphaModeLabels);
    for (std::size_t i = 0; i < control::kParameters.size(); ++i) {
        const control::Parameter &parameter = control::kParameters[i];
        const bool is_alpha = parameter.value == &control::Tuning::alpha_rad2_per_m2;
        const bool is_active = !is_alpha || tuning.alpha_mode == control::AlphaMode::by_hand;
        if (edit_parameter(i, tuning, state, is_active)) {
            changed = true;
            // Moving the slider of α selects α by hand.
            tuning.alpha_mode = is_alpha ? control::AlphaMode::by_hand : tuning.alpha_mode;
        }
    }
    if (changed) {
        session.servo().tune(tuning);
    }
    ImGui::Separator();
    show_consequences(session);
}

} // namespace

void draw_tuning_panel(session::Session &session, TuningPanelState &state, const Rectangle &place) {
    const ui::Panel panel("Tuning", place);
    const ui::Tabs tabs("tuning");
    if (!tabs) {
        return;
    }
    if (const ui::Tab gains("Gains"); gains) {
        draw_tuning_tab(session, state);
    }
    if (const ui::Tab stability("Stability"); stability) {
        draw_stability_tab(session, state.stability);
    }
}

} // namespace springdrive::app
