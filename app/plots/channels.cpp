#include "app/plots/channels.h"

#include "app/widgets/widgets.h"
#include "base/degrees.h"
#include "engine/control/rendered_force.h"
#include "engine/control/tuning.h"
#include "engine/servo/safety_limits.h"
#include "engine/session/telemetry_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace springdrive::app {

namespace {

constexpr std::array<Symbol, 109> kSymbols{{
    // Parameters of the tuning.
    {"dR", "dR", "what is left of R at this motor, as far as R is known", "(7)",
     "residual uncanceled resistance"},
    {"K_P", "K_P", "", "(10), (13)", "error gain, proportional"},
    {"K_D", "K_D", "", "(10), (12)", "error gain, derivative"},
    {"lambda", "λ", "", "(12)", "cutoff frequency of the velocity filter"},
    {"alpha", "α", "", "(23), (29)", "scale of the Jacobian transpose"},
    {"eta", "η", "", "(17), (30)", "0 rigid contact, 1 freespace"},

    // Derived from the tuning, in the panel.
    {"K_L = K_HF", "K_L", "stiffness of the winding's inductance, met by fast motions", "(4), (14)",
     "spring K_L; high frequency stiffness K_HF"},
    {"K_DC", "K_DC", "stiffness that a motor holds at rest: k_T K_P/dR", "(13)",
     "static stiffness"},
    {"B_dR", "B_dR", "damper in series with the spring, by which the set-point drifts: k_T²/dR",
     "(8)", "residual series damper"},
    {"lag τ", "τ", "lag of the velocity loop: T (a/(1 − a) + 1 + d), a = exp(−λT)", "", ""},
    {"added", "", "inertia that each rotor seems to gain in free space: k_T² τ/dR", "(16)",
     "added mass in freespace"},
    {"at the tip", "", "the same as a mass at the tip, mean over directions, at this configuration",
     "", ""},
    {"tip stiffness", "",
     "of the coupling at rest on a rigid surface, at this configuration: (1 − η) α K_DC with the "
     "transpose map",
     "(21), (27)", "Cartesian stiffness K_x"},
    {"active α", "α", "scale of the transpose map that acts at this configuration", "(23), (29)",
     "α"},
    {"maps", "",
     "how a set-point of the tip becomes one of the motors: the inverse is stiffest but bends the "
     "force, the transpose keeps its direction",
     "(18), (23)", "invkin; Jacobian transpose control"},
    {"observe R", "R-hat",
     "R of each winding, observed while it is driven: R-hat follows it, so that dR is what the "
     "slider "
     "says; k_T and the offset of the current's sensor, too",
     "(6), (7)", "R-hat, resistance cancellation"},

    // Measurements.
    {"tick", "", "number of the servo's tick", "", ""},
    {"time", "", "servo time: each tick adds one period", "", ""},
    {"measurement_number", "", "number of the measurement that the tick used", "", ""},
    {"measured", "", "time of the measurement, by the device's clock", "", ""},
    {"arrival", "", "whether the measurement is new: 0 fresh; else late, repeated or absent", "",
     ""},
    {"health", "", "of the device: 0 all is well", "", ""},
    {"board_faults", "", "faults that the board reports, one bit each", "", ""},
    {"supply", "", "voltage of the amplifiers' supply", "", ""},
    {"since_last", "", "time since the previous measurement", "", ""},
    {"counts", "", "of the motor's encoder", "", ""},
    {"theta", "θ", "angle of the motor, by its encoder", "(10)", "rotor position"},
    {"theta_rate", "dθ/dt", "rate of the motor's angle, filtered with λ", "(10)",
     "filtered rotor velocity"},
    {"tip", "x", "position of the tip", "(22), (30)", "user position"},
    {"current", "i", "in the winding, as measured", "(1), (3)", "winding current"},
    {"force", "F", "rendered at the tip: J^−T k_T i", "(3), (22)", "force"},
    {"force_outward", "F", "", "(22)", "force"},
    {"force_up", "F", "", "(22)", "force"},
    {"tip_speed", "dx/dt", "", "(22)", ""},

    // Contact.
    {"touching", "", "1 while the proxy rests on a surface", "", ""},
    {"proxy", "x₀", "where the proxy rests on the surface; in free space the tip", "(15), (30)",
     "contact constraint"},
    {"allowed_motion", "P",
     "an element of the projector onto the motions that the contact leaves free", "", ""},
    {"normal", "n", "unit normal of the contact, towards the free side", "", ""},
    {"surface_eta", "η", "of the surface that is touched", "(30)", "η"},
    {"active_constraints", "", "0 free, 1 face, 2 edge, 3 vertex", "", ""},
    {"sticking", "", "1 while friction holds the proxy", "", ""},
    {"settled", "", "0 where a tick's budget ended before the proxy rested", "", ""},
    {"surface", "", "the point of the surface nearest to the proxy", "", ""},
    {"barycentric", "", "where in its triangle that point is", "", ""},
    {"triangle", "", "number of the triangle that is touched", "", ""},
    {"material", "", "number of its material", "", ""},
    {"scene_id", "", "number of the scene in this run", "", ""},
    {"penetration", "", "", "(22)", "length of Δx"},
    {"normal_direction", "", "", "", "direction of the virtual surface"},

    // The law.
    {"map", "", "0 inverse, 1 transpose", "(18), (23)", ""},
    {"alpha_mode", "", "source of α: 0 on the fly, 1 global, 2 by hand, 3 at touch", "(29)", ""},
    {"eta_in_force", "η", "of surface and tuning together", "(30)", "η"},
    {"global_alpha", "α", "the minimum of the bound over the workspace", "(29)", "global minimum"},
    {"alpha_in_force", "α", "that acts", "(23)", "α"},
    {"alpha_bound", "α", "above it, a motor's gains exceed its tuning", "(29)", "λ_min[(J J^T)⁻¹]"},
    {"x_Sd", "x_Sd", "set-point of the tip", "(30)", "desired set-point"},
    {"theta_Sd", "θ_Sd", "set-point of the motor", "(18), (23)", "desired set-point"},
    {"inverse_possible", "", "0 where the pose is out of reach or singular for the inverse map",
     "(18)", ""},
    {"carried", "", "offset of e_W, so that no change of tuning is a step", "", ""},
    {"lag", "a", "from a measurement to the middle of the voltage computed from it: T (½ + d)", "",
     ""},
    {"stiffness_share", "", "of K_q, so that no motor's margin is lost where dR is held up", "(20)",
     ""},
    {"command_mode", "", "whether the motor is driven, braked or left open", "", ""},
    {"e_W", "e_W", "voltage that the servo commands, beside the cancelled resistance", "(6), (10)",
     "additional voltage input"},
    {"R", "R", "resistance of the winding at this angle, as observed", "(1)", "winding resistance"},
    {"R_deviation", "R", "standard deviation of what is known of R at this angle", "", ""},
    {"R_mean", "R", "resistance of the winding, mean over the commutator's angles", "(1), (7)",
     "winding resistance"},
    {"R_mean_deviation", "R", "standard deviation of what is known of that mean", "", ""},
    {"k_T", "k_T", "torque per current, and voltage per speed", "(2), (3)",
     "torque/speed constant"},
    {"offset", "", "of the current's sensor, as observed", "", ""},
    {"R_observed", "R", "1 while R-hat follows the observed R", "", ""},
    {"R_trusted", "R", "0 where currents and motion contradict each other", "", ""},
    {"V_b", "V_b", "voltage with the sign of the current, of brushes and bridge, as observed", "",
     ""},
    {"V_b_deviation", "V_b", "standard deviation of what is known of V_b", "", ""},
    {"R_hat_max", "R-hat", "the most that was passed on in the tick before", "(7)", ""},
    {"trim", "", "voltage that makes up for what the current lacks at rest", "", ""},
    {"load", "", "whether the motor carries some of the force that lasts, from 0 to 1", "", ""},
    {"R_hat", "R-hat", "resistance that the amplifier cancels: R − dR", "(6), (7)",
     "R-hat, gain of the positive current feedback"},

    // Directions.
    {"rendered_error", "", "angle from the normal to the force, in this tick", "(25)",
     "force direction error"},
    {"inverse_error", "", "the same for the force that the inverse map would hold at rest",
     "(18), (21)", "force direction error of J⁻¹ control"},
    {"transpose_error", "", "the same for the force that the transpose map would hold at rest",
     "(23), (27)", "force direction error of J^T control"},
    {"inverse_measured", "", "", "(18)", "force direction error of J⁻¹ control"},
    {"transpose_measured", "", "", "(23)", "force direction error of J^T control"},

    // Safety.
    {"safety_state", "", "0 waiting, 1 starting, 2 running, 3 tripped, 4 releasing", "", ""},
    {"trip_cause", "", "why the motors were stopped; 0: they were not", "", ""},
    {"trip_measured", "", "the value that was beyond its limit, in SI units", "", ""},
    {"trip_limit", "", "that limit, in SI units", "", ""},
    {"ramp", "", "share of the command that is passed on", "", ""},
    {"held_stop", "", "number of the requested stop that nobody has released", "", ""},
    {"held_back_force", "", "which limit holds the force of the command back; 0: none", "", ""},
    {"held_back_voltage", "", "1 where the supply limits the command", "", ""},
    {"held_back_at_edge", "", "1 at the soft wall around the workspace", "", ""},
    {"limit", "", "of the safety monitor: beyond it the motors brake", "", ""},
    {"generated_energy", "", "delivered to the hand beyond what it put in", "", ""},
    {"winding_least", "", "lower bound of the winding's temperature", "", ""},
    {"winding_greatest", "", "upper bound of the winding's temperature", "", ""},
    {"R_hat_limit", "R-hat", "the largest safe R-hat at the winding's temperature", "(6)", "R-hat"},
    {"R_hat_limited", "R-hat", "1 where more than that was asked for", "(6)", "R-hat"},
    {"R_contradicted", "R", "1 where observations of R exclude each other", "", ""},
    {"generated", "R-hat", "1 once the winding was found to generate: R-hat was above R", "", ""},

    // Timing.
    {"missed_deadlines", "", "ticks that were skipped before this one", "", ""},
    {"missed_in_a_row", "", "those, with the ones before the preceding late ticks", "", ""},
    {"missed_periods", "", "periods of the device without a measurement", "", ""},
    {"clock", "", "start of the tick, since the servo began", "", ""},
    {"lateness", "", "from the tick's deadline to its start", "", ""},
    {"period", "T", "from the start of the last tick to this one", "", "servo period"},
    {"read", "", "duration of reading the device", "", ""},
    {"compute", "", "from the measurement to the command", "", ""},
    {"write", "", "duration of writing the command", "", ""},
    {"d", "d", "delay from reading θ to applying e_W, in periods of the servo", "", ""},
}};

/// Longer ones first, where one ends in another.
constexpr std::array<std::string_view, 15> kUnitEndings{
    "_rad_per_s", "_m_per_s", "_Vs_per_rad", "_V_per_rad", "_rad2_per_m2",
    "_Nm_per_A",  "_Ohm",     "_rad",        "_m",         "_s",
    "_V",         "_A",       "_N",          "_J",         "_C"};

std::string without_ending(std::string_view name) {
    for (const std::string_view ending : kUnitEndings) {
        if (name.ends_with(ending)) {
            return std::string(name.substr(0, name.size() - ending.size()));
        }
    }
    return std::string(name);
}

/// A word between underscores, such as the "x" of "tip_x".
std::string without_axis(const std::string &name) {
    constexpr std::array<std::string_view, 3> kAxes{"_x", "_y", "_z"};
    for (const std::string_view axis : kAxes) {
        if (name.ends_with(axis)) {
            return name.substr(0, name.size() - axis.size());
        }
    }
    return name;
}

std::string lines_of(const Symbol &symbol, std::string_view head, std::string_view meaning,
                     std::string_view unit) {
    head = head == symbol.symbol ? "" : head; // not twice
    std::string text =
        fmt::format("{}{}{}\n{}", symbol.symbol, symbol.symbol.empty() || head.empty() ? "" : "   ",
                    head, meaning);
    if (text.starts_with('\n')) { // neither symbol nor name
        text.erase(0, 1);
    }
    text += unit.empty() ? "" : fmt::format("\nunit: {}", unit == "1" ? "–" : unit);
    text += symbol.equations.empty()
                ? ""
                : fmt::format("\nequation{} {} of the paper",
                              symbol.equations.find(',') == std::string_view::npos ? "" : "s",
                              symbol.equations);
    text += symbol.paper.empty() ? "" : fmt::format("\nin the paper: {}", symbol.paper);
    return text;
}

/// The head of a limit's tooltip is what it limits.
std::string limit_meaning(std::string_view name) {
    for (const servo::SafetyLimit &limit : servo::kSafetyLimits) {
        if (name == std::string("limit_") + limit.name) {
            return limit.what;
        }
    }
    return {};
}

} // namespace

