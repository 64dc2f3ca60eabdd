#include "device/usb/emulator/emulator_faults.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "base/similar_names.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <vector>

namespace springdrive::emulator {

namespace {

constexpr bool are_in_order() {
    for (std::size_t i = 0; i < kFaultKinds; ++i) {
        if (static_cast<std::size_t>(kFaultNames[i].kind) != i) {
            return false;
        }
    }
    return true;
}
static_assert(are_in_order());

template <class Number> std::optional<Number> number_in(std::string_view text) {
    Number number{};
    const char *end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc{} && stop == end ? std::optional<Number>(number) : std::nullopt;
}

std::vector<std::string_view> split(std::string_view text) {
    std::vector<std::string_view> parts;
    for (;;) {
        const std::size_t colon = text.find(':');
        parts.push_back(text.substr(0, colon));
        if (colon == std::string_view::npos) {
            return parts;
        }
        text.remove_prefix(colon + 1);
    }
}

/// Reads one text; its members throw what is wrong with it.
class FaultText {
public:
    explicit FaultText(std::string_view text) : text_(text) {
        const std::size_t at = text.find('@');
        parts_ = split(text.substr(0, at));
        find_name();
        if (at != std::string_view::npos) {
            read_times(text.substr(at + 1));
        }
        read_arguments();
        if (next_ != parts_.size()) {
            refuse(fmt::format("{} is too much", in_quotes(parts_[next_])));
        }
    }

    [[nodiscard]] const Fault &fault() const { return fault_; }

private:
    [[noreturn]] void refuse(const std::string &why) const {
        throw InputError(fmt::format("fault {}: {}; write {}{}[@BEGIN[-END]]", in_quotes(text_),
                                     why, name_.name, usage_of(name_.form)));
    }

    void find_name() {
        const auto *const found = std::ranges::find(kFaultNames, parts_.front(), &FaultName::name);
        if (found == kFaultNames.end()) {
            std::array<std::string_view, kFaultKinds> known_names;
            std::ranges::transform(kFaultNames, known_names.begin(), &FaultName::name);
            std::vector<std::string_view> names(known_names.begin(), known_names.end());
            sort_by_similarity(names, parts_.front(), [](std::string_view name) { return name; });
            throw InputError(fmt::format(
                "fault {}: there is no fault {}; the nearest name is '{}'; all are {}",
                in_quotes(text_), in_quotes(parts_.front()), names.front(), all_names()));
        }
        name_ = *found;
        fault_.kind = name_.kind;
    }

    static std::string all_names() {
        std::string names;
        for (const FaultName &known : kFaultNames) {
            names += (names.empty() ? "" : ", ") + std::string(known.name);
        }
        return names;
    }

    /// The next argument; without one, empty.
    std::string_view next() { return next_ < parts_.size() ? parts_[next_++] : std::string_view(); }
    [[nodiscard]] bool has_next() const { return next_ < parts_.size(); }

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
        switch (name_.form) {
        case FaultForm::nothing:
            break;
        case FaultForm::packets:
            read_direction();
            read_packets();
            break;
        case FaultForm::delay:
            read_direction();
            read_packets();
            if (has_next()) {
                fault_.periods = number(next(), 0.0, 1000.0, "number of periods");
            }
            break;
        case FaultForm::endpoint:
            read_direction();
            break;
        case FaultForm::channel:
            fault_.channel = channel();
            break;
        case FaultForm::two:
            fault_.channel = channel();
            fault_.other_channel = channel();
            if (fault_.channel == fault_.other_channel) {
                refuse("a channel cannot be crossed with itself");
            }
            break;
        case FaultForm::counts:
            fault_.channel = channel();
            fault_.share = number(next(), 0.0, 1.0, "share of the counts");
            break;
        case FaultForm::gain:
            fault_.channel = channel();
            fault_.gain = number(next(), 0.5, 2.0, "gain");
            break;
        case FaultForm::supply:
            fault_.supply_V = number(next(), 0.0, 100.0, "voltage");
            break;
        case FaultForm::temperature:
            fault_.temperature_C = number(next(), -50.0, 300.0, "temperature");
            break;
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
        if (!has_next()) {
            return;
        }
        const std::string_view packets = next();
        if (!packets.starts_with('#')) {
            fault_.share = number(packets, 0.0, 1.0, "share of the packets");
            return;
        }
        const auto packet = number_in<std::uint64_t>(packets.substr(1));
        if (!packet || *packet == 0) {
            refuse(fmt::format("{} is no number of a packet, from #1", in_quotes(packets)));
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

    [[nodiscard]] double number(std::string_view typed, double least, double largest,
                                std::string_view what) const {
        const auto value = number_in<double>(typed);
        if (!value || !(*value >= least && *value <= largest)) {
            refuse(
                fmt::format("{} is no {} from {} to {}", in_quotes(typed), what, least, largest));
        }
        return *value;
    }

    std::string_view text_;
    std::vector<std::string_view> parts_;
    std::size_t next_ = 1;
    FaultName name_;
    Fault fault_;
};

} // namespace

Fault parse_fault(std::string_view text) { return FaultText(text).fault(); }

std::string fault_usage() {
    std::string lines;
    for (const FaultName &fault : kFaultNames) {
        lines += fmt::format("{}{}\n", fault.name, usage_of(fault.form));
    }
    return lines;
}

} // namespace springdrive::emulator
