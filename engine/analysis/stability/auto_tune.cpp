#include "engine/analysis/stability/auto_tune.h"

#include "base/input_error.h"
#include "engine/analysis/stability/stability_simulation.h"
#include "engine/control/coupling.h"
#include "engine/control/parameters.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace springdrive {

namespace {

constexpr double kGreatestMargin = 10.0;

const Parameter &parameter(double Tuning::*value) {
    return *std::find_if(kParameters.begin(), kParameters.end(),
                         [value](const Parameter &each) { return each.value == value; });
}

/// A pair of K_D and λ, each as a share of the way through its range: λ by its logarithm, K_D by
/// its square root, so that small ones are told apart.
struct Place {
    double K_D = 0.0;
    double lambda = 0.0;

    [[nodiscard]] LoopGains gains(double K_P) const {
        const Parameter &of_K_D = parameter(&Tuning::K_D_Vs_per_rad);
        const Parameter &of_lambda = parameter(&Tuning::lambda_rad_per_s);
        return {K_P, of_K_D.lowest + K_D * K_D * (of_K_D.highest - of_K_D.lowest),
                of_lambda.lowest * std::pow(of_lambda.highest / of_lambda.lowest, lambda)};
    }
};

/// The largest K_P of each place, for loops that grow as failures are found.
class Search {
public:
    Search(HeldLoops &loops, const AutoTuneRequest &request)
        : loops_(loops), margin_(request.margin), greatest_K_P_(request.greatest_K_P_V_per_rad) {}

    struct Best {
        Place place;
        double K_P = -1.0; ///< negative: not even without K_P
    };