std::span<const Symbol> symbols() { return kSymbols; }

const Symbol *symbol_named(std::string_view name) {
    const auto *const found = std::ranges::find(kSymbols, name, &Symbol::name);
    return found == kSymbols.end() ? nullptr : found;
}

std::string without_unit(const session::Channel &channel) {
    return channel.unit == "1" ? channel.name : without_ending(channel.name);
}

std::string quantity_of(const session::Channel &channel) {
    if (channel.name.starts_with("limit_")) {
        return "limit";
    }
    if (channel.name.starts_with("allowed_motion_")) {
        return "allowed_motion";
    }
    std::string name = without_unit(channel);
    const std::size_t motor = name.find_first_of("123");
    if (motor != std::string::npos) {
        name.erase(motor, 1);
    }
    return without_axis(name);
}

std::string explanation_of(std::string_view name, std::string_view unit) {
    const auto *const parameter =
        std::ranges::find(control::kParameters, name, &control::Parameter::name);
    if (parameter != control::kParameters.end()) {
        const Symbol &symbol = *symbol_named(without_ending(name));
        return lines_of(symbol, "", parameter->help, parameter->unit) +
               fmt::format("\nfrom {:g} to {:g}", parameter->minimum, parameter->maximum);
    }
    if (const std::optional<std::size_t> channel = session::channel_named(name)) {
        const session::Channel &known = session::channels()[*channel];
        const Symbol *const symbol = symbol_named(quantity_of(known));
        if (symbol == nullptr) {
            return known.name;
        }
        const std::string limited = limit_meaning(name);
        const std::string meaning =
            known.about.empty() ? std::string(symbol->meaning) : known.about;
        return lines_of(*symbol, known.name,
                        limited.empty() ? meaning : fmt::format("{}: {}", limited, meaning),
                        known.unit);
    }
    const Symbol *const symbol = symbol_named(name);
    return symbol == nullptr ? std::string(name) : lines_of(*symbol, name, symbol->meaning, unit);
}

