#include "engine/lab/limits/drive_comparison.h"

#include "base/bisection.h"
#include "base/input_error.h"
#include "base/parallel.h"
#include "device/core/phantom/kinematics.h"
#include "device/simulated/simulated_phantom.h"
#include "engine/control/rendered_force.h"
#include "engine/lab/limits/stability_simulation.h"
#include "engine/lab/loops/rendered_stiffness.h"
#include "engine/lab/rig/law_rig.h"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <numbers>
#include <optional>
#include <ostream>
#include <utility>
#include <vector>

namespace springdrive::limits {

namespace {

/// Here K_P is limited by stability only, not by the range of tuning files and panels.
constexpr double kNoBound_V_per_rad = 1000.0;

double stiffness_at(const loops::StabilityCase &which, double frequency_hz) {
    return std::abs(
        loops::tip_stiffness(which, Vector3::UnitY(), 2.0 * std::numbers::pi * frequency_hz));
}

/// A property of a drive.
struct Quality {
    const char *name; ///< with its unit
    const char *label;
    double in_table; ///< factor of the value in the table
    bool more_is_better;
    double (*measured)(const loops::StabilityCase &which);
};

constexpr std::array<Quality, 7> kQualities{{
    {"K_DC_N_per_m", "K_DC", 1e-3, true, // static
     [](const loops::StabilityCase &which) {
         return loops::tip_stiffness(which, Vector3::UnitY(), 0.0).real();
     }},
    {"K_30Hz_N_per_m", "at 30 Hz", 1e-3, true, // the limit of kinaesthetic perception
     [](const loops::StabilityCase &which) { return stiffness_at(which, control::kPerceived_Hz); }},
    {"K_300Hz_N_per_m", "at 300 Hz", 1e-3, true, // where vibration is perceived best
     [](const loops::StabilityCase &which) { return stiffness_at(which, 300.0); }},
    {"K_HF_N_per_m", "K_HF", 1e-3, true, // as the frequency goes to infinity: (14), or 0
     [](const loops::StabilityCase &which) {
         return loops::inductive_tip_stiffness(which, Vector3::UnitY());
     }},
    {"rate_hardness_N_per_m", "rate-hardness", 1e-3, true,
     [](const loops::StabilityCase &which) { return impact(which).rate_hardness_N_per_m; }},
    {"apparent_mass_kg", "mass", 1e3, false, apparent_mass_kg},
    {"count_N", "count", 1.0, false, loops::force_of_a_count_N},
}};

/// By which drives are equally quiet.
constexpr std::size_t kCount = kQualities.size() - 1;
static_assert(kQualities[kCount].measured == loops::force_of_a_count_N);

DriveQualities qualities(loops::StabilityCase which) {
    which.hands = {loops::hand_of_firmness(0.5)};
    DriveQualities all;
    for (const Quality &quality : kQualities) {
        all.push_back(quality.measured(which));
    }
    return all;
}

/// One drive of a comparison.
struct Drive {
    const char *name;
    DriveQualities DriveComparison::*qualities;
    TunedWall DriveComparison::*wall; ///< null for the spring drive
};

constexpr std::array<Drive, 3> kDrives{{
    {"spring", &DriveComparison::spring, nullptr},
    {"current", &DriveComparison::current, &DriveComparison::wall},
    {"current, as quiet", &DriveComparison::quiet_current, &DriveComparison::quiet_wall},
}};

bool beats_spring(const DriveComparison &all, const Drive &drive, std::size_t quality) {
    if (drive.wall == nullptr || all.spring.empty()) {
        return drive.wall != nullptr;
    }
    const double spring = all.spring[quality];
    const double other = (all.*drive.qualities)[quality];
    return kQualities[quality].more_is_better ? other > spring : other < spring;
}

/// Adds a row for each drive with a result. Where no spring drive is stable, there is no current
/// drive as quiet as it either.
/// @param add  receives the row, the comparison, the drive and its qualities
template <typename Add>
void add_rows(Table &table, const std::vector<DriveComparison> &all, const Add &add) {
    for (const DriveComparison &one : all) {
        for (const Drive &drive : kDrives) {
            const DriveQualities &found = one.*drive.qualities;
            if (!found.empty()) {
                add(table.rows.emplace_back(), one, drive, found);
            }
        }
    }
}

} // namespace

DriveComparison compare_drives(const loops::StabilityCase &which, double margin,
                               const ServoSetting &setting) {
    DriveComparison both;
    both.setting = setting;
    loops::StabilityCase here = which;
    here.period_s = 1.0 / setting.servo_hz;
    here.delay_periods = setting.delay_periods;
    here.tuning.dR_Ohm = setting.dR_Ohm;

    loops::StabilityCase spring = here;
    spring.drive = device::AmplifierKind::spring_drive;
    try {
        both.tuning = spring.tuning = auto_tune({spring, margin, false, kNoBound_V_per_rad}).tuning;
        both.spring = qualities(spring);
    } catch (const InputError &) { // no tuning is stable: a valid result
    }
    here.drive = device::AmplifierKind::current_drive;
    here.tuning.eta = 0.0;
    const auto walled = [&](const TunedWall &tuned) {
        loops::StabilityCase current = here;
        current.wall = tuned.wall;
        current.tuning.lambda_rad_per_s = tuned.lambda_rad_per_s;
        return qualities(current);
    };
    both.wall = tuned_wall(here, margin);
    both.current = walled(both.wall);
    if (!both.spring.empty()) {
        both.quiet_wall = tuned_wall(here, margin, both.spring[kCount]);
        both.quiet_current = walled(both.quiet_wall);
    }
    return both;
}

std::vector<DriveComparison> compare_drives(const loops::StabilityCase &which, double margin,
                                            const std::vector<ServoSetting> &settings,
                                            const std::function<void(double)> &progress) {
    std::vector<DriveComparison> all(settings.size());
    std::mutex progress_mutex;
    std::size_t done = 0;
    for_each_in_parallel(all.size(), all_processors(), [&](std::size_t i) {
        all[i] = compare_drives(which, margin, settings[i]);
        const std::lock_guard lock(progress_mutex);
        progress(static_cast<double>(++done) / static_cast<double>(all.size()));
    });
    return all;
}

std::vector<ServoSetting> usual_settings() {
    std::vector<ServoSetting> settings;
    for (const double servo_hz : {250.0, 1000.0, 4000.0, 10000.0}) {
        for (const double delay_periods : {0.0, 1.0}) {
            for (const double dR_Ohm : {0.2, 0.5}) {
                settings.push_back({servo_hz, delay_periods, dR_Ohm});
            }
        }
    }
    return settings;
}

Table comparison_table(const std::vector<DriveComparison> &all) {
    Table table = Table::with_columns("servo_hz,delay_periods,dR_Ohm,drive,K_P_V_per_rad,"
                                      "K_D_Vs_per_rad,wall_K_N_per_m,wall_B_Ns_per_m,"
                                      "lambda_rad_per_s");
    for (const Quality &quality : kQualities) {
        table.columns.push_back({quality.name});
    }
    add_rows(
        table, all,
        [](std::vector<Cell> &row, const DriveComparison &one, const Drive &drive,
           const DriveQualities &found) {
            row = {one.setting.servo_hz, one.setting.delay_periods, one.setting.dR_Ohm, drive.name};
            if (drive.wall == nullptr) {
                row.insert(row.end(), {one.tuning.K_P_V_per_rad, one.tuning.K_D_Vs_per_rad, Cell(),
                                       Cell(), one.tuning.lambda_rad_per_s});
            } else {
                const TunedWall &tuned = one.*drive.wall;
                row.insert(row.end(), {Cell(), Cell(), tuned.wall.stiffness_N_per_m,
                                       tuned.wall.damping_Ns_per_m, tuned.lambda_rad_per_s});
            }
            row.insert(row.end(), found.begin(), found.end());
        });
    return table;
}

void write_comparison_table(std::ostream &out, const std::vector<DriveComparison> &all) {
    out << "Along the vertical: stiffness and rate-hardness in N/mm, mass in free space in g, the "
           "force of one\nencoder count in N. \"As quiet\": one count changes its force no more "
           "than the spring drive's.\nA + marks where a current drive is better than the spring "
           "drive.\nSearched: K_P up to 1000 V/rad, more than tuning files allow, K_D up to 1 "
           "V·s/rad, λ up to 5000 rad/s,\nK up to 1e6 N/m, B from 0.1 to 300 N·s/m. The motors' "
           "peak current limits rate-hardness.\n\n";
    Table table = Table::with_columns("servo,drive");
    for (const Quality &quality : kQualities) {
        table.columns.push_back({quality.label});
    }
    add_rows(table, all,
             [](std::vector<Cell> &row, const DriveComparison &one, const Drive &drive,
                const DriveQualities &found) {
                 row = {fmt::format("{:.5g} Hz, d {:g}, dR {:.3g} Ω", one.setting.servo_hz,
                                    one.setting.delay_periods, one.setting.dR_Ohm),
                        drive.name};
                 for (std::size_t i = 0; i < kQualities.size(); ++i) {
                     row.push_back(Cell::like_number(
                         fmt::format("{:.3g}{}", kQualities[i].in_table * found[i],
                                     beats_spring(one, drive, i) ? " +" : "")));
                 }
             });
    write_markdown(out, table);
    out << "\nHow often the spring drive is the better one:\n";
    Table wins{.columns = {{""}, {kDrives[1].name}, {kDrives[2].name}}};
    for (std::size_t i = 0; i < kQualities.size(); ++i) {
        std::vector<Cell> row{kQualities[i].label};
        for (const Drive &drive : {kDrives[1], kDrives[2]}) {
            const auto better = std::ranges::count_if(all, [&](const DriveComparison &one) {
                return !one.spring.empty() && !beats_spring(one, drive, i);
            });
            row.push_back(Cell::like_number(fmt::format("{} of {}", better, all.size())));
        }
        wins.rows.push_back(std::move(row));
    }
    write_text(out, wins);
}

namespace {

constexpr double kFastest_rad_per_s = 5000.0; // as for the spring drive

/// Values spaced by a constant factor.
std::vector<double> by_ratio(double from, double to, int count) {
    std::vector<double> values;
    values.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        values.push_back(from * std::pow(to / from, static_cast<double>(i) / (count - 1)));
    }
    return values;
}

/// A loop whose plant is already discretised.
struct ReadyLoop {
    loops::StabilityCase which; ///< its freedom is used
    loops::LoopMember member;
    loops::LinearLoop loop;
};

class WallSearch {
public:
    WallSearch(const loops::StabilityCase &which, double margin, double max_count_N)
        : tried_(which), margin_(margin), max_count_N_(max_count_N) {
        for (const loops::Freedom freedom :
             {loops::Freedom::one_motor, loops::Freedom::three_motors}) {
            loops::StabilityCase each = which;
            each.freedom = freedom;
            for (const loops::LoopMember &member : loops::members(each)) {
                loops_.push_back({each, member, loops::linear_loop(each, member)});
            }
        }
        tried_.freedom = loops::Freedom::one_motor;
    }

