#include "app/panels/tuning_editor.h"

#include "app/host/folders.h"
#include "app/host/output.h"
#include "base/bisection.h"
#include "base/input_error.h"
#include "base/print.h"
#include "device/core/phantom/kinematics.h"
#include "engine/control/tuning.h"
#include "engine/lab/loops/passivity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fcntl.h>
#include <system_error>
#include <utility>

namespace springdrive::app {

namespace {

void add_tunings_in(const std::filesystem::path &folder, bool is_own,
                    std::vector<TuningFiles::Entry> &entries) {
    std::error_code ignored;
    std::vector<std::filesystem::path> files;
    for (const auto &entry : std::filesystem::directory_iterator(folder, ignored)) {
        if (entry.path().extension() == ".toml" && entry.is_regular_file(ignored)) {
            files.push_back(entry.path());
        }
    }
    std::ranges::sort(files);
    for (const std::filesystem::path &file : files) {
        try {
            const std::string name = file.stem().string();
            entries.push_back({file, is_own ? name : "(" + name + ")",
                               control::read_whole_tuning_file(file), is_own});
        } catch (const InputError &) {
            // Another kind of file, such as a device: not offered.
        }
    }
}

/// A file of that name in `output_dir`. @throw InputError for a name that would lead elsewhere
std::filesystem::path file_of(const std::string &name) {
    const bool is_blank = name.find_first_not_of(' ') == std::string::npos;
    if (is_blank || name.find('/') != std::string::npos || name.front() == '.') {
        throw InputError("type a name without / to save the tuning in " + output_dir_text());
    }
    return in_output_dir(name.ends_with(".toml") ? name : name + ".toml");
}

std::vector<loops::Hand> hands_of(IndicatorHand hand) {
    switch (hand) {
    case IndicatorHand::every:
        break;
    case IndicatorHand::none:
        return {loops::no_hand()};
    case IndicatorHand::light:
        return {loops::hand_of_firmness(0.0)};
    case IndicatorHand::relaxed:
        return {loops::hand_of_firmness(0.5)};
    case IndicatorHand::firm:
        return {loops::hand_of_firmness(1.0)};
    }
    return loops::hand_family();
}

/// On the way from one tuning to another; map and source of α are those of the end.
control::Tuning on_the_way(const control::Tuning &from, const control::Tuning &to, double share) {
    control::Tuning tuning = to;
    for (const control::Parameter &parameter : control::kParameters) {
        const double start = from.*parameter.value;
        tuning.*parameter.value = start + share * (to.*parameter.value - start);
    }
    return tuning;
}

/// Changes end where K_P and K_D could grow by this factor: at the limit itself nothing decays.
constexpr double kLockMargin = 1.02;

control::Tuning with_more_gain(control::Tuning tuning) {
    tuning.K_P_V_per_rad *= kLockMargin;
    tuning.K_D_Vs_per_rad *= kLockMargin;
    return tuning;
}

} // namespace

std::string preset_file(std::string_view label, double servo_hz, double delay_periods) {
    // A rate of 1000 Hz is kept as a period of 1 ms, and may return as 999.99….
    constexpr double kRoundOff = 1.0 + 1e-9;
    std::string file;
    for (const Preset &preset : kPresets) {
        const bool fits = preset.min_servo_hz == 0.0 ||
                          (servo_hz * kRoundOff >= preset.min_servo_hz && delay_periods == 0.0);
        if (preset.label == label && fits) {
            file = preset.file;
        }
    }
    return file;
}

void TuningFiles::refresh() {
    entries_.clear();
    add_tunings_in(output_dir(), true, entries_);
    add_tunings_in(asset_folder() / "tunings", false, entries_);
}

std::string TuningFiles::save(const std::string &name, const control::Tuning &tuning) {
    try {
        std::string message = save_as(file_of(name), [&tuning](std::ostream &out) {
            control::write_tuning_file(out, {tuning, "saved in the window", std::nullopt});
        });
        refresh();
        return message;
    } catch (const InputError &error) {
        return error.what();
    }
}

/// The entry is a copy, as those of the list are renewed.
std::string TuningFiles::rename(Entry entry, const std::string &name) {
    try {
        const std::filesystem::path from = std::move(entry.file);
        const std::filesystem::path to = file_of(name);
        // Not std::filesystem::rename, which replaces an existing file.
        if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) != 0) {
            const std::error_code why(errno, std::generic_category());
            throw InputError(to.string() + (why == std::errc::file_exists
                                                ? ": exists already; choose another name"
                                                : ": " + why.message()));
        }
        refresh();
        return from.filename().string() + " is now " + to.string();
    } catch (const InputError &error) {
        return error.what();
    }
}