namespace {

/// Channels whose look has a meaning. Solid lines are measured and so include the plant; dashed
/// ones are what the map alone would do, at rest and without any plant.
struct NamedLook {
    std::string_view channel;
    std::string_view label;
    Stroke stroke;
};

const std::array<NamedLook, 8> &named_looks() {
    static const std::array<NamedLook, 8> looks{{
        {"transpose_error_rad", "transpose, ideal", {kTransposeMap, 1.6F, Dash::dashed}},
        {"inverse_error_rad", "inverse, ideal", {kInverseMap, 1.6F, Dash::dashed}},
        {"transpose_measured_rad", "transpose, measured", {kTransposeMap, 2.0F}},
        {"inverse_measured_rad", "inverse, measured", {kInverseMap, 2.0F}},
        {"rendered_error_rad", "every tick", {ImVec4(0.62F, 0.65F, 0.69F, 0.45F), 1.0F}},
        {"force_N", "force", {kForce, 2.0F}},
        {"force_outward_N", "force outward", {kForce, 2.0F, Dash::dashed}},
        {"force_up_N", "force up", {kForce, 2.0F, Dash::dotted}},
    }};
    return looks;
}

/// Told apart also by most of those who do not see red or green as others do: they differ in
/// lightness as well.
constexpr std::size_t kColourCount = 7;
const std::array<ImVec4, kColourCount> kColours{{{0.17F, 0.78F, 0.60F, 1.0F},
                                                 {0.93F, 0.78F, 0.20F, 1.0F},
                                                 {0.90F, 0.55F, 0.85F, 1.0F},
                                                 {0.86F, 0.88F, 0.90F, 1.0F},
                                                 {0.66F, 0.62F, 0.98F, 1.0F},
                                                 {0.72F, 0.64F, 0.48F, 1.0F},
                                                 {0.62F, 0.86F, 0.35F, 1.0F}}};

/// Which of three, if a channel belongs to a motor or is a component of a vector: the place of the
/// digit or letter that says so in its label.
struct Component {
    std::size_t index;
    std::string of; ///< the label without it
};

std::optional<Component> component_of(const std::string &label) {
    constexpr std::string_view kLetters = "xyz";
    for (std::size_t i = 0; i < label.size(); ++i) {
        const bool is_alone =
            i > 0 && label[i - 1] == '_' && (i + 1 == label.size() || label[i + 1] == '_');
        const std::size_t letter = kLetters.find(label[i]);
        if (is_alone && letter != std::string_view::npos) {
            return Component{letter, label.substr(0, i) + label.substr(i + 1)};
        }
        if (label[i] >= '1' && label[i] <= '3') {
            return Component{static_cast<std::size_t>(label[i] - '1'),
                             label.substr(0, i) + label.substr(i + 1)};
        }
    }
    return std::nullopt;
}

/// The same motor, or the same direction, has the same colour in all quantities, which differ in
/// their dashes; all others have the other colours.
std::vector<ChannelLook> all_looks() {
    std::vector<ChannelLook> looks;
    std::vector<std::string> vectors;
    std::size_t scalars = 0;
    constexpr std::size_t kOthers = kColourCount - 3;
    for (const session::Channel &channel : session::channels()) {
        const auto named = std::ranges::find(named_looks(), channel.name, &NamedLook::channel);
        const std::string label = without_unit(channel); // it stands at the axis
        if (named != named_looks().end()) {
            looks.push_back({std::string(named->label), named->stroke});
        } else if (const std::optional<Component> component = component_of(label)) {
            if (std::ranges::find(vectors, component->of) == vectors.end()) {
                vectors.push_back(component->of);
            }
            const auto group = std::ranges::find(vectors, component->of) - vectors.begin();
            looks.push_back(
                {label, {kColours[component->index], 1.6F, static_cast<Dash>(group % 3)}});
        } else {
            looks.push_back({label,
                             {kColours[3 + scalars % kOthers], 1.6F,
                              static_cast<Dash>(scalars / kOthers % 3)}});
            ++scalars;
        }
    }
    return looks;
}

bool is_direction_error(std::size_t channel) {
    return session::channels()[channel].name.ends_with("error_rad") ||
           session::channels()[channel].name.ends_with("measured_rad");
}

} // namespace

