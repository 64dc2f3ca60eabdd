#include "device/core/faults.h"

#include "base/input_error.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <utility>

namespace springdrive::device {

namespace {

/// Reads one text; its members throw what is wrong with it.
class FaultText {
public:
    explicit FaultText(std::string_view text) : text_(text), rest_(text.substr(0, text.find('@'))) {
        find_name();
        if (const std::size_t at = text.find('@'); at != std::string_view::npos) {
            read_times(text.substr(at + 1));
        }
        read_arguments();
        if (rest_) {
            refuse(fmt::format("{} is too much", in_quotes(next())));
        }
    }

    [[nodiscard]] const Fault &fault() const { return fault_; }

private:
    [[noreturn]] void refuse(const std::string &why) const {
        throw InputError(fmt::format("fault {}: {}; write {}{}[@BEGIN[-END]]", in_quotes(text_),
                                     why, name_.name, name_.usage));
    }

    /// The next part; without one, empty.
    std::string_view next() {
        const std::string_view rest = rest_.value_or("");
        const std::size_t colon = rest.find(':');
        rest_ =
            colon == std::string_view::npos ? std::nullopt : std::optional(rest.substr(colon + 1));
        return rest.substr(0, colon);
    }

    void find_name() {
        const std::string_view typed = next();
        const auto *const found = std::ranges::find(kFaultNames, typed, &FaultName::name);
        if (found == kFaultNames.end()) {
            std::vector<std::string_view> names;
            std::ranges::transform(kFaultNames, std::back_inserter(names), &FaultName::name);
            const std::string all = fmt::format("{}", fmt::join(names, ", "));
            sort_by_similarity(names, typed, std::identity());
            throw InputError(
                fmt::format("fault {}: there is no fault {}; the nearest name is '{}'; all are {}",
                            in_quotes(text_), in_quotes(typed), names.front(), all));
        }
        name_ = *found;
        fault_.kind = found->kind;
    }

    void read_times(std::string_view times) {
        const std::size_t dash = times.find('-');
        const auto begin_s = number_in<double>(times.substr(0, dash));
        const auto end_s = dash == std::string_view::npos
                               ? std::optional<double>(fault_.end_s)
                               : number_in<double>(times.substr(dash + 1));
        if (!begin_s || !end_s || !(*begin_s >= 0.0 && *end_s > *begin_s) ||
            !std::isfinite(*begin_s)) {
            refuse(fmt::format("{} are no times in seconds, the first before the second",
                               in_quotes(times)));
        }
        fault_.begin_s = *begin_s;
        fault_.end_s = *end_s;
    }

    void read_arguments() {
        const std::string_view usage = name_.usage;
        if (usage.starts_with(":in|out")) {
            read_direction();
        }
        if (usage.find("#NUMBER") != std::string_view::npos && rest_) {
            read_packets();
        }
        if (usage.find("PERIODS") != std::string_view::npos && rest_) {
            fault_.periods = number(0.0, 1000.0, "number of periods");
        }
        if (usage.starts_with(":1|2|3")) {
            fault_.channel = channel();
        }
        if (usage == ":1|2|3:1|2|3") {
            fault_.other_channel = channel();
            if (fault_.channel == fault_.other_channel) {
                refuse("a channel cannot be crossed with itself");
            }
        }
        if (usage.ends_with(":SHARE")) {
            fault_.share = number(0.0, 1.0, "share of the counts");
        } else if (usage.ends_with(":GAIN")) {
            fault_.size.setConstant(number(0.5, 2.0, "gain"));
        } else if (usage.ends_with(":VOLTS")) {
            fault_.size.setConstant(number(0.0, 100.0, "voltage"));
        } else if (usage.ends_with(":CELSIUS")) {
            fault_.size.setConstant(number(-50.0, 300.0, "temperature"));
        }
    }

    void read_direction() {
        const std::string_view direction = next();
        if (direction != "in" && direction != "out") {
            refuse(fmt::format("{} is no direction", in_quotes(direction)));
        }
        fault_.direction = direction == "in" ? Direction::in : Direction::out;
    }

    void read_packets() {
        if (!rest_->starts_with('#')) {
            fault_.share = number(0.0, 1.0, "share of the packets");
            return;
        }
        const std::string_view typed = next();
        const auto packet = number_in<std::uint64_t>(typed.substr(1));
        if (!packet || *packet == 0) {
            refuse(fmt::format("{} is no number of a packet, from #1", in_quotes(typed)));
        }
        fault_.packet = *packet;
    }

    std::size_t channel() {
        const std::string_view typed = next();
        const auto number = number_in<std::size_t>(typed);
        if (!number || *number < 1 || *number > 3) {
            refuse(fmt::format("{} is no channel", in_quotes(typed)));
        }
        return *number - 1;
    }

    double number(double minimum, double maximum, std::string_view what) {
        const std::string_view typed = next();
        const auto value = number_in<double>(typed);
        if (!value || !(*value >= minimum && *value <= maximum)) {
            refuse(
                fmt::format("{} is no {} from {} to {}", in_quotes(typed), what, minimum, maximum));
        }
        return *value;
    }

    std::string_view text_;
    std::optional<std::string_view> rest_; ///< after the last colon that was read
    FaultName name_;
    Fault fault_;
};

} // namespace

Fault parse_fault(std::string_view text) { return FaultText(text).fault(); }

std::string fault_usage() {
    std::string lines;
    for (const FaultName &fault : kFaultNames) {
        lines += fmt::format("{}{}\n", fault.name, fault.usage);
    }
    return lines;
}

std::uint64_t FaultInjector::tick_at(double time_s) const {
    constexpr double kLast = 9e18;
    return static_cast<std::uint64_t>(
        std::clamp(std::ceil(time_s * ticks_per_s_ - 1e-6), 0.0, kLast));
}

void FaultInjector::add(const Fault &fault) {
    faults_.push_back({fault, tick_at(fault.begin_s), tick_at(fault.end_s)});
    active_.reserve(faults_.size());
    next_change_ = 0;
}

void FaultInjector::clear() {
    faults_.clear();
    next_change_ = 0;
}

bool FaultInjector::update(std::uint64_t tick) noexcept {
    if (tick < next_change_) {
        return false;
    }
    active_.clear();
    next_change_ = std::numeric_limits<std::uint64_t>::max();
    for (Scheduled &one : faults_) {
        const bool acts = tick >= one.begin && tick < one.end;
        one.begins = acts && !one.acts;
        one.acts = acts;
        if (acts) {
            active_.push_back(one.fault);
        }
        for (const std::uint64_t change : {one.begin, one.end}) {
            if (change > tick) {
                next_change_ = std::min(next_change_, change);
            }
        }
    }
    return true;
}

const Fault *FaultInjector::find(FaultKind kind,
                                 std::optional<std::size_t> channel) const noexcept {
    const auto found = std::find_if(active_.rbegin(), active_.rend(), [&](const Fault &fault) {
        return fault.kind == kind && fault.channel == channel.value_or(fault.channel);
    });
    return found == active_.rend() ? nullptr : &*found;
}

bool FaultInjector::has_begun(FaultKind kind) const noexcept {
    return std::ranges::any_of(
        faults_, [kind](const Scheduled &one) { return one.begins && one.fault.kind == kind; });
}

std::array<std::size_t, 3> FaultInjector::crossed(FaultKind kind) const noexcept {
    std::array<std::size_t, 3> channels{0, 1, 2};
    for (const Fault &fault : active_) {
        if (fault.kind == kind) {
            std::swap(channels[fault.channel], channels[fault.other_channel]);
        }
    }
    return channels;
}

} // namespace springdrive::device
