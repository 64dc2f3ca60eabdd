#include "app/assistant/assistant.h"

#include "app/host/folders.h"
#include "base/input_error.h"
#include "base/new_file.h"
#include "base/strict_toml.h"
#include "base/text.h"

#include <algorithm>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>

namespace springdrive::app::assistant {

namespace {

bool is_stopped(const session::Session &session) {
    return session.latest().safety.state == servo::SafetyState::tripped;
}

bool is_lost(const session::Session &session) {
    return session.device_choice().kind != factory::DeviceKind::simulated &&
           session.latest().health == device::DeviceHealth::lost;
}

struct StepList {
    const char *key = "";
    StepSet Progress::*steps = nullptr;
};
constexpr std::array<StepList, 2> kStepLists{
    {{"done", &Progress::done}, {"failed", &Progress::failed}}};

constexpr auto kStepNames = [] {
    std::array<std::string_view, kSteps> names;
    std::ranges::transform(kStepTitles, names.begin(), &StepTitle::name);
    return names;
}();

StepName step_at(std::size_t index) { return static_cast<StepName>(index); }

} // namespace

std::filesystem::path progress_folder() {
    const std::filesystem::path state = user_folder("XDG_STATE_HOME", ".local/state");
    return state.empty() ? state : state / "assistant";
}

std::string progress_name(const std::string &kind, const std::string &serial) {
    constexpr std::string_view kPlain =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    std::string name;
    for (const char letter : kind + "-" + serial) {
        name += kPlain.find(letter) != std::string_view::npos
                    ? std::string(1, letter)
                    : fmt::format("%{:02x}", static_cast<unsigned char>(letter));
    }
    return name + ".toml";
}

Progress read_progress(const std::filesystem::path &file) {
    Progress progress;
    std::error_code ignored;
    if (file.empty() || !std::filesystem::exists(file, ignored)) {
        return progress;
    }
    try {
        StrictTomlTable table = StrictTomlTable::read(file);
        for (const StepList &list : kStepLists) {
            for (const std::size_t step : table.choices(list.key, kStepNames)) {
                (progress.*list.steps).set(step);
            }
        }
        table.refuse_unknown_keys();
        return progress;
    } catch (const InputError &error) {
        throw InputError(std::string(error.what()) + "; remove the file to begin anew");
    }
}

void write_progress(const std::filesystem::path &file, const Progress &progress) {
    std::error_code ignored; // without the folder, the file cannot be created, which is said
    std::filesystem::create_directories(file.parent_path(), ignored);
    write_file(
        file,
        [&](std::ostream &out) {
            for (const StepList &list : kStepLists) {
                std::vector<std::string_view> names;
                for (std::size_t i = 0; i < kSteps; ++i) {
                    if ((progress.*list.steps).test(i)) {
                        names.push_back(kStepNames[i]);
                    }
                }
                out << list.key << " = " << toml_list(names) << '\n';
            }
        },
        Existing::replace);
}

Assistant::Assistant(std::filesystem::path folder)
    : Assistant(std::move(folder), {link_step(), identity_step(), motion_step(), zero_step(),
                                    self_test_step(), calibration_step(), touch_step()}) {}

Assistant::Assistant(std::filesystem::path folder, Steps steps)
    : folder_(std::move(folder)), steps_(std::move(steps)) {}

std::filesystem::path Assistant::file() const {
    return folder_.empty() || device_.empty() ? std::filesystem::path() : folder_ / device_;
}

/// Of each device, what it has come through is its own.
void Assistant::watch_device(session::Session &session) {
    std::string device;
    if (session.device_choice().kind != factory::DeviceKind::simulated) {
        const device::DeviceIdentity identity = session.device().identity();
        device = progress_name(identity.kind, identity.serial);
    }
    if (device == device_) {
        return;
    }
    device_ = device;
    progress_ = {};
    error_ = error_text_of([this] { progress_ = read_progress(file()); });
    is_device_new_ = !device.empty();
    if (is_open()) {
        enter(session, StepName::link);
    } else {
        hold_back_or_not(session);
    }
}

/// What was known of the zero is void with it. Of a device that is lost it is known only once it is
/// there again.
void Assistant::watch_zero(const session::Session &session) {
    if (!is_lost(session) && !session.is_zeroed() &&
        progress_.done.test(index_of(StepName::zeroing))) {
        void_from(index_of(StepName::zeroing));
    }
}

void Assistant::update(session::Session &session) {
    watch_device(session);
    if (std::exchange(is_device_new_, false) && opens_itself && !is_open() && !is_complete()) {
        open(session);
    }
    if (!is_open()) {
        return;
    }
    watch_zero(session);
    step_->update();
    note_verdict();
}

/// A step that failed stays so until it has succeeded.
void Assistant::note_verdict() {
    const StepReport report = step_->report();
    const std::size_t at = index_of(present_);
    if (report.voids_later) {
        void_from(at + 1);
    }
    const Progress before = progress_;
    if (report.verdict == Verdict::bad) {
        void_from(at);
        progress_.failed.set(at);
    } else if (report.verdict != Verdict::open) {
        progress_.failed.reset(at);
    }
    keep(before);
}

void Assistant::set_done(StepName name) {
    const Progress before = progress_;
    progress_.done.set(index_of(name));
    keep(before);
}

/// Nothing is done from this step on.
void Assistant::void_from(std::size_t step) {
    const Progress before = progress_;
    for (std::size_t i = step; i < kSteps; ++i) {
        progress_.done.reset(i);
    }
    keep(before);
}

void Assistant::keep(const Progress &before) {
    if (progress_ != before && !file().empty()) {
        error_ = error_text_of([this] { write_progress(file(), progress_); });
    }
}

/// While it is closed.
void Assistant::hold_back_or_not(session::Session &session) {
    holds_back_.clear();
    for (std::size_t i = 0; i < kSteps && holds_back_.empty(); ++i) {
        if (progress_.failed.test(i)) {
            holds_back_ = kStepTitles[i].title;
        }
    }
    session.keep_released(!holds_back_.empty());
}

StepName Assistant::first_not_done() const {
    for (std::size_t i = 0; i < kSteps; ++i) {
        if (!progress_.done.test(i)) {
            return step_at(i);
        }
    }
    return StepName::link;
}

void Assistant::enter(session::Session &session, StepName to) {
    if (step_) {
        step_->end();
    }
    present_ = to;
    session.keep_released(true);
    step_ = steps_[index_of(to)](session);
    step_->update();
}

void Assistant::open(session::Session &session) {
    watch_device(session);
    is_device_new_ = false;
    watch_zero(session);
    holds_back_.clear();
    session.servo().set_speed(1.0); // steps wait for the device
    enter(session, first_not_done());
}

bool Assistant::can_go_on(const session::Session &session) const {
    if (is_stopped(session) || is_lost(session) || session.is_in_exclusive_use() ||
        session.is_exchanging()) {
        return false;
    }
    switch (step_->report().verdict) {
    case Verdict::good:
    case Verdict::skipped:
        return true;
    case Verdict::open:
        return progress_.done.test(index_of(present_));
    case Verdict::doubtful:
    case Verdict::bad:
        break;
    }
    return false;
}

void Assistant::next(session::Session &session) {
    if (!is_open() || !can_go_on(session)) {
        return;
    }
    const std::size_t at = index_of(present_);
    set_done(present_);
    if (at + 1 < kSteps) {
        enter(session, step_at(at + 1));
    } else {
        leave(session);
    }
}

void Assistant::continue_all_the_same(session::Session &session) {
    if (!is_open() || is_stopped(session) || is_lost(session) ||
        step_->report().verdict != Verdict::doubtful) {
        return;
    }
    set_done(present_);
    enter(session, step_at(index_of(present_) + 1));
}

void Assistant::back(session::Session &session) {
    if (is_open() && index_of(present_) > 0) {
        enter(session, step_at(index_of(present_) - 1));
    }
}

void Assistant::again(session::Session &session) {
    if (!is_open()) {
        return;
    }
    if (is_stopped(session) && !servo::is_final(session.latest().safety.cause)) {
        session.servo().let_go_on();
    }
    enter(session, present_);
}

bool Assistant::can_go_to(StepName to) const {
    return progress_.done.test(index_of(to)) || to == present_ || to == first_not_done();
}

void Assistant::go_to(session::Session &session, StepName to) {
    if (is_open() && to != present_ && can_go_to(to)) {
        enter(session, to);
    }
}

void Assistant::leave(session::Session &session) {
    if (!is_open()) {
        return;
    }
    step_->end();
    step_.reset();
    hold_back_or_not(session);
}

StepState Assistant::state(StepName of) const {
    return is_open() && of == present_           ? StepState::present
           : progress_.failed.test(index_of(of)) ? StepState::failed
           : progress_.done.test(index_of(of))   ? StepState::done
                                                 : StepState::open;
}

StepReport Assistant::report(const session::Session &session) const {
    StepReport report = step_->report();
    if (is_lost(session)) {
        report.troubles.push_back(
            {"the device is lost: no answer from its board",
             "plug it in again; it is connected by itself, then press Again"});
    } else if (is_stopped(session)) {
        const servo::SafetyStatus &stop = session.latest().safety;
        report.troubles.push_back(
            {"stopped: " + servo::description(stop),
             remedy_of(stop) +
                 (servo::is_final(stop.cause) ? "" : "; then press Again, which resets the stop")});
    }
    if (is_lost(session) || is_stopped(session)) {
        report.to_do = "Do what is named below.";
        report.offers.clear();
        if (report.verdict == Verdict::good) {
            report.verdict = Verdict::open;
        }
    }
    const bool needs_zero = present_ > StepName::zeroing && !is_lost(session);
    if (needs_zero && !session.is_zeroed()) {
        report.troubles.push_back({"the device is not zeroed", "go back to Zeroing"});
    }
    return report;
}

std::optional<Vector3> Assistant::theta_rad() const {
    return is_open() ? step_->report().theta_rad : std::nullopt;
}

} // namespace springdrive::app::assistant
