#include "device/simulated/hand.h"

#include "base/input_error.h"
#include "base/input_file.h"
#include "base/text.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::simulated {

namespace {

/// Days of ticks; all points are held in memory.
constexpr std::uintmax_t kMaxBytes = 2'000'000'000;

/// No hand is farther away: a larger value is in the wrong unit.
constexpr double kFarthest_m = 5.0;

/// No hand waits so long before it begins to move: a later first time is of another clock, such as
/// seconds since 1970.
constexpr double kLatestBegin_s = 3600.0;

/// No hand that moves is slower than this for so long: the times are milliseconds, or less. Slow
/// presses and long rests are no such paths, for the hand came there faster.
constexpr double kSlowest_m_per_s = 0.002;
constexpr double kSlowFor_s = 600.0;

std::string_view trimmed(std::string_view text) {
    const std::string_view blanks = " \t\r";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) {
        return {};
    }
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Reads four comma-separated finite numbers; false if the line is anything else.
bool parse_row(std::string_view line, std::array<double, 4> &row) {
    for (std::size_t column = 0; column < row.size(); ++column) {
        const std::size_t comma = line.find(',');
        if ((comma == std::string_view::npos) != (column + 1 == row.size())) {
            return false;
        }
        std::string_view cell = trimmed(line.substr(0, comma));
        if (cell.starts_with('+') && !cell.starts_with("+-")) {
            cell.remove_prefix(1);
        }
        const auto number = number_in<double>(cell);
        if (!number || !std::isfinite(*number)) {
            return false;
        }
        row[column] = *number;
        line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
    }
    return true;
}

/// Refuses a path in times of another unit or clock, which the hand would follow without being seen
/// to move.
void check_times(const std::vector<HandPath::Point> &points, const std::string &file) {
    const double first_s = points.front().time_s;
    if (std::abs(first_s) > kLatestBegin_s) {
        throw InputError(fmt::format("{}: its first time is {:g} s; times are seconds, from about "
                                     "0: subtract the first from all",
                                     file, first_s));
    }
    double fastest_m_per_s = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        fastest_m_per_s =
            std::max(fastest_m_per_s, (points[i].position_m - points[i - 1].position_m).norm() /
                                          (points[i].time_s - points[i - 1].time_s));
    }
    const double takes_s = points.back().time_s - first_s;
    if (fastest_m_per_s > 0.0 && fastest_m_per_s < kSlowest_m_per_s && takes_s > kSlowFor_s) {
        throw InputError(fmt::format("{}: takes {:g} s, at no more than {:.2g} mm/s; times are "
                                     "seconds: divide milliseconds by 1000",
                                     file, takes_s, 1e3 * fastest_m_per_s));
    }
}

constexpr double kStepRise_s = 0.005;

/// A value with its rate.
struct Moving {
    double value = 0.0;
    double rate_per_s = 0.0;
};

/// From 0 to 1 within `rise_s`, smoothly: half a cosine.
Moving rising(double time_s, double rise_s) {
    if (time_s <= 0.0) {
        return {0.0, 0.0};
    }
    if (time_s >= rise_s) {
        return {1.0, 0.0};
    }
    const double phase = std::numbers::pi * time_s / rise_s;
    return {0.5 * (1.0 - std::cos(phase)), 0.5 * std::numbers::pi / rise_s * std::sin(phase)};
}

/// Out with `rise_s`, and back with it from `back_s` on.
Moving out_and_back(double time_s, double rise_s, double back_s) {
    const Moving out = rising(time_s, rise_s);
    const Moving back = rising(time_s - back_s, rise_s);
    return {out.value - back.value, out.rate_per_s - back.rate_per_s};
}

Moving chirp(const HandStimulus &stimulus, double time_s) {
    // φ(t) = 2π f₀ (kᵗ − 1)/ln k, so that f(t) = f₀ kᵗ; k = 1 is a sine.
    const double growth = std::log(stimulus.to_Hz / stimulus.from_Hz) / stimulus.duration_s; // ln k
    const double omega_0 = 2.0 * std::numbers::pi * stimulus.from_Hz;
    const double phase =
        std::abs(growth) < 1e-9 ? omega_0 * time_s : omega_0 * std::expm1(growth * time_s) / growth;
    const double omega = omega_0 * std::exp(growth * time_s);
    const double fade_s = 0.1 * stimulus.duration_s;
    const Moving fade = out_and_back(time_s, fade_s, stimulus.duration_s - fade_s);
    return {fade.value * std::sin(phase),
            fade.value * omega * std::cos(phase) + fade.rate_per_s * std::sin(phase)};
}

} // namespace