    /// The largest K with this B and λ, if it is better than all before.
    void look_at(double B_Ns_per_m, double lambda_rad_per_s) {
        const double softest = std::max(kSoftest_N_per_m, 1.01 * best_.wall.stiffness_N_per_m);
        const auto wall = [&](double K) { return control::VirtualWall{K, B_Ns_per_m}; };
        const auto all_hold = [&](double K) {
            return holds(wall(K), lambda_rad_per_s) && rests(wall(K), lambda_rad_per_s);
        };
        if (!all_hold(softest)) {
            return;
        }
        const double loops = largest(softest, kStiffest_N_per_m, 1.001,
                                     [&](double K) { return holds(wall(K), lambda_rad_per_s); });
        const double K = rests(wall(loops), lambda_rad_per_s)
                             ? loops
                             : largest(softest, loops, 1.02, [&](double tried) {
                                   return rests(wall(tried), lambda_rad_per_s);
                               });
        best_ = {wall(K), lambda_rad_per_s};
    }

    [[nodiscard]] const TunedWall &best() const { return best_; }

private:
    static constexpr double kSoftest_N_per_m = 1.0;
    static constexpr double kStiffest_N_per_m = 1e6;

    /// The largest value that holds, between one that does and one that may not, to within a
    /// factor.
    template <typename Holds>
    static double largest(double stable, double unstable, double factor, const Holds &value_holds) {
        return bisect(
                   {stable, unstable},
                   [&](const Bracket &now) { return now.fails_at > now.holds_at * factor; },
                   value_holds,
                   [](const Bracket &now) { return std::sqrt(now.holds_at * now.fails_at); })
            .holds_at;
    }

