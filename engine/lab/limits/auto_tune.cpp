#include "engine/lab/limits/auto_tune.h"

#include "base/bisection.h"
#include "base/input_error.h"
#include "engine/control/coupling.h"
#include "engine/control/tuning.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/passivity.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace springdrive::limits {

namespace {

constexpr double kMaxMargin = 10.0;

/// A pair of K_D and λ, each as a fraction of its range: λ on a logarithmic scale, K_D by its cube
/// root, to resolve small values.
struct Place {
    double K_D = 0.0;
    double lambda = 0.0;

    [[nodiscard]] loops::Gains gains(double K_P) const {
        const control::Parameter &of_K_D = control::parameter_of(&control::Tuning::K_D_Vs_per_rad);
        const control::Parameter &of_lambda =
            control::parameter_of(&control::Tuning::lambda_rad_per_s);
        return {K_P, of_K_D.minimum + K_D * K_D * K_D * (of_K_D.maximum - of_K_D.minimum),
                of_lambda.minimum * std::pow(of_lambda.maximum / of_lambda.minimum, lambda)};
    }
};

constexpr int kGrid = 17;                        // points along K_D, and along λ
constexpr double kFirstStep = 0.5 / (kGrid - 1); // between them

/// Searches ever smaller grids around the best place so far, which `best` returns.
template <typename Look, typename Best>
void refine_grid(double step, const Look &look_at, const Best &best) {
    constexpr int kAround = 2; // to each side
    constexpr int kRounds = 7;
    for (int round = 0; round < kRounds; ++round, step *= 0.5) {
        const Place centre = best();
        for (int i = -kAround; i <= kAround; ++i) {
            for (int j = -kAround; j <= kAround; ++j) {
                look_at(Place{std::clamp(centre.K_D + i * step, 0.0, 1.0),
                              std::clamp(centre.lambda + j * step, 0.0, 1.0)});
            }
        }
    }
}

/// Finds the largest K_P of each place, by the loops found critical so far.
class Search {
public:
    Search(loops::TuningConstraints &loops, const AutoTuneRequest &request)
        : loops_(loops), margin_(request.margin), max_K_P_(request.max_K_P_V_per_rad),
          passive_(request.is_passive ? std::optional(request.which) : std::nullopt) {}

    struct Best {
        Place place;
        double K_P = -1.0; ///< negative: unstable even without K_P
    };

    /// Tries a place, and keeps it if it is better than all before.
    void look_at(const Place &place) {
        if (best_.K_P > 0.0 && !holds(place, best_.K_P)) {
            return; // less stiff than the best: most places
        }
        double K_P = largest(place);
        while (K_P >= 0.0 && is_better(place, K_P)) {
            const std::size_t failed = loops_.first_unstable(with_margin(place, K_P));
            if (failed == loops_.count()) {
                // A loop may be stable with larger gains but not with these.
                if (loops_.first_unstable(place.gains(K_P)) == loops_.count()) {
                    best_ = {place, K_P};
                }
                return;
            }
            critical_.push_back(failed);
            K_P = largest(place);
        }
    }

    [[nodiscard]] const Best &best() const { return best_; }

    /// Whether every loop is stable there, with the margin and without, and passive if it must be.
    [[nodiscard]] bool all_stable(const Place &place, double K_P) {
        return is_passive(place, K_P) &&
               loops_.first_unstable(with_margin(place, K_P)) == loops_.count() &&
               loops_.first_unstable(place.gains(K_P)) == loops_.count();
    }

    /// For a K_P below the best, the place near the best at which the slowest of the critical modes
    /// decays fastest: there, vibration excited by encoder counts decays soonest.
    [[nodiscard]] Place max_damped(double K_P) const {
        Place max_damped = best_.place;
        double minimum = slowest(max_damped, K_P);
        refine_grid(
            kFirstStep,
            [&](const Place &place) {
                const double eigenvalue = slowest(place, K_P);
                if (eigenvalue < minimum) {
                    max_damped = place;
                    minimum = eigenvalue;
                }
            },
            [&] { return max_damped; });
        return max_damped;
    }

private:
    /// Stiffer is better; among equally stiff ones at the end of K_P's range, the one whose slowest
    /// critical mode decays faster.
    [[nodiscard]] bool is_better(const Place &place, double K_P) const {
        return K_P > best_.K_P ||
               (K_P == best_.K_P && slowest(place, K_P) < slowest(best_.place, K_P));
    }

    [[nodiscard]] double slowest(const Place &place, double K_P) const {
        double eigenvalue = 0.0;
        for (const std::size_t loop : critical_) {
            eigenvalue =
                std::max(eigenvalue, loops_.largest_eigenvalue(loop, with_margin(place, K_P)));
        }
        return eigenvalue;
    }

    [[nodiscard]] loops::Gains with_margin(const Place &place, double K_P) const {
        loops::Gains gains = place.gains(K_P);
        gains.K_P_V_per_rad *= margin_;
        gains.K_D_Vs_per_rad *= margin_;
        return gains;
    }

