#include "engine/scene/gltf_extras.h"

#include "base/input_error.h"
#include "base/one_line.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace springdrive::scene::gltf {

namespace {

std::string shown(const nlohmann::json &value) {
    constexpr std::size_t kMax = 40;
    return value.is_string() ? in_quotes(value.get<std::string>()) : one_line(value.dump(), kMax);
}

} // namespace

Extras::Extras(const std::string &text, std::string owner, WarningList &warnings)
    : values_(text.empty() ? nlohmann::json::object() : nlohmann::json::parse(text)),
      owner_(std::move(owner)), warnings_(&warnings) {}

bool Extras::has(const char *key) const { return values_.is_object() && values_.contains(key); }

std::optional<double> Extras::number(const char *key, double minimum, double maximum,
                                     const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const auto number = values_[key].is_number() ? values_[key].get<double>() : minimum - 1.0;
    if (!(number >= minimum && number <= maximum)) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    return number;
}

std::optional<bool> Extras::flag(const char *key) const {
    if (!has(key)) {
        return std::nullopt;
    }
    if (!values_[key].is_boolean()) {
        leave_out(key, "true or false");
        return std::nullopt;
    }
    return values_[key].get<bool>();
}

std::optional<std::size_t> Extras::word(const char *key, std::span<const std::string_view> words,
                                        const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const auto found = values_[key].is_string()
                           ? std::ranges::find(words, values_[key].get_ref<const std::string &>())
                           : words.end();
    if (found == words.end()) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    return static_cast<std::size_t>(found - words.begin());
}

std::optional<std::string> Extras::text(const char *key, std::size_t max_length) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const std::string text = values_[key].is_string()
                                 ? one_line(values_[key].get_ref<const std::string &>())
                                 : std::string();
    if (text.empty() || text.size() > max_length) {
        leave_out(key, "a text of 1 to " + std::to_string(max_length) + " bytes");
        return std::nullopt;
    }
    return text;
}

std::optional<Vector3> Extras::vector(const char *key, double max_size) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const nlohmann::json &list = values_[key];
    const auto fits = [max_size](const nlohmann::json &number) {
        return number.is_number() && std::abs(number.get<double>()) <= max_size;
    };
    if (!list.is_array() || list.size() != 3 || !std::ranges::all_of(list, fits)) {
        leave_out(key, "a list of three numbers from " + shortest_text(-max_size) + " to " +
                           shortest_text(max_size));
        return std::nullopt;
    }
    return Vector3(list[0].get<double>(), list[1].get<double>(), list[2].get<double>());
}

std::optional<Extras> Extras::object(const char *key, std::span<const std::string_view> keys,
                                     const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    const nlohmann::json &value = values_[key];
    const bool is_ours = value.is_object() &&
                         (value.empty() || std::ranges::any_of(keys, [&](std::string_view name) {
                              return value.contains(name);
                          }));
    if (!is_ours) {
        leave_out(key, meaning);
        return std::nullopt;
    }
    Extras inner("", owner_, *warnings_);
    inner.values_ = value;
    inner.path_ = path_ + key + ".";
    inner.is_ours_ = true;
    return inner;
}

void Extras::refuse_all_but(std::span<const std::string_view> keys) const {
    for (const auto &[key, value] : values_.items()) {
        if (std::ranges::find(keys, key) == keys.end()) {
            std::string known;
            for (const std::string_view name : keys) {
                known += (known.empty() ? "" : ", ") + std::string(name);
            }
            throw InputError(owner_ + ": " + path_ + one_line(key, 40) +
                             " is not known; what may stand there is " + known);
        }
    }
}

void Extras::refuse(const char *key, const std::string &meaning) const {
    throw InputError(owner_ + ": " + path_ + key + " is " + shown(values_[key]) + "; it must be " +
                     meaning);
}

void Extras::leave_out(const char *key, const std::string &meaning) const {
    if (is_ours_) {
        refuse(key, meaning);
    }
    const std::string text = path_ + key + " is " + shown(values_[key]) +
                             ": left out as another program's; it would have to be " + meaning;
    if (owner_.find(' ') == std::string::npos) {
        warnings_->add(owner_ + ": " + text);
    } else {
        warnings_->add_of(owner_, nullptr, text);
    }
}

} // namespace springdrive::scene::gltf
