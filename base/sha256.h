// SHA-256: of values, to identify what was measured; of files, stored in records so that a replay
// can detect a different scene.
#pragma once

#include "base/vector.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace springdrive {

/// Hashes values in sequence, by their bytes in memory; a text is preceded by its length.
class Sha256 {
public:
    Sha256();
    ~Sha256();

    void add(const void *bytes, std::size_t count);
    void add(double value) { add(&value, sizeof value); }
    void add(std::uint64_t value) { add(&value, sizeof value); }
    void add(std::string_view text);
    void add(const Vector3 &vector) { add(vector.data(), 3 * sizeof(double)); }

    /// 64 digits, lower-case hex, as sha256sum prints it. @pre called once, after everything was
    /// added
    [[nodiscard]] std::string hex();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The hash of a file's contents.
/// @throw InputError for a file that cannot be read; Cancelled as `stop_if_given_up` does
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path &file);

} // namespace springdrive
