// The extras of a glTF object, read key by key.
#pragma once

#include "base/vector.h"
#include "engine/scene/warning_list.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

/// The extras of a glTF object, read key by key from the JSON text itself: tinygltf's own values
/// lose `null` and whatever does not fit into an int. Keys that are not read belong to other
/// programs.
class Extras {
public:
    /// @param text JSON of the extras; empty when there are none
    /// @param owner for messages: "node 'pad'"
    /// @param warnings gains the values that are left out as another program's
    Extras(const std::string &text, std::string owner, WarningList &warnings);

    [[nodiscard]] bool has(const char *key) const;

    /// The number under `key`, if there is one.
    /// @param meaning what it may be, for the message: "a number from 0 to 10"
    /// Left out unless it is a number from `minimum` to `maximum`.
    [[nodiscard]] std::optional<double> number(const char *key, double minimum, double maximum,
                                               const std::string &meaning) const;

    /// Left out unless the value is true or false.
    [[nodiscard]] std::optional<bool> flag(const char *key) const;

    /// Which of `words` the value of `key` is, if there is one. Left out unless it is one of them.
    [[nodiscard]] std::optional<std::size_t> word(const char *key,
                                                  std::span<const std::string_view> words,
                                                  const std::string &meaning) const;

    /// The text under `key`, if there is one, on one line. Left out unless it is a text of at most
    /// `max_length` bytes that shows something.
    [[nodiscard]] std::optional<std::string> text(const char *key, std::size_t max_length) const;

    /// The three numbers under `key`, if there are any. Left out unless it is a list of three, each
    /// at most `max_size` in size.
    [[nodiscard]] std::optional<Vector3> vector(const char *key, double max_size) const;

    /// The extras within the extras, if there are any. Messages name their keys as `key.inner`.
    /// Left out unless it is an object, empty or with any of `keys`; then it is our own, and values
    /// in it that cannot be are refused rather than left out.
    [[nodiscard]] std::optional<Extras> object(const char *key,
                                               std::span<const std::string_view> keys,
                                               const std::string &meaning) const;

    /// @throw InputError for a key that is none of `keys`: in an object of our own, it is a typing
    ///        error.
    void refuse_all_but(std::span<const std::string_view> keys) const;

    /// @throw InputError always: "<owner>: extras.<key> is <value>; it must be <meaning>".
    [[noreturn]] void refuse(const char *key, const std::string &meaning) const;

private:
    /// A warning, or in an object of our own a refusal.
    void leave_out(const char *key, const std::string &meaning) const;

    nlohmann::json values_;
    std::string owner_;
    WarningList *warnings_;
    bool is_ours_ = false;
    std::string path_ = "extras."; ///< before keys, in messages
};

} // namespace springdrive::scene::gltf