const ChannelLook &look_of(std::size_t channel) {
    static const std::vector<ChannelLook> looks = all_looks();
    return looks.at(channel);
}

ShownUnit shown_unit(std::size_t channel, bool in_si) {
    const session::Channel &known = session::channels()[channel];
    const std::string_view si_unit = known.unit;
    struct Unit {
        std::string_view si;
        ShownUnit shown;
    };
    static constexpr std::array<Unit, 6> kUnits{{{"rad", {"°", kDegreesPerRadian}},
                                                 {"rad/s", {"°/s", kDegreesPerRadian}},
                                                 {"m", {"mm", 1e3}},
                                                 {"m/s", {"mm/s", 1e3}},
                                                 {"J", {"mJ", 1e3}},
                                                 {"A", {"mA", 1e3}}}};
    static constexpr std::array<std::string_view, 6> kDurations{
        "since_last_s", "lateness_s", "period_s", "read_s", "compute_s", "write_s"};
    if (!in_si && std::ranges::find(kDurations, known.name) != kDurations.end()) {
        return {"µs", 1e6};
    }
    const auto *const found = std::ranges::find(kUnits, si_unit, &Unit::si);
    if (in_si || found == kUnits.end()) {
        return {si_unit == "1" ? "–" : si_unit, 1.0};
    }
    return found->shown;
}