    /// Tries a place, and keeps it where it is better than all before.
    void look_at(const Place &place) {
        if (best_.K_P > 0.0 && !loops_.are_stable(critical_, with_margin(place, best_.K_P))) {
            return; // not even as stiff as the best: most places
        }
        double K_P = largest(place);
        while (K_P >= 0.0 && is_better(place, K_P)) {
            const std::size_t failed = loops_.first_unstable(with_margin(place, K_P));
            if (failed == loops_.count()) {
                // A loop may be stable with larger gains and not with these.
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

private:
    /// Stiffer counts; of the equally stiff, which the range of K_P leaves, the one whose slowest
    /// critical motion dies out sooner.
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

    [[nodiscard]] LoopGains with_margin(const Place &place, double K_P) const {
        LoopGains gains = place.gains(K_P);
        gains.K_P_V_per_rad *= margin_;
        gains.K_D_Vs_per_rad *= margin_;
        return gains;
    }

    /// For the critical loops alone.
    [[nodiscard]] double largest(const Place &place) const {
        const auto holds = [&](double K_P) {
            return loops_.are_stable(critical_, with_margin(place, K_P));
        };
        if (holds(greatest_K_P_)) {
            return greatest_K_P_;
        }
        double stable = 0.0;
        double unstable = greatest_K_P_;
        if (!holds(stable)) {
            return -1.0;
        }
        while (unstable - stable > 1e-4 * unstable) {
            const double middle = 0.5 * (stable + unstable);
            (holds(middle) ? stable : unstable) = middle;
        }
        return stable;
    }

    HeldLoops &loops_;
    double margin_;
    double greatest_K_P_;
    /// Loops that were found to limit K_P; the first is likely to.
    std::vector<std::size_t> critical_{0};
    Best best_;
};

/// A grid over all pairs, then smaller and smaller grids about the best so far.
void search(Search &search, const std::function<bool(double)> &progress) {
    constexpr int kGrid = 17;
    constexpr int kAround = 2; // to each side
    constexpr int kRounds = 7;
    const auto tell = [&](double share) {
        if (!progress(share)) {
            throw InputError("tuning was given up");
        }
    };
    for (int i = 0; i < kGrid; ++i) {
        for (int j = 0; j < kGrid; ++j) {
            search.look_at(
                {static_cast<double>(i) / (kGrid - 1), static_cast<double>(j) / (kGrid - 1)});
        }
        tell(0.6 * (i + 1) / kGrid);
    }
    double step = 0.5 / (kGrid - 1);
    for (int round = 0; round < kRounds; ++round, step *= 0.5) {
        const Place centre = search.best().place;
        for (int i = -kAround; i <= kAround; ++i) {
            for (int j = -kAround; j <= kAround; ++j) {
                search.look_at({std::clamp(centre.K_D + i * step, 0.0, 1.0),
                                std::clamp(centre.lambda + j * step, 0.0, 1.0)});
            }
        }
        tell(0.6 + 0.3 * (round + 1) / kRounds);
    }
}

LoopGains scaled(const Tuning &tuning, double factor) {
    return {factor * tuning.K_P_V_per_rad, factor * tuning.K_D_Vs_per_rad, tuning.lambda_rad_per_s};
}

StabilityCase tuned(const StabilityCase &which, const Tuning &tuning) {
    StabilityCase same = which;
    same.tuning = tuning;
    return same;
}

bool all_stable(const StabilityCase &which) {
    HeldLoops loops(which);
    return loops.first_unstable(scaled(which.tuning, 1.0)) == loops.count();
}

void find_gain_margin(TuningMargins &margins, HeldLoops &loops, const Tuning &tuning) {
    double stable = 1.0;
    double unstable = 100.0;
    std::size_t worst = loops.first_unstable(scaled(tuning, unstable));
    if (worst == loops.count()) {
        margins.gain = unstable;
        return;
    }
    while (unstable - stable > 1e-3 * stable) {
        const double middle = 0.5 * (stable + unstable);
        const std::size_t failed = loops.first_unstable(scaled(tuning, middle));
        (failed == loops.count() ? stable : unstable) = middle;
        worst = failed == loops.count() ? worst : failed;
    }
    margins.gain = stable;
    margins.worst_hand = loops[worst].hand;
    margins.worst_eta = loops[worst].eta;
}

TuningMargins margins_of(HeldLoops &loops, const StabilityCase &which) {
    TuningMargins margins;
    margins.servo_hz = 1.0 / which.period_s;
    margins.delay_samples = which.delay_samples;
    margins.K_DC_Nm_per_rad =
        coupling(which.device.motor[0], which.tuning, which.period_s, which.delay_samples)
            .K_DC_Nm_per_rad;
    find_gain_margin(margins, loops, which.tuning);

    StabilityCase later = which;
    constexpr int kMostMoreDelay = 8;
    for (; margins.more_delay_samples < kMostMoreDelay; ++margins.more_delay_samples) {
        ++later.delay_samples;
        if (!all_stable(later)) {
            break;
        }
    }
    const double dR_Ohm = which.dR_Ohm(which.device.motor[0]);
    double unstable = 0.0;
    margins.least_dR_Ohm = dR_Ohm;
    while (margins.least_dR_Ohm - unstable > 1e-2 * dR_Ohm) {
        StabilityCase cooler = which;
        cooler.net_resistance_Ohm = 0.5 * (margins.least_dR_Ohm + unstable);
        (all_stable(cooler) ? margins.least_dR_Ohm : unstable) = *cooler.net_resistance_Ohm;
    }
    return margins;
}

/// Whether trials come to rest, of each motor by itself and of the linkage where it stands.
bool rests(StabilityCase which) {
    const TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
    which.freedom = Freedom::one_motor;
    if (!is_stable_simulated(which, options)) {
        return false;
    }
    which.freedom = Freedom::three_motors;
    return which.rotor || is_stable_simulated(which, options);
}

/// Lowers K_P by twentieths until trials come to rest. Returns by which share. @throw InputError
/// where none does.
double take_back(StabilityCase which, Tuning &tuning) {
    constexpr int kTwentieths = 20;
    const double found = tuning.K_P_V_per_rad;
    for (int less = 0; less < kTwentieths; ++less) {
        const double share = static_cast<double>(less) / kTwentieths;
        tuning.K_P_V_per_rad = which.tuning.K_P_V_per_rad = (1.0 - share) * found;
        if (rests(which)) {
            return share;
        }
    }
    throw InputError(
        "no tuning comes to rest with the counts of these encoders; raise dR, or lower "
        "the delay");
}

} // namespace

AutoTuned auto_tune(const AutoTuneRequest &request, const std::function<bool(double)> &progress) {
    if (!(request.margin >= 1.0 && request.margin <= kGreatestMargin)) {
        throw InputError("the margin must be from 1 to 10: the factor by which the gains might "
                         "be larger yet");
    }
    HeldLoops loops(request.which);
    Search places(loops, request);
    search(places, progress);
    const Search::Best &best = places.best();
    if (best.K_P <= 0.0) {
        throw InputError("no tuning is stable with this servo rate, delay, dR and margin; raise "
                         "dR or the servo rate, or lower the delay or the margin");
    }
    AutoTuned found;
    found.tuning = request.which.tuning;
    const LoopGains gains = best.place.gains(best.K_P);
    found.tuning.K_P_V_per_rad = gains.K_P_V_per_rad;
    found.tuning.K_D_Vs_per_rad = gains.K_D_Vs_per_rad;
    found.tuning.lambda_rad_per_s = gains.lambda_rad_per_s;
    found.tuning.eta = 0.0;
    found.taken_back = take_back(tuned(request.which, found.tuning), found.tuning);
    found.margins = margins_of(loops, tuned(request.which, found.tuning));
    found.loops = loops.count();
    progress(1.0);
    return found;
}

} // namespace springdrive