HandPath::HandPath(std::vector<Point> points) : points_(std::move(points)) {
    if (points_.empty()) {
        throw InputError("the hand's path has no points; it needs at least one");
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
        if (!std::isfinite(points_[i].time_s) || !points_[i].position_m.allFinite()) {
            throw InputError("the hand's path is not finite at point " + std::to_string(i + 1));
        }
        if (i > 0 && points_[i].time_s <= points_[i - 1].time_s) {
            throw InputError("the hand's path does not move forward in time at point " +
                             std::to_string(i + 1));
        }
    }
}

HandPath HandPath::read_csv(const std::filesystem::path &file, Header header) {
    check_input_file(file, "a CSV file", kMaxBytes);
    std::ifstream stream(file);
    if (!stream) {
        throw InputError(file.string() + ": cannot be opened; check the name and its permissions");
    }
    std::vector<Point> points;
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        const std::string where = file.string() + ":" + std::to_string(number) + ": ";
        if (number == 1) {
            constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
            line.erase(0, line.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
            if (trimmed(line) == "t,x,y,z") {
                continue;
            }
            if (header == Header::required) {
                throw InputError(where + "the first line must be t,x,y,z (seconds and metres)");
            }
        }
        if (trimmed(line).empty()) {
            continue;
        }
        std::array<double, 4> row{};
        if (!parse_row(line, row)) {
            throw InputError(where + "must hold four finite numbers t,x,y,z");
        }
        if (std::max({std::abs(row[1]), std::abs(row[2]), std::abs(row[3])}) > kFarthest_m) {
            throw InputError(where + "is more than " + std::to_string(kFarthest_m).substr(0, 1) +
                             " m away; coordinates are metres");
        }
        if (!points.empty() && row[0] <= points.back().time_s) {
            throw InputError(where + "its time is not after that of the previous line");
        }
        points.push_back({row[0], Vector3(row[1], row[2], row[3])});
    }
    if (stream.bad()) {
        throw InputError(file.string() + ": cannot be read to its end");
    }
    if (points.empty()) {
        throw InputError(file.string() + ": contains no points; add lines of t,x,y,z");
    }
    check_times(points, file.string());
    return HandPath(std::move(points));
}

HandTarget HandPath::at(double time_s) noexcept {
    while (next_ < points_.size() && points_[next_].time_s <= time_s) {
        ++next_;
    }
    if (next_ == 0 || next_ == points_.size()) {
        return {next_ == 0 ? points_.front().position_m : points_.back().position_m,
                Vector3::Zero()};
    }
    const Point &before = points_[next_ - 1];
    const Point &after = points_[next_];
    const Vector3 velocity =
        (after.position_m - before.position_m) / (after.time_s - before.time_s);
    return {before.position_m + (time_s - before.time_s) * velocity, velocity};
}

HandTarget offset_of(const HandStimulus &stimulus, double time_s) noexcept {
    if (time_s < 0.0 || time_s > stimulus.duration_s) {
        return {};
    }
    Moving moving;
    switch (stimulus.kind) {
    case StimulusKind::none:
        break;
    case StimulusKind::step:
        moving = out_and_back(time_s, std::min(kStepRise_s, 0.5 * stimulus.duration_s),
                              0.5 * stimulus.duration_s);
        break;
    case StimulusKind::hold:
        moving = out_and_back(time_s, 0.2 * stimulus.duration_s, 0.8 * stimulus.duration_s);
        break;
    case StimulusKind::chirp:
        moving = chirp(stimulus, time_s);
        break;
    }
    return {stimulus.amplitude_m * moving.value * stimulus.direction,
            stimulus.amplitude_m * moving.rate_per_s * stimulus.direction};
}

} // namespace springdrive::simulated
