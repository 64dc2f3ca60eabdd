#include "engine/study/store/utc_time.h"

#include "base/assertions.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

namespace springdrive::study {

namespace {

constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:dd.dddZ"; ///< d: a digit

bool has_the_form(std::string_view text) {
    const auto fits = [](char c, char form) {
        return form == 'd' ? c >= '0' && c <= '9' : c == form;
    };
    return text.size() == kForm.size() && std::ranges::equal(text, kForm, fits);
}

template <typename Number> Number digits(std::string_view text, std::size_t at, std::size_t count) {
    Number number{};
    std::from_chars(text.data() + at, text.data() + at + count, number);
    return number;
}

} // namespace

UtcTime utc_now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

std::string utc_text(UtcTime time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    const int year = static_cast<int>(date.year());
    SPRINGDRIVE_ASSERT(year >= 0 && year <= 9999);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", year,
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                       clock.subseconds().count());
}

std::optional<UtcTime> utc_time_of(std::string_view text) {
    using namespace std::chrono;
    if (!has_the_form(text)) {
        return std::nullopt;
    }
    const year_month_day date{year(digits<int>(text, 0, 4)), month(digits<unsigned>(text, 5, 2)),
                              day(digits<unsigned>(text, 8, 2))};
    const hours h(digits<int>(text, 11, 2));
    const minutes min(digits<int>(text, 14, 2));
    const seconds s(digits<int>(text, 17, 2));
    if (!date.ok() || h > hours(23) || min > minutes(59) || s > seconds(59)) {
        return std::nullopt;
    }
    return sys_days(date) + h + min + s + milliseconds(digits<int>(text, 20, 3));
}

} // namespace springdrive::study