std::optional<PlotLevel> level_of(std::size_t channel) {
    if (is_direction_error(channel)) {
        return PlotLevel{control::kNoticeable_deg / kDegreesPerRadian, "25°: limit of perception"};
    }
    return std::nullopt;
}

double min_range_of_interest(std::size_t channel) {
    constexpr double kMinError_deg = 10.0;
    if (is_direction_error(channel)) {
        return kMinError_deg / kDegreesPerRadian;
    }
    struct Least {
        std::string_view unit;
        double range;
    };
    static constexpr std::array<Least, 8> kMin{{{"N", 1.0},
                                                {"V", 0.1},
                                                {"A", 0.02},
                                                {"m", 1e-3},
                                                {"m/s", 1e-2},
                                                {"rad", 1e-3},
                                                {"rad/s", 0.1},
                                                {"J", 1e-4}}};
    const auto *const found =
        std::ranges::find(kMin, session::channels()[channel].unit, &Least::unit);
    return found == kMin.end() ? 0.0 : found->range;
}

double greatest_of_interest(std::size_t channel) {
    constexpr double kMaxError_deg = 60.0;
    return is_direction_error(channel) ? kMaxError_deg / kDegreesPerRadian
                                       : std::numeric_limits<double>::infinity();
}

} // namespace springdrive::app