    /// For the critical loops only.
    [[nodiscard]] bool holds(const Place &place, double K_P) const {
        return loops_.are_stable(critical_, with_margin(place, K_P)) && is_passive(place, K_P);
    }

    /// Whether it is, with kPassiveMargin, if it must be. The gains that are make a convex set,
    /// with no gains in it: so with larger ones this implies it with these.
    [[nodiscard]] bool is_passive(const Place &place, double K_P) const {
        if (!passive_) {
            return true;
        }
        loops::StabilityCase which = *passive_;
        const loops::Gains gains = place.gains(K_P);
        which.tuning.K_P_V_per_rad = kPassiveMargin * gains.K_P_V_per_rad;
        which.tuning.K_D_Vs_per_rad = kPassiveMargin * gains.K_D_Vs_per_rad;
        which.tuning.lambda_rad_per_s = gains.lambda_rad_per_s;
        return loops::passivity(which).holds();
    }

    /// For the critical loops only.
    [[nodiscard]] double largest(const Place &place) const {
        const auto holds_here = [&](double K_P) { return holds(place, K_P); };
        if (holds_here(max_K_P_)) {
            return max_K_P_;
        }
        return holds_here(0.0) ? last_that_holds({0.0, max_K_P_}, 1e-4, holds_here) : -1.0;
    }

