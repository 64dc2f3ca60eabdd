#include "engine/study/store/columns.h"

#include "base/one_line.h"

namespace springdrive::study {

namespace {

/// The names of the kinds of `Response`, by their place in it.
constexpr std::array<std::string_view, std::variant_size_v<Response>> kResponseNames{
    "none", "chosen", "yes_no", "adjusted"};

/// The place of the name that comes next.
template <std::size_t count>
std::size_t place_of_name(Statement &row, const std::array<std::string_view, count> &names) {
    const std::string name = row.text();
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
        row.refuse("no such name: " + in_quotes(name));
    }
    return static_cast<std::size_t>(found - names.begin());
}

} // namespace

void store(Statement &row, const Response &value) {
    row.bind(kResponseNames[value.index()]);
    const auto *const adjusted = std::get_if<Adjusted>(&value);
    if (const auto *const chosen = std::get_if<Chosen>(&value)) {
        row.bind(chosen->alternative);
    } else if (const auto *const answer = std::get_if<YesNo>(&value)) {
        row.bind(answer->yes);
    } else {
        row.bind_null();
    }
    store(row, adjusted != nullptr ? std::optional(adjusted->level) : std::nullopt);
}

void load(Statement &row, UtcTime &value) {
    const std::string text = row.text();
    const auto time = utc_time_of(text);
    if (!time) {
        row.refuse("no time: " + in_quotes(text));
    }
    value = *time;
}

void load(Statement &row, DeviceKind &value) {
    value = static_cast<DeviceKind>(place_of_name(row, kDeviceKindNames));
}

void load(Statement &row, SessionEnding &value) {
    value = static_cast<SessionEnding>(place_of_name(row, kSessionEndingNames));
}

void load(Statement &row, std::variant<double, std::string> &value) {
    if (row.is_text()) {
        value = row.text();
    } else {
        value = row.real();
    }
}

void load(Statement &row, TrialPlace &value) {
    load(row, value.block);
    load(row, value.position);
    load(row, value.attempt);
}

void load(Statement &row, RecordLink &value) {
    value.path = row.text();
    value.sha256 = row.text();
}

void load(Statement &row, Response &value) {
    const std::size_t kind = place_of_name(row, kResponseNames);
    std::optional<std::int64_t> chosen;
    std::optional<double> adjusted;
    load(row, chosen);
    load(row, adjusted);
    switch (kind) {
    case 1:
        value = Chosen{static_cast<int>(chosen.value_or(0))};
        return;
    case 2:
        value = YesNo{chosen == 1};
        return;
    case 3:
        value = Adjusted{adjusted.value_or(0.0)};
        return;
    default:
        value = NoResponse{};
        return;
    }
}

} // namespace springdrive::study
