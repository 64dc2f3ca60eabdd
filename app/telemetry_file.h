// A CSV file with one line a servo tick.
#pragma once

#include "engine/servo/servo_sample.h"

#include <cstdint>
#include <filesystem>
#include <fstream>

namespace springdrive {

class TelemetryFile {
public:
    /// @throw InputError where the file cannot be created.
    explicit TelemetryFile(const std::filesystem::path &path);

    /// @throw InputError where the disk takes no more.
    void write(const ServoSample &sample);

    /// Writes out what is still in memory. @throw InputError as above.
    void close();

    [[nodiscard]] std::uint64_t rows() const { return rows_; }

private:
    std::filesystem::path path_;
    std::ofstream stream_;
    std::uint64_t rows_ = 0;
};

} // namespace springdrive