    loops::TuningConstraints &loops_;
    double margin_;
    double max_K_P_;
    std::optional<loops::StabilityCase> passive_; ///< of which it must be, if it must
    /// Loops found to limit K_P; the first is a likely one.
    std::vector<std::size_t> critical_{0};
    Best best_;
};

using Progress = std::function<bool(double)>;

constexpr double kShareOfGrid = 0.6;   // of the time
constexpr double kShareOfSearch = 0.8; // grid and refinement

void report_progress(const Progress &progress, double share) {
    if (!progress(share)) {
        throw InputError("tuning was cancelled");
    }
}

/// A grid over all pairs, then ever smaller grids around the best so far.
void search(Search &places, const Progress &progress) {
    for (int i = 0; i < kGrid; ++i) {
        for (int j = 0; j < kGrid; ++j) {
            places.look_at(
                {static_cast<double>(i) / (kGrid - 1), static_cast<double>(j) / (kGrid - 1)});
            report_progress(progress, kShareOfGrid * (i * kGrid + j + 1) / (kGrid * kGrid));
        }
    }
    refine_grid(
        kFirstStep, [&](const Place &place) { places.look_at(place); },
        [&] {
            report_progress(progress, kShareOfGrid);
            return places.best().place;
        });
}

loops::Gains scaled(const control::Tuning &tuning, double factor) {
    return {factor * tuning.K_P_V_per_rad, factor * tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s};
}

loops::StabilityCase tuned(const loops::StabilityCase &which, const control::Tuning &tuning) {
    loops::StabilityCase same = which;
    same.tuning = tuning;
    return same;
}

bool all_stable(const loops::StabilityCase &which) {
    loops::TuningConstraints loops(which);
    return loops.first_unstable(loops::gains_of(which.tuning)) == loops.count();
}

void find_gain_margin(control::TuningMargins &margins, loops::TuningConstraints &loops,
                      const control::Tuning &tuning) {
    constexpr double kMaxGain = 100.0;
    std::size_t worst = 0;
    const auto holds = [&](double gain) {
        const std::size_t failed = loops.first_unstable(scaled(tuning, gain));
        worst = failed == loops.count() ? worst : failed;
        return failed == loops.count();
    };
    if (holds(kMaxGain)) {
        margins.gain = kMaxGain;
        return;
    }
    const auto is_wide = [](const Bracket &gains) { return gains.width() > 1e-3 * gains.holds_at; };
    margins.gain = bisect({1.0, kMaxGain}, is_wide, holds).holds_at;
    margins.worst_hand = loops[worst].hand;
    margins.worst_eta = loops[worst].eta;
}

double gain_with_structure(loops::StabilityCase which) {
    which.structures = loops::all_structures();
    const control::Tuning tuning = which.tuning;
    const auto holds = [&](double gain) {
        which.tuning.K_P_V_per_rad = gain * tuning.K_P_V_per_rad;
        which.tuning.K_D_Vs_per_rad = gain * tuning.K_D_Vs_per_rad;
        which.freedom = loops::Freedom::one_motor;
        const bool is_stable = loops::is_stable(which);
        which.freedom = loops::Freedom::three_motors;
        return is_stable && (which.rotor || loops::is_stable(which));
    };
    const auto is_wide = [](const Bracket &gains) { return gains.width() > 1e-3 * gains.fails_at; };
    constexpr double kMaxGain = 100.0;
    return holds(kMaxGain) ? kMaxGain : bisect({0.0, kMaxGain}, is_wide, holds).holds_at;
}

control::TuningMargins margins_of(loops::TuningConstraints &loops,
                                  const loops::StabilityCase &which) {
    control::TuningMargins margins;
    margins.servo_hz = 1.0 / which.period_s;
    margins.delay_periods = which.delay_periods;
    margins.K_DC_Nm_per_rad = device::static_stiffness_Nm_per_rad(
        which.device.motor[0], which.tuning.K_P_V_per_rad, which.tuning.dR_Ohm);
    find_gain_margin(margins, loops, which.tuning);

    loops::StabilityCase later = which;
    constexpr int kMaxAddedDelay = 8;
    for (; margins.more_delay_periods < kMaxAddedDelay; ++margins.more_delay_periods) {
        ++later.delay_periods;
        if (!all_stable(later)) {
            break;
        }
    }
    const double dR_Ohm = which.dR_Ohm(which.device.motor[0]);
    margins.min_dR_Ohm =
        bisect(
            {dR_Ohm, 0.0}, [&](const Bracket &now) { return now.width() > 1e-2 * dR_Ohm; },
            [&](double min_Ohm) {
                loops::StabilityCase cooler = which;
                cooler.net_resistance_Ohm = min_Ohm;
                return all_stable(cooler);
            })
            .holds_at;
    return margins;
}

/// Whether trials come to rest, of each motor alone and of the linkage at its configuration.
bool rests(loops::StabilityCase which) {
    const TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    which.freedom = loops::Freedom::one_motor;
    if (!is_stable_simulated(which, options)) {
        return false;
    }
    which.freedom = loops::Freedom::three_motors;
    return which.rotor || is_stable_simulated(which, options);
}

control::Tuning with_gains(control::Tuning tuning, const loops::Gains &gains) {
    tuning.K_P_V_per_rad = gains.K_P_V_per_rad;
    tuning.K_D_Vs_per_rad = gains.K_D_Vs_per_rad;
    tuning.lambda_rad_per_s = gains.lambda_rad_per_s;
    tuning.eta = 0.0;
    return tuning;
}

/// Places near one, clamped to the ranges.
std::vector<Place> beside(const Place &place) {
    constexpr double kStep = 0.1;
    std::vector<Place> all;
    for (const double K_D : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
        for (const double lambda : {-4.0, -2.0, 0.0}) {
            all.push_back({std::clamp(place.K_D + kStep * K_D, 0.0, 1.0),
                           std::clamp(place.lambda + kStep * lambda, 0.0, 1.0)});
        }
    }
    return all;
}

/// The stiffest tuning at which trials come to rest: K_P is lowered in steps of one per cent until
/// they do, at the best or the calmest place. Where more than ten per cent are needed, the linear
/// loops are not the limit, and places near the calmest are tried as well. Writes the tuning and
/// returns the share by which K_P was reduced.
/// @throw InputError where no tuning does
double take_back(Search &places, const loops::StabilityCase &which, control::Tuning &tuning,
                 const Progress &progress) {
    constexpr double kFew = 0.9;
    constexpr double kMinimum = 0.05;
    double share = 1.0;
    const auto holds = [&](const Place &place) {
        const double K_P = share * places.best().K_P;
        tuning = with_gains(which.tuning, place.gains(K_P));
        return rests(tuned(which, tuning)) && places.all_stable(place, K_P);
    };
    while (share > kMinimum) {
        report_progress(progress, kShareOfSearch + (1.0 - kShareOfSearch) * (1.0 - share));
        if (holds(places.best().place)) {
            return 1.0 - share;
        }
        const Place max_damped = places.max_damped(share * places.best().K_P);
        const std::vector<Place> others =
            share > kFew ? std::vector<Place>{max_damped} : beside(max_damped);
        if (std::any_of(others.begin(), others.end(), holds)) {
            return 1.0 - share;
        }
        share *= share > kFew ? 0.99 : 0.98;
    }
    throw InputError(
        "no tuning comes to rest with the resolution of these encoders; raise dR, or lower "
        "the delay");
}

} // namespace

AutoTuned auto_tune(const AutoTuneRequest &request, const Progress &progress) {
    if (!(request.margin >= 1.0 && request.margin <= kMaxMargin)) {
        throw InputError("the margin must be from 1 to 10: the factor by which the gains could be "
                         "raised before a loop becomes unstable");
    }
    loops::TuningConstraints loops(request.which);
    Search places(loops, request);
    search(places, progress);
    if (places.best().K_P <= 0.0) {
        throw InputError(std::string("no tuning is ") +
                         (request.is_passive ? "passive" : "stable") +
                         " with this servo rate, delay, dR and margin; raise dR or the servo rate, "
                         "or lower the delay or the margin");
    }
    AutoTuned found;
    found.taken_back = take_back(places, request.which, found.tuning, progress);
    const loops::StabilityCase best = tuned(request.which, found.tuning);
    found.margins = margins_of(loops, best);
    found.loops = loops.count();
    found.gain_with_structure = gain_with_structure(best);
    found.coupling =
        loops::port_text(loops::passivity(best), loops::stability_with_linear_hands(best));
    progress(1.0);
    return found;
}

} // namespace springdrive::limits
