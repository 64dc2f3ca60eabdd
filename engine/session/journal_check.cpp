#include "engine/session/journal_check.h"

#include "base/print.h"
#include "device/core/haptic_device.h"
#include "engine/servo/bumpless_transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <span>
#include <utility>

namespace springdrive::session {

namespace {

/// After this, a tuning that another one has replaced can no longer be active: far longer than
/// any frame of the window.
constexpr double kLatest_s = 1.0;

/// If the servo was held up during a frame, what a control set meanwhile has no time of its own.
constexpr double kHeldUp_s = 0.1;

/// Of a tuning on its way to another, as a share of the parameter's range.
constexpr double kRounding = 1e-7;

/// Exact where it has arrived.
bool is_near(const control::Tuning &tuning, const control::Tuning &expected,
             const control::Tuning &wanted) {
    return std::ranges::all_of(control::kParameters, [&](const control::Parameter &parameter) {
        const double reached = expected.*parameter.value;
        const double error = std::abs(tuning.*parameter.value - reached);
        const bool has_arrived = reached == wanted.*parameter.value;
        return error <= (has_arrived ? 0.0 : kRounding * (parameter.maximum - parameter.minimum));
    });
}

} // namespace

JournalCheck::JournalCheck(const RunFacts &run, double start_s, device::DeviceDescription device)
    : journal_(run.journal), until_s_(run.until_s), start_s_(start_s), device_(std::move(device)) {
    if (journal_.empty()) {
        return;
    }
    constexpr double kAlways_s = -std::numeric_limits<double>::infinity();
    TuningEvent &first = journal_.front();
    first.began_s = kAlways_s;
    if (first.what == "start") { // otherwise, what was active before is unknown
        first.time_s = kAlways_s;
    }
}

void JournalCheck::take(const servo::ServoSample &sample) {
    const bool follows = before_ && before_->tick + 1 == sample.tick;
    const Tick before = before_.value_or(Tick{});
    before_ = Tick{sample.tick, sample.time_s, sample.tuning};
    const double now_s = start_s_ + sample.time_s;
    if (!follows || journal_.empty() || now_s > until_s_ || servo::is_final(sample.safety.cause)) {
        ++unchecked_;
        return;
    }
    const bool has_inputs =
        device::has_news(sample.arrival) && sample.health != device::DeviceHealth::lost;
    if (has_inputs ? follows_journal(before, now_s) : sample.tuning == before.tuning) {
        ++agreeing_;
    } else if (has_inputs && is_moved(now_s)) {
        ++moved_;
    } else if (differing_++ == 0) {
        first_differing_ = sample.tick;
    }
}

void JournalCheck::print_to(std::ostream &out) const {
    if (is_fine()) {
        print(out, "  tuning                 as in tuning_history.csv in {} ticks", agreeing_);
    } else {
        print(out,
              "  tuning                 differs from tuning_history.csv in {} ticks, first in "
              "{}; as there in {}",
              differing_, first_differing_, agreeing_);
    }
    if (moved_ > 0) {
        print(out, "; moved in {}", moved_);
    }
    if (longest_delay_s_ > 0.0) {
        print(out, "; up to {:.0f} ms after a change", 1e3 * longest_delay_s_);
    }
    print(out, "; {} not compared\n", unchecked_);
}

/// Whether the latest tuning is what the servo makes of the previous tuning on its way to a
/// tuning of the journal that can be wanted now. The earliest one counts: it leaves the most
/// for later.
bool JournalCheck::follows_journal(const Tick &before, double now_s) {
    while (begun_ < journal_.size() && journal_[begun_].time_s < now_s) {
        ++begun_;
    }
    while (reached_ + 1 < begun_ && journal_[reached_ + 1].time_s + kLatest_s < now_s) {
        ++reached_;
    }
    for (std::size_t i = reached_; i < begun_; ++i) {
        const TuningEvent &event = journal_[i];
        if (is_on_the_way(before, event.tuning)) {
            if (i != reached_ && event.tuning != journal_[reached_].tuning) {
                longest_delay_s_ = std::max(longest_delay_s_, now_s - event.time_s);
            }
            reached_ = i;
            return true;
        }
    }
    return false;
}

/// Whether a control may be setting any tuning now.
bool JournalCheck::is_moved(double now_s) const {
    const std::size_t end = std::min(begun_ + 1, journal_.size());
    const std::span events = std::span(journal_).subspan(reached_, end - reached_);
    return std::ranges::any_of(events, [now_s](const TuningEvent &event) {
        const bool was_moved = event.began_s < event.time_s;
        return event.began_s < now_s && now_s <= event.time_s + (was_moved ? kLatest_s : kHeldUp_s);
    });
}

bool JournalCheck::is_on_the_way(const Tick &before, const control::Tuning &wanted) const {
    const Tick &now = *before_;
    if (now.tuning == wanted) {
        return true; // at rest, or at once while no motor is driven
    }
    return now.time_s > before.time_s && now.tuning.map == wanted.map &&
           now.tuning.alpha_mode == wanted.alpha_mode &&
           is_near(now.tuning, tuning_after(before.tuning, wanted, now.time_s - before.time_s),
                   wanted);
}

control::Tuning JournalCheck::tuning_after(const control::Tuning &before,
                                           const control::Tuning &wanted, double period_s) const {
    servo::BumplessTransfer transfer(device_, period_s);
    transfer.approach({before, 0.0}, false);
    transfer.approach({wanted, 0.0}, true);
    return transfer.active().tuning;
}

} // namespace springdrive::session