    [[nodiscard]] bool rests(const control::VirtualWall &wall, double lambda_rad_per_s) {
        tried_.wall = wall;
        tried_.tuning.lambda_rad_per_s = lambda_rad_per_s;
        TrialOptions options = TrialOptions::with(SimulationEffects::electronics());
        options.longest_s = 1.5;
        options.extension_s = 0.0;
        return is_stable_simulated(tried_, options);
    }

    bool holds(const control::VirtualWall &wall, double lambda_rad_per_s) {
        tried_.wall = wall;
        tried_.tuning.lambda_rad_per_s = lambda_rad_per_s;
        if (loops::force_of_a_count_N(tried_) > max_count_N_) {
            return false;
        }
        for (std::size_t i = 0; i < loops_.size(); ++i) {
            if (!is_stable(loops_[i], wall, lambda_rad_per_s)) {
                // A member that fails now is likely to fail again.
                std::rotate(loops_.begin(), loops_.begin() + static_cast<std::ptrdiff_t>(i),
                            loops_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
                return false;
            }
        }
        return true;
    }

    [[nodiscard]] bool is_stable(ReadyLoop &loop, const control::VirtualWall &wall,
                                 double lambda_rad_per_s) const {
        loop.which.wall = {margin_ * wall.stiffness_N_per_m, margin_ * wall.damping_Ns_per_m};
        loop.which.tuning.lambda_rad_per_s = lambda_rad_per_s;
        return loop.loop.is_stable(loops::sampled_law(loop.which, loop.member));
    }

    loops::StabilityCase tried_;
    double margin_;
    double max_count_N_;
    std::vector<ReadyLoop> loops_;
    TunedWall best_;
};

} // namespace

TunedWall tuned_wall(loops::StabilityCase which, double margin, double max_count_N) {
    which.drive = device::AmplifierKind::current_drive;
    which.tuning.eta = 0.0;
    WallSearch search(which, margin, max_count_N);
    constexpr double kMin_Ns_per_m = 0.1;
    constexpr double kMax_Ns_per_m = 300.0;
    for (const double lambda : by_ratio(100.0, kFastest_rad_per_s, 9)) {
        for (const double B : by_ratio(kMin_Ns_per_m, kMax_Ns_per_m, 25)) {
            search.look_at(B, lambda);
        }
    }
    double factor = 1.2;
    while (factor > 1.02) { // ever finer steps
        const TunedWall centre = search.best();
        for (const double of_B : {1.0 / factor, 1.0, factor}) {
            for (const double of_lambda : {1.0 / factor, 1.0, factor}) {
                search.look_at(of_B * centre.wall.damping_Ns_per_m,
                               std::min(kFastest_rad_per_s, of_lambda * centre.lambda_rad_per_s));
            }
        }
        factor = std::sqrt(factor);
    }
    return search.best();
}

namespace {

/// Force of the motors along the vertical.
double motors_push_N(const loops::StabilityCase &which,
                     const simulated::SimulatedPhantom &phantom) {
    const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
    const device::PhantomGeometry &geometry = which.device.geometry;
    const Matrix3 J =
        device::motor_jacobian(geometry, device::joint_from_motor(geometry, truth.theta_rad));
    const Vector3 torque_Nm = control::torque_constants(which.device).cwiseProduct(truth.current_A);
    return (J.transpose().inverse() * torque_Nm).y();
}

/// A simulated device that is observed many times in each servo period.
class ObservedPlant final : public rig::Plant {
public:
    /// @param phantom  with a period of `which.period_s / steps` and no delay
    ObservedPlant(simulated::SimulatedPhantom &phantom, const loops::StabilityCase &which,
                  int steps, std::function<void()> observe)
        : phantom_(phantom), delay_periods_(which.delay_periods), steps_(steps),
          theta_rad_(phantom.truth().theta_rad), observe_(std::move(observe)) {
        commands_.fill({device::DeviceCommand::braking(), Vector3::Zero()});
    }