double StabilityIndicator::time_constant_s() const {
    return period_s / std::abs(std::log(worst.eigenvalue));
}

loops::StabilityCase stability_case_of(const session::Session &session,
                                       const control::Tuning &tuning) {
    loops::StabilityCase which;
    which.device = session.description();
    which.tuning = tuning;
    which.period_s = session.servo().period_s();
    which.delay_periods = session.device().device().delay_periods();
    which.q_rad = device::joint_from_motor(which.device.geometry, session.latest().theta_rad);
    return which;
}

StabilityIndicator TuningEditor::compute_indicator(const control::Tuning &tuning) const {
    loops::StabilityCase which = stability_case_of(session_, tuning);
    which.hands = hands_of(hand);
    return {loops::worst_member(which), which.period_s, loops::passivity(which).holds()};
}

void TuningEditor::update() { indicator_ = compute_indicator(now()); }

bool TuningEditor::exceeds_gain_margin(const control::Tuning &tuning) const {
    return !compute_indicator(with_more_gain(tuning)).is_stable();
}

bool TuningEditor::is_refused(const control::Tuning &to) const {
    if (is_unlocked || to == now() || !exceeds_gain_margin(to)) {
        return false;
    }
    // Where the present tuning exceeds it already, one that is no less stable may be set.
    return !exceeds_gain_margin(now()) ||
           compute_indicator(to).worst.eigenvalue > compute_indicator(now()).worst.eigenvalue;
}

void TuningEditor::drag(const control::Tuning &to, std::uint32_t source) {
    error_.clear();
    control::Tuning reached = to;
    if (is_refused(to)) {
        constexpr int kHalvings = 14;
        const control::Tuning from = now();
        const auto may_go = [&](double share) {
            return !exceeds_gain_margin(on_the_way(from, to, share));
        };
        // The beginning has the map and the source of α of the end.
        reached = may_go(0.0) ? on_the_way(from, to, bisect({0.0, 1.0}, kHalvings, may_go).holds_at)
                              : from;
        const StabilityIndicator beyond = compute_indicator(with_more_gain(to));
        error_ = fmt::format("held at the limit: beyond it motor {}, {}, is unstable",
                             beyond.worst.member.motor + 1,
                             loops::hand_text(beyond.worst.member.hand.name));
    }
    history().change(reached, session_.plot_time_s(), source);
    update();
}

void TuningEditor::replace(const control::Tuning &to, const std::string &what) {
    history().let_go();
    if (may_go_to(to, what.c_str())) {
        history().replace(to, session_.plot_time_s(), what);
        update();
    }
}

bool TuningEditor::may_go_to(const control::Tuning &to, const char *what) {
    error_.clear();
    if (!control::is_valid(to)) {
        error_ = std::string(what) + ": not done, as it has values out of their ranges";
        return false;
    }
    if (is_refused(to)) {
        error_ = std::string(what) + ": not done, as that tuning is predicted to be unstable "
                                     "now; unlock first";
        return false;
    }
    return true;
}

void TuningEditor::undo() {
    history().let_go();
    if (history().can_undo() &&
        may_go_to(history().steps()[history().done() - 1].before.now(), "undo")) {
        history().undo(session_.plot_time_s());
        update();
    }
}

void TuningEditor::redo() {
    history().let_go();
    if (history().can_redo() &&
        may_go_to(history().steps()[history().done()].after.now(), "redo")) {
        history().redo(session_.plot_time_s());
        update();
    }
}

void TuningEditor::toggle_slot() {
    history().let_go();
    if (may_go_to(history().slots().other(), "the other slot")) {
        history().toggle(session_.plot_time_s());
        update();
    }
}

void TuningEditor::toggle_map() {
    control::Tuning other = now();
    other.map = other.map == control::MotionMap::transpose ? control::MotionMap::inverse
                                                           : control::MotionMap::transpose;
    replace(other, "map " + std::string(control::label_of(other.map)));
}

} // namespace springdrive::app
