#include "engine/scene/gltf_extras.h"

#include "base/input_error.h"
#include "engine/scene/gltf_text.h"

#include <algorithm>

namespace springdrive::scene::gltf {

namespace {

std::string shown(const nlohmann::json &value) {
    constexpr std::size_t kLongest = 40;
    return value.is_string() ? in_quotes(value.get<std::string>())
                             : one_line(value.dump(), kLongest);
}

} // namespace

Extras::Extras(const std::string &json, std::string owner)
    : values_(json.empty() ? nlohmann::json::object() : nlohmann::json::parse(json)),
      owner_(std::move(owner)) {}

bool Extras::has(const char *key) const { return values_.is_object() && values_.contains(key); }

std::optional<double> Extras::number(const char *key, double lowest, double highest,
                                     const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    if (!values_[key].is_number()) {
        refuse(key, meaning);
    }
    const auto number = values_[key].get<double>();
    if (!(number >= lowest && number <= highest)) {
        refuse(key, meaning);
    }
    return number;
}

std::optional<bool> Extras::flag(const char *key) const {
    if (!has(key)) {
        return std::nullopt;
    }
    if (!values_[key].is_boolean()) {
        refuse(key, "true or false");
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
        refuse(key, meaning);
    }
    return static_cast<std::size_t>(found - words.begin());
}

std::optional<Extras> Extras::object(const char *key, const std::string &meaning) const {
    if (!has(key)) {
        return std::nullopt;
    }
    if (!values_[key].is_object()) {
        refuse(key, meaning);
    }
    Extras inner("", owner_);
    inner.values_ = values_[key];
    inner.path_ = path_ + key + ".";
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

} // namespace springdrive::scene::gltf