    void advance(const simulated::PlantCommand &command) override {
        std::shift_right(commands_.begin(), commands_.end(), 1);
        commands_.front() = command;
        for (int step = 0; step < steps_; ++step) {
            const double to_come = delay_periods_ - static_cast<double>(step) / steps_;
            const auto age = static_cast<std::size_t>(std::ceil(std::max(0.0, to_come)));
            const std::array<std::int32_t, 3> counts = phantom_.advance(commands_.at(age)).counts;
            theta_rad_ =
                phantom_.description().rad_per_count() * Vector3(counts[0], counts[1], counts[2]);
            observe_();
        }
    }

    [[nodiscard]] Vector3 theta_rad() const override { return theta_rad_; }

private:
    simulated::SimulatedPhantom &phantom_;
    double delay_periods_;
    int steps_;
    Vector3 theta_rad_;
    std::function<void()> observe_;
    /// Newest first.
    std::array<simulated::PlantCommand, simulated::SimulationOptions::kMaxDelay + 1> commands_;
};

/// The moment at which the tip reaches the wall.
struct Touchdown {
    double time_s = 0.0;
    double speed_m_per_s = 0.0;
};

/// One impact on a wall `lower_m` below the nominal end of the approach.
Impact impact_at(const loops::StabilityCase &which, double speed_m_per_s, double lower_m) {
    constexpr double kSoonest_s = 0.001;
    constexpr double kWatched_s = 0.01;
    constexpr double kStep_s = 20e-6;
    const loops::Hand hand =
        which.hands.empty() ? loops::hand_of_firmness(0.5) : which.hands.front();
    rig::Scenario scenario = rig::impact_scenario(
        setting_of(which), {simulated_hand(hand), speed_m_per_s, lower_m, which.drive});
    const int steps = std::max(1, static_cast<int>(std::lround(which.period_s / kStep_s)));
    scenario.simulation.servo_period_s = which.period_s / steps;
    scenario.simulation.delay_periods = 0.0;
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    const simulated::SimulatedPhantom::Truth &now = phantom.truth();

    Impact seen;
    std::optional<Touchdown> touchdown;
    double idle_N = 0.0; // force of the motors in free space, from the filter's lag
    const auto observe = [&] {
        const double force_N = motors_push_N(which, phantom);
        if (!touchdown) {
            const double above_m = now.tip_m.y() - scenario.contact_m.y();
            if (above_m >= 0.0) {
                idle_N = force_N;
                return;
            }
            const double speed = -now.tip_velocity_m_per_s.y();
            touchdown = {now.time_s + above_m / speed, speed};
        }
        const double since_s = now.time_s - touchdown->time_s;
        if (since_s > kWatched_s) {
            return;
        }
        const double grown_N = force_N - idle_N;
        seen.max_force_N = std::max(seen.max_force_N, grown_N);
        if (since_s >= kSoonest_s) {
            seen.rate_hardness_N_per_m = std::max(seen.rate_hardness_N_per_m,
                                                  grown_N / (since_s * touchdown->speed_m_per_s));
        }
    };
    ObservedPlant plant(phantom, which, steps, observe);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::brakes);
    while (now.time_s < (touchdown ? touchdown->time_s + kWatched_s : scenario.duration_s)) {
        loop.tick();
    }
    return seen;
}

} // namespace

