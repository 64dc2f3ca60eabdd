// What the "extras" of a glTF object say, key by key: what does not fit is one line of complaint.
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace springdrive::scene::gltf {

/// Read from the JSON text itself: tinygltf's own values lose `null` and whatever does not fit
/// into an int. Keys that nobody asks for are other programs' and left alone.
class Extras {
public:
    /// @param json the text of the extras; empty when there are none
    /// @param owner for messages: "node 'pad'"
    Extras(const std::string &json, std::string owner);

    [[nodiscard]] bool has(const char *key) const;

    /// The number under `key`, if it is there.
    /// @param meaning what it may be, for the message: "a number from 0 to 10"
    /// @throw InputError unless it is a number from `lowest` to `highest`.
    [[nodiscard]] std::optional<double> number(const char *key, double lowest, double highest,
                                               const std::string &meaning) const;

    /// @throw InputError unless the value is true or false.
    [[nodiscard]] std::optional<bool> flag(const char *key) const;

    /// Which of `words` stands under `key`, if it is there.
    /// @throw InputError with `meaning` unless it is one of them.
    [[nodiscard]] std::optional<std::size_t> word(const char *key,
                                                  std::span<const std::string_view> words,
                                                  const std::string &meaning) const;

    /// The extras within the extras, if they are there. Their keys are shown as `key.inner`.
    /// @throw InputError with `meaning` unless it is an object.
    [[nodiscard]] std::optional<Extras> object(const char *key, const std::string &meaning) const;

    /// @throw InputError for a key that is none of `keys`: where all keys are ours, another is a
    ///        slip of the pen.
    void refuse_all_but(std::span<const std::string_view> keys) const;

    /// @throw InputError always: "<owner>: extras.<key> is <value>; it must be <meaning>".
    [[noreturn]] void refuse(const char *key, const std::string &meaning) const;

private:
    nlohmann::json values_;
    std::string owner_;
    std::string path_ = "extras."; ///< before keys, in messages
};

} // namespace springdrive::scene::gltf