Impact impact(const loops::StabilityCase &which, double speed_m_per_s) {
    constexpr int kPhases = 8;
    Impact mean;
    for (int i = 0; i < kPhases; ++i) {
        const Impact one =
            impact_at(which, speed_m_per_s, (i + 0.5) / kPhases * speed_m_per_s * which.period_s);
        mean.rate_hardness_N_per_m += one.rate_hardness_N_per_m / kPhases;
        mean.max_force_N += one.max_force_N / kPhases;
    }
    return mean;
}

double apparent_mass_kg(const loops::StabilityCase &which) {
    constexpr double kFrequency_Hz = rig::StrokeOptions::kFrequency_Hz;
    const double omega = 2.0 * std::numbers::pi * kFrequency_Hz;
    const rig::Scenario scenario = rig::stroke_scenario(setting_of(which), {which.drive});
    simulated::SimulatedPhantom phantom(scenario.device, scenario.simulation, scenario.start_m);
    rig::PhantomPlant plant(phantom);
    rig::LawRig loop(plant, law_of(which), scenario.constraint, rig::FirstCommand::brakes);
    loop.tick();
    // F = m a + b v + c along the vertical, from the components of force and motion at 5 Hz.
    double force_sine = 0.0;
    double force_cosine = 0.0;
    double tip_sine = 0.0;
    double tip_cosine = 0.0;
    while (phantom.truth().time_s < scenario.duration_s - 0.5 * which.period_s) {
        loop.tick();
        const simulated::SimulatedPhantom::Truth &truth = phantom.truth();
        if (truth.time_s >
            rig::StrokeOptions::kPeriodsBefore / kFrequency_Hz + 0.5 * which.period_s) {
            // The force is a mean over the last period, so it belongs to the period's middle.
            const double middle = omega * (truth.time_s - 0.5 * which.period_s);
            force_sine += truth.hand_force_N.y() * std::sin(middle);
            force_cosine += truth.hand_force_N.y() * std::cos(middle);
            tip_sine += truth.tip_m.y() * std::sin(omega * truth.time_s);
            tip_cosine += truth.tip_m.y() * std::cos(omega * truth.time_s);
        }
    }
    // The component of F/x in phase is −m ω².
    const double ratio = (force_sine * tip_sine + force_cosine * tip_cosine) /
                         (tip_sine * tip_sine + tip_cosine * tip_cosine);
    return -ratio / (omega * omega);
}

} // namespace springdrive::limits
